"""A power cut at random moments of `deform`: what the disk holds then names no file that is short, and the run is
resumed to the bytes of one that nobody stopped.

strace lists every call that changes a file or a folder, with its bytes. From that list a disk is made as a power cut
may leave it: what was synced is there; of what was not, nothing, or a random part: some of the writes to a file, the
last one torn between two sectors, and the first of the changes of names in a folder.
"""

import random
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass

import numpy as np

import outputs
from program import report, scratch
from sequences import FORMATS, SEED, TIMES, case, command, steps_of

NODES = 700
SECTOR = 512
CALLS = (
    "openat,close,dup,fcntl,write,pwrite64,lseek,ftruncate,rename,renameat,renameat2,link,unlink,unlinkat,mkdir,"
    "rmdir,fsync,fdatasync,copy_file_range,writev,sendfile,fallocate,linkat"
)
LINE = re.compile(r"([\d.]+) (\w+)\((.*)\) += (-?\d+).*<([\d.]+)>$")
STRING = re.compile(r'"((?:\\x[0-9a-f]{2})*)"')


@dataclass
class Call:
    """A call that succeeded, and when it began and ended."""

    start: float
    end: float
    name: str
    text: str
    result: int

    def strings(self):
        """The bytes of its quoted arguments."""
        return [bytes.fromhex(found.replace("\\x", "")) for found in STRING.findall(self.text)]

    def number(self, at):
        """The argument at a place, counted from behind where negative; for calls without strings before it."""
        return int(self.text.split(", ")[at])


class Node(list):
    """A file: writes as (end of the call, offset, bytes), cuts as (end, length, None), syncs as (end, "synced", start)."""


class Folder(list):
    """Changes of names, as (end of the call, name, node or folder or None where the name goes), and syncs."""


def traced(arguments, folder):
    """The calls of a run, in the order in which they ended."""
    prefix = folder / "trace"
    strace = ["strace", "-ff", "-o", prefix, "-ttt", "-T", "-xx", "-s", "1000000000", "-e", f"trace={CALLS}"]
    subprocess.run([*strace, *arguments], check=True, stderr=subprocess.DEVNULL)
    calls = []
    for path in folder.glob("trace.*"):
        for line in path.read_text().splitlines():
            found = LINE.match(line)
            if found and int(found[4]) >= 0:
                start = float(found[1])
                calls.append(Call(start, start + float(found[5]), found[2], found[3], int(found[4])))
        path.unlink()
    return sorted(calls, key=lambda call: call.start if call.name == "close" else call.end)


class Disk:
    """All that happened to files below a folder."""

    def __init__(self, root, calls):
        self.root = str(root)
        self.folders = {self.root: Folder()}
        self.nodes = {}
        self.open = {}
        self.ends = []
        for call in calls:
            getattr(self, f"on_{call.name}", self.refuse)(call)

    def refuse(self, call):
        """A call that this disk knows nothing of."""
        raise NotImplementedError(f"{call.name}({call.text[:200]}")

    def is_ours(self, path):
        return path.startswith(self.root + "/")

    def change(self, path, node, call):
        """A name now stands for another node, or none."""
        folder, name = path.rsplit("/", 1)
        self.folders[folder].append((call.end, name, node))
        self.nodes[path] = node
        self.ends.append(call.end)

    def on_openat(self, call):
        path = call.strings()[0].decode()
        if path in self.folders:
            self.open[call.result] = (self.folders[path], None, False)
        elif self.is_ours(path):
            if self.nodes.get(path) is None:
                self.change(path, Node(), call)
            node = self.nodes[path]
            if "O_TRUNC" in call.text:
                node.append((call.end, 0, None))
            self.open[call.result] = (node, [0], "O_APPEND" in call.text)
        else:
            self.open.pop(call.result, None)

    def on_close(self, call):
        self.open.pop(call.number(0), None)

    def on_fcntl(self, call):
        if "F_DUPFD" in call.text and call.number(0) in self.open:
            self.open[call.result] = self.open[call.number(0)]

    def on_lseek(self, call):
        if call.number(0) in self.open:
            self.open[call.number(0)][1][0] = call.result

    def on_write(self, call):
        file = int(call.text.split(", ", 1)[0])
        if file not in self.open:
            return
        node, at, appends = self.open[file]
        if appends:
            at[0] = len(content(node))
        node.append((call.end, at[0], call.strings()[0][: call.result]))
        at[0] += call.result
        self.ends.append(call.end)

    def on_ftruncate(self, call):
        if call.number(0) in self.open:
            self.open[call.number(0)][0].append((call.end, call.number(1), None))
            self.ends.append(call.end)

    def on_fsync(self, call):
        if call.number(0) in self.open:
            self.open[call.number(0)][0].append((call.end, "synced", call.start))
            self.ends.append(call.end)

    on_fdatasync = on_fsync

    def on_rename(self, call):
        source, target = (text.decode() for text in call.strings())
        if self.is_ours(target):
            assert source.rsplit("/", 1)[0] == target.rsplit("/", 1)[0], f"from one folder to another: {source}"
            # One change: no disk has a file under both names, or under none.
            self.change(target, self.nodes[source], call)
            folder = self.folders[target.rsplit("/", 1)[0]]
            folder[-1] += (source.rsplit("/", 1)[1],)
            self.nodes[source] = None

    def on_unlink(self, call):
        path = call.strings()[0].decode()
        if self.is_ours(path):
            self.change(path, None, call)

    def on_mkdir(self, call):
        path = call.strings()[0].decode()
        if self.is_ours(path):
            self.folders[path] = Folder()
            self.change(path, self.folders[path], call)

    def left(self, moment, chance):
        """Files by their paths as a power cut may leave them; `chance` keeps some of what was not synced, if given."""
        contents, files = {}, {}

        def names(folder, path):
            standing = {}
            for _, name, node, *source in survivors(folder, moment, chance, in_order=True):
                for gone in source:
                    standing.pop(gone, None)
                standing[name] = node
            for name, node in standing.items():
                if isinstance(node, Folder):
                    names(node, f"{path}{name}/")
                elif node is not None:
                    if id(node) not in contents:
                        contents[id(node)] = content(survivors(node, moment, chance))
                    files[path + name] = contents[id(node)]

        names(self.folders[self.root], "")
        return files


