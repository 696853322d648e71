//! The folders of a case, its times, regions and pieces, and the mesh that a path in it names.
//!
//! ```text
//! CASE                            the mesh at every time
//! CASE/any.foam                   the same; any{REGION}.foam: of a region
//! CASE/constant/REGION            the mesh of a region at every time, whole or in pieces
//! CASE/TIME/polyMesh, CASE/TIME   the mesh at this time alone (constant too)
//! CASE/processor0                 one piece as a case of its own; CASE/processors4: all pieces
//! ```
//!
//! As in OpenFOAM, a file that a time does not have is taken from the latest time before it.

use super::file::path_of;
use super::topology::{StoredPieces, Topology};
use crate::formats::inputs::files_in;
use crate::formats::{Location, Source};
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of what does not change.
pub(super) const CONSTANT: &str = "constant";
/// The folder of a mesh.
pub(super) const MESH: &str = "polyMesh";

/// A path in a case: the case, and the region and the time that the path names.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct CasePath {
    /// The case, or a folder of pieces.
    pub root: PathBuf,
    /// Region, where it is not the default one.
    pub region: Option<String>,
    /// The one time that is meant.
    pub time: Option<String>,
}

/// A mesh of the sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub time: f64,
    pub name: String,
    /// Only the pieces have the mesh.
    pub is_decomposed: bool,
}

/// A folder of one piece, `processorN`, or a collated one of several, `processorsN`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ProcessorDirs {
    pub name: String,
    /// Number of the first piece in it.
    pub first: usize,
    pub is_collated: bool,
}

/// A case with the times at which its mesh is known.
pub(super) struct Case {
    pub path: CasePath,
    pub pieces: Vec<ProcessorDirs>,
    /// The meshes of the sequence, in the order of their times.
    pub steps: Vec<Step>,
    pub regions: Vec<String>,
}

/// The folders that a mesh is written to.
pub(super) struct Place<'m> {
    pub path: CasePath,
    /// The pieces that it is written in; none where it is written as a whole.
    pub pieces: &'m [StoredPieces],
}

