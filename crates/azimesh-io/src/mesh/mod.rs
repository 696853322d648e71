//! One mesh in memory for every format: nodes, cells in file order, named groups, arrays.
//!
//! Owns what a mesh is and how two of them differ. Knows nothing of files or of motion. Node order
//! within a cell is VTK's; node and cell indices are zero-based.

pub mod adjacency;
mod apart;
mod append;
pub mod arrays;
mod boundary;
mod bounded;
mod build;
pub mod cells;
mod coincident;
mod collapsed;
mod collective;
mod connected;
mod copies;
pub mod corners;
#[doc(hidden)]
pub mod cubes;
pub mod difference;
mod doubled;
mod extrude;
pub mod faces;
pub mod facets;
mod flatten;
pub mod from_slabs;
pub mod groups;
mod interface;
pub mod join;
mod kind;
pub mod lagrange;
mod layout;
mod linearize;
mod mirrored;
mod near;
mod node_bits;
mod nodes;
mod numbering;
mod one_layer;
mod orientations;
mod origin;
mod outward;
mod part;
mod reorder;
pub mod repeated;
pub mod sides;
mod skin;
mod split;
mod streams;
mod subset;
mod transform;
mod view;
mod walls;
mod zone_sides;

pub use adjacency::{Across, Adjacency};
pub(crate) use apart::reverse_each;
pub use apart::{
    Apart, Coordinates, Listing, NodesOfCells, Numbers, NumbersApart, check_in_32_bits, in_32_bits,
};
pub use append::Merged;
pub use arrays::{DataArray, Values};
pub use boundary::Boundary;
pub use bounded::{BoundedCells, faces_on_no_cell, inner_faces};
pub(crate) use cells::mirror_wedges;
pub use cells::{CellRef, CellRun, Cells};
pub use coincident::Coincident;
pub use collapsed::Uncollapsed;
pub(crate) use connected::UnionFind;
pub use copies::Plane;
pub use difference::{DiffOptions, Difference, Tolerance, diff};
pub use doubled::Doubled;
pub use faces::Faces;
pub(crate) use faces::exterior_faces;
pub use groups::{CellSet, Group};
pub use interface::Neighbour;
pub use kind::CellKind;
pub use linearize::linear;
pub use node_bits::NodeBits;
pub(crate) use nodes::for_each_shared_place;
pub use numbering::Numbering;
pub(crate) use numbering::among;
pub use one_layer::{EMPTY, OneLayer};
pub use orientations::orientations;
pub use origin::Origin;
pub(crate) use outward::{check_listed, turn_outward, turned};
pub use part::RankPart;
pub use reorder::Reordering;
pub use skin::Skin;
pub use split::SplitCounts;
pub use transform::Turned;
pub use view::{ByRanks, MeshView};
pub use walls::n_walls;
pub use zone_sides::ZoneSides;

use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::Bounds;
use azimesh_core::numbers::point;
use azimesh_core::parallel::map_blocks;
use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// An unstructured mesh.
///
/// Boundary faces are cells like any other, one dimension below the mesh's own; a boundary tag is a
/// [`Group`] of them. A face in two tags is one cell in two groups.
///
/// ```
/// use azimesh_io::{CellKind, Cells, Mesh};
///
/// # fn main() -> azimesh_io::Result<()> {
/// let mut cells = Cells::default();
/// cells.push(CellKind::Triangle, &[0, 1, 2]);
/// cells.push(CellKind::Line, &[0, 1]);
/// let mut mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], cells)?;
/// mesh.add_tag("wall", [1])?;
/// assert_eq!(mesh.tag_nodes("wall")?, [0, 1]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Node coordinates, in the mesh's own unit. In 2D the third is zero unless the file says
    /// otherwise.
    #[serde(with = "raw")]
    pub points: Vec<[f64; 3]>,
    /// Cells of every dimension, in file order.
    pub cells: Cells,
    /// Boundary tags, zones and groups of lower dimension, in file order.
    pub groups: Vec<Group>,
    /// Arrays with one tuple a node.
    pub point_arrays: Vec<DataArray>,
    /// Arrays with one tuple a cell.
    pub cell_arrays: Vec<DataArray>,
    /// Arrays of the mesh as a whole.
    pub field_arrays: Vec<DataArray>,
    /// Dimension of the space, if the file states that it is larger than the dimension of the cells: a
    /// surface in 3D. Its cells and groups are the boundary faces and tags of a mesh without volume cells.
    pub space: Option<u8>,
    /// Data from its reader for a writer of the same format.
    #[serde(skip)]
    pub origin: Origin,
    /// Data about the whole mesh, if it is a part of one.
    #[doc(hidden)]
    #[serde(skip)]
    pub part: Option<Arc<RankPart>>,
}

