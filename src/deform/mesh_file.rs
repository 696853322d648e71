//! The file of a mesh that no process holds as a whole: what is known of it is read piece by piece when it is asked for.

use super::first_cells::{self, Edge};
use super::numbers_file::{NumbersFile, failed};
use super::sharing::Holder;
use crate::error::Result;
use crate::formats::{Loaded, SharedFile, reason};
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
    /// The file of the same mesh with copies of some nodes.
    pub(super) fn doubled(&self, doubled: Doubled) -> Arc<Self> {
        Arc::new(Self(self.0.doubled(doubled)))
    }

    /// The outline of the mesh in a file, and the notes of its reader.
    ///
    /// # Errors
    /// Why the mesh has to be read as a whole, in words that complete "it is read whole: ...".
    pub fn outline(file: SharedFile) -> std::result::Result<(Arc<Self>, Loaded), String> {
        let file = Arc::new(Self(file));
        let at_once = file.0.nodes_at_once().map_err(reason)?;
        if at_once > MOST_AT_ONCE {
            return Err(format!(
                "coordinates of {at_once} nodes are stored in one piece (`azimesh convert` writes a mesh without such pieces)"
            ));
        }
        let by: Arc<dyn Apart> = file.clone();
        let outline = file
            .0
            .by_pieces(|slabs, faces_once| Mesh::outline_by_pieces(slabs, faces_once, by));
        let outline = file.0.complete(outline.map_err(reason)?)?;
        match OneLayer::axis_of(&outline.mesh) {
            Ok(None) => Ok((file, outline)),
            _ => Err("it is one layer of cells".to_owned()),
        }
    }
}

impl Holder for MeshFile {
    fn edges_off_walls(&self, nodes: &[u32]) -> Result<(Vec<Edge>, Vec<Vector>)> {
        self.0.by_pieces(|slabs, _| {
            let walls = NodeBits::new(&(0..slabs.n_nodes));
            walls.add(nodes);
            let mut edges: Vec<[u32; 2]> = Vec::new();
            slabs.each_cells(&mut |_, cells| {
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
        let Numbers::Coordinates(wanted) = numbers else {
            unreachable!("a mesh that is looked at is not written");
        };
        let mut out = NumbersFile::new(to, hash_from, &failed)?;
        self.0.by_pieces(|slabs, _| {
            slabs.each_points(&mut |first, points| out.points(points, first, *wanted))
        })?;
        Ok(out.finish().0)
    }
}
