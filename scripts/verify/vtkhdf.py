"""VTKHDF files by VTK's own reader: the same grids as in VTU, bit for bit, also at every step.

And files by VTK's own writer, which must read as VTK reads them.
"""

import subprocess

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from program import AZIMESH, TESTDATA, azimesh, report, scratch

# Schedules of testdata, what is added to them, and one for polyhedra.
ARRAYS = '\n[output]\nquality = "cells"\ndisplacement = true\n'
POLYHEDRA = """
version = 1
azimuth.values = [0, 10, 20, 30]
boundaries.others = "fixed"
body = [ { name = "roof", tags = ["roof"], rigid = { translate = [0.01, 0.0, 0.005], ramp = true } } ]
"""
RUNS = [
    ("naca0012", None, ""), ("wing_on_plane", None, ""), ("body_in_duct", None, ARRAYS), ("polyhedra_ascii", POLYHEDRA, ARRAYS),
]  # fmt: skip
DATA = ("GetPointData", "GetCellData", "GetFieldData")


def reader_of(path):
    """VTK's reader for the ending."""
    reader = vtk.vtkHDFReader() if path.suffix == ".vtkhdf" else vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    return reader


def n_steps(path):
    """How many steps there are in a .vtkhdf; 1 for a single mesh."""
    reader = reader_of(path)
    reader.UpdateInformation()
    return max(1, reader.GetNumberOfSteps())


def grid_of(path):
    """The grid in a file; the first step of a sequence."""
    reader = reader_of(path)
    reader.Update()
    return reader.GetOutput()


def values(array):
    """Values of a numeric array or of one of strings."""
    if isinstance(array, vtk.vtkStringArray):
        return np.array([array.GetValue(i) for i in range(array.GetNumberOfValues())])
    return vtk_to_numpy(array)


def arrays(data):
    """Name -> values."""
    named = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
    return {array.GetName(): values(array) for array in named if array.GetName() != "Time"}


def face_streams(grid):
    """Faces of every polyhedron, one number after another."""
    streams = []
    for cell in range(grid.GetNumberOfCells()):
        if grid.GetCellType(cell) == vtk.VTK_POLYHEDRON:
            ids = vtk.vtkIdList()
            grid.GetFaceStream(cell, ids)
            streams += [ids.GetId(i) for i in range(ids.GetNumberOfIds())]
    return np.array(streams)


def parts_of(grid):
    """All that a grid consists of."""
    cells = grid.GetCells()
    parts = {
        "points": values(grid.GetPoints().GetData()), "types": values(grid.GetCellTypes()), "connectivity": values(cells.GetConnectivityArray()),
        "offsets": values(cells.GetOffsetsArray()), "faces": face_streams(grid),
    }  # fmt: skip
    for kind in DATA:
        parts |= {f"{kind[3:]} {name}": found for name, found in arrays(getattr(grid, kind)()).items()}
    return parts


def assert_same(found, wanted, what):
    """All parts bit for bit; arrays of the data in the same type."""
    found, wanted = parts_of(found), parts_of(wanted)
    assert found.keys() == wanted.keys(), f"{what}: {found.keys() ^ wanted.keys()}"
    for name, one in found.items():
        other = wanted[name]
        same_type = one.dtype == other.dtype or "Data" not in name
        same = one.shape == other.shape and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
        assert same_type and same, f"{what}: {name} is another"
    return len(found)


def check_files(folder):
    """Every mesh of testdata, by way of VTKHDF and of VTU."""
    n = 0
    for source in sorted(TESTDATA.iterdir()):
        if source.suffix not in (".vtu", ".msh", ".su2", ".vtkhdf"):
            continue
        vtu, hdf, again = folder / "a.vtu", folder / "a.vtkhdf", folder / "b.vtu"
        # Of a sequence the last step: into VTKHDF it would go as a whole.
        last = ["--step", str(n_steps(source) - 1)] if source.suffix == ".vtkhdf" else []
        for origin, target, step in ((source, vtu, last), (source, hdf, last), (hdf, again, [])):
            azimesh("convert", origin, target, "--force", *step)
        n += assert_same(grid_of(hdf), grid_of(vtu), source.name)
        assert vtu.read_bytes() == again.read_bytes(), f"{source.name}: another VTU file by way of VTKHDF"
    return n


def check_by_vtk(folder):
    """What VTK's writer makes of the grids of testdata reads as VTK's own reader has it."""
    n = 0
    for source in sorted(TESTDATA.glob("*.vtu")):
        hdf, vtu = folder / "v.vtkhdf", folder / "v.vtu"
        writer = vtk.vtkHDFWriter()
        writer.SetInputData(grid_of(source))
        writer.SetFileName(str(hdf))
        writer.SetCompressionLevel(3)
        assert writer.Write() == 1, source
        azimesh("convert", source, vtu, "--force")
        azimesh("convert", hdf, folder / "w.vtu", "--force")
        n += assert_same(grid_of(folder / "w.vtu"), grid_of(vtu), f"{source.name} by VTK's writer")
        hdf.unlink()
    return n


def check_run(name, motion, more, folder):
    """A run in one .vtkhdf against the same run in .vtu files, forth and back through the steps."""
    schedule = folder / f"{name}.toml"
    motion = motion or (TESTDATA / f"{name}.toml").read_text()
    schedule.write_text(motion + more)
    for kind in ("vtu", "vtkhdf"):
        command = [AZIMESH, "--quiet", "deform", TESTDATA / f"{name}.vtu", schedule, "--format", kind]
        subprocess.run([*command, "-o", folder / f"{name}_{kind}"], check=False)
    files = sorted((folder / f"{name}_vtu").glob("*.vtu"))
    assert files, f"{name}: no file"
    reader = reader_of(folder / f"{name}_vtkhdf" / f"{name}.vtkhdf")
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert len(times) == len(files), f"{name}: {len(times)} steps, {len(files)} files"
    steps = list(range(len(files)))
    n = 0
    for step in steps + steps[::-3]:
        reader.UpdateTimeStep(times[step])
        n += assert_same(reader.GetOutput(), grid_of(files[step]), f"{name}, step {step}")
    return n


def main():
    """One line in all."""
    with scratch() as folder:
        n = check_files(folder) + check_by_vtk(folder)
        n += sum(check_run(*run, folder) for run in RUNS)
    report("vtkhdf", n, 0.0, "arrays", "files and steps by VTK's reader, files by its writer")
