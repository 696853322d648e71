//! `azimesh repair`: what it tells, and what it refuses.

use crate::support::sequence::{read, testdata, write};
use crate::support::{assert_says, azimesh, json};
use azimesh_io::mesh::{CellKind, CellRef, CellSet, Group, Mesh};
use std::collections::BTreeMap;
use std::path::Path;

/// A grid of squares in the unit square, its sides in the tags `lower` and `rest`.
fn squares(n: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            mesh.points
                .push([i as f64 / n as f64, j as f64 / n as f64, 0.0]);
        }
    }
    let node = |i: usize, j: usize| (i + (n + 1) * j) as u32;
    for j in 0..n {
        for i in 0..n {
            let ring = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            mesh.cells.push(CellKind::Quadrilateral, &ring);
        }
    }
    let mut side = |name: &str, edges: Vec<[u32; 2]>| {
        let first = mesh.cells.len();
        edges
            .iter()
            .for_each(|edge| mesh.cells.push(CellKind::Line, edge));
        let cells: CellSet = (first..mesh.cells.len()).collect();
        mesh.groups.push(Group {
            dimension: 1,
            name: name.into(),
            number: None,
            condition: None,
            cells,
        });
    };
    side(
        "lower",
        (0..n).map(|i| [node(i, 0), node(i + 1, 0)]).collect(),
    );
    let rest = (0..n).flat_map(|i| {
        [
            [node(n, i), node(n, i + 1)],
            [node(i + 1, n), node(i, n)],
            [node(0, i + 1), node(0, i)],
        ]
    });
    side("rest", rest.collect());
    mesh
}

/// Writes a mesh as `reference.vtu`, and with a node moved as `folded.vtu`.
fn fold(folder: &Path, mut mesh: Mesh, node: usize, to: [f64; 3]) {
    write(&mesh, &folder.join("reference.vtu"));
    mesh.points[node] = to;
    write(&mesh, &folder.join("folded.vtu"));
}

const REPAIR: [&str; 7] = [
    "repair",
    "folded.vtu",
    "-o",
    "out.vtu",
    "--reference",
    "reference.vtu",
    "--force",
];

#[test]
fn a_node_of_the_boundary_that_is_passed_is_named_with_its_cell_and_slides_where_it_may() {
    let folder = tempfile::tempdir().unwrap();
    fold(folder.path(), squares(10), 4, [0.53, 0.0, 0.0]);
    let run = azimesh(folder.path(), REPAIR);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["no valid mesh", "cell 4 on nodes 4, 5"]);
    let told = json(folder.path(), REPAIR);
    assert_eq!(
        told["overtaken"],
        serde_json::json!([{ "cell": 4, "nodes": [4, 5] }])
    );
    assert_eq!(told["unrepaired"][0]["reason"], "boundary");
    let told = json(folder.path(), [&REPAIR[..], &["--slide", "lower"]].concat());
    assert_eq!(
        (&told["invalid"], &told["overtaken"]),
        (&0.into(), &serde_json::json!([]))
    );
    assert!(told["invalid_before"].as_u64() > Some(0));
    let points = read(&folder.path().join("out.vtu")).points;
    assert!((0..=10).all(|node| points[node][1] == 0.0));
    assert!((0..10).all(|node| points[node][0] < points[node + 1][0]));
}

#[test]
fn cells_that_are_listed_in_the_other_orientation_are_no_folded_cells() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut mesh = Mesh::default();
    let upright = squares(10);
    for cell in 0..upright.cells.len() {
        let cell = upright.cells.get(cell);
        let mut nodes = cell.nodes.to_vec();
        if cell.index % 10 == 3 {
            nodes.reverse();
        }
        mesh.cells.push(cell.kind, &nodes);
    }
    (mesh.points, mesh.groups) = (upright.points.clone(), upright.groups.clone());
    let without_reference = [&REPAIR[..4], &["--force"]].concat();
    fold(folder, mesh.clone(), 60, mesh.points[60]);
    for command in [&REPAIR[..], &without_reference] {
        let told = json(folder, command);
        assert_eq!(
            (&told["invalid_before"], &told["invalid"]),
            (&0.into(), &0.into())
        );
        assert_eq!(read(&folder.join("out.vtu")).points, mesh.points);
    }
    fold(folder, mesh, 60, [0.71, 0.56, 0.0]);
    for command in [&REPAIR[..], &without_reference] {
        let told = json(folder, command);
        assert!(told["invalid_before"].as_u64() > Some(0));
        assert_eq!(told["invalid"], 0);
        let judged = json(folder, "quality out.vtu --reference reference.vtu");
        assert_eq!(judged["inverted"], 0);
    }
}

