//! Roles of nodes and faces, zones and their interface.

use super::{group, parse, two_cubes, two_squares};
use crate::motion::{Motion, Role};
use Role::{Fixed, Moving, Sliding};
use azimesh_core::error::Position;
use azimesh_io::mesh::{Boundary, CellKind, Mesh};

pub(super) fn resolve(mesh: &Mesh, tail: &str) -> Result<Motion, String> {
    let text = format!("[azimuth]\nvalues = [0]\n{tail}");
    let schedule = parse(&text).map_err(|error| error.to_string())?;
    schedule.resolve_on(mesh).map_err(|error| error.to_string())
}

pub(super) const BLADE: &str =
    "[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\nrigid.translate = [0.1, 0, 0]\n";
const HUB: &str = "[[body]]\nname = \"hub\"\ntags = [\"hub\"]\nrigid.translate = [0.1, 0, 0]\n";

fn roles(motion: &Motion) -> Vec<(u32, Role)> {
    let nodes = &motion.surface.nodes;
    nodes
        .nodes
        .iter()
        .copied()
        .zip(nodes.roles.iter().copied())
        .collect()
}

#[test]
fn a_node_on_two_tags_takes_the_stronger_role() {
    let motion = resolve(
        &two_cubes(),
        &format!("{BLADE}[boundaries]\nothers = \"fixed\""),
    )
    .expect("it fits");
    let moving = (0..4).map(|node| (node, Moving(0)));
    let fixed = [4, 7, 8, 9, 10, 11].map(|node| (node, Fixed));
    assert_eq!(roles(&motion), moving.chain(fixed).collect::<Vec<_>>());
    assert_eq!(motion.surface.faces.cells, [2, 3, 4, 5]);
    assert_eq!(motion.surface.faces.roles, [Moving(0), Fixed, Fixed, Fixed]);
}

#[test]
fn sliding_copies_of_a_node_go_with_it() {
    let mut mesh = two_cubes();
    // Where the cubes meet, the upper one has copies of the nodes; the edge of the hub is on its side.
    mesh.cells = azimesh_io::mesh::Cells::default();
    for (kind, nodes) in [
        (CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7][..]),
        (CellKind::Hexahedron, &[12, 13, 14, 15, 8, 9, 10, 11]),
        (CellKind::Quadrilateral, &[0, 1, 2, 3]),
        (CellKind::Quadrilateral, &[0, 3, 7, 4]),
        (CellKind::Quadrilateral, &[12, 15, 11, 8]),
        (CellKind::Quadrilateral, &[8, 9, 10, 11]),
    ] {
        mesh.cells.push(kind, nodes);
    }
    let mut copies = mesh.points[4..8].to_vec();
    copies[3][2] += 1e-15;
    mesh.points.extend(copies);
    let free = "[boundaries]\nslide = [\"side\"]\nothers = \"free\"";
    let motion = resolve(&mesh, &format!("{HUB}{free}")).expect("it fits");
    let roles = roles(&motion);
    for node in [0, 3, 4, 7, 12, 15] {
        assert!(roles.contains(&(node, Moving(0))), "{node}: {roles:?}");
    }
    assert!(roles.contains(&(8, Sliding)));
}

#[test]
fn a_node_on_two_bodies_goes_with_the_first_in_the_schedule() {
    let free = "[boundaries]\nothers = \"free\"";
    let motion = resolve(&two_cubes(), &format!("{HUB}{BLADE}{free}")).expect("it fits");
    let expected = [0, 3, 4, 7].map(|node| (node, Moving(0)));
    let mut expected = [&expected[..], &[(1, Moving(1)), (2, Moving(1))]].concat();
    expected.sort_unstable();
    assert_eq!(roles(&motion), expected);
    let tags: Vec<_> = motion
        .surface
        .tags
        .iter()
        .map(|t| (t.tag.as_str(), t.role))
        .collect();
    assert_eq!(
        tags,
        [
            ("blade_1", Some(Moving(1))),
            ("hub", Some(Moving(0))),
            ("side", None),
            ("farfield", None)
        ]
    );
}

#[test]
fn a_face_in_two_tags_takes_the_stronger_role_once() {
    let mut mesh = two_cubes();
    mesh.groups.push(group(2, "probe", &[2, 5]));
    let tail = format!("{BLADE}[boundaries]\nfixed = [\"probe\"]\nothers = \"free\"");
    let motion = resolve(&mesh, &tail).expect("it fits");
    assert_eq!(motion.surface.faces.cells, [2, 5]);
    assert_eq!(motion.surface.faces.roles, [Moving(0), Fixed]);
}

