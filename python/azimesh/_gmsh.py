"""Meshes from gmsh's current model."""

from __future__ import annotations

import os
import tempfile

import azimesh


def from_gmsh(name: str | None = None) -> azimesh.Mesh:
    """The mesh of a model of gmsh in this process: the current one, or that of this name.

    Physical groups become tags and zones, as when a .msh file is read. gmsh must be initialised, and its model meshed.
    """
    import gmsh

    current = gmsh.model.getCurrent()
    if name is not None:
        gmsh.model.setCurrent(name)
    binary = gmsh.option.getNumber("Mesh.Binary")
    try:
        gmsh.option.setNumber("Mesh.Binary", 1)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "model.msh")
            gmsh.write(path)
            return azimesh.read(path)
    finally:
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.model.setCurrent(current)
