"""Motions, boundaries, zones, methods and outputs mixed at random: ranks of MPI give what one run gives, to the
byte, end with the same code and warn of the same.

    CASES   how many mixtures (16)
    SEED    where chance begins
"""

import os
import random
import subprocess

import gmsh
import numpy
import pyvista
from meshes import quiet_gmsh
from mpi import ALLOWED, command
from outputs import content, same
from program import AZIMESH, azimesh, report, scratch

CASES = int(os.environ.get("CASES", "16"))
SEED = int(os.environ.get("SEED", "20261126"))


def drum(path):
    """A box in a cylinder, the zone `rotor`, inside a box: both ends of the zone lie on the boundary, so that it has a rim there."""
    shapes = gmsh.model.occ
    cylinder = lambda: (3, shapes.addCylinder(0, 0, -0.5, 0, 0, 1, 0.6))
    inside, _ = shapes.cut([cylinder()], [(3, shapes.addBox(-0.15, -0.05, -0.1, 0.3, 0.1, 0.2))])
    around, _ = shapes.cut([(3, shapes.addBox(-1, -1, -0.5, 2, 2, 1))], [cylinder()])
    shapes.fragment(around, inside)
    shapes.synchronize()
    rotor, background = sorted(gmsh.model.getEntities(3), key=lambda volume: shapes.getMass(*volume))
    tags = {"body": set(), "near_caps": set(), "far_caps": set(), "sides": set()}
    for volume, caps in ((rotor, "near_caps"), (background, "far_caps")):
        for face in gmsh.model.getBoundary([volume], oriented=False):
            low, high = (gmsh.model.getBoundingBox(*face)[at : at + 3] for at in (0, 3))
            x, y, z = (abs(b - a) for a, b in zip(low, high, strict=True))
            if max(x, y) < 0.35:
                tags["body"].add(face[1])
            elif z < 1e-3:
                tags[caps].add(face[1])
            elif min(x, y) < 1e-3:
                tags["sides"].add(face[1])
    for name, faces in tags.items():
        gmsh.model.addPhysicalGroup(2, sorted(faces), name=name)
    gmsh.model.addPhysicalGroup(3, [rotor[1]], name="rotor")
    gmsh.model.addPhysicalGroup(3, [background[1]], name="background")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.05)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(path))


def rotor(path):
    """A blade around which the mesh is a zone, with arrays at nodes and cells."""
    azimesh("sample", "rotor", "--nodes", 80_000, "--surface-nodes", 6000, "--first-cell", 0.003, "-o", path.with_suffix(".vtu"))
    mesh = pyvista.read(path.with_suffix(".vtu"))
    mesh.point_data["from hub"] = mesh.points.astype("float32")
    # As a run leaves it, but of other numbers.
    mesh.point_data["Displacement"] = mesh.points[:, 0].astype("float32")
    mesh.cell_data["part"] = numpy.arange(mesh.n_cells) // 1000
    mesh.save(path.with_suffix(".vtu"))
    azimesh("convert", path.with_suffix(".vtu"), path)
    azimesh("convert", path, path.with_suffix(".msh"))


