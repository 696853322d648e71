"""Moves unstructured meshes with rotors, wings and anything else that turns, by radial basis functions.

>>> import azimesh
>>> mesh = azimesh.read("testdata/naca0012.vtu")
>>> deformation = azimesh.Deformation(mesh, azimesh.Schedule("testdata/naca0012.toml"))
>>> for step in deformation:
...     step.points, step.quality["min_scaled_jacobian"]
>>> deformation.write("out")

Lengths are in the mesh's own unit, angles in degrees where a name says so. Arrays that look at a mesh are read-only.
Errors are `Error` with ``path``, ``line`` and ``kind``; what a file cannot hold is told by warnings of class `Note`.
"""

from azimesh._azimesh import (
    Deformation,
    Difference,
    Mesh,
    Moment,
    Morph,
    Schedule,
    Step,
    SurfaceMap,
    __version__,
    diff,
    quality,
    read,
    report,
    write,
)
from azimesh._convert import convert
from azimesh._errors import Error, Note
from azimesh._gmsh import from_gmsh
from azimesh._meshio import from_meshio
from azimesh._pyvista import from_pyvista, use_in_pyvista
from azimesh._quality import Quality

__all__ = [
    "Deformation",
    "Difference",
    "Error",
    "Mesh",
    "Moment",
    "Morph",
    "Note",
    "Quality",
    "Schedule",
    "Step",
    "SurfaceMap",
    "__version__",
    "convert",
    "diff",
    "from_gmsh",
    "from_meshio",
    "from_pyvista",
    "quality",
    "read",
    "report",
    "use_in_pyvista",
    "write",
]
