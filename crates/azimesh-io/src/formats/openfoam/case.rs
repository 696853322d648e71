//! Which folders and times a path stands for: a case, a `.foam` file in it, `constant/polyMesh`, a region.
//!
//! ```text
//! CASE                            the mesh at every time
//! CASE/any.foam                   the same; any{REGION}.foam: of a region
//! CASE/constant/REGION            the mesh of a region at every time, whole or in pieces
//! CASE/TIME/polyMesh, CASE/TIME   the mesh at this time alone (constant too)
//! CASE/processor0                 one piece as a case of its own; CASE/processors4: all pieces
//! ```
//!
//! As in OpenFOAM, a file that a time does not have is that of the latest time before it.

use super::file::{FoamFile, path_of};
use super::folders::{
    CONSTANT, MESH, Pieces, Step, is_case, is_instance, is_mesh, mesh_folder, parent_of, pieces_in,
    regions_in, regions_of, steps_in, time_of, times_in,
};
use crate::formats::{Location, Source};
use azimesh_core::error::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// A case with the times at which its mesh is known.
pub(super) struct Case {
    /// Its folder.
    pub root: PathBuf,
    /// Region, where it is not the default one.
    pub region: Option<String>,
    /// Folders of the pieces of a decomposed case.
    pub pieces: Vec<Pieces>,
    /// The meshes of the sequence, in the order of their times.
    pub steps: Vec<Step>,
    /// Regions of the case.
    pub regions: Vec<String>,
}

/// What a path says of itself.
struct Spot {
    root: PathBuf,
    region: Option<String>,
    /// The one time that is meant.
    only: Option<String>,
    /// Whether the root is the folder of the mesh, of no case.
    is_bare: bool,
}

/// Folders of one piece, or of the whole case, at the times up to one.
pub(super) struct Instances {
    folders: Vec<PathBuf>,
}

impl Instances {
    /// The folders of a mesh in `root` up to this time, the latest first.
    fn up_to(root: &Path, region: Option<&str>, step: &Step) -> Self {
        let mut times = times_in(root);
        times.retain(|(time, name)| *name == step.name || *time <= step.time);
        // Of two names of one time, that of the step comes first.
        times.sort_by(|a, b| {
            b.0.total_cmp(&a.0)
                .then((b.1 == step.name).cmp(&(a.1 == step.name)))
        });
        let mut names: Vec<String> = times.into_iter().map(|(_, name)| name).collect();
        if step.name == CONSTANT {
            names.clear();
        }
        names.push(CONSTANT.to_owned());
        let folder = |name: String| mesh_folder(root, &name, region);
        Self {
            folders: names.into_iter().map(folder).collect(),
        }
    }

    /// The latest file of this name.
    pub fn find(&self, name: &str) -> Result<Option<FoamFile>> {
        match self.folder_of(name) {
            Some(folder) => FoamFile::find(folder, name),
            None => Ok(None),
        }
    }

    /// The latest file of this name, which must be there.
    pub fn need(&self, name: &str) -> Result<FoamFile> {
        self.find(name)?.ok_or_else(|| {
            let folder = self.folders.last().map_or(Path::new(""), PathBuf::as_path);
            Error::input(format!("the mesh has no file \"{name}\"")).file(folder)
        })
    }

    /// The latest folder with a file of this name.
    pub fn folder_of(&self, name: &str) -> Option<&Path> {
        let mut folders = self.folders.iter();
        let folder = folders.find(|folder| path_of(folder, name).is_some());
        folder.map(PathBuf::as_path)
    }

    /// The folders from the latest to that of `faces`, which has the files that belong to them.
    pub fn since_faces(&self) -> Self {
        let faces = self
            .folders
            .iter()
            .position(|folder| path_of(folder, "faces").is_some());
        let n = faces.map_or(self.folders.len(), |faces| faces + 1);
        Self {
            folders: self.folders[..n].to_vec(),
        }
    }
}

impl Case {
    /// Whether the file or folder is a case or a mesh.
    pub fn is_at(location: &Location) -> bool {
        Spot::of(location).is_some()
    }

    /// The case that a path stands for.
    pub fn at(location: &Location) -> Result<Self> {
        let path = location.path();
        let spot = Spot::of(location).ok_or_else(|| {
            Error::input(
                "this is no case of OpenFOAM: it has no constant/polyMesh, no polyMesh at a time, no processor folders and no system/controlDict",
            )
            .file(path)
        })?;
        let collated = parent_of(&spot.root).filter(|(name, _)| name.starts_with("processors"));
        let is_collated = collated.is_some();
        let root = collated.map_or(spot.root, |(_, case)| case);
        let pieces = pieces_in(&root);
        let mut case = Self {
            steps: Vec::new(),
            regions: regions_of(&root, &pieces),
            region: spot.region,
            root,
            pieces,
        };
        case.steps = match (spot.is_bare, spot.only) {
            (true, _) => vec![Step::constant()],
            (false, Some(name)) => vec![Step {
                time: time_of(&name).unwrap_or(0.0),
                is_decomposed: is_collated,
                name,
            }],
            (false, None) => case.find_steps(),
        };
        if is_collated {
            case.steps
                .iter_mut()
                .for_each(|step| step.is_decomposed = true);
        }
        match case.steps.is_empty() {
            true => Err(case.without_mesh(path)),
            false => Ok(case),
        }
    }

