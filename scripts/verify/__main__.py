"""All checks that are not our own code: `.venv/bin/python scripts/verify [NAME...]`."""

import sys
import time
import traceback
from importlib import import_module

CHECKS = [
    "formats", "fixtures", "ugrid", "vtkhdf", "cgns", "openfoam", "openfoam_write", "foam_to_vtk", "split", "paraview", "killed", "interrupted", "power_cut",
    "full_disk", "batches", "joined", "converted", "quality", "faces", "all_points", "sequence", "morph", "shells", "surfaces", "motions", "keys", "surface",
    "openfoam_motion", "su2_surface", "pvd", "pitching", "size_skew", "twist", "bending", "rotor", "flap", "repair", "report", "terminal", "schema",
    "pages", "mpi", "mixtures",
]


def main():
    """Runs each check, all of them even where one fails; exit code 1 where one did."""
    failed = []
    started = time.monotonic()
    for name in sys.argv[1:] or CHECKS:
        try:
            import_module(name).main()
        except Exception:
            traceback.print_exc()
            failed.append(name)
    seconds = time.monotonic() - started
    print(f"verify: {'FAILED: ' + ', '.join(failed) if failed else 'all passed'} in {seconds:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
