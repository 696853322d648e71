"""A table of a mesh for notebooks."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from azimesh import Mesh


def table(mesh: Mesh) -> str:
    """Nodes, cells, tags, zones, arrays and bounds of a mesh as HTML."""
    rows = [("points", f"{mesh.n_points:,}"), ("dimension", str(mesh.dimension))]
    rows += [(name, f"{len(places):,} cells") for name, places in mesh.cell_index.items()]
    rows += [(f"tag {name}", f"{len(faces):,} faces") for name, faces in mesh.tags.items()]
    rows += [(f"zone {name}", f"{len(cells):,} cells") for name, cells in mesh.zones.items()]
    rows += [(f"array {name}", "at points") for name in mesh.point_data]
    rows += [(f"array {name}", "at cells") for name in mesh.cell_data]
    if mesh.bounds is not None:
        low, high = mesh.bounds
        rows += [(axis, f"{a:.6g} to {b:.6g}") for axis, a, b in zip("xyz", low, high)]
    cells = "".join(f"<tr><th style=\"text-align:left\">{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in rows)
    return f"<table>{cells}</table>"
