"""Seconds, peak memory and alternating pairs, for the benchmark scripts."""

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

PYTHON = sys.executable


class Used(NamedTuple):
    """What a command took and what it printed."""

    seconds: float
    megabytes: float
    cpu_seconds: float
    said: str


def used(command):
    """What a command that must succeed takes. The peak of a process counts that of its parent when it
    was started: do not import numpy where this is called."""
    with tempfile.TemporaryFile() as said:
        started = time.monotonic()
        process = subprocess.Popen(list(map(str, command)), stdout=said, stderr=subprocess.PIPE)
        complaint = process.stderr.read().decode()
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.monotonic() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0, f"{command}: exit code {process.returncode}\n{complaint}"
        said.seek(0)
        return Used(seconds, usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime, said.read().decode())


def run(command):
    """(seconds, peak resident MB) of a command that must succeed."""
    return used(command)[:2]


def machine():
    """The processors and memory of this machine, as a phrase."""
    model = next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name"))
    gigabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    return f"{len(os.sched_getaffinity(0))} cores of an {model.split(':')[1].strip()}, {gigabytes:.0f} GB"


def significant(value, digits=3):
    """A number in as many digits, without an exponent, thousands set apart."""
    places = max(0, digits - 1 - (math.floor(math.log10(abs(value))) if value else 0))
    return f"{round(value, places):,.{places}f}"


def alternating(jobs, rounds=3):
    """Medians of {name: (seconds, MB)} over rounds in which every job runs once, in turn."""
    samples = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, job in jobs.items():
            samples[name].append(job())
    return {name: tuple(statistics.median(values) for values in zip(*runs)) for name, runs in samples.items()}


def dd(target, n_bytes):
    """A job that writes as many bytes to `target` and waits for the disk."""
    whole = f"if=/dev/zero of={target} bs=16M iflag=count_bytes count={n_bytes} conv=fsync"

    def job():
        target.unlink(missing_ok=True)
        os.sync()
        return run(["dd", *whole.split()])

    return job


def fsynced(paths):
    """Seconds that it takes until these files are on the disk."""
    started = time.monotonic()
    for path in paths:
        descriptor = os.open(path, os.O_RDONLY)
        os.fsync(descriptor)
        os.close(descriptor)
    return time.monotonic() - started


def table(rows, first="azimesh"):
    """Prints {name: (seconds, MB)} with the ratio of times to the row called `first`."""
    base = rows[first][0]
    print(f"{'':28}{'s':>9}{'peak MB':>10}{'to ' + first:>14}")
    for name, (seconds, megabytes) in rows.items():
        print(f"{name:28}{seconds:9.3f}{megabytes:10.0f}{seconds / base:14.2f}")
