"""`finish` and `convert` ended by SIGINT, SIGTERM, SIGHUP and SIGKILL at random moments and said again: what has its final name is whole, the new file
or, where one was there, the old one, and the last time leaves what one leaves that nobody ended. TIMES says how often in each format.
"""

import random
import shutil
import subprocess
import time

import outputs
from program import AZIMESH, azimesh, report, scratch
from sequences import FORMATS, NAMES, SEED, SIGNALS, TIMES, case

PARTS = ["0..12", "12..13", "13..36"]


def starts(*arguments):
    """A command under way."""
    return subprocess.Popen([AZIMESH, "--quiet", *map(str, arguments)], stderr=subprocess.DEVNULL)


def seconds_of(*arguments):
    """Seconds of a command that nobody ends."""
    start = time.monotonic()
    assert starts(*arguments).wait() == 0, f"{arguments} failed"
    return time.monotonic() - start


def end(chance, seconds, *arguments):
    """Ends a command at a moment; says by what."""
    run, how = starts(*arguments), chance.choice(SIGNALS)
    time.sleep(chance.uniform(0.0, seconds))
    run.send_signal(how)
    run.wait()
    return how.name


def visible(found):
    """What stands under final names, but for parts that a join removes."""
    return {name: content for name, content in found.items() if not name.startswith(".")}


def join(mesh, folder, name, ends, chance):
    """(files compared, ends amid the work) of `finish`."""
    whole, parts, out = (folder / f"{name}_{what}" for what in ["whole", "parts", "out"])
    command, n_files, n_amid = ["deform", mesh, mesh.with_suffix(".toml"), "--format", name, "-o"], 0, 0
    azimesh(*command, whole)
    for part in PARTS:
        azimesh(*command, parts, "--steps", part)
    expected = outputs.content(whole)
    joined = {"steps.csv", "mesh.pvd", f"mesh.{name}"}
    shutil.copytree(parts, out)
    seconds = seconds_of("finish", out)
    for i in range(ends):
        shutil.rmtree(out)
        shutil.copytree(parts, out)
        what = f"{name}, finish, {end(chance, seconds, 'finish', out)}, end {i + 1}"
        for file, content in outputs.content(out).items():
            assert file not in joined & expected.keys() or content == expected[file], f"{what}: {file} is short"
        n_amid += not (out / "run.json").exists()
        for _ in range(2):
            seconds_of("finish", out)
        found = outputs.content(out)
        n_files += outputs.same(found, expected, what, extra=True)
        assert found.keys() == visible(found).keys(), f"{what}: {[file for file in found if file.startswith('.')]} left"
    return n_files, n_amid


def convert(mesh, folder, name, ends, chance):
    """(files compared, ends amid the work) of `convert` of a sequence, into new names and over files that are there."""
    sequence, out = folder / "sequence" / "mesh.pvd", folder / "out"
    target = "moved.pvd" if name == "vtu" else f"moved.{name}"
    command = lambda place, *options: ("convert", sequence, place / target, "--force", *options)  # noqa: E731
    new, old = folder / f"{name}_new", folder / f"{name}_old"
    new.mkdir(), old.mkdir()
    seconds_of(*command(old))
    seconds = 1.1 * seconds_of(*command(new, "--scale", "2"))
    new, before, n_files, n_amid = outputs.content(new), outputs.content(old), 0, 0
    for i in range(ends):
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(old, out) if i % 2 else out.mkdir()
        what = f"{name}, convert, {end(chance, seconds, *command(out, '--scale', '2'))}, end {i + 1}"
        found = visible(outputs.content(out))
        for file, content in found.items():
            assert content in [new[file], before[file]][: 1 + i % 2], f"{what}: {file} is neither the old nor the new one"
        assert not i % 2 or found.keys() == before.keys(), f"{what}: {sorted(before.keys() - found.keys())} lost"
        n_amid += found != new
        seconds_of(*command(out, "--scale", "2"))
        n_files += outputs.same(outputs.content(out), new, f"{what}, the next conversion")
    return n_files, n_amid


def main(ends=TIMES or 6, nodes=8_000):
    """One line in all; `ends` for each format and command."""
    chance = random.Random(SEED)
    with scratch() as folder:
        mesh = case(folder, nodes)
        azimesh("deform", mesh, mesh.with_suffix(".toml"), "-o", folder / "sequence")
        results = [ended(mesh, folder, name, ends, chance) for ended in (join, convert) for name in FORMATS]
    n_files, n_amid = map(sum, zip(*results))
    assert n_amid, "no command was ended amid its work"
    report("ended", n_files, 0.0, "files", f"{ends} ends each of finish and convert in {', '.join(FORMATS)} by {NAMES}, {n_amid} amid the work")