impl CasePath {
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self {
            root: root.into(),
            ..Self::default()
        }
    }

    /// The path of a file or folder that is a case or a mesh.
    pub fn of(location: &Location) -> Option<Self> {
        let folder = match location {
            Location::File(source) => return Self::of_mark(source.path()),
            Location::Folder(folder) => folder,
        };
        let whole = || Self::new(folder.clone());
        if is_mesh(folder) {
            let named = parent_of(folder).filter(|(name, _)| name == MESH);
            let path = named.and_then(|(_, above)| Self::of_instance(&above, true));
            return Some(path.unwrap_or_else(whole));
        }
        let has_mesh = folder.join(MESH).is_dir();
        let path = has_mesh.then(|| Self::of_instance(folder, false));
        path.flatten()
            .or_else(|| Self::of_region_in_pieces(folder))
            .or_else(|| is_case(folder).then(whole))
    }

    /// The path of points: `CASE/TIME/polyMesh/points`, or with a region in between.
    pub fn of_points(path: &Path) -> Option<Self> {
        let (name, above) = parent_of(path.parent()?)?;
        let path = (name == MESH).then(|| Self::of_instance(&above, true));
        path.flatten()
    }

    /// An empty file for ParaView.
    fn of_mark(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        if !["foam", "openfoam"].contains(&extension.as_str()) {
            return None;
        }
        let stem = path.file_stem()?.to_string_lossy().into_owned();
        let region = stem.split_once('{').map(|(_, rest)| rest);
        Some(Self {
            region: region.and_then(|rest| Some(rest.strip_suffix('}')?.to_owned())),
            ..Self::new(parent_of(path)?.1)
        })
    }

    /// The folder of a region with a mesh in the pieces alone.
    fn of_region_in_pieces(folder: &Path) -> Option<Self> {
        let (region, constant) = parent_of(folder)?;
        let (name, root) = parent_of(&constant)?;
        let pieces = root.join(&pieces_in(&root).first()?.name);
        let is_there = name == CONSTANT && regions_in(&pieces).contains(&region);
        is_there.then_some(Self {
            region: Some(region),
            ..Self::new(root)
        })
    }

    /// The folder above a `polyMesh`: a time, or a region in it. A region without `is_exact` is meant at
    /// every time.
    fn of_instance(folder: &Path, is_exact: bool) -> Option<Self> {
        let is_instance = |name: &str| name == CONSTANT || time_of(name).is_some();
        let (name, above) = parent_of(folder)?;
        if is_instance(&name) {
            return Some(Self {
                time: Some(name),
                ..Self::new(above)
            });
        }
        let (time, root) = parent_of(&above)?;
        is_instance(&time).then(|| Self {
            region: Some(name),
            time: (is_exact || time != CONSTANT).then_some(time),
            ..Self::new(root)
        })
    }

    /// The case and the region without a time, as a location that can be read.
    pub fn location(&self) -> Location {
        match &self.region {
            None => Location::Folder(self.root.clone()),
            // The file by which viewers open a region, which does not have to be there.
            Some(region) => {
                let mark = self.root.join(format!("case{{{region}}}.foam"));
                Source::from_bytes(&mark, Vec::new()).into()
            }
        }
    }

    /// The folder of fields at a time, in the folder of the case or of a piece.
    pub fn fields(&self, time: &str) -> String {
        match &self.region {
            Some(region) => format!("{time}/{region}"),
            None => time.to_owned(),
        }
    }

    /// The folder of the mesh at a time, in the folder of the case or of a piece.
    pub fn folder(&self, time: &str) -> String {
        format!("{}/{MESH}", self.fields(time))
    }

    /// The folders in the case that have the mesh that the case begins with, whole or in pieces.
    pub fn owned(&self) -> Vec<String> {
        let folder = self.folder(CONSTANT);
        let pieces = pieces_in(&self.root).into_iter();
        let pieces = pieces.map(|pieces| format!("{}/{folder}", pieces.name));
        pieces.chain([folder.clone()]).collect()
    }

    /// All files of the mesh, whole or in pieces, at every time.
    pub fn files(&self) -> Vec<PathBuf> {
        let pieces = pieces_in(&self.root).into_iter();
        let roots = pieces.map(|pieces| self.root.join(pieces.name));
        let mut files = Vec::new();
        for root in roots.chain([self.root.clone()]) {
            let times = times_in(&root).into_iter().map(|(_, name)| name);
            for time in times.chain([CONSTANT.to_owned()]) {
                let folder = root.join(self.folder(&time));
                let names = files_in(&folder).unwrap_or_default();
                files.extend(names.into_iter().map(|name| folder.join(name)));
            }
        }
        files
    }

    /// The same region and time in a folder of pieces.
    fn within(&self, pieces: &ProcessorDirs) -> Self {
        Self {
            root: self.root.join(&pieces.name),
            ..self.clone()
        }
    }

    /// The folders of the mesh up to a step, the latest first.
    fn up_to(&self, step: &Step) -> Vec<PathBuf> {
        let mut times = times_in(&self.root);
        times.retain(|(time, name)| {
            step.name != CONSTANT && (*name == step.name || *time <= step.time)
        });
        // Of two names of one time, the name of the step comes first.
        times.sort_by(|(a, own), (b, other)| {
            let is_step = |name: &String| *name == step.name;
            b.total_cmp(a).then(is_step(other).cmp(&is_step(own)))
        });
        let names = times.iter().map(|(_, name)| name.as_str());
        let folder = |name: &str| self.root.join(self.folder(name));
        names.chain([CONSTANT]).map(folder).collect()
    }

    /// The times at which the folder has points, `constant` before them unless there is one at time 0 or before.
    fn steps(&self, is_decomposed: bool) -> Vec<Step> {
        let step = |(time, name)| Step {
            time,
            name,
            is_decomposed,
        };
        let has_points = |(_, name): &(f64, String)| {
            let folder = self.root.join(self.folder(name));
            path_of(&folder, "points").is_some() || path_of(&folder, "faces").is_some()
        };
        let mut times = times_in(&self.root);
        times.retain(has_points);
        // Names such as 0.5 and 0.50 are one time.
        times.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        times.dedup_by(|a, b| a.0 == b.0);
        let constant = (0.0, CONSTANT.to_owned());
        if has_points(&constant) && times.first().is_none_or(|first| first.0 > 0.0) {
            times.insert(0, constant);
        }
        times.into_iter().map(step).collect()
    }
}

