//! The folders of a case: those of times, regions and pieces, and which of them have a mesh.

use super::file::path_of;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of what does not change.
pub(super) const CONSTANT: &str = "constant";
/// The folder of a mesh.
pub(super) const MESH: &str = "polyMesh";

/// A mesh of the sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    /// Its time; 0 of `constant`.
    pub time: f64,
    /// Name of its folder.
    pub name: String,
    /// Whether only the pieces have it.
    pub is_decomposed: bool,
}

/// A folder of one piece, `processorN`, or a collated one of several, `processorsN`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pieces {
    /// The folder.
    pub folder: PathBuf,
    /// Number of the first piece in it.
    pub first: usize,
    /// Whether it is a collated one.
    pub is_collated: bool,
}

impl Step {
    /// The mesh that the case begins with.
    pub fn constant() -> Self {
        Self {
            time: 0.0,
            name: CONSTANT.to_owned(),
            is_decomposed: false,
        }
    }
}

/// Whether a folder has the files of a mesh.
pub(super) fn is_mesh(folder: &Path) -> bool {
    let has = |name: &str| path_of(folder, name).is_some();
    let is_named = || parent_of(folder).is_some_and(|(name, _)| name == MESH);
    has("faces") && has("owner") || has("points") && is_named()
}

pub(super) fn is_case(folder: &Path) -> bool {
    folder.join("system/controlDict").is_file()
        || folder.join(CONSTANT).join(MESH).is_dir()
        || !steps_in(folder, None, false).is_empty()
        || !pieces_in(folder).is_empty()
        || !regions_in(folder).is_empty()
}

/// The name of a file or folder, and the folder that it is in.
pub(super) fn parent_of(path: &Path) -> Option<(String, PathBuf)> {
    let Some(name) = path.file_name() else {
        let whole = fs::canonicalize(path).ok()?;
        let name = whole.file_name()?.to_string_lossy().into_owned();
        return Some((name, whole.parent()?.to_path_buf()));
    };
    let parent = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    Some((name.to_string_lossy().into_owned(), parent))
}

pub(super) fn is_instance(name: &str) -> bool {
    name == CONSTANT || time_of(name).is_some()
}

/// The time that a folder is called by.
pub(super) fn time_of(name: &str) -> Option<f64> {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let is_number = name.chars().all(is_part) && !name.starts_with('+');
    let time: f64 = is_number.then(|| name.parse().ok())??;
    time.is_finite().then_some(time)
}

/// Times with their folders, in any order.
pub(super) fn times_in(root: &Path) -> Vec<(f64, String)> {
    let entries = fs::read_dir(root).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names
        .filter_map(|name| Some((time_of(&name)?, name)))
        .collect()
}

pub(super) fn mesh_folder(root: &Path, instance: &str, region: Option<&str>) -> PathBuf {
    let mut folder = root.join(instance);
    folder.extend(region);
    folder.join(MESH)
}

/// The times at which a folder has points, `constant` before them unless there is one at time 0 or before.
pub(super) fn steps_in(root: &Path, region: Option<&str>, is_decomposed: bool) -> Vec<Step> {
    let has_points = |name: &str| {
        let folder = mesh_folder(root, name, region);
        path_of(&folder, "points").is_some() || path_of(&folder, "faces").is_some()
    };
    let times = times_in(root).into_iter();
    let times = times.filter(|(_, name)| has_points(name));
    let mut steps: Vec<Step> = times
        .map(|(time, name)| Step {
            time,
            name,
            is_decomposed,
        })
        .collect();
    // Names such as 0.5 and 0.50 are one time.
    steps.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.name.cmp(&b.name)));
    steps.dedup_by(|a, b| a.time == b.time);
    if has_points(CONSTANT) && steps.first().is_none_or(|first| first.time > 0.0) {
        let constant = Step {
            is_decomposed,
            ..Step::constant()
        };
        steps.insert(0, constant);
    }
    steps
}

/// Names of the regions of a case.
pub(super) fn regions_of(root: &Path, pieces: &[Pieces]) -> Vec<String> {
    let mut regions = regions_in(root);
    if let Some(pieces) = pieces.first() {
        regions.extend(regions_in(&pieces.folder));
    }
    regions.sort();
    regions.dedup();
    regions
}

pub(super) fn regions_in(root: &Path) -> Vec<String> {
    let entries = fs::read_dir(root.join(CONSTANT))
        .into_iter()
        .flatten()
        .flatten();
    let names = entries.filter(|entry| is_mesh(&entry.path().join(MESH)));
    names
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect()
}

/// Names of the folders of the pieces in a case.
pub(super) fn piece_folders(root: &Path) -> Vec<String> {
    let pieces = pieces_in(root);
    let names = pieces.iter().filter_map(|pieces| pieces.folder.file_name());
    names
        .map(|name| name.to_string_lossy().into_owned())
        .collect()
}

/// The folders of the pieces of a decomposed case, in the order of the pieces.
pub(super) fn pieces_in(root: &Path) -> Vec<Pieces> {
    let entries = fs::read_dir(root).into_iter().flatten().flatten();
    let pieces = entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let folder = root.join(&name);
        let rest = name.strip_prefix("processor")?;
        if let Some(range) = rest.strip_prefix('s') {
            // `processorsN_A-B` has the pieces A to B.
            let first = match range.split_once('_') {
                Some((_, range)) => range.split_once('-')?.0.parse().ok()?,
                None if range.bytes().all(|byte| byte.is_ascii_digit()) => 0,
                None => return None,
            };
            return Some(Pieces {
                folder,
                first,
                is_collated: true,
            });
        }
        Some(Pieces {
            folder,
            first: rest.parse().ok()?,
            is_collated: false,
        })
    });
    let is_one = |pieces: &Pieces| pieces.folder.is_dir() && pieces.first < u32::MAX as usize;
    let mut pieces: Vec<Pieces> = pieces.filter(is_one).collect();
    let has_single = pieces.iter().any(|pieces| !pieces.is_collated);
    // A case has the one or the other; both after it was decomposed twice.
    pieces.retain(|pieces| pieces.is_collated != has_single);
    pieces.sort_by(|a, b| (a.first, &a.folder).cmp(&(b.first, &b.folder)));
    pieces
}
