"""What `azimesh deform` costs on ranks of MPI, by counting: arithmetic, bytes and messages. Rates come from runs
on 1 and 8 million nodes; memory and messages are counted alone. Prints tables: runs beside what is predicted, and
the outlook to 1e9 nodes.

    .venv/bin/python scripts/rank_model.py --measure [--rounds 3] [--azimesh PROGRAM]
    .venv/bin/python scripts/rank_model.py --check 60000000 --ranks 2 [--mesh MESH]
    .venv/bin/python scripts/rank_model.py --check 60000000 --ranks 1 --threads 2 [--mesh MESH]
    .venv/bin/python scripts/rank_model.py [--outlook-ranks 64 --outlook-threads 16 --network 10 --disk 2]

PROGRAM is one with the feature `mpi`. Runs are kept in target/rank_model.json: those of --measure give the
rates, those of --check are compared and nothing else. --measure takes 2 GB of memory and disk, and gives them
back; meshes are read from the page cache.
"""

import argparse
import math
import statistics
from pathlib import Path

from measure import significant
from rank_counts import ALL, FIRST, TERMS, counted, exchanged, memory, messages, passed_on
from rank_runs import CORES, FITTED, KEPT, QUIET, STAGES, THREADED, at_once, check, kept, measure, threads_of

PURPOSES = ["selection", "parts", "fields", "correction", "positions", "places", "quality", "writing"]


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


def units(c, stage, serial):
    """How many units of each term a stage has, for one thread: by Amdahl's law a part of each is not faster by more."""
    found = {}
    for what, (who, places) in TERMS.items():
        threads = {ALL: c.T, FIRST: c.alone}.get(who, 1)
        factor = serial[stage] + (1 - serial[stage]) / threads
        found[what] = factor * sum(of(c) for name, of in places if name == stage)
    return found


def fit(runs, serial):
    """Seconds a unit of each term: none below zero, least squares of relative errors."""
    import numpy as np
    from scipy.optimize import nnls

    rows, wanted = [], []
    for run in runs:
        c = counted(run, CORES)
        for stage in STAGES:
            # What takes less than 0.2 s matters less.
            weight = 1 / max(run["seconds"][stage], 0.2)
            rows.append([weight * n for n in units(c, stage, serial).values()])
            wanted.append(weight * run["seconds"][stage])
    matrix = np.array(rows, float)
    scale = matrix.max(axis=0)
    return dict(zip(TERMS, nnls(matrix / scale, np.array(wanted))[0] / scale))


def stages(c, rates, serial):
    """Seconds of each stage."""
    return {stage: sum(rates[what] * n for what, n in units(c, stage, serial).items()) for stage in STAGES}


def fitted_model(runs, threaded):
    """Rates, and the part of each stage that more threads do not make faster, from one process with several. The first
    rank of several has more threads too, so each follows from the other."""
    serial, n = dict.fromkeys(STAGES, 0.5), threaded["case"][2]
    for _ in range(20):
        rates = fit(runs, serial)
        alone = stages(counted(threaded), rates, dict.fromkeys(STAGES, 1))
        ratio = {stage: threaded["seconds"][stage] / alone[stage] for stage in STAGES}
        serial = {stage: min(1, max(0, (n * ratio[stage] - 1) / (n - 1))) for stage in STAGES}
    return rates, serial


def seconds(c, rates, serial):
    """Seconds of each stage, and of the run."""
    found = stages(c, rates, serial)
    return {**found, "total": sum(found.values()) - at_once(found, c.alone, c.K)}


# ---------------------------------------------------------------- tables


