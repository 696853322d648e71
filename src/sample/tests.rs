//! Properties that every sample must have.

use super::*;
use azimesh_core::geometry::vector::{Vector, cross, distance, dot, norm, sub};
use azimesh_io::mesh::{CellKind, corners};
use std::collections::BTreeMap;

/// Smallest corner Jacobian of a cell over the lengths of its edges: the corner's three edges (two
/// in the plane) in positive order.
fn least_corner(mesh: &Mesh, kind: CellKind, nodes: &[u32]) -> f64 {
    let corners = corners::of(kind);
    assert!(!corners.is_empty(), "{kind:?} is no cell of a blade");
    let at = |i: u8| mesh.points[nodes[usize::from(i)] as usize];
    let jacobian = |&[o, a, b, c]: &[u8; 4]| {
        let [a, b, c] = [a, b, c].map(|i| sub(at(i), at(o)));
        dot(cross(a, b), c) / (norm(a) * norm(b) * norm(c))
    };
    corners.iter().map(jacobian).fold(f64::INFINITY, f64::min)
}

fn least_in_mesh(mesh: &Mesh) -> f64 {
    let runs = mesh.volume_runs();
    let cells = runs.flat_map(|run| run.cells().map(move |nodes| (run.kind, nodes)));
    cells
        .map(|(kind, nodes)| least_corner(mesh, kind, nodes))
        .fold(f64::INFINITY, f64::min)
}

/// Checks that the outer faces of volume cells are the faces of the boundary tags, seen from outside.
fn assert_closed(mesh: &Mesh) {
    let dimension = mesh.dimension();
    let mut faces: BTreeMap<Vec<u32>, i32> = BTreeMap::new();
    let mut count = |face: Vec<u32>| {
        let mut key = face.clone();
        key.sort_unstable();
        // True if the face is ascending from its lowest node.
        let lowest = face.iter().position(|n| *n == key[0]).expect("it is there");
        let next = face[(lowest + 1) % face.len()];
        let last = face[(lowest + face.len() - 1) % face.len()];
        let turn = if next < last || face.len() == 2 && lowest == 0 {
            1
        } else {
            -1
        };
        *faces.entry(key).or_insert(0) += turn;
    };
    for cell in mesh.cells.iter() {
        if cell.kind.dimension() == dimension {
            for face in cell.kind.faces() {
                count(face.iter().map(|&i| cell.nodes[i as usize]).collect());
            }
        } else {
            let mut nodes = cell.nodes.to_vec();
            nodes.reverse();
            count(nodes);
        }
    }
    assert!(faces.values().all(|&sum| sum == 0));
    let n_boundary = mesh
        .cells
        .iter()
        .filter(|cell| cell.kind.dimension() + 1 == dimension);
    let n_tagged: usize = mesh.boundary_tags().map(|tag| tag.cells.len()).sum();
    assert_eq!(n_boundary.count(), n_tagged);
}

fn sized(nodes: usize) -> SizeOptions {
    SizeOptions {
        nodes: Some(nodes),
        ..SizeOptions::default()
    }
}

fn of_size(nodes: usize) -> BladeOptions {
    BladeOptions {
        size: sized(nodes),
        ..BladeOptions::default()
    }
}

fn cut(nodes: usize, cells: CellShape) -> BladeOptions {
    BladeOptions {
        cells,
        ..of_size(nodes)
    }
}

/// A blade of 60,000 nodes.
fn shaped(shape: BladeShape) -> BladeOptions {
    BladeOptions {
        shape,
        ..of_size(60_000)
    }
}

#[test]
fn every_hexahedron_of_a_blade_is_valid_at_every_size() {
    for nodes in [5_000, 9_000, 20_000, 60_000, 250_000] {
        let mesh = blade(&of_size(nodes)).expect("the size is possible").mesh;
        mesh.validate().expect("it is a good mesh");
        let least = least_in_mesh(&mesh);
        assert!(least > 0.3, "{nodes}: {least}");
        let off = mesh.points.len() as f64 / nodes as f64 - 1.0;
        assert!(off.abs() < 0.05, "{nodes}: {}", mesh.points.len());
    }
}

