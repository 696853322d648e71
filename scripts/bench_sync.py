"""What it costs that steps are on the disk before steps.csv tells of them.

    .venv/bin/python scripts/bench_sync.py [--nodes 8000000] [--steps 30] [--quality none|summary]
        [--rounds 3] [--folder target/bench]

The M427 blade of scripts/m427.py, as VTU files. In turn: `deform`; `deform --no-sync`; the same and its files synced at
the end; dd writing files of the same sizes with conv=fsync, and without. What is dirty is synced before each, and the
files are deleted after it. Prints the median of each and what the runs say of their steps.
"""

import argparse
import json
import os
import shutil
from pathlib import Path

from measure import alternating, fsynced, run, table
from paper_runs import AZIMESH, PITCH_AND_FLAP, revolution, sample, schedule

SUPPORT_RADIUS = 5.625
TOLERANCE = 7.5e-5


def deform_job(mesh, text, out, *options, synced=False):
    """A run into an empty folder, whose files are deleted when it is timed."""

    def job():
        os.sync()
        seconds, memory = run([AZIMESH, "deform", mesh, text, "-o", out, "-q", *options])
        if synced:
            seconds += fsynced(out.iterdir())
        part = json.loads((out / "run.json").read_text())["seconds"]
        print(f"{' '.join(options) or 'synced':12}{seconds:8.2f} s, of which {part}", flush=True)
        shutil.rmtree(out)
        return seconds, memory

    return job


def dd_job(out, n_files, size, *options):
    """As many files as the run has steps."""

    def job():
        os.sync()
        out.mkdir()
        whole = ["dd", "if=/dev/zero", "bs=16M", "iflag=count_bytes", f"count={size}", *options]
        results = [run([*whole, f"of={out / str(i)}"]) for i in range(n_files)]
        shutil.rmtree(out)
        return sum(seconds for seconds, _ in results), max(memory for _, memory in results)

    return job


def main():
    """One table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=8_000_000)
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--quality", choices=["none", "summary"], default="none")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    options = parser.parse_args()
    folder, mesh = options.folder, options.folder / "m427.vtu"
    text, out = folder / "m427.toml", folder / "sync"
    sample(mesh, "--nodes", str(options.nodes), "--surface-nodes", str(options.nodes * 67 // 800))
    motion = (PITCH_AND_FLAP, SUPPORT_RADIUS, TOLERANCE, "sequence", revolution(360 / options.steps))
    text.write_text(schedule(*motion, quality=options.quality))
    shutil.rmtree(out, ignore_errors=True)
    dd = (out, options.steps, mesh.stat().st_size)
    jobs = {
        "deform": deform_job(mesh, text, out),
        "deform --no-sync": deform_job(mesh, text, out, "--no-sync"),
        "  and synced at the end": deform_job(mesh, text, out, "--no-sync", synced=True),
        "dd conv=fsync": dd_job(*dd, "conv=fsync"),
        "dd": dd_job(*dd),
    }
    table(alternating(jobs, options.rounds), first="dd conv=fsync")


if __name__ == "__main__":
    main()
