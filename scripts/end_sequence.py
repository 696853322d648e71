"""The checks that end `azimesh deform` and `azimesh finish` at random moments, as often as asked.

    .venv/bin/python scripts/end_sequence.py killed --times 50
    .venv/bin/python scripts/end_sequence.py interrupted --times 100
    .venv/bin/python scripts/end_sequence.py joined --times 50

For each format: files of one step each, and whole sequences in one file. `killed` looks at what SIGKILL leaves;
`interrupted` resumes runs that SIGINT, SIGTERM and SIGKILL ended until they are done, and compares byte for byte;
`joined` does so with the joining of parts. The checks themselves are scripts/verify/killed.py, interrupted.py and
joined.py.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "verify"))

import interrupted  # noqa: E402
import joined  # noqa: E402
import killed  # noqa: E402

CHECKS = {"killed": killed, "interrupted": interrupted, "joined": joined}


def main():
    """Runs a check in full."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("check", choices=CHECKS)
    parser.add_argument("--times", type=int, default=50, help="ends for each format")
    parser.add_argument("--nodes", type=int, help="nodes of the mesh")
    arguments = parser.parse_args()
    check = CHECKS[arguments.check]
    check.main(arguments.times, arguments.nodes or check.NODES)


if __name__ == "__main__":
    main()
