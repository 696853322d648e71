"""The cases of `repair_cases.py` with other programs: finite elements, gmsh, OpenFOAM.

    .venv/bin/python validation/repair_peers.py target/release/azimesh [CASE ...]

A row for each case of cells of one kind: folded cells left (of which a corner is not positive) and CPU seconds of

- `azimesh repair` on what one step of interpolation gives,
- linear elasticity in 10 steps, with a stiffness of 1/volume: linear, bilinear and trilinear elements, direct solver (scipy),
- gmsh's `UntangleMeshGeometry` on what one step of interpolation gives,
- OpenFOAM's `displacementLaplacian` (quadratic inverse distance) and `displacementSBRStress`, by `moveDynamicMesh` in 10 steps.

A dash: the program cannot take the case; "failed": it ended with an error.
"""

import itertools
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gmsh
import numpy as np
import pyvista
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

from folding import CUBE, SQUARE, jacobians
from repair_cases import CASES, azimesh

LIMIT = 600  # seconds of a program
ENVIRONMENT = {"WM_PROJECT_DIR": "/usr/share/openfoam"} | os.environ


def volume_cells(grid):
    """The cells of the mesh's dimension where they are of one kind, else None; and the nodes of its boundary."""
    cells = dict(grid.cells_dict)
    own = [kind for kind in (10, 12, 13, 14) if kind in cells] or [kind for kind in (5, 9) if kind in cells]
    if len(own) != 1 or own[0] in (13, 14):
        return None, None
    own = cells.pop(own[0])
    return own, np.unique(np.concatenate([faces.ravel() for faces in cells.values()]))


def at_corners(points, cells, is_plane):
    """The Jacobians at the corners of every cell."""
    if cells.shape[1] == 8 or (is_plane and cells.shape[1] == 4):
        return jacobians(points, cells, 2)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    if is_plane:
        return (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])[None]
    return np.linalg.det(edges)[None]


def folded(reference, points, cells):
    """How many cells have a corner that is not positive."""
    is_plane = np.ptp(reference[:, 2]) == 0
    sign = np.sign(at_corners(reference, cells, is_plane)).min(axis=0)
    return int((at_corners(points, cells, is_plane) * sign <= 0).any(axis=0).sum())


def dimension(points, cells):
    """2 or 3."""
    return 3 if cells.shape[1] == 8 or np.ptp(points[:, 2]) > 0 else 2


def shape_slopes(d, n):
    """The slopes (d, n) of the shape functions at each point of the quadrature: linear, bilinear or trilinear."""
    if n == d + 1:
        return [np.hstack([-np.ones((d, 1)), np.eye(d)])]
    corners = (CUBE if d == 3 else SQUARE)[:, :d]
    found = []
    for at in itertools.product((0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5), repeat=d):
        factors = np.where(corners == 1, at, 1 - np.array(at))
        found.append(np.stack([np.where(corners[:, k] == 1, 1.0, -1.0) * np.delete(factors, k, axis=1).prod(axis=1) for k in range(d)]))
    return found


def stiffness(points, cells):
    """The matrix of linear elasticity with E = 1 / volume and a Poisson ratio of 0.3."""
    d, n = dimension(points, cells), cells.shape[1]
    lame, shear = 0.3 / (1.3 * 0.4), 1 / 2.6
    whole, volume = np.zeros((len(cells), n * d, n * d)), np.zeros(len(cells))
    for slopes in shape_slopes(d, n):
        jacobian = np.einsum("kc,mcx->mkx", slopes, points[cells][:, :, :d])
        determinant = np.abs(np.linalg.det(jacobian))
        gradient = np.einsum("mxk,kc->mcx", np.linalg.inv(jacobian), slopes)
        dots = np.einsum("mix,mjx->mij", gradient, gradient)
        block = lame * np.einsum("mix,mjy->mixjy", gradient, gradient) + shear * np.einsum("miy,mjx->mixjy", gradient, gradient)
        block += shear * np.einsum("mij,xy->mixjy", dots, np.eye(d))
        whole += determinant[:, None, None] * block.reshape(len(cells), n * d, n * d)
        volume += determinant
    whole /= volume[:, None, None]
    unknowns = (d * cells[:, :, None] + np.arange(d)).reshape(len(cells), n * d)
    rows, columns = np.broadcast_arrays(unknowns[:, :, None], unknowns[:, None, :])
    return sparse.csr_matrix((whole.ravel(), (rows.ravel(), columns.ravel())), shape=(d * len(points),) * 2)


