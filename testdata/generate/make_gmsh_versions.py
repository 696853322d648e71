"""testdata/gmsh/: one small model by gmsh in every version of MSH but 3, partitioned, with data, and cells of high order."""

import gmsh

import place

FOLDER = place.FOLDER / "gmsh"

CELLS = {
    4: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    5: [(0, 0, 2), (1, 0, 2), (1.2, 1, 2), (0, 1, 2), (0, 0, 3), (1, 0, 3), (1, 1, 3.1), (0, 1, 3)],
    6: [(0, 0, 4), (1, 0, 4), (0, 1, 4), (0, 0, 5), (1.1, 0, 5), (0, 1, 5)], 7: [(0, 0, 6), (1, 0, 6), (1, 1, 6), (0, 1, 6), (0.5, 0.4, 7)],
    2: [(3, 0, 0), (4, 0, 0), (3, 1, 0)], 3: [(3, 0, 2), (4, 0, 2), (4.2, 1, 2), (3, 1, 2)], 1: [(5, 0, 0), (6, 0, 0)],
}  # fmt: skip


def write(name, version, binary=False, parametric=False):
    """Writes the current model."""
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", int(binary))
    gmsh.option.setNumber("Mesh.SaveParametric", int(parametric))
    gmsh.write(str(FOLDER / f"{name}.msh"))


def cylinder():
    """A cylinder whose side is in two groups, one with spaces, whose ends have a number only, and whose volume has the number of its side."""
    gmsh.clear()
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 0.5)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.6)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
    gmsh.model.addPhysicalGroup(3, [1], 7, "air in it")
    gmsh.model.addPhysicalGroup(2, [1], 7, "outer wall")
    gmsh.model.addPhysicalGroup(2, [2, 3], 8)
    gmsh.model.addPhysicalGroup(2, [1, 2], 9, "both")
    gmsh.model.mesh.generate(3)


def high_order(order):
    """One straight cell of each shape, apart from one another."""
    gmsh.clear()
    gmsh.model.add("high order")
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    n = 0
    for kind, points in CELLS.items():
        dimension = {1: 1, 2: 2, 3: 2}.get(kind, 3)
        entity = gmsh.model.addDiscreteEntity(dimension)
        tags = list(range(n + 1, n + 1 + len(points)))
        n += len(points)
        gmsh.model.mesh.addNodes(dimension, entity, tags, [x for point in points for x in point])
        gmsh.model.mesh.addElementsByType(entity, kind, [kind], tags)
    gmsh.model.mesh.setOrder(order)


def data():
    """Values at nodes at two times and at elements, appended to a mesh."""
    path = FOLDER / "data_v41.msh"
    write("data_v41", 4.1)
    nodes, xyz, _ = gmsh.model.mesh.getNodes()
    elements = gmsh.model.mesh.getElements(3)[1][0]
    model = gmsh.model.getCurrent()
    height = gmsh.view.add("height")
    for step in (0, 1):
        gmsh.view.addModelData(height, step, model, "NodeData", nodes, [[(step + 1) * z] for z in xyz[2::3]], time=0.5 * step)
    velocity = gmsh.view.add("velocity")
    gmsh.view.addModelData(velocity, 0, model, "ElementData", elements, [[e, 0.25, -1.0] for e in elements])
    gmsh.option.setNumber("PostProcessing.SaveMesh", 0)
    for view in (height, velocity):
        gmsh.view.write(view, str(path), append=True)


def main():
    FOLDER.mkdir(exist_ok=True)
    place.start_gmsh()
    for order in (3, 4):
        high_order(order)
        write(f"order{order}_v41", 4.1)
        write(f"order{order}_v22_binary", 2.2, binary=True)
    cylinder()
    for version in (1, 2, 4.0, 4.1):
        name = f"cylinder_v{str(version).replace('.', '')}"
        write(name, version)
        write(f"{name}_parametric", version, parametric=True)
        if version not in (1, 4.0):
            write(f"{name}_binary", version, binary=True, parametric=True)
    data()
    gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", 1)
    gmsh.model.mesh.partition(3)
    write("partitioned_v2", 2.2)
    write("partitioned_v40", 4.0)
    write("partitioned_v41_binary", 4.1, binary=True)
    gmsh.finalize()
