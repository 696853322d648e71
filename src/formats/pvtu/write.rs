//! A mesh as pieces in files of their own, and the list of them.

use super::super::vtk::content::Content;
use super::super::vtk::number::Element;
use super::super::vtk::plan::Plan;
use super::super::vtu::{Vtu, escaped};
use super::super::{WriteOptions, save, save_text};
use super::subset::{nodes_of, subset};
use super::{CELL_IDS, NODE_IDS, cut};
use crate::error::{Error, Result};
use crate::mesh::{CellSet, DataArray, Group, Mesh, Values};
use std::fs;
use std::path::{Path, PathBuf};

/// Cuts the mesh into `n` pieces and writes them into a folder beside `path` that has its name
/// without the ending, and the list of them to `path`. Returns a sentence for each thing that is
/// not in the files.
///
/// Pieces hold the numbers of their nodes and cells in the whole mesh, so that reading them gives
/// the same mesh. They are written in a hidden folder first: an error leaves what was there before.
pub fn write_pieces(
    mesh: &Mesh,
    path: &Path,
    n: usize,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let stem = stem
        .filter(|stem| *stem != "-")
        .ok_or_else(|| Error::input("pieces need a file name that ends in .pvtu").file(path))?;
    let of_cells = cut::pieces(mesh, n).map_err(|error| error.file(path))?;
    let folder = path.with_file_name(stem);
    let hidden = path.with_file_name(format!(".{stem}.{}", std::process::id()));
    let io = |at: &Path, result: std::io::Result<()>| result.map_err(|error| Error::io(at, &error));
    io(&hidden, fs::create_dir(&hidden))?;
    let names: Vec<String> = (0..n).map(|i| format!("{stem}_{i}.vtu")).collect();
    let files: Vec<PathBuf> = names.iter().map(|name| hidden.join(name)).collect();
    let written = write_all(mesh, &of_cells, &files, options).and_then(|(notes, arrays)| {
        io(&folder, fs::create_dir_all(&folder))?;
        for (file, name) in files.iter().zip(&names) {
            let target = folder.join(name);
            io(&target, fs::rename(file, &target))?;
        }
        save_text(&list(stem, &names, &arrays), path)?;
        Ok(notes)
    });
    // What is left there is of no use, whatever happened.
    let _ = fs::remove_dir_all(&hidden);
    written
}

/// Writes the pieces; gives the notes and what a list says of their arrays.
fn write_all(
    mesh: &Mesh,
    of_cells: &[u32],
    files: &[PathBuf],
    options: &WriteOptions,
) -> Result<(Vec<String>, String)> {
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); files.len()];
    let mut index_in_piece = vec![0u32; of_cells.len()];
    for (cell, &piece) in of_cells.iter().enumerate() {
        index_in_piece[cell] = cells[piece as usize].len() as u32;
        cells[piece as usize].push(cell);
    }
    let mut used = vec![false; mesh.points.len()];
    for &node in mesh.cells.connectivity() {
        used[node as usize] = true;
    }
    let mut notes: Vec<String> = Vec::new();
    let mut arrays = String::new();
    for (piece, file) in files.iter().enumerate() {
        // Nodes of no cell go with the first piece.
        let alone = |node: usize| piece == 0 && !used[node];
        let nodes = nodes_of(mesh, &cells[piece], alone);
        let mut part = subset(mesh, &cells[piece], &nodes);
        part.groups = groups(mesh, of_cells, &index_in_piece, piece);
        add_numbers(&mut part.point_arrays, NODE_IDS, &nodes, &mut notes);
        add_numbers(&mut part.cell_arrays, CELL_IDS, &cells[piece], &mut notes);
        for note in save(&part, file, &Vtu, options)? {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
        if piece == 0 {
            arrays = declared(&Plan::new(&part, options));
        }
    }
    Ok((notes, arrays))
}

/// All groups of the mesh, with those of their cells that are in the piece, so that each group has
/// the same number in every piece.
fn groups(mesh: &Mesh, of_cells: &[u32], index_in_piece: &[u32], piece: usize) -> Vec<Group> {
    let in_piece = |cell: &usize| of_cells[*cell] as usize == piece;
    let of_group = |group: &Group| {
        let mut cells = CellSet::new();
        for cell in group.cells.iter().filter(in_piece) {
            cells.push(index_in_piece[cell] as usize);
        }
        Group {
            cells,
            ..group.clone()
        }
    };
    mesh.groups.iter().map(of_group).collect()
}

fn add_numbers(
    arrays: &mut Vec<DataArray>,
    name: &str,
    numbers: &[usize],
    notes: &mut Vec<String>,
) {
    if arrays.iter().any(|array| array.name == name) {
        arrays.retain(|array| array.name != name);
        let note = format!("the array \"{name}\" is replaced by numbers that count through");
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    let numbers = numbers.iter().map(|n| *n as i64).collect();
    arrays.push(DataArray::scalar(name, Values::I64(numbers)));
}

/// The arrays of a piece as the list declares them.
fn declared(plan: &Plan) -> String {
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

fn declaration(array: &Content) -> String {
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
