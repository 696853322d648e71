//! Faces of polyhedra, in VTK's old and new layout.
//!
//! Old: `faces` holds `n_faces, (n_nodes, node...)...` for one polyhedron after another and
//! `faceoffsets` where each ends, -1 for other cells. Version 2.3: `face_connectivity` and
//! `face_offsets` list faces, `polyhedron_to_faces` and `polyhedron_offsets` those of each cell.

use super::cells::{Nodes, indices, named};
use super::number::{Element, Number, with_type};
use super::read::collect;
use super::xml::{Array, Layout};
use crate::error::{Error, Result};
use crate::mesh::{CellKind, cells::face_stream};

/// Face streams `n_faces, (n_nodes, node...)...` of all polyhedra.
#[derive(Debug, Default)]
pub(super) struct Streams {
    entries: Vec<u32>,
    ends: Vec<usize>,
}

impl Streams {
    /// Whether there is no polyhedron.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The stream of each polyhedron, in order.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, &end)| &self.entries[start..end])
    }

    /// Appends the polyhedra of one piece, whose cells have these types.
    pub fn read(
        &mut self,
        arrays: &[Array],
        layout: &Layout,
        nodes: Nodes,
        types: &[u8],
    ) -> Result<()> {
        if arrays
            .iter()
            .any(|array| array.name == "polyhedron_offsets")
        {
            self.read_shared(arrays, layout, nodes, types)
        } else {
            self.read_streams(arrays, layout, nodes, types)
        }
    }

    fn read_streams(
        &mut self,
        arrays: &[Array],
        layout: &Layout,
        nodes: Nodes,
        types: &[u8],
    ) -> Result<()> {
        let mut faces = Vec::new();
        indices(
            named(arrays, "faces")?,
            layout,
            0,
            u32::MAX.into(),
            None,
            &mut faces,
        )?;
        let ends = integers(named(arrays, "faceoffsets")?, layout, Some(types.len()))?;
        let mut start = 0;
        for cell in polyhedra(types) {
            let end = usize::try_from(ends[cell]).ok();
            let stream = end.and_then(|end| faces.get(start..end));
            let stream = stream.ok_or_else(|| {
                let (found, n) = (ends[cell], faces.len());
                let message = format!(
                    "faces of cell {cell} end at {found}; they start at {start} of {n} entries"
                );
                Error::input(message).dataset("faceoffsets")
            })?;
            start += stream.len();
            self.push(stream, nodes, cell)?;
        }
        Ok(())
    }

    /// Appends a stream with the node numbers of its piece.
    fn push(&mut self, stream: &[u32], nodes: Nodes, cell: usize) -> Result<()> {
        let wrong =
            |error: Error| Error::input(format!("cell {cell}: {}", error.message)).dataset("faces");
        self.entries.push(stream.first().copied().unwrap_or(0));
        for face in face_stream(stream) {
            let face = face.map_err(wrong)?;
            self.push_face(face, nodes).map_err(wrong)?;
        }
        self.ends.push(self.entries.len());
        Ok(())
    }

    fn push_face(&mut self, face: &[u32], nodes: Nodes) -> Result<()> {
        self.entries.push(face.len() as u32);
        for &node in face {
            if u64::from(node) >= nodes.limit {
                let n = nodes.limit;
                return Err(Error::input(format!("a face has node {node} of {n} nodes")));
            }
            self.entries.push(node + nodes.base);
        }
        Ok(())
    }

    fn read_shared(
        &mut self,
        arrays: &[Array],
        layout: &Layout,
        nodes: Nodes,
        types: &[u8],
    ) -> Result<()> {
        let mut face_nodes = Vec::new();
        let array = named(arrays, "face_connectivity")?;
        indices(array, layout, 0, nodes.limit, None, &mut face_nodes)?;
        let face_ends = integers(named(arrays, "face_offsets")?, layout, None)?;
        let face_ends = ends_within(&face_ends, face_nodes.len(), "face_offsets")?;
        let mut cell_faces = Vec::new();
        let array = named(arrays, "polyhedron_to_faces")?;
        let n_faces = face_ends.len();
        indices(array, layout, 0, n_faces as u64, None, &mut cell_faces)?;
        let ends = integers(
            named(arrays, "polyhedron_offsets")?,
            layout,
            Some(types.len()),
        )?;
        let ends = ends_within(&ends, cell_faces.len(), "polyhedron_offsets")?;
        // A face lies between two cells; the room for more is for repeated cells.
        let most = self.entries.len() + 8 * (face_nodes.len() + cell_faces.len() + types.len());
        for cell in polyhedra(types) {
            let faces = &cell_faces[start_of(&ends, cell)..ends[cell]];
            self.entries.push(faces.len() as u32);
            for &face in faces {
                let face = face as usize;
                self.push_face(
                    &face_nodes[start_of(&face_ends, face)..face_ends[face]],
                    nodes,
                )?;
                if self.entries.len() > most {
                    let message = "faces are shared by more than two polyhedra";
                    return Err(Error::input(message).dataset("polyhedron_to_faces"));
                }
            }
            self.ends.push(self.entries.len());
        }
        Ok(())
    }
}

fn polyhedra(types: &[u8]) -> impl Iterator<Item = usize> {
    let polyhedron = CellKind::Polyhedron.vtk();
    (0..types.len()).filter(move |cell| types[*cell] == polyhedron)
}

fn start_of(ends: &[usize], index: usize) -> usize {
    if index == 0 { 0 } else { ends[index - 1] }
}

/// Offsets that do not fall and do not pass `n`.
fn ends_within(offsets: &[i64], n: usize, name: &str) -> Result<Vec<usize>> {
    let mut before = 0;
    let check = |&offset: &i64| {
        let end = usize::try_from(offset)
            .ok()
            .filter(|end| (before..=n).contains(end));
        before = end.ok_or_else(|| {
            let message = format!("offset {offset} after {before}; the last may be {n}");
            Error::input(message).dataset(name)
        })?;
        Ok(before)
    };
    offsets.iter().map(check).collect()
}

fn integers(array: &Array, layout: &Layout, expected: Option<usize>) -> Result<Vec<i64>> {
    let mut out = Vec::new();
    with_type!(array.element, T => collect(array, layout, 1, expected, &mut out, |chunk, out| {
        chunk.convert::<T, i64>(out, |x| x.as_index() as i64);
        Ok(())
    })?);
    Ok(out)
}
