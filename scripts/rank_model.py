"""What `azimesh deform` costs on ranks of MPI, by counting: arithmetic, bytes and messages. Rates come from runs
on 1 and 8 million nodes; memory and messages are counted alone. Prints tables: runs beside what is predicted, and
the outlook to 1e9 nodes.

    .venv/bin/python scripts/rank_model.py --measure [--rounds 3] [--azimesh PROGRAM]
    .venv/bin/python scripts/rank_model.py --check 60000000 --ranks 2 [--threads 1] [--mesh MESH]
    .venv/bin/python scripts/rank_model.py [--outlook-ranks 64 --outlook-threads 16 --network 10 --disk 2]

PROGRAM is one with the feature `mpi`. Runs are kept in target/rank_model.json: those of --measure give the
rates, those of --check are compared and nothing else. --measure takes 2 GB of memory and disk, and gives them
back; meshes are read from the page cache.
"""

import argparse
import math
import os
import statistics
from pathlib import Path

from measure import significant
from rank_counts import BY_FIRST, TERMS, counted, memory, messages, passed_on
from rank_runs import FITTED, KEPT, QUIET, STAGES, THREADED, check, kept, measure

PURPOSES = ["fields", "parts", "places", "positions", "quality"]


def medians(runs):
    """One run of each case, with the medians of those during which the machine was quiet, if any was."""
    by_case = {}
    for run in runs:
        by_case.setdefault(tuple(run["case"]), []).append(run)
    merged = []
    for same in by_case.values():
        same = [run for run in same if run["others"] <= QUIET] or same
        seconds = {key: statistics.median(run["seconds"][key] for run in same) for key in same[0]["seconds"]}
        megabytes = [statistics.median(of) for of in zip(*(run["megabytes"] for run in same))]
        merged.append({**same[0], "seconds": seconds, "megabytes": megabytes})
    return merged


# ---------------------------------------------------------------- rates


def units(c, stage):
    """How many units of each term a stage has."""
    return [sum(of(c) for name, of in places if name == stage) for places in TERMS.values()]


def fit(runs):
    """Seconds a unit of each term: none below zero, least squares of relative errors."""
    import numpy as np
    from scipy.optimize import nnls

    rows, wanted = [], []
    for run in runs:
        for stage in STAGES:
            # What takes less than 0.2 s matters less.
            weight = 1 / max(run["seconds"][stage], 0.2)
            rows.append([weight * n for n in units(counted(run), stage)])
            wanted.append(weight * run["seconds"][stage])
    matrix = np.array(rows, float)
    scale = matrix.max(axis=0)
    return list(nnls(matrix / scale, np.array(wanted))[0] / scale)


def one_threaded(c, rates):
    """Seconds of each stage with one thread and a processor for each rank."""
    return {stage: sum(rate * n for rate, n in zip(rates, units(c, stage))) for stage in STAGES}


def serial_parts(run, rates):
    """By Amdahl's law the part of each stage that more threads do not make faster, from a run with several."""
    alone, n = one_threaded(counted(run), rates), run["case"][2]
    ratio = {stage: run["seconds"][stage] / alone[stage] for stage in STAGES}
    return {stage: min(1, max(0, (n * ratio[stage] - 1) / (n - 1))) for stage in STAGES}


def seconds(c, rates, serial, cores):
    """Seconds of each stage; threads beyond the cores that a rank has bring nothing."""
    found = one_threaded(c, rates)
    for stage in STAGES:
        threads = max(1, min(c.T, cores / (1 if stage in BY_FIRST else c.P)))
        found[stage] *= serial[stage] + (1 - serial[stage]) / threads
    found["total"] = sum(found.values())
    if c.T > 1:  # a step is written while the next is computed
        found["total"] -= min(found["steps"], found["writing"]) * (c.K - 1) / c.K
    return found


# ---------------------------------------------------------------- tables


def table(head, rows):
    """In markdown."""
    return "\n".join(f"| {' | '.join(map(str, cells))} |" for cells in [head, ["---"] * len(head), *rows])


def off(measured, predicted):
    """What was measured, and by how much the prediction is off."""
    return f"{significant(measured)} ({round(100 * (predicted / measured - 1)):+d}%)"


def named(run):
    """A run in a few words."""
    nodes, ranks, threads, steps, quality, correction = run["case"]
    without = "" if quality == "summary" else ", unjudged" if correction else ", plain"
    return f"{nodes // 1_000_000}M, {ranks} x {threads}, K={steps}{without}"


def table_of_rates(rates, serial):
    """What was fitted."""
    stages = [" or ".join(stage for stage, _ in places) for places in TERMS.values()]
    times = [f"{significant(rate * 1e9)} ns" if rate < 1e-3 else f"{significant(rate)} s" for rate in rates]
    parts = ", ".join(f"{stage} {100 * part:.0f}%" for stage, part in serial.items())
    return f"{table(['unit', 'stage', 'time'], zip(TERMS, stages, times))}\n\nNot faster by threads: {parts}."


def table_of_times(runs, model):
    """Seconds of the stages, ranks x threads."""
    rows = []
    for run in runs:
        found = seconds(counted(run, model[2]), *model)
        rows.append([named(run), *(off(run["seconds"][key], found[key]) for key in [*STAGES, "total"])])
    return table(["s", *STAGES, "total"], rows)


