//! Sliding boundaries: symmetry planes, edges between planes, curved walls.

use crate::support::rewrite;
use crate::support::sequence::{
    Sequence, Vector, diagonal, distance, faces_of, nodes_of, read, same, testdata, write,
};
use azimesh_io::mesh::{CellKind, Mesh};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Nodes of the first tags that are on none of the others.
fn nodes_but(sequence: &Sequence, tags: &[&str], but: &[&str]) -> BTreeSet<usize> {
    let mut nodes = nodes_of(&sequence.reference, tags);
    let others = nodes_of(&sequence.reference, but);
    nodes.retain(|node| !others.contains(node));
    assert!(nodes.len() > 10);
    nodes
}

/// The farthest that any of the nodes has come.
fn farthest(sequence: &Sequence, points: &[Vector], nodes: &BTreeSet<usize>) -> f64 {
    let reference = &sequence.reference.points;
    let moved = nodes.iter().map(|&i| distance(points[i], reference[i]));
    moved.fold(0.0, f64::max)
}

#[test]
fn nodes_of_a_symmetry_plane_slide_in_it_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let wing = Sequence::of_testdata(folder.path(), "wing_on_plane", "wing_on_plane");
    wing.assert_sound();
    assert_eq!(wing.n_steps(), 9);
    let plane = nodes_of(&wing.reference, &["symmetry"]);
    let sliding = nodes_but(&wing, &["symmetry"], &["wing", "farfield"]);
    let fixed = nodes_of(&wing.reference, &["farfield"]);
    let moving = nodes_of(&wing.reference, &["wing"]);
    assert!(
        plane.intersection(&moving).count() > 10,
        "the wing stands on it"
    );
    let mut largest: f64 = 0.0;
    for (step, azimuth) in wing.numbers("azimuth_deg").into_iter().enumerate() {
        let points = wing.points(step);
        for &node in &plane {
            let z = wing.reference.points[node][2];
            assert_eq!(
                points[node][2].to_bits(),
                z.to_bits(),
                "step {step}, node {node}"
            );
        }
        for &node in &fixed {
            assert!(same(points[node], wing.reference.points[node]));
        }
        // Nose at -x up towards +y: clockwise.
        let pitch = (5.0 + 15.0 * azimuth.to_radians().sin()).to_radians();
        let (sin, cos) = pitch.sin_cos();
        for &node in &moving {
            let [x, y, z] = wing.reference.points[node];
            let exact = [cos * x + sin * y, cos * y - sin * x, z];
            assert!(
                distance(points[node], exact) < 1e-14,
                "step {step}, node {node}"
            );
        }
        largest = largest.max(farthest(&wing, &points, &sliding));
    }
    assert!(largest > 0.1, "nodes of the plane slide, by {largest}");
}

#[test]
fn a_box_that_slides_keeps_its_sides_edges_and_corners_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::copy(testdata("wing_on_plane.toml"), path.join("w.toml")).unwrap();
    let all = (
        "fixed = [\"farfield\"]\nslide = [\"symmetry\"]",
        "slide = [\"symmetry\", \"farfield\"]",
    );
    rewrite(path, "w.toml", "w.toml", &[all]);
    let mesh = testdata("wing_on_plane.vtu");
    let wing = Sequence::of(path, &mesh, &path.join("w.toml"), "out");
    wing.assert_sound();
    let sides = [(0, -2.5), (0, 3.0), (1, -2.5), (1, 2.5), (2, 0.0), (2, 3.0)];
    let moving = nodes_of(&wing.reference, &["wing"]);
    let points = wing.points(2);
    let mut most_in = [0.0f64; 4];
    for node in nodes_but(&wing, &["symmetry", "farfield"], &["wing"]) {
        assert!(!moving.contains(&node));
        let x = wing.reference.points[node];
        let on: Vec<_> = sides.iter().filter(|(axis, at)| x[*axis] == *at).collect();
        assert!(!on.is_empty());
        for (axis, at) in &on {
            assert_eq!(points[node][*axis].to_bits(), at.to_bits(), "node {node}");
        }
        most_in[on.len()] = most_in[on.len()].max(distance(x, points[node]));
    }
    let [_, side, edge, corner] = most_in;
    assert!(side > 0.1 && edge > 0.01, "{side} {edge}");
    assert_eq!(corner, 0.0);
}

