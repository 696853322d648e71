"""The matrix of real files: read, refused with a sentence, or wrong.

    AZIMESH_TESTDATA=folder python validation/matrix --azimesh target/release/azimesh -o docs/matrix.md

Every file that INDEX.tsv of the folder lists is converted to a VTU file, which VTK reads; the same
file is read by gmsh, VTK, meshio or h5py; nodes, cells, tags and arrays of both are compared. A file that
azimesh refuses is given to the peers: one that they read must have its reason in REASONS.
Peers read in processes of their own with a time limit, since they crash on some of these files.
"""

import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

import page
from ask import PEERS
from reasons import peer_reason, reason
from workers import LIMIT_S, Workers

HERE = pathlib.Path(__file__).parent


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--azimesh", default="target/release/azimesh")
    arguments.add_argument("--testdata", default=os.environ.get("AZIMESH_TESTDATA"))
    arguments.add_argument("-o", "--output", help="page to write, docs/matrix.md")
    arguments.add_argument("--only", default="", help="part of the paths or formats to look at")
    arguments.add_argument("--cache", default="target/matrix.json", help="results by content")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count())
    asked = arguments.parse_args()
    if not asked.testdata:
        sys.exit("AZIMESH_TESTDATA or --testdata must name the folder of real files")
    folder = pathlib.Path(asked.testdata)
    with open(folder / "INDEX.tsv", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    rows = [row for row in rows if not row["format"].startswith("companion")]
    # Meshes of Fluent are compared with other programs, by matrix_fluent.py.
    rows = [row for row in rows if "Fluent" not in row["format"]]
    rows = [row for row in rows if asked.only in row["path"] or asked.only in row["format"]]
    cache = Cache(pathlib.Path(asked.cache))
    judge_one = lambda row: judge(row, folder, asked.azimesh, cache)
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        results = list(pool.map(judge_one, rows))
    cache.workers.stop()
    cache.save()
    if asked.output:
        pathlib.Path(asked.output).write_text(page.text(results))
    print(page.summary(results))
    sys.exit(any(result["verdict"] == "wrong" for result in results))


class Cache:
    """What peers said before of the same bytes: of the file, of azimesh's output, of these scripts."""

    def __init__(self, path):
        self.path = path
        self.answers = json.loads(path.read_text()) if path.exists() else {}
        self.salt = "".join(digest(HERE / name) for name in ("model.py", "ask.py", "vtk_peer.py"))
        self.lock = threading.Lock()
        self.workers = Workers()

    def ask(self, peer, path, ours):
        parts = self.salt + digest(HERE / f"{PEERS[peer][0]}.py") + peer + path.name + digest(path) + (digest(ours) if ours else "")
        key = hashlib.blake2b(parts.encode(), digest_size=12).hexdigest()
        if key not in self.answers:
            answer = self.workers.ask(peer, path, ours)
            with self.lock:
                self.answers[key] = answer
                if len(self.answers) % 50 == 0:
                    self.save()
        return self.answers[key]

    def save(self):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.answers))


def digest(path):
    return hashlib.blake2b(pathlib.Path(path).read_bytes(), digest_size=12).hexdigest()


def judge(row, folder, azimesh, cache):
    result = look_at(row, folder / row["path"], azimesh, cache)
    if result["verdict"] == "wrong":
        print(f"{row['path']} [{row['format']}]: {'; '.join(result['wrong'])}", flush=True)
    return {"path": row["path"], "format": row["format"], **result}


def look_at(row, path, azimesh, cache):
    with tempfile.TemporaryDirectory() as scratch:
        ours = os.path.join(scratch, "ours.vtu")
        try:
            run = subprocess.run([azimesh, "convert", str(path), ours], capture_output=True,
                                 text=True, errors="replace", timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            return wrong([f"azimesh has not ended after {LIMIT_S} s"])
        notes = [line.replace(f"{path.parent}/", "") for line in run.stderr.splitlines()]
        if run.returncode == 2 and len(notes) >= 1 and notes[-1].startswith("error: "):
            return refused(row, path, notes[-1].removeprefix("error: "), cache)
        if run.returncode != 0:
            return wrong([f"azimesh ended with {run.returncode}: {' '.join(notes)[-300:]}"])
        notes = [note.removeprefix("note: ").removeprefix(f"{path.name}: ") for note in notes]
        return compared(path, ours, [note for note in notes if ours not in note], cache)


def wrong(sentences, **more):
    return {"verdict": "wrong", "wrong": sentences, **more}


def compared(path, ours, notes, cache):
    """The first peer that agrees decides; one that does not is told."""
    against = []
    for peer in peers(path):
        answer = cache.ask(peer, path, ours)
        if "failed" in answer:
            against.append((peer, "fails", answer["failed"]))
        elif answer["wrong"]:
            against.append((peer, "differs", "; ".join(answer["wrong"])))
        else:
            told = [f"{peer} {what}: {said}" for peer, what, said in against]
            return {"verdict": "read", "peer": peer, "notes": notes, "remarks": answer["remarks"],
                    "against": told}
    told = [f"{peer} {what}: {said}" for peer, what, said in against]
    if any(what == "differs" for _, what, _ in against) and not peer_reason(path):
        return wrong(told, notes=notes)
    remarks = [peer_reason(path)] if peer_reason(path) else []
    return {"verdict": "read", "peer": None, "notes": notes, "remarks": remarks, "against": told}


def refused(row, path, sentence, cache):
    readers = []
    for peer in peers(path):
        answer = cache.ask(peer, path, None)
        if answer.get("cells"):
            readers.append(f"{peer} ({answer['cells']} cells)")
    why = reason(row, sentence)
    result = {"sentence": sentence, "readers": readers, "reason": why}
    if readers and why is None:
        return wrong([f"refused, but {', '.join(readers)} reads it: {sentence}"], **result)
    return {"verdict": "refused", **result}


def peers(path):
    name = path.name.removesuffix(".gz")
    if name.endswith(".msh"):
        return ["gmsh", "meshio"]
    if name.endswith(".cgns"):
        return ["h5py", "vtk", "gmsh"]
    if name.endswith(".su2"):
        return ["meshio_su2"]
    if name.endswith(".ugrid"):
        return ["meshio"]
    return ["vtk", "meshio"]


if __name__ == "__main__":
    main()
