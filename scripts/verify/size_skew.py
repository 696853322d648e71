"""The turned and moved block: sqrt(f_size) f_skew of its quadrilaterals, from the two meshes alone.

Knupp's measures relative to the reference mesh. At corner k of a quadrilateral the edges to its two
neighbours span a signed area alpha_k:

    f_size = min(tau, 1 / tau),   tau = sum alpha_k / sum alpha_k of the reference
    f_skew = 4 / sum (product of the two edge lengths / alpha_k),  0 where an alpha_k is not positive

Best published run known, with sliding nodes and 20 substeps: least 0.1497, mean 0.6554.
"""

import numpy as np
import pyvista

import outputs
from program import TESTDATA, scratch

LEAST, MEAN = 0.19, 0.66


def corners(points, quads):
    """Signed areas and products of edge lengths at the corners, (4, quadrilaterals) each."""
    x = points[quads]
    ahead = np.roll(x, -1, axis=1) - x
    back = np.roll(x, 1, axis=1) - x
    area = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2)
    return area.T, lengths.T


def size_skew(quads, reference, points):
    """sqrt(f_size) f_skew of each quadrilateral."""
    area_before, _ = corners(reference, quads)
    orientation = np.sign(area_before.sum(axis=0))
    area, lengths = corners(points, quads)
    area, area_before = area * orientation, area_before * orientation
    valid = (area > 0).all(axis=0)
    tau = np.where(valid, area.sum(axis=0) / area_before.sum(axis=0), 1.0)
    skew = 4 / (lengths / np.where(valid, area, 1.0)).sum(axis=0)
    return np.where(valid, np.sqrt(np.minimum(tau, 1 / tau)) * skew, 0.0)


def main():
    """The last step of testdata/block_sliding.toml, one interpolation from the reference mesh."""
    mesh = pyvista.read(TESTDATA / "block.vtu")
    quads = mesh.cells_dict[pyvista.CellType.QUAD]
    with scratch() as folder:
        rows = outputs.deform(TESTDATA / "block.vtu", TESTDATA / "block_sliding.toml", folder / "out")
        points = outputs.points(folder / "out", rows[-1])
    metric = size_skew(quads, np.array(mesh.points), points)
    least, mean = metric.min(), metric.mean()
    print(f"turned block: {len(quads)} cells, size-skew at least {least:.4f}, mean {mean:.4f}", flush=True)
    assert least >= LEAST and mean >= MEAN, f"least {LEAST} and mean {MEAN} are to be reached"


if __name__ == "__main__":
    main()