#[test]
fn an_oblique_symmetry_plane_keeps_its_nodes_to_round_off() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut mesh = read(&testdata("wing_on_plane.vtu"));
    // About x by 30 degrees: the plane's normal is (0, -1/2, sqrt(3)/2).
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let tilted = |[x, y, z]: Vector| [x, cos * y - sin * z, sin * y + cos * z];
    mesh.points = mesh.points.into_iter().map(tilted).collect();
    let text = std::fs::read_to_string(testdata("wing_on_plane.toml")).unwrap();
    let text = text
        .replace(
            "[0.0, 0.0, -1.0]",
            &format!("{:?}", tilted([0.0, 0.0, -1.0])),
        )
        .replace("[0.0, 1.0, 0.0]", &format!("{:?}", tilted([0.0, 1.0, 0.0])))
        .replace("tolerance =", "method = \"all\"\ntolerance =");
    std::fs::write(path.join("w.toml"), text).unwrap();
    let file = path.join("w.vtu");
    write(&mesh, &file);
    let wing = Sequence::of(path, &file, &path.join("w.toml"), "out");
    wing.assert_sound();
    std::fs::copy(testdata("wing_on_plane.toml"), path.join("s.toml")).unwrap();
    let all = ("tolerance =", "method = \"all\"\ntolerance =");
    rewrite(path, "s.toml", "s.toml", &[all]);
    let mesh = testdata("wing_on_plane.vtu");
    let straight = Sequence::of(path, &mesh, &path.join("s.toml"), "straight");
    let points = wing.points(2);
    let limit = 1e-14 * diagonal(&points);
    let height = |x: Vector| (cos * x[2] - sin * x[1]).abs();
    for &node in &nodes_of(&wing.reference, &["symmetry"]) {
        assert!(
            height(points[node]) <= limit,
            "node {node}: {:e}",
            height(points[node])
        );
    }
    // With the same base points it does not matter which way the mesh lies.
    for (at, expected) in points.iter().zip(straight.points(2)) {
        let off = distance(*at, tilted(expected));
        assert!(off < 1e-9, "{off:e}");
    }
}

/// Returns whether `x` lies on a facet of the surface (a triangle, in the plane an edge), to `limit`.
fn on_surface(points: &[Vector], faces: &[Vec<usize>], x: Vector, limit: f64) -> bool {
    faces.iter().any(|face| {
        let corners: Vec<Vector> = face.iter().map(|&node| points[node]).collect();
        on_facet(&corners, x, limit)
    })
}

fn on_facet(corners: &[Vector], x: Vector, limit: f64) -> bool {
    let sub = |a: Vector, b: Vector| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let edges: Vec<Vector> = corners[1..].iter().map(|&c| sub(c, corners[0])).collect();
    let arm = sub(x, corners[0]);
    // Normal equations for the parameters of the nearest point of the facet's line or plane.
    let parameters = match edges[..] {
        [a] => vec![dot(a, arm) / dot(a, a)],
        [a, b] => {
            let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
            let (ax, bx) = (dot(a, arm), dot(b, arm));
            let det = aa * bb - ab * ab;
            vec![(bb * ax - ab * bx) / det, (aa * bx - ab * ax) / det]
        }
        _ => panic!("a facet has two or three corners"),
    };
    let mut foot = corners[0];
    for (edge, t) in edges.iter().zip(&parameters) {
        for axis in 0..3 {
            foot[axis] += t * edge[axis];
        }
    }
    let inside =
        parameters.iter().all(|t| *t >= -1e-9) && parameters.iter().sum::<f64>() <= 1.0 + 1e-9;
    inside && distance(x, foot) <= limit
}

/// Nodes of the tags stay on the surface that the tags are in the reference mesh.
fn assert_on_surface(sequence: &Sequence, tags: &[&str], at_least: f64) {
    let reference = &sequence.reference;
    let faces = faces_of(reference, tags);
    let nodes = nodes_of(reference, tags);
    let limit = 1e-12 * diagonal(&reference.points);
    let mut largest: f64 = 0.0;
    for step in 0..sequence.n_steps() {
        let points = sequence.points(step);
        for &node in &nodes {
            assert!(
                on_surface(&reference.points, &faces, points[node], limit),
                "step {step}, node {node}: {:?}",
                points[node]
            );
        }
        largest = largest.max(farthest(sequence, &points, &nodes));
    }
    assert!(largest > at_least, "they slide, by {largest}");
}

#[test]
fn nodes_of_a_wall_that_is_curved_both_ways_stay_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let duct = Sequence::of_testdata(folder.path(), "body_in_duct", "body_in_duct");
    duct.assert_sound();
    assert_on_surface(&duct, &["wall"], 0.1);
    for &node in &nodes_of(&duct.reference, &["inlet", "outlet"]) {
        assert!(same(duct.points(4)[node], duct.reference.points[node]));
    }
}

