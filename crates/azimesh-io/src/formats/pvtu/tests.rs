use super::*;
use crate::formats::{self, Commit, Loaded, ReadOptions, Source, Staged, WriteOptions, stage};
use crate::mesh::{CellKind, DataArray, Group, Mesh, Values};
use crate::testing::assert_says;
use azimesh_core::error::Result;
use std::num::NonZeroUsize;
use std::path::Path;

/// A bar of hexahedra with tagged ends, two zones, a node of no cell, and arrays.
fn bar(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for (y, z) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            mesh.points.push([f64::from(i) / 3.0, y, z]);
        }
    }
    mesh.points.push([100.0, 0.0, 0.0]);
    let cells = &mut mesh.cells;
    cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
    for i in 0..n {
        let nodes: Vec<u32> = (4 * i..4 * i + 8).collect();
        cells.push(CellKind::Hexahedron, &nodes);
    }
    cells.push(
        CellKind::Quadrilateral,
        &[4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3],
    );
    let last = n as usize + 1;
    let group = |dimension, name: &str, number, cells: &[usize]| {
        Group::new(
            dimension,
            name,
            Some(number),
            cells.iter().copied().collect(),
        )
    };
    mesh.groups = vec![
        group(2, "inlet", 1, &[0]),
        group(2, "outlet", 2, &[last]),
        group(2, "both", 3, &[0, last]),
        group(3, "first", 1, &[1]),
        group(3, "rest", 2, &(2..last).collect::<Vec<_>>()),
    ];
    let numbers = |n: usize| (0..n).map(|i| i as f64 / 7.0).collect();
    let (n_points, n_cells) = (mesh.points.len(), mesh.cells.len());
    mesh.point_arrays = vec![DataArray::scalar("p", Values::F64(numbers(n_points)))];
    mesh.cell_arrays = vec![DataArray::scalar("c", Values::F64(numbers(n_cells)))];
    mesh.field_arrays = vec![DataArray::scalar("TimeValue", Values::F64(vec![0.5]))];
    mesh
}

fn stage_pieces(mesh: &Mesh, path: &Path, n: usize) -> Result<(Notes, Staged)> {
    let options = WriteOptions {
        pieces: NonZeroUsize::new(n),
        ..WriteOptions::default()
    };
    stage(&mesh.view(), path, &PVTU, &options, Commit::REPLACE)
}

fn write_pieces(mesh: &Mesh, path: &Path, n: usize) -> Result<Notes> {
    let (notes, files) = stage_pieces(mesh, path, n)?;
    files.keep()?;
    Ok(notes)
}

fn load(path: &Path) -> Loaded {
    let source = Source::open(path).expect("it is there");
    formats::read(&source.into(), &ReadOptions::default()).expect("it can be read")
}

#[test]
fn a_mesh_cut_into_pieces_comes_back_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = bar(40);
    for n in [1, 2, 7, 40] {
        let path = folder.path().join(format!("bar{n}.pvtu"));
        let notes = write_pieces(&mesh, &path, n);
        assert_eq!(notes.expect("it can be written"), []);
        let loaded = load(&path);
        assert_eq!(loaded.format.name, "pvtu");
        assert_eq!(loaded.mesh, mesh, "{n} pieces");
        let files = std::fs::read_dir(path.with_extension("")).expect("the pieces");
        assert_eq!(files.count(), n);
    }
    let left = std::fs::read_dir(folder.path())
        .expect("the folder")
        .count();
    assert_eq!(left, 8, "nothing hidden is left");
    let path = folder.path().join("many.pvtu");
    let error = write_pieces(&mesh, &path, 41);
    assert!(
        error
            .expect_err("too many")
            .to_string()
            .contains("41 pieces")
    );
}

#[test]
fn pieces_that_fail_to_take_their_places_leave_the_old_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bar.pvtu");
    write_pieces(&bar(4), &path, 3).expect("it can be written");
    let pieces = folder.path().join("bar");
    let contents = || {
        let entries = std::fs::read_dir(&pieces).expect("the pieces");
        let entries = entries.map(|entry| entry.expect("a piece").path());
        let mut files: Vec<_> = entries
            .map(|path| (std::fs::read(&path).ok(), path))
            .collect();
        files.sort();
        files
    };
    let before = contents();
    assert_eq!(before.len(), 3);
    // The list, which comes last, cannot take the place of a folder.
    let (_, files) = stage_pieces(&bar(9), &path, 5).expect("it can be written");
    std::fs::remove_file(&path).expect("the list");
    std::fs::create_dir(&path).expect("a folder");
    assert!(files.keep().is_err());
    assert_eq!(contents(), before);
    let new = folder.path().join("new.pvtu");
    let (_, files) = stage_pieces(&bar(9), &new, 3).expect("it can be written");
    std::fs::create_dir(&new).expect("a folder");
    assert!(files.keep().is_err());
    assert!(!folder.path().join("new").exists());
}

