//! Periodic pairs: paired nodes move identically, and the field is that of the whole mesh.

use crate::support::sequence::{
    Sequence, Vector, diagonal, distance, nodes_of, read, same, testdata, write,
};
use crate::support::{rewrite, succeed};
use azimesh_io::mesh::{CellKind, Mesh};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Pairs of nodes of two tags of which the second is the image of the first, by the reference mesh.
fn pairs(mesh: &Mesh, [a, b]: [&str; 2], image: impl Fn(Vector) -> Vector) -> Vec<(usize, usize)> {
    let key = |x: Vector| x.map(|c| (c + 0.0).to_bits()); // no negative zero
    let at: BTreeMap<_, _> = nodes_of(mesh, &[b])
        .into_iter()
        .map(|node| (key(mesh.points[node]), node))
        .collect();
    let nodes = nodes_of(mesh, &[a]).into_iter();
    nodes
        .map(|node| (node, at[&key(image(mesh.points[node]))]))
        .collect()
}

/// Paired nodes are images of each other to the last bit at every step; gives the farthest that one
/// has come.
fn assert_paired(
    sequence: &Sequence,
    pairs: &[(usize, usize)],
    image: impl Fn(Vector) -> Vector,
) -> f64 {
    assert!(pairs.len() > 10);
    let mut largest: f64 = 0.0;
    for step in 0..sequence.n_steps() {
        let points = sequence.points(step);
        for &(a, b) in pairs {
            // Equal to the last bit, but for the sign of a zero.
            assert_eq!(
                points[b],
                image(points[a]),
                "step {step}, nodes {a} and {b}"
            );
            largest = largest.max(distance(points[a], sequence.reference.points[a]));
        }
    }
    largest
}

/// A quarter turn about z.
fn quarter([x, y, z]: Vector) -> Vector {
    [-y, x, z]
}

#[test]
fn paired_nodes_of_a_sector_are_turned_by_90_degrees_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    for schedule in ["rotor_sector", "rotor_sector_sliding"] {
        let sector = Sequence::of_testdata(folder.path(), "rotor_sector", schedule);
        sector.assert_sound();
        let pairs = pairs(&sector.reference, ["side_a", "side_b"], quarter);
        let farthest = assert_paired(&sector, &pairs, quarter);
        assert!(farthest > 0.01, "the sides follow, by {farthest}");
    }
}

#[test]
fn sliding_planes_between_periodic_sides_keep_their_nodes_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let sector = Sequence::of_testdata(folder.path(), "rotor_sector", "rotor_sector_sliding");
    let mut largest: f64 = 0.0;
    for step in 0..sector.n_steps() {
        let points = sector.points(step);
        for node in nodes_of(&sector.reference, &["bottom", "top"]) {
            let x = sector.reference.points[node];
            assert_eq!(points[node][2].to_bits(), x[2].to_bits(), "node {node}");
            largest = largest.max(distance(points[node], x));
        }
        for node in nodes_of(&sector.reference, &["hub_wall", "outer"]) {
            assert!(same(points[node], sector.reference.points[node]));
        }
    }
    assert!(largest > 0.01, "they slide, by {largest}");
}

#[test]
fn every_way_of_choosing_base_points_keeps_pairs_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::copy(testdata("rotor_sector.toml"), path.join("s.toml")).unwrap();
    let mesh = testdata("rotor_sector.vtu");
    for method in ["constant", "real", "all"] {
        let method = format!("[selection]\nmethod = \"{method}\"");
        rewrite(path, "s.toml", "case.toml", &[("[selection]", &method)]);
        let sector = Sequence::of(path, &mesh, &path.join("case.toml"), "out");
        sector.assert_sound();
        let pairs = pairs(&sector.reference, ["side_a", "side_b"], quarter);
        assert!(assert_paired(&sector, &pairs, quarter) > 0.01);
    }
    let substeps = ("[rbf]", "[rbf]\nsubsteps = 2");
    rewrite(path, "s.toml", "case.toml", &[substeps]);
    let sector = Sequence::of(path, &mesh, &path.join("case.toml"), "out");
    sector.assert_sound();
    let pairs = pairs(&sector.reference, ["side_a", "side_b"], quarter);
    assert!(assert_paired(&sector, &pairs, quarter) > 0.01);
}