impl Case {
    pub fn at(location: &Location) -> Result<Self> {
        let path = location.path();
        let mut of = CasePath::of(location).ok_or_else(|| {
            Error::input(
                "this is no case of OpenFOAM: it has no constant/polyMesh, no polyMesh at a time, no processor folders and no system/controlDict",
            )
            .file(path)
        })?;
        let collated = parent_of(&of.root).filter(|(name, _)| name.starts_with("processors"));
        let is_decomposed = collated.is_some();
        if let Some((_, case)) = collated {
            of.root = case;
        }
        let pieces = pieces_in(&of.root);
        let mut regions = regions_in(&of.root);
        if let Some(pieces) = pieces.first() {
            regions.extend(regions_in(&of.root.join(&pieces.name)));
        }
        regions.sort();
        regions.dedup();
        let mut case = Self {
            steps: Vec::new(),
            regions,
            path: of,
            pieces,
        };
        let step = |time, name| Step {
            time,
            name,
            is_decomposed,
        };
        case.steps = match case.path.time.take() {
            Some(name) => vec![step(time_of(&name).unwrap_or(0.0), name)],
            None if is_mesh(&case.path.root) => vec![step(0.0, CONSTANT.to_owned())],
            None => case.find_steps(is_decomposed),
        };
        if case.steps.is_empty() {
            return Err(case.without_mesh(path));
        }
        Ok(case)
    }

    /// The folders of the mesh up to a step, whole or in a folder of pieces, the latest first.
    pub fn folders(&self, step: &Step, pieces: Option<&ProcessorDirs>) -> Vec<PathBuf> {
        match pieces {
            Some(pieces) => self.path.within(pieces).up_to(step),
            None if is_mesh(&self.path.root) => vec![self.path.root.clone()],
            None => self.path.up_to(step),
        }
    }

    /// Times whose folders have files besides a mesh.
    pub fn n_times_with_fields(&self) -> usize {
        let has_fields = |(_, name): &&(f64, String)| {
            let entries = fs::read_dir(self.path.root.join(self.path.fields(name)));
            let mut entries = entries.into_iter().flatten().flatten();
            entries.any(|entry| entry.path().is_file())
        };
        times_in(&self.path.root).iter().filter(has_fields).count()
    }

    fn find_steps(&self, is_decomposed: bool) -> Vec<Step> {
        let mut steps = self.path.steps(is_decomposed);
        if let Some(pieces) = self.pieces.first() {
            let mut more = self.path.within(pieces).steps(true);
            more.retain(|step| !steps.iter().any(|known| known.time == step.time));
            steps.append(&mut more);
        }
        steps.sort_by(|a, b| a.time.total_cmp(&b.time));
        steps
    }

    fn without_mesh(&self, path: &Path) -> Error {
        let message = match (&self.path.region, &self.regions[..]) {
            (Some(region), _) => format!("the case has no mesh of region {region}"),
            (None, []) => {
                "the case has no mesh: there is no constant/polyMesh with points".to_owned()
            }
            (None, regions) => format!(
                "the case has no mesh of its own but regions; give one of {CONSTANT}/{}",
                regions.join(&format!(", {CONSTANT}/"))
            ),
        };
        Error::input(message).file(path)
    }
}

