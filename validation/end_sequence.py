"""The checks that end `azimesh deform`, `finish` and `convert` at random moments, as often as asked.

    .venv/bin/python validation/end_sequence.py killed --times 50
    .venv/bin/python validation/end_sequence.py interrupted --times 100
    .venv/bin/python validation/end_sequence.py joined --times 50
    .venv/bin/python validation/end_sequence.py converted --times 50
    .venv/bin/python validation/end_sequence.py power_cut --times 34

For each format: files of one step each, and whole sequences in one file. `killed` looks at what SIGKILL leaves;
`interrupted` resumes runs that SIGINT, SIGTERM, SIGHUP and SIGKILL ended until they are done, and compares byte for byte;
`joined` does so with the joining of parts, `converted` with conversions; `power_cut` loses what was not synced. The checks
themselves are in scripts/verify.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts" / "verify"))

import converted  # noqa: E402
import interrupted  # noqa: E402
import joined  # noqa: E402
import killed  # noqa: E402
import power_cut  # noqa: E402

CHECKS = {
    "killed": killed, "interrupted": interrupted, "joined": joined, "converted": converted, "power_cut": power_cut,
}


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
