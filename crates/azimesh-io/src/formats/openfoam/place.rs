//! Where a mesh is written in a case: its folders, whole or in pieces.

use super::folders::{CONSTANT, MESH, piece_folders};
use super::topology::{StoredPieces, Topology};
use crate::formats::WriteOptions;
use crate::mesh::MeshView;
use std::path::{Path, PathBuf};

/// The folders of a mesh in its case.
pub(super) struct Place<'m> {
    /// The case.
    pub case: PathBuf,
    /// Region, where it is not the default one.
    pub region: Option<String>,
    /// The pieces that it is written in; none where it is written as a whole.
    pub pieces: &'m [StoredPieces],
}

impl<'m> Place<'m> {
    /// Of a path that is a case or a `.foam` file in it. The mesh keeps the region that it was read from, and its
    /// pieces, unless its cells or tags are others now.
    pub fn of(path: &Path, mesh: &MeshView<'m>) -> Self {
        let origin = mesh.origin.get::<Topology>();
        let fits = |origin: &&Topology| {
            !origin.pieces.is_empty() && origin.has_groups_of(mesh) && origin.has_cells_of(mesh)
        };
        Self {
            case: case_of(path),
            region: origin.and_then(|origin| origin.region.clone()),
            pieces: origin.filter(fits).map_or(&[], |origin| &origin.pieces),
        }
    }

    /// [`Place::of`], as a whole where one piece is wanted.
    pub fn with(path: &Path, mesh: &MeshView<'m>, options: &WriteOptions) -> Self {
        let place = Self::of(path, mesh);
        match options.pieces {
            Some(_) => Self {
                pieces: &[],
                ..place
            },
            None => place,
        }
    }

    /// The folder of the mesh at a time, in the folder of the case or of a piece.
    pub fn folder(&self, time: &str) -> String {
        match &self.region {
            Some(region) => format!("{time}/{region}/{MESH}"),
            None => format!("{time}/{MESH}"),
        }
    }

    /// The folders of the mesh at a time, from the case on: one, or that of each folder of pieces.
    pub fn folders(&self, time: &str) -> Vec<String> {
        let folder = self.folder(time);
        match self.pieces {
            [] => vec![folder],
            pieces => {
                let of_pieces = pieces.iter();
                let of_pieces = of_pieces.map(|pieces| format!("{}/{folder}", pieces.folder));
                of_pieces.collect()
            }
        }
    }

    /// The folders that this mesh replaces as a whole. Beside pieces no other mesh of the case stays: that would be read in
    /// their place.
    pub fn owned(&self) -> Vec<String> {
        let mut owned = self.folders(CONSTANT);
        if !self.pieces.is_empty() {
            let folder = self.folder(CONSTANT);
            let there = piece_folders(&self.case);
            owned.extend(there.iter().map(|pieces| format!("{pieces}/{folder}")));
            owned.push(folder);
            owned.sort();
            owned.dedup();
        }
        owned
    }
}

/// The folders in a case that hold a mesh at the beginning, whole or in pieces.
pub(super) fn owned_in(case: &Path) -> Vec<String> {
    let folder = format!("{CONSTANT}/{MESH}");
    let mut owned: Vec<String> = piece_folders(case)
        .iter()
        .map(|pieces| format!("{pieces}/{folder}"))
        .collect();
    owned.push(folder);
    owned
}

/// The case that a path stands for: its folder where it is a `.foam` file.
pub(super) fn case_of(path: &Path) -> PathBuf {
    let is_foam = path.extension().is_some_and(|ending| ending == "foam") && !path.is_dir();
    match path.parent() {
        Some(folder) if is_foam && folder.as_os_str().is_empty() => PathBuf::from("."),
        Some(folder) if is_foam => folder.to_path_buf(),
        _ => path.to_path_buf(),
    }
}

/// Name of the empty file by which ParaView opens a case.
pub(super) fn foam_file(path: &Path) -> String {
    let is_foam = path.extension().is_some_and(|ending| ending == "foam") && !path.is_dir();
    let full = std::path::absolute(path).unwrap_or_default();
    let name = full.file_name().unwrap_or_default().to_string_lossy();
    match is_foam {
        true => name.into_owned(),
        false if name.is_empty() => "case.foam".to_owned(),
        false => format!("{name}.foam"),
    }
}
