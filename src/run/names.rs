//! The folder of a sequence: names of its files, what an earlier run left in it, the time series.

use super::case::{Case, steps_in_case};
use crate::preflight::existing_folder;
use crate::record::{Row, Rows, file_name, numbered, part_of, step_of};
use azimesh_core::error::{Error, Result, counted};
use azimesh_deform::motion::Step;
use azimesh_io::formats::{
    self, Begin, Begun, CaseFormat, Commit, Format, Inputs, Notes, Staged, WriteOptions, case_name,
    hash_of, pvd, vtk_series,
};
use azimesh_io::mesh::MeshView;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The steps that a run writes: all, or one part of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunSteps {
    steps: Range<usize>,
    whole: bool,
}

impl RunSteps {
    /// The part of a sequence of `n_steps` that was asked for; all of it when none was.
    pub fn new(steps: Option<Range<usize>>, n_steps: usize) -> Result<Self> {
        let whole = steps.is_none();
        let steps = steps.unwrap_or(0..n_steps);
        if steps.is_empty() || steps.end > n_steps {
            return Err(Error::input(format!(
                "--steps {}..{}: the schedule has {}; A..B needs A < B, and B no more than {n_steps}",
                steps.start,
                steps.end,
                counted(n_steps, "step")
            )));
        }
        Ok(Self { steps, whole })
    }
}

/// Names of the files of one sequence.
#[derive(Debug, Clone)]
pub struct Names {
    /// The folder.
    pub folder: PathBuf,
    stem: String,
    extension: &'static str,
    /// Ending of a list of meshes beside the `.pvd`.
    list_ending: Option<&'static str>,
    /// Whether one file holds all steps.
    in_one: bool,
    digits: usize,
    part: RunSteps,
    /// The case that the steps are in, where the format has that.
    case: Option<Case>,
    /// How files take these names.
    pub commit: Commit,
    /// Files of base points that the run was given, which are of no earlier run.
    pub given: Inputs,
}

/// A step in a case.
pub(super) struct StepInCase<'a> {
    pub folder: &'a Path,
    pub format: CaseFormat,
    pub file: &'a str,
}

impl Names {
    /// For a mesh of this name, in a format, with so many steps.
    pub fn new(
        folder: &Path,
        mesh: &Path,
        format: &Format,
        n_steps: usize,
        part: RunSteps,
    ) -> Self {
        // "wing.b8.ugrid.gz" gives wing_0000.
        let name = mesh.file_name().filter(|name| *name != "-");
        let name = name.map_or("mesh".into(), |name| name.to_string_lossy());
        let stem = match case_name(&name) {
            case if case.len() < name.len() => case.to_owned(),
            _ => {
                let stem = Path::new(&*name).file_stem().unwrap_or_default();
                stem.to_string_lossy().into_owned()
            }
        };
        // Lists of files are XML and lines of text.
        let stem = stem.replace(char::is_control, "_");
        let case = format.case.map(|case| Case::of(case, folder));
        let folder = case
            .as_ref()
            .map_or_else(|| folder.to_path_buf(), Case::records);
        Self {
            folder,
            stem,
            extension: format.extensions[0],
            list_ending: format.list_ending,
            in_one: format.sequence.is_some() && case.is_none(),
            case,
            digits: n_steps.saturating_sub(1).to_string().len().max(4),
            part,
            commit: Commit::REPLACE,
            given: Inputs::default(),
        }
    }

    /// Name of the file that holds the mesh of a step.
    pub fn mesh(&self, step: usize) -> String {
        let file = self.case.as_ref().and_then(|case| case.files.get(step));
        match file {
            Some(file) => format!("../{file}"),
            None if self.in_one => self.of_part(&self.stem, self.extension),
            None => numbered(&self.stem, step, self.digits, self.extension),
        }
    }

    /// Name of the file that holds the moving surfaces at a step: SU2 looks for five digits.
    pub fn surface(&self, step: usize) -> String {
        numbered(&self.surface_stem(), step, 5, "dat")
    }

    fn surface_stem(&self) -> String {
        format!("{}_surface", self.stem)
    }

    /// Finds the files of the steps in a case; nothing for other formats.
    ///
    /// # Errors
    /// Where the case cannot take the sequence of this mesh.
    pub fn place_steps(&mut self, mesh: &MeshView, steps: &[Step]) -> Result<()> {
        let Some(case) = &mut self.case else {
            return Ok(());
        };
        case.format.check(&case.folder, mesh)?;
        let times: Vec<f64> = steps.iter().map(Step::time).collect();
        case.files = case.format.step_files(&case.folder, mesh, &times)?;
        case.shared = case.format.shared(mesh);
        Ok(())
    }