#[test]
fn every_cell_of_a_blade_is_valid_for_every_shape_of_the_blade() {
    let shapes = [
        BladeShape {
            untwisted: true,
            ..BladeShape::default()
        },
        BladeShape {
            untwisted: true,
            chord: Some(0.125),
            radius: Some(6.0),
            ..BladeShape::default()
        },
        BladeShape {
            chord: Some(1.0),
            root: Some(1.0),
            radius: Some(1.6),
            ..BladeShape::default()
        },
        BladeShape {
            twist: Some(-30.0),
            cylinder_radius: Some(0.4),
            ..BladeShape::default()
        },
    ];
    for shape in shapes {
        for cells in [CellShape::Hex, CellShape::Wedge, CellShape::Tet] {
            let size = SizeOptions {
                first_cell: (cells == CellShape::Tet).then_some(1e-6),
                ..sized(40_000)
            };
            let options = BladeOptions { size, shape, cells };
            let mesh = blade(&options).expect("the shape is possible").mesh;
            let least = least_in_mesh(&mesh);
            assert!(least > 0.0, "{options:?}: {least}");
        }
    }
}

#[test]
fn every_cell_of_a_rotor_is_valid_whatever_its_number_of_blades() {
    for (blades, nodes) in [(3, 40_000), (4, 20_000), (4, 200_000), (5, 60_000)] {
        for cells in [CellShape::Hex, CellShape::Wedge, CellShape::Tet] {
            let rotor = rotor_of(&cut(nodes, cells), blades);
            let mesh = rotor.expect("the size is possible").mesh;
            mesh.validate().expect("it is a good mesh");
            let least = least_in_mesh(&mesh);
            assert!(least > 0.0, "{blades} {nodes} {cells:?}: {least}");
            let off = mesh.points.len() as f64 / nodes as f64 - 1.0;
            assert!(off.abs() < 0.1, "{nodes}: {}", mesh.points.len());
        }
    }
}

#[test]
fn a_quarter_of_a_turn_takes_four_blades_to_one_another() {
    let mesh = rotor_of(&of_size(20_000), 4).expect("it fits").mesh;
    let places = |name: &str| -> Vec<Vector> {
        let group = mesh.boundary_tags().find(|tag| tag.name == name);
        let cells = group.expect("it is tagged").cells.iter();
        let nodes = cells.flat_map(|cell| mesh.cells.get(cell).nodes);
        let nodes: std::collections::BTreeSet<&u32> = nodes.collect();
        nodes
            .iter()
            .map(|&&node| mesh.points[node as usize])
            .collect()
    };
    for (blade, next) in [
        ("blade_1", "blade_2"),
        ("blade_4", "blade_1"),
        ("hub", "hub"),
    ] {
        let next = places(next);
        for [x, y, z] in places(blade) {
            let turned = [-y, x, z];
            assert!(
                next.iter().any(|x| distance(*x, turned) < 1e-12),
                "{blade} {turned:?}"
            );
        }
    }
}

#[test]
fn the_smallest_grids_are_valid() {
    for first_cell in [1e-9, 0.02] {
        let size = SizeOptions {
            surface_nodes: Some(480),
            layers: Some(4),
            first_cell: Some(first_cell),
            nodes: None,
        };
        let options = BladeOptions {
            size,
            ..BladeOptions::default()
        };
        let mesh = blade(&options).expect("the size is possible").mesh;
        assert!(least_in_mesh(&mesh) > 0.0, "{first_cell}");
    }
}

#[test]
fn samples_are_closed_and_their_tags_look_outward() {
    assert_closed(&naca0012(&sized(3_000)).expect("it fits").mesh);
    for cells in [CellShape::Hex, CellShape::Wedge, CellShape::Tet] {
        let samples = [
            blade(&cut(6_000, cells)),
            rotor(&cut(6_000, cells)),
            rotor_of(&cut(20_000, cells), 4),
        ];
        for sample in samples {
            assert_closed(&sample.expect("it fits").mesh);
        }
    }
}

