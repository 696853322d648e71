"""Small meshes as Fluent stores them, for testdata/fluent: text, binary sections, gzip, HDF5.

`house`: a cube and a pyramid on it, two zones of cells. `refined`: a plane mesh with a hanging node. `polyhedra`: the house as one polyhedron.
Written by the description in the appendix of Fluent's user guide; HDF5 as Fluent's own .cas.h5 files are.
"""

import gzip
import struct

import h5py
import numpy as np

from place import FOLDER

HOUSE = {
    "dimension": 3,
    "points": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1), (0.5, 0.5, 1.5)],
    # Number, type and faces of each zone: nodes by the right-hand rule towards the first of the two cells.
    "faces": [
        (10, 2, [((5, 6, 7, 8), (2, 1))]),
        (3, 10, [((5, 6, 2, 1), (1, 0)), ((6, 7, 3, 2), (1, 0)), ((7, 8, 4, 3), (1, 0)), ((8, 5, 1, 4), (1, 0))]),
        (4, 3, [((1, 2, 3, 4), (1, 0))]),
        (17, 7, [((6, 5, 9), (2, 0)), ((7, 6, 9), (2, 0)), ((8, 7, 9), (2, 0)), ((5, 8, 9), (2, 0))]),
    ],
    # Number, first and last cell, type.
    "cells": [(1, 1, 1, 1), (2, 2, 2, 17)],
    "names": [(1, "fluid", "room"), (2, "solid", "roof"), (3, "velocity-inlet", "sides"), (4, "wall", "floor"),
              (17, "symmetry", "tiles"), (10, "interior", "default-interior")],
    "more": "",
}
POLYHEDRA = HOUSE | {
    "faces": [(zone, kind, [(nodes, (1, 0)) for nodes, _ in faces]) for zone, kind, faces in HOUSE["faces"][1:]], "cells": [(1, 1, 1, 1)],
}  # fmt: skip
REFINED = {
    "dimension": 2,
    "points": [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1), (1, 0.5), (2, 0.5)],
    "faces": [
        (5, 31, [((2, 3), (1, 2)), ((5, 6), (2, 0))]),
        (6, 2, [((2, 7), (1, 3)), ((7, 3), (1, 4)), ((7, 8), (4, 3))]),
        (7, 3, [((1, 2), (1, 0)), ((3, 4), (1, 0)), ((4, 1), (1, 0)), ((2, 5), (3, 0)), ((5, 8), (3, 0)), ((8, 6), (4, 0)),
                ((6, 3), (4, 0))]),
    ],
    "cells": [(1, 1, 1, 1), (2, 2, 2, 32), (1, 3, 4, 1)],
    "names": [(1, "fluid", "air"), (7, "wall", "box")],
    "more": "(58 (2 2 1 1)(\n2 3 4))\n(59 (1 2 5 6)(\n2 3 4\n2 a b))\n",
}


def main():
    folder = FOLDER / "fluent"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "house.msh").write_text(text(HOUSE))
    (folder / "house.cas").write_bytes(binary(HOUSE))
    hdf5(HOUSE, folder / "house.cas.h5")
    (folder / "refined.msh").write_text(text(REFINED))
    (folder / "polyhedra.cas.gz").write_bytes(gzip.compress(binary(POLYHEDRA), mtime=0))
    hdf5(POLYHEDRA, folder / "polyhedra.msh.h5")


def size_of(faces):
    sizes = {len(nodes) for nodes, _ in faces}
    return sizes.pop() if len(sizes) == 1 else 0


def zones_of_faces(mesh):
    """First and last face of each zone with it."""
    first = 1
    for zone, kind, faces in mesh["faces"]:
        yield first, first + len(faces) - 1, zone, kind, faces
        first += len(faces)


def names(mesh):
    return "".join(f"(39 ({zone} {kind} {name} 1)())\n" for zone, kind, name in mesh["names"])


