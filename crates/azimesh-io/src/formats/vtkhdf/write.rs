//! A file of one mesh.

use super::super::WriteOptions;
use super::super::hdf5::{Id, Tree};
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::order;
use super::ROOT;
use super::blocks::{Blocks, NAMES, shape};
use crate::formats::{Notes, Out};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::collections::BTreeMap;

/// Version of a file of one mesh, which the readers of all of VTK since 9.1 know.
const ONE_MESH: [i64; 2] = [1, 0];
/// The first version with polyhedra.
const POLYHEDRA: [i64; 2] = [2, 5];

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let flattened = options.check_coordinates(mesh)?;
    let plan = VtkArrays::new(mesh, options, &NAMES);
    let mut blocks = Blocks::new(mesh, &plan);
    blocks.notes.extend(flattened);
    let (has_polyhedra, has_wedges) = (mesh.cells.has_polyhedra(), order::has_wedges(mesh.cells));
    let mut grid = Grid::new(ONE_MESH, has_polyhedra, has_wedges);
    for (name, n) in blocks.counts {
        grid.tree.numbers(grid.root, name, &[n as i64]);
    }
    // Coordinates come before cells.
    blocks.arrays.splice(1..1, blocks.cells);
    for block in blocks.arrays {
        let (parent, column) = (grid.group(block.group), block.column);
        let shape = shape(column.n_tuples as u64, column.n_components as u64);
        let (name, element) = (column.name, column.element);
        grid.tree
            .dataset(parent, name, element, &shape, column.data);
    }
    grid.tree.write(out)?;
    Ok(blocks.notes)
}

/// The group of an unstructured grid in a file to be.
pub(super) struct Grid<'a> {
    pub tree: Tree<'a>,
    pub root: Id,
    groups: BTreeMap<&'static str, Id>,
}

impl Grid<'_> {
    /// A grid of a version of the format, or of a later one if that has polyhedra.
    pub fn new(version: [i64; 2], has_polyhedra: bool, has_wedges: bool) -> Self {
        let mut tree = Tree::new();
        let root = tree.group(Tree::ROOT, ROOT);
        let version = if has_polyhedra { POLYHEDRA } else { version };
        tree.number_attribute(root, "Version", &version, false);
        tree.text_attribute(root, "Type", "UnstructuredGrid");
        if has_wedges {
            tree.text_attribute(root, order::WEDGES, order::OUTWARD);
        }
        let groups = BTreeMap::from([("", root)]);
        Self { tree, root, groups }
    }

    /// The group of this name inside the group of the grid, created on first use; the grid's own for no name.
    pub fn group(&mut self, name: &'static str) -> Id {
        let create = || self.tree.group(self.root, name);
        *self.groups.entry(name).or_insert_with(create)
    }
}
