"""Whatever is handed over: exceptions of Python, never a crash; no memory is lost."""

import gc
import os
import random
import resource

import numpy as np
import pytest

import azimesh

hypothesis = pytest.importorskip("hypothesis")
from hypothesis import given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402
from hypothesis.extra import numpy as hnp  # noqa: E402

# The same cases at every run; more of them with HYPOTHESIS_PROFILE=thorough.
settings.register_profile("same", derandomize=True, max_examples=300, deadline=None)
settings.register_profile("thorough", max_examples=50_000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

ALLOWED = (azimesh.Error, TypeError, ValueError, OverflowError, RuntimeWarning)
numbers = st.one_of(st.integers(-(2**70), 2**70), st.floats(), st.booleans(), st.none(), st.text(max_size=3), st.complex_numbers())
arrays = st.one_of(
    hnp.arrays(
        st.one_of(hnp.integer_dtypes(), hnp.unsigned_integer_dtypes(), hnp.floating_dtypes(), hnp.boolean_dtypes(), hnp.complex_number_dtypes()),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5),
    ),
    st.recursive(numbers, lambda inner: st.lists(inner, max_size=4), max_leaves=10),
)
points = st.one_of(arrays, st.just(np.eye(3)), st.just(np.eye(4)[:, :3]))
names = st.sampled_from(["triangle", "tetra", "line", "vertex", "polygon", "polyhedron", "quad9", "VTK_LAGRANGE_QUADRILATERAL", "no"])
blocks = st.one_of(arrays, st.tuples(arrays, arrays), st.just([[0, 1, 2]]), st.just([[0, 1]]))
groups = st.one_of(st.none(), st.dictionaries(st.text(max_size=2), arrays, max_size=2))


def tried(function, *arguments, **options):
    try:
        with np.errstate(all="ignore"):
            return function(*arguments, **options)
    except ALLOWED:
        return None


@given(points, st.lists(st.tuples(names, blocks), max_size=3), groups, groups)
def test_anything_as_a_mesh(points, cells, tags, data):
    mesh = tried(azimesh.Mesh, points, cells, tags=tags, point_data=data)
    if mesh is None:
        return
    assert mesh.n_cells == sum(len(places) for places in mesh.cell_index.values())
    tried(azimesh.quality, mesh)
    tried(azimesh.diff, mesh, mesh)
    for name in mesh.tags:
        mesh.tag_nodes(name), mesh.tag_faces(name)


@given(arrays, arrays, arrays)
def test_anything_to_a_morph(displacements, moving, fixed):
    mesh = azimesh.Mesh(np.eye(3), {"triangle": [[0, 1, 2]], "line": [[0, 1], [1, 2]]}, tags={"a": [1], "b": [2]})
    tried(azimesh.Morph, mesh, moving, fixed)
    tried(mesh.with_points, displacements)
    morph = azimesh.Morph(mesh.with_points([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), [0], [2])
    tried(morph, displacements)
    tried(morph.pull_back, displacements)


keys = st.recursive(
    st.one_of(numbers, st.sampled_from(["azimuth", "pitch"])),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["azimuth", "body", "name", "tags", "cyclic", "pitch", "sin", "stop", "step", "values", "displacements"]), inner, max_size=4),
    ),
    max_leaves=12,
)


@given(keys)
def test_anything_as_a_schedule(source):
    if not isinstance(source, str):
        tried(azimesh.Schedule, source)


def anything():
    """Arrays of wrong and right shapes, types and layouts, and what is no array."""
    good = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    wide = np.zeros((3, 6))
    wide[:, ::2] = good
    frozen = good.copy()
    frozen.flags.writeable = False
    numbers = [good, wide[:, ::2], frozen, np.asfortranarray(good), good.astype(">f8"), good.astype("f4"), good[::-1], good[:, :2], good.T, good[:0]]
    numbers += [np.full((3, 3), value) for value in (np.nan, np.inf, 1e308, -1.0)] + [np.zeros((3, 3, 1)), np.float64(2.0), np.zeros((0, 3)), np.zeros((10_000, 3))]
    indices = [np.array(values) for values in ([0, 1, 2], [0, -1], [3], [2**31], [2**62], [[0, 1, 2]], [[0, 1]], [], [0, 0, 0], [1.5], [True, False, True])]
    indices += [np.array([0, 1, 2], dtype=kind) for kind in ("u1", "i2", ">i4", "u8", "f8", "c16", "O", "S1", "U1", "M8[s]")]
    masked = np.ma.masked_array(good, mask=good > 0)
    others = [None, True, 0, -1, 2**80, 1.5, float("nan"), 1j, "", "a", "b", "no", b"a", "\0", "\ud800", object(), [], [[]], [[0, 1], [2]], {}, {"a": 1}, {1: "a"}, {"a": [1]}, {"a": good}]
    others += [[("triangle", [[0, 1, 2]])], {"triangle": [[0, 1, 2]]}, {"polygon": [[0, 1, 2]]}, {"polyhedron": [[[0, 1, 2]]]}, range(3), memoryview(b"abc"), slice(1), int, masked]
    return numbers + indices + others