def survivors(changes, moment, chance, in_order=False):
    """Changes that a power cut at a moment leaves: all that were synced, and some of the others."""
    happened = [change for change in changes if change[0] <= moment]
    synced = max((change[2] for change in happened if change[1] == "synced"), default=0.0)
    happened = [change for change in happened if change[1] != "synced"]
    safe = [change for change in happened if change[0] <= synced]
    others = happened[len(safe) :]
    if chance is None or not others:
        return safe
    if in_order:
        return safe + others[: chance.randrange(len(others) + 1)]
    kept = [change for change in others if chance.random() < 0.7]
    if kept and kept[-1][2] is not None and chance.random() < 0.5:
        end, at, data = kept[-1]
        # Disks write whole sectors.
        torn = (at + chance.randrange(len(data) + 1)) // SECTOR * SECTOR - at
        kept[-1] = (end, at, data[: max(torn, 0)])
    return safe + kept


def content(changes):
    """The bytes of a file after its changes."""
    data = bytearray()
    for _, at, written in changes:
        if at == "synced":
            continue
        if written is None:
            data = data[:at].ljust(at, b"\0")
        else:
            data = data.ljust(at, b"\0")
            data[at : at + len(written)] = written
    return bytes(data)


def rows_of(folder):
    """The whole rows of steps.csv: step -> file."""
    path = folder / "steps.csv"
    lines = path.read_bytes().split(b"\n")[:-1] if path.exists() else []
    rows = [line.decode(errors="replace").split(",") for line in lines]
    return {int(row[0]): row[3] for row in rows[1:] if len(row) == len(rows[0]) and row[0].isdigit()}


def short(folder, name, whole, wanted):
    """What is wrong with the files that stand under final names; empty where nothing is."""
    rows = rows_of(folder)
    if name == "vtu":
        files = {path.name for path in folder.glob("mesh_*.vtu")} | set(rows.values())
        same = (lambda file: (folder / file).exists() and (folder / file).read_bytes() == (whole / file).read_bytes())
        return [file for file in sorted(files) if not same(file)]
    if not rows and not (folder / f"mesh.{name}").exists():
        return []
    try:
        found = steps_of(folder, name)
    except Exception as error:
        return [f"mesh.{name}: {error}"]
    wrong = [f"step {step}" for step in rows if step not in found]
    return wrong + [f"step {step}" for step, points in found.items() if not np.array_equal(points, wanted[step])]


def put(files, folder):
    """Makes a folder as the disk has it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return folder / "out"


def cut(mesh, name, n_cuts, chance, folder):
    """Cuts the power of runs in one format; compared files, and how often a run without syncing was short."""
    whole = folder / f"{name}_whole"
    subprocess.run(command(mesh, whole, name), check=True)
    wanted, n_files, n_short = steps_of(whole, name), 0, 0
    for option in ["--no-sync", None]:
        root = folder / f"{name}{option}"
        root.mkdir()
        options = [option] if option else []
        disk = Disk(root, traced([*command(mesh, root / "out", name), *options], folder))
        for _ in range(n_cuts):
            moment = chance.choice(disk.ends)
            out = put(disk.left(moment, chance if chance.random() < 0.7 else None), folder / "cut")
            wrong = short(out, name, whole, wanted)
            if option:
                n_short += bool(wrong)
                continue
            assert not wrong, f"{name}, power cut at {moment}: {wrong}"
            subprocess.run(command(mesh, out, name), check=True, stderr=subprocess.DEVNULL)
            n_files += outputs.same(outputs.content(out), outputs.content(whole), f"{name}, resumed after a power cut at {moment}")
    return n_files, n_short


def main(cuts=TIMES or 8, nodes=NODES):
    """One line in all; `cuts` for each format."""
    if not shutil.which("strace"):
        print("power_cut: strace is not installed: NOT run", file=sys.stderr, flush=True)
        return
    chance = random.Random(SEED)
    totals = np.zeros(2, dtype=int)
    with scratch() as folder:
        mesh = case(folder, nodes)
        for name in FORMATS:
            totals += cut(mesh, name, cuts, chance, folder)
    n_files, n_short = totals
    assert n_short, f"not one of {cuts * len(FORMATS)} power cuts hurts a run that syncs nothing"
    note = f"{cuts} power cuts each of {', '.join(FORMATS)}; {n_short} of {cuts * len(FORMATS)} hurt a run with --no-sync"
    report("power_cut", n_files, 0.0, "files", note)
