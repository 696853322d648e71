//! The folder of a sequence: names of its files, files of earlier runs in it, the time series.

use super::table;
use crate::preflight::existing_folder;
use crate::record::{Row, Rows, file_name, numbered, part_of, parts_in, step_of};
use azimesh_core::error::{Error, Result, counted};
use azimesh_deform::motion::Step;
use azimesh_io::formats::{
    self, Begin, Begun, CaseFormat, Commit, Format, Inputs, Notes, Staged, WriteOptions, case_name,
    folder_of, hash_of, pvd, vtk_series,
};
use azimesh_io::mesh::MeshView;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Names of the files of one sequence.
#[derive(Clone)]
pub struct Names {
    /// The folder.
    pub folder: PathBuf,
    stem: String,
    extension: &'static str,
    /// Ending of a list of meshes next to the `.pvd`.
    list_ending: Option<&'static str>,
    /// True if one file holds all steps.
    pub is_in_one: bool,
    n_steps: usize,
    /// The steps of a run that writes only some of them.
    part: Option<Range<usize>>,
    /// The case that contains the steps, if the format has cases.
    case: Option<Case>,
    /// Options for committing files under these names.
    pub commit: Commit,
    /// Files of base points that were passed to the run, which belong to no earlier run.
    pub given: Inputs,
    /// Hashes of the files next to the mesh of each step that are the same for all, by `*.` and their ending.
    pub companions: BTreeMap<String, String>,
    /// True if each step has a file of the moving surfaces.
    pub has_surfaces: bool,
    /// True if each step has displacements, which have a file of their own in a case.
    pub has_displacements: bool,
}

/// A case that holds the steps of a sequence, and the folder of [`Names`].
#[derive(Clone)]
struct Case {
    folder: PathBuf,
    /// File of each step, relative to the case; empty until [`Names::place_steps`].
    files: Vec<String>,
    /// Folder of the mesh that all steps share.
    shared: String,
}

impl Case {
    /// Returns the case that a folder is, or whose records are in it.
    fn of(folder: &Path) -> Self {
        let records = CaseFormat.records();
        let is_records = folder.file_name().is_some_and(|name| name == records)
            && !folder.join(records).exists()
            && has_records(folder);
        let above = folder.parent().filter(|_| is_records);
        Self {
            folder: above.unwrap_or(folder).to_path_buf(),
            files: Vec::new(),
            shared: String::new(),
        }
    }
}

/// Checks if runs have left records in a folder.
fn has_records(folder: &Path) -> bool {
    let is_there = |name: &str| folder.join(file_name(name, None, "json")).exists();
    is_there("run") || parts_in(folder, "run", "json").is_ok_and(|parts| !parts.is_empty())
}

impl Names {
    /// Creates the names for a mesh of this name, in a format, with this many steps.
    pub fn new(folder: &Path, mesh: &Path, format: &Format, n_steps: usize) -> Self {
        // "wing.b8.ugrid.gz" gives wing_0000.
        let name = mesh.file_name().filter(|name| *name != "-");
        let name = name.map_or("mesh".into(), |name| name.to_string_lossy());
        let stem = match case_name(&name) {
            case if case.len() < name.len() => case.into(),
            _ => (Path::new(&*name).file_stem().unwrap_or_default()).to_string_lossy(),
        };
        let case = format.case.map(|_| Case::of(folder));
        let records = case
            .as_ref()
            .map(|case| case.folder.join(CaseFormat.records()));
        Self {
            folder: records.unwrap_or_else(|| folder.to_path_buf()),
            // Lists of files are XML and lines of text.
            stem: stem.replace(char::is_control, "_"),
            extension: format.extensions[0],
            list_ending: format.list_ending,
            is_in_one: format.sequence.is_some() && case.is_none(),
            n_steps,
            part: None,
            case,
            commit: Commit::REPLACE,
            given: Inputs::default(),
            companions: BTreeMap::new(),
            has_surfaces: false,
            has_displacements: false,
        }
    }

    /// Returns the names of a part of this sequence.
    ///
    /// # Errors
    /// If the sequence does not have these steps.
    pub fn part(&self, steps: Range<usize>) -> Result<Self> {
        if steps.is_empty() || steps.end > self.n_steps {
            return Err(Error::input(format!(
                "--steps {}..{}: the schedule has {}; A..B needs A < B, and B no more than {}",
                steps.start,
                steps.end,
                counted(self.n_steps, "step"),
                self.n_steps
            )));
        }
        Ok(Self {
            part: Some(steps),
            ..self.clone()
        })
    }

