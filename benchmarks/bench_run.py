"""A whole run of `azimesh deform` beside writing the same files with dd.

    .venv/bin/python benchmarks/bench_run.py [--nodes 1000000] [--folder target/bench]

The blade's own schedule (the paper's cyclic motion, 36 steps, tolerance 1e-4 chord). Each of three
rounds runs deform, its files fsynced, then dd over files of the same sizes, fsynced.
"""

import argparse
import csv
import json
import shutil
from pathlib import Path

from measure import alternating, dd, fsynced, run, table

AZIMESH = "target/release/azimesh"


def deform_job(mesh, out):
    """deform into an empty folder; its files are on the disk at the end, as dd's are."""

    def job():
        shutil.rmtree(out, ignore_errors=True)
        seconds, memory = run([AZIMESH, "deform", mesh, mesh.with_suffix(".toml"), "-o", out, "-q"])
        return seconds + fsynced(out.iterdir()), memory

    return job


def dd_job(out, copy):
    """Files of the sizes that deform left, one after another."""

    def job():
        shutil.rmtree(copy, ignore_errors=True)
        copy.mkdir()
        sizes = [(path.name, path.stat().st_size) for path in sorted(out.glob("*.vtu"))]
        results = [dd(copy / name, size)() for name, size in sizes]
        return sum(seconds for seconds, _ in results), max(memory for _, memory in results)

    return job


def main():
    """Prints a table, then what the run itself says of its parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    mesh, out = options.folder / "blade_run.vtu", options.folder / "run"
    run([AZIMESH, "sample", "blade", "--nodes", str(options.nodes), "-o", mesh, "--force", "-q"])
    table(alternating({"azimesh": deform_job(mesh, out), "dd": dd_job(out, options.folder / "dd")}), first="dd")
    with open(out / "steps.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    written = sum(path.stat().st_size for path in out.glob("*.vtu"))
    print(f"\n{len(rows)} steps, {written / 1e9:.2f} GB, {rows[0]['base_points']} base points")
    print(json.dumps(json.loads((out / "run.json").read_text())["seconds"], indent=2))


if __name__ == "__main__":
    main()
