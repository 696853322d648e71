//! The input of a command: a mesh, or the meshes of a sequence one after another.

use super::Context;
use super::unfinished::{is_of_run, unfinished};
use crate::alloc::limit;
use azimesh_core::error::{Error, Position, Result, counted};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_deform::motion::Schedule;
use azimesh_io::formats::{
    self, Format, Listed, Loaded, Location, ReadOptions, Shared, SharedFile,
};
use azimesh_io::mesh::Mesh;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Opening meshes with the common options.
impl Context {
    /// Reads a mesh.
    pub fn read_mesh(&self, path: &Path) -> Result<Mesh> {
        let loaded = self.reading(path, || {
            self.read_location(&self.open(path)?, &self.read_options())
        })?;
        Ok(self.with_notes(loaded, path))
    }

    fn read_location(&self, location: &Location, options: &ReadOptions) -> Result<Loaded> {
        formats::read_as(self.format_of_input(location)?, location, options)
    }

    /// Returns the format of the option, or of the content.
    fn format_of_input(&self, location: &Location) -> Result<&'static Format> {
        self.input_format()?
            .map_or_else(|| formats::of(location), Ok)
    }

    /// Returns the format of meshes that are read, if an option gives it.
    pub fn input_format(&self) -> Result<Option<&'static Format>> {
        let name = self.common.input_format.as_deref();
        name.map(formats::by_name).transpose()
    }

    /// Reads a motion schedule; reports a mesh that is passed instead.
    pub fn read_schedule(&self, path: &Path) -> Result<Schedule> {
        Schedule::read(path).map_err(|error| {
            let is_toml = path.extension().is_some_and(|kind| kind == "toml");
            let location = (!is_toml && path.exists()).then(|| self.open(path).ok());
            match location.flatten().as_ref().and_then(formats::recognize) {
                Some(format) => Error::input(format!(
                    "the schedule is a mesh, {}; the first argument is the mesh, the second the schedule (TOML)",
                    format.title
                ))
                .file(path),
                None => error,
            }
        })
    }

    /// Prints the reader's notes on the mesh of a path, and returns the mesh.
    pub fn with_notes(&self, loaded: Loaded, path: &Path) -> Mesh {
        for note in loaded.notes.iter() {
            self.note(note.clone().file(path));
        }
        loaded.mesh
    }

    /// Opens an input; its uncompressed content, or a pipe's, may use the memory that `--max-memory` allows.
    pub fn open(&self, path: &Path) -> Result<Location> {
        limit::set_stage("reading", Some(path));
        Location::open_within(path, self.common.max_memory)
    }

    /// Reads, as a stage.
    pub fn reading<T>(&self, path: &Path, read: impl FnOnce() -> Result<T>) -> Result<T> {
        self.stage("reading", || {
            limit::set_stage("reading", Some(path));
            read()
        })
    }

    /// Returns the options of readers.
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            tag_array: self.common.tag_array.clone(),
            step: None,
        }
    }
}

/// One input, opened.
pub struct Input {
    path: PathBuf,
    meshes: Meshes,
}

enum Meshes {
    /// A file or folder with one mesh, or with a sequence.
    File {
        location: Location,
        format: &'static Format,
        times: Vec<f64>,
    },
    /// A list of files with their times.
    Listed(Vec<Listed>),
    /// Inputs of which each step is one mesh.
    Merged(Vec<Input>),
    /// An input that another rank has opened, with its times.
    Elsewhere(Option<Vec<f64>>),
}

impl Input {
    /// Opens a mesh file, a list of mesh files, or the sequence of a folder.
    pub fn open(path: &Path, context: &Context) -> Result<Self> {
        let meshes = if formats::is_series(path) && !path.is_dir() {
            let list = formats::read_series(path)?;
            formats::note_inputs(list.iter().map(|entry| &entry.path));
            Meshes::Listed(list)
        } else {
            let location = context.open(path)?;
            if location.file().is_err() && formats::recognize(&location).is_none() {
                return Self::of_folder(path, context);
            }
            let format = context.format_of_input(&location)?;
            let times = format.steps(&location).map_err(|error| error.file(path))?;
            Meshes::File {
                location,
                format,
                times,
            }
        };
        Ok(Self {
            path: path.to_path_buf(),
            meshes,
        })
    }

    /// Like [`open`](Self::open), on the first rank only: the others receive the content type.
    pub fn open_shared(path: &Path, context: &Context) -> Result<Self> {
        let opened = if context.ranks.is_first() {
            Some(Self::open(path, context)).transpose()
        } else {
            Ok(None)
        };
        let opened = context.ranks.all_ok(opened)?;
        let times = context.ranks.broadcast(opened.as_ref().map(Self::times));
        Ok(opened.unwrap_or_else(|| Self {
            path: path.to_path_buf(),
            meshes: Meshes::Elsewhere(times),
        }))
    }

