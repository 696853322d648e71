//! Round trips, and the oddities of real files.

use super::super::{Encoding, Format, Notes, ReadOptions, Source, WriteOptions};
use super::{MSH22, MSH41};
use crate::formats::parse;
use crate::mesh::lagrange::n_nodes;
use crate::mesh::{CellKind, DataArray, Group, Mesh, Values};
use crate::testing::assert_says;

fn read(bytes: &[u8]) -> Mesh {
    let mut mesh = parse(&MSH41, bytes, &ReadOptions::default()).expect("a good file");
    mesh.validate().expect("a good mesh");
    mesh.merge_repeated_faces();
    mesh
}

fn group(dimension: u8, name: &str, number: i32, cells: &[usize]) -> Group {
    let cells = cells.iter().copied().collect();
    Group::new(dimension, name, Some(number), cells)
}

/// Every kind that comes back as itself, with its number of nodes.
fn sizes() -> Vec<(CellKind, usize)> {
    let mut sizes = Vec::new();
    for kind in CellKind::ALL {
        let lowest = if kind == CellKind::LagrangePyramid {
            2
        } else {
            3
        };
        match kind.n_nodes() {
            Some(n) => sizes.push((kind, n)),
            None => sizes.extend((lowest..6).filter_map(|p| Some((kind, n_nodes(kind, p)?)))),
        }
    }
    sizes.retain(|(kind, n)| {
        *kind != CellKind::CubicLine && super::kinds::number(*kind, *n).is_some()
    });
    sizes
}

/// One cell of every kind and order that MSH holds, in groups of every dimension.
fn every_kind() -> Mesh {
    let mut mesh = Mesh::of_points(
        (0..240)
            .map(|i| {
                let x = f64::from(i);
                [x / 3.0, -x * 1e-9, 1e17 / (x + 0.7)]
            })
            .collect(),
    );
    let mut of_dimension: [Vec<usize>; 4] = Default::default();
    for (kind, n) in sizes() {
        let nodes: Vec<u32> = (5..).take(n).collect();
        of_dimension[usize::from(kind.dimension())].push(mesh.cells.len());
        mesh.cells.push(kind, &nodes);
    }
    let [points, lines, surfaces, volumes] = &of_dimension;
    mesh.groups = vec![
        group(3, "air", 4, &volumes[1..]),
        group(3, "rotor", 5, &volumes[2..6]),
        group(2, "upper wall", 2, &surfaces[..3]),
        group(2, "hub", 7, &surfaces[2..]),
        group(1, "the \"edge\"", 2, &lines[1..]),
        group(1, "edges", 3, lines),
        group(0, "9", 9, points),
    ];
    mesh
}

fn written(format: &Format, mesh: &Mesh, encoding: Encoding) -> Vec<u8> {
    let options = WriteOptions {
        encoding,
        ..WriteOptions::default()
    };
    let mut file = Vec::new();
    format
        .write_file(&mesh.view(), &mut file, &options)
        .expect("MSH holds it");
    file
}

#[test]
fn every_kind_and_group_comes_back_from_every_flavour() {
    let mut mesh = every_kind();
    for format in [&MSH41, &MSH22] {
        for encoding in [Encoding::Raw, Encoding::Ascii] {
            let back = read(&written(format, &mesh, encoding));
            assert_eq!(back.points, mesh.points);
            assert_eq!(back.cells, mesh.cells);
            // A quote inside a name cannot be written.
            mesh.groups[4].name = "the 'edge'".into();
            let mut groups = back.groups;
            groups.sort_by_key(|group| std::cmp::Reverse(group.dimension));
            assert_eq!(groups, mesh.groups);
        }
    }
}

#[test]
fn what_is_left_out_is_said() {
    let mut mesh = every_kind();
    let text = Values::Text(vec!["a".into()]);
    mesh.field_arrays.push(DataArray::scalar("title", text));
    let large = Values::I64(vec![1 << 60; mesh.points.len()]);
    mesh.point_arrays.push(DataArray::scalar("hash", large));
    mesh.groups[0].condition = Some("BCWall".into());
    let notes = MSH41
        .write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default())
        .expect("MSH holds the rest");
    let expected = [
        "renamed",
        "integers_rounded",
        "arrays_left_out",
        "conditions_left_out",
    ];
    assert_eq!(notes, expected);
    let renamed = notes.iter().next().expect("the first");
    assert_eq!(renamed.get("name"), "the \"edge\"");
    assert_eq!(renamed.get("written"), "the 'edge'");
    assert!(
        notes.says("MSH holds no field arrays; left out: \"title\""),
        "{notes:?}"
    );
    let conditions = "MSH holds no types of boundary conditions; the types of 1 tag are left out";
    assert!(notes.says(conditions), "{notes:?}");
    mesh.cells.push(CellKind::Polygon, &[0, 1, 2]);
    for format in [&MSH41, &MSH22] {
        let error = format
            .write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default())
            .expect_err("a polygon");
        assert_says(&error, "polygon");
    }
}