#[test]
fn in_the_inertial_frame_a_sector_is_carried_round_with_its_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::copy(testdata("rotor_sector_sliding.toml"), path.join("s.toml")).unwrap();
    let frame = ("[[body]]", "[rotor]\nframe = \"inertial\"\n\n[[body]]");
    rewrite(path, "s.toml", "inertial.toml", &[frame]);
    let mesh = testdata("rotor_sector.vtu");
    let inertial = Sequence::of(path, &mesh, &path.join("inertial.toml"), "inertial");
    inertial.assert_sound();
    let rotating = Sequence::of(path, &mesh, &path.join("s.toml"), "rotating");
    for (step, azimuth) in rotating.numbers("azimuth_deg").into_iter().enumerate() {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        for ([x, y, z], found) in rotating.points(step).into_iter().zip(inertial.points(step)) {
            let carried = [cos * x - sin * y, sin * x + cos * y, z];
            assert!(distance(found, carried) < 1e-14);
        }
    }
}

const BLOCK: &str = r#"
[azimuth]
stop = 3.0
step = 1.0

[[body]]
name = "block"
tags = ["block"]

[body.rigid]
rotate = { axis = [0.0, 0.0, 1.0], origin = [0.5, 0.5, 0.0], angle = 30.0 }
translate = [0.11, -0.07, 0.0]
ramp = true

[rbf]
support_radius = 0.8

[selection]
tolerance = 1e-4

[boundaries]
"#;

/// The block of testdata/ moves between boundaries of these roles.
fn block(folder: &Path, boundaries: &str) -> Sequence {
    let schedule = folder.join("block.toml");
    std::fs::write(&schedule, format!("{BLOCK}{boundaries}\n")).unwrap();
    Sequence::of(folder, &testdata("block.vtu"), &schedule, "out")
}

#[test]
fn paired_edges_of_a_square_are_one_apart_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let across = |[x, y, z]: Vector| [x + 1.0, y, z];
    let up = |[x, y, z]: Vector| [x, y + 1.0, z];
    let left_right = "periodic = [ { pair = [\"left\", \"right\"] } ]";
    for others in [
        "fixed = [\"bottom\", \"top\"]",
        "slide = [\"bottom\", \"top\"]",
    ] {
        let channel = block(folder.path(), &format!("{left_right}\n{others}"));
        channel.assert_sound();
        let sides = pairs(&channel.reference, ["left", "right"], across);
        assert!(assert_paired(&channel, &sides, across) > 0.01);
    }
    let both = "periodic = [ { pair = [\"left\", \"right\"] }, { pair = [\"bottom\", \"top\"] } ]";
    let torus = block(folder.path(), both);
    torus.assert_sound();
    let sides = pairs(&torus.reference, ["left", "right"], across);
    assert!(assert_paired(&torus, &sides, across) > 0.01);
    let ends = pairs(&torus.reference, ["bottom", "top"], up);
    assert!(assert_paired(&torus, &ends, up) > 0.01);
}

#[test]
fn the_order_of_a_pair_does_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let run = |a: &str, b: &str| {
        let pair = format!(
            "periodic = [ {{ pair = [\"{a}\", \"{b}\"] }} ]\nslide = [\"bottom\", \"top\"]"
        );
        block(folder.path(), &pair).points(3)
    };
    let (forth, back) = (run("left", "right"), run("right", "left"));
    for (a, b) in forth.into_iter().zip(back) {
        assert!(distance(a, b) < 1e-12);
    }
}

const PITCH: &str = r#"
[azimuth]
values = [0.0]

[boundaries]
WALLS
PERIODIC

[rbf]
support_radius = 3.0

[selection]
method = "all"
"#;

