//! `azimesh convert`.

mod by_ranks;
mod changes;
mod merge;
mod target;

use super::input::Input;
use super::output::{self, OutputArgs};
use super::{Context, Outcome};
use crate::record::{Diagnostic, Level};
use azimesh_core::error::{Error, ErrorKind, Result, counted};
use azimesh_core::{Note, note};
use azimesh_io::formats::{self, Loaded, Staged};
use azimesh_io::mesh::{Mesh, Reordering};
use changes::{Changes, NODE_NUMBERS, without};
pub(super) use changes::{bind_distance, patch_type};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
pub use target::Outputs;
use target::{Done, Place, Row, Written};

/// Arguments of `azimesh convert`.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "azimesh convert [OPTIONS] IN OUT\n       \
azimesh convert [OPTIONS] IN... OUT.vtkhdf|OUT.cgns|OUT.pvd\n       \
azimesh convert [OPTIONS] IN... -o OUT\n       \
azimesh convert [OPTIONS] --merge IN IN... -o OUT\n       \
azimesh convert [OPTIONS] IN... -o DIR --format F[,F...]",
    after_help = "The format of the input is recognised by its content; --format gives that of the output if \
its ending does not. A .pvd, a .vtk.series and a file of several steps are sequences: they are written to one \
file of a format that holds sequences, or to numbered files with a list: OUT.pvd, and in DIR where the format has none.\n\n\
With -o DIR an input may be a folder: each mesh and sequence in it is converted. Of several outputs a table on standard \
output says what each does not hold. If an input is refused, all refusals are listed and nothing is written, or with \
--keep-going the others (exit code 1).\n\n\
ParaView opens .vtkhdf from 5.12 on, earlier versions one mesh in a file that ends in .hdf."
)]
pub struct ConvertArgs {
    /// Meshes to read, then the one to write (without -o); - is standard input or output
    #[arg(value_name = "MESH", required = true)]
    paths: Vec<PathBuf>,
    /// The file to write, as OUT; a name without the ending of a format is a folder, to which each mesh is written
    /// under its own name in the format of --format
    #[arg(short, long, value_name = "OUT|DIR")]
    output: Option<PathBuf>,
    /// Write what can be written of several outputs where others fail; exit code 1 then
    #[arg(long)]
    keep_going: bool,
    /// Make one mesh of all inputs: tags and zones of one name become one. Of sequences with the same times each step is
    /// merged, with a single mesh at every step; --join joins them where faces lie on one another
    #[arg(long)]
    merge: bool,
    /// Put the name of its file before each tag and zone of an input of --merge: rotor_wall; cells in no zone get the zone rotor
    #[arg(long, requires = "merge")]
    prefix_tags: bool,
    /// Read only this step of a sequence, counted from 0
    #[arg(long, value_name = "I")]
    step: Option<usize>,
    /// Write N pieces and a .pvtu that lists them; 1 with an OpenFOAM case joins the pieces of a decomposed one
    #[arg(long, value_name = "N", value_parser = number_of_pieces)]
    pieces: Option<NonZeroUsize>,
    /// Leave out what the format holds and usual readers of it do not take: SU2 markers inside the volume; Lagrange
    /// pyramids for VTK, which become linear; edges and points of a solid mesh in CGNS, with which ParaView shows no cell
    /// array
    #[arg(long)]
    portable: bool,
    /// Put nodes and cells in the order of a space-filling curve, so that neighbours lie close to one another in the
    /// file and in memory; all steps of a sequence in that of the first. Files that name nodes by number no longer fit
    #[arg(long)]
    reorder: bool,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    write: OutputArgs,
}

/// A mesh or a sequence, with its output.
struct Job<'i> {
    input: &'i Input,
    place: Place,
    is_sequence: bool,
    /// Reason for a refusal before the job begins.
    refused: Option<Error>,
}

