//! The inertial frame: a zone that is carried round with the azimuth, cut from the rest of the mesh.

use crate::support::{assert_says, azimesh, rewrite, succeed};
use azimesh_io::mesh::{CellKind, Group, Mesh, Values};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tempfile::TempDir;

fn read(path: &Path) -> Mesh {
    Mesh::read(path).unwrap()
}

/// Nodes of a zone's cells.
fn nodes_of(mesh: &Mesh, zone: &str) -> BTreeSet<usize> {
    let zone = mesh.zones().find(|group| group.name == zone).unwrap();
    let nodes = |cell| mesh.cells.get(cell).nodes.iter().map(|&node| node as usize);
    zone.cells.iter().flat_map(nodes).collect()
}

/// The sample `rotor` at azimuths 0, 130 and 260, run in both frames.
fn runs() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = [
        "--layers",
        "4",
        "--first-cell",
        "0.01",
        "--surface-nodes",
        "1500",
    ];
    succeed(
        path,
        [&["-q", "sample", "rotor", "-o", "r.vtu"][..], &size].concat(),
    );
    let changes = [
        ("step = 10.0", "step = 130.0"),
        ("[selection]", "[selection]\n# 1e-2 chord\n"),
    ];
    rewrite(path, "r.toml", "rotating.toml", &changes);
    let turning = ("frame = \"rotating\"", "frame = \"inertial\"");
    rewrite(path, "rotating.toml", "inertial.toml", &[turning]);
    for frame in ["inertial", "rotating"] {
        let schedule = format!("{frame}.toml");
        // The cylinder around the blade is not round about the shaft.
        let out = ["-o", frame, "--allow-outside"];
        succeed(
            path,
            [&["-q", "deform", "r.vtu", &schedule][..], &out].concat(),
        );
    }
    folder
}

#[test]
fn a_turning_zone_is_the_rotating_frame_turned_and_the_background_stays() {
    let folder = runs();
    let source = read(&folder.path().join("r.vtu"));
    let n = source.points.len();
    let zone_before = nodes_of(&source, "rotor");
    let background_before = nodes_of(&source, "background");
    let interface: Vec<usize> = zone_before
        .intersection(&background_before)
        .copied()
        .collect();
    assert!(interface.len() > 10);

    for (step, azimuth_deg) in [0.0f64, 130.0, 260.0].into_iter().enumerate() {
        let name = format!("r_{step:04}.vtu");
        let inertial = read(&folder.path().join("inertial").join(&name));
        let rotating = read(&folder.path().join("rotating").join(&name));
        assert_eq!(rotating.points.len(), n);
        assert_eq!(inertial.points.len(), n + interface.len(), "each node once");
        let zone = nodes_of(&inertial, "rotor");
        let background = nodes_of(&inertial, "background");
        assert!(zone.is_disjoint(&background));
        assert_eq!(background, background_before);

        for &node in &background {
            assert_eq!(inertial.points[node], source.points[node], "node {node}");
        }
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        for &node in &zone {
            let original = node.checked_sub(n).map_or(node, |copy| interface[copy]);
            assert!(zone_before.contains(&original));
            let [x, y, z] = rotating.points[original];
            let turned = [cos * x - sin * y, sin * x + cos * y, z];
            for (found, right) in inertial.points[node].iter().zip(turned) {
                let off = (found - right).abs();
                assert!(off < 1e-12, "step {step}, node {node}: off by {off:e}");
            }
        }
    }
}

#[test]
fn cutting_a_zone_out_keeps_cells_tags_and_zones_and_tags_both_sides() {
    let folder = runs();
    let source = read(&folder.path().join("r.vtu"));
    let inertial = read(&folder.path().join("inertial/r_0001.vtu"));
    assert!(
        source
            .groups
            .iter()
            .all(|group| inertial.groups.contains(group))
    );
    let new = inertial.groups.iter();
    let new: Vec<_> = new.filter(|group| !source.groups.contains(group)).collect();
    let names: Vec<&str> = new.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["inner_interface", "outer_interface"]);
    assert_eq!(new[0].cells.len(), new[1].cells.len());
    assert!(new[0].cells.len() > 10);
    let n_new = new[0].cells.len() + new[1].cells.len();
    assert_eq!(inertial.cells.len(), source.cells.len() + n_new);
    for (group, zone) in new.iter().zip(["rotor", "background"]) {
        let zone = nodes_of(&inertial, zone);
        let faces = group.cells.iter().map(|cell| inertial.cells.get(cell));
        let mut nodes = faces.flat_map(|face| face.nodes);
        assert!(
            nodes.all(|&node| zone.contains(&(node as usize))),
            "{}",
            group.name
        );
    }
    let mut original = BTreeMap::new();
    for (cut, whole) in inertial.cells.iter().zip(source.cells.iter()) {
        assert_eq!((cut.kind, cut.nodes.len()), (whole.kind, whole.nodes.len()));
        for (&node, &was) in cut.nodes.iter().zip(whole.nodes) {
            assert_eq!(*original.entry(node).or_insert(was), was, "node {node}");
        }
    }
    // Every tag keeps its faces; the blade's are all on the side that turns.
    let zone = nodes_of(&inertial, "rotor");
    let blade = inertial
        .boundary_tags()
        .find(|tag| tag.name == "blade")
        .unwrap();
    let nodes = blade
        .cells
        .iter()
        .flat_map(|cell| inertial.cells.get(cell).nodes);
    assert!(
        nodes
            .into_iter()
            .all(|&node| zone.contains(&(node as usize)))
    );
}