impl Mesh {
    /// Dimension of its volume cells, present or not: what [`space`](Self::space) says, else the largest
    /// of its cells. 2 for a plane mesh or a shell, 3 for a solid one, 0 for a cloud of points.
    pub fn dimension(&self) -> u8 {
        volume_dimension(&self.cells, self.space)
    }

    /// Dimension of its space: 3 if it has solid cells or is not in a plane of constant z, else 2.
    pub fn space_dimension(&self) -> u8 {
        match self.dimension() {
            3 => 3,
            _ if is_flat(&Bounds::around(&self.points)) => 2,
            _ => 3,
        }
    }

    /// The boundary tags, in file order; of a cloud of points its groups.
    pub fn boundary_tags(&self) -> impl Iterator<Item = &Group> + Clone {
        groups::boundary_tags(&self.groups, self.dimension())
    }

    /// The zones, in file order.
    pub fn zones(&self) -> impl Iterator<Item = &Group> + Clone {
        groups::zones(&self.groups, self.dimension())
    }

    /// Runs of the cells with the mesh's own dimension.
    pub fn volume_runs(&self) -> impl Iterator<Item = CellRun<'_>> + Clone {
        let dimension = self.dimension();
        self.cells
            .runs()
            .filter(move |run| run.kind.dimension() == dimension)
    }

    /// Runs of the cells with the mesh's own dimension, cut to the cells of `range`.
    pub fn volume_runs_in(
        &self,
        range: std::ops::Range<usize>,
    ) -> impl Iterator<Item = CellRun<'_>> {
        let dimension = self.dimension();
        let runs = self.cells.runs_in(range);
        runs.filter(move |run| run.kind.dimension() == dimension)
    }

    /// Smallest and largest coordinates; `None` without nodes.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        bounds(&self.points)
    }

    /// Removes the field arrays of these names; gives the names of those that were there.
    pub fn remove_field_arrays(&mut self, names: &[&str]) -> Vec<String> {
        let is_named = |array: &mut DataArray| names.contains(&array.name.as_str());
        let removed = self.field_arrays.extract_if(.., is_named);
        removed.map(|array| array.name).collect()
    }

    /// Bytes held in memory by nodes, cells, groups and arrays.
    pub fn memory_bytes(&self) -> usize {
        let arrays = self
            .point_arrays
            .iter()
            .chain(&self.cell_arrays)
            .chain(&self.field_arrays);
        size_of_val(&self.points[..])
            + self.cells.memory_bytes()
            + self
                .groups
                .iter()
                .map(|g| g.cells.ranges().len() * 8)
                .sum::<usize>()
            + arrays.map(|a| a.values.memory_bytes()).sum::<usize>()
    }

    /// Checks what every later stage relies on: node indices in range, finite coordinates, arrays
    /// of the right length, groups that hold cells of their own dimension.
    pub fn validate(&self) -> Result<()> {
        let n_points = self.points.len();
        let strange = |p: &[f64; 3]| !p.iter().all(|x| x.is_finite());
        if let Some(i) = first_where(&self.points, strange) {
            return Err(Error::input(format!(
                "node {i} is at {}; coordinates must be finite",
                point(&self.points[i])
            )));
        }
        for run in self.cells.runs() {
            let outside = |&n: &u32| n as usize >= n_points;
            if let Some(at) = first_where(run.connectivity, outside) {
                return Err(Error::input(format!(
                    "{} {} has node {}, but the mesh has {n_points} nodes (0 to {})",
                    run.kind.name(),
                    run.first_cell + at / run.n_nodes,
                    run.connectivity[at],
                    n_points.saturating_sub(1),
                )));
            }
        }
        self.validate_arrays()?;
        self.validate_groups()
    }

    pub(crate) fn validate_arrays(&self) -> Result<()> {
        let all = [&self.point_arrays, &self.cell_arrays, &self.field_arrays];
        for array in all.into_iter().flatten() {
            if array.n_components > array.values.len().max(MOST_COMPONENTS) {
                return Err(Error::input(format!(
                    "array \"{}\" has tuples of {} components but {} values",
                    array.name,
                    array.n_components,
                    array.values.len()
                )));
            }
        }
        let expected = [
            (&self.point_arrays, self.points.len(), "nodes"),
            (&self.cell_arrays, self.cells.len(), "cells"),
        ];
        for (arrays, n, of) in expected {
            for array in arrays {
                if array.n_components == 0 || array.values.len() != n * array.n_components {
                    return Err(Error::input(format!(
                        "array \"{}\" has {} values, not {} for each of {n} {of}",
                        array.name,
                        array.values.len(),
                        array.n_components
                    )));
                }
            }
        }
        Ok(())
    }

    pub(crate) fn validate_groups(&self) -> Result<()> {
        for group in &self.groups {
            for range in group.cells.ranges() {
                if range.end > self.cells.len() {
                    return Err(Error::input(format!(
                        "group \"{}\" holds cell {}, but the mesh has {} cells",
                        group.name,
                        range.end - 1,
                        self.cells.len()
                    )));
                }
            }
            let runs = group.cells.ranges().flat_map(|r| self.cells.runs_in(r));
            for run in runs {
                if run.kind.dimension() != group.dimension {
                    return Err(Error::input(format!(
                        "group \"{}\" of dimension {} holds cell {}, a {}",
                        group.name,
                        group.dimension,
                        run.first_cell,
                        run.kind.name()
                    )));
                }
            }
        }
        Ok(())
    }
}