def elasticity(reference, goal, cells, boundary, steps=10):
    """The boundary moved to its goal in steps, each on the mesh of the last one."""
    d = dimension(reference, cells)
    if len(reference) > (30_000 if d == 2 else 8_000):
        return None
    points, start = reference.copy(), time.process_time()
    fixed = np.zeros((len(points), d), bool)
    fixed[boundary] = True
    fixed, free = np.flatnonzero(fixed.ravel()), np.flatnonzero(~fixed.ravel())
    step = (goal - reference)[:, :d].ravel() / steps
    for _ in range(steps):
        matrix = stiffness(points, cells)
        by = np.zeros(len(points) * d)
        by[fixed] = step[fixed]
        by[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix[free][:, fixed] @ by[fixed]))
        points[:, :d] += by.reshape(-1, d)
    return points, time.process_time() - start


def untangled_by_gmsh(path, cells, n_nodes):
    """What gmsh makes of a folded mesh. It numbers nodes anew, cells stay in order."""
    azimesh("convert", path, path.with_suffix(".msh"), "--force")
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    start = time.process_time()
    try:
        gmsh.open(str(path.with_suffix(".msh")))
        gmsh.model.mesh.optimize("UntangleMeshGeometry")
        tags, places, _ = gmsh.model.mesh.getNodes()
        types = {3: 2, 8: 5, 4: 3 if gmsh.model.getDimension() == 2 else 4}
        _, connectivity = gmsh.model.mesh.getElementsByType(types[cells.shape[1]])
    finally:
        gmsh.finalize()
    place_of = np.full((int(tags.max()) + 1, 3), np.nan)
    place_of[tags.astype(int)] = places.reshape(-1, 3)
    points = np.zeros((n_nodes, 3))
    points[cells.ravel()] = place_of[connectivity.astype(int)]
    return points, time.process_time() - start


def foam_motion(schedule):
    """OpenFOAM's boundary condition for the motion of a schedule, which takes a second."""
    if found := re.search(r"translate = \[(.*)\]", schedule):
        return f"solidBodyMotionFunction linearMotion; linearMotionCoeffs {{ velocity ({found[1].replace(',', ' ')}); }}"
    axis, origin, angle = re.search(r"axis = \[(.*?)\], origin = \[(.*?)\], angle = ([-\d.]+)", schedule).groups()
    spaced = lambda text: text.replace(",", " ")  # noqa: E731
    omega = np.radians(float(angle))
    return f"solidBodyMotionFunction rotatingMotion; rotatingMotionCoeffs {{ origin ({spaced(origin)}); axis ({spaced(axis)}); omega {float(omega)!r}; }}"


HEADER = "FoamFile {{ version 2.0; format ascii; class {0}; object {1}; }}\n"
DICTIONARIES = {
    "system/controlDict": """application moveDynamicMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 0.1;
writeControl runTime; writeInterval 1; writeFormat ascii; writePrecision 16; timePrecision 6; libs ("libfvMotionSolvers.so");
""",
    "system/fvSchemes": """ddtSchemes { default Euler; } gradSchemes { default Gauss linear; } divSchemes { default Gauss linear; }
laplacianSchemes { default Gauss linear corrected; } interpolationSchemes { default linear; } snGradSchemes { default corrected; }
""",
    "system/fvSolution": """solvers { "cellDisplacement.*" { solver PCG; preconditioner DIC; tolerance 1e-10; relTol 1e-6; maxIter 5000; } }
""",
}


