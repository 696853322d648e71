"""The command ``azimesh``."""

import sys

from azimesh import _azimesh


def main() -> int:
    """Runs the command with the arguments of the process; gives its exit code."""
    return _azimesh.run_command(["azimesh", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