    /// The file of a step in the case that has the meshes.
    pub(super) fn in_case(&self, step: usize) -> Option<StepInCase<'_>> {
        let case = self.case.as_ref()?;
        Some(StepInCase {
            folder: &case.folder,
            format: case.format,
            file: case.files.get(step)?,
        })
    }

    /// Whether a mesh on the disk has the hash of its row.
    pub(super) fn has_hash(&self, path: &Path, hash: &str) -> std::io::Result<bool> {
        match &self.case {
            Some(case) => case.format.has_hash(path, hash),
            None => Ok(hash_of(path)?.to_string() == hash),
        }
    }

    /// Stages what all steps share, where they are in a case.
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
        // Parts come to a case in any order.
        let begin = if self.is_part() { Begin::Resume } else { begin };
        case.format
            .begin(&case.folder, mesh, options, begin, self.commit)
    }

    /// Whether one file holds all steps.
    pub fn is_in_one(&self) -> bool {
        self.in_one
    }

    /// Names of another part of this sequence.
    pub fn part(&self, part: RunSteps) -> Self {
        Self {
            part,
            ..self.clone()
        }
    }

    /// Path of the time series over files; `None` where one file is that itself, and for a part.
    pub fn series(&self) -> Option<PathBuf> {
        let wanted = !self.in_one && self.case.is_none() && !self.is_part();
        wanted.then(|| self.folder.join(format!("{}.pvd", self.stem)))
    }

    /// Refuses a mesh whose name makes names of files that the file system does not take.
    ///
    /// # Errors
    /// Of kind `Input`, with the path.
    pub fn check_lengths(&self, has_surfaces: bool) -> Result<()> {
        let first = self.part.steps.start;
        let lists = self.series().into_iter().flat_map(|series| {
            let list = self.list_ending.map(|ending| series.with_extension(ending));
            std::iter::once(series).chain(list)
        });
        let surface = has_surfaces.then(|| self.surface(first));
        let files = std::iter::once(self.mesh(first)).chain(surface);
        let there = existing_folder(&self.folder);
        for path in files.map(|name| self.path(&name)).chain(lists) {
            let name = path.file_name().unwrap_or_default();
            // Of a path through a folder that is not there yet, names are not looked at.
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

    /// Path of a file of the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The steps that this run writes.
    pub fn steps(&self) -> Range<usize> {
        self.part.steps.clone()
    }

    /// Whether it writes some of the steps only.
    pub fn is_part(&self) -> bool {
        !self.part.whole
    }

    /// Path of the table of steps.
    pub fn table(&self) -> PathBuf {
        self.path(&self.of_part("steps", "csv"))
    }

    /// Path of the record of the run.
    pub fn record(&self) -> PathBuf {
        self.path(&self.of_part("run", "json"))
    }

    /// Path of the base points; of those chosen at a step where there are several choices.
    pub fn base(&self, step: Option<usize>) -> PathBuf {
        self.path(&match step {
            None => file_name("base", None, "toml"),
            Some(step) => numbered("base", step, self.digits, "toml"),
        })
    }

    fn of_part(&self, stem: &str, extension: &str) -> String {
        let part = self.is_part().then_some(&self.part.steps);
        file_name(stem, part, extension)
    }

    /// Whether a file belongs to a sequence of this name; for a part, whether this part writes it.
    fn is_ours(&self, name: &str) -> bool {
        let mesh = step_of(name, &self.stem, self.extension)
            .or_else(|| step_of(name, &self.surface_stem(), "dat"));
        if self.is_part() {
            return mesh.is_some_and(|step| self.part.steps.contains(&step))
                || self.in_one && name == self.mesh(self.part.steps.start)
                || name == self.of_part("steps", "csv")
                || name == self.of_part("run", "json");
        }
        let of_any_part = |stem: &str, extension: &str| {
            name == file_name(stem, None, extension) || part_of(name, stem, extension).is_some()
        };
        mesh.is_some()
            || self.in_one && of_any_part(&self.stem, self.extension)
            || name == format!("{}.pvd", self.stem)
            || name == format!("{}.vtk.series", self.stem)
            || of_any_part("steps", "csv")
            || of_any_part("run", "json")
            || is_base(name)
    }
}

/// Whether a file holds base points.
fn is_base(name: &str) -> bool {
    let of_any_choice = |extension: &str| {
        name == file_name("base", None, extension) || step_of(name, "base", extension).is_some()
    };
    of_any_choice("toml") || of_any_choice("vtp")
}

/// Files of an earlier run that stand in the folder.
pub fn existing_outputs(names: &Names) -> Vec<PathBuf> {
    let mut found = files(names, |name| names.is_ours(name));
    found.retain(|path| names.given.find(path).is_none());
    if let Some(case) = &names.case {
        // A part minds its own steps; the others share the rest of the case with it.
        let shared = case.folder.join(&case.shared);
        let is_there = !names.is_part() && !case.shared.is_empty() && shared.exists();
        found.extend(is_there.then_some(shared));
        found.extend(steps_in_case(names, case));
    }
    found
}

pub(super) fn files(names: &Names, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(&names.folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.file_name()
                .is_some_and(|n| wanted(&n.to_string_lossy()))
        })
        .collect();
    found.sort();
    found
}

