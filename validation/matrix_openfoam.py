"""Cases of OpenFOAM by others: read by azimesh, by VTK's reader and by OpenFOAM's foamToVTK, compared point by point and face by face.

    python validation/matrix_openfoam.py FOLDER --azimesh target/release/azimesh -o docs/matrix_openfoam.md

FOLDER holds the cases, and SOURCES.tsv with the name of each of its folders and the repository that it is of. Compared are the mesh at its first time
and, where there are several, at the last one. VTK is told the width of labels, which it does not find out; for foamToVTK it is written into
the headers of a copy, with the version where a header has none. foamToVTK is left out where OpenFOAM is not installed.
"""

import argparse
import csv
import pathlib
import re
import shutil
import sys
import tempfile

import pyvista

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts" / "verify"))
HEAD = """# Every OpenFOAM case

Cases of {n} public repositories, each read by azimesh and by VTK's reader (`vtkPOpenFOAMReader`), and compared: points to the bit (VTK has
them in 32 bits; those of 64 bits are read from the file), cells face by face, patches and cell zones face by face, at the first time and
at the last. Zones of 64-bit labels are left out, since VTK takes them for 32 bits.
The last column is a comparison with OpenFOAM's own `foamToVTK` (v1912) at the same times: points in 32 bits, each cell with its kind and its faces,
the faces of each patch.
`python validation/matrix_openfoam.py` makes this page from a folder of the cases, which are not part of the project.

| case | stored as | points | cells | patches | times | VTK | foamToVTK |
|---|---|---|---|---|---|---|---|
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--azimesh")
    arguments.add_argument("-o", "--output", type=pathlib.Path)
    asked = arguments.parse_args()
    import program

    program.AZIMESH = asked.azimesh or program.AZIMESH
    with open(asked.folder / "SOURCES.tsv", newline="") as file:
        sources = dict(csv.reader(file, delimiter="\t"))
    rows = []
    for name, source in sorted(sources.items(), key=lambda row: row[1].lower()):
        for mesh in meshes(asked.folder / name):
            rows.append((source, row(asked.folder / name, mesh, source)))
            print(rows[-1][1], flush=True)
    if asked.output:
        text = HEAD.format(n=len({source for source, _ in rows})) + "".join(f"{line}\n" for _, line in rows)
        asked.output.write_text(text)
    sys.exit(any("**wrong**" in line for _, line in rows))


def meshes(folder):
    """The polyMesh folders that a case begins with, without pieces of decomposed cases."""
    for faces in sorted(folder.rglob("constant/**/polyMesh/faces*")):
        inside = faces.relative_to(folder).parts
        if faces.name in ("faces", "faces.gz") and not any(part.startswith("processor") for part in inside):
            yield faces.parent


def row(folder, mesh, source):
    parts = mesh.parts
    at = len(parts) - 1 - parts[::-1].index("constant")
    case, region = pathlib.Path(*parts[:at]), "/".join(parts[at + 1 : -1]) or None
    name = "/".join([source, *case.relative_to(folder).parts, *([region] if region else [])])
    times = sorted((path.parts[at] for path in case.glob(f"*/{region + '/' if region else ''}polyMesh/points*")
                    if re.fullmatch(r"[\d.e-]+", path.parts[at])), key=float)  # fmt: skip
    found = outcome(case, mesh, region, times)
    seen = [found.get(key, "") for key in ("points", "cells", "tags")]
    beside = by_foam_to_vtk(mesh, case, region, times, found.get("wide", False))
    return f"| {name} | {stored(mesh)} | {' | '.join(map(str, seen))} | {len(times) or ''} | {found['result']} | {beside} |"


def by_foam_to_vtk(mesh, case, region, times, is_wide):
    """Whether foamToVTK makes the same of the first and the last time."""
    import foam_to_vtk

    if not (foam_to_vtk.ETC.exists() and shutil.which("foamToVTK")):
        return ""
    of_region = ["-region", region] if region else []
    has_start = times and float(times[0]) <= 0
    wanted = [(0 if times else None, ["-time", times[0]] if has_start else ["-constant", "-time", "0"])]
    if times:
        wanted.append((None, ["-time", times[-1]]))
    points = 0
    try:
        for step, chosen in wanted:
            with tempfile.TemporaryDirectory() as scratch:
                copy = pathlib.Path(scratch) / "case"
                foam_to_vtk.dictionaries(copy)
                if region:
                    shutil.copytree(copy / "system", copy / "system" / region)
                for instance in ["constant", *(times if step is None or has_start else [])]:
                    folder = case / instance / (region or "") / "polyMesh"
                    if folder.is_dir():
                        copied = copy / instance / (region or "") / "polyMesh"
                        shutil.copytree(folder, copied)
                        complete_headers(copied, is_wide)
                path = mesh if region and not times else case / "constant" / region if region else case
                out = pathlib.Path(scratch) / "ours.vtu"
                points += foam_to_vtk.compare(copy, out, path, step, chosen + of_region)[0]
    except AssertionError as error:
        words = " ".join(str(error).replace(str(case), "").split()).replace("|", "/")
        return f"**wrong**: {words[-300:]}"
    return "same, labels of 64 bits told" if is_wide else "same"


def complete_headers(folder, is_wide):
    """Writes into the headers what v1912 wants and others leave out: the version, and that labels have 64 bits."""
    for path in filter(pathlib.Path.is_file, folder.iterdir()):
        data = path.read_bytes()
        if data[:2] == b"\x1f\x8b":
            continue
        if not re.search(rb"\bversion\s+[\d.]+;", data[:1500]):
            data = re.sub(rb"(FoamFile\s*\{)", rb"\1 version 2.0;", data, count=1)
            path.write_bytes(data)
        if is_wide and b"arch" not in data[:1000]:
            path.write_bytes(re.sub(rb"(format\s+binary;)", rb'\1 arch "LSB;label=64;scalar=64";', data, count=1))


def stored(mesh):
    """How the faces are stored, as their header says."""
    import gzip

    packed = mesh / "faces.gz"
    data = gzip.decompress(packed.read_bytes()) if packed.exists() else (mesh / "faces").read_bytes()
    header = data[:2000].decode("latin1")
    word = lambda key: (re.search(rf"\b{key}\s+(\w+);", header) or ["", ""])[1]
    return ", ".join([word("format"), word("class")] + (["gzip"] if packed.exists() else []))


def outcome(case, mesh, region, times):
    """What was compared, and whether it is the same."""
    path = mesh if region else case
    several = bool(times)
    try:
        # Without a folder 0, VTK has no mesh of constant.
        if not several or (case / "0").exists():
            found = compared(case, path, region, 0 if several else None, 0.0)
        if several:
            last = case / times[-1] / (region or "") / "polyMesh" / "points"
            found = compared(case, path, region, -1, float(times[-1]), last)
        wide = ", labels of 64 bits" if found["wide"] else ""
        return found | {"result": f"same as VTK{wide}"}
    except AssertionError as error:
        words = " ".join(str(error).replace(str(case), "").split()).replace("|", "/")
        return {"result": f"**wrong**: {words[:300]}"}


def without_wide_zones(read):
    """VTK's reader, but without zones of 64-bit labels."""

    def reader(*arguments, **named):
        found = read(*arguments, **named)
        is_zone = lambda name: "cellZones" in name.split("/")[:-1]
        return {name: block for name, block in found.items() if not (named.get("long_labels") and is_zone(name))}

    return reader


def compared(case, path, region, step, time, points=None):
    """What `foam.compare` says, with labels of 32 bits or else of 64; the first failure where both fail."""
    import foam

    chosen = {} if region is None else {"region": region}
    points = points or case / "constant" / (region or "") / "polyMesh" / "points"
    is_last = step == -1
    read, failed = foam.by_vtk, []
    foam.by_vtk = without_wide_zones(read)
    with tempfile.TemporaryDirectory() as scratch:
        out = pathlib.Path(scratch) / "ours.vtu"
        told = {"step": None if is_last else step, "points": points, "time": time if is_last else 0.0, **chosen}
        try:
            for wide in (False, True):
                try:
                    return foam.compare(case, path, out, long_labels=wide, **told) | {"wide": wide}
                except (AssertionError, KeyError, StopIteration, ValueError) as error:
                    failed.append(error)
        finally:
            foam.by_vtk = read
    raise AssertionError(" / ".join(f"{type(error).__name__} {error}" for error in failed))


if __name__ == "__main__":
    main()