/// A blade with the same pitch and flap wherever it is.
fn body(tag: &str, azimuth: f64) -> String {
    format!(
        "[[body]]\nname = \"{tag}\"\ntags = [\"{tag}\"]\nazimuth_offset = {azimuth:?}\n\
         cyclic = {{ collective = 12.0, coning = 3.0 }}\n"
    )
}

/// Four sectors, their common nodes once; the blades have tags of their own. Gives the node of each
/// sector's node too.
fn annulus(sector: &Mesh) -> (Mesh, Vec<Vec<u32>>) {
    let images: [fn(Vector) -> Vector; 4] = [
        |x| x,
        quarter,
        |[x, y, z]| [-x, -y, z],
        |[x, y, z]| [y, -x, z],
    ];
    let mut whole = Mesh::default();
    let mut at: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut nodes = Vec::new();
    let mut cells_of = BTreeMap::new();
    for (copy, image) in images.iter().enumerate() {
        let node = |x: &Vector| {
            let x = image(*x).map(|c| c + 0.0);
            *at.entry(x.map(f64::to_bits)).or_insert_with(|| {
                whole.points.push(x);
                whole.points.len() as u32 - 1
            })
        };
        let own: Vec<u32> = sector.points.iter().map(node).collect();
        for group in &sector.groups {
            let name = match group.name.as_str() {
                "side_a" | "side_b" => continue,
                "blade" => format!("blade_{copy}"),
                name => name.to_owned(),
            };
            let entry = cells_of
                .entry(name)
                .or_insert_with(|| (group.clone(), Vec::new()));
            for cell in group.cells.iter() {
                let cell = sector.cells.get(cell);
                let corners: Vec<u32> = cell.nodes.iter().map(|&n| own[n as usize]).collect();
                entry.1.push((cell.kind, corners));
            }
        }
        nodes.push(own);
    }
    for (name, (mut group, cells)) in cells_of {
        let first = whole.cells.len();
        for (kind, corners) in cells {
            whole.cells.push(kind, &corners);
        }
        group.name = name;
        group.cells = (first..whole.cells.len()).collect();
        whole.groups.push(group);
    }
    (whole, nodes)
}

#[test]
fn a_sector_with_periodic_sides_moves_as_in_the_whole_annulus() {
    assert_as_in_the_annulus("fixed = [\"hub_wall\", \"outer\", \"bottom\", \"top\"]");
}

#[test]
fn a_sector_whose_hub_and_casing_slide_moves_as_in_the_whole_annulus() {
    assert_as_in_the_annulus("slide = [\"hub_wall\", \"outer\", \"bottom\", \"top\"]");
}

fn assert_as_in_the_annulus(walls: &str) {
    let pitch = PITCH.replace("WALLS", walls);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sector_mesh = testdata("rotor_sector.vtu");
    let sides = "periodic = [ { pair = [\"side_a\", \"side_b\"] } ]";
    let text = body("blade", 0.0) + &pitch.replace("PERIODIC", sides);
    std::fs::write(path.join("sector.toml"), text).unwrap();
    let sector = Sequence::of(path, &sector_mesh, &path.join("sector.toml"), "sector");

    let (whole, nodes) = annulus(&read(&sector_mesh));
    write(&whole, &path.join("whole.vtu"));
    let mut text = String::new();
    for copy in 0..4 {
        let _ = write!(
            text,
            "{}",
            body(&format!("blade_{copy}"), 90.0 * f64::from(copy))
        );
    }
    text += &pitch.replace("PERIODIC", "");
    std::fs::write(path.join("whole.toml"), text).unwrap();
    let annulus = Sequence::of(
        path,
        &path.join("whole.vtu"),
        &path.join("whole.toml"),
        "whole",
    );

    let (part, whole) = (sector.points(0), annulus.points(0));
    let limit = 1e-9 * diagonal(&whole);
    let mut largest: f64 = 0.0;
    for (node, x) in part.iter().enumerate() {
        let off = distance(*x, whole[nodes[0][node] as usize]);
        assert!(off < limit, "node {node} is off by {off:e}");
        largest = largest.max(distance(*x, sector.reference.points[node]));
    }
    assert!(largest > 0.05);
}

