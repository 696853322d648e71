//! `azimesh convert`.

mod by_ranks;
mod changes;
mod target;

use super::input::Input;
use super::output::OutputArgs;
use super::{Context, Outcome};
use azimesh_core::error::{Error, ErrorKind, Result, counted};
use azimesh_core::{Note, note};
use azimesh_io::formats::{self, Loaded, Staged};
use azimesh_io::mesh::{Mesh, Reordering};
use changes::Changes;
pub(super) use changes::patch_type;
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
pub use target::Outputs;
use target::{Place, Written};

/// Arguments of `azimesh convert`.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "azimesh convert [OPTIONS] IN OUT\n       \
azimesh convert [OPTIONS] IN... OUT.vtkhdf|OUT.cgns|OUT.pvd\n       \
azimesh convert [OPTIONS] IN... -o OUT\n       \
azimesh convert [OPTIONS] IN... -o DIR --format F",
    after_help = "The format of the input is recognised by its content; --format gives that of the output if \
its ending does not. A .pvd, a .vtk.series and a file of several steps are sequences: they are written to one \
file of a format that holds sequences, or to numbered files with a list, OUT.pvd or a .pvd in DIR.\n\n\
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

/// What one run does.
struct Run<'a> {
    args: &'a ConvertArgs,
    context: &'a Context,
    /// Remarks that have been made: one on every mesh of a sequence is made once.
    told: RefCell<BTreeSet<String>>,
    /// True if it has told of cells that become flat in 32 bits.
    is_flat_told: Cell<bool>,
    written: RefCell<Vec<Written>>,
    /// Files that get their names when all are whole.
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
    let (new_folder, done) = match target {
        Target::Folder(folder) => (
            Some(folder).filter(|folder| !folder.exists()),
            run.write_folder(folder),
        ),
        Target::File(out, inputs) => (None, run.write_file(out, inputs)),
    };
    run.keep(done).inspect_err(|_| {
        // Removed unless it holds something; the first error is the one to report.
        let _ = new_folder.map(std::fs::remove_dir);
    })?;
    context.tell_of_files();
    run.report()?;
    Ok(Outcome::Fine)
}

