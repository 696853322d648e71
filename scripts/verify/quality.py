"""Volume and scaled Jacobian of every cell against VTK's cell quality, to 1e-12.

VTK's scaled Jacobian of a 2D cell has no sign, so magnitudes are compared there; volumes are
relative to the largest one.
"""

import numpy as np
import pyvista

from formats import sources
from program import azimesh, report, scratch

# Triangle, quadrilateral: area. Tetrahedron, hexahedron, wedge, pyramid: volume.
MEASURE = {5: "area", 9: "area", 10: "volume", 12: "volume", 13: "volume", 14: "volume"}


def deviation(source, folder):
    """(cells compared, largest difference) over the cells of the mesh's own dimension."""
    output = folder / "quality.vtu"
    azimesh("quality", source, "-o", output)
    grid = pyvista.read(output)
    volume, jacobian = grid.cell_data["Volume"], grid.cell_data["ScaledJacobian"]
    judged = np.isfinite(jacobian)
    n_compared, largest = 0, 0.0
    for kind, measure in MEASURE.items():
        cells = np.flatnonzero((grid.celltypes == kind) & judged)
        if len(cells) == 0:
            continue
        theirs = grid.extract_cells(cells).cell_quality(["scaled_jacobian", measure])
        plane = measure == "area"
        ours = np.abs(jacobian[cells]) if plane else jacobian[cells]
        size = np.abs(volume[cells]) if plane else volume[cells]
        other = np.abs(theirs.cell_data["scaled_jacobian"]) if plane else theirs.cell_data["scaled_jacobian"]
        scale = np.abs(theirs.cell_data[measure]).max()
        largest = max(
            largest,
            np.abs(ours - other).max(),
            np.abs(size - theirs.cell_data[measure]).max() / scale,
        )
        n_compared += len(cells)
    return n_compared, largest


def main():
    """One line in all; second-order cells and polyhedra have no scaled Jacobian in VTK."""
    total, largest = 0, 0.0
    for source in sources():
        with scratch() as folder:
            n_compared, difference = deviation(source, folder)
        assert difference <= 1e-12, f"{source}: differs from VTK by {difference}"
        total, largest = total + n_compared, max(largest, difference)
    report("quality", total, largest, "cells")
    assert total > 0, "no cell was compared"


if __name__ == "__main__":
    main()
