"""Readings by one peer, and the comparison with what azimesh wrote.

ask.py PEER reads lines of JSON, [FILE, OURS.vtu or null], and answers each with a line of JSON.
"""

import gzip
import importlib
import json
import os
import pathlib
import shutil
import sys
import tempfile

PEERS = {"gmsh": ("gmsh_peer", "read"), "vtk": ("vtk_peer", "read"), "meshio": ("meshio_peer", "read"),
         "meshio_su2": ("meshio_peer", "read_su2"), "h5py": ("cgns_peer", "read")}


def answer(peer, path, ours):
    module, function = PEERS[peer]
    read = getattr(importlib.import_module(module), function)
    try:
        with tempfile.TemporaryDirectory() as scratch:
            theirs = read(unpacked(path, scratch))
    except (Exception, SystemExit) as error:
        return {"failed": " ".join(str(error).split())[:200] or type(error).__name__}
    if theirs.n_cells() == 0:
        return {"failed": "no cells"}
    if ours is None:
        return {"cells": theirs.n_cells()}
    import model
    import vtk_peer
    wrong, remarks = model.differences(vtk_peer.read(ours), theirs)
    return {"cells": theirs.n_cells(), "wrong": wrong, "remarks": remarks}


def unpacked(path, scratch):
    if not path.endswith(".gz"):
        return path
    target = pathlib.Path(scratch) / pathlib.Path(path).name.removesuffix(".gz")
    with gzip.open(path) as packed, open(target, "wb") as out:
        shutil.copyfileobj(packed, out)
    return str(target)


if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a peer prints is no answer
    for line in sys.stdin:
        file, ours = json.loads(line)
        answers.write(json.dumps(answer(sys.argv[1], file, ours)) + "\n")
        answers.flush()
