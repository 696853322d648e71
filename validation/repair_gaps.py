"""Whether other keys of the interpolation fold fewer cells where a gap is narrower than the motion.

    .venv/bin/python validation/repair_gaps.py target/release/azimesh

A row for each way, a column for each gap case of `repair_cases.py` (and the flap in its slot): inverted and unproven cells after one
step with `on_inverted = "warn"`, and the CPU seconds of the command.
"""

import sys
import tempfile
from pathlib import Path

from folding import flap, two_blocks
from repair_cases import azimesh, count, last_row

# The default support radius is the diagonal of the mesh, 1.414.
WAYS = {
    "default": "",
    "wendland-c0": 'kernel = "wendland-c0"',
    "support_radius = 0.2": "support_radius = 0.2",
    "support_radius = 0.5": "support_radius = 0.5",
    "support_radius = 3": "support_radius = 3.0",
    "support_radius = 10": "support_radius = 10.0",
    "substeps = 8": "substeps = 8",
    "substeps = 50": "substeps = 50",
    "wendland-c0, 8 substeps": 'kernel = "wendland-c0"\nsubsteps = 8',
    "wendland-c0, 50 substeps": 'kernel = "wendland-c0"\nsubsteps = 50',
    "wendland-c0, 50 substeps, support_radius = 0.2": 'kernel = "wendland-c0"\nsubsteps = 50\nsupport_radius = 0.2',
}
CASES = {
    f"gap {gap} by {times}": lambda folder, gap=gap, times=times: two_blocks(folder, gap, gap * times)
    for gap, times in ((0.05, 4), (0.005, 4), (0.005, 20), (0.005, 60), (0.0005, 20), (0.0005, 600))
} | {f"flap, {angle} degrees": lambda folder, angle=angle: flap(folder, angle) for angle in (60, 90)}


def main():
    """The table."""
    print("| keys under `[rbf]` | " + " | ".join(CASES) + " |")
    print("|---" * (len(CASES) + 1) + "|")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for way, keys in WAYS.items():
            cells = []
            for make in CASES.values():
                mesh, text = make(folder)
                (folder / "s.toml").write_text(text + f'\n[rbf]\n{keys}\n[output]\nformat = "vtu"\non_inverted = "warn"\n')
                _, seconds = azimesh("deform", mesh, folder / "s.toml", "-o", folder / "out", "--force", "-q")
                cells.append(f"{count(last_row(folder / 'out'), 'inverted', 'unproven')}, {seconds:.2f} s")
            print(f"| {way} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
