"""Surfaces in space and clouds of points against dense numpy, by both selections.

The surface (SU2 without volume cells, whose markers are tags) and the cloud (vertex cells) have all nodes of a solid
mesh in its order, so that numpy works on that.
"""

from dataclasses import replace

import numpy as np
import pyvista

import all_points
import meshes
import sequence
from cases import CASES
from program import report, scratch


def write_surface(mesh, path):
    """All nodes, no cells, and the boundary faces as markers."""
    lines = ["NDIME= 3", "NELEM= 0", f"NPOIN= {len(mesh.points)}"]
    lines += [" ".join(map(repr, point)) for point in mesh.points.tolist()]
    lines.append(f"NMARK= {len(mesh.tags)}")
    for name, faces in mesh.tags.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(faces)}"]
        lines += [f"5 {' '.join(map(str, face))}" for face in sorted(faces)]
    path.write_text("\n".join(lines) + "\n")


def write_cloud(mesh, path):
    """Vertex cells: one for each node, and one for each node of each tag."""
    nodes, tags = [np.arange(len(mesh.points))], [np.zeros(len(mesh.points), int)]
    for number, faces in enumerate(mesh.tags.values(), 1):
        nodes.append(np.unique(np.array(sorted(faces))))
        tags.append(np.full(len(nodes[-1]), number))
    nodes = np.concatenate(nodes)
    cells = np.column_stack([np.ones_like(nodes), nodes]).ravel()
    grid = pyvista.UnstructuredGrid(cells, np.full(len(nodes), pyvista.CellType.VERTEX), mesh.points)
    grid.cell_data["BoundaryTag"] = np.concatenate(tags).astype(np.int32)
    grid.field_data["BoundaryTagNames"] = np.array(list(mesh.tags))
    grid.save(path)


def main():
    """Two lines a mesh."""
    solid = next(case for case in CASES if case.name == "sphere")
    mesh = meshes.by_pyvista(solid.mesh)
    solid = replace(solid, schedule=solid.schedule + '\n[output]\nformat = "vtu"\n', solid=solid.mesh)
    for name, write in [("surface.su2", write_surface), ("cloud.vtu", write_cloud)]:
        with scratch() as folder:
            write(mesh, folder / name)
            case = replace(solid, name=name.split(".")[0], mesh=folder / name)
            n_nodes, largest, condition = all_points.deviation(case, folder)
            report(f"{case.name}, all points", n_nodes, largest, "nodes", f"cond(Phi) {condition:.2e}")
            assert largest <= max(1e-10, 100 * np.finfo(float).eps * condition), f"{name}: {largest}"
        with scratch() as folder:
            write(mesh, folder / name)
            case = replace(solid, name=name.split(".")[0], mesh=folder / name)
            n, largest, n_base = sequence.check(case, folder)
            report(f"{case.name}, sequence", n, largest, "error figures", f"of the tolerance; {n_base} base points")
            assert largest <= 0.01, f"{name}: selection_error is off by {largest} of the tolerance"


if __name__ == "__main__":
    main()