/// Bytes of the files of an earlier run.
pub fn bytes_of_existing(names: &Names) -> u64 {
    existing_outputs(names)
        .iter()
        .map(|path| bytes_of(path))
        .sum()
}

/// Bytes of a file, or of all files in a folder; 0 for what cannot be read.
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
        "holds {} of an earlier run, such as {}; --resume continues that run, --force replaces it",
        counted(existing.len(), "file"),
        first.file_name().unwrap_or_default().display()
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
    let whole = names.part(RunSteps {
        steps: names.steps(),
        whole: true,
    });
    let outputs = existing_outputs(&whole);
    outputs.iter().try_for_each(|path| inputs.refuse(path))
}

/// Removes every file of an earlier run.
pub fn remove_existing(names: &Names) -> Result<()> {
    existing_outputs(names).iter().try_for_each(|path| {
        let removed = if names.case.is_some() && path.is_dir() {
            std::fs::remove_dir_all(path)
        } else {
            std::fs::remove_file(path)
        };
        removed.map_err(|error| Error::io(path, &error))?;
        // Folders of times of a case go with what was in them; others that are empty never hold a mesh.
        if names.case.is_some() {
            let above = path
                .ancestors()
                .skip(1)
                .take(3)
                .filter(|above| !names.folder.starts_with(above));
            let _ = above
                .map(std::fs::remove_dir)
                .take_while(|removed| removed.is_ok())
                .count();
        }
        Ok(())
    })
}

/// Lists of the finished steps for ParaView, with their paths: time in s where it is known, else
/// azimuth. Legacy VTK files have a list of their own besides the .pvd.
pub(super) fn series(names: &Names, rows: &Rows) -> Vec<(PathBuf, String)> {
    let entries = || rows.values().map(|row| (time(row), row.file.as_str()));
    let Some(path) = names.series().filter(|_| !rows.is_empty()) else {
        return Vec::new();
    };
    let mut lists = vec![(path, pvd(entries()))];
    if let Some(ending) = names.list_ending {
        let path = names.path(&format!("{}.{ending}", names.stem));
        lists.push((path, vtk_series(entries())));
    }
    lists
}

/// The time that a step has in a time series.
pub(super) fn time(row: &Row) -> f64 {
    row.time_s.or(row.azimuth_deg).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_named_without_its_endings() {
        let vtu = azimesh_io::formats::by_name("vtu").expect("it is known");
        let name = |mesh: &str, n| {
            let part = RunSteps::new(None, n).expect("all of it");
            Names::new(Path::new("d"), Path::new(mesh), vtu, n, part).mesh(7)
        };
        assert_eq!(name("a/wing.su2.gz", 10), "wing_0007.vtu");
        assert_eq!(name("wing.v2.msh", 20_000), "wing.v2_00007.vtu");
        assert_eq!(name("-", 1), "mesh_0007.vtu");
    }

    #[test]
    fn bytes_of_an_earlier_run_are_those_of_its_files() {
        let folder = tempfile::tempdir().expect("a folder");
        for (path, n) in [("wing_0000.vtu", 7), ("wing_0001.vtu", 30)] {
            std::fs::write(folder.path().join(path), vec![0; n]).expect("it can be written");
        }
        std::fs::write(folder.path().join("steps.csv"), "12345").expect("it can be written");
        std::fs::write(folder.path().join("another"), "12345").expect("it can be written");
        let names = Names {
            folder: folder.path().to_owned(),
            ..names(None, "vtu")
        };
        assert_eq!(bytes_of_existing(&names), 42);
    }

    fn names(steps: Option<Range<usize>>, format: &str) -> Names {
        let format = azimesh_io::formats::by_name(format).expect("it is known");
        let part = RunSteps::new(steps, 10).expect("there are ten steps");
        Names::new(Path::new("d"), Path::new("wing.su2"), format, 10, part)
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
