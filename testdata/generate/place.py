"""Where the files of testdata go, and the programs that make them."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("TESTDATA", ROOT / "testdata"))
AZIMESH = str(Path(os.environ.get("AZIMESH", ROOT / "target/release/azimesh")).resolve())


def azimesh(*arguments):
    """Runs azimesh; its failure is ours."""
    subprocess.run([AZIMESH, "-q", *map(str, arguments)], check=True)


def start_gmsh():
    """Gmsh, quiet and on one thread, so that it makes the same files again."""
    import gmsh

    gmsh.initialize()
    for option in ("Terminal", "NumThreads"):
        gmsh.option.setNumber(f"General.{option}", int(option == "NumThreads"))