    /// Returns the least number of digits of a step in a name.
    fn digits(&self) -> usize {
        self.n_steps.saturating_sub(1).to_string().len().max(4)
    }

    /// Returns the name of the file that holds the mesh of a step.
    pub fn mesh(&self, step: usize) -> String {
        match self.in_case(step) {
            Some((_, file)) => format!("../{file}"),
            None if self.is_in_one => self.of_part(&self.stem, self.extension),
            None => numbered(&self.stem, step, self.digits(), self.extension),
        }
    }

    /// Returns the name of the file of the moving surfaces at a step: SU2 expects five digits.
    pub fn surface(&self, step: usize) -> String {
        numbered(&self.surface_stem(), step, 5, "dat")
    }

    fn surface_stem(&self) -> String {
        format!("{}_surface", self.stem)
    }

    /// Finds the files of the steps in a case; no effect for other formats.
    ///
    /// # Errors
    /// If the case cannot take the sequence of this mesh.
    pub fn place_steps(&mut self, mesh: &MeshView, steps: &[Step]) -> Result<()> {
        let Some(case) = &mut self.case else {
            return Ok(());
        };
        CaseFormat.check(&case.folder, mesh)?;
        let times: Vec<f64> = steps.iter().map(Step::time).collect();
        case.files = CaseFormat.step_files(&case.folder, mesh, &times)?;
        case.shared = CaseFormat.shared(mesh);
        Ok(())
    }

    /// Returns the case that has the meshes, and the file of a step in it.
    pub(super) fn in_case(&self, step: usize) -> Option<(&Path, &str)> {
        let case = self.case.as_ref()?;
        Some((&case.folder, case.files.get(step)?))
    }

    /// Checks if the steps are in a case.
    pub(super) fn has_case(&self) -> bool {
        self.case.is_some()
    }

    /// Checks if the mesh of a step is the one that all steps of a case share.
    pub(super) fn is_shared(&self, step: usize) -> bool {
        (self.in_case(step)).is_some_and(|(_, file)| CaseFormat.is_shared(file))
    }

    /// Checks if a mesh on the disk has the hash of its row.
    pub(super) fn has_hash(&self, path: &Path, hash: &str) -> std::io::Result<bool> {
        match self.case {
            Some(_) => CaseFormat.has_hash(path, hash),
            None => Ok(hash_of(path)?.to_string() == hash),
        }
    }