fn bounds(points: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
    let bounds = Bounds::around(points);
    (!points.is_empty()).then_some([bounds.low, bounds.high])
}

/// Message for more nodes or cells than 32-bit indices can address.
pub(crate) fn too_many(what: &str) -> String {
    let most = u32::MAX - 1;
    format!("there are more than {most} {what}, the most that a mesh can have")
}

/// Extent in z, relative to the diagonal, above which a mesh is not plane.
const FLAT: f64 = 1e-6;

/// Returns true if nodes with these bounds are in a plane of constant z.
fn is_flat(extent: &Bounds) -> bool {
    let size = |k: usize| extent.high[k] - extent.low[k];
    let diagonal = (0..3).map(|k| size(k).powi(2)).sum::<f64>().sqrt();
    size(2) <= FLAT * diagonal
}

/// The dimension given by a file, or the largest of the cells.
fn volume_dimension(cells: &Cells, space: Option<u8>) -> u8 {
    space.unwrap_or(0).max(cells.dimension())
}

/// Components that an array may have without values to show for them.
const MOST_COMPONENTS: usize = 4096;

/// Position of the first value for which `wanted` holds. Long slices are searched on all threads.
pub(crate) fn first_where<T: Sync>(
    values: &[T],
    wanted: impl Fn(&T) -> bool + Sync,
) -> Option<usize> {
    const CHUNK: usize = 1 << 16;
    if values.len() <= CHUNK {
        return values.iter().position(wanted);
    }
    let found = map_blocks(values.len(), CHUNK, &|range| {
        let at = values[range.clone()].iter().position(&wanted)?;
        Some(range.start + at)
    });
    found.into_iter().flatten().next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_needs_values_for_very_many_components() {
        for (n, n_values, is_good) in [(4096, 0, true), (4097, 0, false), (4097, 4097, true)] {
            let wide = DataArray::tuples("wide", n, Values::F64(vec![0.0; n_values]));
            let mesh = Mesh {
                field_arrays: vec![wide],
                ..Mesh::default()
            };
            assert_eq!(mesh.validate().is_ok(), is_good);
        }
    }
}
