//! Surfaces in space and clouds of points: they deform as the mesh would whose nodes they have.

use crate::support::sequence::{
    Sequence, Vector, distance, nodes_of, read, same, testdata, write, write_as,
};
use crate::support::{assert_says, azimesh, json, succeed};
use azimesh_io::mesh::{CellKind, CellSet, Group, Mesh};
use std::path::{Path, PathBuf};

const SCHEDULE: &str = r#"
[azimuth]
start = 0.0
stop = 90.0
step = 45.0

[[body]]
name = "ball"
tags = ["sphere"]

[body.rigid]
ramp = true
rotate = { axis = [0.0, 1.0, 1.0], origin = [0.1, 0.0, 0.0], angle = 25.0 }
translate = [0.05, -0.02, 0.1]

[boundaries]
fixed = ["inlet", "outlet"]
others = "free"

[rbf]
support_radius = 2.5

[output]
format = "vtu"
"#;

fn schedule(folder: &Path, selection: &str) -> PathBuf {
    let path = folder.join(format!("{selection}.toml"));
    let selection = format!("[selection]\nmethod = \"{selection}\"\ntolerance = 5e-3\n");
    std::fs::write(&path, format!("{SCHEDULE}\n{selection}")).unwrap();
    path
}

fn group(dimension: u8, name: &str, cells: CellSet) -> Group {
    Group {
        dimension,
        name: name.into(),
        number: None,
        condition: None,
        cells,
    }
}

/// The boundary faces of a solid mesh with its tags, and all of its nodes.
fn surface_of(solid: &Mesh) -> Mesh {
    let mut surface = Mesh {
        points: solid.points.clone(),
        space: Some(3),
        ..Mesh::default()
    };
    for tag in solid.boundary_tags() {
        let first = surface.cells.len();
        for cell in tag.cells.iter() {
            let cell = solid.cells.get(cell);
            surface.cells.push(cell.kind, cell.nodes);
        }
        let cells = (first..surface.cells.len()).collect();
        surface.groups.push(group(2, &tag.name, cells));
    }
    surface
}

/// The nodes of a mesh as vertex cells, those of its tags tagged; a node in two tags is two cells.
fn cloud_of(solid: &Mesh) -> Mesh {
    let mut cloud = Mesh {
        points: solid.points.clone(),
        ..Mesh::default()
    };
    for node in 0..solid.points.len() as u32 {
        cloud.cells.push(CellKind::Vertex, &[node]);
    }
    for tag in solid.boundary_tags() {
        let first = cloud.cells.len();
        for node in solid.tag_nodes(&tag.name).unwrap() {
            cloud.cells.push(CellKind::Vertex, &[node]);
        }
        let cells = (first..cloud.cells.len()).collect();
        cloud.groups.push(group(0, &tag.name, cells));
    }
    cloud
}

/// A solid mesh, the file of its surface and that of its nodes.
fn meshes(folder: &Path) -> [PathBuf; 3] {
    let solid = testdata("sphere_in_box_raw.vtu");
    let mesh = read(&solid);
    let [surface, cloud] = ["surface.su2", "cloud.vtu"].map(|name| folder.join(name));
    write_as("su2", &surface_of(&mesh), &surface);
    write(&cloud_of(&mesh), &cloud);
    [solid, surface, cloud]
}

fn farthest(a: &[Vector], b: &[Vector]) -> f64 {
    let apart = a.iter().zip(b).map(|(a, b)| distance(*a, *b));
    apart.fold(0.0, f64::max)
}

#[test]
fn a_surface_and_a_cloud_move_as_the_nodes_of_the_solid_do() {
    let folder = tempfile::tempdir().unwrap();
    let all = schedule(folder.path(), "all");
    let [solid, surface, cloud] = meshes(folder.path());
    let run = |mesh: &Path, out: &str| Sequence::of(folder.path(), mesh, &all, out);
    let solid = run(&solid, "solid");
    let last = solid.points(2);
    assert!(farthest(&last, &solid.reference.points) > 0.1);
    for other in [run(&surface, "surface"), run(&cloud, "cloud")] {
        assert_eq!(other.n_steps(), 3);
        assert!(farthest(&other.points(2), &last) < 1e-12);
        assert_eq!(other.column("base_points"), solid.column("base_points"));
        for column in ["min_volume", "min_scaled_jacobian", "max_skew"] {
            assert_eq!(other.column(column), ["", "", ""], "{column}");
        }
    }
}

