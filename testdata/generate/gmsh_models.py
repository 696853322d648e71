"""Small meshes by gmsh: each function leaves one as gmsh's current model."""

import gmsh
import numpy as np


def model(name):
    """Starts an empty gmsh model."""
    gmsh.clear()
    gmsh.model.add(name)


def group(dimension, entities, name):
    """A physical group with a name."""
    gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, entities), name)


def naca0012(x):
    """Half thickness of the NACA 0012 section with a closed trailing edge."""
    return 0.6 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)


def airfoil_hybrid():
    """A NACA 0012 in a circle: quadrilaterals along the wall, triangles beyond; two zones."""
    model("airfoil_hybrid")
    geo = gmsh.model.geo
    n, layers = 40, 4
    angle = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    x = 0.5 * (1.0 + np.cos(angle))
    y = np.where(angle <= np.pi, 1.0, -1.0) * naca0012(x)
    wall = np.c_[x, y]
    normal = np.c_[np.cos(angle), 1.2 * np.sin(angle)]
    sheath = wall + 0.15 * normal
    inner = [geo.addPoint(a, b, 0.0) for a, b in wall]
    outer = [geo.addPoint(a, b, 0.0) for a, b in sheath]

    def around(points):
        return [geo.addLine(points[i], points[(i + 1) % n]) for i in range(n)]

    airfoil, interface = around(inner), around(outer)
    spokes = [geo.addLine(a, b) for a, b in zip(inner, outer)]
    for line in airfoil + interface:
        geo.mesh.setTransfiniteCurve(line, 2)
    for line in spokes:
        geo.mesh.setTransfiniteCurve(line, layers + 1, "Progression", 1.4)
    layer = []
    for i in range(n):
        loop = geo.addCurveLoop([spokes[i], interface[i], -spokes[(i + 1) % n], -airfoil[i]])
        layer.append(geo.addPlaneSurface([loop]))
        geo.mesh.setTransfiniteSurface(layer[-1])
        geo.mesh.setRecombine(2, layer[-1])
    centre = geo.addPoint(0.5, 0.0, 0.0)
    rim = [geo.addPoint(0.5 + 2.5 * c, 2.5 * s, 0.0, 0.5) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    circle = [geo.addCircleArc(rim[i], centre, rim[(i + 1) % 4]) for i in range(4)]
    field = geo.addPlaneSurface([geo.addCurveLoop(circle), geo.addCurveLoop(interface)])
    geo.synchronize()
    group(1, airfoil, "airfoil")
    group(1, circle, "farfield")
    group(2, layer, "boundary layer")
    group(2, [field], "field")
    gmsh.model.mesh.generate(2)


def sphere_in_box(size=1.0):
    """Tetrahedra between a sphere and a box; the box has four tags."""
    model("sphere_in_box")
    occ = gmsh.model.occ
    box = occ.addBox(-1.5, -1.5, -1.5, 3.0, 3.0, 3.0)
    sphere = occ.addSphere(0.0, 0.0, 0.0, 0.5)
    (_, volume), = occ.cut([(3, box)], [(3, sphere)])[0]
    occ.synchronize()
    named = {"sphere": [], "inlet": [], "outlet": [], "walls": []}
    for _, face in gmsh.model.getEntities(2):
        x, y, z = occ.getCenterOfMass(2, face)
        side = "inlet" if x < -1.4 else "outlet" if x > 1.4 else "walls"
        named["sphere" if max(abs(x), abs(y), abs(z)) < 1.0 else side].append(face)
    for name, faces in named.items():
        group(2, faces, name)
    group(3, [volume], "fluid")
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.setSize(gmsh.model.getBoundary([(2, face) for face in named["sphere"]], recursive=True), 0.4 * size)
    gmsh.model.mesh.generate(3)


def mixed_cells(cells=3, pyramids=True):
    """All four linear solids: a block of hexahedra, wedges beside it, pyramids and tetrahedra above."""
    model("mixed_cells")
    geo = gmsh.model.geo
    corner = [geo.addPoint(x, y, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (1.7, 0), (1.7, 1))]
    pairs = {"s": (0, 1), "e": (1, 2), "n": (2, 3), "w": (3, 0), "bs": (1, 4), "be": (4, 5), "bn": (5, 2)}
    line = {name: geo.addLine(corner[a], corner[b]) for name, (a, b) in pairs.items()}
    for tag in line.values():
        geo.mesh.setTransfiniteCurve(tag, cells + 1)
    floor = geo.addPlaneSurface([geo.addCurveLoop([line[k] for k in ("s", "e", "n", "w")])])
    loop = geo.addCurveLoop([line["bs"], line["be"], line["bn"], -line["e"]])
    beside = geo.addPlaneSurface([loop])
    geo.mesh.setTransfiniteSurface(floor)
    geo.mesh.setRecombine(2, floor)
    block = geo.extrude([(2, floor)], 0.0, 0.0, 0.6, [cells], recombine=True)
    wing = geo.extrude([(2, beside)], 0.0, 0.0, 0.6, [cells], recombine=True)
    solids = {"hexahedra": block[1][1], "wedges": wing[1][1]}
    if pyramids:
        solids["above"] = geo.extrude([block[0]], 0.0, 0.0, 0.8)[1][1]
    geo.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0 / cells)
    named = {"floor": [], "roof": [], "sides": []}
    outside = gmsh.model.getBoundary(gmsh.model.getEntities(3), oriented=False)
    for face in sorted(face for _, face in outside):
        low, high = (gmsh.model.getBoundingBox(2, face)[i] for i in (2, 5))
        named["floor" if high < 0.1 else "roof" if low > 0.5 else "sides"].append(face)
    for name, faces in named.items():
        group(2, faces, name)
    for name, solid in solids.items():
        group(3, [solid], name)
    gmsh.model.mesh.generate(3)


def curved_plate(incomplete):
    """Second-order triangles and quadrilaterals around a hole in a plate."""
    model("curved_plate")
    occ = gmsh.model.occ
    plate = occ.addRectangle(-1.0, -1.0, 0.0, 2.0, 2.0)
    hole = occ.addDisk(0.0, 0.0, 0.0, 0.4, 0.4)
    occ.cut([(2, plate)], [(2, hole)])
    beside = occ.addRectangle(1.0, -1.0, 0.0, 1.0, 2.0)
    occ.fragment([(2, 1)], [(2, beside)])
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.model.mesh.setTransfiniteSurface(beside)
    gmsh.model.mesh.setRecombine(2, beside)
    lines = {"hole": [], "rim": []}
    for _, line in gmsh.model.getBoundary(gmsh.model.getEntities(2), oriented=False):
        x, y, _ = occ.getCenterOfMass(1, line)
        lines["hole" if np.hypot(x, y) < 0.5 else "rim"].append(line)
    for name, entities in lines.items():
        group(1, entities, name)
    group(2, [surface for _, surface in gmsh.model.getEntities(2)], "plate")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


def curved_solids(incomplete):
    """Second-order solids: `mixed_cells` of one layer; no pyramids where they would have 14 nodes."""
    mixed_cells(1, pyramids=incomplete)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.model.mesh.setOrder(2)


def shared_faces():
    """A box whose one side belongs to two boundary tags."""
    model("shared_faces")
    occ = gmsh.model.occ
    box = occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    faces = [face for _, face in gmsh.model.getEntities(2)]
    group(2, faces, "all sides")
    group(2, faces[:1], "monitored")
    group(3, [box], "fluid")
    gmsh.model.mesh.generate(3)
