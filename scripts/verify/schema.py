"""The JSON of every command, and run.json, agree with docs/schema/: `.venv/bin/python scripts/verify schema`."""

import json
from pathlib import Path

import meshes
from jsonschema import Draft202012Validator
from program import TESTDATA, azimesh, report, scratch

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "schema"
# Three triangles, the last one folded over another; all nodes are on the boundary, so that no repair is possible.
BENT = [(0, 0), (1, 0), (1, 1), (0, 1), (0.8, 0.5)], [(0, 1, 2), (0, 2, 3), (1, 4, 2)]


def runs(folder):
    """Names of schemas with what commands print."""

    def told(*arguments, expect=0):
        return arguments[0], json.loads(azimesh(*arguments, "--json", expect=expect))

    def record(path):
        return "run", json.loads(path.read_text())

    airfoil, schedule = TESTDATA / "naca0012.vtu", TESTDATA / "naca0012.toml"
    blade, bending = TESTDATA / "hart_ii.vtu", TESTDATA / "hart_ii.toml"
    out, parts, one, other = (folder / name for name in ("out", "parts", "one", "other"))

    for mesh in ("naca0012.vtu", "mixed_cells.ugrid", "cgns/sequence.cgns", "cgns/linked_families.cgns", "vtk/mixed_5.1_binary.vtk"):
        yield told("info", TESTDATA / mesh)
    yield told("info", blade, TESTDATA / "cgns" / "sequence.cgns")
    yield "error", json.loads(azimesh("info", folder / "none.vtu", "--json", expect=2))
    yield told("convert", airfoil, folder / "n.su2")
    yield told("sample", "rotor", "--nodes", "8000", "-o", folder / "rotor.vtu")
    yield told("check", airfoil, schedule)
    yield told("check", blade, bending)
    yield told("select", airfoil, schedule, "-o", folder / "base.toml")
    strict = ("--fail-on", "min_scaled_jacobian<0.75")
    yield told("deform", airfoil, schedule, "-o", out, "--tag-array", "BoundaryTag", *strict, expect=1)
    yield record(out / "run.json")
    yield told("deform", blade, bending, "-o", one, "--format", "vtkhdf")
    yield record(one / "run.json")
    for steps in ("0..20", "20..37"):
        azimesh("deform", airfoil, schedule, "-o", parts, "--steps", steps, *strict, expect=(0, 1))
    yield record(parts / "run_0-20.json")
    yield told("finish", parts, expect=1)
    yield record(parts / "run.json")
    yield from folding(folder, told, record)
    yield told("report", out)
    yield told("convert", out / "naca0012.pvd", folder / "sequence.pvd")
    yield told("quality", airfoil, "--worst", "2", *strict)
    yield told("quality", blade, "--worst", "2")
    yield told("quality", out, "--worst", "2", *strict, expect=1)
    yield told("diff", airfoil, folder / "n.su2")
    yield told("diff", airfoil, out / "naca0012_0009.vtu", expect=1)
    yield told("diff", out, parts)
    (folder / "other.toml").write_text(schedule.read_text().replace("sin = 10.0", "sin = 9.0"))
    azimesh("deform", airfoil, folder / "other.toml", "-o", other)
    yield told("diff", out, other, expect=1)
    yield told("completions", "bash")
    yield told("man", "-o", folder / "man")
    for path in sorted((TESTDATA / "records").glob("*.json")):
        yield record(path)


def folding(folder, told, record):
    """A block that is turned too far: repaired, in substeps, with twist, and with steps left out; and repairs of meshes."""
    azimesh("sample", "block", "-o", folder / "block.vtu")
    text = (folder / "block.toml").read_text().replace("angle = 60.0", "angle = 100.0")
    schedules = {name: text + f'\n[output]\non_inverted = "{name}"\n' for name in ("substeps", "repair", "warn", "stop")}
    schedules["twist"] = text.replace('method = "all"', "tolerance = 1e-3").replace("[rbf]", '[rbf]\ninterpolate = "twist"')
    for name, schedule in schedules.items():
        (folder / f"{name}.toml").write_text(schedule)
        more = ["--keep-going"] if name == "stop" else []
        yield told("deform", folder / "block.vtu", folder / f"{name}.toml", "-o", folder / name, *more, expect=(0, 1))
        yield record(folder / name / "run.json")
    yield told("select", folder / "block.vtu", folder / "twist.toml", "-o", folder / "twist_base.toml")
    folded = sorted((folder / "warn").glob("*.vtu"))[-1]
    yield told("repair", folded, "-o", folder / "untangled.vtu", "--reference", folder / "block.vtu", "--improve", "0.2")
    meshes.write_su2(folder / "bent.su2", *BENT, {})
    yield told("repair", folder / "bent.su2", "-o", folder / "stuck.vtu", expect=1)


def main():
    """Runs the commands, and compares what they print with the schemas."""
    validators = {path.stem: Draft202012Validator(json.loads(path.read_text())) for path in FOLDER.glob("*.json")}
    n_objects, seen = 0, set()
    with scratch() as folder:
        for name, value in runs(folder):
            n_objects += 1
            seen.add(name)
            wrong = [f"{error.json_path}: {error.message}" for error in validators[name].iter_errors(value)]
            assert not wrong, f"{name}: {wrong}"
    assert seen == set(validators), f"no run prints {validators.keys() - seen}"
    report("schema", n_objects, 0.0, "objects", f"of {len(seen)} kinds")