#[test]
fn fewer_base_points_leave_moving_and_fixed_nodes_exact() {
    let folder = tempfile::tempdir().unwrap();
    let sequence = schedule(folder.path(), "sequence");
    let [solid, surface, cloud] = meshes(folder.path());
    let run = |mesh: &Path, out: &str| Sequence::of(folder.path(), mesh, &sequence, out);
    let solid = run(&solid, "solid");
    let moving = nodes_of(&solid.reference, &["sphere"]);
    let fixed = nodes_of(&solid.reference, &["inlet", "outlet"]);
    for other in [run(&surface, "surface"), run(&cloud, "cloud")] {
        assert_eq!(other.column("base_points"), solid.column("base_points"));
        for step in 0..3 {
            let (found, wanted) = (other.points(step), solid.points(step));
            for &node in &moving {
                assert!(distance(found[node], wanted[node]) < 1e-14, "{step} {node}");
            }
            for &node in &fixed {
                assert!(same(found[node], solid.reference.points[node]));
            }
        }
    }
}

#[test]
fn markers_without_a_volume_are_tags() {
    let folder = tempfile::tempdir().unwrap();
    let [_, surface, cloud] = meshes(folder.path());
    for (mesh, dimension) in [(surface, 3), (cloud, 0)] {
        let info = json(folder.path(), ["info", mesh.to_str().unwrap()]);
        assert_eq!(info["dimension"], dimension);
        assert_eq!(info["zones"].as_array().map(Vec::len), Some(0), "{info}");
        let tags = info["boundary_tags"].as_array().unwrap();
        let names: Vec<_> = tags.iter().filter_map(|tag| tag["name"].as_str()).collect();
        assert_eq!(names, ["sphere", "inlet", "outlet", "walls"]);
    }
}

#[test]
fn a_surface_keeps_its_markers_through_su2_and_vtu() {
    let folder = tempfile::tempdir().unwrap();
    meshes(folder.path());
    succeed(folder.path(), "-q convert surface.su2 b.vtu");
    succeed(folder.path(), "-q convert b.vtu c.su2");
    let [before, after] = ["surface.su2", "c.su2"].map(|name| {
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.starts_with("NDIME= 3\nNELEM= 0\n"), "{name}");
        text
    });
    assert!(before == after);
}

/// A strip bent about the y axis: quadrilaterals in space, with tags of edges at two of its sides.
fn shell() -> Mesh {
    let mut mesh = Mesh::default();
    let (n, m) = (12u32, 5u32);
    for i in 0..=n {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::PI;
        for j in 0..=m {
            let y = f64::from(j) / f64::from(m);
            mesh.points.push([angle.cos(), y, angle.sin()]);
        }
    }
    let node = |i: u32, j: u32| i * (m + 1) + j;
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let corners = [
            node(i, j),
            node(i + 1, j),
            node(i + 1, j + 1),
            node(i, j + 1),
        ];
        mesh.cells.push(CellKind::Quadrilateral, &corners);
    }
    for (name, i) in [("sphere", 0), ("inlet", n), ("outlet", n / 2)] {
        let first = mesh.cells.len();
        for j in 0..m {
            mesh.cells
                .push(CellKind::Line, &[node(i, j), node(i, j + 1)]);
        }
        let cells = (first..mesh.cells.len()).collect();
        mesh.groups.push(group(1, name, cells));
    }
    mesh
}

#[test]
fn a_shell_with_tagged_edges_deforms_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let all = schedule(folder.path(), "all");
    let [a, b] = ["shell.vtu", "cloud.vtu"].map(|name| folder.path().join(name));
    write(&shell(), &a);
    write(&cloud_of(&shell()), &b);
    let [shell, cloud] =
        [(a, "a"), (b, "b")].map(|(mesh, out)| Sequence::of(folder.path(), &mesh, &all, out));
    assert_eq!(shell.column("inverted"), ["0"; 3]);
    assert!(farthest(&shell.points(2), &cloud.points(2)) < 1e-12);
    let moved = |x: &Vector, y: &Vector| (0..3).all(|k| (x[k] - y[k]).abs() > 1e-3);
    let (last, reference) = (shell.points(2), &shell.reference.points);
    assert!(last.iter().zip(reference).any(|(x, y)| moved(x, y)));
}

#[test]
fn edges_of_a_shell_cannot_slide() {
    let folder = tempfile::tempdir().unwrap();
    let path = schedule(folder.path(), "all");
    let text = std::fs::read_to_string(&path).unwrap();
    let slides = text.replace("\"inlet\", \"outlet\"]", "\"inlet\"]\nslide = [\"outlet\"]");
    std::fs::write(&path, slides).unwrap();
    write(&shell(), &folder.path().join("shell.vtu"));
    let run = azimesh(folder.path(), "-q deform shell.vtu all.toml -o out");
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["\"outlet\"", "slide"]);
}
