"""Files from one format to another."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from azimesh import _azimesh

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from azimesh._azimesh import WriteOptions


def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    step: int | None = None,
    tag_array: str | None = None,
    **options: Unpack[WriteOptions],
) -> None:
    """Reads a mesh and writes it in another format; options are those of `read` and `write`."""
    _azimesh.write(_azimesh.read(source, step=step, tag_array=tag_array), target, **options)
