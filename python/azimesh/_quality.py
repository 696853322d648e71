"""Quality of a mesh: arrays over its cells, and their summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


class Quality(Mapping[str, Any]):
    """Metrics of each cell: arrays (n_cells,) under the names of ``azimesh quality -o``.

    Names are ``Volume`` (area in 2D), ``ScaledJacobian``, ``EdgeRatio``, ``EquiangleSkew``, ``Inverted`` (bool), ``Jacobian``,
    ``AspectRatio``, ``Condition``, ``Shape``, ``MinAngle``, ``MaxAngle``, ``Skew``, ``NonOrthogonality``, ``FaceSkewness``,
    ``VolumeRatio`` and ``SizeSkew``; with curved cells also ``CurvedJacobian`` and ``CurvedScaledJacobian``. A boundary face has the values of the cell that it bounds; NaN where a cell does not have the
    metric.

    Attributes
    ----------
    summary : dict
        The numbers of a row of steps.csv: counts of cells, smallest, mean and largest values.
    """

    def __init__(self, arrays: dict[str, Any], summary: dict[str, Any]) -> None:
        self._arrays = arrays
        self.summary = summary

    def __getitem__(self, name: str) -> Any:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        worst = self.summary["min_scaled_jacobian"]
        return f"<azimesh.Quality: {self.summary['n_cells']} cells, {self.summary['inverted']} inverted, least scaled Jacobian {worst:.4g}>"
