//! A binary file by slabs: its numbers lie in the order of the mesh, those of each kind of cells together.
//!
//! What is odd or damaged is left to the reader of the whole file.

use super::super::slabs::{Refusal, Slabs, overlapping, whole};
use super::super::{Notes, Source};
use super::binary::{self, Stored};
use super::layout::{Counts, KINDS, Layout, n_nodes};
use super::{Ugrid, case, faces, mapbc, read};
use crate::mesh::{CellKind, Cells, Mesh};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::sparse;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;

/// The numbers of a file.
struct Open<'a> {
    source: &'a Source,
    counts: Counts,
    stored: Stored<'a>,
    /// The cells of each of [`KINDS`], by its place there.
    kinds: Vec<(usize, Range<usize>)>,
}

/// Finds the numbers of a file.
pub(super) fn open<'a>(source: &'a Source, flavour: &Ugrid) -> Found<impl Slabs + use<'a>> {
    let Layout::Binary(binary) = flavour.layout else {
        return Err(whole("it is text"));
    };
    let mut notes = Notes::default();
    let (counts, body, start) = binary::body(source.bytes(), &binary, flavour, &mut notes)?;
    let [body] = body[..] else {
        return Err(whole("its Fortran records are in several parts"));
    };
    if !notes.is_empty() {
        return Err(whole("its Fortran records have wrong marks"));
    }
    let stored = Stored::new(&counts, body, start, binary);
    if stored.n_rest > 0 {
        return Err(whole("there are bytes after its cells"));
    }
    let mut kinds = Vec::new();
    let mut first = 0;
    for (kind, n) in counts.n_cells.into_iter().enumerate() {
        kinds.push((kind, first..first + n));
        first += n;
    }
    Ok(Open {
        source,
        counts,
        stored,
        kinds,
    })
}

impl Slabs for Open<'_> {
    fn n_nodes(&self) -> usize {
        self.counts.n_nodes
    }

    fn n_cells(&self) -> usize {
        self.counts.n_cells.iter().sum()
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        Ok(self.stored.points(nodes))
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let (mut connectivity, mut runs) = (Vec::new(), Vec::new());
        for (&(place, _), own) in overlapping(&self.kinds, |(_, all)| all.clone(), cells) {
            let kind = KINDS[place];
            let first = connectivity.len();
            connectivity.resize(first + n_nodes(kind) * own.len(), 0);
            let nodes = &mut connectivity[first..];
            runs.push((kind, n_nodes(kind), own.len()));
            self.stored.nodes(place, own, nodes)?;
            if kind == CellKind::Pyramid {
                read::turn(nodes);
            }
        }
        Ok(Cells::from_connectivity(connectivity, runs))
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let patches = mapbc::companion(&case(self.source.path()), notes)?;
        // Numbers of symmetry planes depend on the positions of their nodes.
        let mut boundary = Mesh {
            points: sparse::zeros(self.n_nodes(), [0.0; 3]),
            cells: self.cells(0..self.counts.n_faces())?,
            ..Mesh::default()
        };
        for node in boundary.cells.connectivity() {
            let node = *node as usize;
            boundary.points[node] = self.stored.points(node..node + 1)[0];
        }
        faces::add_groups(&mut boundary, &self.stored.face_numbers()?, &patches);
        mesh.groups.append(&mut boundary.groups);
        mesh.field_arrays.append(&mut boundary.field_arrays);
        Ok(())
    }
}