#[test]
fn empty_groups_and_unused_nodes_are_kept() {
    let mut mesh = every_kind();
    mesh.groups.push(group(2, "spare", 11, &[]));
    mesh.groups.push(group(2, "12", 12, &[]));
    for format in [&MSH41, &MSH22] {
        let back = read(&written(format, &mesh, Encoding::Raw));
        let empty = back.groups.iter().filter(|group| group.cells.is_empty());
        let names: Vec<&str> = empty.map(|group| &group.name[..]).collect();
        assert_eq!(names, ["spare", "12"]);
        assert_eq!(back.points.len(), 240);
    }
}

const SQUARE_41: &str = "\
$Comments\nmade by hand\n$EndComments\n$MeshFormat\n4.1 0 8\n$EndMeshFormat
$PhysicalNames\n2\n1 3 \"lower side\"\n2 1 \"plate\"\n$EndPhysicalNames
$Entities\n0 2 1 0\n1 0 0 0 1 0 0 2 -3 5 0\n2 0 0 0 0 1 0 0 0\n4 0 0 0 1 1 0 1 1 2 1 -2\n$EndEntities
$Nodes\n2 4 10 40\n1 1 1 2\n40\n20\n0 0 0 0\n1 0 0 1\n2 4 1 2\n30\n10\n1 1 0 0.5 0.5\n0 1 0 1 1
$EndNodes\n$Unknown\n$Elements of another kind\n$EndUnknown
$Elements\n3 3 1 3\n1 1 1 1\n1 40 20\n1 2 1 1\n2 10 40\n2 4 3 1\n3 40 20 30 10\n$EndElements\n";

#[test]
fn entities_carry_groups_and_nodes_any_tags_and_parameters() {
    for file in [SQUARE_41.to_owned(), SQUARE_41.replace('\n', "\r\n")] {
        let mesh = read(file.as_bytes());
        assert_eq!(mesh.points[2], [1.0, 1.0, 0.0]);
        assert_eq!(mesh.cells.get(2).nodes, [0, 1, 2, 3]);
        assert_eq!(
            mesh.groups,
            [
                group(1, "lower side", 3, &[0]),
                group(2, "plate", 1, &[2]),
                group(1, "5", 5, &[0]),
            ]
        );
    }
}

#[test]
fn a_boundary_without_physical_groups_is_tagged_by_its_entities() {
    let file = SQUARE_41
        .replace("2 -3 5 0", "0 0")
        .replace("2\n1 3 \"lower side\"\n2 1", "1\n2 1");
    let groups = read(file.as_bytes()).groups;
    let expected = [
        group(2, "plate", 1, &[2]),
        group(1, "1", 1, &[0]),
        group(1, "2", 2, &[1]),
    ];
    assert_eq!(groups, expected);
}

#[test]
fn coordinates_of_a_block_on_one_line_are_read() {
    let file = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 3 1 3\n2 1 0 3\n1 2 3\n\
                0. 0. 0. 1. 0. 0. 0. 1. 0.\n$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n\
                $EndElements\n";
    assert_eq!(read(file.as_bytes()).points[2], [0.0, 1.0, 0.0]);
}

/// A triangle in big-endian binary, `size_bytes` each `size_t`.
fn big_endian_41(size_bytes: usize) -> Vec<u8> {
    let mut file = format!("$MeshFormat\n4.1 1 {size_bytes}\n").into_bytes();
    let size = |n: u64| n.to_be_bytes()[8 - size_bytes..].to_vec();
    let int = |n: i32| n.to_be_bytes().to_vec();
    file.extend(int(1));
    file.extend(b"\n$EndMeshFormat\n$Nodes\n");
    file.extend([1, 3, 1, 3].map(size).concat());
    file.extend([int(2), int(1), int(0), size(3)].concat());
    file.extend([1, 2, 3].map(size).concat());
    for x in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.25f64] {
        file.extend(x.to_be_bytes());
    }
    file.extend(b"\n$EndNodes\n$Elements\n");
    file.extend([1, 1, 1, 1].map(size).concat());
    file.extend([int(2), int(1), int(2), size(1)].concat());
    file.extend([1, 3, 1, 2].map(size).concat());
    file.extend(b"\n$EndElements\n");
    file
}