def schedule(chance, is_drum):
    """A schedule of any kind."""
    one, often = chance.choice, lambda part: chance.random() < part
    lines = ["version = 1", 'angle_unit = "deg"', "[azimuth]", "start = 0.0", f"stop = {one([30.0, 90.0])}", "step = 30.0"]
    lines += ["[rotor]", "hub = [0.0, 0.0, 0.0]", "span_axis = [1.0, 0.0, 0.0]", "shaft_axis = [0.0, 0.0, 1.0]", "rpm = 300.0"]
    lines += [f'frame = "{one(["rotating", "inertial"])}"']
    lines += ["[[body]]", 'name = "b"', f'tags = ["{"body" if is_drum else "blade"}"]']
    motion = one(["cyclic", "rigid", "both"])
    if motion != "rigid":
        lines += ["[body.cyclic]", f"collective = {one([0.0, 3.0, 20.0, 60.0])}", f"coning = {one([0.0, 1.5])}"]
        lines += [f"pitch = [ {{ sin = {one([-4.0, 70.0])}, cos = {one([0.0, 1.0])} }} ]"]
    if motion != "cyclic":
        lines += ["[body.rigid]", f"translate = [{one([0.0, 0.02])}, 0.05, {one([0.0, 0.13])}]"]
    lines += ["[boundaries]"] + (['zones = ["rotor"]'] if often(0.6) else [])
    roles = {}
    for tag in ("near_caps", "far_caps", "sides") if is_drum else ("farfield",):
        roles.setdefault(one(["fixed", "slide", "free"]), []).append(f'"{tag}"')
    lines += [f"{role} = [{', '.join(tags)}]" for role, tags in roles.items()]
    radius = one([0.25, 0.5, 3.0] if is_drum else [0.4, 5.6])
    lines += ["[rbf]", f'kernel = "{one(["wendland-c2", "wendland-c0"])}"', f"support_radius = {radius}"]
    lines += ['interpolate = "twist"'] * often(0.25) + ['polynomial = "linear"'] * often(0.2) + ["substeps = 2"] * often(0.2)
    lines += ["[selection]", f"tolerance = {one([1e-3, 3e-4])}"]
    lines += ["correction = false"] * often(0.2) + ['method = "real"'] * often(0.2)
    written = one(["vtu", "vtkhdf", "cgns", "ugrid-b8", "ugrid-lb8l"])
    lines += ["[output]", f'format = "{written}"', f'on_inverted = "{one(["warn", "repair", "stop", "substeps"])}"']
    lines += ['precision = "f32"'] * (often(0.3) and "ugrid" not in written)
    lines += [f'quality = "{one(["none", "cells"])}"'] * often(0.25) + ["velocity = true"] * often(0.35) + ["displacement = true"] * often(0.3)
    return "\n".join(lines) + "\n"


def warnings(said):
    """The warnings among what was told."""
    return sorted(line for line in said.splitlines() if line.startswith("warning"))


def run(*arguments):
    """Runs a command; gives its exit code and its warnings."""
    done = subprocess.run([*map(str, arguments)], capture_output=True, text=True, env=os.environ | ALLOWED)
    assert done.returncode in (0, 1, 2), f"{arguments}\n{done.stderr}"
    return done.returncode, warnings(done.stderr)


def main():
    chance, n_files, n_refused = random.Random(SEED), 0, 0
    with scratch() as folder:
        with quiet_gmsh():
            drum(folder / "drum.msh")
        azimesh("convert", folder / "drum.msh", folder / "drum.vtkhdf")
        rotor(folder / "rotor.vtkhdf")
        # With the surface first or layer by layer, and along a curve: then nodes of the surface lie everywhere.
        names = ["drum", "rotor", "drum_along", "rotor_along"]
        for name in names[:2]:
            for ending in ("vtkhdf", "msh"):
                azimesh("convert", "--reorder", folder / f"{name}.{ending}", folder / f"{name}_along.{ending}")
        for name in names:
            for ending in ("cgns", "vtu"):
                azimesh("convert", folder / f"{name}.vtkhdf", folder / f"{name}.{ending}", "--force")
        for case in range(CASES):
            name, ending = chance.choice(names), chance.choice(["vtkhdf", "cgns", "vtu", "msh"])
            mesh, steps = folder / f"{name}.{ending}", folder / f"{case}.toml"
            steps.write_text(schedule(chance, name.startswith("drum")))
            what = f"case {case} of seed {SEED}, {mesh.name}:\n{steps.read_text()}"
            alone = folder / f"{case}_alone"
            ended, told = run(AZIMESH, "-v", "deform", "--allow-outside", mesh, steps, "-o", alone)
            ranks = folder / f"{case}_ranks"
            shared = run(*command(chance.choice([2, 3, 4]), "-v", "deform", "--allow-outside", mesh, steps, "-o", ranks))
            assert shared == (ended, told), f"{what}ranks end with {shared}, one run with {(ended, told)}"
            if ended == 2:
                n_refused += 1
                continue
            n_files += same(content(ranks), content(alone), f"{what}ranks")
    assert n_refused < CASES / 2, f"{n_refused} of {CASES} mixtures are refused"
    report("mixtures: ranks beside one run", n_files, 0, "files", f"{CASES} mixtures, {n_refused} of them refused by all")
