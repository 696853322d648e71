//! The inertial frame: a zone that is carried round with the azimuth, cut from the rest of the mesh.

use crate::support::{rewrite, succeed};
use azimesh_io::mesh::Mesh;
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
        &[&["-q", "sample", "rotor", "-o", "r.vtu"][..], &size].concat(),
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
        succeed(path, &["-q", "deform", "r.vtu", &schedule, "-o", frame]);
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
