"""One revolution of the M427 blade at the paper's size, beside dd writing the same bytes.

    .venv/bin/python validation/m427.py [--nodes 8000000] [--steps 360] [--quality none|summary] [--batch 30]
        [--processes] [--dd-files N] [--folder target/m427] [--keep-mesh]

All steps do not fit on a disk at once, so every file is synced to the disk and deleted as soon as steps.csv
has its row. After each batch of steps azimesh is stopped (SIGSTOP; what it has written so far is synced on its
own time), the last file of the batch is read with VTK and judged against plain trigonometry, and dd writes
files of the same size (conv=fsync), as many as the batch had or N; then azimesh goes on. These pauses are not
counted. With --processes every batch is a process of its own that goes on from `azimesh select`.

Writes m427_QUALITY.json into the folder of validation/paper.py and prints a table. 8,000,000 nodes need 4 GB of
memory, 8 GB of disk, and about 20 minutes (quality none) or 30 (summary).
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyvista

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))
from measure import dd
from paper_runs import (
    AZIMESH, COLLECTIVE, CONING, FLAP_COS, FLAP_SIN, PITCH_AND_FLAP, PITCH_COS, PITCH_SIN, azimesh, deform,
    revolution, sample, schedule,
)  # fmt: skip

SUPPORT_RADIUS = 5.625
LEAST_FREE = 12  # files of one step that must find room beside what is there
UNDISTURBED = 6  # steps of the run that is never stopped


class Reference:
    """Boundary nodes of the reference mesh."""

    def __init__(self, mesh):
        grid = pyvista.read(mesh)
        tag = grid.cell_data["BoundaryTag"]
        self.volume = np.flatnonzero(tag == 0)
        self.blade, self.outer = (self.nodes(grid, tag == number) for number in (1, 2))
        self.at_blade, self.at_outer = (np.array(grid.points[nodes]) for nodes in (self.blade, self.outer))

    @staticmethod
    def nodes(grid, chosen):
        """Nodes of some cells, which are quadrilaterals."""
        starts = grid.cell_offsets[:-1][chosen]
        return np.unique(grid.cell_connectivity[starts[:, None] + np.arange(4)])

    def check(self, path, azimuth_deg):
        """A deformed mesh: how far the blade is off, whether the cylinder stayed, VTK's least scaled Jacobian."""
        grid = pyvista.read(path)
        off = np.linalg.norm(grid.points[self.blade] - moved(self.at_blade, np.radians(azimuth_deg)), axis=1).max()
        stayed = bool((grid.points[self.outer] == self.at_outer).all())
        jacobian = grid.cell_quality("scaled_jacobian").cell_data["scaled_jacobian"][self.volume]
        found = {"azimuth": azimuth_deg, "off": float(off), "stayed": stayed, "min_jacobian": float(jacobian.min())}
        assert off < 1e-9 and stayed and jacobian.min() > 0, found
        return found


def moved(points, psi):
    """Where pitch about the x axis and then flap about the hub put points of the blade."""
    pitch = np.radians(COLLECTIVE + PITCH_SIN * np.sin(psi) + PITCH_COS * np.cos(psi))
    flap = np.radians(CONING + FLAP_SIN * np.sin(psi) + FLAP_COS * np.cos(psi))
    x, y, z = points.T
    y, z = y * np.cos(pitch) - z * np.sin(pitch), y * np.sin(pitch) + z * np.cos(pitch)
    x, z = x * np.cos(flap) - z * np.sin(flap), x * np.sin(flap) + z * np.cos(flap)
    return np.stack([x, y, z], axis=1)


class Run:
    """Runs of azimesh into one folder whose files are synced and deleted as they come."""

    def __init__(self, folder, batch, between):
        self.folder, self.batch, self.between = folder, batch, between
        self.seconds = 0.0  # of azimesh and of syncing its files, pauses left out
        self.rows, self.bytes = [], 0
        self.peak = {"VmHWM": 0, "RssAnon": 0}

    def go(self, arguments, table):
        """One process, to its end."""
        started = time.monotonic()
        paused, done = 0.0, 0
        self.process = subprocess.Popen([AZIMESH, *map(str, arguments), "-q"], stderr=subprocess.PIPE)
        while True:
            code = self.process.poll()
            self.sample_memory()
            rows = read_rows(self.folder / table)
            for row in rows[done:]:
                last = self.take(row)
                if len(self.rows) % self.batch == 0:
                    paused += self.pause(last, row)
                last.unlink()
            done = len(rows)
            if code is not None:
                break
            time.sleep(0.01)
        self.seconds += time.monotonic() - started - paused
        assert code in (0, 1), self.process.stderr.read().decode()
        return json.loads((self.folder / table.replace("steps", "run").replace("csv", "json")).read_text())

    def take(self, row):
        """Syncs the file of a row."""
        path = self.folder / row["file"]
        sync(path)
        self.rows.append(row)
        self.bytes += path.stat().st_size
        return path

    def pause(self, last, row):
        """Stops the process for what comes between batches; the seconds that took."""
        self.process.send_signal(signal.SIGSTOP)
        for path in self.folder.iterdir():
            sync(path)
        started = time.monotonic()
        self.between(last, float(row["azimuth_deg"]), min(self.batch, len(self.rows)))
        seconds = time.monotonic() - started
        self.process.send_signal(signal.SIGCONT)
        return seconds

    def sample_memory(self):
        """Peak resident and anonymous memory in kB."""
        try:
            with open(f"/proc/{self.process.pid}/status") as status:
                for line in status:
                    key = line.split(":")[0]
                    if key in self.peak:
                        self.peak[key] = max(self.peak[key], int(line.split()[1]))
        except (FileNotFoundError, ProcessLookupError):
            pass


