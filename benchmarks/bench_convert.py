"""Converting one large mesh beside meshio, gmsh and pyvista: whole commands, from start to exit.

    .venv/bin/python benchmarks/bench_convert.py [--nodes 1972139] [--folder target/bench] [--rounds 1] [--limit 1200]
        [--targets vtu cgns su2]

The mesh is a rotor of tetrahedra with tagged boundaries. It goes from MSH (4.1 binary, 2.2 text) to VTU,
CGNS and SU2, and from these back to both. After every conversion the boundary tags of the new file are
counted by `azimesh info` and compared with those of the first: `names` where names and counts of faces
are kept, `faces` where only counts are, `lost` otherwise. What azimesh wrote is compared cell by cell
with its input by `azimesh diff`. A peer that cannot do a conversion is listed with its complaint, one
that takes longer than the limit with the limit.
"""

import argparse
import json
import os
import subprocess
from pathlib import Path

from measure import PYTHON, machine, significant, used

AZIMESH = "target/release/azimesh"
MESHIO_FORMAT = {"msh": "gmsh", "msh2": "gmsh22", "vtu": "vtu", "cgns": "cgns", "su2": "su2"}
TO_MSH2 = {"msh2": ["--encoding", "ascii"]}


def own(path, peer):
    """The file of a peer that answers to one of azimesh's; gmsh has no VTU, but legacy VTK."""
    path = path.with_stem(f"{path.stem}_{peer}")
    return path.with_suffix(".vtk") if peer == "gmsh" and path.suffix == ".vtu" else path


def peers(source, target):
    """{peer: Python statements that convert `source` into its own file for `target`}. Where a peer has
    made the source before, it is given its own file: it need not read what azimesh writes."""
    kind, from_kind = target.suffix[1:], source.suffix[1:]
    name, reader = MESHIO_FORMAT[kind], MESHIO_FORMAT[from_kind]
    reader = "gmsh" if reader == "gmsh22" else reader
    args = {"gmsh": ", binary=True", "gmsh22": ", binary=False"}.get(name, "")
    given = {peer: str(own(source, peer) if own(source, peer).exists() else source)
             for peer in ("meshio", "gmsh", "pyvista")}
    out = {peer: str(own(target, peer)) for peer in given}
    save = (f"m.save({out['pyvista']!r})" if kind == "vtu"
            else f"pv.save_meshio({out['pyvista']!r}, m, file_format={name!r}{args})")
    read = (f"m = pv.read({given['pyvista']!r})" if from_kind == "vtu"
            else f"m = pv.read_meshio({given['pyvista']!r}, {reader!r})")
    binary, version = (0, 2.2) if kind == "msh2" else (1, 4.1)
    return {
        "meshio": f"import meshio; m = meshio.read({given['meshio']!r}, {reader!r}); "
                  f"meshio.write({out['meshio']!r}, m, file_format={name!r}{args})",
        "gmsh": "import gmsh; gmsh.initialize(); n = gmsh.option.setNumber; n('General.Terminal', 0); "
                f"n('Mesh.Binary', {binary}); n('Mesh.MshFileVersion', {version}); "
                f"gmsh.open({given['gmsh']!r}); gmsh.write({out['gmsh']!r})",
        "pyvista": f"import pyvista as pv; {read}; {save}",
    }


def tags(path):
    """{name: faces} of the boundary tags that azimesh finds in a file; None where it cannot be read."""
    said = subprocess.run([AZIMESH, "info", "--json", path], capture_output=True, text=True)
    if said.returncode:
        return None
    return {tag["name"]: tag["faces"] for tag in json.loads(said.stdout)["boundary_tags"]}


def kept(found, wanted):
    """How much of the tags a file kept."""
    if found == wanted:
        return "names"
    same_counts = found is not None and sorted(found.values()) == sorted(wanted.values())
    return "faces" if same_counts else "lost"


def fresh(*paths):
    """Removes files that are to be written and lets the disk come to rest."""
    for path in paths:
        path.unlink(missing_ok=True)
    os.sync()


