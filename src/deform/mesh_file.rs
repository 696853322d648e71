//! The file of a mesh that no process holds as a whole: what is known of it is read piece by piece when it is asked for.

use super::first_cells::{self, Edge};
use super::numbers_file::{NumbersFile, failed};
use super::sharing::{Holder, Sharing};
use crate::error::{Error, Result};
use crate::formats::{Loaded, SharedFile, hash_of, list_nodes, reason};
use crate::geometry::vector::Vector;
use crate::mesh::{Apart, CellSet, Doubled, Mesh, NodeBits, Numbers, OneLayer, ZoneSides};
use crate::parallel;
use crate::ranks::hash::HashedBytes;
use std::path::Path;
use std::sync::Arc;

/// Nodes that are stored in one piece at the most: each piece is read again for each slab of nodes.
const MOST_AT_ONCE: usize = 1 << 22;

/// The file of a mesh of which this process holds the outline.
#[derive(Debug)]
pub struct MeshFile(SharedFile);

impl MeshFile {
    pub fn new(file: SharedFile) -> Self {
        Self(file)
    }

    pub(super) fn file(&self) -> &SharedFile {
        &self.0
    }

    /// The file of the same mesh with copies of some nodes.
    pub(super) fn doubled(&self, doubled: Doubled) -> Arc<Self> {
        Arc::new(Self(self.0.doubled(doubled)))
    }

    /// The outline of the mesh, and the notes of its reader.
    ///
    /// # Errors
    /// Why it has to be read as a whole.
    pub(super) fn outline(self: &Arc<Self>) -> std::result::Result<Loaded, String> {
        let at_once = self.0.nodes_at_once().map_err(reason)?;
        if at_once > MOST_AT_ONCE {
            return Err(format!(
                "coordinates of {at_once} nodes are stored in one piece (`azimesh convert` writes a mesh without such pieces)"
            ));
        }
        let by: Arc<dyn Apart> = self.clone();
        let outline = self
            .0
            .by_pieces(|slabs, faces_once| Mesh::outline_by_pieces(slabs, faces_once, by));
        let outline = outline.map_err(reason)?;
        self.0.complete(outline)
    }
}

/// A mesh of which this process holds the outline, or the whole where that is not enough; with the notes of its reader.
pub struct Outlined {
    /// Of which this is the outline.
    pub(super) file: Option<Arc<MeshFile>>,
    /// The mesh, or its outline where that is enough.
    pub loaded: Loaded,
}

impl From<Loaded> for Outlined {
    fn from(whole: Loaded) -> Self {
        Self {
            file: None,
            loaded: whole,
        }
    }
}

impl Outlined {
    /// Reads the outline.
    ///
    /// # Errors
    /// Why the mesh has to be read as a whole, in words that complete "it is read whole: ...".
    pub fn outline(file: SharedFile) -> std::result::Result<Self, String> {
        let file = Arc::new(MeshFile::new(file));
        let outline = file.outline()?;
        match OneLayer::axis_of(&outline.mesh) {
            Ok(None) => Ok(Self {
                file: Some(file),
                loaded: outline,
            }),
            _ => Err("it is one layer of cells".to_owned()),
        }
    }

    /// Looking at it.
    pub fn alone(&self) -> Sharing {
        self.file.clone().map_or(Sharing::Alone, Sharing::File)
    }
}

impl Holder for MeshFile {
    fn whole(&self) -> Result<Mesh> {
        self.0.read_whole()
    }

    fn hash_of_file(&self) -> Result<blake3::Hash> {
        let path = self.0.path();
        hash_of(path).map_err(|error| Error::io(path, &error))
    }

    fn edges_off_walls(&self, nodes: &[u32]) -> Result<(Vec<Edge>, Vec<Vector>)> {
        self.0.by_pieces(|slabs, _| {
            let walls = NodeBits::new(&(0..slabs.n_nodes));
            walls.add(nodes);
            let mut edges: Vec<[u32; 2]> = Vec::new();
            slabs.each_cells(0..slabs.n_cells, &mut |_, cells| {
                edges.extend(first_cells::off_walls(cells, &walls));
                Ok(())
            })?;
            parallel::sort(&mut edges);
            edges.dedup();
            let mut off: Vec<u32> = edges.iter().map(|edge| edge[1]).collect();
            parallel::sort(&mut off);
            off.dedup();
            let (on, ends) = (slabs.places(nodes)?, slabs.places(&off)?);
            Ok(first_cells::shortest_at(
                &edges,
                (nodes, &on),
                (&off, &ends),
            ))
        })
    }

    fn faces_on_no_cell(&self, outline: &Mesh, faces: &[u32]) -> Result<Vec<u32>> {
        let alone = outline
            .cells
            .select(faces.iter().map(|&face| face as usize));
        let loose = self
            .0
            .by_pieces(|slabs, _| slabs.faces_on_no_cell(&alone, &|_| true));
        Ok(loose?.into_iter().map(|at| faces[at]).collect())
    }
}

/// The mesh at rest.
impl Apart for MeshFile {
    fn zone_sides(&self, marked: &CellSet) -> Result<ZoneSides> {
        self.0.by_pieces(|slabs, _| slabs.zone_sides(marked))
    }

    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        let mut out = NumbersFile::new(to, hash_from, &failed)?;
        self.0.by_pieces(|slabs, _| match numbers {
            Numbers::Displacements(_) | Numbers::Velocities(_) => {
                unreachable!("who asks how nodes move has moved them")
            }
            Numbers::Coordinates(wanted) => slabs
                .each_points(0..slabs.n_nodes, &mut |first, points| {
                    out.points(points, first, *wanted)
                }),
            Numbers::Nodes(wanted) => slabs.each_cells(wanted.cells.clone(), &mut |_, cells| {
                let all = 0..cells.len();
                let n_bytes = wanted.n_numbers(cells, all.clone()) * wanted.size();
                out.piece(n_bytes, |take| {
                    list_nodes(cells, all, wanted, &|node| node, take)
                })
            }),
        })?;
        Ok(out.finish().0)
    }
}