    /// Opens an input, or each mesh and sequence of a folder that is no mesh itself and no folder of a run.
    pub fn open_all(path: &Path, context: &Context) -> Vec<Result<Self>> {
        let is_group = path.is_dir()
            && !is_of_run(path)
            && context
                .open(path)
                .is_ok_and(|location| formats::recognize(&location).is_none());
        let members = if is_group {
            members(path)
        } else {
            Ok(Vec::new())
        };
        match members {
            Ok(members) if members.is_empty() => vec![Self::open(path, context)],
            Ok(members) => members
                .iter()
                .map(|member| Self::open(member, context))
                .collect(),
            Err(error) => vec![Err(error)],
        }
    }

    /// Opens the sequence of a folder; reports how to continue a run that is not finished.
    fn of_folder(path: &Path, context: &Context) -> Result<Self> {
        let unfinished = unfinished(path);
        match (sequence_in(path), unfinished) {
            (Ok(sequence), None) => Self::open(&sequence, context),
            (Ok(sequence), Some(how)) => {
                let input = Self::open(&sequence, context)?;
                context.note(how.file(path));
                Ok(input)
            }
            (Err(_), Some(how)) => Err(Error::input(how.text).file(path)),
            (Err(error), None) => Err(error),
        }
    }

    /// Opens files that are the meshes of one sequence, in order; their times are 0, 1, 2, ...
    pub fn of_parts(paths: &[PathBuf]) -> Result<Self> {
        if let Some(list) = paths.iter().find(|path| formats::is_series(path)) {
            return Err(
                Error::input("a list of meshes cannot be one step of a sequence").file(list),
            );
        }
        let part = |(i, path): (usize, &PathBuf)| Listed {
            time: i as f64,
            path: path.clone(),
            line: None,
        };
        Ok(Self {
            path: paths[0].clone(),
            meshes: Meshes::Listed(paths.iter().enumerate().map(part).collect()),
        })
    }

    /// Opens inputs that are merged, step by step, or of which one step is merged.
    pub fn merged(paths: &[PathBuf], step: Option<usize>, context: &Context) -> Result<Self> {
        if paths.len() < 2 {
            return Err(Error::input("--merge is for two meshes or more"));
        }
        let opened = paths.iter().map(|path| Self::open(path, context));
        let parts = opened.collect::<Result<Vec<_>>>()?;
        let sequences = parts.iter().filter_map(|part| Some((part, part.times()?)));
        let sequences: Vec<_> = sequences.collect();
        for (part, times) in &sequences {
            let (first, of_first) = &sequences[0];
            match (step, difference(times, of_first)) {
                (Some(_), _) => part.check_step(step)?,
                (None, None) => {}
                (None, Some([own, its])) => {
                    return Err(Error::input(format!(
                        "{own}, {its} in {}; merged sequences have the same times (--step I merges one step of each)",
                        first.path.display()
                    ))
                    .file(&part.path));
                }
            }
        }
        Ok(Self {
            path: paths[0].clone(),
            meshes: Meshes::Merged(parts),
        })
    }

    /// Returns the merged inputs; none for a single input.
    pub fn parts(&self) -> &[Self] {
        match &self.meshes {
            Meshes::Merged(parts) => parts,
            _ => &[],
        }
    }

    /// Refuses a list of files if one of them is missing.
    pub fn check_files(&self) -> Result<()> {
        match &self.meshes {
            Meshes::Listed(list) => list.iter().try_for_each(|entry| self.check_file(entry)),
            Meshes::Merged(parts) => parts.iter().try_for_each(Self::check_files),
            Meshes::File { .. } | Meshes::Elsewhere(_) => Ok(()),
        }
    }

    fn check_file(&self, entry: &Listed) -> Result<()> {
        let is_named = formats::is_series(&self.path);
        if !is_named {
            let is_pipe = entry.path.as_os_str() == "-";
            let found = std::fs::metadata(&entry.path).map(|_| ());
            let found = if is_pipe { Ok(()) } else { found };
            return found.map_err(|error| Error::io(&entry.path, &error));
        }
        formats::check_file(&entry.path).map_err(|error| Error {
            message: format!("it names {}: {error}", entry.path.display()),
            position: entry.line.map(Position::Line),
            ..Error::io(&self.path, &error)
        })
    }

