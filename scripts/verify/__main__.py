"""All checks that are not our own code: `.venv/bin/python scripts/verify [NAME...]`. Two run at a time. With `--update` pages are written anew."""

import os
import sys
import tempfile
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import import_module

# The longest first.
CHECKS = [
    "formats", "fixtures", "ugrid", "vtkhdf", "cgns", "openfoam", "openfoam_write", "split", "whole", "ended", "quality", "curved", "faces", "selection", "morph",
    "surfaces", "motions", "keys", "damaged", "surface", "su2_surface", "pitching", "size_skew", "twist", "bending", "rotor", "flap", "repair", "schema", "notes", "pages",
]
# These use all processors, time what they do, or open windows.
ALONE = ["paraview", "interrupted", "power_cut", "full_disk", "report", "terminal", "mpi", "mixtures"]


def check(name):
    """Runs a check; whether it passed, its seconds, and what it printed."""
    started = time.monotonic()
    passed = True
    with tempfile.TemporaryFile() as output:
        sys.stdout.flush()
        kept = os.dup(1), os.dup(2)
        os.dup2(output.fileno(), 1)
        os.dup2(output.fileno(), 2)
        try:
            import_module(name).main()
        except BaseException:
            traceback.print_exc()
            passed = False
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, number in enumerate(kept, 1):
            os.dup2(number, stream)
            os.close(number)
        output.seek(0)
        return passed, time.monotonic() - started, output.read().decode(errors="replace")


def main():
    """Runs each check, all of them even where one fails; exit code 1 where one did."""
    failed = []
    started = time.monotonic()

    def report(name, result):
        passed, seconds, text = result
        print(f"{text}{name}: {'passed' if passed else 'FAILED'} in {seconds:.1f} s", flush=True)
        if not passed:
            failed.append(name)

    names = [name for name in sys.argv[1:] if name != "--update"] or CHECKS + ALONE
    with ProcessPoolExecutor(2) as pool:
        running = {pool.submit(check, name): name for name in names if name not in ALONE}
        for done in as_completed(running):
            report(running[done], done.result())
    for name in names:
        if name in ALONE:
            report(name, check(name))
    seconds = time.monotonic() - started
    print(f"verify: {'FAILED: ' + ', '.join(failed) if failed else 'all passed'} in {seconds:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