/// A sector of 60 degrees with even spacing: in the plane, or with layers in z.
fn even_sector(n_layers: usize) -> Mesh {
    let (n, m) = (6, 9);
    let mut mesh = Mesh::default();
    let node = |i: usize, j: usize, k: usize| (((k * m) + j) * n + i) as u32;
    for k in 0..=n_layers {
        for j in 0..m {
            for i in 0..n {
                let angle = std::f64::consts::FRAC_PI_3 * j as f64 / (m - 1) as f64;
                let radius = 1.0 + i as f64 / (n - 1) as f64;
                mesh.points
                    .push([radius * angle.cos(), radius * angle.sin(), 0.2 * k as f64]);
            }
        }
    }
    let square = |i: usize, j: usize, k: usize| {
        [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| node(i, j, k))
    };
    let mut sides: BTreeMap<&str, Vec<Vec<u32>>> = BTreeMap::new();
    let squares = (0..m - 1).flat_map(|j| (0..n - 1).map(move |i| (i, j)));
    for (i, j) in squares.clone() {
        match n_layers {
            0 => mesh.cells.push(CellKind::Quadrilateral, &square(i, j, 0)),
            _ => {
                for k in 0..n_layers {
                    let nodes = [square(i, j, k), square(i, j, k + 1)].concat();
                    mesh.cells.push(CellKind::Hexahedron, &nodes);
                }
                sides
                    .entry("ends")
                    .or_default()
                    .push(square(i, j, 0).to_vec());
                let top = square(i, j, n_layers).to_vec();
                sides.entry("ends").or_default().push(top);
            }
        }
    }
    let mut edge = |name: &'static str, (i, j): (usize, usize), (p, q): (usize, usize)| {
        let side = sides.entry(name).or_default();
        match n_layers {
            0 => side.push(vec![node(i, j, 0), node(p, q, 0)]),
            _ => side.extend((0..n_layers).map(|k| {
                vec![
                    node(i, j, k),
                    node(p, q, k),
                    node(p, q, k + 1),
                    node(i, j, k + 1),
                ]
            })),
        }
    };
    for i in 0..n - 1 {
        edge("side_a", (i, 0), (i + 1, 0));
        edge("side_b", (i, m - 1), (i + 1, m - 1));
    }
    for j in 0..m - 1 {
        edge("hub", (0, j), (0, j + 1));
        edge("outer", (n - 1, j), (n - 1, j + 1));
    }
    for (name, faces) in sides {
        let first = mesh.cells.len();
        for nodes in faces {
            let kind = if nodes.len() == 2 {
                CellKind::Line
            } else {
                CellKind::Quadrilateral
            };
            mesh.cells.push(kind, &nodes);
        }
        mesh.add_tag(name, first..mesh.cells.len()).unwrap();
    }
    mesh
}

#[test]
fn even_sides_of_a_sector_are_turned_about_the_hub_and_not_onto_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let schedule = "azimuth.values = [0]\nbody = [ { name = \"hub\", tags = [\"hub\"], rigid.rotate = { axis = [0, 0, 1], angle = 9 } } ]\n\
                    boundaries = { others = \"fixed\", periodic = [ { pair = [\"side_a\", \"side_b\"] } ] }\n";
    for (n_layers, others) in [(0, "fixed"), (3, "slide")] {
        write(&even_sector(n_layers), &path.join("m.vtu"));
        std::fs::write(path.join("s.toml"), schedule.replace("fixed", others)).unwrap();
        let run = succeed(path, "check m.vtu s.toml");
        let map = "by a rotation by 60 degrees about the direction (0, 0, 1) through (0, 0, 0)";
        assert!(run.out.contains(map), "{}", run.out);
    }
}

