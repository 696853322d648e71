//! A case with the points of many times: that of a run, written step by step beside a mesh that all steps share, and that
//! of a conversion, written as a whole.

use super::case::{Case, of_region};
use super::folders::{CONSTANT, MESH, piece_folders};
use super::motion::{field_path, write_time};
use super::place::{Place, foam_file};
use super::times::TimeNames;
use super::topology::Topology;
use super::write::{check, points, topology};
use super::{OpenFoam, beside};
use crate::formats::case::{Begun, CaseFormat};
use crate::formats::hash::hash_of;
use crate::formats::output_set::hash_of_names;
use crate::formats::{
    Begin, Commit, Location, Notes, OutputSet, SequenceFile, Staged, StepBytes, StepSize,
    WriteOptions,
};
use crate::mesh::MeshView;
use azimesh_core::diagnostic::formats::Written;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// How the names of the folders of pieces begin.
const PIECE: &str = "processor";

/// Bytes of the header of a file and of what stands around a list, at the most.
const AROUND: u64 = 1000;

/// Bytes that a mesh after the first adds to a case.
pub(super) fn step_bytes(step: &StepSize) -> StepBytes {
    StepBytes {
        coordinates: 24 * step.n_nodes + AROUND,
        arrays: step.n_vectors * (24 * step.n_nodes + AROUND),
        rest: 0,
    }
}

impl CaseFormat for OpenFoam {
    fn is_case(&self, folder: &Path) -> bool {
        folder.join("system").join("controlDict").is_file() || folder.join(CONSTANT).is_dir()
    }

    fn records(&self) -> &'static str {
        "azimesh"
    }

    fn check(&self, case: &Path, mesh: &MeshView) -> Result<()> {
        check(mesh)?;
        beside::check(case, mesh)
    }

    fn shared(&self, mesh: &MeshView) -> String {
        Place::of(Path::new(""), mesh)
            .folders(CONSTANT)
            .swap_remove(0)
    }

    fn step_files(&self, case: &Path, mesh: &MeshView, times: &[f64]) -> Result<Vec<String>> {
        let place = Place::of(case, mesh);
        let folders = time_names(&place.case, mesh)?.folders(times)?;
        let file = |folder: &String| format!("{}/points", place.folders(folder)[0]);
        Ok(folders.iter().map(file).collect())
    }

    fn is_shared(&self, file: &str) -> bool {
        time_in(file) == CONSTANT
    }

    fn begin(
        &self,
        case: &Path,
        mesh: &MeshView,
        options: &WriteOptions,
        begin: Begin,
        commit: Commit,
    ) -> Result<Begun> {
        let place = Place::of(case, mesh);
        let owned = place.owned();
        let write = |out: &mut OutputSet| -> Result<Notes> {
            out.place_in(&place.case, &owned)?;
            topology(mesh, out, &place, options)
        };
        let is_there_already = owned.iter().any(|own| place.case.join(own).exists());
        let own = place.folders(CONSTANT);
        let mut has_points = false;
        if begin == Begin::Resume && is_there_already {
            let mut wanted = OutputSet::nowhere(&place.case).hashed();
            let notes = write(&mut wanted)?;
            let files = wanted.finish().of_folder;
            has_points = own.iter().all(|own| points_in(&place, own).1.is_file());
            if has_points && is_there(&place.case, &files) {
                return Ok(Begun {
                    notes,
                    files,
                    staged: Staged::all(Vec::new()),
                });
            }
        }
        // Of several runs that find none, each a part of the sequence, one puts its mesh in place.
        let replace = is_there_already || begin != Begin::Resume;
        let mut out = OutputSet::new(&place.case, Commit { replace, ..commit }).hashed();
        let mut notes = write(&mut out)?;
        match has_points {
            // They may be those of a step.
            true => {
                own.iter()
                    .try_for_each(|own| keep_points(&place, own, &mut out))?;
                notes.push(Written::MeshAgain { folders: own });
            }
            false => points(mesh.points, &mut out, &place, CONSTANT, options)?,
        }
        beside::copy(mesh, &place, &mut out)?;
        let foam = foam_file(case);
        if !place.case.join(&foam).exists() {
            out.in_folder(&place.case, &foam, |_| Ok(()))?;
        }
        let written = out.finish();
        let mut files = written.of_folder;
        let is_own = |name: &str| owned.iter().any(|own| Path::new(name).starts_with(own));
        files.retain(|name, _| is_own(name) && !name.ends_with("/points"));
        Ok(Begun {
            notes,
            files,
            staged: written.files,
        })
    }

    fn write_step(
        &self,
        mesh: &MeshView,
        file: &str,
        out: &mut OutputSet,
        options: &WriteOptions,
    ) -> Result<()> {
        let place = Place::of(out.path(), mesh);
        let folder = time_in(file);
        let of_field = match folder {
            CONSTANT => time_names(&place.case, mesh)?.name(0.0),
            folder => folder.to_owned(),
        };
        write_time(mesh, folder, &of_field, &place, out, options)
    }

    fn has_hash(&self, path: &Path, hash: &str) -> io::Result<bool> {
        let points = hash_of(path)?;
        if points.to_string() == hash {
            return Ok(true);
        }
        let files = self.files_of(path);
        let Some((root, _)) = split(path) else {
            return Ok(false);
        };
        let (case, _) = roots_of(root);
        let mut hashes = BTreeMap::new();
        for file in files {
            let name = file.strip_prefix(&case).unwrap_or(&file);
            hashes.insert(name.to_string_lossy().replace('\\', "/"), hash_of(&file)?);
        }
        Ok(hash_of_names(&hashes).to_string() == hash)
    }

    fn step_at(&self, path: &Path) -> Option<(Location, usize)> {
        let (root, inside) = split(path)?;
        let (case, _) = roots_of(root.clone());
        if case == root {
            return None;
        }
        let location = match &inside[..] {
            [_, region, _, _] => of_region(&case, region),
            _ => Location::Folder(case),
        };
        let all = Case::at(&location).ok()?.steps;
        let step = all.iter().position(|step| step.name == inside[0])?;
        Some((location, step))
    }

    fn files_of(&self, path: &Path) -> Vec<PathBuf> {
        let Some((root, inside)) = split(path) else {
            return Vec::new();
        };
        let folder = inside.first().map_or("", |folder| folder.as_str());
        let region = (inside.len() == 4).then(|| inside[1].clone());
        let (case, roots) = roots_of(root);
        let place = Place {
            case: case.clone(),
            region,
            pieces: &[],
        };
        // The displacement at the mesh that a case begins with lies in the folder of its first time.
        let names = TimeNames::of_case(&case).unwrap_or_default();
        let field = match folder {
            CONSTANT => field_path(&place, &names.name(0.0)),
            folder => field_path(&place, folder),
        };
        let points = inside.join("/");
        let files = roots
            .iter()
            .flat_map(|root| [root.join(&points), root.join(&field)]);
        files.filter(|path| path.is_file()).collect()
    }
}

