"""The JSON of every command is what docs/schema/ says: `.venv/bin/python scripts/verify schema`.

Both ways: whatever a command prints agrees with its schema, and every key of a schema but those in `NOT_SHOWN` is printed by
some run here, with a value that is not null.
"""

import json
from pathlib import Path

from jsonschema import Draft202012Validator
from program import TESTDATA, azimesh, report, scratch

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "schema"
# What no run here prints: conditions of groups of cells, for which a CGNS file would need a boundary condition on cells,
# functions that move a body, which only programs that use the library have, and cells that are neither valid nor inverted.
NOT_SHOWN = {
    ("info", ".zones[].condition"), ("info", ".other_groups[].condition"),
    ("info", ".meshes[].zones[].condition"), ("info", ".meshes[].other_groups[].condition"),
    ("run", ".functions"), ("run", ".functions[].body"), ("run", ".functions[].name"),
    ("run", ".repairs[].unproven_before"), ("run", ".companions"), ("run", ".repairs[].kernel"),
    ("deform", ".error"), ("finish", ".error"),
}  # fmt: skip
# Objects with the same keys in every schema: which are null depends on the note or the error.
ALIKE = {"diagnostics", "error", "errors"}


def keys(schema, path=""):
    """Every key of a schema by its path."""
    for branch in schema.get("anyOf", ()):
        yield from keys(branch, path)
    for key, inside in schema.get("properties", {}).items():
        yield f"{path}.{key}"
        if key not in ALIKE:
            yield from keys(inside, f"{path}.{key}")
    if schema.get("additionalProperties"):
        yield from keys(schema["additionalProperties"], f"{path}.*")
    if "items" in schema:
        yield from keys(schema["items"], f"{path}[]")


def met(value, schema, path=""):
    """The keys of a schema that have values here."""
    for branch in schema.get("anyOf", ()):
        yield from met(value, branch, path)
    for key, inside in value.items() if isinstance(value, dict) else ():
        if key in schema.get("properties", {}) and inside is not None:
            yield f"{path}.{key}"
            if key in ALIKE:
                continue
            yield from met(inside, schema["properties"][key], f"{path}.{key}")
        elif schema.get("additionalProperties"):
            yield from met(inside, schema["additionalProperties"], f"{path}.*")
    for item in value if isinstance(value, list) else ():
        yield from met(item, schema["items"], f"{path}[]")


