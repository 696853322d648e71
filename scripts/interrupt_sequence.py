"""Ends `azimesh deform` at random moments by SIGINT, SIGTERM and SIGKILL, resumes it until it is done, and
compares what is left with a run that nobody ended, byte for byte.

    .venv/bin/python scripts/interrupt_sequence.py --ends 100

For each format: files of one step each, and whole sequences in one file. The check itself is
scripts/verify/interrupted.py.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "verify"))

import interrupted  # noqa: E402


def main():
    """Runs the check in full."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ends", type=int, default=100, help="ends for each format, at least")
    parser.add_argument("--nodes", type=int, default=interrupted.NODES, help="nodes of the mesh")
    arguments = parser.parse_args()
    interrupted.main(arguments.ends, arguments.nodes)


if __name__ == "__main__":
    main()
