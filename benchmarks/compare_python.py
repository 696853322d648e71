"""azimesh in Python beside other packages on the same displacements; prints a table for benchmarks/README.md.

    python benchmarks/compare_python.py [--nodes 380000] [--steps 36] [--only NAME ...]

In an environment that has azimesh, SciPy, ferreus_rbf and PyGeM (from its repository: the name on the index is a
glacier model); one that is not there is left out. The sample blade, the paper's cyclic pitch and flap, the same base
points for all but azimesh's Morph. Every package is a process of its own, for its peak memory.
"""

import argparse
import importlib.util
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import azimesh

sys.path.append(str(Path(__file__).resolve().parents[1] / "scripts" / "verify"))
from reference import rotation  # noqa: E402

RADIUS = 5.625
STEPS = {"start": 0.0, "stop": 350.0, "step": 10.0}
BLADE = {
    "name": "blade",
    "tags": ["blade"],
    "cyclic": {"collective": 10.04, "pitch": [{"sin": -7.65, "cos": -0.96}], "coning": 2.619, "flap": [{"sin": 3.211, "cos": -0.421}]},
}
CALLS = 100
# Seconds of one step from which on 36 are not run.
LONG = 2.0


def schedule():
    return azimesh.Schedule(
        {
            "azimuth": STEPS,
            "body": [BLADE],
            "boundaries": {"fixed": ["outer"]},
            "rbf": {"support_radius": RADIUS},
            "selection": {"tolerance": 1e-4},
        }
    )


def turned(points, psi_deg):
    """The blade's nodes at an azimuth: pitch about the span (x), then flap about y, in plain numpy."""
    sin, cos = np.sin(np.radians(psi_deg)), np.cos(np.radians(psi_deg))
    pitch, flap = (np.radians(mean + a["sin"] * sin + a["cos"] * cos) for mean, a in ((BLADE["cyclic"]["collective"], BLADE["cyclic"]["pitch"][0]), (BLADE["cyclic"]["coning"], BLADE["cyclic"]["flap"][0])))
    return points @ (rotation([0, 1, 0], -flap) @ rotation([1, 0, 0], pitch)).T


def prepare(folder, nodes):
    """The mesh, its base points and the displacements of its surface at every step."""
    mesh_file = folder / "blade.vtu"
    subprocess.run([sys.executable, "-m", "azimesh", "sample", "blade", "--nodes", str(nodes), "-o", mesh_file, "-q"], check=True)
    mesh = azimesh.read(mesh_file)
    deformation = azimesh.Deformation(mesh, schedule())
    surface = np.union1d(mesh.tag_nodes("blade"), mesh.tag_nodes("outer"))
    blade = mesh.tag_nodes("blade")
    moved = np.zeros((len(deformation), len(surface), 3))
    for step in deformation.steps:
        moved[step.index, np.searchsorted(surface, blade)] = turned(mesh.points[blade], step.azimuth_deg) - mesh.points[blade]
    np.savez(folder / "case.npz", surface=surface, base=np.searchsorted(surface, deformation.base_points), moved=moved)


def by_azimesh(mesh, case):
    for step in azimesh.Deformation(mesh, schedule()):
        yield step.points


def by_morph(mesh, case):
    morph = azimesh.Morph(mesh, "blade", "outer", support_radius=RADIUS)
    own = np.searchsorted(case["surface"], morph.moving)
    yield from (morph(moved[own]) for moved in case["moved"])


def by_scipy(mesh, case):
    from scipy.interpolate import RBFInterpolator

    at = mesh.points[case["surface"][case["base"]]]
    for moved in case["moved"]:
        yield mesh.points + RBFInterpolator(at, moved[case["base"]], kernel="linear")(mesh.points)


def by_scipy_once(mesh, case):
    """One fit for all steps, which a motion that is known beforehand allows."""
    from scipy.interpolate import RBFInterpolator

    at = mesh.points[case["surface"][case["base"]]]
    values = np.moveaxis(case["moved"][:, case["base"]], 0, 1).reshape(len(at), -1)
    moved = RBFInterpolator(at, values, kernel="linear")(mesh.points).reshape(mesh.n_points, -1, 3)
    yield from (mesh.points + moved[:, step] for step in range(moved.shape[1]))


def by_pygem(mesh, case):
    from pygem import RBF

    at = mesh.points[case["surface"][case["base"]]]
    for moved in case["moved"]:
        yield RBF(at, at + moved[case["base"]], func="beckert_wendland_c2_basis", radius=RADIUS)(mesh.points)


def ferreus(kernel, mesh, case, nodes):
    from ferreus_rbf import RBFInterpolator
    from ferreus_rbf.interpolant_config import FittingAccuracy, FittingAccuracyType, InterpolantSettings, RBFKernelType

    accuracy = FittingAccuracy(1e-6, FittingAccuracyType.Absolute)
    reach = {"base_range": RADIUS} if kernel == "WendlandsC2" else {}
    settings = InterpolantSettings(getattr(RBFKernelType, kernel), fitting_accuracy=accuracy, **reach)
    at = np.ascontiguousarray(mesh.points[case["surface"][nodes]])
    targets = np.ascontiguousarray(mesh.points)
    for moved in case["moved"]:
        yield targets + RBFInterpolator(at, np.ascontiguousarray(moved[nodes]), settings).evaluate(targets)


def by_ferreus(mesh, case):
    yield from ferreus("Linear", mesh, case, slice(None))