/// What the arguments say is written.
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
    /// Refuses `--pieces` for what is not written in pieces, unless it joins those of a case.
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

    /// Gives the files their names. After wrong input there are none; after a failure of the system those
    /// that are whole stay.
    fn keep(&self, done: Result<()>) -> Result<()> {
        let files = self.waiting.take();
        match done {
            Err(error) if error.kind != ErrorKind::System => return Err(error),
            _ => {}
        }
        let kept = Staged::keep_all(files);
        done.and(kept)
    }

    /// `IN OUT`, or the files of a sequence and `OUT`.
    fn write_file(&self, out: &Path, inputs: &[PathBuf]) -> Result<()> {
        self.context.check_json_beside(out)?;
        let input = match inputs {
            [] => {
                return Err(Error::input(
                    "convert needs a mesh to read and one to write, or -o DIR",
                ));
            }
            [one] => {
                let place = self.place(out)?;
                self.args.write.check(out)?;
                let input = Input::open(one, None, self.context)?;
                if place.is_one_mesh() {
                    return self.one_mesh(&input, &place);
                }
                input
            }
            several => {
                let place = self.place(out)?;
                if place.is_one_mesh() {
                    return Err(Error::input(
                        "several meshes are written to one file as a sequence, .pvd, .vtkhdf or .cgns; -o DIR \
                         converts each of them",
                    )
                    .file(out));
                }
                self.args.write.check(out)?;
                Input::of_parts(several)?
            }
        };
        input.check_files()?;
        match (self.place(out)?, input.times()) {
            (place @ Place::File { .. }, None) => self.one_mesh(&input, &place),
            (place, times) => self.sequence(&input, &times.unwrap_or(vec![0.0]), &place),
        }
    }

    /// Each input into a folder.
    fn write_folder(&self, folder: &Path) -> Result<()> {
        let format = self.output_format(None)?;
        if folder.is_file() {
            return Err(Error::input("this is a file, not a folder").file(folder));
        }
        let is_case = format.case.is_some() && self.args.paths.len() == 1;
        let open = |path: &PathBuf| Input::open(path, None, self.context);
        let inputs = self.args.paths.iter().map(open);
        let inputs = inputs.collect::<Result<Vec<_>>>()?;
        if self.args.step.is_none() {
            inputs.iter().try_for_each(Input::check_files)?;
        }
        let mut names = BTreeSet::new();
        for input in &inputs {
            if !names.insert(input.stem()) {
                return Err(Error::input(format!(
                    "another input is also called {}; both would be written to the same file",
                    input.stem()
                ))
                .file(input.path()));
            }
        }
        if !is_case {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
        }
        for input in &inputs {
            self.order.take();
            // One mesh, or one sequence, makes the folder itself the case.
            let stem = if is_case {
                folder.to_path_buf()
            } else {
                folder.join(input.stem())
            };
            match (input.times(), self.args.step) {
                (Some(times), None) if format.case.is_some() => {
                    let path = stem;
                    self.sequence(input, &times, &Place::File { path, format })?;
                }
                (Some(times), None) => {
                    let place = Place::listed(&stem, format);
                    self.sequence(input, &times, &place)?;
                }
                _ => {
                    let path = match format.case {
                        Some(_) => stem,
                        None => target::with_ending(&stem, self.ending(format)),
                    };
                    if !is_case {
                        self.args.write.check(&path)?;
                    }
                    self.one_mesh(input, &Place::File { path, format })?;
                }
            }
        }
        Ok(())
    }

    fn one_mesh(&self, input: &Input, place: &Place) -> Result<()> {
        let Place::File { path, format } = place else {
            return self.sequence(input, &[0.0], place);
        };
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

    /// The mesh of a step, changed as asked.
    fn read(&self, input: &Input, step: Option<usize>) -> Result<Mesh> {
        let loaded = input.read(step, self.context)?;
        self.tell_notes(input, &loaded);
        let mut mesh = loaded.mesh;
        let remarks = self.args.changes.apply(&mut mesh);
        for remark in remarks.map_err(|error| error.file(input.path()))? {
            self.tell(remark);
        }
        if self.args.reorder {
            self.reorder(&mut mesh);
        }
        Ok(mesh)
    }

    /// Puts nodes and cells along a curve; those of later steps of a sequence in the order of the first, by which a step
    /// differs from the next as it did before. A step with another number of nodes or cells has an order of its own.
    fn reorder(&self, mesh: &mut Mesh) {
        let mut order = self.order.borrow_mut();
        let known = order.take().filter(|order| order.fits(mesh));
        let order = order.insert(known.unwrap_or_else(|| Reordering::along_curve(mesh)));
        mesh.reorder(order);
        self.tell(note!(
            "reordered",
            "--reorder: {} and {} along a space-filling curve",
            counted(mesh.points.len(), "node"),
            counted(mesh.cells.len(), "cell")
        ));
    }

    /// Tells what the reader of an input remarks.
    fn tell_notes(&self, input: &Input, loaded: &Loaded) {
        // Of steps it has told how to choose another.
        for note in loaded.notes.iter() {
            if note.code == "last_of_steps" {
                continue;
            }
            self.tell(note.clone().file(input.path()));
        }
    }

    /// Makes a remark, once.
    fn tell(&self, remark: Note) {
        if self.told.borrow_mut().insert(remark.to_string()) {
            self.context.note(remark);
        }
    }

    fn report(&self) -> Result<()> {
        let written = self.written.take();
        if self.context.common.json {
            return self.context.print_json(&Outputs::of(written));
        }
        for file in &written {
            self.context.detail(&file.to_string());
        }
        Ok(())
    }

    /// The format that `--format` or, without it, the name of the output gives.
    fn output_format(&self, path: Option<&Path>) -> Result<&'static formats::Format> {
        match (&self.context.common.format, path) {
            (Some(name), _) => formats::to_write(formats::by_name(name)?),
            (None, Some(path)) => formats::by_extension(path),
            (None, None) => Err(Error::input("-o DIR needs --format")),
        }
    }
}

/// Reads `--pieces`.
fn number_of_pieces(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let number = text.parse().ok().and_then(NonZeroUsize::new);
    number.ok_or_else(|| "it must be a whole number from 1 on".to_owned())
}
