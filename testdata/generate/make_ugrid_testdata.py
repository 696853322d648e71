"""Makes the UGRID files of testdata/, from mixed_cells by gmsh, in plain numpy.

Run from the repository root: `.venv/bin/python testdata/generate/make_ugrid_testdata.py`.
"""

from pathlib import Path

import gmsh
import numpy as np

from gmsh_models import mixed_cells
from make_testdata import current_grid
from ugrid_file import Ugrid, write

FOLDER = Path("testdata")
FLAVOURS = ["", ".b8", ".lb4", ".lr8", ".lb8l"]
CONDITIONS = [4000, 5000, 6662, 6100, 3000, 7011, 5050]


def grid():
    """The model as UGRID: faces without a tag are left out."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    mixed_cells(2)
    points, cells, tags, _ = current_grid()
    gmsh.finalize()
    mesh = Ugrid(points)
    numbers = []
    for vtk in (5, 9, 10, 14, 13, 12):
        chosen = [(nodes, tag) for kind, nodes, tag, _ in cells if kind == vtk and (tag or vtk not in (5, 9))]
        if chosen:
            mesh.cells.append((vtk, np.array([nodes for nodes, _ in chosen])))
        numbers += [tag for _, tag in chosen if vtk in (5, 9)]
    mesh.numbers = np.array(numbers)
    mesh.names = {i + 1: (CONDITIONS[i % len(CONDITIONS)], name) for i, name in enumerate(tags)}
    return mesh


def main():
    """One mesh in several flavours, which share the names beside it."""
    mesh = grid()
    write(FOLDER / "mixed_cells.ugrid", mesh)
    mesh.names = {}
    for name in FLAVOURS[1:]:
        write(FOLDER / f"mixed_cells{name}.ugrid", mesh)
    for path in sorted(FOLDER.glob("mixed_cells*.ugrid")):
        size = path.stat().st_size
        assert size <= 100_000, f"{path} has {size} bytes; at most 100 kB"
        print(path, size)


if __name__ == "__main__":
    main()