def table_of_memory(runs):
    """Peaks of ranks."""
    rows = []
    for run in runs:
        (first, *others), (own, *rest) = run["megabytes"], memory(counted(run))
        rows.append([named(run), off(first, own), off(max(others), max(rest)) if others else ""])
    return table(["MB", "first rank", "largest of the others"], rows)


def table_of_messages(runs):
    """MB and numbers of messages, and by how much the count is off where it is."""
    rows = []
    for run in (run for run in runs if run["messages"]):
        found, cells = messages(counted(run)), []
        for what in PURPOSES:
            (n, of), (counts, size) = (sent.get(what, [0, 0]) for sent in (run["messages"], found))
            more, percent = round(counts - n), round(100 * (size / of - 1)) if of else 0
            wrong = (f" {percent:+d}%" if percent else "", f" {more:+d}" if more else "")
            cells.append(f"{significant(of / 1e6)}{wrong[0]} ({n:.0f}{wrong[1]})" if n else "")
        rows.append([named(run), *cells])
    return table(["MB (messages)", *PURPOSES], rows)


def prospect(like, surface, compact, model, options):
    """What a run on 1e9 nodes would cost."""
    nodes, steps, ranks = 1_000_000_000, options.outlook_steps, options.outlook_ranks
    cells = nodes + surface // 2
    size = {"nodes": nodes, "cells": cells, "surface_points": surface, "bytes_read": 24 * nodes + 41 * cells}
    case = [nodes, ranks, options.outlook_threads, steps, "summary", True]
    c = counted({**like, **size, "case": case, "steps": steps, "compact": compact})
    found, sent = seconds(c, *model[:2], math.inf), messages(c)
    # The first rank alone does this for all of them.
    compared = list(TERMS).index("place compared")
    share = model[0][compared] * units(c, "steps")[compared] / one_threaded(c, model[0])["steps"]
    disk, network = options.disk * 1e9, options.network * 1e9
    # All else goes to the first rank, or comes from it.
    found["network"] = (sum(size for _, size in sent.values()) - passed_on(c)) / network
    found["reading"] = max(found["reading"], c.F / disk)
    found["writing"] = c.written / disk
    stepping = max(found["steps"] + found["network"], found["writing"])
    whole = stepping + sum(found[stage] for stage in ("reading", "selection", "modes", "rest"))
    first, *others = memory(c)
    return {
        **{f"{stage}, s": found[stage] for stage in [*STAGES, "network"]},
        "of the steps, places compared, s": share * found["steps"],
        "whole, s (steps and network beside writing)": whole,
        "nodes that a rank evaluates, of 1 / P": c.rows * c.P / c.N,
        **{f"{what}, GB": sent[what][1] / 1e9 for what in PURPOSES},
        "first rank, GB of memory": first / 1e3,
        "largest of the others, GB of memory": max(others) / 1e3,
    }


def outlook(like, model, options):
    """1e9 nodes: by layers as in the sample, and in compact parts."""
    kinds = [(surface, compact) for surface in (17_000_000, 80_000_000) for compact in (False, True)]
    columns = [prospect(like, *kind, model, options) for kind in kinds]
    names = [f"S = {s // 1_000_000}M, {'compact' if compact else 'layers'}" for s, compact in kinds]
    return table(["", *names], [[key, *(significant(of[key]) for of in columns)] for key in columns[0]])


def report(options):
    """All tables."""
    runs, checks = medians(kept()["runs"]), kept()["checks"]
    fitted = [run for run in runs if tuple(run["case"]) in FITTED]
    threaded = next(run for run in runs if tuple(run["case"]) == THREADED)
    rates = fit(fitted)
    model = (rates, serial_parts(threaded, rates), len(os.sched_getaffinity(0)))
    both = [*fitted, threaded, *checks]
    print(f"{kept()['machine']}\n\n{table_of_rates(*model[:2])}\n\n{table_of_times(both, model)}\n")
    print(f"{table_of_memory(both)}\n\n{table_of_messages(both)}\n")
    print(outlook(max(both, key=lambda run: run["nodes"]), model, options))


def arguments():
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("--measure", action="store_true")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--check", type=int, metavar="NODES")
    parser.add_argument("--mesh", help="the mesh of --check, with its schedule beside it; else it is made")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--steps", type=int, default=2)
    parser.add_argument("--outlook-ranks", type=int, default=64)
    parser.add_argument("--outlook-threads", type=int, default=16, help="of each rank")
    parser.add_argument("--outlook-steps", type=int, default=37)
    parser.add_argument("--network", type=float, default=10, help="GB/s at the first rank")
    parser.add_argument("--disk", type=float, default=2, help="GB/s")
    return parser.parse_args()


def main():
    """Measures where that is asked for, and prints the tables."""
    options = arguments()
    KEPT.parent.mkdir(exist_ok=True)
    program = Path(options.azimesh).resolve()
    if options.measure:
        measure(program, options.rounds)
    if options.check:
        check(program, options.mesh, (options.check, options.ranks, options.threads, options.steps, "summary", True))
    report(options)


if __name__ == "__main__":
    main()