    /// Returns a note on the times of a sequence, if they do not increase.
    pub fn remark_on_times(&self) -> Option<Note> {
        let times = self.times()?;
        let step = times.windows(2).position(|two| two[0] >= two[1])?;
        Some(note!(
            "times_not_increasing",
            "the times do not increase: step {step} is at {}, step {} at {}; steps keep the order of the file",
            short(times[step]),
            step + 1,
            short(times[step + 1])
        ))
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the file with the mesh of a step.
    pub fn path_of(&self, step: usize) -> &Path {
        match &self.meshes {
            Meshes::File { .. } | Meshes::Merged(_) | Meshes::Elsewhere(_) => &self.path,
            Meshes::Listed(list) => list.get(step).map_or(&self.path, |entry| &entry.path),
        }
    }

    fn file(&self) -> Option<(&Location, &'static Format)> {
        match &self.meshes {
            Meshes::File {
                location, format, ..
            } => Some((location, format)),
            Meshes::Listed(_) | Meshes::Merged(_) | Meshes::Elsewhere(_) => None,
        }
    }

    /// Returns the title of the format of the file.
    pub fn title(&self) -> Option<String> {
        let (location, format) = self.file()?;
        Some(format.title_of(location.bytes()))
    }

    /// Returns the version of the format that the file states.
    pub fn version(&self) -> Option<String> {
        let (location, format) = self.file()?;
        (format.version)(location.bytes())
    }

    /// Returns the times of a sequence; `None` for one mesh.
    pub fn times(&self) -> Option<Vec<f64>> {
        match &self.meshes {
            Meshes::File { times, .. } => (times.len() > 1).then(|| times.clone()),
            Meshes::Listed(list) => Some(list.iter().map(|entry| entry.time).collect()),
            Meshes::Merged(parts) => parts.iter().find_map(Self::times),
            Meshes::Elsewhere(times) => times.clone(),
        }
    }

    /// Refuses a step that the sequence does not have.
    pub fn check_step(&self, step: Option<usize>) -> Result<()> {
        let n = self.times().map_or(1, |times| times.len());
        let message = match (step, n) {
            (Some(step), 1) if step > 0 => {
                format!("--step {step}: this is one mesh; its only step is 0")
            }
            (Some(step), n) if step >= n => {
                format!("--step {step}: the sequence has steps 0 to {}", n - 1)
            }
            _ => return Ok(()),
        };
        Err(Error::input(message).file(&self.path))
    }

    /// Returns the name without folder and endings.
    pub fn stem(&self) -> String {
        if !self.parts().is_empty() {
            return "merged".to_owned();
        }
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name = formats::without_compression(&name);
        let name = name.strip_suffix(".series").unwrap_or(name);
        let known = formats::FORMATS.iter().flat_map(|format| format.extensions);
        let stem = known
            .chain(&["pvd"])
            .filter_map(|ending| name.strip_suffix(ending)?.strip_suffix('.'))
            .min_by_key(|stem| stem.len());
        match stem.unwrap_or(name) {
            "" | "-" => "mesh".to_owned(),
            stem => stem.to_owned(),
        }
    }

    /// Reads the mesh of a step, or the only one; prints its reader's notes.
    pub fn mesh(&self, step: Option<usize>, context: &Context) -> Result<Mesh> {
        let loaded = self.read(step, context)?;
        Ok(context.with_notes(loaded, &self.path))
    }

    /// Returns the file with the mesh of a step, if each rank can read its part of it.
    pub fn shared(&self, step: Option<usize>, context: &Context) -> Shared {
        let mut options = context.read_options();
        match &self.meshes {
            Meshes::File { format, .. } => {
                options.step = step;
                SharedFile::new(&self.path, Some(*format), &options)
            }
            Meshes::Listed(list) => {
                let last = list.len().saturating_sub(1);
                let format = context.input_format().map_err(|error| error.message)?;
                SharedFile::new(self.path_of(step.unwrap_or(last)), format, &options)
            }
            Meshes::Merged(_) => Err("one rank merges meshes".to_owned()),
            Meshes::Elsewhere(_) => Err("another rank has it".to_owned()),
        }
    }

    /// Reads a mesh: of a step of a sequence, or the only one.
    pub fn read(&self, step: Option<usize>, context: &Context) -> Result<Loaded> {
        context.reading(self.path_of(step.unwrap_or(0)), || {
            let mut options = context.read_options();
            match &self.meshes {
                Meshes::File {
                    location, format, ..
                } => {
                    options.step = step;
                    formats::read_as(format, location, &options)
                }
                Meshes::Listed(list) => {
                    let entry = &list[step.unwrap_or(list.len() - 1)];
                    self.check_file(entry)?;
                    let location = context.open(&entry.path)?;
                    // A list may name any file: the content of a file that is not a mesh is not shown.
                    if location.file().is_ok() && context.format_of_input(&location).is_err() {
                        let list = self.path.display();
                        let message = format!(
                            "{list} lists this file, but it is not a mesh of a known format"
                        );
                        return Err(Error::input(message).file(&entry.path));
                    }
                    context.read_location(&location, &options)
                }
                Meshes::Merged(_) | Meshes::Elsewhere(_) => {
                    Err(Error::system("its parts are read elsewhere"))
                }
            }
        })
    }
}

/// Returns words for the times of two sequences, where they differ by more than rounding.
fn difference(own: &[f64], other: &[f64]) -> Option<[String; 2]> {
    if own.len() != other.len() {
        return Some([own, other].map(|times| counted(times.len(), "step")));
    }
    let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    let step = own.iter().zip(other).position(|two| !is_same(two))?;
    let times = [own[step], other[step]].map(short);
    Some([format!("step {step} is at {}", times[0]), times[1].clone()])
}

/// Returns the file that joins the parts, given one part's name `stem_A-B.ending`.
fn whole_of(part: &Path) -> Option<PathBuf> {
    let (stem, steps) = part.file_stem()?.to_str()?.rsplit_once('_')?;
    let (first, end) = steps.split_once('-')?;
    let is_number = |text: &str| text.parse::<usize>().is_ok();
    let name = format!("{stem}.{}", part.extension()?.to_str()?);
    (is_number(first) && is_number(end)).then(|| part.with_file_name(name))
}

/// Returns the contents of a folder, by name.
fn paths_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder);
    let paths = entries.and_then(|all| all.map(|entry| Ok(entry?.path())).collect());
    let mut paths: Vec<PathBuf> = paths.map_err(|error| Error::io(folder, &error))?;
    paths.sort();
    Ok(paths)
}

