//! Round trips through every pair of formats from the command line, and `diff` as their judge.

use crate::support::{azimesh, succeed};
use azimesh::formats::{self, Commit, WriteOptions};
use azimesh::mesh::{CellKind, Cells, Group, Mesh};
use std::path::Path;

const EXTENSIONS: [&str; 7] = ["vtu", "vtk", "vtkhdf", "cgns", "msh", "msh2", "su2"];
/// Solid meshes only, in an order of cells of its own: a start, not a stop on the way.
const UGRID: &str = "lb8.ugrid";

fn read(path: &Path) -> Mesh {
    Mesh::read(path).unwrap()
}

fn save(mesh: &Mesh, path: &Path) {
    let format = formats::by_extension(path).unwrap();
    formats::save(
        &mesh.view(),
        path,
        format,
        &WriteOptions::default(),
        Commit::REPLACE,
    )
    .unwrap();
}

/// A hexahedron with a pyramid on top, a tetrahedron at its side and a wedge beside it; triangles
/// and quadrilaterals in two tags; `zones` in two zones.
fn mixed(zones: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let thirds = |x: [i32; 3]| x.map(|x| f64::from(x) / 3.0);
    mesh.points = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
        [1, 1, 2],
        [2, 0, 0],
        [2, 0, 1],
        [0, 2, 2],
    ]
    .map(thirds)
    .to_vec();
    let cells = &mut mesh.cells;
    cells.push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
    cells.push(CellKind::Pyramid, &[4, 5, 6, 7, 8]);
    cells.push(CellKind::Wedge, &[1, 2, 9, 5, 6, 10]);
    cells.push(CellKind::Tetrahedron, &[7, 6, 8, 11]);
    cells.push(CellKind::Quadrilateral, &[0, 3, 2, 1]);
    cells.push(CellKind::Quadrilateral, &[0, 1, 5, 4]);
    cells.push(CellKind::Triangle, &[4, 5, 8]);
    cells.push(CellKind::Triangle, &[5, 6, 8]);
    let mut group = |dimension, name: &str, cells: std::ops::Range<usize>| {
        mesh.groups.push(Group {
            dimension,
            name: name.into(),
            number: None,
            condition: None,
            cells: cells.collect(),
        });
    };
    group(2, "lower-wall", 4..6);
    group(2, "far", 6..8);
    if zones {
        group(3, "rotor", 0..2);
        group(3, "background", 2..4);
    }
    mesh
}

/// Names of meshes without zones, and of those with.
fn meshes(folder: &Path) -> ([&'static str; 5], [&'static str; 2]) {
    let sample = |args: &[&str]| {
        succeed(folder, &[&["-q", "sample"], args].concat());
    };
    sample(&["naca0012", "--nodes", "800", "-o", "airfoil.vtu"]);
    let small = [
        "--layers",
        "4",
        "--first-cell",
        "0.01",
        "--surface-nodes",
        "800",
    ];
    for cells in ["hex", "wedge", "tet"] {
        let name = format!("{cells}.vtu");
        sample(&[&["blade", "--cells", cells, "-o", &name][..], &small].concat());
    }
    sample(&[&["rotor", "-o", "rotor.vtu"][..], &small].concat());
    save(&mixed(false), &folder.join("mixed.vtu"));
    save(&mixed(true), &folder.join("zones.vtu"));
    (
        ["airfoil", "hex", "wedge", "tet", "mixed"],
        ["rotor", "zones"],
    )
}

#[test]
fn every_mesh_survives_every_pair_of_formats() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (plain, zoned) = meshes(folder);
    for name in plain.into_iter().chain(zoned) {
        let first = format!("{name}.vtu");
        let starts = EXTENSIONS.into_iter().chain([UGRID]);
        for a in starts.filter(|a| *a != UGRID || name != "airfoil") {
            let start = format!("{name}_a.{a}");
            succeed(folder, &["convert", "--force", "-q", &first, &start]);
            for b in EXTENSIONS {
                let (there, back) = (format!("{name}_b.{b}"), format!("{name}_c.{a}"));
                let out = succeed(folder, &["convert", "--force", &start, &there]);
                succeed(folder, &["convert", "--force", "-q", &there, &back]);
                let has_zones = zoned.contains(&name) && a != "su2" && a != UGRID;
                let loses_zones = has_zones && b == "su2";
                let diff = azimesh(folder, &["diff", "-v", &start, &back]);
                assert_eq!(
                    diff.code,
                    i32::from(loses_zones),
                    "{name} {a} {b}: {diff:?}"
                );
                assert_eq!(
                    out.err.contains("zone"),
                    loses_zones,
                    "{name} {a} {b}: {out:?}"
                );
                if !loses_zones {
                    assert!(diff.out.starts_with("same: "), "{}", diff.out);
                }
            }
        }
    }
}

/// The mesh with the last node of its first boundary face replaced.
fn with_a_changed_cell(mesh: &Mesh) -> Mesh {
    let changed = mesh
        .boundary_tags()
        .next()
        .unwrap()
        .cells
        .iter()
        .next()
        .unwrap();
    let mut cells = Cells::new();
    for cell in mesh.cells.iter() {
        let mut nodes = cell.nodes.to_vec();
        if cell.index == changed {
            let other = (0..).find(|node| !nodes.contains(node)).unwrap();
            *nodes.last_mut().unwrap() = other;
        }
        cells.push(cell.kind, &nodes);
    }
    Mesh {
        cells,
        ..mesh.clone()
    }
}

#[test]
fn diff_finds_a_node_a_tag_and_a_cell_that_changed_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    meshes(folder);
    for name in ["airfoil", "mixed"] {
        let mesh = read(&folder.join(format!("{name}.vtu")));
        let mut moved = mesh.clone();
        moved.points[5][0] = moved.points[5][0].next_up();
        let mut renamed = mesh.clone();
        renamed.groups[0].name = "other".into();
        let mut regrouped = mesh.clone();
        let (first, second) = (&mesh.groups[0].cells, &mesh.groups[1].cells);
        let given = first.iter().last().unwrap();
        regrouped.groups[0].cells = first.iter().filter(|cell| *cell != given).collect();
        regrouped.groups[1].cells = [given].into_iter().chain(second.iter()).collect();
        for extension in EXTENSIONS {
            let path = |name: &str| folder.join(format!("{name}.{extension}"));
            save(&mesh, &path("right"));
            let names = ["right", "wrong"].map(|name| format!("{name}.{extension}"));
            let diff = ["diff", &names[0], &names[1]];
            save(&mesh, &path("wrong"));
            succeed(folder, &diff);
            for (what, changed) in [
                ("a node", &moved),
                ("a tag's name", &renamed),
                ("a tag's faces", &regrouped),
                ("a cell", &with_a_changed_cell(&mesh)),
            ] {
                save(changed, &path("wrong"));
                let run = azimesh(folder, &diff);
                assert_eq!(run.code, 1, "{name}.{extension}, {what}: {run:?}");
            }
        }
    }
}
