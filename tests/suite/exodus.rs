//! Exodus files: what is read of them, and what is refused.

use crate::support::exodus::{file, small};
use crate::support::netcdf::{NetCdf, Numbers, text};
use crate::support::sequence::testdata;
use crate::support::{assert_says, azimesh, json, succeed};
use azimesh_core::error::{Error, Position};
use azimesh_io::formats::exodus::EXODUS;
use azimesh_io::formats::{ReadOptions, parse};
use azimesh_io::mesh::{CellKind, Mesh, Values};

fn read_at(bytes: &[u8], step: Option<usize>) -> Result<Mesh, Error> {
    let options = ReadOptions {
        step,
        ..ReadOptions::default()
    };
    let mesh = parse(&EXODUS, bytes, &options)?;
    mesh.validate().unwrap();
    Ok(mesh)
}

fn read(bytes: &[u8]) -> Mesh {
    read_at(bytes, None).unwrap()
}

/// A file is refused because of a variable, in a sentence with these parts.
fn assert_refused(file: &NetCdf, variable: &str, parts: &[&str]) {
    let error = parse(&EXODUS, &file.bytes(), &ReadOptions::default()).expect_err(variable);
    let position = Some(Position::Dataset(variable.into()));
    assert_eq!(error.position, position, "{error}");
    assert_says(&error.message, parts);
}

#[test]
fn blocks_are_cells_with_zones_and_side_sets_are_tags() {
    for version in [1, 2, 5] {
        let mesh = read(&small(version));
        assert_eq!(mesh.points.len(), 16);
        assert_eq!(mesh.points[3], [3.0, 0.5, -9.0]);
        let kinds: Vec<_> = mesh.cells.iter().map(|cell| cell.kind).collect();
        let elements = [
            CellKind::Tetrahedron,
            CellKind::Wedge,
            CellKind::Polyhedron,
            CellKind::Triangle,
            CellKind::Triangle,
        ];
        assert_eq!(kinds[..5], elements);
        let faces = [
            CellKind::Triangle,
            CellKind::Quadrilateral,
            CellKind::Triangle,
        ];
        assert_eq!(kinds[5..], faces);
        assert_eq!(mesh.cells.get(1).nodes, [0, 1, 2, 3, 4, 5]);
        assert_eq!(mesh.cells.polyhedron_faces(2).nth(1).unwrap(), [8, 6, 5]);
        let groups = mesh.groups.iter().map(|group| {
            let cells: Vec<usize> = group.cells.iter().collect();
            (
                group.name.as_str(),
                group.number.unwrap(),
                group.dimension,
                cells,
            )
        });
        let groups: Vec<_> = groups.collect();
        let expected = [
            ("air", 10, 3, vec![0]),
            ("20", 20, 3, vec![1]),
            ("cells", 40, 3, vec![2]),
            ("skin", 50, 2, vec![3, 4]),
            ("upper wall", 7, 2, vec![5, 6]),
            // The first face of a shell is the shell.
            ("8", 8, 2, vec![3, 7]),
        ];
        assert_eq!(groups, expected);
        assert_eq!(mesh.cells.get(5).nodes, [0, 2, 1]);
        assert_eq!(mesh.cells.get(6).nodes, [0, 1, 4, 3]);
        assert_eq!(mesh.cells.get(7).nodes, [8, 6, 5]);
    }
}

#[test]
fn results_are_arrays_at_a_step() {
    for version in [1, 2, 5] {
        for (step, time) in [(Some(0), 0.0), (Some(1), 100.0), (None, 100.0)] {
            let mesh = read_at(&small(version), step).unwrap();
            let names: Vec<_> = mesh.point_arrays.iter().map(|a| a.name.as_str()).collect();
            assert_eq!(names, ["GlobalNodeId", "displ", "p"]);
            let Values::F64(displacement) = &mesh.point_arrays[1].values else {
                panic!("of 64 bits");
            };
            assert_eq!(
                displacement[3 * 8..3 * 9],
                [time + 0.5, time + 10.5, time + 20.5]
            );
            let Values::F64(p) = &mesh.point_arrays[2].values else {
                panic!("of 64 bits");
            };
            assert_eq!(p[4], time + 30.25);
            let Values::F32(stress) = &mesh.cell_arrays[0].values else {
                panic!("of 32 bits");
            };
            let last = f32::from(u8::from(time > 0.0));
            assert_eq!(
                [stress[0], stress[5]],
                [1.0 + last; 2],
                "a face has that of its cell"
            );
            assert!(stress[1].is_nan() && stress[2].is_nan() && stress[6].is_nan());
            assert_eq!(stress[3..5], [3.0 + 2.0 * last, 4.0 + 2.0 * last]);
            assert_eq!(mesh.field_arrays[1].name, "energy");
            let energy = Values::F64(vec![2.0 + 2.0 * f64::from(last)]);
            assert_eq!(mesh.field_arrays[1].values, energy);
        }
    }
    let error = read_at(&small(2), Some(2)).unwrap_err();
    assert_says(&error.message, &["no step 2", "0 to 1"]);
}

