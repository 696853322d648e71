"""Meshes of bodies that move beside sliding, symmetric and periodic boundaries, by gmsh."""

import gmsh
import numpy as np

from gmsh_models import group, model, naca0012


def section(chord, thickness, place):
    """A wire of a NACA 00xx section, chord from -1/4 to 3/4; `place` puts (chordwise, upward) in space."""
    occ = gmsh.model.occ
    angle = np.linspace(0.0, np.pi, 9)
    x = 0.5 * (1.0 - np.cos(angle))
    y = naca0012(x) * thickness / 0.12
    ahead = [occ.addPoint(*place(chord * (a - 0.25), chord * b)) for a, b in zip(x, y)]
    below = [occ.addPoint(*place(chord * (a - 0.25), -chord * b)) for a, b in zip(x[1:-1], y[1:-1])]
    upper = occ.addSpline(ahead)
    lower = occ.addSpline([ahead[0], *below, ahead[-1]])
    return occ.addCurveLoop([upper, -lower])


def without(outside, body):
    """The volume between a body and its surroundings, and the faces round it by the centres of mass."""
    occ = gmsh.model.occ
    (_, volume), = occ.cut([(3, outside)], [(3, body)])[0]
    occ.synchronize()
    faces = [face for _, face in gmsh.model.getBoundary([(3, volume)], oriented=False)]
    return volume, {face: np.array(occ.getCenterOfMass(2, face)) for face in faces}


def generate(volume, named, near, sizes, reach):
    """Tags, sizes growing from the faces `near` over `reach`, and tetrahedra."""
    for name, faces in named.items():
        group(2, faces, name)
    group(3, [volume], "fluid")
    field = gmsh.model.mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "SurfacesList", near)
    field.setNumber(distance, "Sampling", 40)
    growing = field.add("Threshold")
    values = {"InField": distance, "SizeMin": sizes[0], "SizeMax": sizes[1], "DistMin": 0.0, "DistMax": reach}
    for key, value in values.items():
        field.setNumber(growing, key, value)
    field.setAsBackgroundMesh(growing)
    for key in ("MeshSizeFromPoints", "MeshSizeExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.{key}", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", sizes[1])
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("Netgen")
    for key in ("MeshSizeFromPoints", "MeshSizeExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.{key}", 1)


def wing_on_plane():
    """A tapered wing that stands on the symmetry plane z = 0 of a box, tetrahedra."""
    model("wing_on_plane")
    occ = gmsh.model.occ
    root = section(1.0, 0.15, lambda x, y: (x, y, 0.0))
    tip = section(0.6, 0.15, lambda x, y: (x, y, 1.2))
    (_, wing), = occ.addThruSections([root, tip], makeRuled=True)
    box = occ.addBox(-2.5, -2.5, 0.0, 5.5, 5.0, 3.0)
    volume, faces = without(box, wing)
    named = {"wing": [], "symmetry": [], "farfield": []}
    for face, centre in faces.items():
        near = max(abs(centre)) < 1.5 and centre[2] > 1e-6
        named["wing" if near else "symmetry" if centre[2] < 1e-6 else "farfield"].append(face)
    generate(volume, named, named["wing"], (0.1, 0.9), 2.5)


def exactly_periodic(faces):
    """Nodes of the faces where a quarter turn takes those of the other side, to the last bit."""
    for face in faces:
        _, nodes, masters, _ = gmsh.model.mesh.getPeriodicNodes(2, face)
        for node, master in zip(nodes, masters):
            (x, y, z), *_ = gmsh.model.mesh.getNode(master)
            gmsh.model.mesh.setNode(node, [-y, x, z], [])


def rotor_sector():
    """A blade in a quarter of an annulus round the z axis; nodes of the sides match when turned by 90 degrees."""
    model("rotor_sector")
    occ = gmsh.model.occ
    inner = section(0.4, 0.18, lambda x, y: (0.9, -x, y))
    outer = section(0.3, 0.18, lambda x, y: (1.9, -x, y))
    (_, blade), = occ.addThruSections([inner, outer], makeRuled=True)
    rim = [occ.addPoint(r, 0.0, z) for r, z in ((0.4, -0.8), (2.5, -0.8), (2.5, 0.8), (0.4, 0.8))]
    loop = occ.addCurveLoop([occ.addLine(rim[i], rim[(i + 1) % 4]) for i in range(4)])
    start = [(2, occ.addPlaneSurface([loop]))]
    occ.rotate(start, 0, 0, 0, 0, 0, 1, -np.pi / 4)
    sector, = (tag for dim, tag in occ.revolve(start, 0, 0, 0, 0, 0, 1, np.pi / 2) if dim == 3)
    volume, faces = without(sector, blade)
    named = {name: [] for name in ("blade", "hub_wall", "outer", "side_a", "side_b", "bottom", "top")}
    for face, (x, y, z) in faces.items():
        radius, side = np.hypot(x, y), np.degrees(np.arctan2(y, x))
        sides = "side_a" if side < -44 else "side_b" if side > 44 else None
        planes = "bottom" if z < -0.79 else "top" if z > 0.79 else None
        walls = "hub_wall" if radius < 0.5 else "outer" if radius > 2.1 else "blade"
        named[sides or planes or walls].append(face)
    quarter = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    gmsh.model.mesh.setPeriodic(2, named["side_b"], named["side_a"], quarter)
    generate(volume, named, named["blade"], (0.07, 0.4), 0.9)
    exactly_periodic(named["side_b"])


def body_in_duct():
    """A sphere in a duct that swells in its middle, tetrahedra; the wall is curved both ways."""
    model("body_in_duct")
    occ = gmsh.model.occ
    x = np.linspace(-2.0, 2.0, 9)
    wall = [occ.addPoint(a, 1.0 + 0.25 * np.cos(0.25 * np.pi * a) ** 2, 0.0) for a in x]
    ends = [occ.addPoint(a, 0.0, 0.0) for a in (-2.0, 2.0)]
    outline = [
        occ.addLine(ends[0], wall[0]), occ.addSpline(wall), occ.addLine(wall[-1], ends[1]), occ.addLine(ends[1], ends[0]),
    ]  # fmt: skip
    half = [(2, occ.addPlaneSurface([occ.addCurveLoop(outline)]))]
    duct, = (tag for dim, tag in occ.revolve(half, 0, 0, 0, 1, 0, 0, 2 * np.pi) if dim == 3)
    sphere = occ.addSphere(0.0, 0.0, 0.0, 0.35)
    volume, faces = without(duct, sphere)
    named = {name: [] for name in ("body", "wall", "inlet", "outlet")}
    for face in faces:
        low, high = (np.array(gmsh.model.getBoundingBox(2, face)[i : i + 3]) for i in (0, 3))
        ends = "inlet" if high[0] < -1.9 else "outlet" if low[0] > 1.9 else None
        named[ends or ("body" if high[1] < 0.5 else "wall")].append(face)
    generate(volume, named, named["body"], (0.12, 0.33), 0.9)
