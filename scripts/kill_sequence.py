"""Kills `azimesh deform` at random moments, as often as asked, and checks what is left.

    .venv/bin/python scripts/kill_sequence.py --kills 50

For each format: files of one step each, and whole sequences in one file. The check itself is
scripts/verify/killed.py.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "verify"))

import killed  # noqa: E402


def main():
    """Runs the check in full."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50, help="kills for each format")
    parser.add_argument("--nodes", type=int, default=killed.NODES, help="nodes of the mesh")
    arguments = parser.parse_args()
    killed.main(arguments.kills, arguments.nodes)


if __name__ == "__main__":
    main()
