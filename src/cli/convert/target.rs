//! Outputs of `azimesh convert`: one mesh, one file with a sequence, or files and their list.

use super::{Input, Run};
use crate::record::{Diagnostic, Failed};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_io::formats::{
    self, Format, Notes, OuterFaces, SequenceFile, Staged, WriteOptions, check_listed,
    is_flattened, is_series, make_portable, pvd, refuse_special, stage_bytes, vtk_series,
};
use azimesh_io::mesh::{ByRanks, Mesh};
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

/// Destination of meshes.
pub enum Place {
    /// A file, of a format that may hold a sequence.
    File {
        path: PathBuf,
        format: &'static Format,
    },
    /// Files `stem_0000` and so on, and lists of them.
    Listed {
        stem: PathBuf,
        format: &'static Format,
        lists: Vec<PathBuf>,
    },
}

/// A file that was written.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Written {
    /// Path of the mesh that was read.
    pub input: String,
    /// Path of the file.
    output: String,
    /// Name of its format, as `--format` takes it.
    format: &'static str,
    /// Number of nodes.
    nodes: usize,
    /// Number of cells.
    cells: usize,
    /// Time of the step; only where the mesh is a step of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
    /// Notes on the input and on the file; of a sequence those of all its steps.
    pub notes: Vec<Diagnostic>,
    /// Codes of those notes that say what the file does not hold.
    pub lost: BTreeSet<String>,
}

/// Results of the command.
#[derive(Default)]
pub struct Done {
    /// Files that were written.
    pub written: Vec<Written>,
    /// Each output, with what it lost.
    pub rows: Vec<Row>,
    /// Reasons for outputs that were not written, each once.
    pub failed: Vec<Error>,
}

impl Done {
    /// Adds a reason; that an input cannot be read is the same for each of its outputs.
    pub fn fail(&mut self, error: Error) {
        let text = error.to_string();
        if !self.failed.iter().any(|known| known.to_string() == text) {
            self.failed.push(error);
        }
    }
}

/// An output in the table of losses.
pub struct Row {
    /// Path of the file, or of the list of the files.
    pub output: String,
    /// Name of its format.
    pub format: &'static str,
    /// Codes of notes; `None` where it was not written.
    pub lost: Option<BTreeSet<String>>,
}

/// The files that were written: one at the top, several in `outputs`.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Outputs {
    /// One file.
    One(Written),
    /// Several files.
    Several {
        /// The files, in order.
        outputs: Vec<Written>,
        /// Why others were not written; only with `--keep-going`.
        failed: Vec<Failed>,
    },
}

impl Place {
    /// Numbered files with a .pvd, and with a .vtk.series where they are legacy VTK files.
    /// Where they are written in several formats, the list has the ending of its own before `.pvd`.
    pub fn listed(stem: &Path, format: &'static Format, is_one_of_several: bool) -> Self {
        let ending = match is_one_of_several {
            true => format!("{}.pvd", format.extensions[0]),
            false => "pvd".to_owned(),
        };
        let mut lists = vec![with_ending(stem, &ending)];
        lists.extend(format.list_ending.map(|ending| with_ending(stem, ending)));
        Place::Listed {
            stem: stem.to_path_buf(),
            format,
            lists,
        }
    }

    /// Path of the file, or of the first list of the files, and their format.
    pub fn named(&self) -> (String, &'static Format) {
        let (path, format) = match self {
            Place::File { path, format } => (path, format),
            Place::Listed { lists, format, .. } => (&lists[0], format),
        };
        (path.display().to_string(), format)
    }

    /// Returns the files of an input at this destination.
    pub fn files(&self, input: &Input) -> Vec<PathBuf> {
        match self {
            Place::File { path, .. } => vec![path.clone()],
            Place::Listed {
                stem,
                format,
                lists,
            } => {
                let n = input.times().map_or(1, |times| times.len());
                let files = (0..n).map(|i| stem.with_file_name(step_name(stem, format, n, i)));
                files.chain(lists.iter().cloned()).collect()
            }
        }
    }