    /// Finds the first of some files that is missing or has another hash. `*.mapbc` is the file with that ending next to the
    /// mesh of each row.
    pub(super) fn changed<'a>(
        &self,
        files: impl IntoIterator<Item = (&'a String, &'a String)>,
        rows: impl IntoIterator<Item = &'a Row> + Clone,
    ) -> Option<PathBuf> {
        files.into_iter().find_map(|(name, hash)| {
            let paths = match (name.strip_prefix("*."), name.strip_prefix("../")) {
                (Some(ending), _) => {
                    let rows = rows.clone().into_iter();
                    rows.map(|row| companion(&self.path(&row.file), ending))
                        .collect()
                }
                (None, Some(inside)) => vec![folder_of(&self.folder).join(inside)],
                (None, None) => vec![self.path(name)],
            };
            let is_changed =
                |path: &PathBuf| !hash_of(path).is_ok_and(|own| own.to_string() == *hash);
            paths.into_iter().find(is_changed)
        })
    }

    /// Stages the data that all steps share, if they are in a case.
    pub(super) fn begin(
        &self,
        mesh: &MeshView,
        options: &WriteOptions,
        begin: Begin,
    ) -> Result<Begun> {
        let Some(case) = &self.case else {
            return Ok(Begun {
                notes: Notes::default(),
                files: BTreeMap::new(),
                staged: Staged::all(Vec::new()),
            });
        };
        // Parts are added to a case in any order.
        let begin = if self.is_part() { Begin::Resume } else { begin };
        CaseFormat.begin(&case.folder, mesh, options, begin, self.commit)
    }

    /// Returns the path of the time series over files; `None` if one file is the series itself, and for a part.
    pub fn series(&self) -> Option<PathBuf> {
        let wanted = !self.is_in_one && self.case.is_none() && !self.is_part();
        wanted.then(|| self.path(&format!("{}.pvd", self.stem)))
    }

    /// Refuses a mesh whose name leads to file names that the file system does not accept.
    ///
    /// # Errors
    /// Of kind `Input`, with the path.
    pub fn check_lengths(&self) -> Result<()> {
        let first = self.steps().start;
        let lists = self.series().into_iter().flat_map(|series| {
            let list = self.list_ending.map(|ending| series.with_extension(ending));
            std::iter::once(series).chain(list)
        });
        let surface = self.has_surfaces.then(|| self.surface(first));
        let files = std::iter::once(self.mesh(first)).chain(surface);
        let there = existing_folder(&self.folder);
        for path in files.map(|name| self.path(&name)).chain(lists) {
            let name = path.file_name().unwrap_or_default();
            // Names are not checked for a path through a folder that does not exist yet.
            for path in [&path, &there.join(name)] {
                match std::fs::symlink_metadata(path) {
                    Err(error) if error.kind() == ErrorKind::InvalidFilename => {
                        return Err(Error::io(path, &error));
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Returns the path of a file of the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Returns a path as seen from the folder, or from the case.
    pub(super) fn shown<'a>(&self, path: &'a Path) -> &'a Path {
        let folder = self.case.as_ref().map_or(&self.folder, |case| &case.folder);
        path.strip_prefix(folder).unwrap_or(path)
    }

    /// Returns the steps that this run writes.
    pub fn steps(&self) -> Range<usize> {
        self.part.clone().unwrap_or(0..self.n_steps)
    }

    /// Returns the number of steps of the sequence.
    pub fn all_steps(&self) -> usize {
        self.n_steps
    }

    /// Checks if it writes only some of the steps.
    pub fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// Returns the path of the table of steps.
    pub fn table(&self) -> PathBuf {
        self.path(&self.of_part("steps", "csv"))
    }

    /// Returns the path of the record of the run.
    pub fn record(&self) -> PathBuf {
        self.path(&self.of_part("run", "json"))
    }

    /// Returns the path of the base points; if they are selected several times, of the selection at a step.
    pub fn base(&self, step: Option<usize>) -> PathBuf {
        self.path(&match step {
            None => file_name("base", None, "toml"),
            Some(step) => numbered("base", step, self.digits(), "toml"),
        })
    }

    fn of_part(&self, stem: &str, extension: &str) -> String {
        file_name(stem, self.part.as_ref(), extension)
    }

    /// Checks if a file belongs to a sequence of this name; for a part, whether this part writes it.
    fn is_ours(&self, name: &str) -> bool {
        let mut companions = self.companion_endings();
        let step = step_of(name, &self.stem, self.extension)
            .or_else(|| companions.find_map(|ending| step_of(name, &self.stem, ending)))
            .or_else(|| step_of(name, &self.surface_stem(), "dat"));
        if let Some(step) = step {
            return !self.is_part() || self.steps().contains(&step);
        }
        // A whole sequence also owns the files of parts.
        let is_one = |stem: &str, extension: &str| {
            name == self.of_part(stem, extension)
                || !self.is_part() && part_of(name, stem, extension).is_some()
        };
        is_one("steps", "csv")
            || is_one("run", "json")
            || self.is_in_one && is_one(&self.stem, self.extension)
            || !self.is_part()
                && (name == format!("{}.pvd", self.stem)
                    || name == format!("{}.vtk.series", self.stem)
                    || is_base(name))
    }

    /// Returns the endings of the files next to the mesh of each step.
    fn companion_endings(&self) -> impl Iterator<Item = &str> {
        let names = self.companions.keys();
        names.filter_map(|name| name.strip_prefix("*."))
    }

    /// Returns the files of a step that are there, of this run or not; in a case all that are in the folder of its mesh.
    pub(super) fn files_of_step(&self, step: usize) -> Vec<PathBuf> {
        let mut found = match self.in_case(step) {
            // The mesh that all steps share belongs to no step.
            Some((_, file)) if CaseFormat.is_shared(file) => Vec::new(),
            Some((case, file)) => CaseFormat.files_at(&case.join(file), self.has_displacements),
            None if self.is_in_one => Vec::new(),
            None => {
                let mesh = self.path(&self.mesh(step));
                let endings = self.companion_endings();
                let mut files: Vec<_> = endings.map(|ending| companion(&mesh, ending)).collect();
                files.push(mesh);
                files
            }
        };
        found.extend(self.has_surfaces.then(|| self.path(&self.surface(step))));
        found.retain(|path| path.symlink_metadata().is_ok());
        found
    }

    /// Returns the files that parts share and that are there: base points, and the mesh of a case.
    pub(super) fn shared_files(&self) -> Vec<PathBuf> {
        let mut found = files(self, is_base);
        found.retain(|path| self.given.find(path).is_none());
        if let Some(case) = &self.case {
            let shared = case.folder.join(&case.shared);
            let is_there = !case.shared.is_empty() && shared.exists();
            found.extend(is_there.then_some(shared));
        }
        found
    }

    /// Checks if there are parts in the folder of a whole sequence.
    pub(super) fn has_parts(&self) -> bool {
        !self.is_part() && parts_in(&self.folder, "run", "json").is_ok_and(|all| !all.is_empty())
    }
}

/// Returns the file with another ending next to a mesh, whose own ending may have dots.
fn companion(mesh: &Path, ending: &str) -> PathBuf {
    let name = mesh.file_name().unwrap_or_default().to_string_lossy();
    mesh.with_file_name(format!("{}.{ending}", case_name(&name)))
}

/// Checks if a file holds base points.
fn is_base(name: &str) -> bool {
    ["toml", "vtp"].iter().any(|extension| {
        name == file_name("base", None, extension) || step_of(name, "base", extension).is_some()
    })
}

/// Returns files of an earlier run in the folder.
pub fn existing_outputs(names: &Names) -> Vec<PathBuf> {
    let mut found = files(names, |name| names.is_ours(name));
    found.retain(|path| names.given.find(path).is_none());
    if names.case.is_some() {
        // A part owns only its own steps; other parts share the rest of the case.
        let shared = names.shared_files().into_iter();
        found.extend(shared.filter(|path| !names.is_part() && path.is_dir()));
        found.extend(steps_in_case(names));
        found.extend(names.steps().flat_map(|step| names.files_of_step(step)));
        found.sort();
        found.dedup();
    }
    found
}

/// Returns the files of the steps in a case that the tables of earlier runs name.
fn steps_in_case(names: &Names) -> impl Iterator<Item = PathBuf> {
    let parts = parts_in(&names.folder, "steps", "csv").unwrap_or_default();
    let parts = parts.into_iter().filter(|_| !names.is_part());
    let tables = std::iter::once(names.table()).chain(parts.map(|(_, path)| path));
    let rows = tables.filter_map(|table| table::read(&table).ok());
    let rows = rows.flat_map(Rows::into_values);
    // The mesh that all steps share belongs to no step.
    let own = rows.filter(|row| !CaseFormat.is_shared(row.file.trim_start_matches("../")));
    let case = names
        .case
        .as_ref()
        .map_or(&names.folder, |case| &case.folder);
    own.flat_map(|row| CaseFormat.files_of(&case.join(row.file.trim_start_matches("../"))))
}

pub(super) fn files(names: &Names, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(&names.folder).into_iter().flatten();
    let named = entries
        .flatten()
        .filter(|entry| wanted(&entry.file_name().to_string_lossy()));
    let mut found: Vec<PathBuf> = named.map(|entry| entry.path()).collect();
    found.sort();
    found
}

/// Returns the bytes of a file, or of all files in a folder; 0 if they cannot be read.
pub(super) fn bytes_of(path: &Path) -> u64 {
    let Ok(found) = std::fs::symlink_metadata(path) else {
        return 0;
    };
    if !found.is_dir() {
        return found.len();
    }
    let inside = std::fs::read_dir(path).into_iter().flatten().flatten();
    inside.map(|entry| bytes_of(&entry.path())).sum()
}

/// Refuses a folder that holds files of an earlier run.
pub fn refuse_existing(names: &Names) -> Result<()> {
    let existing = existing_outputs(names);
    let Some(first) = existing.first() else {
        return Ok(());
    };
    Err(Error::input(format!(
        "holds {} of an earlier run or another program, such as {}; --resume continues an earlier run, --force replaces the \
         files, and another folder keeps them",
        counted(existing.len(), "file"),
        names.shown(first).display()
    ))
    .file(&names.folder))
}

/// Refuses a folder in which a file of this run is a pipe or a device.
pub(super) fn refuse_special(names: &Names) -> Result<()> {
    let outputs = existing_outputs(names).into_iter();
    let mut all = outputs.chain(files(names, is_base));
    all.try_for_each(|path| formats::refuse_special(&path))
}

/// Refuses a folder in which an input has the name of a file of the sequence, which this run or `finish` would replace.
pub fn refuse_inputs(names: &Names, inputs: &Inputs) -> Result<()> {
    let whole = Names {
        part: None,
        ..names.clone()
    };
    let mut outputs = existing_outputs(&whole);
    for folder in outputs.clone().iter().filter(|path| path.is_dir()) {
        let inside = formats::files_in(folder).unwrap_or_default();
        outputs.extend(inside.iter().map(|name| folder.join(name)));
    }
    outputs.iter().try_for_each(|path| inputs.refuse(path))
}

/// Removes every file of an earlier run.
pub fn remove_existing(names: &Names) -> Result<()> {
    for path in existing_outputs(names) {
        let removed = if names.case.is_some() && path.is_dir() {
            std::fs::remove_dir_all(&path)
        } else {
            std::fs::remove_file(&path)
        };
        removed.map_err(|error| Error::io(&path, &error))?;
        // Folders of times of a case are removed with their files; other empty folders never hold a mesh.
        let above = path.ancestors().skip(1).take(3);
        let above = above.filter(|above| names.case.is_some() && !names.folder.starts_with(above));
        let _ = above
            .map(std::fs::remove_dir)
            .all(|removed| removed.is_ok());
    }
    Ok(())
}

/// Writes lists of the finished steps for ParaView, with their paths: time in s if it is known, else azimuth. Legacy VTK
/// files have their own list in addition to the .pvd.
pub(super) fn series(names: &Names, rows: &Rows) -> Vec<(PathBuf, String)> {
    let entries = || rows.values().map(|row| (time(row), row.file.as_str()));
    let Some(path) = names.series().filter(|_| !rows.is_empty()) else {
        return Vec::new();
    };
    let mut lists = vec![(path, pvd(entries()))];
    let list = names.list_ending.map(|ending| {
        let path = names.path(&format!("{}.{ending}", names.stem));
        (path, vtk_series(entries()))
    });
    lists.extend(list);
    lists
}

/// Returns the time of a step in a time series.
pub(super) fn time(row: &Row) -> f64 {
    row.time_s.or(row.azimuth_deg).unwrap_or(row.step as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_named_without_its_endings() {
        let vtu = azimesh_io::formats::by_name("vtu").expect("it is known");
        let name = |mesh: &str, n| Names::new(Path::new("d"), Path::new(mesh), vtu, n).mesh(7);
        assert_eq!(name("a/wing.su2.gz", 10), "wing_0007.vtu");
        assert_eq!(name("wing.v2.msh", 20_000), "wing.v2_00007.vtu");
        assert_eq!(name("-", 1), "mesh_0007.vtu");
    }

    fn names(steps: Option<Range<usize>>, format: &str) -> Names {
        let format = azimesh_io::formats::by_name(format).expect("it is known");
        let names = Names::new(Path::new("d"), Path::new("wing.su2"), format, 10);
        match steps {
            Some(steps) => names.part(steps).expect("there are ten steps"),
            None => names,
        }
    }

    #[test]
    fn one_file_of_all_steps_is_named_after_the_mesh_and_the_part() {
        let (all, some) = (names(None, "vtkhdf"), names(Some(2..4), "vtkhdf"));
        assert_eq!(all.mesh(7), "wing.vtkhdf");
        assert_eq!(some.mesh(3), "wing_2-4.vtkhdf");
        assert!(all.is_ours("wing.vtkhdf") && all.is_ours("wing_2-4.vtkhdf"));
        assert!(!all.is_ours("wing_two.vtkhdf") && !all.is_ours("wing.vtkhdf.old"));
        assert!(some.is_ours("wing_2-4.vtkhdf") && !some.is_ours("wing.vtkhdf"));
        assert_eq!((all.series(), some.series()), (None, None));
        assert!(names(None, "vtu").series().is_some());
    }
}
