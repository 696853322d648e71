//! A mesh for the tests of all formats of VTK.

use crate::mesh::{CellKind, DataArray, Group, Mesh, Values};

/// Every kind of thing that a mesh can hold: mixed cells, a polyhedron, a face in two tags, zones, groups of lower
/// dimension, arrays of every type.
pub fn rich_mesh() -> Mesh {
    let point = |i: u32| [i % 3, i, i * i].map(f64::from);
    let points = (0..30).map(point).map(|[x, y, z]| [x, y / 3.0, -0.1 * z]);
    let mut mesh = Mesh::of_points(points.collect());
    let cells = &mut mesh.cells;
    cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    cells.push(CellKind::Hexahedron, &[2, 3, 4, 5, 6, 7, 8, 9]);
    let stream = [
        4, 3, 10, 11, 12, 3, 10, 11, 13, 3, 11, 12, 13, 3, 10, 12, 13,
    ];
    cells.push_polyhedron(&stream).expect("a good stream");
    let nodes: Vec<u32> = (0..27).collect();
    cells.push(CellKind::LagrangeHexahedron, &nodes);
    cells.push(CellKind::Triangle, &[0, 1, 2]);
    cells.push(CellKind::Polygon, &[2, 3, 4, 5, 6]);
    cells.push(CellKind::Quadrilateral, &[2, 3, 4, 5]);
    cells.push(CellKind::Line, &[0, 1]);
    cells.push(CellKind::Vertex, &[13]);
    let group = |dimension, name, number, cells: &[usize]| {
        Group::new(
            dimension,
            name,
            Some(number),
            cells.iter().copied().collect(),
        )
    };
    mesh.groups = vec![
        group(2, "wall <&\"> ä %", 1, &[5, 6]),
        group(2, "unused", 2, &[]),
        group(2, "probe", 3, &[6, 7]),
        group(3, "rotor", 1, &[0, 1]),
        group(3, "outside", 2, &[2, 3, 4]),
        group(1, "edge", 1, &[8]),
        group(0, "corner", 2, &[9]),
    ];
    let texts = (0..10).map(|i| "x ".repeat(i * 40));
    let of_cells = [
        ("i8", Values::I8((-5..5).collect())),
        ("u8", Values::U8((0..10).map(|i| i * 28).collect())),
        ("i16", Values::I16((0..10).map(|i| i * -3000).collect())),
        ("u16", Values::U16((0..10).map(|i| i * 7000).collect())),
        ("i32", Values::I32((0..10).map(|i| i32::MIN >> i).collect())),
        ("u32", Values::U32((0..10).map(|i| u32::MAX >> i).collect())),
        ("i64", Values::I64((0..10).map(|i| i64::MIN >> i).collect())),
        ("u64", Values::U64((0..10).map(|i| u64::MAX >> i).collect())),
        ("text", Values::Text(texts.collect())),
    ];
    mesh.cell_arrays = of_cells
        .map(|(name, values)| DataArray::scalar(name, values))
        .into();
    let thirds = |n: u16| (0..n).map(|i| f64::from(i) / 3.0 - 1e-300);
    let single = thirds(30).map(|x| x as f32 * 1e30);
    mesh.point_arrays = vec![
        DataArray {
            component_names: ["u u", "v%", "w & x"].map(String::from).into(),
            ..DataArray::tuples("a velocity", 3, Values::F64(thirds(90).collect()))
        },
        DataArray::scalar("p", Values::F32(single.collect())),
        DataArray::tuples("stress", 11, Values::F64(thirds(330).collect())),
    ];
    let title = ["a", "", "ü\n"].map(String::from);
    mesh.field_arrays = vec![
        DataArray::scalar("TimeValue", Values::F64(vec![0.1])),
        DataArray::scalar("title", Values::Text(title.into())),
        DataArray::scalar("nothing", Values::I64(vec![])),
    ];
    mesh
}
