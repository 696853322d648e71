"""Converts every .msh below a folder to MSH 4.1 and that to 2.2, and holds what gmsh reads of the copies against
what it reads of the files: nodes by tag, elements by type and node tags, physical groups.

    msh_files.py AZIMESH FOLDER

One line a file: same, refused (with the sentence, and whether gmsh reads the file), or what differs. Gmsh keeps groups
by entity, so that a version 2 file whose entity has elements in several groups is compared by its own lines; of version
2 it forgets nodes without elements. Boundary faces that are there twice, turned round, are one face in the copy.
"""

import multiprocessing
import pathlib
import subprocess
import sys
import tempfile
from collections import defaultdict


def by_gmsh(path, out):
    """Nodes, elements with their groups, and names of groups."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        gmsh.open(str(path))
    except Exception as error:
        out.put(("error", str(error)))
        return
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): tuple(coordinates[3 * i : 3 * i + 3]) for i, t in enumerate(tags)}
    elements = defaultdict(set)
    for dimension, entity in gmsh.model.getEntities():
        groups = {(dimension, int(g)) for g in gmsh.model.getPhysicalGroupsForEntity(dimension, entity)}
        for kind, ids, flat in zip(*gmsh.model.mesh.getElements(dimension, entity)):
            n = len(flat) // len(ids) if len(ids) else 1
            for i in range(len(ids)):
                elements[(int(kind), tuple(int(t) for t in flat[n * i : n * i + n]))] |= groups
    names = {(d, int(g)): gmsh.model.getPhysicalName(d, g) for d, g in gmsh.model.getPhysicalGroups()}
    out.put((nodes, dict(elements), names))


def read(path):
    """What gmsh reads, in a process of its own since it may crash."""
    queue = multiprocessing.Queue()
    process = multiprocessing.Process(target=by_gmsh, args=(path, queue))
    process.start()
    try:
        return queue.get(timeout=60)
    except Exception:
        return ("error", "gmsh crashed")
    finally:
        process.kill()


def by_lines(path):
    """Groups of the elements of a text file of version 1 or 2; None for others."""
    lines = path.read_bytes().decode(errors="replace").splitlines()
    start = next((i for i, l in enumerate(lines) if l.strip() in ("$Elements", "$ELM")), None)
    form = next((lines[i + 1].split() for i, l in enumerate(lines) if l.strip() == "$MeshFormat"), ["1", "0"])
    if start is None or form[0][0] not in "12" or form[1] != "0":
        return None
    is_old = lines[start].strip() == "$ELM"
    elements = defaultdict(set)
    for line in lines[start + 2 : start + 2 + int(lines[start + 1])]:
        words = [int(w) for w in line.split()]
        n_tags = 3 if is_old else 1 + words[2]
        group = abs(words[2] if is_old else words[3]) if n_tags > 1 else 0
        flat = (2, 3, 9, 10, 16, 20, 21, 22, 23, 24, 25, 36, 37, 38)
        dimension = {15: 0, 1: 1, 8: 1, 26: 1, 27: 1, 28: 1}.get(words[1], 2 if words[1] in flat else 3)
        elements[(words[1], tuple(words[2 + n_tags :]))] |= {(dimension, group)} if group else set()
    return dict(elements)


def difference(old, new):
    """What differs, in words; None where nothing does."""
    if old[0] == "error":
        return None if new[0] != "error" else f"gmsh does not read it: {old[1][:100]}"
    if new[0] == "error":
        return f"gmsh does not read the copy: {new[1][:100]}"
    used = {t for _, nodes in old[1] for t in nodes}
    old = ({t: p for t, p in old[0].items() if t in used}, *old[1:])
    new = ({t: p for t, p in new[0].items() if t in used}, *new[1:])
    if old[0] != new[0]:
        if set(old[0]) != set(new[0]):
            return f"node tags {len(old[0])} {len(new[0])}: {sorted(set(old[0]) ^ set(new[0]))[:5]}"
        return "coordinates " + str([(t, p, new[0][t]) for t, p in old[0].items() if p != new[0][t]][:2])
    if set(old[1]) != set(new[1]):
        merged = {(k, tuple(sorted(nodes))) for k, nodes in old[1]}
        if merged == {(k, tuple(sorted(nodes))) for k, nodes in new[1]}:
            return f"only in that {len(old[1]) - len(new[1])} faces that are there twice are one"
        return f"elements {len(old[1])} {len(new[1])}: {sorted(set(old[1]) - set(new[1]))[:2]} {sorted(set(new[1]) - set(old[1]))[:2]}"
    # Where a dimension has no group, the entities may be groups of the copy.
    grouped = {d for groups in old[1].values() for d, _ in groups}
    made = lambda groups: groups and next(iter(groups))[0] not in grouped
    wrong = [(e, g, new[1][e]) for e, g in old[1].items() if g != new[1][e] and not made(new[1][e])]
    if wrong:
        return f"groups of {len(wrong)} elements: {wrong[:2]}"
    if {k: v for k, v in old[2].items() if v} != {k: v for k, v in new[2].items() if v}:
        return f"names {sorted(set(old[2].items()) ^ set(new[2].items()))[:4]}"
    return None


def main():
    azimesh, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    count = defaultdict(int)
    for path in sorted(folder.rglob("*.msh")):
        name = str(path.relative_to(folder))
        old = read(path)
        if old[0] != "error" and (lines := by_lines(path)) is not None:
            old = (old[0], lines, old[2])
        with tempfile.TemporaryDirectory() as scratch:
            source, verdicts = path, []
            for i, (form, encoding) in enumerate([("msh", "ascii"), ("msh22", "raw")]):
                copy = pathlib.Path(scratch) / f"{i}.{'msh2' if form == 'msh22' else 'msh'}"
                run = [azimesh, "convert", str(source), str(copy), "--encoding", encoding]
                done = subprocess.run(run, capture_output=True, text=True)
                if not done.returncode:
                    copy = copy.rename(copy.with_name(f"{i}_copy.msh"))
                if done.returncode:
                    read_by = "" if old[0] == "error" else "; GMSH READS IT"
                    verdicts.append("refused: " + done.stderr.strip().splitlines()[-1].replace(str(folder), "") + read_by)
                    break
                new = read(copy)
                if new[0] != "error" and (lines := by_lines(copy)) is not None:
                    new = (new[0], lines, new[2])
                what = difference(old, new)
                if what:
                    verdicts.append(f"{form} {encoding}: {what}")
                source = copy
        verdict = "; ".join(verdicts) or ("same" if old[0] != "error" else "read, not by gmsh: " + old[1][:80])
        count[verdict.split(":")[0].split(";")[0]] += 1
        print(f"{name}\t{verdict}", flush=True)
    print(dict(count), file=sys.stderr)


if __name__ == "__main__":
    main()
