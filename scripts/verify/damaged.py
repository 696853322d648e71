"""Tables and schedules damaged at random: exit 2, one error with its file and line, and nothing written.

    CASES   how many are damaged (200)
    SEED    where chance begins
    SHOW    1 prints every error
"""

import os
import random
import re
import subprocess

import pyvista

from program import AZIMESH, TESTDATA, report, scratch

CASES = int(os.environ.get("CASES", "200"))
SEED = int(os.environ.get("SEED", "20261128"))
HEAD = 'time = { stop = 2, step = 1, frequency = 0.5 }\nboundaries.others = "fixed"\nselection.tolerance = 0.05\noutput.length_unit = "m"\n'
BODY = '[[body]]\nname = "ball"\ntags = ["sphere"]\n'
TURNS = {
    "euler_xzy": ("rot_x_deg,rot_y_deg,rot_z_deg", "1,2,3", "4,-5,6", "2,0,1"),
    "vector": ("rot_x_rad,rot_y_rad,rot_z_rad", "0,0,0.1", "0.1,0.2,0", "0,0,0"),
    "quaternion": ("quat_w,quat_x,quat_y,quat_z", "1,0,0,0", "0.8,0.6,0,0", "-1,0,0,0"),
    "wiener_milenkovic": ("wm_x,wm_y,wm_z", "0,0,0.1", "0.1,0.2,0", "0,0,0"),
}
JUNK = ["x", "NaN", "inf", "1e999", "", "0,5", "1.2.3", "--1", "\0", "ß", '"', "#", "1e400", "-"]
VALUES = ["-1", "0", '"x"', "[]", "{}", "true", "nan", "1e999", '""', "[1, 2]", "2024-01-01", '"vectr"', "{ x = 1 }", "9" * 30]


def good(points, nodes):
    """(schedule, files) that are right, in many ways."""
    for form, (names, *turns) in TURNS.items():
        rows = "".join(f"{i},0,0.0{i},{turn}\n" for i, turn in enumerate(turns))
        keys = f'rotation = "{form}", interpolation = "cubic"'
        yield f'{BODY}ramp = {{ steps = 2 }}\ntable = {{ file = "m.csv", {keys} }}\n', {"m.csv": f"time_s,dx,dy,{names}\n{rows}"}
        rows = "".join(f"{i},{r},0,0.0{i},{turn}\n" for i, turn in enumerate(turns) for r in (-1, 1))
        beam = f'beam = {{ table = "m.csv", lifting_line = "l.csv", {keys} }}\n'
        yield BODY + beam, {"m.csv": f"time_s,station,dx,dy,{names}\n{rows}", "l.csv": "station,x,y,z\n-1,-1,0,0\n1,1,0,0\n"}
    fast = "made by a program\nwith others; and options\n\nTime \tSurge \tPitch \tPower\n(s) \t(mm) \t(deg) \t(kW)\n"
    fast += "".join(f"{i}.0\t {10 * i}.5\t {i}\t 7\n" for i in range(3))
    columns = 'columns = { time_s = "Time", dx = "Surge", rot_y_deg = "-Pitch" }'
    yield f'{BODY}ramp = {{ seconds = 0.5 }}\ntable = {{ file = "m.out", {columns}, units = {{ dx = 0.001, time_s = "s" }} }}\n', {"m.out": fast}
    foam = "3\n(\n(0 ((0 0 0) (0 0 0)))\n(1 ((0.01 0 0) (0 0 5)))\n(2 ((0 0 0) (0 0 0)))\n)\n"
    yield f'{BODY}table = {{ file = "m.dat", origin = [0.1, 0, 0] }}\n', {"m.dat": foam}
    some = nodes[::7]
    rows = "".join(f"{t};{points[n][0]};{points[n][1]};{points[n][2]};{t / 100};0,01;0\n" for t in range(3) for n in some)
    columns = 'columns = { x = "X", y = "Y", z = "Z", dx = "U", dy = "V", dz = "W" }, units = { dx = "m", x = 1.0 }'
    surface = f'{BODY}surface = {{ file = "m.csv", map = "rbf", interpolation = "linear", {columns} }}\n'
    yield surface, {"m.csv": f"time_s;X;Y;Z;U;V;W\n{rows}"}
    moved = lambda by: "".join(f"{n} {points[n][0] + by} {points[n][1]} {points[n][2]}\n" for n in nodes)  # noqa: E731
    yield f'{BODY}surface.file = "m_*.dat"\n', {f"m_0000{i}.dat": moved(i / 100) for i in range(3)}
    zones = 'rigid = { ramp = true, rotate = { axis = [0, 0, 1], angle = 5 } }\n'
    yield f'[[body]]\nname = "all"\nzones = ["*"]\n{zones}', {}