#[test]
fn nodes_of_a_circle_in_the_plane_stay_on_it() {
    let folder = crate::support::airfoil();
    let path = folder.path();
    let slide = ("fixed = [\"farfield\"]", "slide = [\"farfield\"]");
    rewrite(
        path,
        "n.toml",
        "n.toml",
        &[slide, ("step = 10.0", "step = 45.0")],
    );
    let out = Sequence::of(path, &path.join("n.vtu"), &path.join("n.toml"), "out");
    out.assert_sound();
    assert_on_surface(&out, &["farfield"], 0.05);
    for x in out.points(2) {
        assert_eq!(
            x[2].to_bits(),
            0.0f64.to_bits(),
            "a plane mesh stays in its plane"
        );
    }
}

#[test]
fn a_sliding_circle_follows_substeps_on_the_original_circle() {
    let folder = crate::support::airfoil();
    let path = folder.path();
    let changes = [
        ("fixed = [\"farfield\"]", "slide = [\"farfield\"]"),
        ("step = 10.0", "step = 90.0"),
        ("sin = 10.0", "sin = 40.0"),
        ("[rbf]", "[rbf]\nsubsteps = 3"),
    ];
    rewrite(path, "n.toml", "n.toml", &changes);
    let out = Sequence::of(path, &path.join("n.vtu"), &path.join("n.toml"), "out");
    out.assert_sound();
    assert_on_surface(&out, &["farfield"], 0.1);
}

#[test]
fn the_shipped_block_slides_along_the_square_and_turns_by_60_degrees() {
    let folder = tempfile::tempdir().unwrap();
    let block = Sequence::of_testdata(folder.path(), "block", "block_sliding");
    block.assert_sound();
    let edges = ["left", "right", "bottom", "top"];
    let points = block.points(6);
    for (tag, axis, at) in [
        ("left", 0, 0.0f64),
        ("right", 0, 1.0),
        ("bottom", 1, 0.0),
        ("top", 1, 1.0),
    ] {
        for node in nodes_of(&block.reference, &[tag]) {
            assert_eq!(
                points[node][axis].to_bits(),
                at.to_bits(),
                "{tag}, node {node}"
            );
        }
    }
    let nodes = nodes_of(&block.reference, &edges);
    assert!(farthest(&block, &points, &nodes) > 0.05);
    let (sin, cos) = 60f64.to_radians().sin_cos();
    for node in nodes_of(&block.reference, &["block"]) {
        let [x, y, _] = block.reference.points[node];
        let (x, y) = (x - 0.5, y - 0.5);
        let exact = [0.3 + cos * x - sin * y, 0.2 + sin * x + cos * y, 0.0];
        assert!(distance(points[node], exact) < 1e-14);
    }
}

/// `None` where the folder is not given, which is said loudly.
fn real_meshes() -> Option<PathBuf> {
    let folder = std::env::var_os("AZIMESH_TESTDATA");
    if folder.is_none() {
        eprintln!("AZIMESH_TESTDATA is not set: NO REAL MESH SLIDES");
    }
    folder.map(PathBuf::from)
}

/// A slice of a sphere's surroundings between two planes 9 degrees apart that meet in the x axis.
#[test]
fn the_sphere_of_su2_moves_between_two_symmetry_planes() {
    let Some(real) = real_meshes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mesh = real.join("su2code__TestCases/incomp_navierstokes/sphere/slice_2syms.su2");
    let schedule = testdata("real/slice_2syms.toml");
    let slice = Sequence::of(folder.path(), &mesh, &schedule, "out");
    slice.assert_sound();
    let (sin, cos) = 9f64.to_radians().sin_cos();
    let limit = 1e-12 * diagonal(&slice.reference.points);
    let flat = nodes_but(&slice, &["symmetry_right"], &["wall", "farfield"]);
    let tilted = nodes_but(&slice, &["symmetry_left"], &["wall", "farfield"]);
    let wall = nodes_of(&slice.reference, &["wall"]);
    let last = slice.n_steps() - 1;
    for step in 0..=last {
        let points = slice.points(step);
        for &node in &flat {
            let z = slice.reference.points[node][2];
            assert_eq!(
                points[node][2].to_bits(),
                z.to_bits(),
                "step {step}, node {node}"
            );
        }
        for &node in &tilted {
            let [_, y, z] = points[node];
            let off = (cos * z - sin * y).abs();
            let before = slice.reference.points[node];
            let off_before = (cos * before[2] - sin * before[1]).abs();
            assert!(
                off <= off_before + limit,
                "step {step}, node {node}: {off:e}"
            );
        }
        // On the axis nodes keep to both planes: they slide along it.
        for &node in flat.intersection(&tilted) {
            assert_eq!(points[node][1..], slice.reference.points[node][1..]);
        }
    }
    let points = slice.points(last);
    for &node in &wall {
        let [x, y, z] = slice.reference.points[node];
        assert!(distance(points[node], [x + 0.4, y, z]) < 1e-14);
    }
    for nodes in [&flat, &tilted] {
        assert!(farthest(&slice, &points, nodes) > 0.1);
    }
}

const AROUND: usize = 12;