/// Rings of cells around z: zone `front` from radius 1 to 2, `rear` to 4, `rest` to 5, with the tags `hub` and `far` on both ends.
fn rings() -> Mesh {
    const AROUND: u32 = 16;
    let mut mesh = Mesh::default();
    for radius in 1..=5 {
        for around in 0..AROUND {
            let angle = std::f64::consts::TAU * f64::from(around) / f64::from(AROUND);
            let (sin, cos) = angle.sin_cos();
            let r = f64::from(radius);
            mesh.points
                .extend([0.0, 1.0].map(|z| [r * cos, r * sin, z]));
        }
    }
    let node = |ring: u32, around: u32, up: u32| 2 * (ring * AROUND + around % AROUND) + up;
    for ring in 0..4 {
        for at in 0..AROUND {
            let corners = [0, 1].map(|up| {
                let next = at + 1;
                [(ring, at), (ring + 1, at), (ring + 1, next), (ring, next)]
                    .map(|(ring, at)| node(ring, at, up))
            });
            mesh.cells.push(CellKind::Hexahedron, &corners.concat());
        }
    }
    for (ring, at) in [0, 4]
        .into_iter()
        .flat_map(|r| (0..AROUND).map(move |at| (r, at)))
    {
        let face = [(at, 0), (at + 1, 0), (at + 1, 1), (at, 1)];
        let face = face.map(|(at, up)| node(ring, at, up));
        mesh.cells.push(CellKind::Quadrilateral, &face);
    }
    let group = |dimension, name: &str, cells: std::ops::Range<usize>| Group {
        dimension,
        name: name.into(),
        number: None,
        condition: None,
        cells: cells.collect(),
    };
    mesh.groups = vec![
        group(3, "front", 0..16),
        group(3, "rear", 16..48),
        group(3, "rest", 48..64),
        group(2, "hub", 64..80),
        group(2, "far", 80..96),
    ];
    mesh
}

/// Two rotors that turn against each other, one inside the other; the hub pitches in the frame of the inner one.
const COUNTER_ROTATING: &str = "azimuth = { stop = 60, step = 20 }\nboundaries.fixed = ['far']\noutput.velocity = true\n\
    [[rotor]]\nname = 'front'\nframe = 'inertial'\nrpm = 60\nzones = ['front']\n\
    [[rotor]]\nname = 'rear'\nframe = 'inertial'\nrpm = 90\nzones = ['rear']\nazimuth_sign = -1\n\
    [[body]]\nname = 'hub'\ntags = ['hub']\nrotor = 'front'\n\
    rigid.rotate = { axis = [0, 0, 1], origin = [0.5, 0, 0], angle = 1.0, harmonics = [ { sin = 4.0, cos = 2.0 } ] }\n";

/// Position and velocity turned about z through `origin` by an angle that grows at a rate.
fn turned(x: [f64; 3], v: [f64; 3], origin: f64, angle: f64, rate: f64) -> [[f64; 3]; 2] {
    let (sin, cos) = angle.sin_cos();
    let turn = |x: [f64; 3]| [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], x[2]];
    let [px, py, pz] = turn([x[0] - origin, x[1], x[2]]);
    let [vx, vy, vz] = turn(v);
    [[px + origin, py, pz], [vx - rate * py, vy + rate * px, vz]]
}

