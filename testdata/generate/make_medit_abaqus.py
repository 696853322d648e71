"""box_by_gmsh.mesh and box_by_gmsh.inp: a box of tetrahedra, as Gmsh writes it."""

import os

import gmsh

from place import FOLDER, start_gmsh


def main():
    # Gmsh writes the path that it is given into the file.
    os.chdir(FOLDER)
    start_gmsh()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    gmsh.write("box_by_gmsh.mesh")
    faces = [tag for _, tag in gmsh.model.getEntities(2)]
    gmsh.model.addPhysicalGroup(3, [1], 5, "solid")
    gmsh.model.addPhysicalGroup(2, faces[:2], 6, "wall")
    gmsh.model.addPhysicalGroup(2, faces[2:], 7, "far field")
    gmsh.write("box_by_gmsh.inp")
    gmsh.finalize()