/// The meshes and lists of a folder that are not hidden, without those that a list or a .pvtu of it names.
fn members(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_mesh = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let inside = path.with_file_name(formats::without_compression(&name));
        let is_named = formats::is_series(path)
            || formats::is_only_read(&inside)
            || formats::by_extension(&inside).is_ok();
        is_named && !name.starts_with('.')
    };
    let mut meshes: Vec<PathBuf> = paths_in(folder)?.into_iter().filter(is_mesh).collect();
    // Two lists of the same files are one sequence: the first stands for it.
    let mut named = BTreeSet::new();
    meshes.retain(|path| {
        let files = if formats::is_series(path) {
            let list = formats::read_series(path).unwrap_or_default();
            list.into_iter().map(|entry| entry.path).collect::<Vec<_>>()
        } else {
            let pieces = formats::pvtu::pieces_of(path).unwrap_or_default();
            pieces
                .iter()
                .map(|name| path.with_file_name(name))
                .collect::<Vec<_>>()
        };
        let n_files = files.len();
        let n_known = named.len();
        named.extend(files);
        n_files == 0 || named.len() > n_known
    });
    meshes.retain(|path| !named.contains(path));
    Ok(meshes)
}

/// Returns the file that is or lists the sequence of a folder, as `deform` writes it: a .pvd, or a .vtkhdf or .cgns with
/// all steps.
fn sequence_in(folder: &Path) -> Result<PathBuf> {
    let files = paths_in(folder)?;
    let is_mesh = |path: &&PathBuf| {
        let is_folder = || formats::by_extension(path).is_ok_and(|format| format.is_folder());
        path.is_file() || path.is_dir() && is_folder()
    };
    let ending = |path: &PathBuf| path.extension().map(|e| e.to_ascii_lowercase());
    let in_one = formats::FORMATS.iter();
    let in_one = in_one.filter(|format| format.sequence.is_some());
    let in_one: Vec<&str> = in_one.map(|format| format.extensions[0]).collect();
    // Of a mesh with a hidden name the sequence is hidden too.
    let (pvd, visible, hidden) = (&["pvd"][..], false, true);
    let orders = [
        (visible, pvd),
        (visible, &in_one),
        (hidden, pvd),
        (hidden, &in_one),
    ];
    for (is_hidden, wanted) in orders {
        let is_wanted = |path: &&PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with('.') == is_hidden
                && wanted.iter().any(|w| ending(path).is_some_and(|e| e == *w))
        };
        let found: Vec<&PathBuf> = files.iter().filter(is_wanted).filter(is_mesh).collect();
        // Parts are joined in a file that has their name without the steps.
        let is_joined =
            |path: &&PathBuf| whole_of(path).is_none_or(|whole| !found.contains(&&whole));
        let found: Vec<&PathBuf> = found.iter().copied().filter(is_joined).collect();
        match found[..] {
            [] => continue,
            [one] => return Ok(one.clone()),
            [first, second, ..] => {
                return Err(Error::input(format!(
                    "the folder holds several sequences, such as {} and {}; give one of them",
                    first.display(),
                    second.display()
                ))
                .file(folder));
            }
        }
    }
    let in_one = in_one.join(" or .");
    Err(Error::input(format!(
        "this is a folder, not a mesh, and it holds no sequence (no .pvd, .{in_one})"
    ))
    .file(folder))
}