#[test]
fn big_endian_and_short_sizes_are_read() {
    for size_bytes in [4, 8] {
        let mesh = read(&big_endian_41(size_bytes));
        assert_eq!(mesh.points[2], [0.0, 1.0, 0.25]);
        assert_eq!(mesh.cells.get(0).nodes, [2, 0, 1]);
    }
}

#[test]
fn an_element_without_tags_is_in_no_group() {
    let file = "$MeshFormat\n2.0 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n6 \"plate\"\n\
                $EndPhysicalNames\n$Nodes\n4\n0 0 0 0\n1 1 0 0\n2 1 1 0\n3 0 1 0\n$EndNodes\n\
                $Elements\n2\n1 2 0 0 1 2\n2 2 3 -6 8 1 0 2 3\n$EndElements\n";
    let mesh = read(file.as_bytes());
    assert_eq!(mesh.groups, [group(2, "plate", 6, &[1])]);
}

/// Two triangles with sparse node tags, numbers out of order, entities within a group, and values at
/// some nodes and elements.
const SPARSE: &str = "\
$MeshFormat\n4.1 0 8\n$EndMeshFormat
$PhysicalNames\n2\n-1 7 \"any\"\n2 0 \"zero\"\n$EndPhysicalNames
$Entities\n0 0 2 0\n5 0 0 0 1 1 0 1 0 0\n9 0 0 0 1 1 0 1 0 0\n$EndEntities
$Nodes\n1 4 3 900\n2 5 0 4\n900\n3\n40\n41\n0 0 0\n1 0 0\n1 1 0\n0 1 0
$Elements\n2 2 11 30\n2 5 2 1\n30 900 3 40\n2 9 2 1\n11 900 40 41\n$EndElements
$NodeData\n1\n\"t\"\n1\n0\n3\n0\n2\n2\n900 1 2\n41 nan -inf\n$EndNodes
$ElementData\n1\n \"q\"\n0\n3\n0\n1\n2\n11 7.5\n99 1\n$EndElementData
$Periodic\n0\n$EndPeriodic\n";

#[test]
fn tags_entities_and_values_survive_both_versions() {
    let source = Source::from_bytes("sparse".as_ref(), SPARSE.into());
    let mut notes = Notes::default();
    let mesh = MSH41.read_file(&source, &ReadOptions::default(), &mut notes);
    let mesh = mesh.expect("a good file");
    for text in [
        "periodic links between entities ($Periodic) are not kept",
        "\"q\" has 1 value for elements that are not in the mesh",
        "\"t\" has no value at 2 of 4 nodes, where it is NaN",
    ] {
        assert!(notes.says(text), "{text}: {notes:?}");
    }
    assert_eq!(mesh.groups, [group(2, "zero", 0, &[0, 1])]);
    let names = |arrays: &[DataArray]| arrays.iter().map(|a| a.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&mesh.point_arrays), ["t", "node_number"]);
    assert_eq!(
        names(&mesh.cell_arrays),
        ["gmsh:geometrical", "q", "cell_number"]
    );
    assert_eq!(mesh.cell_arrays[0].values, Values::I32(vec![5, 9]));
    assert_eq!(mesh.cell_arrays[2].values, Values::I64(vec![30, 11]));
    let shown = |mesh: &Mesh| format!("{:?}", (&mesh.point_arrays, &mesh.cell_arrays));
    for format in [&MSH41, &MSH22] {
        for encoding in [Encoding::Raw, Encoding::Ascii] {
            let back = read(&written(format, &mesh, encoding));
            assert_eq!(shown(&back), shown(&mesh));
            assert_eq!(back.points, mesh.points);
            assert_eq!(back.cells, mesh.cells);
        }
    }
    let text = String::from_utf8(written(&MSH41, &mesh, Encoding::Ascii)).expect("text");
    assert_says(&text, "\n2 9 2 1\n11 900 40 41\n");
    assert_says(&text, "\n41 NaN -inf\n$EndNodeData");
}

#[test]
fn tags_that_are_not_distinct_are_no_tags() {
    let mut mesh = read(SQUARE_41.as_bytes());
    let doubled = Values::I64(vec![3, 3, 4, 5]);
    mesh.point_arrays = vec![DataArray::scalar("node_number", doubled)];
    mesh.cell_arrays = vec![DataArray::scalar(
        "cell_number",
        Values::I64(vec![-1, 2, 3]),
    )];
    let back = read(&written(&MSH41, &mesh, Encoding::Raw));
    assert_eq!(back.cells, mesh.cells);
    assert_eq!(
        back.point_arrays[0].values,
        Values::F64(vec![3.0, 3.0, 4.0, 5.0])
    );
    assert_eq!(
        back.cell_arrays[0].values,
        Values::F64(vec![-1.0, 2.0, 3.0])
    );
}

