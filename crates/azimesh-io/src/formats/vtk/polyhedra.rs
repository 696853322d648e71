//! Faces of polyhedra, in VTK's old and new layout.
//!
//! Old: a stream `n_faces, (n_nodes, node...)...` for each polyhedron and where each ends. New: a
//! list of faces, and the faces of each cell.

use crate::formats::number::Chunk;
use crate::mesh::{CellKind, cells::face_stream};
use azimesh_core::error::{Error, Result};

/// Conversion of node indices of a piece to indices of the mesh.
#[derive(Debug, Clone, Copy)]
pub struct PieceNodes {
    /// Nodes of the pieces before.
    pub base: u32,
    /// Nodes of this piece.
    pub limit: u64,
}

impl PieceNodes {
    /// Converts entries of a list of nodes from `first` on.
    pub fn indices(self, chunk: Chunk, first: usize, out: &mut [u32]) -> Result<()> {
        let converted = chunk.indices(out, (0, self.limit), self.base);
        converted.map_err(|(at, value)| {
            let (entry, highest) = (first + at, self.limit as i64 - 1);
            let wanted = format!("it must be from 0 to {highest}");
            Error::input(format!("entry {entry} is {value}; {wanted}"))
        })
    }
}

/// Face streams `n_faces, (n_nodes, node...)...` of all polyhedra.
#[derive(Debug, Default)]
pub struct Streams {
    entries: Vec<u32>,
    ends: Vec<usize>,
}

/// Faces and the polyhedra that they belong to.
pub struct SharedFaces<'a> {
    /// Nodes of one face after another.
    pub face_nodes: &'a [u32],
    /// End of the nodes of each face.
    pub face_ends: &'a [i64],
    /// Faces of one polyhedron after another.
    pub cell_faces: &'a [u32],
    /// End of the faces of each cell; a cell of another kind has none.
    pub cell_ends: &'a [i64],
}

impl Streams {
    /// Returns whether there is no polyhedron.
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

    /// Appends polyhedra whose streams are in `faces`; `ends` has the end of each cell's stream.
    pub fn read_streams(
        &mut self,
        faces: &[u32],
        ends: &[i64],
        nodes: PieceNodes,
        types: &[u8],
    ) -> Result<()> {
        let mut start = 0;
        for (cell, &vtk) in types.iter().enumerate() {
            let end = usize::try_from(ends[cell]).ok();
            if vtk != CellKind::Polyhedron.vtk() {
                // Some writers give cells of other kinds a stream too, of no faces.
                start = end.unwrap_or(start);
                continue;
            }
            let stream = end.and_then(|end| faces.get(start..end));
            let stream = stream.ok_or_else(|| {
                let (found, n) = (ends[cell], faces.len());
                let message = format!(
                    "the faces of cell {cell} start at {start} and end at {found} of {n} entries"
                );
                Error::input(message).dataset("faceoffsets")
            })?;
            start += stream.len();
            self.push(stream, nodes, cell)?;
        }
        Ok(())
    }

    /// Appends one stream, with the node numbers of its piece.
    pub fn push(&mut self, stream: &[u32], nodes: PieceNodes, cell: usize) -> Result<()> {
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

    fn push_face(&mut self, face: &[u32], nodes: PieceNodes) -> Result<()> {
        self.entries.push(face.len() as u32);
        for &node in face {
            if u64::from(node) >= nodes.limit {
                let n = nodes.limit;
                return Err(Error::input(format!(
                    "a face has node {node}; there are {n} nodes, counted from 0"
                )));
            }
            self.entries.push(node + nodes.base);
        }
        Ok(())
    }

    /// Appends the polyhedra among cells of these types.
    pub fn read_shared(
        &mut self,
        faces: &SharedFaces,
        nodes: PieceNodes,
        types: &[u8],
    ) -> Result<()> {
        let (face_nodes, cell_faces) = (faces.face_nodes, faces.cell_faces);
        let face_ends = ends_within(faces.face_ends, face_nodes.len(), "face_offsets")?;
        let ends = ends_within(faces.cell_ends, cell_faces.len(), "polyhedron_offsets")?;
        // A face is between two cells; more are allowed for repeated cells.
        let most = self.entries.len() + 8 * (face_nodes.len() + cell_faces.len() + types.len());
        for cell in polyhedra(types) {
            let faces = &cell_faces[start_of(&ends, cell)..ends[cell]];
            self.entries.push(faces.len() as u32);
            for &face in faces {
                let face = face as usize;
                let start = start_of(&face_ends, face);
                self.push_face(&face_nodes[start..face_ends[face]], nodes)?;
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
        let end = usize::try_from(offset).ok();
        before = end
            .filter(|end| (before..=n).contains(end))
            .ok_or_else(|| {
                let message =
                    format!("offset {offset} follows {before}; offsets must ascend to at most {n}");
                Error::input(message).dataset(name)
            })?;
        Ok(before)
    };
    offsets.iter().map(check).collect()
}
