//! What a run is asked for.

use crate::record::Criterion;
use std::ops::Range;
use std::path::PathBuf;

/// Options of a run that its deformation does not have.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The mesh file, for names and hashes.
    pub mesh: PathBuf,
    /// Where the files go.
    pub folder: PathBuf,
    /// Base points chosen before.
    pub base: Option<PathBuf>,
    /// The steps to write, counted from 0; all when left out.
    pub steps: Option<Range<usize>>,
    /// The cell array that the boundary tags were read from, where it was named.
    pub tag_array: Option<String>,
    /// Whether files of an earlier run are replaced.
    pub force: bool,
    /// Whether an earlier run is resumed.
    pub resume: bool,
    /// Whether a step that cannot be written is skipped and the run continues.
    pub keep_going: bool,
    /// Whether bodies may leave the mesh.
    pub allow_outside: bool,
    /// Whether a disk without room for all steps is written to nevertheless.
    pub no_space_check: bool,
    /// Whether steps need not outlive a power cut.
    pub no_sync: bool,
    /// Bytes of arrays that lie on the disk while it runs.
    pub bytes_in_files: u64,
    /// Conditions that fail the run.
    pub fail_on: Vec<Criterion>,
}
