"""Meshes, schedules and runs of azimesh, for the scripts that repeat the paper's cases."""

import csv
import json
import os
import shutil
import subprocess

AZIMESH = os.environ.get("AZIMESH", "target/release/azimesh")

# Forward flight of the M427 rotor, degrees.
COLLECTIVE, PITCH_SIN, PITCH_COS = 10.04, -7.65, -0.96
CONING, FLAP_SIN, FLAP_COS = 2.619, 3.211, -0.421

PITCH = f"cyclic = {{ collective = {COLLECTIVE}, pitch = [ {{ sin = {PITCH_SIN}, cos = {PITCH_COS} }} ] }}"
PITCH_AND_FLAP = (
    PITCH[:-2] + f", coning = {CONING}, flap = [ {{ sin = {FLAP_SIN}, cos = {FLAP_COS} }} ] }}"
)

SCHEDULE = """
[azimuth]
{azimuth}

[[body]]
name = "blade"
tags = ["blade"]
{motion}

[boundaries]
fixed = ["outer"]

[rbf]
support_radius = {radius!r}

[selection]
method = "{method}"
tolerance = {tolerance!r}
max_points = 10000
correction = {correction}

[output]
quality = "{quality}"
on_inverted = "warn"
"""


def schedule(motion, radius, tolerance, method, azimuth="values = [0]", correction=True, quality="summary"):
    """Text of a schedule for the sample `blade`."""
    return SCHEDULE.format(
        motion=motion, radius=float(radius), tolerance=float(tolerance), method=method, azimuth=azimuth,
        correction=str(correction).lower(), quality=quality,
    )  # fmt: skip


def revolution(step):
    """The azimuths of one revolution, 360 excluded, as a schedule has them."""
    return f"stop = {360 - step}\nstep = {step}"


def azimesh(*arguments, allowed=(0,)):
    """Runs azimesh quietly and returns its standard output."""
    command = [AZIMESH, *map(str, arguments), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in allowed, f"{command}: exit code {done.returncode}\n{done.stderr}"
    return done.stdout


def sample(path, *options):
    """Makes the sample `blade` at `path` and says how large it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return json.loads(azimesh("sample", "blade", *options, "-o", path, "--force", "--json"))


def quality(mesh):
    """Cell quality of a mesh."""
    return json.loads(azimesh("quality", mesh, "--json"))


COLUMNS = {
    "azimuth": "azimuth_deg",
    "base_points": "base_points",
    "displacement": "max_displacement",
    "error": "selection_error",
    "surface_error": "max_surface_error",
    "inverted": "inverted",
    "min_jacobian": "min_scaled_jacobian",
    "mean_jacobian": "mean_scaled_jacobian",
    "first_cell": "min_first_cell_ratio",
}


def deform(mesh, text, folder, steps=None):
    """Runs `azimesh deform` and returns what it wrote down of itself; the meshes are deleted.

    All steps or the first ones. Exit code 1 passes: inverted cells are told by the tables. `busy`: other work kept
    the processors from it, so that its seconds say nothing.
    """
    out, path = folder / "out", folder / "schedule.toml"
    shutil.rmtree(out, ignore_errors=True)
    path.write_text(text)
    part = ["--steps", f"0..{steps}"] if steps else []
    busy = os.getloadavg()[0] > 2 * os.cpu_count()
    try:
        azimesh("deform", mesh, path, "-o", out, *part, allowed=(0, 1))
        (record,), (table,) = out.glob("run*.json"), out.glob("steps*.csv")
        record = json.loads(record.read_text())
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
    finally:
        shutil.rmtree(out, ignore_errors=True)
    assert record["outcome"] == "complete", record["outcome"]
    columns = {name: [float(row[column] or "nan") for row in rows] for name, column in COLUMNS.items()}
    kept = ("nodes", "surface_points", "modes", "seconds", "selections")
    return columns | {"tolerance": record["options"]["tolerance"], "busy": busy} | {key: record[key] for key in kept}


def base_points(mesh, text, folder):
    """How many base points `azimesh select` takes; the tolerance must be met."""
    path, base = folder / "schedule.toml", folder / "base.toml"
    path.write_text(text)
    chosen = json.loads(azimesh("select", mesh, path, "-o", base, "--force", "--json"))
    return chosen["layers"][0]["base_points"]


def without_residuals(run):
    """The run, less the error of every base point when it was chosen."""
    for selection in run["selections"]:
        for layer in selection["layers"]:
            del layer["residuals"]
    return run
