"""docs/notes.md lists the codes of all notes: `.venv/bin/python scripts/verify notes`.

    .venv/bin/python scripts/verify notes --update       writes docs/notes.md from the sources
"""

import re
from pathlib import Path

from program import UPDATE, report

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/notes.md"
NOTE = re.compile(r'\b(?:note!|Note::new)\(\s*"(\w+)",(?:\s*"((?:[^"\\]|\\.|\\\n)*)")?', re.S)
HEAD = """# Codes of notes

A [note](library.md) has a `code`, the sentence `text`, the file and the line, and in `data` names and numbers that programs use. Codes stay; sentences may
change in any version. This page is written by `scripts/verify notes --update` from the sources: "…" is a name or a number.

| code | sentence |
|---|---|
"""


def page():
    """The page as the sources have it."""
    found = {}
    for path in sorted([*ROOT.glob("src/**/*.rs"), *ROOT.glob("crates/*/src/**/*.rs")]):
        if "tests" not in str(path.relative_to(ROOT)) and path.name != "note.rs":
            for code, text in NOTE.findall(path.read_text().split("#[cfg(test)]\nmod tests")[0]):
                text = re.sub(r"\{[^{}]*\}", "…", re.sub(r"\\\n\s*", "", text)).replace('\\"', '"')
                found[code] = found.get(code) or text.replace("|", "\\|")
    return HEAD + "".join(f"| `{code}` | {text or 'varies'} |\n" for code, text in sorted(found.items())), len(found)


def main(update=UPDATE):
    """Holds the page against the sources."""
    text, n = page()
    if update:
        PAGE.write_text(text)
    assert PAGE.read_text() == text, "docs/notes.md is not what the sources say; run scripts/verify notes --update"
    report("notes", n, 0, "codes", "one page")
