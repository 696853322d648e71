//! The outline of a mesh that the ranks have read in parts, and what the first rank asks the others for besides: the first cells at
//! moving walls, and faces that lie on no cell. With an outline the first rank holds its own part and the surface, until something
//! needs the whole mesh.

use super::Team;
use super::order::Order;
use super::placing::{NotByFields, Numbered, Placing};
use super::serve::part_of_file;
use super::work::{Work, cells_among};
use crate::deform::first_cells::{self, Edge};
use crate::deform::sharing::Holder;
use crate::error::{Error, Result};
use crate::formats::{Loaded, SharedFile};
use crate::geometry::vector::Vector;
use crate::mesh::{Doubled, Mesh, OneLayer, faces_on_no_cell};
use crate::motion::{QualityOutput, Schedule};
use crate::ranks::Ranks;
use crate::ranks::hash::{HashedBytes, TreeHasher};
use crate::ranks::raw::List;
use std::sync::Arc;

impl Team {
    /// The outline of the mesh, where that is enough for a schedule.
    ///
    /// # Errors
    /// Why the mesh has to be read as a whole, as for [`read_parts`](crate::formats::read_parts).
    pub fn outline_for(
        self: &Arc<Self>,
        schedule: &Schedule,
    ) -> std::result::Result<Loaded, String> {
        if schedule.output.quality == QualityOutput::Cells {
            return Err("it makes arrays of all cells (quality = \"cells\")".to_owned());
        }
        let outline = self.outline()?;
        match OneLayer::axis_of(&outline.mesh) {
            Ok(None) => Ok(outline),
            _ => Err("it is one layer of cells".to_owned()),
        }
    }

    /// The outline of the mesh, once each rank has read its part, and the notes of its reader.
    ///
    /// # Errors
    /// As [`outline_for`](Self::outline_for).
    pub fn outline(self: &Arc<Self>) -> std::result::Result<Loaded, String> {
        let file = self.file.as_ref().map_err(String::clone)?;
        let mut state = self.state();
        self.order(Order::Read {
            file: file.clone(),
            tells: true,
        });
        let read = part_of_file(file, &self.ranks)?;
        let outline = Mesh::outline_of(&read, &self.ranks, Some(self.clone()));
        state.work.read = Some(read);
        drop(state);
        let outline = outline.expect("this is the first rank");
        if outline.dimension() != 3 {
            return Err("it has no solid cells".to_owned());
        }
        file.complete(outline)
    }

    /// Has ranks read their parts with copies of nodes once more, where they have read them: else the first cuts the mesh.
    ///
    /// # Errors
    /// Where they cannot be read again.
    pub(in crate::deform) fn double(&self, doubled: Doubled) -> Result<()> {
        let Ok(file) = &self.file else {
            return Ok(());
        };
        let file = file.doubled(doubled);
        let mut state = self.state();
        if state.work.read.take().is_none() {
            // Its cells need not be those of the file.
            state.why_cut = Some("nodes where a zone turns are doubled".to_owned());
            return Ok(());
        }
        self.order(Order::Read {
            file: file.clone(),
            tells: false,
        });
        let read = part_of_file(&file, &self.ranks).map_err(Error::system)?;
        state.work.read = Some(read);
        self.doubled.set(file).expect("a mesh is doubled once");
        Ok(())
    }

    /// The file of which ranks read their parts.
    pub(super) fn file(&self) -> std::result::Result<&SharedFile, &String> {
        self.doubled.get().map_or_else(|| self.file.as_ref(), Ok)
    }

    /// The whole mesh, which ranks have read by parts.
    ///
    /// # Errors
    /// Where it cannot be read again.
    pub(in crate::deform) fn whole(&self) -> Result<Mesh> {
        let file = self.file();
        file.expect("ranks have read it by parts").read_whole()
    }

    /// The hash of the file that ranks have read by parts.
    pub(in crate::deform) fn hash_of_file(&self) -> Result<blake3::Hash> {
        let file = self.file.as_ref().expect("ranks have read it by parts");
        let _state = self.state();
        self.order(Order::Hash(file.clone()));
        let of_ranks = self.ranks.gather(hash_of_share(file, &self.ranks));
        let mut hasher = TreeHasher::default();
        for share in of_ranks.into_iter().flatten() {
            share?.iter().for_each(|part| hasher.take(part));
        }
        Ok(hasher.finalize())
    }
}

impl Holder for Team {
    fn edges_off_walls(&self, nodes: &[u32]) -> Result<(Vec<Edge>, Vec<Vector>)> {
        let state = self.state();
        self.order(Order::Edges);
        let walls: Vec<(u32, Placing)> = nodes.iter().map(|&node| (node, Placing::Told)).collect();
        let found = edges(&state.work, Some(&walls), &self.ranks);
        Ok(first_cells::shortest_of(found.into_iter().flatten()))
    }

    fn faces_on_no_cell(&self, _: &Mesh, faces: &[u32]) -> Result<Vec<u32>> {
        let state = self.state();
        self.order(Order::LooseFaces(faces.to_vec()));
        let found = self.ranks.gather(loose_faces(&state.work, faces));
        let found = found.into_iter().flatten();
        Ok(found.flat_map(|List(faces)| faces).collect())
    }
}

/// What a rank tells of its share of a file.
pub(super) fn hash_of_share(file: &SharedFile, ranks: &Ranks) -> Result<Vec<HashedBytes>> {
    ranks.together(|| file.hash_of_share(ranks))
}

/// Reads the part of a rank, and tells the first of it where that `tells`.
pub(super) fn read(work: &mut Work, (file, tells): (&SharedFile, bool), ranks: &Ranks) {
    work.read = None;
    let Ok(read) = part_of_file(file, ranks) else {
        return;
    };
    if tells {
        Mesh::outline_of(&read, ranks, None);
    }
    work.read = Some(read);
}

/// The shortest edges of the own cells that leave walls, all on the first rank, which has the nodes of walls.
pub(super) fn edges(
    work: &Work,
    walls: Option<&[(u32, Placing)]>,
    ranks: &Ranks,
) -> Vec<Vec<(Edge, Vector)>> {
    let mesh = work.cells_to_write();
    let part = mesh.part.as_ref().expect("it is a part of a mesh");
    let numbered = Numbered {
        n_nodes: mesh.n_nodes_of_all(),
        all: Some(&part.nodes),
    };
    let walls = NotByFields::share(walls, &numbered, ranks).told;
    let own = ranks.together(|| first_cells::shortest(mesh, mesh.own_cells(), &walls));
    let edge = |&(at, off, length): &Edge| {
        let on = part.nodes[walls[at as usize] as usize];
        let end = mesh.points[off as usize];
        ((on, part.nodes[off as usize], length), end)
    };
    let mut to_each = vec![Vec::new(); ranks.n()];
    to_each[0] = own.iter().map(edge).collect();
    ranks.exchange_values(to_each)
}

/// Those of the own faces, among these of the whole mesh, that are a side of no cell.
pub(super) fn loose_faces(work: &Work, faces: &[u32]) -> List<u32> {
    let mesh = work.cells_to_write();
    let own = mesh.own_cells();
    let mut here = cells_among(mesh, faces);
    here.retain(|&face| own.contains(&(face as usize)));
    let found = faces_on_no_cell(mesh, &here);
    let number = |face: u32| face + mesh.own_offset() as u32;
    List(found.into_iter().map(number).collect())
}
