"""`convert` of a sequence ended by SIGINT, SIGTERM, SIGHUP and SIGKILL at random moments, into new names and over files
that are there: under a final name is the whole new file or the whole old one, and the next conversion leaves what one
that nobody ended leaves.
"""

import random
import shutil
import signal
import subprocess
import time

from interrupted import case
from killed import FORMATS, SEED
from program import AZIMESH, azimesh, report, scratch

NODES = 8_000
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]
OUTPUTS = {"vtu": "moved.pvd", "vtkhdf": "moved.vtkhdf", "cgns": "moved.cgns"}


def convert(sequence, out, name, *options):
    """A conversion under way."""
    command = [AZIMESH, "--quiet", "convert", sequence, out / OUTPUTS[name], "--force", *options]
    return subprocess.Popen(command, stderr=subprocess.DEVNULL)


def files_of(folder):
    """Bytes by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def made(sequence, out, name, *options):
    """What a conversion leaves that nobody ends, and its seconds."""
    out.mkdir()
    start = time.monotonic()
    assert convert(sequence, out, name, *options).wait() == 0, f"{name}: convert failed"
    return files_of(out), time.monotonic() - start


def main(ends=6, nodes=NODES):
    """One line in all; `ends` for each format."""
    chance = random.Random(SEED)
    n_files, n_amid = 0, 0
    with scratch() as folder:
        mesh = case(folder, nodes)
        azimesh("deform", mesh, mesh.with_suffix(".toml"), "-o", folder / "sequence")
        sequence, out = folder / "sequence" / "mesh.pvd", folder / "out"
        for name in FORMATS:
            new, seconds = made(sequence, folder / f"{name}_new", name, "--scale", "2")
            old, _ = made(sequence, folder / f"{name}_old", name)
            for end in range(ends):
                shutil.rmtree(out, ignore_errors=True)
                if end % 2:
                    shutil.copytree(folder / f"{name}_old", out)
                else:
                    out.mkdir()
                run, how = convert(sequence, out, name, "--scale", "2"), chance.choice(SIGNALS)
                time.sleep(chance.uniform(0.0, 1.1 * seconds))
                run.send_signal(how)
                run.wait()
                what = f"{name}, {how.name}, end {end + 1}"
                found = {file: content for file, content in files_of(out).items() if not file.startswith(".")}
                for file, content in found.items():
                    allowed = [new[file], old[file]] if end % 2 else [new[file]]
                    assert content in allowed, f"{what}: {file} is neither the old nor the new one"
                assert not end % 2 or found.keys() == old.keys(), f"{what}: {sorted(old.keys() - found.keys())} lost"
                n_amid += found != new
                assert convert(sequence, out, name, "--scale", "2").wait() == 0, what
                assert files_of(out) == new, f"{what}: the next conversion leaves something else"
                n_files += len(new)
    note = f"{ends} ends each of {', '.join(FORMATS)} by {', '.join(how.name for how in SIGNALS)}, {n_amid} amid the work"
    report("converted", n_files, 0.0, "files", note)


if __name__ == "__main__":
    main()
