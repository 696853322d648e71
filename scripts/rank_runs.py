"""Runs of `azimesh deform` on ranks of MPI, for `rank_model.py`: what is counted of each, and what it took."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measure import machine, used

KEPT = Path(__file__).resolve().parent.parent / "target" / "rank_model.json"
ALLOWED = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}
# Layers of nodes around the blade: as many in every mesh, so that surface nodes grow as nodes do.
LAYERS = 60
CORES = len(os.sched_getaffinity(0))


def threads_of(ranks):
    """Threads of each of some ranks that are not bound to cores. The first has all cores while the others wait."""
    return max(1, CORES // ranks) if ranks > 1 else 1


# (nodes, ranks, threads of each, steps, quality, correction): each rate counts for more in one than in another.
FITTED = [
    *((1_000_000, ranks, threads_of(ranks), steps, "summary", True) for ranks in (1, 2) for steps in (2, 6)),
    *((1_000_000, ranks, threads_of(ranks), 2, "none", True) for ranks in (1, 2)),
    (1_000_000, 1, 1, 2, "none", False),
    (1_000_000, 4, threads_of(4), 2, "summary", True),
    *((8_000_000, ranks, threads_of(ranks), 2, "summary", True) for ranks in (1, 2)),
]
THREADED = (8_000_000, 1, CORES, 2, "summary", True)
SCHEDULE = """
[output]
format = "vtkhdf"
quality = "{quality}"
"""
STAGES = ["reading", "selection", "modes", "steps", "writing", "rest"]
UNITS = {"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
# Of a processor, by other programs; a run during which they take more is made again, at most so often.
QUIET, AGAIN = 0.1, 4


def one_rank(figures, command):
    """Runs the program as one rank, and writes what it took beside what the others took."""
    rank = next((os.environ[name] for name in ("OMPI_COMM_WORLD_RANK", "PMI_RANK") if name in os.environ), "0")
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    took = {"megabytes": usage.ru_maxrss * 1024 / 1e6, "cpu": usage.ru_utime + usage.ru_stime}
    Path(f"{figures}.{rank}").write_text(json.dumps(took))
    return os.waitstatus_to_exitcode(status)


def busy():
    """Processor seconds that all programs have taken."""
    user, nice, system, _, _, *others = map(int, Path("/proc/stat").read_text().split("\n")[0].split()[1:9])
    return (user + nice + system + sum(others)) / os.sysconf("SC_CLK_TCK")


def wait_for_quiet():
    """Waits until other programs take little, but no longer than three minutes."""
    for _ in range(90):
        before = busy()
        time.sleep(2)
        if busy() - before < 2 * QUIET:
            return


def messages(said):
    """{purpose: (messages, bytes)} of what `-v` prints."""
    found = re.findall(r"^(\w+): ([\d,]+) messages? sent, ([\d.,]+) (\w+);", said, re.MULTILINE)
    plain = [[text.replace(",", "") for text in line] for line in found]
    return {what: [int(n), float(amount) * UNITS[unit]] for what, n, amount, unit in plain}


def cached(path):
    """Reads a file, so that the system has it in memory."""
    with path.open("rb", buffering=0) as file:
        while file.read(1 << 24):
            pass


def deform(program, folder, mesh, case):
    """One run: what is counted of it, and what it took."""
    _, ranks, threads, steps, quality, correction = case
    out, said, toml = folder / "out", folder / "said", folder / "steps.toml"
    text = mesh.with_suffix(".toml").read_text()
    text = text.replace("[selection]", f"[selection]\ncorrection = {str(correction).lower()}")
    toml.write_text(text + SCHEDULE.format(quality=quality))
    cached(mesh)
    os.sync()
    wait_for_quiet()
    command = [program, "deform", mesh, toml, "--steps", f"0..{steps}", "-o", out, "-v"]
    launcher = ["mpirun", "--bind-to", "none", "-n", ranks] if ranks > 1 else []
    words = [*launcher, sys.executable, __file__, folder / "rank", *command]
    words += ["--threads", threads] if ranks == 1 else []
    before, started = busy(), time.monotonic()
    with said.open("w") as file:
        subprocess.run([*map(str, words)], stdout=file, stderr=file, check=True, env={**os.environ, **ALLOWED})
    whole, all_cpu = time.monotonic() - started, busy() - before
    of_ranks = [json.loads((folder / f"rank.{rank}").read_text()) for rank in range(ranks)]
    result = figures(case, mesh, out, said.read_text(), whole)
    shutil.rmtree(out)
    result["megabytes"] = [rank["megabytes"] for rank in of_ranks]
    return {**result, "others": (all_cpu - sum(rank["cpu"] for rank in of_ranks)) / whole}


def at_once(seconds, threads, steps):
    """Seconds that count twice: with several threads a step is written while the next is computed."""
    return min(seconds["steps"], seconds["writing"]) * (steps - 1) / steps * (threads > 1)


def figures(case, mesh, out, said, whole):
    """What a run says of itself."""
    record = json.loads(next(out.glob("run*.json")).read_text())
    seconds = {**record["seconds"], "reading": float(re.search(r"^reading: ([\d.]+) s", said, re.MULTILINE)[1])}
    alone = CORES if case[1] > 1 else case[2]
    seconds["rest"] = whole - sum(seconds[stage] for stage in STAGES[:-1]) + at_once(seconds, alone, case[3])
    found = {"alone": alone, "seconds": {**seconds, "total": whole}, "messages": messages(said)}
    return {**counts(case, mesh, record), **found}


def counts(case, mesh, record):
    """What is counted of a run, from its record."""
    layer = record["selections"][0]["layers"][0]
    return {
        "case": list(case),
        "alone": CORES,
        **{key: record[key] for key in ("nodes", "cells", "surface_points", "modes", "steps")},
        "base_points": layer["base_points"],
        "sweeps": [n for n, _ in layer["history"]],
        "bytes_read": mesh.stat().st_size,
    }


def sample(program, folder, nodes):
    """A mesh with its schedule."""
    mesh = folder / f"blade_{nodes}.vtkhdf"
    if not mesh.exists():
        sizes = ["--nodes", nodes, "--surface-nodes", 2 * nodes // LAYERS]
        used([program, "sample", "blade", *sizes, "-o", mesh, "--format", "vtkhdf", "-q"])
    return mesh


def quietest(program, folder, mesh, case):
    """The run during which other programs took least."""
    runs = []
    while not runs or (runs[-1]["others"] > QUIET and len(runs) < AGAIN):
        runs.append(deform(program, folder, mesh, case))
        print(case, f"{runs[-1]['seconds']['total']:.1f} s, others {runs[-1]['others']:.2f}", flush=True)
    return min(runs, key=lambda run: run["others"])


def kept():
    """All runs so far."""
    return json.loads(KEPT.read_text()) if KEPT.exists() else {"runs": [], "checks": []}


def keep(**new):
    """Replaces some of what is kept."""
    KEPT.write_text(json.dumps({**kept(), **new, "machine": machine()}, indent=1))


def measure(program, rounds):
    """The runs that give rates, several times in turn."""
    runs = []
    with tempfile.TemporaryDirectory(prefix="rank_model_", dir=KEPT.parent) as folder:
        folder = Path(folder)
        for case in [*FITTED, THREADED] * rounds:
            runs.append(quietest(program, folder, sample(program, folder, case[0]), case))
            keep(runs=runs)


def check(program, mesh, case):
    """A run that is compared with what is predicted, made once."""
    with tempfile.TemporaryDirectory(prefix="rank_model_", dir=KEPT.parent) as folder:
        folder = Path(folder)
        mesh = Path(mesh).resolve() if mesh else sample(program, folder, case[0])
        done = deform(program, folder, mesh, case)
    print(f"others {done['others']:.2f}")
    keep(checks=[*(run for run in kept()["checks"] if run["case"] != done["case"]), done])


if __name__ == "__main__":
    sys.exit(one_rank(sys.argv[1], sys.argv[2:]))