def by_azimesh(source, target, wanted, rounds):
    """Best seconds and MB of azimesh, and what it kept."""
    command = [AZIMESH, "convert", source, target, *TO_MSH2.get(target.suffix[1:], [])]
    if target.suffix == ".msh2":
        command += ["--format", "msh22"]
    runs = []
    for _ in range(rounds):
        fresh(target)
        runs.append(used(command))
    same = subprocess.run([AZIMESH, "diff", source, target], capture_output=True, text=True)
    difference = "" if same.returncode == 0 else f"; diff: {same.stdout.strip().splitlines()[-1]}"
    return min(run.seconds for run in runs), min(run.megabytes for run in runs), kept(tags(target), wanted) + difference


def by_peer(statements, target, wanted, rounds, limit):
    """The same of a peer; its complaint where it fails."""
    seconds, megabytes = [], []
    for _ in range(rounds):
        fresh(target)
        try:
            run = used(["timeout", str(limit), PYTHON, "-c", statements])
        except AssertionError as error:
            target.unlink(missing_ok=True)
            if "exit code 124" in str(error):
                return f"takes more than {limit} s"
            return f"fails: {str(error).strip().splitlines()[-1][:90]}"
        if not target.exists() or target.stat().st_size == 0:
            return "fails: it wrote nothing"
        seconds.append(run.seconds)
        megabytes.append(run.megabytes)
    return min(seconds), min(megabytes), kept(tags(target), wanted)


def compare(source, target, wanted, options):
    """One conversion by all; prints rows and returns the least ratios of time and memory."""
    print(f"\n{source.suffix[1:]} to {target.suffix[1:]}")
    seconds, megabytes, fate = by_azimesh(source, target, wanted, options.rounds)
    print(f"    {'azimesh':10}{significant(seconds):>8} s {megabytes:8.0f} MB               tags: {fate}", flush=True)
    ratios = []
    for name, statements in peers(source, target).items():
        out = own(target, name)
        found = by_peer(statements, out, wanted, options.rounds, options.limit)
        if isinstance(found, str):
            print(f"    {name:10}{found}", flush=True)
            continue
        ratios.append((found[0] / seconds, found[1] / megabytes))
        print(f"    {name:10}{significant(found[0]):>8} s {found[1]:8.0f} MB "
              f"{ratios[-1][0]:6.1f} x {ratios[-1][1]:5.1f} x  tags: {found[2]}", flush=True)
    return ratios


def main():
    """Prints a block of rows for each conversion, then the least ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1_972_139)
    parser.add_argument("--folder", type=Path, default=Path("target/bench"))
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--targets", nargs="+", choices=("vtu", "cgns", "su2"), default=["vtu", "cgns", "su2"])
    parser.add_argument("--limit", type=int, default=1200, help="seconds given to a peer")
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    first = {kind: folder / f"convert.{kind}" for kind in ("msh", "msh2")}
    used([AZIMESH, "sample", "rotor", "--nodes", options.nodes, "--cells", "tet", "-o", first["msh"], "--force"])
    used([AZIMESH, "convert", "--force", first["msh"], first["msh2"], "--format", "msh22", "--encoding", "ascii"])
    wanted = tags(first["msh"])
    sizes = ", ".join(f"{path.name} {path.stat().st_size / 1e6:.0f} MB" for path in first.values())
    print(f"{machine()}; {sizes}; tags {wanted}")
    ratios = []
    for target in (folder / f"there.{kind}" for kind in options.targets):
        for source in first.values():
            ratios += compare(source, target, wanted, options)
        for back in (folder / f"back.{kind}" for kind in first):
            ratios += compare(target, back, wanted, options)
        fresh(*folder.glob("there*"), *folder.glob("back*"))
    print(f"\nto the nearest peer: at least {min(r[0] for r in ratios):.1f} times faster, "
          f"at least {min(r[1] for r in ratios):.1f} times less memory")


if __name__ == "__main__":
    main()