/// The time of the file of a step, `time/polyMesh/points` or that of a piece.
fn time_in(file: &str) -> &str {
    let mut names = file.split('/');
    let first = names.next().unwrap_or(file);
    match first.starts_with(PIECE) {
        true => names.next().unwrap_or(first),
        false => first,
    }
}

/// The case that a folder of times is, or is a piece of, and all folders of its times.
fn roots_of(root: PathBuf) -> (PathBuf, Vec<PathBuf>) {
    let name = root.file_name().unwrap_or_default().to_string_lossy();
    let is_piece = |case: &Path| piece_folders(case).iter().any(|piece| *piece == name);
    match root.parent().filter(|case| is_piece(case)) {
        Some(case) => {
            let pieces = piece_folders(case);
            let roots = pieces.iter().map(|piece| case.join(piece)).collect();
            (case.to_path_buf(), roots)
        }
        None => (root.clone(), vec![root]),
    }
}

/// A path of points as the case, or the piece of one, and what comes after it: `time/polyMesh/points`, or with a region in between.
pub(super) fn split(path: &Path) -> Option<(PathBuf, Vec<String>)> {
    let names: Vec<String> = path
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    let at = names.len().checked_sub(2)?;
    if names[at] != MESH {
        return None;
    }
    let is_time = |name: &String| name == CONSTANT || name.parse::<f64>().is_ok();
    let first = [at.checked_sub(1), at.checked_sub(2)];
    let first = first
        .into_iter()
        .flatten()
        .find(|&at| is_time(&names[at]))?;
    let case = path.iter().take(first).collect();
    Some((case, names[first..].to_vec()))
}

/// Names of times as the case says that is written or, before it has anything to say, that of the mesh.
fn time_names(case: &Path, mesh: &MeshView) -> Result<TimeNames> {
    let has_own = case.join("system").join("controlDict").is_file();
    match mesh.origin.get::<Topology>().filter(|_| !has_own) {
        Some(origin) => TimeNames::of_case(&origin.case),
        None => TimeNames::of_case(case),
    }
}

