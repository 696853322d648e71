"""Cell quality of every mesh of testdata against VTK's: `scripts/check_quality.py` on all of them."""

import subprocess
import sys

from formats import sources
from meshes import third_party
from program import AZIMESH

JUDGED = {5, 9, 10, 12, 13, 14}


def judged():
    """Meshes with cells that VTK's mesh quality knows: neither second-order ones nor polyhedra."""
    return [path for path in sources() if {kind for kind, _ in third_party(path).volume_cells} & JUDGED]


def main():
    """One line a mesh."""
    command = [sys.executable, "scripts/check_quality.py", "--azimesh", AZIMESH, *map(str, judged())]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    print(done.stdout, end="", flush=True)
    assert done.returncode == 0, "cell quality differs from VTK's"


if __name__ == "__main__":
    main()
