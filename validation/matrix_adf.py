"""ADF files by others, and of every kind that the CGNS library writes: the same mesh from them as from HDF5.

    python validation/matrix_adf.py FOLDER --azimesh target/release/azimesh -o docs/matrix_adf.md

FOLDER holds a folder for each repository, called owner+name. `adf2hdf` (Debian's cgns-convert) converts each of their files, and
`azimesh diff` compares both. The CGNS library (libcgns 3.4, by ctypes) copies the HDF5 files of testdata/cgns and of `--testdata` into ADF
in every version, byte order and width, in fragments, and with coordinates in a linked file: these are compared with their sources.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "testdata" / "generate"))
from adf_library import FORMS, cgns_version, copy

ROOT = pathlib.Path(__file__).parent.parent
HEAD = """# Every ADF file

CGNS files in ADF of {n_repositories} public repositories and of all their commits, as far as they differ. Each was converted to HDF5 by `adf2hdf` of the CGNS library, and
`azimesh diff` compared the two: nodes to the bit, cells, tags, arrays. `python validation/matrix_adf.py` makes this page from a folder of the
files, which are not part of the project.

{n_same} of {n} are the same.

| file | ADF | numbers | CGNS | nodes | cells | tags | beside adf2hdf |
|---|---|---|---|---|---|---|---|
"""
KINDS = """
## Every kind of ADF

Files in HDF5, copied by the CGNS library 3.4 into ADF of version A and of version B, in little and in big endian, of 32 and of 64 bits, each in one piece and
with data in up to five fragments between other nodes; and once more with the coordinates in a second file behind a link. `azimesh diff` compares each with
the file that it is a copy of.

| source | copies | the same |
|---|---|---|
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--azimesh", default="target/release/azimesh")
    arguments.add_argument("--testdata", default=os.environ.get("AZIMESH_TESTDATA"))
    arguments.add_argument("-o", "--output", type=pathlib.Path)
    asked = arguments.parse_args()
    rows, results = [], []
    with tempfile.TemporaryDirectory() as scratch:
        converted = convert_all(asked.folder, pathlib.Path(scratch))
        for path in sorted(converted):
            rows.append(row(asked.azimesh, asked.folder, path, converted[path]))
            results.append(rows[-1].split("|")[-2].strip())
            print(rows[-1], flush=True)
    n_repositories = len({path.relative_to(asked.folder).parts[0] for path in converted})
    n_same = sum(result == "same" for result in results)
    page = HEAD.format(n_repositories=n_repositories, n=len(rows), n_same=n_same) + "\n".join(rows) + "\n" + KINDS
    wrong = any("**" in result for result in results)
    for source in sources(asked.testdata):
        n, n_same = kinds(asked.azimesh, source)
        page += f"| {shown(source, asked.testdata)} | {n} | {n_same} |\n"
        print(page.splitlines()[-1], flush=True)
        wrong |= n_same != n
    if asked.output:
        asked.output.write_text(page)
    sys.exit(wrong)


def convert_all(folder, scratch):
    """The ADF files of the folder with their copies in HDF5, or why there is none."""
    converted = {}
    for path in filter(pathlib.Path.is_file, folder.rglob("*")):
        copied = scratch / path.relative_to(folder)
        copied.parent.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["adf2hdf", path, copied], capture_output=True, text=True)
        converted[path] = copied if copied.exists() and not done.returncode else done.stderr.strip()
    return converted


def row(azimesh, folder, path, other):
    head = path.read_bytes()[:102].decode("latin1")
    order = {"L": "little", "B": "big"}[head[100]]
    numbers = f"{order} endian, {64 if head[101] == 'B' else 32} bits"
    owner, *rest = path.relative_to(folder).parts
    name = "/".join([owner.replace("+", "/"), *rest])
    found = subprocess.run([azimesh, "info", "--json", path], capture_output=True, text=True)
    if found.returncode:
        told = found.stderr.strip().splitlines()[-1].replace(str(path), path.name).removeprefix("error: ").replace("|", "\\|")
        by_library = other if isinstance(other, str) else same_error(azimesh, other)
        return f"| {name} | {head[25:31]} | {numbers} | | | | | refused: {told} ({by_library}) |"
    info = json.loads(found.stdout)
    if isinstance(other, str):
        result = f"**adf2hdf fails**: {other}"
    else:
        result = compared(azimesh, path, other)
    return f"| {name} | {head[25:31]} | {numbers} | {cgns_version(path)} | {info['nodes']} | {info['cells']} | {len(info['boundary_tags'])} | {result} |"


def same_error(azimesh, other):
    found = subprocess.run([azimesh, "info", other], capture_output=True, text=True)
    return "as is its copy in HDF5" if found.returncode else "**its copy in HDF5 is read**"


def compared(azimesh, one, other):
    done = subprocess.run([azimesh, "diff", "-q", one, other], capture_output=True, text=True)
    return "same" if done.returncode == 0 else f"**wrong**: {(done.stdout + done.stderr).strip()[-300:]}"


def sources(testdata):
    """HDF5 files of CGNS."""
    folders = [ROOT / "testdata" / "cgns", *([pathlib.Path(testdata)] if testdata else [])]
    for folder in folders:
        for path in sorted(folder.rglob("*.cgns")):
            is_left_out = path.name in ("linked_grid.cgns", "odd_parts.cgns") or path.stat().st_size > 3_000_000
            if path.read_bytes()[1:4] == b"HDF" and not is_left_out:
                yield path


def shown(path, testdata):
    for folder in filter(None, [testdata, ROOT]):
        if path.is_relative_to(folder):
            return path.relative_to(folder)
    return path


def kinds(azimesh, source):
    """How many copies there are, and how many of them are the same mesh."""
    same = []
    with tempfile.TemporaryDirectory() as scratch:
        for form in FORMS:
            for is_old in (False, True):
                for fragments, linked in ((1, None), (5, None), (3, "grid_of_copy.cgns")):
                    path = pathlib.Path(scratch) / "copy.cgns"
                    copy(source, path, form, is_old, fragments, linked)
                    same.append(compared(azimesh, path, source))
                    if same[-1] != "same":
                        print(source, form, is_old, fragments, linked, same[-1])
    return len(same), same.count("same")


if __name__ == "__main__":
    main()
