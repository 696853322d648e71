"""Reading a large OpenFOAM case beside the same mesh as CGNS and beside foamToVTK; writing the points of a step beside dd.

    .venv/bin/python benchmarks/bench_openfoam.py [--nodes 2000000] [--folder target/bench_openfoam] [--rounds 5]

Seconds are user and system time together, so that other work on the machine counts little, and runs alternate. Those of reading are asked for
when azimesh says (`-v`) that it is done; so is the memory. foamToVTK reads, and writes what is inside; it is left out where it is not
installed.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import time
from pathlib import Path

AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")
TICK = os.sysconf("SC_CLK_TCK")
HEADER = "FoamFile { version 2.0; format ascii; class dictionary; object dictionary; }\n"
CONTROL = "application none; startTime 0; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writeFormat binary;\n"
TURN = """azimuth.values = [0, 1, 2, 3, 4, 5]
boundaries.fixed = ["farfield"]
output.quality = "none"
rbf.support_radius = 1.0
selection.tolerance = 0.01
[[body]]
name = "blade"
tags = ["blade"]
cyclic = { collective = 0.0, pitch = [ { sin = 1.0 } ] }
"""


def run(*command):
    """Runs a command to its end."""
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def reading(mesh):
    """Seconds of processors and MB at the peak when azimesh has read a mesh."""
    command = [AZIMESH, "-v", "info", str(mesh)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if "reading:" in line:
                times = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
                status = dict(row.split(":", 1) for row in Path(f"/proc/{process.pid}/status").read_text().splitlines() if ":" in row)
                process.kill()
                return (int(times[11]) + int(times[12])) / TICK, int(status["VmHWM"].split()[0]) / 1024
    raise RuntimeError(f"{command} did not read")


def whole(*command):
    """Seconds of processors and MB at the peak of a command."""
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, code, used = os.wait4(process.pid, 0)
    assert code == 0, command
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def writing(case, out):
    """Wall seconds of writing a step, without waiting for the disk; nothing of memory."""
    shutil.rmtree(out, ignore_errors=True)
    schedule = out.with_suffix(".toml")
    schedule.write_text(TURN)
    run(AZIMESH, "-q", "deform", case, schedule, "-o", out, "--no-sync", "--no-space-check")
    seconds = json.loads((out / "azimesh/run.json").read_text())["seconds"]["writing"]
    return seconds / 6, 0.0


def dd(path, n_bytes):
    """Wall seconds of dd for as many bytes, without waiting for the disk."""
    path.unlink(missing_ok=True)
    start = time.perf_counter()
    run("dd", "if=/dev/zero", f"of={path}", "bs=1M", f"count={n_bytes}", "iflag=count_bytes")
    return time.perf_counter() - start, 0.0


def main():
    """Prints a line for each job."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=2_000_000)
    parser.add_argument("--folder", type=Path, default=Path("target/bench_openfoam"))
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    vtu, cgns, binary, text = folder / "r.vtu", folder / "r.cgns", folder / "binary", folder / "text"
    run(AZIMESH, "sample", "rotor", "--nodes", options.nodes, "--cells", "tet", "-o", vtu, "--force")
    run(AZIMESH, "convert", vtu, cgns, "--force")
    run(AZIMESH, "convert", vtu, binary, "--format", "openfoam", "--force")
    run(AZIMESH, "convert", vtu, text, "--format", "openfoam", "--encoding", "ascii", "--force")
    (binary / "system").mkdir(exist_ok=True)
    (binary / "system/controlDict").write_text(HEADER + CONTROL)
    (binary / "system/fvSchemes").write_text(HEADER + "divSchemes {} gradSchemes {} laplacianSchemes {}\n")
    (binary / "system/fvSolution").write_text(HEADER)
    points = binary / "constant/polyMesh/points"
    n_text = sum(path.stat().st_size for path in (text / "constant/polyMesh").iterdir())
    jobs = {
        "CGNS, read": lambda: reading(cgns),
        "binary polyMesh, read": lambda: reading(binary),
        "text polyMesh, read": lambda: reading(text),
        "points of a step, written (wall)": lambda: writing(binary, folder / "moved"),
        "dd of as many bytes (wall)": lambda: dd(folder / "dd", points.stat().st_size),
    }
    if shutil.which("foamToVTK"):
        jobs["foamToVTK"] = lambda: whole("foamToVTK", "-case", binary, "-constant", "-no-boundary", "-overwrite")
    found = {name: [] for name in jobs}
    for _ in range(options.rounds):
        for name, job in jobs.items():
            found[name].append(job())
    for name, runs in found.items():
        seconds, megabytes = [run[0] for run in runs], max(run[1] for run in runs)
        print(f"{name}: {statistics.median(seconds):.2f} s ({min(seconds):.2f} to {max(seconds):.2f}), peak {megabytes:.0f} MB")
    middle = lambda name: max(statistics.median(run[0] for run in found[name]), 1 / TICK)
    print(f"binary beside CGNS: {middle('binary polyMesh, read') / middle('CGNS, read'):.2f}")
    print(f"points beside dd: {middle('points of a step, written (wall)') / middle('dd of as many bytes (wall)'):.2f}")
    print(f"text: {n_text / 1e6:.0f} MB, {n_text / 1e6 / (middle('text polyMesh, read') / 2):.0f} MB/s on two cores")


if __name__ == "__main__":
    main()
