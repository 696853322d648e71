"""`convert --mirror`, `--repeat` and `--merge --join` against gmsh and OpenFOAM: `.venv/bin/python scripts/verify whole`.

gmsh gives the length, area or volume of each tag and zone before and after, and the smallest Jacobian of curved cells; checkMesh says "Mesh OK" of a
sector that was made whole and deformed. With AZIMESH_TESTDATA real meshes too.
"""

import re

import gmsh
import numpy as np

import foam
from meshes import quiet_gmsh
from program import TESTDATA, azimesh, real_meshes, report, scratch

# A mesh, the options that make a whole of it, how many copies that is, and the tags between the copies.
OWN = [
    ("wing_on_plane.vtu", ["--mirror", "z"], 2, {"symmetry"}),
    ("rotor_sector.vtu", ["--repeat", "4", "--axis", "z"], 4, {"side_a", "side_b"}),
    ("rotor_sector.vtu", ["--repeat", "4", "--axis", "z,-90"], 4, {"side_a", "side_b"}),
]
REAL = [
    ("CGNS__CGNS/src/tests/data/cgnslib_vers-3000.cgns", ["--mirror", "z"], 2, None),
    ("mfem__mfem/data/torus-pi-3.msh", ["--repeat", "6", "--axis", "z"], 6, {"2", "3"}),
    ("mfem__mfem/data/annulus-pi-3.msh", ["--repeat", "6", "--axis", "z"], 6, None),
    ("petsc__petsc/share/petsc/datafiles/meshes/gmsh-hex-20node.msh", ["--repeat", "6", "--axis", "z"], 6, {"start", "end"}),
    ("pyvista__vtk-data/Data/AngularSector.vtk", ["--repeat", "4", "--axis", "z"], 4, set()),
]
# Curved cells: each across its side of least x.
CURVED = ["curved_solids_complete_v22.msh", "curved_solids_serendipity_v22.msh", "curved_plate_complete_v41.msh"]


def sizes(mesh, folder):
    """The size of each tag and zone, its number of a copy left out, and of all cells; the smallest Jacobian; the least x."""
    azimesh("convert", mesh, folder / "sizes.msh", "--force")
    with quiet_gmsh():
        gmsh.open(str(folder / "sizes.msh"))
        dimension = max(d for d, _ in gmsh.model.getEntities() if gmsh.model.mesh.getElements(d)[0].size)
        found, jacobian = {}, np.inf
        for d, entity in gmsh.model.getEntities():
            elements = np.concatenate([*gmsh.model.mesh.getElements(d, entity)[1], np.empty(0, np.uint64)])
            if d < dimension - 1 or not elements.size:
                continue
            size = gmsh.model.mesh.getElementQualities(elements, "volume").sum()
            names = {gmsh.model.getPhysicalName(d, n) or str(n) for n in gmsh.model.getPhysicalGroupsForEntity(d, entity)}
            if d == dimension:
                jacobian = min(jacobian, gmsh.model.mesh.getElementQualities(elements, "minDetJac").min())
                names.add("all cells")
            for name in names:
                found[d, name] = found.get((d, name), 0.0) + size
        least = gmsh.model.mesh.getNodes()[1].reshape(-1, 3)[:, 0].min()
    return found, jacobian, float(least)


def compare(mesh, options, n, between, folder):
    """Makes a whole of a mesh; the number of sizes that are compared and their largest difference."""
    before, least_before, _ = sizes(mesh, folder)
    azimesh("convert", mesh, folder / "whole.vtu", "--force", *options)
    after, least_after, _ = sizes(folder / "whole.vtu", folder)
    assert abs(least_after - least_before) < 1e-9 * abs(least_before), f"{mesh}: Jacobians {least_before} and {least_after}"
    of_copies = {}
    for (d, name), size in after.items():
        plain = re.sub(r"_\d+$", "", name)
        key = (d, name if (d, name) in before else plain)
        of_copies[key] = of_copies.get(key, 0.0) + size
    apart = []
    for (d, name), size in before.items():
        is_cells = d == max(d for d, _ in before)
        if between is None and not is_cells:
            continue
        wanted = 0.0 if name in (between or ()) and not is_cells else n * size
        apart.append(abs(of_copies.get((d, name), 0.0) - wanted) / max(abs(n * size), 1e-300))
    assert max(apart) < 1e-9, f"{mesh} {options}: sizes differ by {max(apart)}"
    return len(apart), max(apart)


def merged(folder):
    """Two sectors side by side, joined, are the sector repeated twice."""
    sector = TESTDATA / "rotor_sector.vtu"
    azimesh("convert", sector, folder / "next.vtu", "--rotate", "z,90", "--rename-tag", "side_a=gap", "--force")
    azimesh("convert", "--merge", sector, folder / "next.vtu", folder / "pair.vtu", "--join", "--force")
    azimesh("convert", sector, folder / "twice.vtu", "--repeat", "2", "--axis", "z,90", "--force")
    [pair, twice] = [sizes(folder / f"{name}.vtu", folder)[0][3, "all cells"] for name in ("pair", "twice")]
    return 1, abs(pair - twice) / twice


def deformed(folder):
    """A rotor of four sectors, whose blades turn; times of which checkMesh says that the mesh is good."""
    azimesh("convert", TESTDATA / "rotor_sector.vtu", folder / "rotor.vtu", "--repeat", "4", "--axis", "z", "--force")
    blade = '[[body]]\nname = "blade_{0}"\ntags = ["blade_{0}"]\nazimuth_offset = {1}\n[body.cyclic]\ncollective = 8.0\npitch = [ {{ sin = -7.0 }} ]\n'
    blades = "".join(blade.format(i + 1, 90 * i) for i in range(4))
    fixed = [f"{name}_{i}" for name in ("hub_wall", "outer", "bottom", "top") for i in range(1, 5)]
    text = f"azimuth.values = [0, 90, 180]\n{blades}[boundaries]\nfixed = {fixed}\n[rbf]\nsupport_radius = 3.0\n".replace("'", '"')
    (folder / "rotor.toml").write_text(text)
    azimesh("deform", folder / "rotor.vtu", folder / "rotor.toml", "-o", folder / "run", "--format", "openfoam")
    said = foam.run(foam.make_system(folder / "run"), "checkMesh")
    assert "Failed" not in said, said[-2000:]
    return said.count("Mesh OK")


def main():
    """Compares all."""
    with scratch() as folder:
        jobs = [(TESTDATA / name, *rest) for name, *rest in OWN]
        for name in CURVED:
            least = sizes(TESTDATA / name, folder)[2]
            jobs.append((TESTDATA / name, ["--mirror", f"x,{least!r}"], 2, None))
        if real := real_meshes():
            jobs += [(real / name, *rest) for name, *rest in REAL]
        found = [compare(*job, folder) for job in jobs] + [merged(folder)]
        n_good = deformed(folder) if foam.is_there("checkMesh") else 0
    n, largest = zip(*found)
    report("whole", sum(n), max(largest), "sizes of tags and zones", f"{len(jobs)} meshes; checkMesh: Mesh OK at {n_good} times")


if __name__ == "__main__":
    main()
