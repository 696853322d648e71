//! The interface of formats whose sequences lie in a folder that holds more than meshes, such as the case of a solver: a
//! file for each step, beside what all steps share.

use super::{Begin, Commit, Location, Notes, OutputSet, Staged, WriteOptions};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Name of the point array that is the displacement of the nodes.
pub const DISPLACEMENT: &str = "Displacement";

/// The mesh that all steps share, as it is in the case.
pub struct Begun {
    /// Notes of the writer.
    pub notes: Notes,
    /// Hashes of its files but the points, by their paths from the case on.
    pub files: BTreeMap<String, blake3::Hash>,
    /// The files that are to be put in place.
    pub staged: Staged,
}

/// A format with such sequences.
pub trait CaseFormat: Sync {
    /// Whether a folder is a case, with or without a mesh.
    fn is_case(&self, folder: &Path) -> bool;

    /// The folder in the case that has the records of a run.
    fn records(&self) -> &'static str;

    /// The file of each step, as a path from the case on, for steps of these times.
    ///
    /// # Errors
    /// Where two steps would have one file.
    fn step_files(&self, case: &Path, mesh: &MeshView, times: &[f64]) -> Result<Vec<String>>;

    /// Whether the file of a step takes the place of the mesh that all steps share.
    fn is_shared(&self, file: &str) -> bool;

    /// Stages what all steps share, and copies what belongs to the case that the mesh was read from. What is there
    /// already stays as it is; a mesh that is there is replaced with [`Begin::Create`]. With [`Begin::Resume`] it is kept where it is
    /// this one; where a file is missing or another, all but its points are written again.
    ///
    /// # Errors
    /// Where the mesh that is there is another one.
    fn begin(
        &self,
        case: &Path,
        mesh: &MeshView,
        options: &WriteOptions,
        begin: Begin,
        commit: Commit,
    ) -> Result<Begun>;

    /// Refuses to write the sequence of a mesh to a case.
    fn check(&self, case: &Path, mesh: &MeshView) -> Result<()>;

    /// The folder of the mesh that all steps share, from the case on.
    fn shared(&self, mesh: &MeshView) -> String;

    /// Writes a step, whose displacement is the point array [`DISPLACEMENT`] where it has one.
    fn write_step(
        &self,
        mesh: &MeshView,
        file: &str,
        out: &mut OutputSet,
        options: &WriteOptions,
    ) -> Result<()>;

    /// Whether a step that was written has this hash, as [`OutputSet`] gave it.
    fn has_hash(&self, path: &Path, hash: &str) -> io::Result<bool>;

    /// The case and the index in it of the step whose file this is, where the file has a part of the mesh only.
    fn step_at(&self, path: &Path) -> Option<(Location, usize)>;

    /// All files of a step that are there, as paths.
    fn files_of(&self, path: &Path) -> Vec<std::path::PathBuf>;
}
