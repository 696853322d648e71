"""Errors and notes of azimesh."""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """What went wrong, where, and what would be right.

    Attributes
    ----------
    kind : str
        ``"input"``: a file or an argument is wrong and nothing was written. ``"check"``: the work was done but a check
        failed (inverted cells, tolerance missed, a condition of ``fail_on``). ``"system"``: the system refused (disk
        full, no permission). ``"interrupted"``: the work was asked to end.
    path : pathlib.Path or None
        The file it is about.
    line : int or None
        The line of that file, from 1.
    """

    def __init__(self, message: str, kind: str = "input", path: Path | None = None, line: int | None = None) -> None:
        super().__init__(message)
        self.kind = kind
        self.path = None if path is None else Path(path)
        self.line = line

    def __reduce__(self) -> tuple[type[Error], tuple[object, ...]]:
        return type(self), (str(self), self.kind, self.path, self.line)


class Note(UserWarning):
    """What a reader or a writer could not keep, or had to choose."""