/// An annulus of cells of second order from radius 1 to 2, in the plane or one cell high, with sides `hub`, `outer` and `ends`.
fn curved_annulus(high: bool) -> Mesh {
    let (n, m) = (2 * AROUND, 6);
    let n_layers = if high { 3 } else { 1 };
    let mut mesh = Mesh::default();
    for k in 0..n_layers {
        for j in 0..=m {
            for i in 0..n {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
                let r = 1.0 + j as f64 / m as f64;
                mesh.points.push([r * cos, r * sin, 0.2 * k as f64]);
            }
        }
    }
    let node = |i: usize, j: usize, k: usize| ((k * (m + 1) + j) * n + i % n) as u32;
    // Nodes of VTK's cells, in half cells.
    let edge = [0, 2, 1];
    let square = [
        [0, 0],
        [2, 0],
        [2, 2],
        [0, 2],
        [1, 0],
        [2, 1],
        [1, 2],
        [0, 1],
        [1, 1],
    ];
    let mut sides = [
        ("hub", Vec::new()),
        ("outer", Vec::new()),
        ("ends", Vec::new()),
    ];
    for j in (0..m).step_by(2) {
        for i in (0..n).step_by(2) {
            let flat = |k: usize| square.map(|[a, b]| node(i + a, j + b, k));
            if !high {
                mesh.cells.push(CellKind::Quadrilateral9, &flat(0));
            } else {
                let [low, middle, top] = [0, 1, 2].map(flat);
                let nodes = [
                    &low[..4],
                    &top[..4],
                    &low[4..8],
                    &top[4..8],
                    &middle[..4],
                    &[
                        middle[7], middle[5], middle[4], middle[6], low[8], top[8], middle[8],
                    ],
                ];
                mesh.cells.push(CellKind::Hexahedron27, &nodes.concat());
                sides[2].1.extend([low.to_vec(), top.to_vec()]);
            }
            for (side, at, is_there) in [(0, 0, j == 0), (1, m, j + 2 == m)] {
                if is_there && high {
                    sides[side]
                        .1
                        .push(square.map(|[a, b]| node(i + a, at, b)).to_vec());
                } else if is_there {
                    sides[side]
                        .1
                        .push(edge.map(|a| node(i + a, at, 0)).to_vec());
                }
            }
        }
    }
    for (name, faces) in sides.into_iter().filter(|(_, faces)| !faces.is_empty()) {
        let first = mesh.cells.len();
        for nodes in faces {
            let kind = match nodes.len() {
                3 => CellKind::Line3,
                _ => CellKind::Quadrilateral9,
            };
            mesh.cells.push(kind, &nodes);
        }
        mesh.add_tag(name, first..mesh.cells.len()).unwrap();
    }
    mesh
}

#[test]
fn nodes_of_a_wall_of_second_order_slide_on_its_curved_edges_and_faces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for high in [false, true] {
        write(&curved_annulus(high), &path.join("m.vtu"));
        let slide = if high { "\"hub\", \"ends\"" } else { "\"hub\"" };
        let schedule = format!(
            "steps = 2\nbody = [ {{ name = \"o\", tags = [\"outer\"], rigid = {{ rotate = {{ axis = [0, 0, 1], angle = 20 }}, translate = [0.2, 0, 0] }} }} ]\n\
             boundaries.slide = [{slide}]\n"
        );
        std::fs::write(path.join("s.toml"), schedule).unwrap();
        let out = Sequence::of(
            path,
            &path.join("m.vtu"),
            &path.join("s.toml"),
            &format!("out{high}"),
        );
        let off = out.numbers("max_surface_error");
        assert!(off.iter().all(|off| *off < 1e-13), "{off:?}");
        let points = out.points(1);
        let hub = nodes_of(&out.reference, &["hub"]);
        assert!(farthest(&out, &points, &hub) > 0.1);
        // An edge is a parabola through its ends and its middle.
        let half = std::f64::consts::PI / AROUND as f64;
        let mut largest: f64 = 0.0;
        for node in hub {
            let [x, y, z] = points[node];
            let from_middle = y.atan2(x).rem_euclid(2.0 * half) - half;
            let (along, radius) = (
                x.hypot(y) * from_middle.sin(),
                x.hypot(y) * from_middle.cos(),
            );
            let curve = 1.0 - (1.0 - half.cos()) * (along / half.sin()).powi(2);
            assert!(
                (radius - curve).abs() < 1e-12,
                "node {node}: {:e}",
                radius - curve
            );
            assert!(!high || (-1e-15..0.4 + 1e-15).contains(&z));
            largest = largest.max((x.hypot(y) - 1.0).abs());
        }
        assert!(
            largest > 1e-5,
            "nodes leave the circle that the reference nodes are on"
        );
    }
}