/// A cube of one hexahedron with node sets alone.
fn cube(n_nodes: usize, name: &str) -> NetCdf {
    let mut file = NetCdf::new(
        2,
        0,
        &[
            ("len_string", 33),
            ("num_dim", 3),
            ("num_nodes", n_nodes),
            ("num_el_blk", 1),
            ("num_node_sets", 2),
            ("num_el_in_blk1", 1),
            ("num_nod_per_el1", n_nodes),
            ("num_nod_ns1", 4),
            ("num_nod_ns2", 2),
        ],
    );
    let axis = |of: &dyn Fn(usize) -> usize| {
        Numbers::F64(
            (0..n_nodes)
                .map(|i| of(i % 8) as f64 + i as f64 / 64.0)
                .collect(),
        )
    };
    file.add("coordx", &["num_nodes"], axis(&|i| i.div_ceil(2) % 2));
    file.add("coordy", &["num_nodes"], axis(&|i| i / 2 % 2));
    file.add("coordz", &["num_nodes"], axis(&|i| i / 4));
    let nodes = (1..=n_nodes as i32).collect();
    let dimensions = ["num_el_in_blk1", "num_nod_per_el1"];
    file.connect("connect1", &dimensions, name, Numbers::I32(nodes));
    file.add(
        "ns_names",
        &["num_node_sets", "len_string"],
        text(33, &["floor", "edge"]),
    );
    file.add("node_ns1", &["num_nod_ns1"], Numbers::I32(vec![1, 2, 3, 4]));
    file.add("node_ns2", &["num_nod_ns2"], Numbers::I32(vec![1, 2]));
    file
}

#[test]
fn node_sets_are_tags_of_the_outer_faces_where_there_are_no_side_sets() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.g"), cube(8, "hex").bytes()).unwrap();
    let info = json(folder.path(), "info cube.g");
    assert_eq!(info["boundary_tags"][0]["name"], "floor", "{info}");
    assert_eq!(info["boundary_tags"].as_array().unwrap().len(), 1, "{info}");
    let told = succeed(folder.path(), "info cube.g").err;
    assert_says(&told, &["node sets are not kept: edge"]);
    let mesh = read(&cube(8, "hex").bytes());
    assert_eq!(mesh.cells.get(1).nodes, [0, 3, 2, 1]);
}

#[test]
fn elements_with_more_nodes_than_a_cell_keep_those_that_it_has() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.g"), cube(9, "HEX9").bytes()).unwrap();
    let told = succeed(folder.path(), "info cube.g").err;
    assert_says(&told, &["1 element of type HEX9 keeps 8 of 9 nodes"]);
    let mesh = read(&cube(20, "HEX20").bytes());
    let nodes = mesh.cells.get(0).nodes;
    assert_eq!(nodes[12..], [16, 17, 18, 19, 12, 13, 14, 15]);
}

/// A pentagon beside a triangle, with a side of each in a set.
fn polygons(version: u8) -> NetCdf {
    let dimensions = [
        ("num_dim", 2),
        ("num_nodes", 6),
        ("num_el_blk", 1),
        ("num_side_sets", 1),
        ("num_el_in_blk1", 2),
        ("num_nod_per_el1", 8),
        ("num_side_ss1", 2),
    ];
    let mut file = NetCdf::new(version, 0, &dimensions);
    let axis = |values: [f64; 6]| Numbers::F64(values.to_vec());
    file.add(
        "coordx",
        &["num_nodes"],
        axis([0.0, 2.0, 2.0, 1.0, 0.0, 3.0]),
    );
    file.add(
        "coordy",
        &["num_nodes"],
        axis([0.0, 0.0, 1.0, 2.0, 1.0, 0.5]),
    );
    let nodes = Numbers::I32(vec![1, 2, 3, 4, 5, 2, 6, 3]);
    file.connect("connect1", &["num_nod_per_el1"], "nsided", nodes);
    file.add("ebepecnt1", &["num_el_in_blk1"], Numbers::I32(vec![5, 3]));
    file.add("elem_ss1", &["num_side_ss1"], Numbers::I32(vec![1, 2]));
    file.add("side_ss1", &["num_side_ss1"], Numbers::I32(vec![5, 2]));
    file
}