#[test]
fn sides_that_do_not_match_are_refused_with_the_node() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut mesh = read(&testdata("block.vtu"));
    let moved = *nodes_of(&mesh, &["right"]).iter().nth(7).unwrap();
    mesh.points[moved][1] += 1e-3;
    write(&mesh, &path.join("b.vtu"));
    let sides = "periodic = [ { pair = [\"left\", \"right\"] } ]\nfixed = [\"bottom\", \"top\"]";
    std::fs::write(path.join("b.toml"), format!("{BLOCK}{sides}\n")).unwrap();
    let run = crate::support::azimesh(path, "deform b.vtu b.toml -o out");
    assert_eq!(run.code, 2, "{run:?}");
    assert!(
        run.err.contains("left") && run.err.contains("right"),
        "{}",
        run.err
    );
    assert!(!path.join("out").exists(), "nothing is written");
    succeed(path, "-q info b.vtu");
}

/// The angle by which each node of a tag of a sector has turned about z, by its angle at rest, both in degrees.
fn turns(sequence: &Sequence, step: usize, tag: &str) -> Vec<[f64; 2]> {
    let angle = |[x, y, _]: Vector| y.atan2(x).to_degrees();
    let points = sequence.points(step);
    let nodes = nodes_of(&sequence.reference, &[tag]).into_iter();
    let mut turns: Vec<[f64; 2]> = nodes
        .map(|node| {
            let at_rest = angle(sequence.reference.points[node]);
            [at_rest, angle(points[node]) - at_rest]
        })
        .collect();
    turns.sort_by(|a, b| a[0].total_cmp(&b[0]));
    turns
}

#[test]
fn a_curved_wall_slides_through_periodic_sides_in_both_senses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for n_layers in [0, 2] {
        write(&even_sector(n_layers), &path.join("m.vtu"));
        for sense in [1.0, -1.0] {
            let others = if n_layers == 0 { "" } else { ", \"ends\"" };
            let schedule = format!(
                "steps = 2\nbody = [ {{ name = \"o\", tags = [\"outer\"], rigid = {{ rotate = {{ axis = [0, 0, 1], angle = {} }} }} }} ]\n\
                 boundaries = {{ slide = [\"hub\"{others}], periodic = [ {{ pair = [\"side_a\", \"side_b\"] }} ] }}\n",
                12.0 * sense
            );
            std::fs::write(path.join("s.toml"), schedule).unwrap();
            let out = format!("out_{n_layers}_{sense}");
            let sector = Sequence::of(path, &path.join("m.vtu"), &path.join("s.toml"), &out);
            let off = sector.numbers("max_surface_error");
            assert!(off.iter().all(|off| *off < 1e-14), "{off:?}");
            let pairs = pairs_near(&sector.reference);
            let points = sector.points(1);
            for (a, b) in pairs {
                assert!(distance(sixth(points[a]), points[b]) < 1e-14);
            }
            let turned = turns(&sector, 1, "hub");
            let mean = turned.iter().map(|turn| turn[1]).sum::<f64>() / turned.len() as f64;
            assert!(sense * mean > 6.0, "{mean}");
            for [at_rest, turn] in turned {
                assert!((turn - mean).abs() < 0.3, "{at_rest}: {turn}, {mean}");
            }
            // Eight facets of 7.5 degrees, and their images.
            let half = 3.75f64.to_radians();
            for node in nodes_of(&sector.reference, &["hub"]) {
                let [x, y, _] = points[node];
                let from_middle = y.atan2(x).rem_euclid(2.0 * half) - half;
                let off = x.hypot(y) * from_middle.cos() - half.cos();
                assert!(off.abs() < 1e-14, "node {node} is {off:e} off the hub");
            }
        }
    }
}

/// A turn by 60 degrees about z.
fn sixth([x, y, z]: Vector) -> Vector {
    let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

/// The pairs of a sector of 60 degrees.
fn pairs_near(mesh: &Mesh) -> Vec<(usize, usize)> {
    let other = nodes_of(mesh, &["side_b"]);
    let partner = |a: usize| {
        let image = sixth(mesh.points[a]);
        let near = other
            .iter()
            .find(|&&b| distance(mesh.points[b], image) < 1e-9);
        (a, *near.unwrap())
    };
    nodes_of(mesh, &["side_a"])
        .into_iter()
        .map(partner)
        .collect()
}