POINT_GROUP = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
3
1 0 0 0
2 1 0 0
3 0 1 0
$EndNodes
$Elements
2
1 15 2 7 1 1
2 2 2 8 1 1 2 3
$EndElements
"""
BENT = """NDIME= 2
NELEM= 3
5 0 1 2 0
5 0 2 3 1
5 1 4 2 2
NPOIN= 5
0 0 0
1 0 1
1 1 2
0 1 3
0.8 0.5 4
NMARK= 0
"""
ONE_STEP = """<VTKFile type="Collection" version="0.1"><Collection>
<DataSet timestep="2.5" part="0" file="small.vtu"/>
</Collection></VTKFile>
"""


def runs(folder):
    """Names of schemas with what commands print."""

    def told(*arguments, expect=0):
        return arguments[0], json.loads(azimesh(*arguments, "--json", expect=expect))

    def record(path):
        return "run", json.loads(path.read_text())

    airfoil, schedule = TESTDATA / "naca0012.vtu", TESTDATA / "naca0012.toml"
    blade, bending = TESTDATA / "hart_ii.vtu", TESTDATA / "hart_ii.toml"
    out, parts, one, other = (folder / name for name in ("out", "parts", "one", "other"))

    for mesh in ("naca0012.vtu", "mixed_cells.ugrid", "cgns/sequence.cgns", "sphere_in_box_v41_binary.msh", "cgns/linked_families.cgns"):
        yield told("info", TESTDATA / mesh)
    yield told("info", TESTDATA / "vtk" / "mixed_5.1_binary.vtk")
    (folder / "point.msh").write_text(POINT_GROUP)
    yield told("info", blade, folder / "point.msh", *(TESTDATA / "cgns" / f"{name}.cgns" for name in ("sequence", "linked_families")))
    yield told("info", folder / "point.msh")
    yield "error", json.loads(azimesh("info", folder / "none.vtu", "--json", expect=2))
    yield told("convert", airfoil, folder / "n.su2")
    yield told("sample", "rotor", "--nodes", "8000", "-o", folder / "rotor.vtu")
    yield told("sample", "naca0012", "--nodes", "800", "-o", folder / "small.vtu")
    (folder / "one_step.pvd").write_text(ONE_STEP)
    yield told("convert", folder / "one_step.pvd", folder / "one_step.vtkhdf")
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
    yield from in_time(folder, told, record)
    (folder / "surface.toml").write_text(schedule.read_text() + '\n[output]\nformat = "su2"\nsurface = "su2"\ntitle = "SU2"\nlength_unit = "m"\n')
    azimesh("deform", airfoil, folder / "surface.toml", "-o", folder / "surface")
    yield record(folder / "surface" / "run.json")
    yield told("report", out)
    yield told("convert", out / "naca0012.pvd", folder / "sequence.pvd")
    yield told("quality", airfoil, "--worst", "2", *strict)
    yield told("quality", airfoil, "--fail-on", "max_skew>0", expect=1)
    yield told("quality", blade, "--worst", "2")
    yield told("quality", out, "--worst", "2", *strict, expect=1)
    yield told("diff", airfoil, folder / "n.su2")
    yield told("diff", airfoil, out / "naca0012_0009.vtu", expect=1)
    yield told("diff", out, parts)
    (folder / "other.toml").write_text(schedule.read_text().replace("sin = 10.0", "sin = 9.0"))
    azimesh("deform", airfoil, folder / "other.toml", "-o", other)
    yield told("diff", out, other, expect=1)
    yield told("completions", "bash")
    yield told("man")
    yield told("man", "-o", folder / "man")
    for path in sorted((TESTDATA / "records").glob("*.json")):
        yield record(path)


def grid(n, second):
    """A square of n by n cells as SU2; the second node of its lower side is at `second`."""
    cells = [(9, i + (n + 1) * j, i + 1 + (n + 1) * j, i + 1 + (n + 1) * (j + 1), i + (n + 1) * (j + 1)) for j in range(n) for i in range(n)]
    points = [[i / n, j / n] for j in range(n + 1) for i in range(n + 1)]
    points[1][0] = second
    text = f"NDIME= 2\nNELEM= {len(cells)}\n" + "".join(" ".join(map(str, cell)) + "\n" for cell in cells)
    return text + f"NPOIN= {len(points)}\n" + "".join(f"{x} {y}\n" for x, y in points) + "NMARK= 0\n"


def folding(folder, told, record):
    """A block that is turned too far: a run that takes substeps, one that passes over steps, and one with twist."""
    azimesh("sample", "block", "-o", folder / "block.vtu")
    text = (folder / "block.toml").read_text().replace("angle = 60.0", "angle = 100.0")
    schedules = {
        "substeps": text + '\n[output]\non_inverted = "substeps"\n',
        "repair": text,
        "warn": text + '\n[output]\non_inverted = "warn"\n',
        "stop": text + '\n[output]\non_inverted = "stop"\n',
        "twist": text.replace('method = "all"', "tolerance = 1e-3").replace("[rbf]", '[rbf]\ninterpolate = "twist"'),
    }
    for name, schedule in schedules.items():
        (folder / f"{name}.toml").write_text(schedule)
        more = ["--keep-going"] if name == "stop" else []
        mesh, base = folder / "block.vtu", folder / f"{name}_base.toml"
        yield told("deform", mesh, folder / f"{name}.toml", "-o", folder / name, *more, expect=(0, 1))
        yield record(folder / name / "run.json")
        yield told("select", mesh, folder / f"{name}.toml", "-o", base)
    folded = sorted((folder / "warn").glob("*.vtu"))[-1]
    given = ("--reference", folder / "block.vtu", "--improve", "0.2")
    yield told("repair", folded, "-o", folder / "untangled.vtu", *given)
    (folder / "bent.su2").write_text(BENT)
    yield told("repair", folder / "bent.su2", "-o", folder / "stuck.vtu", expect=1)
    (folder / "straight.su2").write_text(grid(4, 0.25))
    (folder / "passed.su2").write_text(grid(4, 0.6))
    yield told("repair", folder / "passed.su2", "--reference", folder / "straight.su2", "-o", folder / "none.vtu", expect=1)
    yield told("deform", folder / "block.vtu", folder / "stop.toml", "-o", folder / "stopped", expect=1)
    yield record(folder / "stopped" / "run.json")


def in_time(folder, told, record):
    """An airfoil that moves in time: a run that is extended, and one of parts."""
    schedule, airfoil = folder / "time.toml", TESTDATA / "naca0012.vtu"
    for stop in ("0.2", "0.3"):
        schedule.write_text(
            f'time = {{ stop = {stop}, step = 0.1 }}\nboundaries.fixed = ["farfield"]\n'
            '[[body]]\nname = "airfoil"\ntags = ["airfoil"]\nrigid.rotate = { axis = [0, 0, 1], angle = 5 }\nramp.seconds = 0.2\n'
        )
        azimesh("deform", airfoil, schedule, "-o", folder / "extended", "--resume")
    yield record(folder / "extended" / "run.json")
    for steps in ("0..2", "2..4"):
        azimesh("deform", airfoil, schedule, "-o", folder / "time_parts", "--steps", steps)
    yield told("finish", folder / "time_parts")


def main():
    """Runs the commands, and compares what they print with the schemas."""
    schemas = {path.stem: json.loads(path.read_text()) for path in FOLDER.glob("*.json")}
    n_objects, shown = 0, set(NOT_SHOWN)
    with scratch() as folder:
        for name, value in runs(folder):
            n_objects += 1
            wrong = [f"{error.json_path}: {error.message}" for error in Draft202012Validator(schemas[name]).iter_errors(value)]
            assert not wrong, f"{schemas[name]['title']}: {wrong}"
            shown.update((name, path) for path in met(value, schemas[name]))
    wanted = {(name, path) for name, schema in schemas.items() for path in keys(schema)}
    assert wanted <= shown, f"no run prints {sorted(' '.join(key) for key in wanted - shown)}"
    report("schema", len(wanted), 0, "keys", f"{n_objects} objects of {len(schemas)} kinds")
