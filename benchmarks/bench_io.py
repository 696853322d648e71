"""Reading and writing one large mesh beside gmsh, meshio, VTK and dd.

    .venv/bin/python benchmarks/bench_io.py [--nodes 1000000] [--folder target/bench] [--rounds 5]

Every program times its own call, imports and exit left out: azimesh says it with `convert -v`.
Files that are written are new. The mesh is a rotor of tetrahedra: meshio refuses MSH 4.1 without
zones.
"""

import argparse
import os
import re
import subprocess
from pathlib import Path

from measure import PYTHON, alternating, dd, fsynced, table

AZIMESH = "target/release/azimesh"
IMPORTS = {
    "gmsh": "import gmsh; gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0)",
    "meshio": "import meshio",
    "VTK": "import vtk",
}
READ_MSH = {
    "gmsh": "gmsh.open(path); gmsh.model.mesh.getNodes(); gmsh.model.mesh.getElements()",
    "meshio": "meshio.read(path)",
}
READ_VTU = "r = vtk.vtkXMLUnstructuredGridReader(); r.SetFileName(path); r.Update()"
PREPARE_VTU = (
    f"{READ_VTU}; w = vtk.vtkXMLUnstructuredGridWriter(); w.SetFileName(out); "
    "w.SetInputData(r.GetOutput()); w.SetDataModeToAppended(); w.EncodeAppendedDataOff(); "
    "w.SetCompressorTypeToNone()"
)


def peak_megabytes(command):
    """Standard output and error of a command, and its peak resident MB."""
    timed = ["/usr/bin/env", "python3", "-c", "import resource, subprocess, sys; "
             "r = subprocess.run(sys.argv[1:], capture_output=True, text=True); "
             "print(r.stdout, r.stderr, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, sep='\\n'); "
             "sys.exit(r.returncode)"]
    said = subprocess.run([*timed, *map(str, command)], check=True, capture_output=True, text=True).stdout
    return said, float(said.split()[-1]) / 1024


def fresh(out):
    """Removes a file that is to be written, and lets the disk come to rest."""
    Path(out).unlink(missing_ok=True)
    os.sync()


def python(library, work, path, out="", prepare="", wait=False):
    """A job that times `work` in a Python process of its own, after the imports and `prepare`; with
    `wait` until `out` is on the disk."""
    lines = [IMPORTS[library], f"path, out = {str(path)!r}, {str(out)!r}", prepare, "import time",
             "start = time.perf_counter()", work, "print('seconds', time.perf_counter() - start)"]

    def job():
        if out:
            fresh(out)
        said, memory = peak_megabytes([PYTHON, "-c", "\n".join(lines)])
        seconds = float(re.search(r"seconds (\S+)", said)[1])
        return seconds + (fsynced([out]) if wait else 0.0), memory

    return job


def azimesh(stage, source, out, wait=False):
    """A job of `convert`; its seconds are those of `stage`, with `wait` until the file is on the disk."""

    def job():
        fresh(out)
        said, memory = peak_megabytes([AZIMESH, "convert", "-v", source, out])
        seconds = float(re.search(rf"{stage}: (\S+) s", said)[1])
        return seconds + (fsynced([out]) if wait else 0.0), memory

    return job


def main():
    """Prints four tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    vtu, msh, out = folder / "rotor.vtu", folder / "rotor.msh", folder / "written.vtu"
    sample = ["sample", "rotor", "--nodes", str(options.nodes), "--cells", "tet"]
    peak_megabytes([AZIMESH, *sample, "-o", vtu, "--force"])
    peak_megabytes([AZIMESH, "convert", "--force", vtu, msh])
    print(f"{vtu}: {vtu.stat().st_size / 1e6:.0f} MB, {msh}: {msh.stat().st_size / 1e6:.0f} MB\n")

    print("reading binary MSH 4.1")
    jobs = {"azimesh": azimesh("reading", msh, out)}
    jobs |= {name: python(name, work, msh) for name, work in READ_MSH.items()}
    table(alternating(jobs, options.rounds))

    print("\nreading raw VTU")
    jobs = {"azimesh": azimesh("reading", vtu, out), "VTK": python("VTK", READ_VTU, vtu)}
    table(alternating(jobs, options.rounds))

    vtk_out = folder / "written_vtk.vtu"
    for wait, where in ((False, "as far as the system's memory"), (True, "until it is on the disk")):
        print(f"\nwriting raw VTU, {where}")
        jobs = {
            "azimesh": azimesh("writing", vtu, out, wait),
            "VTK": python("VTK", "w.Write()", vtu, vtk_out, PREPARE_VTU, wait),
        }
        if wait:
            jobs["dd"] = dd(folder / "written.dd", vtu.stat().st_size)
        table(alternating(jobs, options.rounds))


if __name__ == "__main__":
    main()