def in_table(rng, text):
    """A table with one thing wrong, most of the time."""
    lines = text.splitlines()
    at = rng.randrange(len(lines))
    parts = re.split(r"([,;\t ]+)", lines[at])
    field = 2 * rng.randrange((len(parts) + 1) // 2)
    change = rng.randrange(9)
    if change == 0:
        parts[field] = rng.choice(JUNK)
    elif change == 1:
        del parts[field : field + 2]
    elif change == 2:
        parts[field] += rng.choice(["x", "1", ",", ";", '"', ")"])
    elif change == 3:
        return "\n".join(lines[:at] + lines[at + 1 :]) + "\n"
    elif change == 4:
        return "\n".join(lines[: at + 1] + lines[at:]) + "\n"
    elif change == 5:
        return text[: rng.randrange(len(text))]
    elif change == 6:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
        return "\n".join(lines) + "\n"
    elif change == 7:
        where = rng.randrange(len(text))
        return text[:where] + rng.choice(JUNK + ["(", ")", "\n", "%"]) + text[where + 1 :]
    else:
        parts[field] = parts[field].replace("0", "7").replace("_", "-").replace("e", "")
    lines[at] = "".join(parts)
    return "\n".join(lines) + "\n"


def in_schedule(rng, text):
    """A schedule with one thing wrong, most of the time."""
    change = rng.randrange(5)
    key = rng.choice(list(re.finditer(r"\b[a-z_]+(?= ?=)", text)))
    value = rng.choice(list(re.finditer(r'"[^"]*"|(?<![\w.])-?\d[\d.]*|true', text)))
    if change == 0:
        name = key.group()
        name = name[:-1] if len(name) > 2 else name + "x"
        return text[: key.start()] + name + text[key.end() :]
    if change == 1:
        return text[: value.start()] + rng.choice(VALUES) + text[value.end() :]
    if change == 2:
        return text[: rng.randrange(len(text))]
    if change == 3:
        at = rng.randrange(len(text))
        return text[:at] + rng.choice(["[", '"', "=", "\n", "}", "x", "\0"]) + text[at + 1 :]
    lines = text.splitlines()
    at = rng.randrange(len(lines))
    return "\n".join(lines[:at] + lines[at + 1 :]) + "\n"


def main():
    """Every damaged input is refused in one sentence, or is still right."""
    rng = random.Random(SEED)
    mesh = (TESTDATA / "sphere_in_box_raw_zlib.vtu").resolve()
    grid = pyvista.read(mesh)
    tag = list(grid.field_data["BoundaryTagNames"]).index("sphere") + 1
    cells = [grid.get_cell(i).point_ids for i in range(grid.n_cells) if grid.cell_data["BoundaryTag"][i] == tag]
    cases = list(good(grid.points.tolist(), sorted({node for cell in cells for node in cell})))
    program = os.path.abspath(AZIMESH)
    refused = right = 0
    wrong = []
    with scratch() as top:
        for case in range(len(cases) + CASES):
            folder = top / str(case)
            folder.mkdir()
            text, files = cases[case] if case < len(cases) else rng.choice(cases)
            text, files = HEAD + text, dict(files)
            if case >= len(cases):
                name = rng.choice(["s.toml", *files, *files])
                if name == "s.toml":
                    text = in_schedule(rng, text)
                else:
                    files[name] = in_table(rng, files[name])
            (folder / "s.toml").write_bytes(text.encode())
            for name, content in files.items():
                (folder / name).write_bytes(content.encode())
            before = sorted(os.listdir(folder))
            command = [program, "-q", "deform", mesh, "s.toml", "-o", "out"]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
            told = f"case {case}: exit {done.returncode}\n{done.stderr}\n{text}"
            if done.returncode in (0, 1):
                right += case >= len(cases)
                continue
            # What the whole schedule lacks has no line.
            has_place = re.fullmatch(r"error: ((s\.toml|m\w*\.\w+|l\.csv):[1-9]\d*: \S|s\.toml: the schedule ).*\n", done.stderr)
            if case < len(cases) or done.returncode != 2 or not has_place or sorted(os.listdir(folder)) != before:
                wrong.append(told)
            if os.environ.get("SHOW"):
                print(f"{case}: {done.stderr}", end="")
            refused += 1
    assert not wrong, "\n".join(wrong)
    report("damaged", refused, 0, "damaged inputs", f"{right} were still right")