#[test]
fn polygons_have_as_many_nodes_and_sides_as_the_file_counts() {
    for version in [1, 2, 5] {
        let mesh = read(&polygons(version).bytes());
        let cells: Vec<_> = mesh
            .cells
            .iter()
            .map(|cell| (cell.kind, cell.nodes.to_vec()))
            .collect();
        let expected = [
            (CellKind::Polygon, vec![0, 1, 2, 3, 4]),
            (CellKind::Polygon, vec![1, 5, 2]),
            (CellKind::Line, vec![4, 0]),
            (CellKind::Line, vec![5, 2]),
        ];
        assert_eq!(cells, expected);
    }
    type Wrong<'a> = (&'a str, [i32; 2], &'a [&'a str]);
    let wrong: [Wrong; 4] = [
        ("ebepecnt1", [5, 4], &["value 1", "8 entries"]),
        ("ebepecnt1", [5, 2], &["add up to 7", "8 entries"]),
        ("ebepecnt1", [6, 2], &["polygon 2 has 2 nodes"]),
        (
            "side_ss1",
            [5, 4],
            &["value 1", "side 4", "element 2", "polygon"],
        ),
    ];
    for (variable, values, parts) in wrong {
        let mut file = polygons(2);
        file.replace(variable, Numbers::I32(values.to_vec()));
        assert_refused(&file, variable, parts);
    }
}

/// Two polyhedra, a cube and the pyramid on it, which share a face as the file has it.
#[test]
fn faces_of_polyhedra_turn_outward_whichever_way_the_file_has_them() {
    let dimensions = [
        ("num_dim", 3),
        ("num_nodes", 9),
        ("num_el_blk", 1),
        ("num_fa_blk", 1),
        ("num_el_in_blk1", 2),
        ("num_fac_per_el1", 11),
        ("num_fa_in_blk1", 10),
        ("num_nod_per_fa1", 36),
    ];
    let faces = [
        &[1, 2, 3, 4][..],
        &[5, 6, 7, 8],
        &[1, 2, 6, 5],
        &[3, 2, 6, 7],
        &[3, 4, 8, 7],
        &[4, 1, 5, 8],
        &[5, 6, 9],
        &[7, 6, 9],
        &[7, 8, 9],
        &[8, 5, 9],
    ];
    for version in [1, 2, 5] {
        let mut file = NetCdf::new(version, 0, &dimensions);
        let axes = [
            [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.5],
            [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.5],
            [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0],
        ];
        for (name, axis) in ["coordx", "coordy", "coordz"].iter().zip(axes) {
            file.add(name, &["num_nodes"], Numbers::F64(axis.to_vec()));
        }
        let nodes = Numbers::I32(faces.concat());
        file.connect("fbconn1", &["num_nod_per_fa1"], "nsided", nodes);
        let lengths = faces.iter().map(|face| face.len() as i32).collect();
        file.add("fbepecnt1", &["num_fa_in_blk1"], Numbers::I32(lengths));
        let numbers = Numbers::I32(vec![1, 2, 3, 4, 5, 6, 2, 7, 8, 9, 10]);
        file.connect("facconn1", &["num_fac_per_el1"], "nfaced", numbers);
        file.add("ebepecnt1", &["num_el_in_blk1"], Numbers::I32(vec![6, 5]));
        let mesh = read(&file.bytes());
        for (cell, volume) in [(0, 1.0), (1, 1.0 / 3.0)] {
            let sides = mesh.cells.polyhedron_faces(cell);
            let found: f64 = sides.map(|side| under(&mesh, side)).sum();
            assert!((found - volume).abs() < 1e-12, "{version} {cell}: {found}");
        }
    }
}

/// The volume between a plane face and the origin, positive where the face turns away from it.
fn under(mesh: &Mesh, side: &[u32]) -> f64 {
    let at = |i: usize| mesh.points[side[i] as usize];
    let triangles = (2..side.len()).map(|i| [at(0), at(i - 1), at(i)]);
    triangles
        .map(|[a, b, c]| {
            let cross = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
            (a[0] * cross(1, 2) + a[1] * cross(2, 0) + a[2] * cross(0, 1)) / 6.0
        })
        .sum()
}

