"""The JSON of every command is what docs/schema/ says: `.venv/bin/python scripts/verify schema`.

    .venv/bin/python scripts/verify/schema.py --update       writes docs/json.md from the schemas

Both ways: whatever a command prints agrees with its schema (JSON Schema, draft 2020-12; of it the keywords in
`Walk`), and every key of a schema but those in `NOT_SHOWN` is printed by some run here, with a value that is not null.
"""

import json
import sys
from pathlib import Path

from program import TESTDATA, azimesh, report, scratch

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "schema"
PAGE = ROOT / "docs" / "json.md"
IGNORED = {"$schema", "title", "description", "deprecated"}
KNOWN = IGNORED | {
    "type", "properties", "required", "additionalProperties", "items", "minItems", "maxItems", "minimum", "enum", "const", "oneOf",
}  # fmt: skip
TYPES = {
    "object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float), "null": type(None),
}  # fmt: skip
# What no run here prints: conditions of groups of cells, for which a CGNS file would need a boundary condition on cells,
# functions that move a body, which only programs that use the library have, and cells that are neither valid nor inverted.
NOT_SHOWN = {
    ("info", ".zones[].condition"), ("info", ".other_groups[].condition"),
    ("run", ".functions"), ("run", ".functions[].body"), ("run", ".functions[].name"),
    ("run", ".repairs[].unproven_before"), ("run", ".companions"),
}  # fmt: skip


def types(schema):
    """The types that a schema allows, or None for any."""
    found = schema.get("type")
    return [found] if isinstance(found, str) else found


def is_of(value, name):
    """Whether a value has a type of JSON; true and false are no numbers."""
    return isinstance(value, TYPES[name]) and (name in ("boolean",) or not isinstance(value, bool))


class Walk:
    """Holds values against a schema, and notes the keys that it has met with a value."""

    def __init__(self, schema):
        self.schema, self.met = schema, set()

    def check(self, value):
        """Fails where the value is not what the schema says."""
        self.at(value, self.schema, "")

    def at(self, value, schema, path):
        where = path or "the whole"
        unknown = set(schema) - KNOWN
        assert not unknown, f"{where}: the schema uses {unknown}"
        if "oneOf" in schema:
            branches = [one for one in schema["oneOf"] if set(one["required"]) <= set(value)]
            assert len(branches) == 1, f"{where}: {len(branches)} of the forms have the keys {sorted(value)}"
            self.at(value, branches[0], path)
            return
        allowed = types(schema)
        assert allowed is None or any(is_of(value, name) for name in allowed), f"{where}: {value!r} is no {allowed}"
        assert value in schema.get("enum", [value]), f"{where}: {value!r} is none of {schema.get('enum')}"
        assert value == schema.get("const", value), f"{where}: {value!r} is not {schema.get('const')}"
        if isinstance(value, dict):
            self.at_object(value, schema, path)
        elif isinstance(value, list):
            fits = schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
            assert fits, f"{where}: {len(value)} items"
            for item in value:
                self.at(item, schema["items"], f"{path}[]")
        elif "minimum" in schema and value is not None:
            assert value >= schema["minimum"], f"{where}: {value}"

    def at_object(self, value, schema, path):
        missing = set(schema.get("required", ())) - set(value)
        assert not missing, f"{path or 'the whole'}: {missing} missing"
        named, others = schema.get("properties", {}), schema["additionalProperties"]
        for key, inside in value.items():
            if key in named:
                if inside is not None:
                    self.met.add(f"{path}.{key}")
                self.at(inside, named[key], f"{path}.{key}")
            else:
                assert others, f"{path}.{key} is printed, and not in the schema"
                if others is not True:
                    self.at(inside, others, f"{path}.*")


def keys(schema, path=""):
    """Every key of a schema, with its path, schema and whether it is always there."""
    for branch in schema.get("oneOf", ()):
        yield from keys(branch, path)
    for key, inside in schema.get("properties", {}).items():
        yield f"{path}.{key}", inside, key in schema.get("required", ())
        yield from keys(inside, f"{path}.{key}")
    if isinstance(schema.get("additionalProperties"), dict):
        yield from keys(schema["additionalProperties"], f"{path}.*")
    if "items" in schema:
        yield from keys(schema["items"], f"{path}[]")


# ---------------------------------------------------------------- the runs


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
    yield told("info", airfoil, blade)
    (folder / "point.msh").write_text(POINT_GROUP)
    yield told("info", folder / "point.msh")
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


