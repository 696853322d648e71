"""Reading and writing one large mesh beside gmsh, meshio, VTK and dd.

    .venv/bin/python scripts/bench_io.py [--nodes 1000000] [--folder target/bench]

Whole processes are timed; the time to start Python and import a library is measured alone and taken
off. The mesh is a rotor of tetrahedra: meshio refuses MSH 4.1 without zones. azimesh reads with
`info`; its writing is `convert` from VTU to VTU less `info` on the same file, plus fsync.
"""

import argparse
from pathlib import Path

from measure import PYTHON, alternating, dd, fsynced, run, table

AZIMESH = "target/release/azimesh"
IMPORTS = {
    "gmsh": "import gmsh; gmsh.initialize()",
    "meshio": "import meshio",
    "VTK": "import vtk",
}
READ_MSH = {
    "gmsh": "gmsh.open(path); gmsh.model.mesh.getNodes(); gmsh.model.mesh.getElements()",
    "meshio": "meshio.read(path)",
}
READ_VTU = "r = vtk.vtkXMLUnstructuredGridReader(); r.SetFileName(path); r.Update()"
WRITE_VTU = (
    "w = vtk.vtkXMLUnstructuredGridWriter(); w.SetFileName(out); w.SetInputData(r.GetOutput()); "
    "w.SetDataModeToAppended(); w.EncodeAppendedDataOff(); w.SetCompressorTypeToNone(); w.Write(); "
    "import os; f = os.open(out, os.O_RDWR); os.fsync(f)"
)


def python(library, work, path, out="", less=None):
    """A job that runs `work` after the imports, less the time of `less` (by default the imports)."""
    head = f"path, out = {str(path)!r}, {str(out)!r}; {IMPORTS[library]}; "

    def job():
        seconds, memory = run([PYTHON, "-c", head + work])
        idle, _ = run([PYTHON, "-c", head + (less or "")])
        return seconds - idle, memory

    return job


def write_job(source, out):
    """azimesh's writing: convert less info, until it is on the disk."""

    def job():
        seconds, memory = run([AZIMESH, "convert", "-q", "--force", source, out])
        reading, _ = run([AZIMESH, "info", source])
        return seconds - reading + fsynced([out]), memory

    return job


def main():
    """Prints three tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    vtu, msh = options.folder / "rotor.vtu", options.folder / "rotor.msh"
    sample = ["sample", "rotor", "--nodes", str(options.nodes), "--cells", "tet"]
    run([AZIMESH, *sample, "-o", vtu, "--force", "-q"])
    run([AZIMESH, "convert", "-q", "--force", vtu, msh])
    print(f"{vtu}: {vtu.stat().st_size / 1e6:.0f} MB, {msh}: {msh.stat().st_size / 1e6:.0f} MB\n")

    print("reading binary MSH 4.1")
    jobs = {"azimesh": lambda: run([AZIMESH, "info", msh])}
    jobs |= {name: python(name, work, msh) for name, work in READ_MSH.items()}
    table(alternating(jobs))

    print("\nreading raw VTU")
    jobs = {"azimesh": lambda: run([AZIMESH, "info", vtu]), "VTK": python("VTK", READ_VTU, vtu)}
    table(alternating(jobs))

    print("\nwriting raw VTU, fsynced")
    out = options.folder / "written.vtu"
    jobs = {
        "azimesh": write_job(vtu, out),
        "VTK": python("VTK", f"{READ_VTU}; {WRITE_VTU}", vtu, out, less=READ_VTU),
        "dd": dd(options.folder / "written.dd", vtu.stat().st_size),
    }
    table(alternating(jobs))


if __name__ == "__main__":
    main()