    /// The folders of the whole mesh, up to a step.
    pub fn whole(&self, step: &Step) -> Instances {
        if is_mesh(&self.root) {
            return Instances {
                folders: vec![self.root.clone()],
            };
        }
        Instances::up_to(&self.root, self.region.as_deref(), step)
    }

    /// The folders of a piece, or of several collated ones, up to a step.
    pub fn of_pieces(&self, pieces: &Pieces, step: &Step) -> Instances {
        Instances::up_to(&pieces.folder, self.region.as_deref(), step)
    }

    /// Times whose folders have files besides a mesh.
    pub fn n_times_with_fields(&self) -> usize {
        let has_fields = |(_, name): &(f64, String)| {
            let mut folder = self.root.join(name);
            folder.extend(&self.region);
            let mut entries = fs::read_dir(folder).into_iter().flatten().flatten();
            entries.any(|entry| entry.path().is_file())
        };
        times_in(&self.root)
            .iter()
            .filter(|time| has_fields(time))
            .count()
    }

    fn find_steps(&self) -> Vec<Step> {
        let region = self.region.as_deref();
        let mut steps = steps_in(&self.root, region, false);
        if let Some(pieces) = self.pieces.first() {
            for step in steps_in(&pieces.folder, region, true) {
                if !steps.iter().any(|known| known.time == step.time) {
                    steps.push(step);
                }
            }
        }
        steps.sort_by(|a, b| a.time.total_cmp(&b.time));
        steps
    }

    fn without_mesh(&self, path: &Path) -> Error {
        let message = match (&self.region, &self.regions[..]) {
            (Some(region), _) => format!("the case has no mesh of region {region}"),
            (None, []) => {
                "the case has no mesh: there is no constant/polyMesh with points".to_owned()
            }
            (None, regions) => format!(
                "the case has no mesh of its own but regions; give one of {}",
                list(regions.iter().map(|region| format!("{CONSTANT}/{region}")))
            ),
        };
        Error::input(message).file(path)
    }
}

/// A region of a case, by the file that viewers open it with, which does not have to be there.
pub(super) fn of_region(case: &Path, region: &str) -> Location {
    let mark = case.join(format!("case{{{region}}}.foam"));
    Source::from_bytes(&mark, Vec::new()).into()
}

fn list(names: impl Iterator<Item = String>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

impl Spot {
    fn of(location: &Location) -> Option<Self> {
        match location {
            Location::File(source) => Self::of_file(source.path()),
            Location::Folder(folder) => Self::of_folder(folder),
        }
    }

    /// An empty file for ParaView.
    fn of_file(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        if !["foam", "openfoam"].contains(&extension.as_str()) {
            return None;
        }
        let stem = path.file_stem()?.to_string_lossy().into_owned();
        let region = stem
            .split_once('{')
            .and_then(|(_, rest)| rest.strip_suffix('}'));
        Some(Self {
            root: parent_of(path)?.1,
            region: region.map(str::to_owned),
            only: None,
            is_bare: false,
        })
    }

    fn of_folder(folder: &Path) -> Option<Self> {
        let of_case = |root: &Path| Self {
            root: root.to_path_buf(),
            region: None,
            only: None,
            is_bare: false,
        };
        if is_mesh(folder) {
            let named = parent_of(folder).filter(|(name, _)| name == MESH);
            let spot = named.and_then(|(_, parent)| Self::of_instance(&parent, true));
            return Some(spot.unwrap_or_else(|| Self {
                is_bare: true,
                ..of_case(folder)
            }));
        }
        if folder.join(MESH).is_dir()
            && let Some(spot) = Self::of_instance(folder, false)
        {
            return Some(spot);
        }
        Self::of_region_in_pieces(folder).or_else(|| is_case(folder).then(|| of_case(folder)))
    }

    /// The folder of a region of which only the pieces have a mesh.
    fn of_region_in_pieces(folder: &Path) -> Option<Self> {
        let (region, constant) = parent_of(folder)?;
        let (name, root) = parent_of(&constant)?;
        let pieces = pieces_in(&root);
        let is_there = name == CONSTANT && regions_in(&pieces.first()?.folder).contains(&region);
        is_there.then_some(Self {
            root,
            region: Some(region),
            only: None,
            is_bare: false,
        })
    }

    /// The folder above a `polyMesh`: that of a time, or of a region in it. A region without `is_exact` is meant at
    /// every time.
    fn of_instance(folder: &Path, is_exact: bool) -> Option<Self> {
        let (name, above) = parent_of(folder)?;
        if is_instance(&name) {
            return Some(Self {
                root: above,
                region: None,
                only: Some(name),
                is_bare: false,
            });
        }
        let (time, root) = parent_of(&above)?;
        is_instance(&time).then(|| Self {
            root,
            region: Some(name),
            only: (is_exact || time != CONSTANT).then_some(time),
            is_bare: false,
        })
    }
}