def by_ferreus_base(mesh, case):
    yield from ferreus("Linear", mesh, case, case["base"])


PACKAGES = {
    "azimesh `Deformation`, exact surface": (by_azimesh, "azimesh"),
    "azimesh `Morph`, a step at a time": (by_morph, "azimesh"),
    "SciPy `RBFInterpolator`, linear, a fit a step": (by_scipy, "scipy"),
    "SciPy `RBFInterpolator`, linear, one fit": (by_scipy_once, "scipy"),
    "PyGeM `RBF`, Wendland C2": (by_pygem, "pygem"),
    "ferreus_rbf, linear, all surface nodes": (by_ferreus, "ferreus_rbf"),
    "ferreus_rbf, linear, base points": (by_ferreus_base, "ferreus_rbf"),
}


def measure(name, folder, n_steps):
    """What a package takes for some steps, its worst cell and its error at the surface."""
    mesh = azimesh.read(folder / "blade.vtu")
    case = dict(np.load(folder / "case.npz"))
    case["moved"] = case["moved"][:n_steps] if n_steps > 1 else case["moved"][27:28]
    before = mesh.points[case["surface"]]
    if name.startswith("azimesh `Deformation`") and n_steps == 1:
        STEPS.clear()
        STEPS["values"] = [270.0]
    error, worst, seconds = 0.0, None, 0.0
    moved = PACKAGES[name][0](mesh, case)
    for step in range(len(case["moved"])):
        started = time.perf_counter()
        points = next(moved)
        seconds += time.perf_counter() - started
        error = max(error, np.abs(points[case["surface"]] - before - case["moved"][step]).max())
        megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        worst = points if step == min(27, len(case["moved"]) - 1) else worst
    summary = azimesh.quality(mesh.with_points(worst), mesh).summary
    return seconds, megabytes, summary["min_scaled_jacobian"], summary["inverted"], error


def calls(folder):
    """Seconds of a call of Morph, and of a stored Cholesky factor with kernel values in blocks or stored too."""
    from scipy.linalg import cho_factor, cho_solve
    from scipy.spatial.distance import cdist

    mesh = azimesh.read(folder / "blade.vtu")
    case = np.load(folder / "case.npz")
    started = time.perf_counter()
    morph = azimesh.Morph(mesh, "blade", "outer", support_radius=RADIUS)
    rows = [("azimesh `Morph`, preparing", time.perf_counter() - started)]
    own = np.searchsorted(case["surface"], morph.moving)
    moved = case["moved"][27]

    def timed(name, call, times):
        started = time.perf_counter()
        for _ in range(times):
            call()
        rows.append((f"{name} ({times} calls)", (time.perf_counter() - started) / times))

    timed("azimesh `Morph`", lambda: morph(moved[own]), CALLS)
    timed("azimesh `Morph.pull_back`", lambda: morph.pull_back(mesh.points), CALLS)

    def kernel(points, base):
        xi = np.minimum(cdist(points, base) / RADIUS, 1.0)
        return (1.0 - xi) ** 4 * (4.0 * xi + 1.0)

    base = mesh.points[case["surface"][case["base"]]]
    factor = cho_factor(kernel(base, base))
    blocks = np.array_split(mesh.points, len(mesh.points) // 4096)

    def in_blocks():
        weights = cho_solve(factor, moved[case["base"]])
        return np.concatenate([kernel(block, base) @ weights for block in blocks])

    stored = np.concatenate([kernel(block, base) for block in blocks])
    timed("SciPy, stored factor, kernel in blocks", in_blocks, 3)
    timed(f"SciPy, stored factor and kernel ({stored.nbytes / 1e9:.1f} GB)", lambda: stored @ cho_solve(factor, moved[case["base"]]), CALLS)
    return rows


def in_process(*arguments):
    printed = subprocess.run([sys.executable, __file__, *map(str, arguments)], stdout=subprocess.PIPE)
    return json.loads(printed.stdout) if printed.returncode == 0 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=380_000)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--measure", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--calls", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        name, folder, n_steps = options.measure
        print(json.dumps(measure(name, Path(folder), int(n_steps))))
        return
    if options.calls:
        print(json.dumps(calls(Path(options.calls))))
        return
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder), options.nodes)
        print("| | 1 step, s | 36 steps, s | peak memory, MB | least scaled Jacobian | inverted cells | error at the surface |")
        print("|---|---|---|---|---|---|---|")
        for name, (_, package) in PACKAGES.items():
            if importlib.util.find_spec(package) is None or (options.only and name not in options.only):
                continue
            one = in_process("--measure", name, folder, 1)
            # What takes long for one step takes as long for each.
            is_long = one is not None and one[0] > LONG and PACKAGES[name][0] is not by_scipy_once
            all_steps = [36 * one[0], *one[1:]] if is_long else one and in_process("--measure", name, folder, 36)
            if one is None or all_steps is None:
                print(f"| {name} | failed | | | | | |", flush=True)
                continue
            seconds, megabytes, worst, inverted, error = all_steps
            print(f"| {name} | {one[0]:.2f} | {'36 x ' * is_long}{one[0] if is_long else seconds:.2f} | {megabytes:,.0f} | {worst:.3f} | {inverted} | {error:.1e} |", flush=True)
        for name, seconds in in_process("--calls", folder) or []:
            print(f"{name}: {seconds:.3f} s")


if __name__ == "__main__":
    main()
