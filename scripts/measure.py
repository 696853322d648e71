"""Seconds, peak memory and alternating pairs, for the benchmark scripts."""

import os
import statistics
import subprocess
import sys
import time

PYTHON = sys.executable


def run(command):
    """(seconds, peak resident MB) of a command that must succeed."""
    started = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.monotonic() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, f"{command}: exit code {process.returncode}\n{said}"
    return seconds, usage.ru_maxrss / 1024


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