def text(mesh):
    lines = ['(0 "a small mesh")', f'(2 {mesh["dimension"]})', f'(10 (0 1 {len(mesh["points"]):x} 0))']
    lines.append(f'(10 (1 1 {len(mesh["points"]):x} 1 {mesh["dimension"]})(')
    lines += [" ".join(f"{x:.10e}" for x in point) for point in mesh["points"]] + ["))"]
    lines.append(f'(12 (0 1 {max(cells[2] for cells in mesh["cells"]):x} 0))')
    lines += [f"(12 ({zone:x} {first:x} {last:x} {32 if kind == 32 else 1:x} 0)(4))" for zone, first, last, kind in mesh["cells"]]
    lines.append(f'(13 (0 1 {sum(len(zone[2]) for zone in mesh["faces"]):x} 0))')
    for first, last, zone, kind, faces in zones_of_faces(mesh):
        size = size_of(faces)
        lines.append(f"(13 ({zone:x} {first:x} {last:x} {kind:x} {size})(")
        for nodes, cells in faces:
            lines.append(" ".join(f"{n:x}" for n in ([] if size else [len(nodes)]) + [*nodes, *cells]))
        lines.append("))")
    return "\n".join(lines) + "\n" + names(mesh) + mesh["more"]


def binary(mesh):
    data = f'(0 "a small mesh")\n(4 (60 0 0 1 2 4 4 4 8 8 8 4))\n(2 {mesh["dimension"]})\n'.encode()

    def section(index, header, body):
        closed = b"\n(" + body + b")" if body else b""
        return f"({index} ({header})".encode() + closed + f"\nEnd of Binary Section   {index})\n".encode()

    for zone, first, last, _ in mesh["cells"]:
        data += section(3012, f"{zone:x} {first:x} {last:x} 1 7", b"")
    for first, last, zone, kind, faces in zones_of_faces(mesh):
        size = size_of(faces)
        numbers = [n for nodes, cells in faces for n in ([] if size else [len(nodes)]) + [*nodes, *cells]]
        data += section(3013, f"{zone:x} {first:x} {last:x} {kind:x} {size}", struct.pack(f"<{len(numbers)}i", *numbers))
    points = np.array(mesh["points"], dtype="<f8")
    data += section(3010, f'1 1 {len(points):x} 1 {mesh["dimension"]}', points.tobytes())
    return data + names(mesh).encode() + mesh["more"].encode()


def hdf5(mesh, path):
    with h5py.File(path, "w", libver="earliest", track_order=False) as file:
        group = file.create_group("meshes/1")
        points = np.array(mesh["points"], dtype=float)
        faces = [face for _, _, faces in mesh["faces"] for face in faces]
        group.attrs["dimension"] = np.array([mesh["dimension"]], dtype=np.int32)
        for key, n in ("nodeCount", len(points)), ("faceCount", len(faces)), ("cellCount", mesh["cells"][-1][2]):
            group.attrs[key] = np.array([n], dtype=np.uint64)
        with_ids(group.create_dataset("nodes/coords/1", data=points), 1, len(points))
        topology(group.create_group("cells/zoneTopology"), [(zone, first, last, kind) for zone, first, last, kind in mesh["cells"]], mesh)
        zones = [(zone, first, last, kind) for first, last, zone, kind, _ in zones_of_faces(mesh)]
        topology(group.create_group("faces/zoneTopology"), zones, mesh)
        nodes = with_ids(group.create_group("faces/nodes/1"), 1, len(faces))
        nodes["nnodes"] = np.array([len(face) for face, _ in faces], dtype=np.int16)
        nodes["nodes"] = np.array([node for face, _ in faces for node in face], dtype=np.uint32)
        group["faces/nodes"].attrs["nSections"] = np.array([1], dtype=np.uint64)
        for side, name in enumerate(("c0", "c1")):
            cells = np.array([cells[side] for _, cells in faces], dtype=np.uint32)
            with_ids(group.create_dataset(f"faces/{name}/1", data=cells, compression="gzip"), 1, len(faces))
        file["settings/Thread Variables"] = np.array([names(mesh).encode()])


def with_ids(item, first, last):
    item.attrs["minId"], item.attrs["maxId"] = (np.array([n], dtype=np.uint64) for n in (first, last))
    return item


def topology(group, zones, mesh):
    known = {zone: name for zone, _, name in mesh["names"]}
    for i, (name, kind) in enumerate((("id", np.int32), ("minId", np.uint64), ("maxId", np.uint64), ("zoneType", np.int32))):
        group[name] = np.array([zone[i] for zone in zones], dtype=kind)
    group["name"] = np.array([";".join(known.get(zone[0], "") for zone in zones).encode()])