#[test]
fn two_rotors_turn_their_zones_against_each_other_to_a_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mesh = rings();
    std::fs::write(path.join("s.toml"), COUNTER_ROTATING).unwrap();
    mesh.write(path.join("m.vtu")).unwrap();
    succeed(path, "-q deform m.vtu s.toml -o out");
    let n = mesh.points.len();
    let tau = std::f64::consts::TAU;
    for step in 0..4 {
        let found = read(&path.join(format!("out/m_000{step}.vtu")));
        assert_eq!(
            found.points.len(),
            n + 2 * 32,
            "each interface has two sides"
        );
        let velocity = found
            .point_arrays
            .iter()
            .find(|array| array.name == "Velocity");
        let Values::F64(velocity) = &velocity.unwrap().values else {
            panic!("64 bits")
        };
        let time = f64::from(step) * 20.0 / 360.0;
        let (front, rear) = (tau * time, -1.5 * tau * time);
        let (sin, cos) = front.sin_cos();
        let pitch = (1.0 + 4.0 * sin + 2.0 * cos).to_radians();
        let pitch_rate = tau * (4.0 * cos - 2.0 * sin).to_radians();
        let expected = |zone: &str, x: [f64; 3]| {
            let on_hub = x[0].hypot(x[1]) < 1.5;
            match zone {
                "rest" => [x, [0.0; 3]],
                "front" if on_hub => {
                    let [x, v] = turned(x, [0.0; 3], 0.5, pitch, pitch_rate);
                    turned(x, v, 0.0, front, tau)
                }
                "front" => turned(x, [0.0; 3], 0.0, front, tau),
                _ => turned(x, [0.0; 3], 0.0, rear, -1.5 * tau),
            }
        };
        for zone in ["front", "rear", "rest"] {
            let cells = found.zones().find(|group| group.name == zone).unwrap();
            for cell in cells.cells.iter() {
                let nodes = found
                    .cells
                    .get(cell)
                    .nodes
                    .iter()
                    .zip(mesh.cells.get(cell).nodes);
                for (&node, &original) in nodes {
                    let x = mesh.points[original as usize];
                    // The nodes in the middle of the rear zone are interpolated.
                    if (x[0].hypot(x[1]) - 3.0).abs() < 0.5 {
                        continue;
                    }
                    let node = node as usize;
                    let [place, rate] = expected(zone, x);
                    for k in 0..3 {
                        assert!(
                            (found.points[node][k] - place[k]).abs() < 1e-12,
                            "{zone} {step}"
                        );
                        assert!(
                            (velocity[3 * node + k] - rate[k]).abs() < 1e-12,
                            "{zone} {step}"
                        );
                    }
                }
            }
        }
        for (tag, zone) in [
            ("inner_interface", "front"),
            ("outer_interface", "rear"),
            ("inner_interface_2", "rear"),
            ("outer_interface_2", "rest"),
        ] {
            let group = found
                .boundary_tags()
                .find(|group| group.name == tag)
                .unwrap();
            let zone = nodes_of(&found, zone);
            let faces = group.cells.iter().map(|cell| found.cells.get(cell));
            let mut nodes = faces.flat_map(|face| face.nodes);
            assert_eq!(group.cells.len(), 16);
            assert!(nodes.all(|&node| zone.contains(&(node as usize))), "{tag}");
        }
    }
    // Resumed, the steps are the same bytes.
    let last = path.join("out/m_0003.vtu");
    let bytes = std::fs::read(&last).unwrap();
    std::fs::remove_file(&last).unwrap();
    succeed(path, "-q deform m.vtu s.toml -o out --resume");
    assert!(std::fs::read(&last).unwrap() == bytes);
}

#[test]
fn check_has_a_row_for_each_rotor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    rings().write(path.join("m.vtu")).unwrap();
    std::fs::write(path.join("s.toml"), COUNTER_ROTATING).unwrap();
    let told = succeed(path, "check m.vtu s.toml").out;
    let rows = told.lines().filter(|line| line.starts_with("rotor "));
    let rows: Vec<&str> = rows.collect();
    assert_eq!(rows.len(), 2, "{told}");
    assert!(
        rows[0].contains("front: inertial frame")
            && rows[0].ends_with("azimuth from 0 to 60 degrees")
    );
    assert!(
        rows[1].contains("rear: inertial frame")
            && rows[1].ends_with("azimuth from 0 to 90 degrees")
    );
}

#[test]
fn zones_that_run_into_others_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    rings().write(path.join("m.vtu")).unwrap();
    let text = COUNTER_ROTATING.replace("rpm = 90", "rpm = 90\nhub = [0, 0.5, 0]");
    std::fs::write(path.join("s.toml"), text).unwrap();
    let parts = [
        "s.toml: the zones of rotor \"front\" do not stay in their interface: at step 3 its nodes are up to ",
        "--allow-outside",
    ];
    for args in [
        &["check", "m.vtu", "s.toml"][..],
        &["deform", "m.vtu", "s.toml", "-o", "out"],
    ] {
        let run = azimesh(path, args);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, &parts);
    }
    assert!(!path.join("out").exists());
    succeed(
        path,
        [
            "-q",
            "deform",
            "m.vtu",
            "s.toml",
            "-o",
            "out",
            "--allow-outside",
        ],
    );
}