/// Changes of the small file, the variable that is named, and words of the refusal.
type Change<'a> = (&'a dyn Fn(&mut NetCdf), &'a str, &'a [&'a str]);

#[test]
fn what_is_wrong_in_a_file_is_refused_by_the_name_of_its_variable() {
    let changes: [Change; 8] = [
        (
            &|file| file.replace("connect1", Numbers::I32(vec![1, 2, 17, 4])),
            "connect1",
            &["value 2", "node 17", "there are 16"],
        ),
        (
            &|file| file.replace("facconn4", Numbers::I32(vec![1, 2, 3, 5])),
            "facconn4",
            &["value 3", "face 5", "there are 4"],
        ),
        (
            &|file| file.replace("fbepecnt1", Numbers::I32(vec![3, 3, 3, 4])),
            "fbepecnt1",
            &["value 3", "12 entries"],
        ),
        (
            &|file| file.replace("side_ss1", Numbers::I32(vec![5, 1])),
            "side_ss1",
            &["value 0", "side 5", "element 1", "tetrahedron"],
        ),
        (
            &|file| file.replace("elem_ss2", Numbers::I32(vec![3, 6])),
            "elem_ss2",
            &["value 1", "element 6", "there are 5"],
        ),
        (
            &|file| file.remove("coordy"),
            "coordy",
            &["no such variable"],
        ),
        (
            &|file| file.resize("num_el_blk", 5_000_000),
            "num_el_blk",
            &["5000000"],
        ),
        (
            &|file| file.replace("coordz", Numbers::F64(vec![f64::NAN; 16])),
            "coordz",
            &["node 1", "finite"],
        ),
    ];
    for (change, variable, parts) in changes {
        let mut file = file(2);
        change(&mut file);
        assert_refused(&file, variable, parts);
    }
    let mut strange = cube(8, "SUPER");
    strange.remove("node_ns1");
    let error = parse(&EXODUS, &strange.bytes(), &ReadOptions::default()).unwrap_err();
    assert_says(&error.message, &["element block 1", "\"SUPER\""]);
}

#[test]
fn a_piece_of_a_decomposed_mesh_and_a_short_file_are_named() {
    let dimensions = [
        ("num_dim", 3),
        ("num_nodes", 1),
        ("num_processors", 4),
        ("num_procs_file", 1),
    ];
    let piece = NetCdf::new(1, 0, &dimensions).bytes();
    let error = parse(&EXODUS, &piece, &ReadOptions::default()).unwrap_err();
    assert_says(&error.message, &["1 of the 4 pieces", "epu"]);
    let whole = small(5);
    let error = parse(
        &EXODUS,
        &whole[..whole.len() - 700],
        &ReadOptions::default(),
    )
    .unwrap_err();
    assert_says(&error.message, &["cut short"]);
    let error = parse(&EXODUS, b"CDF\x03rest", &ReadOptions::default()).unwrap_err();
    assert_says(&error.message, &["version 3", "1, 2 and 5"]);
}

/// Both are written by netCDF's library, the first with compressed values.
#[test]
fn files_of_netcdfs_library_are_read_like_ours() {
    for name in ["exodus_hdf5.exo", "exodus_cdf5.exo"] {
        let bytes = std::fs::read(testdata(name)).unwrap();
        for step in [0, 1] {
            let found = read_at(&bytes, Some(step)).unwrap();
            let expected = read_at(&small(2), Some(step)).unwrap();
            assert_eq!(found.points, expected.points);
            assert_eq!(found.cells, expected.cells);
            assert_eq!(found.groups, expected.groups);
            assert_eq!(found.point_arrays, expected.point_arrays);
            assert_eq!(
                format!("{:?}", found.cell_arrays),
                format!("{:?}", expected.cell_arrays)
            );
            assert_eq!(found.field_arrays, expected.field_arrays);
        }
    }
}

#[test]
fn the_program_reads_a_sequence_and_does_not_write_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("a.exo"), small(5)).unwrap();
    let info = json(at, "info a.exo");
    assert_eq!(info["format"], "Exodus II (.exo)", "{info}");
    succeed(at, "convert a.exo --step 0 a.vtu");
    succeed(at, "convert a.exo --step 1 b.vtu");
    assert_eq!(azimesh(at, "diff a.vtu b.vtu").code, 1);
    for args in [
        "convert a.vtu b.exo",
        "convert a.vtu -o b.exo",
        "convert a.vtu - --format exodus",
        "sample naca0012 -o n.exo",
    ] {
        let run = azimesh(at, args);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, &["Exodus II", "is read, not written"]);
    }
    assert!(!at.join("b.exo").exists());
}
