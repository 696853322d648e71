"""Files in the modes of VTK's writers, read as VTK reads them: a ninth of testdata/generate/vtk_fixtures.py."""

import sys
from pathlib import Path

from program import report

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "testdata" / "generate"))
import vtk_fixtures  # noqa: E402

# Prime to the number of choices of every option, so that each of them occurs.
EVERY = 9


def main():
    """Compares, and fails with the first file that differs."""
    n_files, wrong = vtk_fixtures.check(EVERY)
    assert not wrong, f"{len(wrong)} of {n_files} files: {wrong[0]}"
    report("fixtures", n_files, 0, "files by VTK")
