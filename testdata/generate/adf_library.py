"""Two files of testdata/cgns in ADF, by the CGNS library (libcgns 3.4): other byte orders and widths, and fragmented data. Sources are CGNS files in HDF5."""

import ctypes
import ctypes.util
from pathlib import Path

import h5py
import numpy as np

from place import FOLDER

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


def copy(source, path, form="IEEE_LITTLE_32", is_old=False, fragments=1):
    """Copies an HDF5 file of CGNS."""
    root = create(path, form, is_old)

    def fill(group, above):
        for name in (name for name in group if not name.startswith(" ")):
            node, new = group[name], identity("Create", above, name)
            while node.attrs["type"] == b"LK":
                node = node[" link"]
            call("Set_Label", new, node.attrs["label"].decode())
            if " data" in node:
                data = node[" data"][()]
                data = data.astype(data.dtype.newbyteorder("="))
                put(new, node.attrs["type"].decode(), data, fragments if data.nbytes > 64 else 1)
            fill(node, new)

    with h5py.File(source) as file:
        fill(file, root)
    call("Database_Close", root)


def main():
    """Two small files: one as old machines left them, one of the last version."""
    folder = FOLDER / "cgns"
    copy(folder / "structured_rind.cgns", folder / "adf_fragmented_big_endian.cgns", form="IEEE_BIG_32", is_old=True, fragments=4)
    copy(folder / "polyhedra_offsets.cgns", folder / "adf_version_b.cgns", form="IEEE_LITTLE_64")