/// One run of the command.
struct Run<'a> {
    args: &'a ConvertArgs,
    context: &'a Context,
    /// Remarks that have been printed: one on every mesh of a sequence, or on an input of several outputs, is printed once.
    told: RefCell<BTreeSet<String>>,
    /// Remarks on the job.
    notes: RefCell<Vec<Note>>,
    /// Codes of notes on losses of the job.
    lost: RefCell<BTreeSet<String>>,
    /// True after a remark on cells that become flat in 32 bits.
    is_flat_told: Cell<bool>,
    /// Files of the job.
    written: RefCell<Vec<Written>>,
    /// Files of the job that are renamed when all are complete.
    waiting: RefCell<Vec<Staged>>,
    /// The order of `--reorder`, once the first mesh has been read.
    order: RefCell<Option<Reordering>>,
}

pub(super) fn run(args: &ConvertArgs, context: &Context) -> Result<Outcome> {
    if !context.ranks.is_first() {
        by_ranks::follow(context);
        return Ok(Outcome::Fine);
    }
    let outcome = run_first(args, context);
    by_ranks::end(context);
    outcome
}

fn run_first(args: &ConvertArgs, context: &Context) -> Result<Outcome> {
    args.changes.check()?;
    let run = Run {
        args,
        context,
        told: RefCell::default(),
        notes: RefCell::default(),
        lost: RefCell::default(),
        is_flat_told: Cell::default(),
        written: RefCell::default(),
        waiting: RefCell::default(),
        order: RefCell::default(),
    };
    run.check_pieces()?;
    let target = args.target();
    let (Target::Folder(output) | Target::File(output, _)) = target;
    let inputs = match target {
        Target::File(_, inputs) => inputs,
        Target::Folder(_) => &args.paths,
    };
    formats::guard_inputs(inputs);
    context.keep_in_files(output);
    let new_folder = match target {
        Target::Folder(folder) => Some(folder).filter(|folder| !folder.exists()),
        Target::File(..) => None,
    };
    let done = match target {
        Target::Folder(folder) => run.write_folder(folder),
        Target::File(out, inputs) => run.write_file(out, inputs),
    };
    let done = done.inspect_err(|_| {
        // Removed unless it holds something; the first error is the one to report.
        let _ = new_folder.map(std::fs::remove_dir);
    })?;
    context.tell_of_files();
    run.report(done)
}

/// Output of the arguments.
#[derive(Clone, Copy)]
enum Target<'a> {
    /// A file, a list or a case, from these inputs.
    File(&'a Path, &'a [PathBuf]),
    /// Each input into a folder.
    Folder(&'a Path),
}

impl ConvertArgs {
    /// The last path without `-o`; with it a file if the name ends as one of a format does, and is no folder.
    fn target(&self) -> Target<'_> {
        let Some(out) = &self.output else {
            let (out, inputs) = self.paths.split_last().expect("clap asks for one");
            return Target::File(out, inputs);
        };
        let is_named = out.as_os_str() == "-"
            || formats::is_series(out)
            || formats::by_extension(out).is_ok()
            || formats::is_only_read(out);
        if is_named && !out.is_dir() {
            Target::File(out, &self.paths)
        } else {
            Target::Folder(out)
        }
    }
}

