"""`finish` ended by SIGINT, SIGTERM, SIGHUP and SIGKILL at random moments and said again: what is under a final name is
whole, and the last time leaves the files of one run.
"""

import random
import shutil
import signal
import subprocess
import time

from interrupted import case, left_by
from killed import FORMATS, SEED, SEQUENCES
from program import AZIMESH, report, scratch

NODES = 8_000
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]
PARTS = ["0..12", "12..13", "13..36"]


def deform(mesh, out, name, *options):
    """A run, or a part of one."""
    schedule = mesh.with_suffix(".toml")
    command = [AZIMESH, "--quiet", "deform", mesh, schedule, "-o", out, "--format", name, *options]
    subprocess.run(command, check=True)


def without_seconds(path):
    """Rows of a table that is whole."""
    text = path.read_text()
    assert text.endswith("\n"), f"{path} is cut"
    rows = [row.split(",") for row in text.splitlines()]
    at = rows[0].index("seconds")
    return [row[:at] + row[at + 1 :] for row in rows]


def check_named(out, expected, name, what):
    """What has its final name is whole; whether run.json is there."""
    if name in SEQUENCES and (out / f"mesh.{name}").exists():
        assert (out / f"mesh.{name}").read_bytes() == expected[f"mesh.{name}"], f"{what}: the file of all steps is short"
    if (out / "steps.csv").exists():
        assert without_seconds(out / "steps.csv") == expected["steps.csv"], f"{what}: steps.csv is another"
    if (out / "mesh.pvd").exists():
        assert (out / "mesh.pvd").read_bytes() == expected["mesh.pvd"], f"{what}: the .pvd is another"
    return (out / "run.json").exists()


def finish(out):
    """A join under way."""
    return subprocess.Popen([AZIMESH, "--quiet", "finish", out], stderr=subprocess.DEVNULL)


def main(ends=6, nodes=NODES):
    """One line in all; `ends` for each format."""
    chance = random.Random(SEED)
    n_files, n_amid = 0, 0
    with scratch() as folder:
        mesh = case(folder, nodes)
        for name in FORMATS:
            whole, parts, out = (folder / f"{name}_{what}" for what in ["whole", "parts", "out"])
            deform(mesh, whole, name)
            for part in PARTS:
                deform(mesh, parts, name, "--steps", part)
            expected = left_by(whole)
            shutil.copytree(parts, out)
            start = time.monotonic()
            assert finish(out).wait() == 0, f"{name}: finish failed"
            seconds = time.monotonic() - start
            for end in range(ends):
                shutil.rmtree(out)
                shutil.copytree(parts, out)
                run, how = finish(out), chance.choice(SIGNALS)
                time.sleep(chance.uniform(0.0, seconds))
                run.send_signal(how)
                run.wait()
                what = f"{name}, {how.name}, end {end + 1}"
                n_amid += not check_named(out, expected, name, what)
                for _ in range(2):
                    assert finish(out).wait() == 0, f"{what}: it does not go on without --force"
                found = left_by(out)
                for file, content in expected.items():
                    assert found.get(file) == content, f"{what}: {file} is another"
                left = [file for file in found if file.startswith(".")]
                assert not left, f"{what}: {left} left"
                n_files += len(expected)
    note = f"{ends} ends each of {', '.join(FORMATS)} by {', '.join(how.name for how in SIGNALS)}, {n_amid} amid the work"
    report("joined", n_files, 0.0, "files", note)


if __name__ == "__main__":
    main()
