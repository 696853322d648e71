//! Node sets: in files without side sets, tags of the outer faces whose corners are all in a set.

use super::super::Notes;
use super::super::netcdf::File;
use super::blocks::{Named, check_number, indices, named};
use super::sides::Faces;
use crate::mesh::exterior_faces;
use crate::mesh::{CellKind, Cells, Group};
use azimesh_core::error::Result;

/// Appends the faces of all node sets, and gives their groups. Where there are tags already, node sets only repeat
/// them in another way, and their names are noted.
pub(super) fn read(
    file: &File,
    n_nodes: usize,
    has_tags: bool,
    cells: &mut Cells,
    faces: &mut Faces,
    notes: &mut Notes,
) -> Result<Vec<Group>> {
    let n = file.length("num_node_sets")?.unwrap_or(0);
    check_number(n, "num_node_sets", file)?;
    let mut left = Vec::new();
    let mut sets = Vec::new();
    for (place, named) in (1..).zip(named(file, n, ["ns_prop1", "ns_names"], notes)?) {
        let Some(nodes) = file.variable(&format!("node_ns{place}"))? else {
            continue;
        };
        if has_tags {
            left.push(named.name)
        } else {
            sets.push((named, indices(&nodes, n_nodes, "node")?))
        }
    }
    let groups = tags(sets, n_nodes, cells, faces, &mut left)?;
    notes.names_not_kept("node sets", left);
    Ok(groups)
}

/// Tags of the sets that have faces; the names of the others are `left`.
fn tags(
    sets: Vec<(Named, Vec<u32>)>,
    n_nodes: usize,
    cells: &mut Cells,
    faces: &mut Faces,
    left: &mut Vec<String>,
) -> Result<Vec<Group>> {
    if sets.is_empty() {
        return Ok(Vec::new());
    }
    let dimension = cells.dimension();
    let mut is_in = vec![false; n_nodes];
    for node in sets.iter().flat_map(|(_, nodes)| nodes) {
        is_in[*node as usize] = true;
    }
    let n_elements = cells.len();
    let outer = exterior_faces(cells, 0..n_elements, dimension, |node| is_in[node as usize]);
    let mut groups = Vec::new();
    for (named, nodes) in sets {
        is_in.fill(false);
        nodes.iter().for_each(|node| is_in[*node as usize] = true);
        let all_in = |(kind, nodes): &&(CellKind, Vec<u32>)| {
            let corners = &nodes[..kind.n_corners(nodes.len())];
            corners.iter().all(|corner| is_in[*corner as usize])
        };
        let first = cells.len();
        for (kind, nodes) in outer.iter().filter(all_in) {
            let space = cells.check_space(1);
            space.map_err(|error| error.dataset("node sets"))?;
            cells.push(*kind, nodes);
        }
        match cells.len() - first {
            0 => left.push(named.name),
            n => {
                faces.of_cells.extend(std::iter::repeat_n(u32::MAX, n));
                let cells = (first..first + n).collect();
                groups.push(named.group(dimension.saturating_sub(1), cells));
            }
        }
    }
    Ok(groups)
}