impl Run<'_> {
    /// Refuses `--pieces` for outputs without pieces, unless it joins the pieces of a case.
    fn check_pieces(&self) -> Result<()> {
        let Some(n) = self.args.pieces else {
            return Ok(());
        };
        let out = match self.args.target() {
            Target::File(out, _) => Some(out),
            Target::Folder(_) => None,
        };
        let format = self.output_format(out);
        if format.is_ok_and(|format| format.case.is_some()) {
            return match n.get() {
                1 => Ok(()),
                _ => Err(Error::input(format!(
                    "--pieces {n}: a case is written in the pieces that it was read from, or with --pieces 1 as a whole; \
                     decomposePar cuts it"
                ))),
            };
        }
        let is_list = |out: &Path| {
            let ending = formats::in_pieces().extensions[0];
            out.extension().is_some_and(|found| found == ending)
        };
        match out.filter(|out| !is_list(out)) {
            None => Ok(()),
            Some(out) => {
                let message =
                    "--pieces N writes a .pvtu and its pieces; the name must end in .pvtu";
                Err(Error::input(message).file(out))
            }
        }
    }

    /// Writes the jobs. All wrong inputs are reported, with the ones found before (`failed`); then no file is renamed, or with
    /// `--keep-going` only the files of the other jobs. After a failure of the system complete files stay.
    fn write(&self, jobs: Vec<Job<'_>>, failed: Vec<Error>) -> Result<Done> {
        let keeps_going = self.args.keep_going;
        let mut done = Done {
            failed,
            ..Done::default()
        };
        let mut is_over = false;
        let mut whole = Vec::new();
        for mut job in jobs {
            let wrote = match job.refused.take() {
                Some(error) => Err(error),
                None => self.write_job(&job),
            };
            let files = self.waiting.take();
            let (output, format) = job.place.named();
            let mut lost = Some(self.lost.take());
            if let Err(error) = wrote {
                lost = None;
                is_over = error.kind != ErrorKind::Input;
                done.fail(error.file(job.input.path()));
            } else {
                done.written.extend(self.written_by(&job, &lost));
            }
            if lost.is_some() || is_over {
                whole.extend(files);
            }
            done.rows.push(Row {
                output,
                format: format.name,
                lost,
            });
            if keeps_going {
                Staged::all(std::mem::take(&mut whole)).keep()?;
            }
            if is_over {
                break;
            }
        }
        let is_kept = done.failed.is_empty() || is_over;
        if is_kept {
            Staged::all(whole).keep()?;
        }
        if done.failed.is_empty() || keeps_going && !is_over && !done.written.is_empty() {
            return Ok(done);
        }
        let last = done.failed.pop().expect("it is not empty");
        done.failed
            .iter()
            .for_each(|error| self.context.error(error));
        Err(last)
    }

    fn write_job(&self, job: &Job<'_>) -> Result<()> {
        self.order.take();
        self.notes.take();
        self.lost.take();
        self.written.take();
        self.is_flat_told.set(false);
        let (input, place) = (job.input, &job.place);
        match place {
            Place::File { path, format } if !job.is_sequence => self.one_mesh(input, path, format),
            _ => self.sequence(input, &input.times().unwrap_or(vec![0.0]), place),
        }
    }

    /// Returns the files of the job.
    fn written_by(&self, job: &Job<'_>, lost: &Option<BTreeSet<String>>) -> Vec<Written> {
        let notes = self.notes.take();
        let notes = notes.iter().map(|note| Diagnostic::new(Level::Note, note));
        let notes: Vec<_> = notes.collect();
        let mut written = self.written.take();
        for file in &mut written {
            file.notes.clone_from(&notes);
            file.lost = lost.clone().unwrap_or_default();
            if file.input.is_empty() {
                file.input = job.input.path().display().to_string();
            }
        }
        written
    }

    /// `IN OUT`, or the files of a sequence and `OUT`.
    fn write_file(&self, out: &Path, inputs: &[PathBuf]) -> Result<Done> {
        self.context.check_json_beside(out)?;
        let input = match inputs {
            [] => {
                return Err(Error::input(
                    "convert needs a mesh to read and one to write, or -o DIR",
                ));
            }
            [one, others @ ..] if others.is_empty() || self.args.merge => {
                let place = self.place(out)?;
                self.args.write.check(out)?;
                let input = match others {
                    [] if !self.args.merge => Input::open(one, self.context)?,
                    _ => Input::merged(inputs, self.args.step, self.context)?,
                };
                if !place.is_one_mesh() {
                    input.check_files()?;
                }
                input
            }
            several => {
                let place = self.place(out)?;
                if place.is_one_mesh() {
                    return Err(Error::input(
                        "several meshes are written to one file as a sequence, .pvd, .vtkhdf or .cgns; -o DIR \
                         converts each of them, --merge makes one mesh of them",
                    )
                    .file(out));
                }
                self.args.write.check(out)?;
                let input = Input::of_parts(several)?;
                input.check_files()?;
                input
            }
        };
        let place = self.place(out)?;
        let is_list = matches!(place, Place::Listed { .. });
        let job = Job {
            is_sequence: is_list || input.times().is_some() && !place.is_one_mesh(),
            input: &input,
            place,
            refused: None,
        };
        self.write(vec![job], Vec::new())
    }

    /// Each input, or each mesh and sequence of an input that is a folder, into a folder, in each format.
    fn write_folder(&self, folder: &Path) -> Result<Done> {
        let formats = self.output_formats()?;
        if folder.is_file() {
            return Err(Error::input("this is a file, not a folder").file(folder));
        }
        let mut refused = Vec::new();
        let mut inputs = Vec::new();
        for opened in self.open_all()? {
            let checked = opened.and_then(|input| {
                match self.args.step {
                    None => input.check_files()?,
                    step => input.check_step(step)?,
                }
                Ok(input)
            });
            match checked {
                Ok(input) => inputs.push(input),
                Err(error) => refused.push(error),
            }
        }
        formats::guard_inputs(inputs.iter().map(Input::path));
        let is_one = self.args.merge || self.args.paths.len() == 1 && inputs.len() <= 1;
        let is_case = formats.len() == 1 && formats[0].case.is_some() && is_one;
        let mut taken = BTreeMap::new();
        let mut jobs = Vec::new();
        for input in &inputs {
            for format in &formats {
                // One mesh, or one sequence, makes the folder itself the case.
                let stem = if is_case {
                    folder.to_path_buf()
                } else {
                    folder.join(input.stem())
                };
                let mut job = self.job(input, stem, format, formats.len() > 1);
                match clash(&job, &mut taken) {
                    Some(error) => refused.push(error),
                    None => {
                        job.refused = self.check_outputs(&job, is_case).err();
                        jobs.push(job);
                    }
                }
            }
        }
        if !is_case {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
        }
        self.write(jobs, refused)
    }

    /// Opens the inputs of a folder.
    fn open_all(&self) -> Result<Vec<Result<Input>>> {
        let paths = &self.args.paths;
        Ok(match self.args.merge {
            true => vec![Ok(Input::merged(paths, self.args.step, self.context)?)],
            false => {
                let paths = paths.iter();
                let opened = paths.flat_map(|path| Input::open_all(path, self.context));
                opened.collect()
            }
        })
    }

    /// An input into a file or case of this stem, or into files and their lists.
    fn job<'i>(
        &self,
        input: &'i Input,
        stem: PathBuf,
        format: &'static formats::Format,
        is_one_of_several: bool,
    ) -> Job<'i> {
        let is_sequence = input.times().is_some() && self.args.step.is_none();
        let place = if format.case.is_some() {
            Place::File { path: stem, format }
        } else if is_sequence && format.sequence.is_none() {
            Place::listed(&stem, format, is_one_of_several)
        } else {
            Place::File {
                path: target::with_ending(&stem, self.ending(format)),
                format,
            }
        };
        Job {
            input,
            place,
            is_sequence,
            refused: None,
        }
    }

    /// Refuses to replace the files of a job. A file that takes a whole sequence is checked where it is opened.
    fn check_outputs(&self, job: &Job<'_>, is_case: bool) -> Result<()> {
        let is_joined = matches!(job.place, Place::File { .. }) && job.is_sequence;
        if is_joined || is_case {
            return Ok(());
        }
        let files = job.place.files(job.input);
        files
            .iter()
            .try_for_each(|path| self.args.write.check(path))
    }

    fn one_mesh(&self, input: &Input, path: &Path, format: &'static formats::Format) -> Result<()> {
        input.check_step(self.args.step)?;
        if let (Some(times), None) = (input.times(), self.args.step) {
            let note = note!(
                "last_written",
                "a sequence of {} meshes; only the last is written (--step I chooses another, -o DIR writes all)",
                times.len()
            );
            self.tell(note.file(input.path()));
        }
        if self.by_ranks(input, path, format)? {
            return Ok(());
        }
        let mesh = self.read(input, self.args.step)?;
        self.save(&mesh, None, path, format)
    }

    /// Returns the changed mesh of a step.
    fn read(&self, input: &Input, step: Option<usize>) -> Result<Mesh> {
        let mut mesh = match input.parts() {
            [] => self.read_one(input, step)?,
            parts => self.merged(parts, step)?,
        };
        let remarks = self.args.changes.apply(&mut mesh, self.args.merge);
        for remark in remarks.map_err(|error| error.file(input.path()))? {
            self.tell(remark.file(input.path()));
        }
        if self.args.reorder {
            self.reorder(&mut mesh, input);
        }
        Ok(mesh)
    }

    fn read_one(&self, input: &Input, step: Option<usize>) -> Result<Mesh> {
        let loaded = input.read(step, self.context)?;
        self.tell_notes(input, &loaded);
        Ok(loaded.mesh)
    }

    /// Puts nodes and cells along a curve; those of later steps of a sequence in the order of the first, by which a step
    /// differs from the next as it did before. A step with another number of nodes or cells has an order of its own.
    fn reorder(&self, mesh: &mut Mesh, input: &Input) {
        let mut order = self.order.borrow_mut();
        let known = order.take().filter(|order| order.fits(mesh));
        let order = order.insert(known.unwrap_or_else(|| Reordering::along_curve(mesh)));
        mesh.reorder(order);
        if let Some(note) = without(mesh, &NODE_NUMBERS) {
            self.tell(note.file(input.path()));
        }
        let note = note!(
            "reordered",
            "--reorder: {} and {} along a space-filling curve",
            counted(mesh.points.len(), "node"),
            counted(mesh.cells.len(), "cell")
        );
        self.tell(note.file(input.path()));
    }

    /// Reports the remarks of the reader of an input.
    fn tell_notes(&self, input: &Input, loaded: &Loaded) {
        // Of steps it has told how to choose another.
        for note in loaded.notes.iter() {
            if note.code == "last_of_steps" {
                continue;
            }
            if ["not_kept", "left_out"]
                .iter()
                .any(|end| note.code.ends_with(end))
            {
                self.lost.borrow_mut().insert(note.code.to_string());
            }
            self.tell(note.clone().file(input.path()));
        }
    }

    /// Adds a remark on the job.
    fn tell(&self, remark: Note) {
        let mut notes = self.notes.borrow_mut();
        if notes.contains(&remark) {
            return;
        }
        if self.told.borrow_mut().insert(remark.to_string()) {
            self.context.note(remark.clone());
        }
        notes.push(remark);
    }

    /// Prints the written files, for several outputs also their losses, and the failures.
    fn report(&self, done: Done) -> Result<Outcome> {
        let context = self.context;
        done.failed.iter().for_each(|error| context.error(error));
        let outcome = match done.failed[..] {
            [] => Outcome::Fine,
            _ => Outcome::CheckFailed,
        };
        if context.common.json {
            context.print_json(&Outputs::of(done))?;
            return Ok(outcome);
        }
        for file in &done.written {
            context.detail(&file.to_string());
        }
        if done.rows.len() > 1 {
            context.print_result(&target::table(&done.rows))?;
        }
        Ok(outcome)
    }

    /// Returns the format of `--format`, or of the name of the output.
    fn output_format(&self, path: Option<&Path>) -> Result<&'static formats::Format> {
        match path {
            Some(path) => output::format_of(path, self.context),
            None if self.context.common.format.is_empty() => {
                Err(Error::input("-o DIR needs --format"))
            }
            None => output::format_of(Path::new("-"), self.context),
        }
    }

    /// The formats of a folder, each once.
    fn output_formats(&self) -> Result<Vec<&'static formats::Format>> {
        let names = &self.context.common.format;
        if names.is_empty() {
            return Ok(vec![self.output_format(None)?]);
        }
        let mut known = BTreeSet::new();
        let names = names.iter().filter(|name| known.insert(*name));
        names
            .map(|name| formats::to_write(formats::by_name(name)?))
            .collect()
    }
}

/// Refuses a job that would write a file of another one (`taken`).
fn clash(job: &Job<'_>, taken: &mut BTreeMap<PathBuf, (PathBuf, &str)>) -> Option<Error> {
    let input = job.input.path();
    let format = job.place.named().1.name;
    job.place.files(job.input).into_iter().find_map(|path| {
        let (other, its) = taken.insert(path.clone(), (input.to_path_buf(), format))?;
        let message = if other == input && its == format {
            format!("{} is given twice, and both would be written to this file; give it once", input.display())
        } else if other == input {
            "two of the formats would be written to this file; convert to one of them at a time".to_owned()
        } else {
            let [other, input] = [&other, input].map(Path::display);
            format!("{other} and {input} would both be written to this file; convert them into different folders")
        };
        Some(Error::input(message).file(&path))
    })
}

/// Reads `--pieces`.
fn number_of_pieces(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let number = text.parse().ok().and_then(NonZeroUsize::new);
    number.ok_or_else(|| "it must be a whole number from 1 on".to_owned())
}