/// Whether all these files of a case have these hashes.
fn is_there(case: &Path, files: &BTreeMap<String, blake3::Hash>) -> bool {
    let is_same = |(name, hash): (&String, &blake3::Hash)| {
        hash_of(&case.join(name)).is_ok_and(|own| own == *hash)
    };
    files.iter().all(is_same)
}

/// The points in a folder of a mesh: from the case on, and as a path.
fn points_in(place: &Place, folder: &str) -> (String, PathBuf) {
    let name = format!("{folder}/points");
    let path = place.case.join(&name);
    (name, path)
}

/// Copies points that are there, since their folder is replaced as a whole.
fn keep_points(place: &Place, folder: &str, out: &mut OutputSet) -> Result<()> {
    let (name, path) = points_in(place, folder);
    let io = |error: io::Error| Error::io(&path, &error);
    let mut points = fs::File::open(&path).map_err(io)?;
    out.in_folder(&place.case, &name, |out| {
        io::copy(&mut points, out).map(|_| ()).map_err(io)
    })
}

/// A case that takes one mesh after another, as a whole.
pub(super) struct Sequence {
    folder: PathBuf,
    options: WriteOptions,
    times: Vec<f64>,
    names: TimeNames,
    /// Hash of the cells and groups of the first mesh.
    first: Option<blake3::Hash>,
    n_bytes: u64,
    notes: Notes,
}

impl Sequence {
    /// In an empty folder.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin) -> Result<Self> {
        if begin != Begin::Fill {
            return Err(Error::input("a case is not resumed mesh by mesh").file(path));
        }
        Ok(Self {
            folder: path.to_path_buf(),
            options: options.clone(),
            times: Vec::new(),
            names: TimeNames::default(),
            first: None,
            n_bytes: 0,
            notes: Notes::default(),
        })
    }

    /// Makes sure that a later mesh has the cells of the first.
    fn fix(&mut self, mesh: &MeshView) -> Result<bool> {
        let hash = super::topology::hash_of_cells(mesh.points.len(), mesh.cells);
        match self.first {
            None => self.first = Some(hash),
            Some(first) if first == hash => return Ok(false),
            Some(_) => {
                return Err(Error::input(format!(
                    "step {} has other nodes or cells than the first step; all times of an OpenFOAM case that is written \
                     have the same",
                    self.times.len()
                )));
            }
        }
        Ok(true)
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        check(mesh)?;
        let is_first = self.fix(mesh)?;
        self.times.push(time);
        let folders = self.names.folders(&self.times)?;
        let folder = &folders[folders.len() - 1];
        let place = Place {
            case: self.folder.clone(),
            ..Place::with(&self.folder, mesh, &self.options)
        };
        let mut out = OutputSet::new(
            &self.folder,
            Commit {
                replace: true,
                sync: false,
            },
        )
        .hashed();
        out.place_in(&self.folder, &[] as &[&str])?;
        if is_first {
            self.notes = topology(mesh, &mut out, &place, &self.options)?;
            points(mesh.points, &mut out, &place, CONSTANT, &self.options)?;
        }
        if !is_first || folder != CONSTANT {
            points(mesh.points, &mut out, &place, folder, &self.options)?;
        }
        let written = out.finish();
        self.n_bytes += written.n_bytes;
        let hash = written.hash.expect("it was asked for");
        written.files.keep()?;
        Ok(hash)
    }

    fn commit(&mut self) -> Result<()> {
        Ok(())
    }

    fn notes(&self) -> &Notes {
        &self.notes
    }

    fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    fn end(&mut self) -> Result<bool> {
        Ok(false)
    }

    fn is_resuming(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_a_step_tell_their_case_and_time() {
        let parts = |path: &str| {
            split(Path::new(path))
                .map(|(case, inside)| (case.display().to_string(), inside.join(" ")))
        };
        let found = |case: &str, inside: &str| Some((case.to_owned(), inside.to_owned()));
        assert_eq!(
            parts("c/azimesh/../0.1/polyMesh/points"),
            found("c/azimesh/..", "0.1 polyMesh points")
        );
        assert_eq!(
            parts("c/constant/solid/polyMesh/points"),
            found("c", "constant solid polyMesh points")
        );
        assert_eq!(
            parts("10/1e-05/polyMesh/points"),
            found("10", "1e-05 polyMesh points")
        );
        assert_eq!(parts("c/0.1/points"), None);
    }
}
