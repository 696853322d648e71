"""UGRID in every flavour, read back by plain numpy and by meshio: nodes, cells, numbers, names."""

import itertools
import sys
from pathlib import Path

import meshio
import numpy as np

from program import TESTDATA, azimesh, report, scratch

sys.path.append(str(Path(__file__).resolve().parents[2] / "testdata" / "generate"))
import ugrid_file  # noqa: E402

FLAVOURS = ["", ".b8", ".lb8", ".b4", ".lb4", ".r8", ".lr8", ".r4", ".lr4", ".b8l", ".lb8l"]
MESHIO = {5: "triangle", 9: "quad", 10: "tetra", 14: "pyramid", 13: "wedge", 12: "hexahedron"}


def assert_same(found, wanted, what, is_single):
    """Nodes to the last bit, of 32 where the file has no more; cells in order; numbers of faces."""
    points = wanted.points.astype(np.float32).astype(float) if is_single else wanted.points
    assert np.array_equal(found.points, points), f"{what}: nodes"
    kept = dict(found.cells)
    for vtk, rows in wanted.cells:
        assert np.array_equal(kept[vtk], rows), f"{what}: cells of type {vtk}"
    assert np.array_equal(found.numbers, wanted.numbers), f"{what}: numbers of faces"


def assert_same_names(found, wanted, what, has_conditions):
    """Names, and conditions where they came through."""
    strip = (lambda names: names) if has_conditions else (lambda names: {i: name for i, (_, name) in names.items()})
    assert strip(found.names) == strip(wanted.names), f"{what}: {found.names}, expected {wanted.names}"


def assert_meshio_agrees(path, wanted, is_single):
    """meshio has the same; its cells come in blocks by kind."""
    found = meshio.read(path)
    points = wanted.points.astype(np.float32) if is_single else wanted.points
    assert np.array_equal(found.points, points), f"{path.name} by meshio: nodes"
    blocks = {block.type: block.data for block in found.cells}
    for vtk, rows in wanted.cells:
        assert len(rows) == 0 or np.array_equal(blocks[MESHIO[vtk]], rows), f"{path.name} by meshio: {MESHIO[vtk]}"
    numbers = np.concatenate(found.cell_data["ugrid:ref"][:2])[: len(wanted.numbers)]
    assert np.array_equal(numbers, wanted.numbers), f"{path.name} by meshio: numbers of faces"


def main():
    """One line in all."""
    sources = sorted(TESTDATA.glob("*.ugrid"))
    n_compared = 0
    for source in sources:
        wanted = ugrid_file.read(source)
        with scratch() as folder:
            by_vtu = folder / "by.vtu"
            azimesh("convert", source, by_vtu)
            for first, flavour in itertools.product((source, by_vtu), FLAVOURS):
                target = folder / f"from_{first.suffix[1:]}{flavour}.ugrid"
                azimesh("convert", "--force", first, target)
                what = f"{source.name} by {first.name} as {target.name}"
                found = ugrid_file.read(target)
                assert_same(found, wanted, what, flavour.endswith("4"))
                assert_same_names(found, wanted, what, first == source)
                if flavour:  # meshio reads text as floats of 32 bits
                    assert_meshio_agrees(target, wanted, flavour.endswith("4"))
                if first == source:  # VTU has no conditions
                    azimesh("diff", "--tolerance", "1e-6", source, target)
                n_compared += 1
    report("ugrid", n_compared, 0.0, "meshes", f"{len(sources)} files of testdata")
