"""Runs azimesh, and knows where everything is."""

import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

TESTDATA = Path("testdata")
AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")
UPDATE = "--update" in sys.argv  # pages are written anew


def azimesh(*arguments, expect=0):
    """Runs azimesh and returns its standard output; exit codes other than `expect` fail."""
    allowed = expect if isinstance(expect, tuple) else (expect,)
    command = [AZIMESH, "--quiet", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    said = f"{' '.join(command)}: exit code {done.returncode}, expected {expect}\n{done.stderr}"
    assert done.returncode in allowed, said
    return done.stdout


@contextmanager
def scratch():
    """A folder that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="azimesh-verify-") as folder:
        yield Path(folder)


def real_meshes():
    """The folder of real meshes, or None where AZIMESH_TESTDATA is not set."""
    folder = os.environ.get("AZIMESH_TESTDATA")
    return Path(folder) if folder else None


def report(name, n_compared, largest, unit="", note=""):
    """The one line a check ends with."""
    note = f"; {note}" if note else ""
    print(f"{name}: {n_compared} {unit or 'values'} compared, largest difference {largest:.3g}{note}", flush=True)