#[test]
fn cells_that_rounded_coordinates_flatten_are_left_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut mesh = squares(10);
    mesh.points.iter_mut().for_each(|x| x[0] += 4e6);
    let [x, y, z] = mesh.points[60];
    fold(folder, mesh, 60, [x + 0.21, y + 0.01, z]);
    let command = [&REPAIR[..], &["--precision", "f32"]].concat();
    let run = azimesh(folder, &command);
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["32 bits", "64 bits"]);
    let told = json(folder, &command);
    let judged = json(folder, "quality out.vtu --reference reference.vtu");
    assert!(judged["inverted"].as_u64() > Some(0));
    assert_eq!(told["invalid"], judged["inverted"]);
    assert_eq!(told["min_scaled_jacobian"], judged["min_scaled_jacobian"]);
    assert_eq!(told["unrepaired"][0]["reason"], "rounded");
    // The quality of a mesh that is written is that of its coordinates.
    let write = "-o cells.vtu --precision f32 --force";
    let written = json(folder, format!("quality reference.vtu {write}"));
    let judged = json(folder, "quality cells.vtu --reference reference.vtu");
    assert!(written["inverted"].as_u64() > Some(0));
    assert_eq!(written["inverted"], judged["inverted"]);
    assert_eq!(azimesh(folder, REPAIR).code, 0);
}

#[test]
fn improvement_that_falls_short_says_so() {
    let folder = tempfile::tempdir().unwrap();
    fold(folder.path(), squares(10), 60, [0.59, 0.56, 0.0]);
    let improved = |wanted: &'static str| {
        azimesh(
            folder.path(),
            [&REPAIR[..], &["--improve", wanted]].concat(),
        )
    };
    let enough = improved("0.8");
    assert_eq!(enough.code, 0, "{enough:?}");
    assert!(!enough.err.contains("no better"), "{enough:?}");
    let short = improved("1");
    assert_says(&short.err, &["not 1", "no better was found"]);
    let refused = improved("1.5");
    assert_eq!(refused.code, 2);
    assert_says(&refused.err, &["--improve 1.5", "between 0 and 1"]);
}

/// A mesh of tetrahedra in which a node inside has moved past its neighbours, and so some cells have turned over.
fn turned_over() -> Mesh {
    let mut mesh = Mesh::read(testdata("sphere_in_box_raw.vtu")).unwrap();
    let boundary: Vec<u32> = mesh
        .boundary_tags()
        .flat_map(|tag| mesh.tag_nodes(&tag.name).unwrap())
        .collect();
    let inside = (0..mesh.points.len() as u32).find(|node| !boundary.contains(node));
    let [low, high] = mesh.bounds().unwrap();
    mesh.points[inside.unwrap() as usize][0] += 0.3 * (high[0] - low[0]);
    mesh
}

/// Squares of which one is listed in the other orientation, and one has a corner folded.
fn reversed_and_folded() -> Mesh {
    let mut mesh = squares(6);
    mesh.points[24] = [0.35, 0.6, 0.0];
    let mut cells = azimesh_io::mesh::Cells::default();
    for run in mesh.cells.runs() {
        for cell in run.cell_refs() {
            let mut nodes = cell.nodes.to_vec();
            if cell.index == 3 {
                nodes.reverse();
            }
            cells.push(cell.kind, &nodes);
        }
    }
    mesh.cells = cells;
    mesh
}

#[test]
fn info_quality_and_repair_count_and_measure_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(&turned_over(), &path.join("turned_over.vtu"));
    write(
        &reversed_and_folded(),
        &path.join("reversed_and_folded.vtu"),
    );
    // At its axis hexahedra that list two nodes twice.
    let wedge = "NDIME= 3\nNELEM= 1\n12 0 1 2 0 3 4 5 3 0\nNPOIN= 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 1\n0 1 1\nNMARK= 0\n";
    std::fs::write(path.join("collapsed.su2"), wedge).unwrap();
    let polyhedra = testdata("polyhedra_ascii.vtu");
    let curved = testdata("curved_solids_complete_v22.msh");
    for (mesh, negative, reversed, some) in [
        ("turned_over.vtu", true, false, true),
        ("reversed_and_folded.vtu", true, true, true),
        ("collapsed.su2", false, false, false),
        (polyhedra.to_str().unwrap(), false, false, false),
        (curved.to_str().unwrap(), false, false, false),
    ] {
        let info = json(path, ["info", mesh]);
        let quality = json(path, ["quality", mesh]);
        let arguments = format!("repair {mesh} -o o.vtu --force");
        let repair = azimesh(path, format!("{arguments} --json"));
        let repair: serde_json::Value = serde_json::from_str(&repair.out).unwrap();
        let n = |found: &serde_json::Value, key: &str| found[key].as_u64().unwrap();
        let cells = n(&info, "negative_cells");
        assert_eq!(cells > 0, negative, "{mesh}: {info}");
        assert_eq!(n(&info, "reversed_cells") > 0, reversed, "{mesh}: {info}");
        assert_eq!(n(&quality, "negative_cells"), cells, "{mesh}");
        assert_eq!(n(&repair, "negative_cells_before"), cells, "{mesh}");
        let invalid = n(&info, "invalid_cells");
        assert_eq!(invalid > 0, some, "{mesh}: {info}");
        let parts = n(&info, "degenerate_cells") + n(&info, "folded_cells") + cells;
        assert_eq!(invalid, parts - n(&info, "reversed_cells"), "{mesh}");
        let counted = n(&quality, "inverted") + n(&quality, "unproven");
        assert_eq!(counted, invalid, "{mesh}");
        assert_eq!(n(&repair, "invalid_before"), invalid, "{mesh}");
        assert_eq!(
            quality["min_scaled_jacobian"], repair["min_scaled_jacobian_before"],
            "{mesh}"
        );
        assert_eq!(n(&repair, "nodes_moved") > 0, some, "{mesh}: {repair}");
    }
}