/// A piece of two triangles on a line of nodes from `x`, with further data in its XML.
fn piece(folder: &Path, name: &str, x: u32, point_data: &str, cell_data: &str) {
    let points: String = (x..x + 2).map(|x| format!("{x} 0 0 {x} 1 0 ")).collect();
    let text = format!(
        r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="2"><PointData GlobalIds="ids">{point_data}</PointData>
<CellData>{cell_data}</CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 2 1 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">3 6</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 5</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>"#
    );
    std::fs::write(folder.join(name), text).expect("it can be written");
}

fn list(folder: &Path) -> std::path::PathBuf {
    let text = r#"<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="1">
<Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid></VTKFile>"#;
    let path = folder.join("all.pvtu");
    std::fs::write(&path, text).expect("it can be written");
    path
}

fn array(kind: &str, name: &str, values: &str) -> String {
    format!(r#"<DataArray type="{kind}" Name="{name}" format="ascii">{values}</DataArray>"#)
}

#[test]
fn nodes_at_one_place_become_one_and_it_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let p = array("Float32", "p", "1 2 3 4");
    piece(folder.path(), "a.vtu", 0, &p, "");
    piece(
        folder.path(),
        "b.vtu",
        1,
        &(p + &array("Int8", "only here", "1 2 3 4")),
        "",
    );
    let loaded = load(&list(folder.path()));
    assert_eq!(loaded.mesh.points.len(), 6);
    assert_eq!(
        loaded.mesh.cells.connectivity(),
        [0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5]
    );
    let expected = Values::F32(vec![1.0, 2.0, 3.0, 4.0, 3.0, 4.0]);
    assert_eq!(loaded.mesh.point_arrays[0].values, expected);
    assert_eq!(loaded.notes, ["pieces_joined", "array_not_alike"]);
    let joined = "2 pieces are joined at 2 nodes with the same place";
    assert!(loaded.notes.says(joined), "{:?}", loaded.notes);
}

#[test]
fn ghost_cells_are_left_out_with_their_nodes() {
    let folder = tempfile::tempdir().expect("a folder");
    piece(
        folder.path(),
        "a.vtu",
        0,
        "",
        &array("UInt8", "vtkGhostType", "0 0"),
    );
    piece(
        folder.path(),
        "b.vtu",
        0,
        "",
        &array("UInt8", "vtkGhostType", "1 1"),
    );
    let loaded = load(&list(folder.path()));
    assert_eq!((loaded.mesh.points.len(), loaded.mesh.cells.len()), (4, 2));
    assert!(loaded.mesh.cell_arrays.is_empty());
    assert!(loaded.notes.has("ghosts_left_out"));
}

#[test]
fn global_numbers_decide_where_they_agree_with_the_places() {
    let folder = tempfile::tempdir().expect("a folder");
    piece(
        folder.path(),
        "a.vtu",
        0,
        &array("Int64", "ids", "50 40 30 20"),
        "",
    );
    piece(
        folder.path(),
        "b.vtu",
        1,
        &array("Int64", "ids", "30 20 10 60"),
        "",
    );
    let mesh = load(&list(folder.path())).mesh;
    let xs: Vec<f64> = mesh.points.iter().map(|point| point[0]).collect();
    assert_eq!(xs, [2.0, 1.0, 1.0, 0.0, 0.0, 2.0]);
    assert_eq!(mesh.point_arrays[0].name, "ids");
    piece(
        folder.path(),
        "b.vtu",
        1,
        &array("Int64", "ids", "50 40 10 60"),
        "",
    );
    let loaded = load(&list(folder.path()));
    assert_eq!(loaded.mesh.points.len(), 6);
    assert!(loaded.notes.has("numbers_unused"));
}

#[test]
fn zeros_of_both_signs_and_rounded_coordinates_are_one_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let second = folder.path().join("b.vtu");
    for (ids, other_zero) in [(false, "-0.0"), (true, "-0.0"), (true, "1e-9")] {
        let ids = |values| {
            if ids {
                array("Int64", "ids", values)
            } else {
                String::new()
            }
        };
        piece(folder.path(), "a.vtu", 0, &ids("0 1 2 3"), "");
        piece(folder.path(), "b.vtu", 1, &ids("2 3 4 5"), "");
        let text = std::fs::read_to_string(&second).expect("it is there");
        let other = text.replace("1 0 0", &format!("1 {other_zero} 0"));
        std::fs::write(&second, other).expect("it can be written");
        let mesh = load(&list(folder.path())).mesh;
        assert_eq!(mesh.points.len(), 6, "{other_zero}");
    }
}

#[test]
fn a_missing_piece_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    piece(folder.path(), "a.vtu", 0, "", "");
    let source = Source::open(&list(folder.path())).expect("it is there");
    let result = formats::read(&source.into(), &ReadOptions::default());
    let message = result.err().expect("b.vtu is missing").to_string();
    assert_says(&message, "b.vtu");
}