def read_rows(table):
    """Rows of steps.csv that are whole."""
    if not table.exists():
        return []
    lines = table.read_text().split("\n")[:-1]
    names = lines[0].split(",") if lines else []
    return [dict(zip(names, line.split(","))) for line in lines[1:]]


def sync(path):
    """Waits until a file is on the disk."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:  # renamed meanwhile
        return
    os.fsync(descriptor)
    os.close(descriptor)


def whole_run(options):
    """Everything that is measured, as it goes into the JSON."""
    folder = options.folder
    mesh, out = folder / "m427.vtu", folder / "out"
    surface = options.surface_nodes or options.nodes * 67 // 800
    if not (options.keep_mesh and mesh.exists()):
        sample(mesh, "--nodes", str(options.nodes), "--surface-nodes", str(surface))
    shutil.rmtree(out, ignore_errors=True)
    free, needed = shutil.disk_usage(folder).free, LEAST_FREE * mesh.stat().st_size
    assert free > needed, f"{free / 1e9:.1f} GB are free in {folder}, {needed / 1e9:.1f} GB are needed"
    text = schedule(
        PITCH_AND_FLAP, SUPPORT_RADIUS, options.tolerance, "sequence", revolution(360 / options.steps),
        quality=options.quality,
    )  # fmt: skip
    (folder / "m427.toml").write_text(text)
    reference, samples, dd_times = Reference(mesh), [], []

    def between(path, azimuth, n_files):
        samples.append(reference.check(path, azimuth))
        write = dd(folder / "dd.bin", path.stat().st_size)
        seconds = [write()[0] for _ in range(options.dd_files or n_files)]
        (folder / "dd.bin").unlink()
        dd_times.extend(seconds)
        print(f"azimuth {azimuth:g}: {samples[-1]}; dd {np.mean(seconds):.2f} s a file", flush=True)

    # The clock of a process that is stopped goes on: a step is timed in a run that never is.
    n_timed = min(UNDISTURBED, options.steps)
    part = deform(mesh, text, folder, n_timed)["seconds"]
    os.sync()
    run = Run(out, options.batch, between)
    record = go_all(run, mesh, folder, options)
    shutil.rmtree(out)
    record["seconds"] |= {"step": part["steps"] / n_timed, "write": part["writing"] / n_timed}
    return result(options, mesh, run, record, samples, dd_times)


def go_all(run, mesh, folder, options):
    """One process, or a selection and a process for each batch; the record of the run.

    For processes, "modes" is of all together and "selection" of the whole `select`.
    """
    command = ["deform", mesh, folder / "m427.toml", "-o", run.folder]
    if not options.processes:
        return run.go(command, "steps.csv")
    started = time.monotonic()
    base = folder / "chosen.toml"
    azimesh("select", mesh, folder / "m427.toml", "-o", base, "--force")
    selection, modes = time.monotonic() - started, 0.0
    run.seconds += selection
    for first in range(0, options.steps, options.batch):
        end = min(first + options.batch, options.steps)
        part = ["--base", base, "--steps", f"{first}..{end}"]
        record = run.go([*command, *part], f"steps_{first}-{end}.csv")
        modes += record["seconds"]["modes"]
    record["seconds"] |= {"selection": selection, "modes": modes}
    return record


def result(options, mesh, run, record, samples, dd_times):
    """The figures of a run by name."""
    column = lambda name: [float(row[name]) for row in run.rows if row[name]]  # noqa: E731
    assert len(run.rows) == options.steps, f"{len(run.rows)} steps of {options.steps}"
    info = json.loads(azimesh("info", mesh, "--json"))
    return {
        "quality": options.quality, "steps": options.steps, "tolerance": options.tolerance,
        "processes": -(-options.steps // options.batch) if options.processes else 1,
        "nodes": record["nodes"], "surface_points": record["surface_points"], "modes": record["modes"],
        "base_points": max(column("base_points")), "error": max(column("selection_error")),
        "surface_error": max(column("max_surface_error")), "inverted": sum(column("inverted")),
        "min_jacobian": min(column("min_scaled_jacobian"), default=None), "seconds": record["seconds"],
        "whole": run.seconds, "bytes": run.bytes, "dd": float(np.mean(dd_times)) * options.steps,
        "dd_files": len(dd_times), "peak_rss": 1024 * run.peak["VmHWM"], "peak_anonymous": 1024 * run.peak["RssAnon"],
        "mesh_file": mesh.stat().st_size, "mesh_memory": mesh_memory(info), "samples": samples,
    }  # fmt: skip


def mesh_memory(info):
    """Bytes of node positions and connectivity."""
    corners = {"hexahedron": 8, "quadrilateral": 4}
    return 24 * info["nodes"] + sum(4 * corners[kind] * n for kind, n in info["cells_by_kind"].items())


NOTES = """
The paper ran on 16 processors, azimesh on two cores. "Whole run" is one process from reading the mesh to the last file on the disk: every file is synced while the next is computed, then
deleted. dd writes files of the same size between batches of steps, while azimesh is stopped. After each batch the last mesh is read
with VTK: the blade's nodes are where plain trigonometry puts them, the cylinder's where they were, bit for bit, and no cell is
inverted. Times of a step are from a run of a few steps beside, which is never stopped; writing there does not wait for the disk.
"""


# What the paper has at 7.5e-5 m, with Algorithm 1.
AT_THIS_TOLERANCE = {"steps, evenly over the revolution": "360", "base points": "495", "selection, s": "5,261"}
PAPER = ["paper, Algorithm 1 at 7.5e-5 m", "paper at its own tolerance, Algorithms 1; 2"]


def markdown(results):
    """A table with a column a run, beside the paper's."""
    rows = [
        ("steps, evenly over the revolution", "360", lambda r: f"{r['steps']}"),
        ("base points", "592; 1,003", lambda r: f"{r['base_points']:,.0f}"),
        ("largest error before the correction, m", "", lambda r: f"{r['error']:.2e}"),
        ("selection, s", "9,637; 512", lambda r: f"{r['seconds']['selection']:.2f}"),
        ("modes, s, once", "", lambda r: f"{r['seconds']['modes']:.2f}"),
        ("a step: positions (and quality), s", "4.96", lambda r: f"{r['seconds']['step']:.3f}"),
        ("a step: writing, s, beside the next step", "", lambda r: f"{r['seconds']['write']:.3f}"),
        ("whole run, s", "1,786 and the selection", lambda r: f"{r['whole']:.0f}"),
        ("dd of the same bytes, s", "", lambda r: f"{r['dd']:.0f}"),
        ("ratio to dd", "", lambda r: f"{r['whole'] / r['dd']:.2f}"),
        ("bytes written", "", lambda r: f"{r['bytes'] / 1e9:.1f} GB"),
        ("peak memory, resident", "", lambda r: f"{r['peak_rss'] / 1e9:.2f} GB"),
        ("peak memory, anonymous", "", lambda r: f"{r['peak_anonymous'] / 1e9:.2f} GB"),
        ("resident to the mesh in memory", "", lambda r: f"{r['peak_rss'] / r['mesh_memory']:.2f}"),
        ("inverted cells, all steps", "", lambda r: f"{r['inverted']:.0f}" if r["quality"] != "none" else ""),
        (
            "least scaled Jacobian, all steps",
            "",
            lambda r: f"{r['min_jacobian']:.3f}" if r["quality"] != "none" else "",
        ),
        ("meshes read with VTK", "", lambda r: str(len(r["samples"]))),
        ("blade off by at most, m", "", lambda r: f"{max(s['off'] for s in r['samples']):.1e}"),
        (
            "least scaled Jacobian by VTK",
            "",
            lambda r: f"{min(s['min_jacobian'] for s in r['samples']):.3f}",
        ),
    ]
    header = ["", *(f"azimesh, quality {r['quality']}" for r in results), *PAPER]
    lines = [header, ["---"] * len(header)]
    lines += [[name, *(value(r) for r in results), AT_THIS_TOLERANCE.get(name, ""), paper] for name, paper, value in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main():
    """Measures one run and writes it down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=8_000_000)
    parser.add_argument("--surface-nodes", type=int, help="[default: 67 of 800 nodes]")
    parser.add_argument("--steps", type=int, default=360)
    parser.add_argument("--tolerance", type=float, default=1e-4, help="in m")
    parser.add_argument("--quality", choices=["none", "summary"], default="none")
    parser.add_argument("--batch", type=int, default=30, help="steps between samples")
    parser.add_argument("--processes", action="store_true", help="a process for each batch")
    parser.add_argument("--dd-files", type=int, help="files dd writes after a batch [default: as many as the batch]")
    parser.add_argument("--folder", type=Path, default=Path("target/m427"))
    parser.add_argument("--results", type=Path, default=Path("target/paper"))
    parser.add_argument("--keep-mesh", action="store_true", help="use the mesh of an earlier run")
    options = parser.parse_args()
    for folder in (options.folder, options.results):
        folder.mkdir(parents=True, exist_ok=True)
    measured = whole_run(options)
    (options.results / f"m427_{options.quality}.json").write_text(json.dumps(measured))
    print(markdown([measured]))


if __name__ == "__main__":
    main()
