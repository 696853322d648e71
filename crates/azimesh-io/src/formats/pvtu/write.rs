//! Writes a mesh as pieces, each in a file, and the list of them.

use super::super::column::Column;
use super::super::rounding::is_flattened;
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::number::Element;
use super::super::vtu::{NAMES, VTU, escaped};
use super::super::{Notes, Out, OutputSet, WriteOptions, check_listed};
use super::subset::Subsets;
use super::{CELL_IDS, NODE_IDS, cut};
use crate::mesh::{CellSet, DataArray, Group, MeshView, Values};
use azimesh_core::diagnostic::formats::ArrayWritten;
use azimesh_core::error::{Error, Result};

/// Cuts the mesh into `n` pieces and writes them into a folder next to the list of them, which has its name
/// without the ending. Returns a note for each thing that is not in the files.
///
/// Pieces hold the numbers of their nodes and cells in the whole mesh, so that reading them gives
/// the same mesh.
pub(super) fn write(
    mesh: &MeshView,
    n: usize,
    out: &mut OutputSet,
    options: &WriteOptions,
) -> Result<Notes> {
    let path = out.path().to_path_buf();
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let stem = stem
        .filter(|stem| *stem != "-")
        .ok_or_else(|| Error::input("pieces need an output name that ends in .pvtu").file(&path))?;
    check_listed(stem).map_err(|error| error.file(&path))?;
    let of_cells = cut::pieces(mesh, n).map_err(|error| error.file(&path))?;
    let names: Vec<String> = (0..n).map(|i| format!("{stem}_{i}.vtu")).collect();
    let flattened = options.check_coordinates(mesh)?;
    let (mut notes, arrays) = write_all(mesh, &of_cells, &names, out, options)?;
    notes.extend(flattened);
    let list = list(stem, &names, &arrays);
    out.main(|out| {
        let written = out.write_all(list.as_bytes());
        written.map_err(|error| Error::io(&path, &error))
    })?;
    Ok(notes)
}

/// Writes the pieces; gives the notes and the declarations of arrays for the list.
fn write_all(
    mesh: &MeshView,
    of_cells: &[u32],
    names: &[String],
    out: &mut OutputSet,
    options: &WriteOptions,
) -> Result<(Notes, String)> {
    let folder = out.path().with_extension("");
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); names.len()];
    let mut index_in_piece = vec![0u32; of_cells.len()];
    for (cell, &piece) in of_cells.iter().enumerate() {
        index_in_piece[cell] = cells[piece as usize].len() as u32;
        cells[piece as usize].push(cell);
    }
    let used = mesh.cells.used_nodes(mesh.points.len());
    let alone: Vec<usize> = (0..used.len()).filter(|node| !used[*node]).collect();
    let mut group_cells = group_cells(mesh, of_cells, &index_in_piece, names.len());
    let mut subsets = Subsets::of(mesh);
    let mut notes = Notes::default();
    let mut arrays = String::new();
    for (piece, name) in names.iter().enumerate() {
        // Nodes of no cell go with the first piece.
        let alone: &[usize] = if piece == 0 { &alone } else { &[] };
        let (mut part, nodes) = subsets.take(&cells[piece], alone);
        part.groups = groups(mesh, std::mem::take(&mut group_cells[piece]));
        add_numbers(&mut part.point_arrays, NODE_IDS, &nodes, &mut notes);
        add_numbers(&mut part.cell_arrays, CELL_IDS, &cells[piece], &mut notes);
        let part = part.view();
        let write = |out: &mut dyn Out| VTU.write_file(&part, out, options);
        let of_piece = out.in_folder(&folder, name, write)?.into_iter();
        // Flat cells are counted in the whole mesh.
        notes.extend(of_piece.filter(|note| !is_flattened(note)));
        if piece == 0 {
            arrays = declared(&VtkArrays::new(&part, options, &NAMES));
        }
    }
    Ok((notes, arrays))
}

/// For each piece the cells that groups have in it, by the number of the group.
fn group_cells(
    mesh: &MeshView,
    of_cells: &[u32],
    index_in_piece: &[u32],
    n_pieces: usize,
) -> Vec<Vec<(usize, CellSet)>> {
    let mut of_pieces = vec![Vec::new(); n_pieces];
    for (i, group) in mesh.groups.iter().enumerate() {
        let mut sets = vec![CellSet::new(); n_pieces];
        for cell in group.cells.iter() {
            sets[of_cells[cell] as usize].push(index_in_piece[cell] as usize);
        }
        for (piece, set) in of_pieces.iter_mut().zip(sets) {
            if !set.is_empty() {
                piece.push((i, set));
            }
        }
    }
    of_pieces
}

/// All groups of the mesh, with those of their cells that are in a piece, so that each group has
/// the same number in every piece.
fn groups(mesh: &MeshView, cells: Vec<(usize, CellSet)>) -> Vec<Group> {
    let empty = |group: &Group| Group {
        dimension: group.dimension,
        name: group.name.clone(),
        number: group.number,
        condition: group.condition.clone(),
        cells: CellSet::new(),
    };
    let mut groups: Vec<Group> = mesh.groups.iter().map(empty).collect();
    for (i, set) in cells {
        groups[i].cells = set;
    }
    groups
}

fn add_numbers(arrays: &mut Vec<DataArray>, name: &str, numbers: &[usize], notes: &mut Notes) {
    if arrays.iter().any(|array| array.name == name) {
        arrays.retain(|array| array.name != name);
        notes.push(ArrayWritten::ReplacedByNumbers { name: name.into() });
    }
    let numbers = numbers.iter().map(|n| *n as i64).collect();
    arrays.push(DataArray::scalar(name, Values::I64(numbers)));
}

/// The arrays of a piece as the list declares them.
fn declared(plan: &VtkArrays) -> String {
    let sections = plan.sections();
    let mut xml = String::new();
    for (name, ids, arrays) in [
        ("PPointData", NODE_IDS, &sections.point_data),
        ("PCellData", CELL_IDS, &sections.cell_data),
    ] {
        xml += &format!("    <{name} GlobalIds=\"{ids}\">\n");
        arrays.iter().for_each(|array| xml += &declaration(array));
        xml += &format!("    </{name}>\n");
    }
    let points = sections.points.iter().map(declaration);
    xml + "    <PPoints>\n" + &points.collect::<String>() + "    </PPoints>\n"
}

fn declaration(array: &Column) -> String {
    let element = match array.element {
        Element::String => "PArray",
        _ => "PDataArray",
    };
    format!(
        "      <{element} type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n",
        array.element.name(),
        escaped(array.name),
        array.n_components
    )
}

fn list(stem: &str, names: &[String], arrays: &str) -> String {
    let source = |name: &String| {
        let source = escaped(&format!("{stem}/{name}"));
        format!("    <Piece Source=\"{source}\"/>\n")
    };
    let pieces: String = names.iter().map(source).collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  \
         <PUnstructuredGrid GhostLevel=\"0\">\n{arrays}{pieces}  </PUnstructuredGrid>\n</VTKFile>\n"
    )
}