    /// Returns whether it takes one mesh only.
    pub fn is_one_mesh(&self) -> bool {
        matches!(self, Place::File { format, .. } if format.sequence.is_none())
    }
}

/// Returns the name of the file of one of `n` steps.
fn step_name(stem: &Path, format: &Format, n: usize, step: usize) -> String {
    let digits = n.saturating_sub(1).to_string().len().max(4);
    let name = stem.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}_{step:0digits$}.{}", format.extensions[0])
}

/// A path with an ending behind its last name, which may have dots of its own.
pub fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.file_name().unwrap_or_default().to_os_string();
    name.push(".");
    name.push(ending);
    stem.with_file_name(name)
}

impl Run<'_> {
    /// Returns the destination of an output of this name.
    pub(super) fn place(&self, path: &Path) -> Result<Place> {
        if !is_series(path) {
            return Ok(Place::File {
                format: self.output_format(Some(path))?,
                path: path.to_path_buf(),
            });
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let of_format = name.strip_suffix(".series").map(Path::new);
        let stem = match of_format {
            Some(inner) => inner.file_stem().unwrap_or_default().to_os_string(),
            None => path.file_stem().unwrap_or_default().to_os_string(),
        };
        let format = match (of_format, self.context.common.one_format()?) {
            (Some(inner), _) => formats::by_extension(inner)?,
            (None, Some(name)) => formats::to_write(formats::by_name(name)?)?,
            (None, None) => formats::by_name("vtu")?,
        };
        if format.case.is_some() {
            return Err(Error::input(format!(
                "a list has a file for each step, and {} keeps all steps in one folder; give its name instead",
                format.title
            ))
            .file(path));
        }
        Ok(Place::Listed {
            stem: path.with_file_name(stem),
            format,
            lists: vec![path.to_path_buf()],
        })
    }

    /// The ending of one mesh of this format.
    pub(super) fn ending(&self, format: &Format) -> &'static str {
        match self.args.pieces {
            Some(_) => formats::in_pieces().extensions[0],
            None => format.extensions[0],
        }
    }

    /// Writes every mesh of a sequence.
    pub(super) fn sequence(&self, input: &Input, times: &[f64], place: &Place) -> Result<()> {
        let is_case = matches!(place, Place::File { format, .. } if format.case.is_some());
        if self.args.pieces.is_some() && !is_case {
            return Err(
                Error::input("--pieces is for one mesh, and this is a sequence").file(input.path()),
            );
        }
        if let Some(remark) = input.remark_on_times() {
            self.tell(remark.file(input.path()));
        }
        let is_sequence = input.times().is_some();
        let steps: Vec<usize> = match self.args.step {
            Some(step) => {
                input.check_step(self.args.step)?;
                vec![step]
            }
            None => (0..times.len()).collect(),
        };
        let steps = steps
            .into_iter()
            .map(|step| (is_sequence.then_some(step), times[step]));
        match place {
            Place::File { path, format } => {
                let (options, commit) = (self.options(), self.args.write.commit());
                let write = |file: &mut dyn SequenceFile| {
                    self.write_one_file(input, steps, path, file, format)
                };
                let ((), file) = formats::stage_sequence(path, format, &options, commit, write)?;
                self.wait(file);
                Ok(())
            }
            Place::Listed {
                stem,
                format,
                lists,
            } => self.write_files(input, steps, stem, format, lists),
        }
    }

    /// Writes a sequence to a file that will be `path`.
    fn write_one_file(
        &self,
        input: &Input,
        steps: impl Iterator<Item = (Option<usize>, f64)>,
        path: &Path,
        file: &mut dyn SequenceFile,
        format: &'static Format,
    ) -> Result<()> {
        for (step, time) in steps {
            let mesh = self.read(input, step)?;
            let mesh = self.portable(&mesh, path, format)?;
            let append = || file.push(time, &mesh.view());
            self.context.stage("writing", append)?;
            self.note_written(&mesh, path, format);
            self.note_step(input, step, time);
        }
        self.remark_on_options(path, format);
        self.tell_dropped(path, file.notes());
        Ok(())
    }

    /// Reports the losses of an output; cells that become flat are reported once per sequence.
    fn tell_dropped(&self, output: &Path, notes: &Notes) {
        for dropped in notes.iter() {
            if !is_flattened(dropped) || !self.is_flat_told.replace(true) {
                self.tell(dropped.clone().file(output));
            }
            self.lost.borrow_mut().insert(dropped.code.to_string());
        }
    }

    fn remark_on_options(&self, output: &Path, format: &Format) {
        for remark in self.args.write.remarks(format) {
            self.tell(remark.file(output));
        }
    }

    fn write_files(
        &self,
        input: &Input,
        steps: impl ExactSizeIterator<Item = (Option<usize>, f64)>,
        stem: &Path,
        format: &'static Format,
        lists: &[PathBuf],
    ) -> Result<()> {
        let n = steps.len();
        let file = |i| step_name(stem, format, n, i);
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        if lists.iter().any(|list| is_pvd(list)) {
            check_listed(&name).map_err(|error| error.file(stem))?;
        }
        let steps: Vec<_> = steps.zip(0..).map(|(step, i)| (step, file(i))).collect();
        let files = steps.iter().map(|(_, file)| stem.with_file_name(file));
        for path in files.chain(lists.iter().cloned()) {
            refuse_special(&path)?;
            self.args.write.check(&path)?;
        }
        for ((step, time), file) in &steps {
            let mesh = self.read(input, *step)?;
            let path = stem.with_file_name(file);
            self.save_as(&mesh, None, &path, &lists[0], format)?;
            self.note_step(input, *step, *time);
        }
        let entries = || steps.iter().map(|((_, time), file)| (*time, file.as_str()));
        for list in lists {
            let text = if is_pvd(list) {
                pvd(entries())
            } else {
                vtk_series(entries())
            };
            let commit = self.args.write.commit();
            self.wait(stage_bytes(text.as_bytes(), list, commit)?);
        }
        Ok(())
    }

    /// Writes one mesh; returns remarks on its losses.
    pub(super) fn save(
        &self,
        mesh: &Mesh,
        by_ranks: Option<ByRanks<'_>>,
        path: &Path,
        format: &'static Format,
    ) -> Result<()> {
        self.save_as(mesh, by_ranks, path, path, format)
    }

    /// As [`save`](Self::save), for a file of an output that remarks name: the list of a sequence, or the file itself.
    fn save_as(
        &self,
        mesh: &Mesh,
        by_ranks: Option<ByRanks<'_>>,
        path: &Path,
        output: &Path,
        format: &'static Format,
    ) -> Result<()> {
        self.remark_on_options(output, format);
        let mesh = &*self.portable(mesh, output, format)?;
        let options = self.options();
        let written_as = match options.pieces {
            Some(_) if format.case.is_none() => formats::in_pieces(),
            _ => format,
        };
        let commit = self.args.write.commit();
        let mut view = mesh.view();
        view.by_ranks = by_ranks;
        let write = || formats::stage(&view, path, written_as, &options, commit);
        let (notes, files) = self.context.stage("writing", write)?;
        self.wait(files);
        self.tell_dropped(output, &notes);
        self.tell_of_zones_apart(output, mesh, &notes);
        self.note_written(mesh, path, format);
        Ok(())
    }

    /// Where some of the notes are on outer faces without a tag, says that zones which share no nodes have left them.
    fn tell_of_zones_apart(&self, output: &Path, mesh: &Mesh, notes: &Notes) {
        let is_on_bare_faces =
            |note: &Note| ["bare_faces", "untagged_patch"].contains(&&*note.code);
        if !notes.iter().any(is_on_bare_faces) {
            return;
        }
        let n = mesh.n_joinable_faces();
        if n > 0 {
            let note = note!(
                "zones_apart",
                "of the outer faces without a tag, {} lie on one another: they are interfaces of zones that share no nodes \
                 (`repeated` in azimesh info); --join makes these one mesh",
                2 * n
            );
            self.tell(note.file(output));
        }
    }

    /// The mesh without what readers of the format do not take, where that is asked for; its surface for a format of surfaces,
    /// without the faces of tags that were removed.
    fn portable<'m>(
        &self,
        mesh: &'m Mesh,
        output: &Path,
        format: &Format,
    ) -> Result<Cow<'m, Mesh>> {
        let outer = if self.args.changes.removes_tags() {
            OuterFaces::Listed
        } else {
            OuterFaces::All
        };
        if let Some(surface_of) = format.surface {
            let (surface, notes) = surface_of(&mesh.view(), outer);
            if surface.cells.is_empty() {
                return Err(Error::input(
                    "no boundary face is left after --keep-tag or --drop-tag",
                ));
            }
            self.tell_dropped(output, &notes);
            self.tell_of_zones_apart(output, mesh, &notes);
            return Ok(Cow::Owned(surface));
        }
        if !self.args.portable {
            return Ok(Cow::Borrowed(mesh));
        }
        let mut portable = mesh.clone();
        Ok(match make_portable(&mut portable, format.name) {
            Some(remark) => {
                self.tell(remark.file(output));
                Cow::Owned(portable)
            }
            None => Cow::Borrowed(mesh),
        })
    }

    pub(super) fn options(&self) -> WriteOptions {
        WriteOptions {
            pieces: self.args.pieces,
            ..self.args.write.options()
        }
    }

    /// Leaves files without their final names until all are complete.
    fn wait(&self, files: Staged) {
        self.waiting.borrow_mut().push(files);
    }

    /// Adds the file of the step, with its time, to the last output.
    fn note_step(&self, input: &Input, step: Option<usize>, time: f64) {
        if let Some(last) = self.written.borrow_mut().last_mut() {
            last.time = Some(time);
            last.input = input.path_of(step.unwrap_or(0)).display().to_string();
        }
    }

    fn note_written(&self, mesh: &Mesh, path: &Path, format: &Format) {
        if path.as_os_str() != "-" {
            self.written.borrow_mut().push(Written {
                input: String::new(),
                notes: Vec::new(),
                output: path.display().to_string(),
                format: format.name,
                nodes: mesh.points.len(),
                cells: mesh.cells.len(),
                time: None,
                lost: BTreeSet::new(),
            });
        }
    }
}

