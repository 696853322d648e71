"""Every file of testdata through every format, read back by a third party.

Nodes bit for bit, cells in order, boundary tags and zones by name; `azimesh diff` must agree.
"""

import json
from pathlib import Path

import meshes
from program import TESTDATA, azimesh, report, scratch

ENDINGS = {"vtu": ".vtu", "msh": ".msh", "msh22": ".msh2", "su2": ".su2"}
SU2_KINDS = {3, 5, 9, 10, 12, 13, 14}


def sources():
    """All meshes of testdata."""
    known = set(ENDINGS.values())
    return sorted(path for path in TESTDATA.iterdir() if path.suffix in known)


def targets(mesh):
    """Formats that can hold these cells: polyhedra and polygons only VTU, SU2 only linear ones.

    Not MSH 2.2 where a node is in no cell: gmsh drops such nodes when it reads that.
    """
    kinds = {kind for cells in mesh.cells.values() for kind, _ in cells}
    if kinds & {7, 42}:
        return ["vtu"]
    if not kinds <= SU2_KINDS | {1}:
        return ["vtu", "msh", "msh22"]
    used = {node for cells in mesh.cells.values() for _, nodes in cells for node in nodes}
    if len(used) < len(mesh.points):
        return ["vtu", "msh", "su2"]
    return list(ENDINGS)


def assert_same(found, wanted, what, name):
    """Everything that format `name` holds: SU2 has no zones and no spaces in names.

    meshio sorts the cells of SU2 by type.
    """
    meshes.assert_same_points(found.points, wanted.points, what)
    su2 = name == "su2"
    meshes.assert_same_cells(found.volume_cells, wanted.volume_cells, what, across_kinds=not su2)
    tags = {name.replace(" ", "_") if su2 else name: faces for name, faces in wanted.tags.items()}
    meshes.assert_same_groups(found.tags, tags, f"{what}: tags")
    if not su2:
        meshes.assert_same_groups(found.zones, wanted.zones, f"{what}: zones")


def convert(source, target, *options):
    """Converts a mesh and returns the new path."""
    azimesh("convert", source, target, *options)
    return target


def assert_diff_agrees(first, second):
    """`azimesh diff` finds no difference but arrays that MSH and SU2 cannot hold."""
    found = json.loads(azimesh("diff", "--json", first, second, expect=(0, 1)))
    others = {key: value for key, value in found.items() if key.endswith("_differences")}
    arrays = others.pop("array_differences")
    others |= {key: found[key] for key in ("moved_nodes", "changed_cells")}
    assert not any(others.values()), f"{first} and {second}: {found}"
    assert all("is only in" in sentence for sentence in arrays), f"{first} and {second}: {arrays}"


def check_source(source, folder):
    """All pairs of formats that start from this file; returns the number of meshes compared."""
    wanted = meshes.third_party(source)
    names = targets(wanted)
    from_su2 = source.suffix == ".su2"
    written = {}
    for name in names:
        written[name] = convert(source, folder / f"{source.stem}{ENDINGS[name]}")
        what = f"{source.name} as {name}"
        assert_same(meshes.third_party(written[name]), wanted, what, "su2" if from_su2 else name)
        if name != "su2":
            assert_diff_agrees(source, written[name])
    for first, path in written.items():
        for second in names:
            target = convert(path, folder / f"{first}_{second}{ENDINGS[second]}")
            narrow = "su2" if "su2" in (first, second) else second
            what = f"{source.name} by {first} to {second}"
            assert_same(meshes.third_party(target), wanted, what, "su2" if from_su2 else narrow)
            assert_diff_agrees(path if first == "su2" else written[second], target)
    return len(names) * (1 + len(names)) + check_meshio(source, wanted, names, folder)


def check_meshio(source, wanted, names, folder):
    """meshio on our MSH files and on VTU without string arrays; tags are numbers there.

    It refuses MSH 4.1 where some cells are in a group and others are not, and knows too little of second-order wedges.
    """
    if {kind for kind, _ in wanted.volume_cells} & {26, 32, 42}:
        return 0
    plain = folder / f"{source.stem}_plain.vtu"
    convert(source, plain, "--encoding", "base64", "--tag-names", "none")
    all_in_groups = sum(map(len, wanted.zones.values())) >= len(wanted.volume_cells)
    readable = ["msh", "msh22"] if all_in_groups else ["msh22"]
    compared = [plain] + [folder / f"{source.stem}{ENDINGS[name]}" for name in readable if name in names]
    for path in compared:
        found = meshes.by_meshio(path)
        what = f"{source.name} as {path.name} by meshio"
        meshes.assert_same_points(found.points, wanted.points, what)
        meshes.assert_same_cells(found.volume_cells, wanted.volume_cells, what, across_kinds=False)
    faces = sorted(map(sorted, meshes.by_meshio(plain).tags.values()))
    numbered = sorted(map(sorted, meshes.by_pyvista(plain).tags.values()))
    assert faces == numbered, f"{source.name}: tags in {plain.name}"
    return len(compared)


def main():
    """One line in all."""
    n_compared = 0
    for source in sources():
        with scratch() as folder:
            n_compared += check_source(Path(source), folder)
    report("formats", n_compared, 0.0, "meshes", f"{len(sources())} files of testdata")