#[test]
fn wall_cells_have_the_height_asked_for() {
    let mesh = blade(&of_size(20_000)).expect("it fits").mesh;
    let hexahedra = mesh.volume_runs().next().expect("there are cells");
    let heights: Vec<f64> = hexahedra
        .cells()
        .flat_map(|nodes| (0..4).map(move |i| (nodes[i], nodes[i + 4])))
        .take_while(|&(low, high)| low < high && high < 2 * (high - low))
        .map(|(low, high)| distance(mesh.points[low as usize], mesh.points[high as usize]))
        .collect();
    assert!(heights.len() > 1000);
    assert!(
        heights
            .iter()
            .all(|height| (height / 3e-6 - 1.0).abs() < 1e-3)
    );
}

#[test]
fn nodes_of_the_outer_boundary_lie_on_the_cylinder() {
    let mesh = blade(&of_size(8_000)).expect("it fits").mesh;
    let outer = mesh
        .groups
        .iter()
        .find(|group| group.name == "outer")
        .expect("it is tagged");
    let on_cylinder = |[x, y, z]: Vector| {
        let on_side = (y.hypot(z) - 1.5).abs() < 1e-12;
        on_side || ((x - 0.225).abs() < 1e-12 || (x - 7.125).abs() < 1e-12) && y.hypot(z) < 1.5
    };
    for cell in outer.cells.iter() {
        for &node in mesh.cells.get(cell).nodes {
            assert!(on_cylinder(mesh.points[node as usize]));
        }
    }
}

#[test]
fn published_sizes_are_met() {
    let options = BladeOptions {
        size: SizeOptions {
            surface_nodes: Some(25_121),
            ..sized(379_170)
        },
        shape: BladeShape {
            untwisted: true,
            ..BladeShape::default()
        },
        ..BladeOptions::default()
    };
    let mesh = blade(&options).expect("it fits").mesh;
    let wall: usize = mesh.boundary_tags().map(|tag| tag.cells.len() + 2).sum();
    // A closed surface of quadrilaterals has two nodes more than faces.
    assert!((wall as f64 / 25_121.0 - 1.0).abs() < 0.01, "{wall}");
    assert!((mesh.points.len() as f64 / 379_170.0 - 1.0).abs() < 0.02);
}

#[test]
fn schedules_are_toml_and_name_tags_and_zones_of_their_mesh() {
    let samples = [
        naca0012(&SizeOptions::default()),
        blade(&of_size(6_000)),
        rotor(&of_size(6_000)),
        rotor_of(&of_size(20_000), 3),
        block(1),
    ];
    for sample in samples {
        let sample = sample.expect("it fits");
        let schedule: toml::Table = sample.schedule.parse().expect("it is TOML");
        let bodies = schedule["body"].as_array().expect("there are bodies");
        let boundaries = schedule["boundaries"].as_table().expect("a table");
        let lists = bodies.iter().map(|body| &body["tags"]);
        let lists = lists.chain(boundaries.values());
        let named = lists.filter_map(|list| list.as_array()).flatten();
        let names: Vec<&str> = named.filter_map(|name| name.as_str()).collect();
        for name in &names {
            assert!(
                sample.mesh.groups.iter().any(|group| group.name == *name),
                "{name}"
            );
        }
        for tag in sample.mesh.boundary_tags() {
            assert!(names.contains(&tag.name.as_str()), "{}", tag.name);
        }
    }
}

#[test]
fn wrong_options_are_refused_in_a_sentence() {
    let short = BladeShape {
        root: Some(5.6),
        ..BladeShape::default()
    };
    let sentence = |shape: BladeShape| {
        let refused = blade(&shaped(shape));
        refused.expect_err("it is wrong").to_string()
    };
    assert!(sentence(short).contains("shorter than half its chord"));
    let negative = BladeShape {
        chord: Some(f64::NAN),
        ..BladeShape::default()
    };
    assert!(sentence(negative).contains("--chord"));
    assert!(block(0).is_err());
    let blades = |n| {
        rotor_of(&of_size(6_000), n)
            .expect_err("it is wrong")
            .to_string()
    };
    assert!(blades(1).starts_with("--blades is a number from 3 to 5, found 1"));
    let wide = BladeShape {
        chord: Some(0.9),
        ..BladeShape::default()
    };
    let crowded = rotor_of(&shaped(wide), 4);
    let crowded = crowded.expect_err("there is no room").to_string();
    assert!(
        crowded.starts_with("4 blades with a chord of 0.9 do not fit"),
        "{crowded}"
    );
}
