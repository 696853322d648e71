"""ADF files written by the CGNS library (libcgns 3.4), in every byte order and width, with fragmented data and with links.

    from adf_library import copy
    copy("mesh.cgns", "copy.cgns", form="IEEE_BIG_64", fragments=5)

Sources are CGNS files in HDF5, read by h5py. `python testdata/generate/adf_library.py` writes those of testdata/cgns.
"""

import ctypes
import ctypes.util
from pathlib import Path

import h5py
import numpy as np

FORMS = ["IEEE_LITTLE_32", "IEEE_LITTLE_64", "IEEE_BIG_32", "IEEE_BIG_64"]
LIBRARY = ctypes.CDLL(ctypes.util.find_library("cgns") or "libcgns.so.3.4")
FINE = -1


def call(name, *arguments):
    """Calls a function whose last argument is the number of its error."""
    error = ctypes.c_int(FINE)
    typed = [ctypes.c_double(x) if isinstance(x, float) else x.encode() if isinstance(x, str) else x for x in arguments]
    getattr(LIBRARY, f"ADF_{name}")(*typed, ctypes.byref(error))
    if error.value != FINE:
        raise RuntimeError(f"ADF_{name}: error {error.value}")


def identity(name, *arguments):
    """What a function gives that makes or finds a node."""
    found = ctypes.c_double()
    call(name, *arguments, ctypes.byref(found))
    return found.value


def create(path, form, is_old):
    """A new file: of version A where it is old, else of version B."""
    Path(path).unlink(missing_ok=True)
    root = identity("Database_Open", str(path), "NEW", "LEGACY" if is_old else form)
    if is_old:
        call("Database_Set_Format", root, form)
    return root


def put(node, kind, data, fragments):
    """Data of a node; in fragments where it is longer with each time that it is written, and something else between."""
    sizes = list(data.shape[::-1])
    steps = sorted({max(1, sizes[-1] * i // fragments) for i in range(1, fragments)} | {sizes[-1]})
    for n in steps:
        shape = (ctypes.c_int * len(sizes))(*sizes[:-1], n)
        call("Put_Dimension_Information", node, kind, len(sizes), shape)
        call("Write_All_Data", node, np.ascontiguousarray(data[:n]).ctypes.data_as(ctypes.c_char_p))
        if n != steps[-1]:
            call("Delete", node, identity("Create", node, "hole"))
            identity("Create", node, "between")
            call("Delete", node, identity("Get_Node_ID", node, "between"))


def copy(source, path, form="IEEE_LITTLE_32", is_old=False, fragments=1, linked=None):
    """Copies an HDF5 file of CGNS. With `linked` the coordinates go into a file of that name, beside it."""
    root = create(path, form, is_old)
    other = create(Path(path).parent / linked, form, is_old) if linked else None
    grids = identity("Create", other, "Grids") if linked else None

    numbers = []

    def fill(group, above):
        for name in group:
            if name.startswith(" "):
                continue
            node = group[name]
            while node.attrs["type"] == b"LK":
                node = node[" link"]
            label = node.attrs["label"].decode()
            if linked and label == "GridCoordinates_t":
                numbers.append(len(numbers))
                unique = f"Grid{numbers[-1]}"
                fill_one(node, identity("Create", grids, unique), label)
                identity("Link", above, name, linked, f"/Grids/{unique}")
            else:
                fill_one(node, identity("Create", above, name), label)

    def fill_one(node, new, label):
        call("Set_Label", new, label)
        if " data" in node:
            data = node[" data"][()]
            data = data.astype(data.dtype.newbyteorder("="))
            put(new, node.attrs["type"].decode(), data, fragments if data.nbytes > 64 else 1)
        fill(node, new)

    with h5py.File(source) as file:
        fill(file, root)
    call("Database_Close", root)
    if linked:
        call("Database_Close", other)


def cgns_version(path):
    """The version of CGNS that a file states."""
    root = identity("Database_Open", str(path), "READ_ONLY", "NATIVE")
    version = ctypes.c_float()
    call("Read_All_Data", identity("Get_Node_ID", root, "/CGNSLibraryVersion"), ctypes.byref(version))
    call("Database_Close", root)
    return f"{version.value:.2f}"


def main():
    """Two small files: one as old machines left them, one of the last version."""
    folder = Path(__file__).parent.parent / "cgns"
    fragmented = {"form": "IEEE_BIG_32", "is_old": True, "fragments": 4}
    copy(folder / "structured_rind.cgns", folder / "adf_fragmented_big_endian.cgns", **fragmented)
    copy(folder / "polyhedra_offsets.cgns", folder / "adf_version_b.cgns", form="IEEE_LITTLE_64")


if __name__ == "__main__":
    main()