def table(head, rows):
    """In markdown."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in [head, *rows]]
    lines.insert(1, "|" + "---|" * len(head))
    return "\n".join(lines).replace("|  |", "| |").replace("|  |", "| |")


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
    who = [who for who, _ in TERMS.values()]
    where = [" or ".join(stage for stage, _ in places) for _, places in TERMS.values()]
    times = [f"{significant(rate * 1e9)} ns" if rate < 1e-3 else f"{significant(rate)} s" for rate in rates.values()]
    parts = ", ".join(f"{stage} {100 * part:.0f}%" for stage, part in serial.items())
    return f"{table(['unit', 'stage', 'by', 'time'], zip(TERMS, where, who, times))}\n\nNot faster by threads: {parts}."


def times(run, model):
    """Seconds of the stages."""
    found = seconds(counted(run, CORES), *model)
    return {f"{stage}, s": off(run["seconds"][stage], found[stage]) for stage in [*STAGES, "total"]}


def peaks(run, _):
    """Peaks of memory of ranks."""
    (first, *others), (own, *rest) = run["megabytes"], memory(counted(run))
    names = ("first rank, MB", "largest of the others, MB")
    return dict(zip(names, (off(first, own), off(max(others), max(rest)) if others else "")))


def traffic(run, _):
    """MB and numbers of messages, and by how much the count is off where it is."""
    counts, cells = messages(counted(run)), {}
    for what in PURPOSES:
        (n, of), (wanted, size) = (sent.get(what, [0, 0]) for sent in (run["messages"], counts))
        more, percent = round(wanted - n), round(100 * (size / of - 1)) if of else 0
        wrong = (f" {percent:+d}%" if percent else "", f" {more:+d}" if more else "")
        cells[f"{what}, MB (messages)"] = f"{significant(of / 1e6)}{wrong[0]} ({n:.0f}{wrong[1]})" if n else ""
    return cells


def beside(runs, of, model):
    """What runs took beside what is counted, a run a line."""
    found = [of(run, model) for run in runs]
    return table(["", *found[0]], [[named(run), *cells.values()] for run, cells in zip(runs, found)])


def table_of_checks(runs, model):
    """The same of runs that rates do not come from, a run a column."""
    found = [{**times(run, model), **peaks(run, model), **traffic(run, model)} for run in runs]
    return table(["", *map(named, runs)], [[key, *(of[key] for of in found)] for key in found[0]])


def prospect(like, surface, compact, model, options):
    """What a run on 1e9 nodes would cost."""
    nodes, steps, ranks = 1_000_000_000, options.outlook_steps, options.outlook_ranks
    cells = nodes + surface // 2
    size = {"nodes": nodes, "cells": cells, "surface_points": surface, "bytes_read": 24 * nodes + 41 * cells}
    case = [nodes, ranks, options.outlook_threads, steps, "summary", True]
    c = counted({**like, **size, "case": case, "alone": options.outlook_threads, "compact": compact})
    rates, serial = model
    found, sent = seconds(c, rates, serial), messages(c)
    disk, network = options.disk * 1e9, options.network * 1e9
    # Parts and the correction go from each rank to all; all else goes to the first rank, or comes from it.
    between = exchanged(c, "parts", "correction")
    by_first = sum(size for _, size in sent.values()) - passed_on(c) - between
    found["network"] = (by_first + 2 * between / c.P) / network
    found["reading"] = max(found["reading"], c.F / disk)
    found["writing"] = (c.F + 24 * nodes * (steps - 1)) / disk
    stepping = max(found["steps"] + found["network"], found["writing"])
    whole = stepping + sum(found[stage] for stage in ("reading", "selection", "modes", "rest"))
    first, *others = memory(c)
    return {
        **{f"{stage}, s": found[stage] for stage in [*STAGES, "network"]},
        "whole, s (steps and network beside writing)": whole,
        "nodes that a rank has, of 1 / P": c.nodes * c.P / c.N,
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


def tables(options):
    """All tables."""
    runs, checks = medians(kept()["runs"]), kept()["checks"]
    fitted = [run for run in runs if tuple(run["case"]) in FITTED]
    threaded = next(run for run in runs if tuple(run["case"]) == THREADED)
    model, both = fitted_model(fitted, threaded), [*fitted, threaded]
    found = {
        "machine": kept()["machine"],
        "times": beside(both, times, model),
        "memory": beside(both, peaks, model),
        "messages": beside([run for run in both if run["messages"]], traffic, model),
        "checks": table_of_checks(checks, model) if checks else "",
        "rates": table_of_rates(*model),
    }
    largest = max([*both, *checks], key=lambda run: run["nodes"])
    return {**found, "outlook": outlook(largest, model, options)}


def arguments(words=None):
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--azimesh", default="target/release/azimesh")
    parser.add_argument("--measure", action="store_true")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--check", type=int, metavar="NODES")
    parser.add_argument("--mesh", help="the mesh of --check, with its schedule beside it; else it is made")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1, help="of one process; ranks share the cores")
    parser.add_argument("--steps", type=int, default=2)
    parser.add_argument("--outlook-ranks", type=int, default=64)
    parser.add_argument("--outlook-threads", type=int, default=16, help="of each rank")
    parser.add_argument("--outlook-steps", type=int, default=37)
    parser.add_argument("--network", type=float, default=10, help="GB/s at the first rank")
    parser.add_argument("--disk", type=float, default=2, help="GB/s")
    return parser.parse_args(words)


def main():
    """Measures where that is asked for, and prints the tables."""
    options = arguments()
    KEPT.parent.mkdir(exist_ok=True)
    program = Path(options.azimesh).resolve()
    if options.measure:
        measure(program, options.rounds)
    if options.check:
        threads = threads_of(options.ranks) if options.ranks > 1 else options.threads
        check(program, options.mesh, (options.check, options.ranks, threads, options.steps, "summary", True))
    if kept()["runs"]:
        print("\n\n".join(filter(None, tables(options).values())))


if __name__ == "__main__":
    main()
