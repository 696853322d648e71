"""A bar for terminals and notebooks."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

Progress = Callable[[str, int, "int | None"], object]


def as_function(progress: bool | Progress | None) -> Progress | None:
    """The function that is told of the work: none, the caller's, or one that draws a bar."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return bar()
    if callable(progress):
        return progress
    raise TypeError(f"progress is {progress!r}; it must be True, False or a function (stage, done, total)")


def bar() -> Progress:
    """A bar by tqdm where it is installed, which knows notebooks; else a line on standard error; in a log a line for each stage."""
    if not (sys.stderr.isatty() or "ipykernel" in sys.modules):
        return _log()
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _line
    shown: dict[str, Any] = {}

    def told(stage: str, done: int, total: int | None) -> None:
        if shown.get("stage") != stage:
            if "bar" in shown:
                shown["bar"].close()
            shown["stage"], shown["bar"] = stage, tqdm(total=total, desc=stage, leave=False)
        shown["bar"].n = done
        shown["bar"].refresh()
        if done == total:
            shown.pop("bar").close()
            shown.pop("stage")

    return told


def _log() -> Progress:
    last = [""]

    def told(stage: str, done: int, total: int | None) -> None:
        if stage != last[0]:
            last[0] = stage
            print(f"azimesh: {stage}", file=sys.stderr, flush=True)

    return told


def _line(stage: str, done: int, total: int | None) -> None:
    part = f"{100 * done / total:3.0f} %" if total else str(done)
    end = "\n" if done == total else ""
    print(f"\r{stage}: {part}", end=end, file=sys.stderr, flush=True)