#[test]
fn several_volumes_without_groups_are_zones() {
    let file = SPARSE
        .replace("1 1 0 1 0 0", "1 1 0 0 0")
        .replace("\n2 0 \"zero\"", "")
        .replace("$PhysicalNames\n2", "$PhysicalNames\n1");
    let mesh = read(file.as_bytes());
    assert_eq!(
        mesh.groups,
        [group(2, "5", 5, &[0]), group(2, "9", 9, &[1])]
    );
    assert!(
        mesh.cell_arrays
            .iter()
            .all(|array| array.name != "gmsh:geometrical")
    );
}

#[test]
fn cells_that_msh_lacks_are_refused_with_the_way_out() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3]; 8]);
    mesh.cells.push(CellKind::Triangle7, &[0, 1, 2, 3, 4, 5, 6]);
    let refusal = |mesh: &Mesh| {
        let refused = MSH41.write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default());
        refused.expect_err("MSH has no such cell").to_string()
    };
    assert!(refusal(&mesh).contains("`linearize`"));
    mesh.cells = Default::default();
    mesh.cells.push(CellKind::Polygon, &[0, 1, 2, 3, 4]);
    assert!(!refusal(&mesh).contains("`linearize`"));
}

#[test]
fn elements_that_a_mesh_lacks_are_refused_by_name() {
    for (number, word) in [
        (20, "serendipity"),
        (34, "level set"),
        (136, "level set"),
        (138, "bubble"),
    ] {
        let file = SQUARE_41.replace("2 4 3 1\n3 40", &format!("2 4 {number} 1\n3 40"));
        let error = parse(&MSH41, file.as_bytes(), &ReadOptions::default()).expect_err("refused");
        assert_says(&error, word);
    }
}

/// A triangle with these tags of its nodes and values at them.
fn triangle(tags: [i64; 3], values: DataArray) -> Mesh {
    let mut mesh = Mesh::of_points(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    let tags = Values::I64(tags.to_vec());
    mesh.point_arrays = vec![DataArray::scalar("node_number", tags), values];
    mesh
}

#[test]
fn values_of_nodes_with_tags_above_32_bits_stay_with_them() {
    let p = DataArray::scalar("p", Values::F64(vec![1.0, 2.0, 3.0]));
    let mesh = triangle([3_000_000_000, 3_000_000_001, 7], p);
    for encoding in [Encoding::Raw, Encoding::Ascii] {
        let options = WriteOptions {
            encoding,
            ..WriteOptions::default()
        };
        let mut bytes = Vec::new();
        let notes = MSH41
            .write_file(&mesh.view(), &mut bytes, &options)
            .expect("written");
        assert_eq!(notes, ["counted_from_one"]);
        let back = read(&bytes);
        let p = back.point_arrays.iter().find(|array| array.name == "p");
        assert_eq!(p, Some(&mesh.point_arrays[1]));
        let mut alone = mesh.clone();
        alone.point_arrays.pop();
        assert_eq!(read(&written(&MSH41, &alone, encoding)), alone);
    }
}

#[test]
fn arrays_of_more_components_than_are_read_are_left_out() {
    for (n, is_written) in [(100, true), (101, false)] {
        let wide = DataArray::tuples("wide", n, Values::F64(vec![0.5; 3 * n]));
        let mesh = triangle([1, 2, 3], wide);
        for format in [&MSH41, &MSH22] {
            let mut bytes = Vec::new();
            let notes = format.write_file(&mesh.view(), &mut bytes, &WriteOptions::default());
            let notes = notes.expect("it can be written");
            let said = notes.has("too_many_components");
            assert_eq!(said, !is_written, "{notes:?}");
            let names = |array: &DataArray| array.name == "wide";
            assert_eq!(read(&bytes).point_arrays.iter().any(names), is_written);
        }
    }
}

#[test]
fn msh_3_is_refused_with_the_versions_that_are_read() {
    let file = SQUARE_41.replace("\n4.1 0 8", "\n3 0 8");
    let error = parse(&MSH41, file.as_bytes(), &ReadOptions::default()).expect_err("refused");
    let message = "this is MSH 3; versions 1, 2, 4.0 and 4.1 are read";
    assert_says(&error, message);
}