#[test]
fn a_repair_says_what_share_of_the_mesh_it_moves() {
    let folder = tempfile::tempdir().unwrap();
    fold(folder.path(), squares(40), 840, [0.519, 0.519, 0.0]);
    let improved = [&REPAIR[..], &["--improve", "0.8"]].concat();
    let run = azimesh(folder.path(), &improved);
    let found = json(folder.path(), &improved);
    let moved = found["nodes_moved"].as_u64().unwrap();
    assert!(moved > 0 && moved < 400, "{found}");
    assert_says(&run.out, &[&format!("{moved} of 1681 (")]);
    let [before, after] = ["folded.vtu", "out.vtu"].map(|name| read(&folder.path().join(name)));
    let pairs = before.points.iter().zip(&after.points);
    assert_eq!(pairs.filter(|(a, b)| a != b).count() as u64, moved);
}

/// Two triangles of second order for each square of a grid in the unit square.
fn curved(n: usize) -> Mesh {
    let side = 2 * n + 1;
    let mut mesh = Mesh::default();
    for (j, i) in (0..side).flat_map(|j| (0..side).map(move |i| (j, i))) {
        let h = 0.5 / n as f64;
        mesh.points.push([i as f64 * h, j as f64 * h, 0.0]);
    }
    let node = |[i, j]: [usize; 2]| (i + side * j) as u32;
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (2 * j, 2 * i))) {
        let [a, b, c, d] = [[i, j], [i + 2, j], [i + 2, j + 2], [i, j + 2]];
        for corners in [[a, b, c], [a, c, d]] {
            let middle = |k: usize| {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                [0, 1].map(|axis| (from[axis] + to[axis]) / 2)
            };
            let nodes = [corners, [0, 1, 2].map(middle)].concat();
            let nodes: Vec<u32> = nodes.into_iter().map(node).collect();
            mesh.cells.push(CellKind::Triangle6, &nodes);
        }
    }
    mesh
}

#[test]
fn curved_cells_are_repaired_to_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mesh = curved(6);
    // The middle of an edge goes far into a triangle; elsewhere a corner leaves the middles of its edges behind.
    let mut folded = mesh.clone();
    folded.points[5 + 13 * 4] = [5.0 / 12.0 + 0.06, 4.0 / 12.0 + 0.12, 0.0];
    folded.points[8 + 13 * 8] = [8.0 / 12.0 + 0.2, 8.0 / 12.0 + 0.13, 0.0];
    write(&mesh, &folder.join("reference.vtu"));
    write(&folded, &folder.join("folded.vtu"));
    for arguments in [&REPAIR[..6], &REPAIR[..4]] {
        let mut bytes = Vec::new();
        for threads in ["1", "2"] {
            let more = ["--threads", threads];
            let told = json(folder, [arguments, &["--force"], &more].concat());
            assert!(told["invalid_before"].as_u64() > Some(4), "{told}");
            assert_eq!(told["invalid"], 0, "{told}");
            assert_eq!(told["patches"][0]["rings"], 0, "{told}");
            bytes.push(std::fs::read(folder.join("out.vtu")).unwrap());
        }
        assert_eq!(bytes[0], bytes[1]);
        assert_eq!(json(folder, ["quality", "out.vtu"])["inverted"], 0);
        let out = read(&folder.join("out.vtu"));
        let is_outer = |x: &[f64; 3]| x[..2].iter().any(|x| *x == 0.0 || *x == 1.0);
        let pairs = out.points.iter().zip(&mesh.points);
        assert!(
            pairs
                .clone()
                .all(|(now, then)| now == then || !is_outer(then))
        );
        assert!(pairs.filter(|(now, then)| now != then).count() < 140);
    }
}

