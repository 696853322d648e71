"""The commands on the pages of docs/ do what the pages show: `.venv/bin/python scripts/verify pages`.

    .venv/bin/python scripts/verify pages --update        writes the outputs of now into the pages

A block ```console holds commands, behind `$ `, and what they print. A ```toml block under a line that ends in a file
name in backticks and a colon is that file. The blocks of a page run in order in one folder, which has `testdata` in it.
Numbers may differ by a thousandth, seconds and paths by anything; a line `...` stands for any lines.

Also: every link between the pages of the repository leads to a page and a heading that are there, and every page
of docs/ is in the book's SUMMARY.md.
"""

import math
import os
import re
import subprocess
from pathlib import Path

from program import AZIMESH, UPDATE, report, scratch

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(console|toml|csv)\n(.*?)^```$", re.M | re.S)
FILE = re.compile(r"`([\w.]+)`:$")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")
SECONDS = re.compile(r"\d+(?:\.\d+)? s\b(: selection .*)?|^\d+\.\d+$")
ROUND_OFF = 1e-12
TOLERANCE = 2e-3


def steps(block):
    """The commands of a block with the lines that they print."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append(([line[2:]], []))
        elif not found[-1][1] and found[-1][0][-1].endswith("\\"):
            found[-1][0].append(line)
        else:
            found[-1][1].append(line)
    return [("\n".join(command), printed) for command, printed in found]


def run(command, folder):
    """What a command prints on both streams; it must not fail."""
    environment = os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "NO_COLOR": "1"}
    done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)  # fmt: skip
    assert done.returncode == 0, f"{command}: exit code {done.returncode}\n{done.stdout}"
    return done.stdout.rstrip("\n").splitlines()


def alike(expected, found):
    """Whether two lines are the same but for the last digits of numbers and all digits of seconds."""
    expected, found = (SECONDS.sub("SECONDS", line) for line in (expected, found))
    if NUMBER.sub("#", expected).split() != NUMBER.sub("#", found).split():
        return False
    pairs = zip(map(float, NUMBER.findall(expected)), map(float, NUMBER.findall(found)))
    return all(math.isclose(a, b, rel_tol=TOLERANCE, abs_tol=ROUND_OFF) for a, b in pairs)


def matches(expected, found):
    """Whether lines are alike; `...` stands for any lines."""
    if not expected:
        return not found
    if expected[0] == "...":
        return any(matches(expected[1:], found[skipped:]) for skipped in range(len(found) + 1))
    return bool(found) and alike(expected[0], found[0]) and matches(expected[1:], found[1:])


def try_page(path, update):
    """Runs the blocks of a page in order; the number of commands."""
    text = path.read_text()
    n_commands, changed = 0, []
    with scratch() as folder:
        (folder / "bin").mkdir()
        (folder / "bin" / "azimesh").symlink_to(Path(AZIMESH).resolve())
        (folder / "testdata").symlink_to(ROOT / "testdata")
        for block in BLOCK.finditer(text):
            if block[1] != "console":
                name = FILE.search(text[: block.start()].rstrip())
                if name:
                    (folder / name[1]).write_text(block[2])
                continue
            lines = []
            for command, expected in steps(block[2]):
                found = run(command, folder)
                n_commands += 1
                same = matches(expected, found)
                if not same and not update:
                    raise AssertionError(
                        f"{path.name}: {command}\nthe page shows\n  " + "\n  ".join(expected)
                        + "\nnow it prints\n  " + "\n  ".join(found)
                    )  # fmt: skip
                lines += [f"$ {command}", *(expected if same else found)]
            changed.append((block[0], "```console\n" + "\n".join(lines) + "\n```"))
    if update:
        for old, new in changed:
            text = text.replace(old, new)
        path.write_text(text)
    return n_commands


LINK = re.compile(r"\]\(([^)\s]+)\)")
SKIPPED = ("http://", "https://", "mailto:")


def anchors(text):
    """Names of the headings of a page, as forges and mdbook make them."""
    headings = re.findall(r"^#+ +(.+)$", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S), re.M)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in plain}


def check_links():
    """Every link of every page leads somewhere; their number."""
    pages = [*ROOT.glob("*.md"), *DOCS.rglob("*.md"), *(ROOT / "fuzz").glob("*.md"), *(ROOT / "testdata").rglob("*.md")]
    wrong, n_links = [], 0
    for page in pages:
        text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
        for link in LINK.findall(text):
            if link.startswith(SKIPPED):
                continue
            n_links += 1
            target, _, anchor = link.partition("#")
            path = (page.parent / target).resolve() if target else page
            if not path.exists():
                wrong.append(f"{page.relative_to(ROOT)}: {link}: there is no such file")
            elif anchor and path.suffix == ".md" and anchor not in anchors(path.read_text()):
                wrong.append(f"{page.relative_to(ROOT)}: {link}: there is no such heading")
    summary = (DOCS / "SUMMARY.md").read_text()
    for page in DOCS.rglob("*.md"):
        name = str(page.relative_to(DOCS))
        if name != "SUMMARY.md" and f"({name})" not in summary:
            wrong.append(f"docs/{name} is not in docs/SUMMARY.md")
    assert not wrong, "\n".join(wrong)
    return n_links


def main(update=UPDATE):
    """Runs every page, then follows every link."""
    pages = [page for page in sorted(DOCS.rglob("*.md")) if "```console" in page.read_text()]
    report("pages", sum(try_page(page, update) for page in pages), 0, "commands", f"{len(pages)} pages, {check_links()} links")