def test_seeded_calls_with_anything(airfoil):
    """`AZIMESH_PYTHON_CALLS` sets how many."""
    mesh = azimesh.Mesh(np.eye(3), {"triangle": [[0, 1, 2]], "line": [[0, 1], [1, 2]]}, tags={"a": [1], "b": [2]})
    flat = mesh.with_points([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    morph = azimesh.Morph(flat, [0], [2])
    schedule = {"azimuth": {"values": [0.0, 90.0]}, "body": [{"name": "a", "tags": ["airfoil"], "cyclic": {"collective": 1.0}}], "boundaries": {"others": "fixed"}}
    deformation = azimesh.Deformation(airfoil, azimesh.Schedule(schedule))
    step = deformation[0]
    calls = [
        lambda a, b, c: azimesh.Mesh(a, b),
        lambda a, b, c: azimesh.Mesh(np.eye(3), {"triangle": a, "line": b}, tags={"a": c}),
        lambda a, b, c: azimesh.Mesh(np.eye(3), {"triangle": [[0, 1, 2]]}, tags=a, zones=b, cell_data=c),
        lambda a, b, c: azimesh.Mesh(np.eye(3), {"triangle": [[0, 1, 2]]}, point_data={"a": a}, field_data={"b": b}, cell_data={"c": c}),
        lambda a, b, c: mesh.with_points(a),
        lambda a, b, c: mesh.with_data(point_data={"a": a}, cell_data=b),
        lambda a, b, c: (mesh.tag_nodes(a), mesh.tag_faces(a)),
        lambda a, b, c: morph(a),
        lambda a, b, c: morph.pull_back(a),
        lambda a, b, c: morph.displacements_of(a),
        lambda a, b, c: deformation[a],
        lambda a, b, c: azimesh.diff(mesh, flat, tolerance=a, relative=b, match_tolerance=c),
        lambda a, b, c: azimesh.quality(mesh, a),
        lambda a, b, c: setattr(step, "points", a),
        lambda a, b, c: mesh.points.__setitem__(a, b),
        lambda a, b, c: step.points[a],
        lambda a, b, c: azimesh.Schedule({"azimuth": a, "body": b}),
        lambda a, b, c: azimesh.Schedule({**schedule, "body": [{"name": a, "tags": b, "displacements": c}]}),
    ]
    seldom = [
        lambda a, b, c: azimesh.Morph(flat, a, b, slide=c),
        lambda a, b, c: azimesh.Morph(flat, [0], [2], max_points=a, tolerance=b, support_radius=c),
        lambda a, b, c: azimesh.Morph(flat, [0], [2], kernel=a, periodic=b, samples=c),
        lambda a, b, c: morph.report(a),
        lambda a, b, c: azimesh.Deformation(a, b, base_points=c),
        lambda a, b, c: azimesh.from_meshio(a),
        lambda a, b, c: azimesh.quality(tried(azimesh.Mesh, a, b) or mesh),
    ]
    pool, pick = anything(), random.Random(1)
    allowed = (*ALLOWED, IndexError, KeyError, AttributeError)
    raised = 0
    for _ in range(int(os.environ.get("AZIMESH_PYTHON_CALLS", 20_000))):
        call = pick.choice(seldom if pick.random() < 0.01 else calls)
        try:
            call(pick.choice(pool), pick.choice(pool), pick.choice(pool))
        except allowed:
            raised += 1
    assert raised > 0


def test_strided_and_read_only_arrays_are_taken(cube):
    wide = np.zeros((8, 6))
    wide[:, ::2] = cube.points
    wide.flags.writeable = False
    assert (cube.with_points(wide[:, ::2]).points == cube.points).all()
    assert (cube.with_points(np.asfortranarray(cube.points)).points == cube.points).all()
    assert (cube.with_points(cube.points.astype(">f8")).points == cube.points).all()


def test_views_leak_nothing(testdata):
    mesh = azimesh.read(testdata / "wing_on_plane.vtu")
    for _ in range(2_000):
        mesh.points, mesh.cells, mesh.tags, mesh.point_data
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(100_000):
        mesh.points
    gc.collect()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2_000