fn is_pvd(list: &Path) -> bool {
    list.extension().is_some_and(|ending| ending == "pvd")
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = &self.output;
        let [nodes, cells] = [counted(self.nodes, "node"), counted(self.cells, "cell")];
        write!(f, "{path}: {nodes}, {cells}")?;
        self.time
            .map_or(Ok(()), |time| write!(f, ", time {}", short(time)))
    }
}

impl Outputs {
    /// Files in their order.
    pub fn of(done: Done) -> Self {
        let failed: Vec<Failed> = done.failed.iter().map(Failed::from).collect();
        match <[Written; 1]>::try_from(done.written) {
            Ok([one]) if failed.is_empty() => Self::One(one),
            Ok(one) => Self::Several {
                outputs: one.into(),
                failed,
            },
            Err(outputs) => Self::Several { outputs, failed },
        }
    }
}

/// A line for each output: the file, its format, and what it lost, each kind once.
pub fn table(rows: &[Row]) -> String {
    let width = |of: fn(&Row) -> usize, title: &str| {
        let widths = rows.iter().map(of);
        widths.fold(title.len(), usize::max)
    };
    let file = width(|row| row.output.chars().count(), "file");
    let format = width(|row| row.format.len(), "format");
    let line = |a: &str, b: &str, c: &str| format!("{a:file$}  {b:format$}  {c}\n");
    let mut text = line("file", "format", "lost");
    for row in rows {
        let words = |codes: &BTreeSet<String>| {
            let words: Vec<_> = codes.iter().map(|code| code.replace('_', " ")).collect();
            words.join(", ")
        };
        let lost = match &row.lost {
            None => "not written".to_owned(),
            Some(codes) if codes.is_empty() => "nothing".to_owned(),
            Some(codes) => words(codes),
        };
        text += &line(&row.output, row.format, &lost);
    }
    text
}