impl<'m> Place<'m> {
    /// Of a path that is a case or a `.foam` file in it. The mesh keeps the region that it was read from, and its
    /// pieces, unless its cells or tags are others now or `as_one`.
    pub fn of(path: &Path, mesh: &MeshView<'m>, as_one: bool) -> Self {
        let origin = mesh.origin.get::<Topology>();
        let in_pieces = origin.filter(|origin| !as_one && !origin.pieces.is_empty());
        let in_pieces =
            in_pieces.filter(|origin| origin.has_groups_of(mesh) && origin.has_cells_of(mesh));
        Self {
            path: CasePath {
                region: origin.and_then(|origin| origin.path.region.clone()),
                ..CasePath::new(case_of(path))
            },
            pieces: in_pieces.map_or(&[], |origin| &origin.pieces),
        }
    }

    /// The folders of the mesh at a time, from the case on: one, or one in each folder of pieces.
    pub fn folders(&self, time: &str) -> Vec<String> {
        let folder = self.path.folder(time);
        if self.pieces.is_empty() {
            return vec![folder];
        }
        let pieces = self.pieces.iter();
        pieces
            .map(|pieces| format!("{}/{folder}", pieces.folder))
            .collect()
    }

    /// The folders that this mesh replaces as a whole. With pieces no other mesh of the case stays: that would be read
    /// in their place.
    pub fn owned(&self) -> Vec<String> {
        let mut owned = self.folders(CONSTANT);
        if !self.pieces.is_empty() {
            owned.extend(self.path.owned());
            owned.sort();
            owned.dedup();
        }
        owned
    }
}

/// All files of the case that a path names, whole and in pieces: meshes, fields and settings.
pub(crate) fn files_of_case(path: &Path) -> Vec<PathBuf> {
    let location = match path.is_dir() {
        true => Location::Folder(path.to_path_buf()),
        false if is_mark(path) => Source::from_bytes(path, Vec::new()).into(),
        false => return Vec::new(),
    };
    let Some(CasePath { mut root, .. }) = CasePath::of(&location) else {
        return Vec::new();
    };
    if let Some((name, above)) = parent_of(&root)
        && name.starts_with("processors")
    {
        root = above;
    }
    let mut folders: Vec<PathBuf> = is_mesh(&root).then(|| root.clone()).into_iter().collect();
    let pieces = pieces_in(&root).into_iter();
    let pieces: Vec<PathBuf> = pieces.map(|pieces| root.join(pieces.name)).collect();
    for root in pieces.iter().chain([&root]) {
        let times = times_in(root).into_iter().map(|(_, name)| name);
        let further = [CONSTANT, "system"].map(str::to_owned);
        folders.extend(times.chain(further).map(|name| root.join(name)));
    }
    // Links may lead to a folder again.
    let mut known = BTreeSet::new();
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        let is_new = fs::canonicalize(&folder).is_ok_and(|real| known.insert(real));
        let entries = fs::read_dir(folder).into_iter().filter(|_| is_new);
        for path in entries.flatten().flatten().map(|entry| entry.path()) {
            match path.is_dir() {
                true => folders.push(path),
                false => files.push(path),
            }
        }
    }
    files
}

/// Checks if a path is a `.foam` file.
fn is_mark(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "foam") && !path.is_dir()
}

/// The folder of the case that is written to a path, which may be a `.foam` file in it.
pub(super) fn case_of(path: &Path) -> PathBuf {
    match path.parent().filter(|_| is_mark(path)) {
        Some(folder) if folder.as_os_str().is_empty() => PathBuf::from("."),
        Some(folder) => folder.to_path_buf(),
        None => path.to_path_buf(),
    }
}

