//! A file of one mesh.

use super::super::WriteOptions;
use super::super::column::Column;
use super::super::hdf5::{Id, Tree};
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::order;
use super::ROOT;
use super::blocks::{Blocks, NAMES};
use crate::formats::{Notes, Out};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::collections::BTreeMap;

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let flattened = options.check_coordinates(mesh)?;
    let plan = VtkArrays::new(mesh, options, &NAMES);
    let blocks = Blocks::new(mesh, &plan);
    let mut notes = blocks.notes;
    notes.extend(flattened);
    let version = match mesh.cells.has_polyhedra() {
        true => POLYHEDRA,
        false => ONE_MESH,
    };
    let mut grid = Grid::new(version, order::has_wedges(mesh.cells));
    for (name, n) in blocks.counts {
        grid.tree.numbers(grid.root, name, &[n as i64]);
    }
    for block in std::iter::once(blocks.points)
        .chain(blocks.cells)
        .chain(blocks.arrays)
    {
        let (shape, parent) = (block.shape(), grid.group(block.group));
        let Column {
            name,
            element,
            data,
            ..
        } = block.column;
        grid.tree
            .dataset(parent, name, element.into(), &shape, data);
    }
    grid.tree.write(out)?;
    Ok(notes)
}

/// Version of a file of one mesh, which the readers of all of VTK since 9.1 know.
const ONE_MESH: [i64; 2] = [1, 0];
/// The first version with sequences.
pub(super) const SEQUENCE: [i64; 2] = [2, 0];
/// The first version with polyhedra.
pub(super) const POLYHEDRA: [i64; 2] = [2, 5];

/// The group of an unstructured grid in a file to be.
pub(super) struct Grid<'a> {
    pub tree: Tree<'a>,
    pub root: Id,
    groups: BTreeMap<&'static str, Id>,
}

impl Grid<'_> {
    pub fn new(version: [i64; 2], has_wedges: bool) -> Self {
        let mut tree = Tree::new();
        let root = tree.group(Tree::ROOT, ROOT);
        tree.number_attribute(root, "Version", &version, false);
        tree.text_attribute(root, "Type", "UnstructuredGrid");
        if has_wedges {
            tree.text_attribute(root, order::WEDGES, order::OUTWARD);
        }
        Self {
            tree,
            root,
            groups: BTreeMap::new(),
        }
    }

    /// The group of this name in that of the grid, which is created on first use; the
    /// grid's own for no name.
    pub fn group(&mut self, name: &'static str) -> Id {
        if name.is_empty() {
            return self.root;
        }
        let (tree, root) = (&mut self.tree, self.root);
        *self
            .groups
            .entry(name)
            .or_insert_with(|| tree.group(root, name))
    }
}