# ---------------------------------------------------------------- the page

ORDER = [
    "info", "convert", "quality", "repair", "check", "select", "deform", "finish", "diff", "report", "sample", "completions", "man", "run",
]  # fmt: skip
HEAD = """# The JSON of the commands

Every command takes `--json` and prints one object on standard output; notes, warnings and errors still go to standard error. A run
leaves one more in its folder, `run.json`.

- `version` is 1. Keys may be added without a new version. A key that gets another name keeps the old one too, marked deprecated, for
  one version of azimesh at least.
- Lengths are in the mesh's own unit, angles in degrees, times in seconds, sizes in bytes, unless a key says otherwise. Nodes, cells and
  steps count from 0.
- JSON has no infinity and no NaN: such a value is `null`.
- "Sentences" are for people and may change in any version.
- If a command fails (exit code 2 or 3), it prints no JSON. After a failed check (exit code 1) it does, also if `deform` stopped before
  its last step because the tolerance was missed or by `on_inverted = "stop"`: `outcome` has the reason then, as in `run.json`.
- `deform`, `finish` and `run.json` have the same keys for the same things.

Each table below is made from a JSON Schema (draft 2020-12) in `docs/schema/`, by `scripts/verify/schema.py --update`. The same
script, a part of `scripts/test`, runs the commands and holds what they print against the schemas, both ways.

In the tables `a[].b` is the key `b` of each item of the list `a`, and `*` stands for a key that is a name.
"""


HEADINGS = {"run": "run.json"}


def shown(schema):
    """The type of a value, in words."""
    if "const" in schema:
        return str(schema["const"])
    allowed = [name for name in types(schema) if name != "null"]
    words = {"object": "object", "array": "list", "string": "text", "boolean": "true, false"}
    name = words.get(allowed[0], allowed[0])
    if "items" in schema and types(schema["items"]):
        name += f" of {schema['minItems']}" if schema.get("minItems") == schema.get("maxItems", -1) else ""
        inner = shown(schema["items"])
        name += f" of {inner}" if inner.startswith("list") else f" of {inner}s" if "," not in inner and inner != "text" else f" of {inner}"
    return name + (" or null" if len(allowed) < len(types(schema)) else "")


def tables(schema):
    """A table of the keys of a schema; one for each form that it may have."""
    for branch in schema.get("oneOf", [schema]):
        if "oneOf" in schema:
            yield f"{branch['description'][0].upper()}{branch['description'][1:]}:"
        rows = ["| key | type | |", "|---|---|---|"]
        for path, inside, always in keys(branch):
            named = inside.get("enum")
            text = inside.get("description", "") + (": " + ", ".join(f"`{one}`" for one in named) if named else "")
            rows.append(f"| `{path[1:]}`{'' if always else ' (not always)'} | {shown(inside)} | {text} |")
        yield "\n".join(rows)


def page(schemas):
    """The text of docs/json.md."""
    parts = [HEAD.strip()]
    for name in ORDER:
        schema = schemas[name]
        parts += [f"## {HEADINGS.get(name, name)}", f"`{schema['title']}` · [schema](schema/{name}.json)", schema["description"]]
        parts += tables(schema)
    return "\n\n".join(parts) + "\n"


def main(update=False):
    """Runs the commands, holds what they print against the schemas, and the page against these."""
    schemas = {path.stem: json.loads(path.read_text()) for path in FOLDER.glob("*.json")}
    assert set(schemas) == set(ORDER), f"{set(schemas) ^ set(ORDER)}: not a command"
    walks = {name: Walk(schema) for name, schema in schemas.items()}
    n_objects = 0
    with scratch() as folder:
        for name, value in runs(folder):
            n_objects += 1
            try:
                walks[name].check(value)
            except AssertionError as error:
                raise AssertionError(f"{schemas[name]['title']}: {error}") from None
    wanted = {(name, path) for name, schema in schemas.items() for path, _, _ in keys(schema)} - NOT_SHOWN
    met = {(name, path) for name, walk in walks.items() for path in walk.met}
    assert wanted <= met, f"no run prints {sorted(' '.join(key) for key in wanted - met)}"
    text = page(schemas)
    if update:
        PAGE.write_text(text)
    assert PAGE.read_text() == text, "docs/json.md is not what the schemas say; run scripts/verify/schema.py --update"
    report("schema", len(wanted), 0, "keys", f"{n_objects} objects of {len(schemas)} kinds")


if __name__ == "__main__":
    main("--update" in sys.argv)
