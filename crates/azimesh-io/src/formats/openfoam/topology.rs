//! What a mesh that was read from OpenFOAM leaves for its writer: the files of its topology as they are, its patches,
//! and where they lie. A mesh has it in [`Mesh::origin`](crate::mesh::Mesh::origin).

use crate::formats::Source;
use crate::mesh::{Cells, Group, MeshView};
use azimesh_core::parallel::collect;
use std::path::PathBuf;

/// The files of a mesh that do not change while it moves.
pub(crate) struct Topology {
    /// The folder of the case.
    pub case: PathBuf,
    /// Region, where it is not the default one.
    pub region: Option<String>,
    /// `faces`, `owner`, `neighbour`, `boundary` and, where there are some, `cellZones`, `faceZones`, `pointZones` and
    /// further files of the folder; none where the mesh was joined from the pieces of a decomposed case.
    pub files: Vec<StoredFile>,
    /// The pieces of a decomposed case, folder by folder.
    pub pieces: Vec<StoredPieces>,
    /// The patches, in the order of their faces.
    pub patches: Vec<Patch>,
    /// Number of faces between two cells; they come first.
    pub n_internal_faces: usize,
    /// Hash of the files and the points, however they are stored.
    pub(super) content: blake3::Hash,
    /// Hash of the cells that the files give.
    pub(super) cells: blake3::Hash,
    /// Hash of the tags and zones that the files give.
    pub(super) groups: blake3::Hash,
}

/// A file as it is on the disk.
pub(crate) struct StoredFile {
    /// Name in the folder, with `.gz` where it is compressed.
    pub name: String,
    /// Its bytes, compressed where it is.
    pub stored: Source,
}

/// A folder of one piece of a decomposed case, or of several collated ones.
pub(crate) struct StoredPieces {
    /// Its name in the case: `processor0`, `processors4`.
    pub folder: String,
    /// Whether a file has a block for each piece.
    pub is_collated: bool,
    /// The files of the topology, those of the numbers in the whole among them.
    pub files: Vec<StoredFile>,
    /// The pieces.
    pub pieces: Vec<StoredPiece>,
}

/// What is needed to write the points of a piece.
pub(crate) struct StoredPiece {
    /// The node of the whole that each of its points is.
    pub nodes: Vec<u32>,
    /// Its patches, in the order of their faces.
    pub patches: Vec<Patch>,
}

/// A patch: an entry of the file `boundary`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    /// Name.
    pub name: String,
    /// `patch`, `wall`, `cyclic` ...
    pub kind: String,
    /// Number of its faces.
    pub n_faces: usize,
    /// Index of its first face.
    pub start_face: usize,
    /// All entries as they are in the file, with `type`, `nFaces` and `startFace`: the key and the text between it and
    /// its semicolon, or a dictionary with its braces.
    pub entries: Vec<(String, String)>,
}

impl StoredPiece {
    /// What its points have of what nodes of the whole have.
    pub fn of(&self, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
        collect(self.nodes.len(), |i| values[self.nodes[i] as usize])
    }
}

impl Topology {
    /// Hash of the mesh that was read: of its files, points, cells, tags and zones.
    pub fn content(&self) -> blake3::Hash {
        self.content
    }

    /// Whether the mesh has the nodes and cells that the files give, boundary faces too, in their order.
    pub fn has_cells_of(&self, mesh: &MeshView) -> bool {
        hash_of_cells(mesh.points.len(), mesh.cells) == self.cells
    }

    /// Whether the mesh has the tags, with their types, and the zones that the files give.
    pub fn has_groups_of(&self, mesh: &MeshView) -> bool {
        hash_of_groups(mesh.groups) == self.groups
    }
}

impl Patch {
    /// The type that a tag has: none where it is the general one.
    pub fn condition(&self) -> Option<String> {
        (self.kind != "patch").then(|| self.kind.clone())
    }

    /// The text of an entry.
    pub fn entry(&self, key: &str) -> Option<&str> {
        let mut entries = self.entries.iter();
        let (_, text) = entries.find(|(known, _)| known == key)?;
        Some(text)
    }
}

/// Hash of the cells of a mesh with so many nodes.
pub(super) fn hash_of_cells(n_nodes: usize, cells: &Cells) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let mut add = |number: usize| {
        hasher.update(&(number as u64).to_le_bytes());
    };
    add(n_nodes);
    for run in cells.runs() {
        add(run.kind as usize);
        add(run.n_nodes);
        add(run.n_cells());
    }
    update(&mut hasher, cells.connectivity());
    update(&mut hasher, cells.face_streams());
    hasher.finalize()
}

/// Hash of files and points, and of cells, tags and zones, of which their own hashes are given.
pub(super) fn hash_of_content<'f>(
    files: impl IntoIterator<Item = &'f StoredFile>,
    points: &[[f64; 3]],
    further: &[blake3::Hash],
) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let bytes = file.stored.bytes();
        for n in [file.name.len(), bytes.len()] {
            hasher.update(&(n as u64).to_le_bytes());
        }
        hasher.update(file.name.as_bytes());
        hasher.update_rayon(bytes);
        file.stored.release();
    }
    hasher.update_rayon(bytemuck::cast_slice(points));
    for hash in further {
        hasher.update(hash.as_bytes());
    }
    hasher.finalize()
}

fn update(hasher: &mut blake3::Hasher, numbers: &[u32]) {
    hasher.update(&(numbers.len() as u64).to_le_bytes());
    if cfg!(target_endian = "little") {
        hasher.update_rayon(bytemuck::cast_slice(numbers));
        return;
    }
    let mut bytes = Vec::with_capacity(1 << 20);
    for block in numbers.chunks(1 << 18) {
        bytes.clear();
        bytes.extend(block.iter().flat_map(|number| number.to_le_bytes()));
        hasher.update_rayon(&bytes);
    }
}

/// Hash of tags and zones: names, types, cells.
pub(super) fn hash_of_groups(groups: &[Group]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let mut text = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    for group in groups {
        text(&group.name);
        text(group.condition.as_deref().unwrap_or_default());
        let ranges: Vec<String> = group.cells.ranges().map(|r| format!("{r:?}")).collect();
        text(&format!("{} {}", group.dimension, ranges.join(" ")));
    }
    hasher.finalize()
}