#[test]
fn curved_polygons_and_surfaces_are_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let triangles = [[0, 1, 2], [1, 3, 2]];
    let mut polygons = Mesh::default();
    polygons.points.extend(corners);
    for [a, b, c] in triangles {
        let first = polygons.points.len() as u32;
        for (i, j) in [(a, b), (b, c), (c, a)] {
            let (p, q): ([f64; 3], [f64; 3]) = (corners[i as usize], corners[j as usize]);
            let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
            polygons.points.push(middle);
        }
        let nodes = [a, b, c, first, first + 1, first + 2];
        polygons.cells.push(CellKind::QuadraticPolygon, &nodes);
    }
    fold(folder.path(), polygons, 3, [-1.0, -1.0, 0.0]);
    let run = azimesh(folder.path(), REPAIR);
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["curved polygons", "convert --linearize"]);
    let mut surface = Mesh {
        space: Some(3),
        ..Mesh::default()
    };
    surface.points.extend(corners);
    surface.points[3][2] = 0.5;
    for triangle in triangles {
        surface.cells.push(CellKind::Triangle, &triangle);
    }
    fold(folder.path(), surface, 3, [-1.0, -1.0, 0.5]);
    let run = azimesh(folder.path(), REPAIR);
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["surface in space", "volume mesh"]);
}

/// The mesh of [`curved`] with a square hole; its sides are in the tags `body` and `outer`.
fn curved_with_hole() -> Mesh {
    let mut mesh = curved(9);
    let is_outside = |cell: CellRef<'_>| {
        let corners = cell.nodes[..3]
            .iter()
            .map(|&node| mesh.points[node as usize]);
        let centre = corners.fold([0.0; 2], |sum, x| {
            [sum[0] + x[0] / 3.0, sum[1] + x[1] / 3.0]
        });
        centre.iter().any(|x| (x - 0.5).abs() > 1.0 / 6.0)
    };
    let keep = mesh.cells.iter().filter(|cell| is_outside(*cell));
    let keep: Vec<usize> = keep.map(|cell| cell.index).collect();
    mesh.cells = mesh.cells.select(keep);
    let mut sides = BTreeMap::new();
    for cell in mesh.cells.iter() {
        for k in 0..3 {
            let side = [cell.nodes[k], cell.nodes[(k + 1) % 3], cell.nodes[3 + k]];
            sides.entry(side[2]).or_insert((side, 0)).1 += 1;
        }
    }
    sides.retain(|_, (_, n_cells)| *n_cells == 1);
    let mut tags = [Vec::new(), Vec::new()];
    for (middle, (side, _)) in sides {
        let is_outer = mesh.points[middle as usize][..2]
            .iter()
            .any(|x| *x == 0.0 || *x == 1.0);
        tags[usize::from(is_outer)].push(mesh.cells.len());
        mesh.cells.push(CellKind::Line3, &side);
    }
    for (name, cells) in ["body", "outer"].into_iter().zip(tags) {
        mesh.add_tag(name, cells).expect("sides");
    }
    mesh
}

#[test]
fn steps_of_curved_cells_are_repaired_to_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(&curved_with_hole(), &folder.join("c.vtu"));
    let schedule = "azimuth.values = [0, 90]
boundaries.fixed = ['outer']
rbf.support_radius = 0.4
[[body]]
name = 'a'
tags = ['body']
rigid.rotate = { origin = [0.5, 0.5, 0], axis = [0, 0, 1], harmonics = [{ sin = 70 }] }
";
    std::fs::write(folder.join("c.toml"), schedule).unwrap();
    let warn = format!("{schedule}[output]\non_inverted = 'warn'\n");
    std::fs::write(folder.join("warn.toml"), warn).unwrap();
    assert_eq!(azimesh(folder, "deform c.vtu warn.toml -o bare").code, 1);
    let inverted = json(
        folder,
        ["quality", "bare/c_0001.vtu", "--reference", "c.vtu"],
    );
    assert!(inverted["inverted"].as_u64() > Some(0), "{inverted}");
    for threads in ["1", "2"] {
        let run = azimesh(
            folder,
            format!("deform c.vtu c.toml -o {threads} --threads {threads}"),
        );
        assert_eq!(run.code, 0, "{run:?}");
    }
    let [one, two] =
        ["1", "2"].map(|of| std::fs::read(folder.join(of).join("c_0001.vtu")).unwrap());
    assert!(one == two);
    let found = json(folder, ["quality", "1/c_0001.vtu", "--reference", "c.vtu"]);
    assert_eq!(found["inverted"], 0, "{found}");
}