#[test]
fn sliding_nodes_give_way_to_moving_and_fixed_ones() {
    let tail = format!("{BLADE}[boundaries]\nslide = [\"hub\", \"side\"]\nfixed = [\"farfield\"]");
    let motion = resolve(&two_cubes(), &tail).expect("it fits");
    let moving = (0..4).map(|node| (node, Moving(0)));
    let sliding = [4, 7].map(|node| (node, Sliding));
    let fixed = (8..12).map(|node| (node, Fixed));
    assert_eq!(
        roles(&motion),
        moving.chain(sliding).chain(fixed).collect::<Vec<_>>()
    );
    let faces = &motion.surface.faces;
    assert_eq!(faces.cells, [2, 3, 4, 5]);
    assert_eq!(faces.roles, [Moving(0), Sliding, Sliding, Fixed]);
    assert_eq!(faces.tags, [0, 1, 2, 3]);
    let tail = format!("{BLADE}[boundaries]\nothers = \"slide\"");
    let others = resolve(&two_cubes(), &tail).expect("it fits");
    assert_eq!(
        others.surface.faces.roles,
        [Moving(0), Sliding, Sliding, Sliding]
    );
    assert_eq!(others.surface.tags[3].role, Some(Sliding));
}

#[test]
fn a_face_in_two_tags_of_one_role_belongs_to_the_first() {
    let mut mesh = two_cubes();
    mesh.groups.insert(2, group(2, "all_sides", &[3, 4]));
    let tail = format!("{BLADE}[boundaries]\nothers = \"slide\"");
    let motion = resolve(&mesh, &tail).expect("it fits");
    assert_eq!(motion.surface.faces.tags, [1, 0, 0, 3 + 1]);
}

#[test]
fn an_interface_holds_sliding_nodes() {
    let tail = format!("{BLADE}[boundaries]\nzones = [\"rotor\"]\nslide = [\"hub\"]");
    let motion = resolve(&two_cubes(), &tail).expect("it fits");
    let expected = (0..8).map(|node| (node, if node < 4 { Moving(0) } else { Fixed }));
    assert_eq!(roles(&motion), expected.collect::<Vec<_>>());
    assert_eq!(motion.surface.faces.roles, [Moving(0), Sliding]);
}

/// The two cubes with a tag on each side x = 1, images of hub and side.
fn periodic_cubes() -> Mesh {
    let mut mesh = two_cubes();
    mesh.cells.push(CellKind::Quadrilateral, &[1, 2, 6, 5]);
    mesh.cells.push(CellKind::Quadrilateral, &[5, 6, 10, 9]);
    mesh.groups.push(group(2, "hub_image", &[6]));
    mesh.groups.push(group(2, "side_image", &[7]));
    mesh
}

#[test]
fn periodic_tags_have_no_role_and_know_their_nodes() {
    let mesh = periodic_cubes();
    let pair = |a: &str, b: &str| {
        format!(
            "{BLADE}[boundaries]\nothers = \"fixed\"\nperiodic = [ {{ pair = [\"{a}\", \"{b}\"] }} ]"
        )
    };
    let motion = resolve(&mesh, &pair("hub", "hub_image")).expect("it fits");
    assert_eq!(
        (&motion.periodic[0].a, &motion.periodic[0].b),
        (&vec![1], &vec![4])
    );
    assert_eq!(motion.periodic[0].place, Some(Position::Line(9)));
    let periodic: Vec<bool> = motion.surface.tags.iter().map(|tag| tag.periodic).collect();
    assert_eq!(periodic, [false, true, false, false, true, false]);
    assert_eq!(motion.surface.tags[1].role, None);
    assert_eq!(motion.surface.faces.cells, [2, 4, 5, 7]);
    let [a, b] = motion.periodic_nodes(&motion.periodic[0], &Boundary::of(&mesh));
    assert_eq!((a, b), (vec![0, 3, 4, 7], vec![1, 2, 5, 6]));
    let several = resolve(&mesh, &pair("side", "*_image")).expect("several tags on a side");
    assert_eq!(several.periodic[0].b, [4, 5]);
    let [_, b] = several.periodic_nodes(&several.periodic[0], &Boundary::of(&mesh));
    assert_eq!(b, [1, 2, 5, 6, 9, 10]);
}