/// Name of the empty file by which ParaView opens a case.
pub(super) fn mark_of(path: &Path) -> String {
    let full = std::path::absolute(path).unwrap_or_default();
    let name = full.file_name().unwrap_or_default().to_string_lossy();
    match (is_mark(path), &*name) {
        (true, name) => name.to_owned(),
        (false, "") => "case.foam".to_owned(),
        (false, name) => format!("{name}.foam"),
    }
}

/// Checks if a folder has the files of a mesh.
fn is_mesh(folder: &Path) -> bool {
    let has = |name: &str| path_of(folder, name).is_some();
    let is_named = || parent_of(folder).is_some_and(|(name, _)| name == MESH);
    has("faces") && has("owner") || has("points") && is_named()
}

fn is_case(folder: &Path) -> bool {
    folder.join("system/controlDict").is_file()
        || folder.join(CONSTANT).join(MESH).is_dir()
        || !CasePath::new(folder).steps(false).is_empty()
        || !pieces_in(folder).is_empty()
        || !regions_in(folder).is_empty()
}

/// The name of a file or folder, and the folder that it is in.
fn parent_of(path: &Path) -> Option<(String, PathBuf)> {
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

/// The time that a folder is called by.
fn time_of(name: &str) -> Option<f64> {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let is_number = name.chars().all(is_part) && !name.starts_with('+');
    let time: f64 = is_number.then(|| name.parse().ok())??;
    time.is_finite().then_some(time)
}

fn names_in(folder: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok())
}

/// Times with their folders, in any order.
fn times_in(root: &Path) -> Vec<(f64, String)> {
    let times = names_in(root).filter_map(|name| Some((time_of(&name)?, name)));
    times.collect()
}

/// Names of the regions of a case or a piece.
fn regions_in(root: &Path) -> Vec<String> {
    let constant = root.join(CONSTANT);
    let is_region = |name: &String| is_mesh(&constant.join(name).join(MESH));
    names_in(&constant).filter(is_region).collect()
}

/// The folders of the pieces of a decomposed case, in the order of the pieces.
pub(super) fn pieces_in(root: &Path) -> Vec<ProcessorDirs> {
    let pieces = names_in(root).filter_map(|name| {
        let rest = name.strip_prefix("processor")?;
        let (first, is_collated) = match rest.strip_prefix('s') {
            None => (rest.parse().ok()?, false),
            // `processorsN_A-B` has the pieces A to B.
            Some(range) => match range.split_once('_') {
                Some((_, range)) => (range.split_once('-')?.0.parse().ok()?, true),
                None if range.bytes().all(|byte| byte.is_ascii_digit()) => (0, true),
                None => return None,
            },
        };
        let is_one = root.join(&name).is_dir() && first < u32::MAX as usize;
        is_one.then_some(ProcessorDirs {
            name,
            first,
            is_collated,
        })
    });
    let mut pieces: Vec<_> = pieces.collect();
    let has_single = pieces.iter().any(|pieces| !pieces.is_collated);
    // A case has the one or the other; both after it was decomposed twice.
    pieces.retain(|pieces| pieces.is_collated != has_single);
    pieces.sort_by(|a, b| (a.first, &a.name).cmp(&(b.first, &b.name)));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_step_name_their_case_and_time() {
        let of = |path: &str| CasePath::of_points(Path::new(path));
        let found = |case: &str, region: Option<&str>, time: &str| {
            Some(CasePath {
                region: region.map(str::to_owned),
                time: Some(time.to_owned()),
                ..CasePath::new(case)
            })
        };
        let points = of("c/azimesh/../0.1/polyMesh/points");
        assert_eq!(points, found("c/azimesh/..", None, "0.1"));
        let points = of("c/constant/solid/polyMesh/points");
        assert_eq!(points, found("c", Some("solid"), "constant"));
        assert_eq!(of("10/1e-05/polyMesh/points"), found("10", None, "1e-05"));
        assert_eq!(of("c/0.1/points"), None);
    }
}
