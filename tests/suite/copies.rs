//! Copies of a node, as blocks and cuts of structured grids have them, never move apart.

use crate::support::sequence::{read, write};
use crate::support::{azimesh, succeed};
use azimesh_io::mesh::{CellKind, Group, Mesh};
use std::path::Path;

/// Cells around, outward and along the span.
const N: [usize; 3] = [28, 7, 2];

/// An O-grid of one block around an ellipse, open at its cut: tags `body`, `far`, and `sides` at both ends of the span.
fn ogrid() -> Mesh {
    let [around, outward, along] = N;
    let mut mesh = Mesh::default();
    let node = |i: usize, j: usize, k: usize| (i + (around + 1) * (j + (outward + 1) * k)) as u32;
    for k in 0..=along {
        for j in 0..=outward {
            for i in 0..=around {
                let angle = std::f64::consts::TAU * (i % around) as f64 / around as f64;
                let part = (j as f64 / outward as f64).powf(1.3);
                let (sin, cos) = angle.sin_cos();
                let radius = |of_body: f64| of_body + part * (2.0 - of_body);
                let at = [radius(0.6) * cos, radius(0.12) * sin];
                mesh.points.push([at[0], at[1], 0.5 * k as f64]);
            }
        }
    }
    let cells = |range: [usize; 3]| {
        (0..range[2]).flat_map(move |k| {
            (0..range[1]).flat_map(move |j| (0..range[0]).map(move |i| [i, j, k]))
        })
    };
    for [i, j, k] in cells(N) {
        let ring = |k| {
            [
                node(i, j, k),
                node(i, j + 1, k),
                node(i + 1, j + 1, k),
                node(i + 1, j, k),
            ]
        };
        mesh.cells
            .push(CellKind::Hexahedron, &[ring(k), ring(k + 1)].concat());
    }
    let mut tag = |name: &str, faces: Vec<[u32; 4]>| {
        let first = mesh.cells.len();
        for face in faces {
            mesh.cells.push(CellKind::Quadrilateral, &face);
        }
        let cells = (first..mesh.cells.len()).collect();
        mesh.groups.push(Group {
            dimension: 2,
            name: name.into(),
            number: None,
            condition: None,
            cells,
        });
    };
    let round = |j: usize| {
        let faces = cells([around, 1, along]);
        let face = move |[i, _, k]: [usize; 3]| {
            [
                node(i, j, k),
                node(i + 1, j, k),
                node(i + 1, j, k + 1),
                node(i, j, k + 1),
            ]
        };
        faces.map(face).collect::<Vec<_>>()
    };
    tag("body", round(0));
    tag("far", round(outward));
    let sides = [0, along].into_iter().flat_map(|end| {
        let face = move |[i, j, _]: [usize; 3]| {
            [
                node(i, j, end),
                node(i + 1, j, end),
                node(i + 1, j + 1, end),
                node(i, j + 1, end),
            ]
        };
        cells([around, outward, 1]).map(face)
    });
    tag("sides", sides.collect());
    mesh.validate().unwrap();
    mesh
}

/// Pairs of nodes at one place.
fn copies(mesh: &Mesh) -> Vec<[usize; 2]> {
    let per_ring = N[0] + 1;
    let firsts = (0..mesh.points.len()).step_by(per_ring);
    let pairs: Vec<[usize; 2]> = firsts.map(|first| [first, first + N[0]]).collect();
    assert!(
        pairs
            .iter()
            .all(|[a, b]| mesh.points[*a] == mesh.points[*b])
    );
    pairs
}

fn column(folder: &Path, name: &str) -> Vec<f64> {
    let table = std::fs::read_to_string(folder.join("steps.csv")).unwrap();
    let mut rows = table.lines().map(|row| row.split(','));
    let at = rows
        .next()
        .unwrap()
        .position(|column| column == name)
        .unwrap();
    rows.map(|mut row| row.nth(at).unwrap().parse().unwrap())
        .collect()
}

#[test]
fn copies_of_a_node_at_a_cut_move_together_when_cells_are_repaired_and_improved() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mesh = ogrid();
    write(&mesh, &folder.join("o.vtu"));
    let schedule = |output: &str| {
        let text = format!(
            "azimuth.values = [0]\nboundaries = {{ fixed = [\"far\"], slide = [\"sides\"] }}\noutput = {{ {output} }}\n\
             [[body]]\nname = \"body\"\ntags = [\"body\"]\n\
             rigid = {{ rotate = {{ axis = [0, 0, 1], angle = 75 }}, translate = [-0.4, 0.1, 0] }}\n"
        );
        std::fs::write(folder.join("o.toml"), text).unwrap();
    };
    let mut moved = Vec::new();
    for (out, output) in [
        ("folded", "on_inverted = \"warn\""),
        ("repaired", ""),
        ("improved", "improve = 0.6"),
    ] {
        schedule(output);
        let run = azimesh(folder, ["-q", "deform", "o.vtu", "o.toml", "-o", out]);
        assert_eq!(run.code, i32::from(out == "folded"), "{}", run.err);
        let points = read(&folder.join(out).join("o_0000.vtu")).points;
        for [a, b] in copies(&mesh) {
            assert_eq!(points[a], points[b], "{out}: nodes {a} and {b}");
        }
        moved.push(points);
    }
    assert!(column(&folder.join("folded"), "inverted")[0] > 0.0);
    for out in ["repaired", "improved"] {
        assert_eq!(column(&folder.join(out), "inverted")[0], 0.0);
    }
    // Nodes of the cut are inside the mesh: those between the sides can move too.
    let middle = (N[0] + 1) * (N[1] + 1);
    let mut cut = (1..N[1]).map(|j| middle + (N[0] + 1) * j);
    assert!(cut.any(|node| moved[0][node] != moved[1][node] || moved[0][node] != moved[2][node]));
    succeed(
        folder,
        "repair folded/o_0000.vtu --reference o.vtu --slide sides --improve 0.6 -o by_command.vtu",
    );
    let points = read(&folder.join("by_command.vtu")).points;
    assert!(points != moved[0]);
    for [a, b] in copies(&mesh) {
        assert_eq!(points[a], points[b], "command: nodes {a} and {b}");
    }
}
