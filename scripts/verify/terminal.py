"""On a terminal of 80 columns: colours and progress bars, and neither where NO_COLOR or TERM=dumb asks."""

import fcntl
import os
import pty
import struct
import subprocess
import termios

from program import AZIMESH, TESTDATA, report, scratch

COMMANDS = ["info", "convert", "quality", "check", "select", "deform", "finish", "diff", "report", "sample", "completions", "man"]
MESH = TESTDATA / "naca0012.vtu"
# Variables that decide about colours and widths; of these only a test's own are set. (`CI` stands for a terminal in colours, whatever TERM says.)
OURS = {"NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI", "COLUMNS", "LINES"}


def on_terminal(arguments, **variables):
    """What a command prints on a terminal, both streams together."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name not in OURS}
    environment |= {"TERM": "xterm-256color"} | variables
    process = subprocess.Popen([AZIMESH, *map(str, arguments)], stdin=theirs, stdout=theirs, stderr=theirs, env=environment)
    os.close(theirs)
    said = b""
    while True:
        try:
            read = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not read:
            break
        said += read
    os.close(ours)
    assert process.wait() == 0, f"{arguments}: {said.decode()}"
    return said.decode()


def main():
    """Help of every command, and a run with a progress bar."""
    escape = "\x1b["
    for command in COMMANDS:
        assert escape in on_terminal([command, "--help"]), f"{command}: no colours on a terminal"
        assert escape not in on_terminal([command, "--help"], NO_COLOR="1"), f"{command}: NO_COLOR is not respected"
        assert escape not in on_terminal([command, "--help"], TERM="dumb"), f"{command}: TERM=dumb is not respected"
    with scratch() as folder:
        schedule = TESTDATA / "naca0012.toml"
        run = ["deform", MESH, schedule, "-o", folder / "out", "--force"]
        assert escape in on_terminal(run), "no progress bar on a terminal"
        assert escape not in on_terminal(run, TERM="dumb"), "a progress bar on a dumb terminal"
        assert on_terminal([*run, "-q"]) == "", "a quiet run prints"
    report("terminal", 3 * len(COMMANDS) + 3, 0.0, "screens")