#[test]
fn periodic_nodes_are_those_of_the_zones_that_deform() {
    let mesh = periodic_cubes();
    let tail = format!(
        "{BLADE}[boundaries]\nzones = [\"rotor\"]\nfixed = [\"hub\", \"hub_image\"]\nperiodic = [ {{ pair = [\"side\", \"side_image\"] }} ]"
    );
    let motion = resolve(&mesh, &tail).expect("it fits");
    let [a, b] = motion.periodic_nodes(&motion.periodic[0], &Boundary::of(&mesh));
    assert_eq!((a, b), (vec![4, 7], vec![5, 6]));
}

#[test]
fn only_the_named_zones_deform_and_their_interface_stays() {
    let tail = format!("{BLADE}[boundaries]\nzones = [\"rot*\"]\nfixed = [\"hub\"]");
    let motion = resolve(&two_cubes(), &tail).expect("tags away from the zone need no name");
    let zone = motion.zone.as_ref().expect("there is one");
    assert_eq!(zone.cells.iter().collect::<Vec<_>>(), [0]);
    assert_eq!(zone.sides.nodes.take(), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(zone.sides.interface_nodes, [4, 5, 6, 7]);
    assert_eq!(zone.sides.interface_faces.len(), 1);
    assert_eq!(
        zone.sides.interface_faces.get(0).kind,
        CellKind::Quadrilateral
    );
    assert_eq!(zone.sides.interface_faces.get(0).nodes, [4, 5, 6, 7]);
    let expected = (0..8).map(|node| (node, if node < 4 { Moving(0) } else { Fixed }));
    assert_eq!(roles(&motion), expected.collect::<Vec<_>>());
    assert_eq!(motion.surface.faces.cells, [2, 3]);
}

#[test]
fn an_interface_in_two_dimensions_is_made_of_edges() {
    let mut mesh = two_squares();
    mesh.groups
        .extend([group(2, "near", &[0]), group(2, "far", &[1])]);
    let motion =
        resolve(&mesh, &format!("{BLADE}[boundaries]\nzones = [\"near\"]")).expect("it fits");
    let zone = motion.zone.as_ref().expect("there is one");
    assert_eq!(zone.sides.interface_nodes, [2, 3]);
    assert_eq!(zone.sides.interface_faces.len(), 1);
    assert_eq!(zone.sides.interface_faces.get(0).kind, CellKind::Line);
    assert_eq!(
        roles(&motion),
        [(0, Moving(0)), (1, Moving(0)), (2, Fixed), (3, Fixed)]
    );
}

#[test]
fn an_interface_of_polyhedra_is_made_of_their_faces() {
    let mut mesh = two_cubes();
    let hexahedra = std::mem::take(&mut mesh.cells);
    for cell in hexahedra.iter() {
        if cell.kind != CellKind::Hexahedron {
            mesh.cells.push(cell.kind, cell.nodes);
            continue;
        }
        let mut stream = vec![6];
        for face in cell.kind.faces() {
            stream.push(face.len() as u32);
            stream.extend(face.iter().map(|&i| cell.nodes[i as usize]));
        }
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
    }
    let tail = format!("{BLADE}[boundaries]\nzones = [\"rotor\"]\nfixed = [\"hub\"]");
    let motion = resolve(&mesh, &tail).expect("it fits");
    let zone = motion.zone.as_ref().expect("there is one");
    assert_eq!(zone.sides.interface_nodes, [4, 5, 6, 7]);
    assert_eq!(zone.sides.interface_faces.get(0).nodes, [4, 5, 6, 7]);
}

#[test]
fn both_zones_together_have_no_interface() {
    let tail = format!("{BLADE}[boundaries]\nzones = [\"*\"]\nothers = \"free\"");
    let motion = resolve(&two_cubes(), &tail).expect("it fits");
    let zone = motion.zone.as_ref().expect("there is one");
    assert!(zone.sides.interface_nodes.is_empty() && zone.sides.interface_faces.is_empty());
    assert_eq!(motion.surface.nodes.nodes, [0, 1, 2, 3]);
}

#[test]
fn a_plane_mesh_may_have_angles_of_zero_out_of_it() {
    let ok = "[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\ncyclic = { coning = 0, flap = [{ sin = 0 }], collective = 2 }\n\
              [boundaries]\nothers = \"fixed\"";
    assert!(resolve(&two_squares(), ok).is_ok());
}

#[test]
fn a_mesh_that_cannot_deform_is_said_in_one_sentence() {
    let tail = format!("{BLADE}[boundaries]\nothers = \"fixed\"");
    let mut untagged = two_cubes();
    untagged.groups.retain(|group| group.dimension == 3);
    let mut empty = two_cubes();
    empty.groups[2].cells = Default::default();
    let mut unzoned = two_cubes();
    unzoned.groups.retain(|group| group.dimension == 2);
    let zoned = format!("{BLADE}[boundaries]\nzones = [\"rotor\"]");
    for (mesh, tail, expected) in [
        (
            &untagged,
            &tail,
            "hover.toml: the mesh has no boundary tags, so nothing says which nodes move; convert it with `tag_boundary` connected, which gives each part of its boundary a tag",
        ),
        (
            &empty,
            &tail,
            "hover.toml:4: the tags of body \"blade\" have no faces in the mesh; it needs at least one",
        ),
        (
            &unzoned,
            &zoned,
            "hover.toml:8: zone \"rotor\" is not in the mesh; it has no zones",
        ),
        (
            &Mesh::default(),
            &tail,
            "hover.toml: the mesh has no cells; there is nothing to deform",
        ),
    ] {
        assert_eq!(resolve(mesh, tail).err().as_deref(), Some(expected));
    }
}

#[test]
fn the_sides_of_a_wedge_are_offered_as_a_pair_and_do_not_slide() {
    let mut mesh = periodic_cubes();
    for tag in [3, 6] {
        mesh.groups[tag].condition = Some("wedge".into());
    }
    let told = |boundaries: &str| {
        let found = resolve(&mesh, &format!("{BLADE}[boundaries]\n{boundaries}"));
        found.expect_err("it is wrong")
    };
    let offer = "periodic = [{ pair = [\"hub\", \"hub_image\"] }] suits the wedge patches hub and hub_image";
    let others = "fixed = [\"side\", \"side_image\", \"farfield\"]";
    assert!(
        told(others).ends_with(&format!("in [boundaries]; {offer}")),
        "{}",
        told(others)
    );
    let free = told("others = \"free\"");
    assert!(
        free.contains("tag \"hub\" is of type wedge") && free.ends_with(offer),
        "{free}"
    );
    for sliding in [
        "slide = [\"hub\"]\nothers = \"fixed\"",
        "others = \"slide\"",
    ] {
        let error = told(sliding);
        assert!(
            error.contains("tag \"hub\" is of type wedge and would slide; "),
            "{error}"
        );
        assert!(error.ends_with(offer), "{error}");
    }
    let fixed = resolve(&mesh, &format!("{BLADE}[boundaries]\nothers = \"fixed\""));
    assert!(fixed.is_ok());
}

#[test]
fn optional_tags_move_with_the_body_where_the_mesh_has_them() {
    let mesh = two_cubes();
    let roles = |tags: &str| {
        let text = format!(
            "azimuth.values = [0]\nboundaries.others = \"fixed\"\nbody = [ {{ name = \"b\", {tags}, rigid = {{ translate = [1, 0, 0] }} }} ]"
        );
        let schedule = crate::motion::Schedule::parse(&text, std::path::Path::new("hover.toml"));
        let motion = schedule.and_then(|schedule| schedule.resolve_on(&mesh));
        let motion = motion.map_err(|error| error.to_string())?;
        let tags = motion.surface.tags.iter();
        let moving = tags.filter(|tag| matches!(tag.role, Some(Role::Moving(0))));
        Ok(moving.map(|tag| tag.tag.clone()).collect::<Vec<_>>())
    };
    assert_eq!(
        roles("tags = [\"blade_1\"], optional_tags = [\"h?b\", \"flap_*\"]"),
        Ok(vec!["blade_1".to_owned(), "hub".to_owned()])
    );
    assert_eq!(
        roles("optional_tags = [\"hub\"]"),
        Ok(vec!["hub".to_owned()])
    );
    assert_eq!(
        roles("optional_tags = [\"flap_*\"]"),
        Err(
            "hover.toml:3: the tags of body \"b\" have no faces in the mesh; it needs at least one"
                .to_owned()
        )
    );
}