def moved_by_foam(folder, mesh, schedule, solver):
    """What OpenFOAM makes of the motion."""
    case = folder / solver
    plane = mesh.suffix == ".su2" and "NDIME= 2" in mesh.read_text()[:20]
    more = ["--extrude", "0.01"] if plane else []
    azimesh("convert", mesh, case, "--format", "openfoam", *more, "--force")
    for name, text in DICTIONARIES.items():
        (case / name).parent.mkdir(exist_ok=True)
        (case / name).write_text(HEADER.format("dictionary", Path(name).name) + text)
    (case / "constant/dynamicMeshDict").write_text(
        HEADER.format("dictionary", "dynamicMeshDict")
        + f"dynamicFvMesh dynamicMotionSolverFvMesh; motionSolverLibs (fvMotionSolvers); solver {solver}; motionSolver {solver};\n"
        + f"{solver}Coeffs {{ diffusivity quadratic inverseDistance ({moving_tag(schedule)}); }}\n"
    )
    patches = re.findall(r"^\s*(\S+)\s*\n\s*\{\s*\n\s*type\s+(\S+);", (case / "constant/polyMesh/boundary").read_text(), re.M)
    of = lambda name, kind: condition(name, kind, schedule)  # noqa: E731
    fields = "\n".join(f'"{name}" {{ {of(name, kind)} }}' for name, kind in patches)
    (case / "0").mkdir(exist_ok=True)
    (case / "0/pointDisplacement").write_text(
        HEADER.format("pointVectorField", "pointDisplacement")
        + f"dimensions [0 1 0 0 0 0 0]; internalField uniform (0 0 0);\nboundaryField {{ {fields} }}\n"
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(["moveDynamicMesh", "-case", case], capture_output=True, text=True, timeout=LIMIT, env=ENVIRONMENT)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode != 0 or not (case / "1/polyMesh/points").exists():
        (Path(tempfile.gettempdir()) / "moveDynamicMesh.log").write_text(done.stdout + done.stderr)
        return "failed"
    azimesh("convert", case, folder / "before.vtu", "--step", "0", "--force")
    azimesh("convert", case, folder / "after.vtu", "--step", "1", "--force")
    before, after = (pyvista.read(folder / name) for name in ("before.vtu", "after.vtu"))
    cells, _ = volume_cells(before)
    if cells is None:
        return "-"  # a layer of wedges
    return f"{folded(np.asarray(before.points, float), np.asarray(after.points, float), cells)}, {seconds:.1f} s"


def moving_tag(schedule):
    """The tag of the body."""
    return re.search(r'tags = \["(.*)"\]', schedule)[1]


def condition(name, kind, schedule):
    """The boundary condition of a patch."""
    if name == moving_tag(schedule):
        return f"type solidBodyMotionDisplacement; {foam_motion(schedule)} value uniform (0 0 0);"
    if kind == "empty":
        return "type empty;"
    if f'fixed = ["{name}"' in schedule or f'"{name}"]' in schedule.split("slide")[0]:
        return "type fixedValue; value uniform (0 0 0);"
    return "type slip;"


def row(name, folder, mesh, schedule):
    """One row of the table."""
    azimesh("convert", mesh, folder / "reference.vtu", "--force")
    (folder / "warn.toml").write_text(schedule + '\n[output]\nformat = "vtu"\non_inverted = "warn"\n')
    azimesh("deform", mesh, folder / "warn.toml", "-o", folder / "warn", "--force", "-q")
    path = sorted((folder / "warn").glob("*_0001.*"))[-1]
    reference, start = pyvista.read(folder / "reference.vtu"), pyvista.read(path)
    cells, boundary = volume_cells(reference)
    if cells is None:
        return None
    x, y = np.asarray(reference.points, float), np.asarray(start.points, float)
    told = [name, str(folded(x, y, cells))]
    slides = "slide = " in schedule
    slide = ["--slide", "plane"] if slides else []
    out, own = azimesh("repair", path, "-o", folder / "out.vtu", "--reference", folder / "reference.vtu", "--json", "--force", "-q", *slide)
    after = np.asarray(pyvista.read(folder / "out.vtu").points, float)
    assert json.loads(out)["invalid"] >= 0
    told.append(f"{folded(x, after, cells)}, {own:.1f} s")
    of = lambda found: "-" if found is None else f"{folded(x, found[0], cells)}, {found[1]:.1f} s"  # noqa: E731
    told.append("-" if slides else of(elasticity(x, y, cells, boundary)))
    try:
        told.append(of(untangled_by_gmsh(path, cells, len(x))))
    except Exception as error:  # gmsh raises nothing narrower
        told.append(f"failed ({str(error)[:40]})")
    for solver in ("displacementLaplacian", "displacementSBRStress"):
        try:
            told.append(moved_by_foam(folder, mesh, schedule, solver))
        except (subprocess.TimeoutExpired, KeyError) as error:
            told.append(f"failed ({type(error).__name__})")
    return told


def main():
    """Runs the cases that are asked for."""
    words = sys.argv[2:]
    print("| case | folded in one step | `azimesh repair` | finite elements | gmsh | OpenFOAM, Laplacian | OpenFOAM, SBR stress |")
    print("|---|---|---|---|---|---|---|")
    for name, make in CASES.items():
        if words and not any(name.startswith(word) for word in words):
            continue
        with tempfile.TemporaryDirectory() as folder:
            if told := row(name, Path(folder), *make(Path(folder))):
                print("| " + " | ".join(told) + " |", flush=True)


if __name__ == "__main__":
    main()
