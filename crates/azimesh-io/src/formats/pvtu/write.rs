//! Writes a mesh as pieces, each in a file, and the list of them. Pieces are intervals of about equal length along a
//! space-filling curve.

use super::super::column::Column;
use super::super::rounding::is_flattened;
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::number::Element;
use super::super::vtu::{NAMES, VTU, escaped};
use super::super::{Notes, Out, OutputSet, WriteOptions, check_listed};
use super::subset::Subsets;
use super::{CELL_IDS, NODE_IDS};
use crate::mesh::{CellSet, DataArray, Group, MeshView, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::curve;
use azimesh_core::note;

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
    let of_cells = pieces(mesh, n).map_err(|error| error.file(&path))?;
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
    // For each piece the cells that groups have in it, by the number of the group.
    let mut of_groups: Vec<Vec<(usize, CellSet)>> = vec![Vec::new(); names.len()];
    for (i, group) in mesh.groups.iter().enumerate() {
        let mut sets = vec![CellSet::new(); names.len()];
        for cell in group.cells.iter() {
            sets[of_cells[cell] as usize].push(index_in_piece[cell] as usize);
        }
        for (piece, set) in of_groups.iter_mut().zip(sets) {
            piece.extend((!set.is_empty()).then_some((i, set)));
        }
    }
    let mut subsets = Subsets::of(mesh);
    let mut notes = Notes::default();
    let mut arrays = String::new();
    for ((piece, name), own) in names.iter().enumerate().zip(of_groups) {
        // Nodes of no cell go with the first piece.
        let alone: &[usize] = if piece == 0 { &alone } else { &[] };
        let (mut part, nodes) = subsets.take(&cells[piece], alone);
        // Every piece has all groups, so that each has the same number in all.
        let mut own = own.into_iter().peekable();
        let groups = mesh.groups.iter().enumerate();
        let groups = groups.map(|(i, group)| {
            let own = own.next_if(|(at, _)| *at == i).map(|(_, set)| set);
            Group {
                condition: group.condition.clone(),
                ..Group::new(
                    group.dimension,
                    &*group.name,
                    group.number,
                    own.unwrap_or_default(),
                )
            }
        });
        part.groups = groups.collect();
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

fn add_numbers(arrays: &mut Vec<DataArray>, name: &str, numbers: &[usize], notes: &mut Notes) {
    if arrays.iter().any(|array| array.name == name) {
        arrays.retain(|array| array.name != name);
        notes.push(note!(
            "replaced_by_numbers",
            "the array \"{name}\" is replaced by consecutive numbers"
        ));
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

/// The piece, from 0 to `n - 1`, of every cell. Cells of lower dimension go where the mesh's own
/// cells at their first node are.
fn pieces(mesh: &MeshView, n: usize) -> Result<Vec<u32>> {
    let volume: Vec<usize> = mesh.volume_runs().flat_map(|run| run.range()).collect();
    let n_volume = volume.len();
    if n == 0 || n > n_volume {
        return Err(Error::input(format!(
            "a mesh of {} cannot be cut into {n} pieces",
            counted(n_volume, "cell")
        )));
    }
    let center = |cell: &usize| {
        let nodes = mesh.cells.get(*cell).nodes;
        let mut sum = [0.0; 3];
        for &node in nodes {
            for (sum, x) in sum.iter_mut().zip(mesh.points[node as usize]) {
                *sum += x;
            }
        }
        sum.map(|x| x / nodes.len() as f64)
    };
    let centers: Vec<[f64; 3]> = volume.iter().map(center).collect();
    let mut of_cells = vec![0; mesh.cells.len()];
    for (place, along) in curve::order(&centers).into_iter().enumerate() {
        let piece = place as u128 * n as u128 / n_volume as u128;
        of_cells[volume[along as usize]] = piece as u32;
    }
    let mut of_nodes = vec![0; mesh.points.len()];
    for &cell in volume.iter().rev() {
        for &node in mesh.cells.get(cell).nodes {
            of_nodes[node as usize] = of_cells[cell];
        }
    }
    let dimension = mesh.dimension();
    let runs = mesh.cells.runs();
    for run in runs.filter(|run| run.kind.dimension() < dimension) {
        for (i, nodes) in run.cells().enumerate() {
            of_cells[run.first_cell + i] = of_nodes[nodes[0] as usize];
        }
    }
    Ok(of_cells)
}
