//! `azimesh quality`.

mod json;
mod table;
mod worst;

use super::deform::complain_of_all;
use super::input::Input;
use super::output::{self, OutputArgs};
use super::{Context, Outcome};
use crate::record::Criterion;
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::with_verb;
use azimesh_core::{Note, note};
use azimesh_io::formats::{Format, SharedFile, guard_inputs};
use azimesh_io::mesh::{Cells, Mesh, RankPart, in_32_bits};
use azimesh_quality::{
    Assessment, Flaws, QualityEvaluator, Reference, Statistic, remarks, statistics,
};
pub use json::QualityResult;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use worst::{WorstCell, WorstCells};

/// Arguments of `azimesh quality`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A cell is inverted if it is valid in the reference mesh and one of its corners has turned over \
or become flat, or if it is not valid there and its positive volume has become zero or negative. Without --reference a cell of one mesh is inverted if it is not valid in \
the orientation of the cells around it; it counts as inverted_reference too. Solid cells whose nodes are in reverse order \
count as inverted_reference, and are judged as mirror images. negative_cells have a negative volume in the order of their \
nodes, as in azimesh info. The reference of a sequence is its first mesh.\n\n\
For one mesh the smallest, mean and largest value of every metric are printed too; for a sequence, one row per step: those with \
the smallest scaled Jacobian, the worst first, and a line on the worst of all."
)]
pub struct QualityArgs {
    /// Mesh, or a sequence: a .pvd, the folder that deform has written, a .vtkhdf or .cgns of several
    /// steps; - is standard input
    mesh: PathBuf,
    /// Undeformed mesh with the same cells
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// List the N cells with the smallest scaled Jacobian (of a sequence, over all steps)
    #[arg(long, value_name = "N", default_value_t = 0)]
    worst: usize,
    /// Of a sequence, print the row of every step, in order; without it the rows of the ten worst steps
    #[arg(long)]
    all: bool,
    /// Exit with code 1 if this holds (at any step), such as "inverted>0" or "min_scaled_jacobian<0.1";
    /// repeatable
    #[arg(long, value_name = "EXPR")]
    fail_on: Vec<Criterion>,
    /// Write the mesh with every metric as a cell array; --format gives its format if the ending does
    /// not. With --precision f32 all results refer to the rounded coordinates
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    write: OutputArgs,
}

/// A step of a sequence.
#[derive(Debug, Clone, Copy)]
struct Step {
    index: usize,
    time: f64,
}

/// An evaluated mesh.
struct Judged {
    /// `None` for a single mesh.
    step: Option<Step>,
    quality: Assessment,
    /// Indices in `--fail-on` of the conditions that hold, each with the value of its column.
    met: Vec<(usize, f64)>,
}

/// The results.
struct Findings<'a> {
    meshes: Vec<Judged>,
    /// For a single mesh only.
    metrics: Option<Vec<Statistic>>,
    flaws: Flaws,
    worst: WorstCells,
    /// Number of listed cells.
    n_listed: usize,
    /// True if the row of every step is printed.
    all: bool,
    fail_on: &'a [Criterion],
}

pub(super) fn run(args: &QualityArgs, context: &Context) -> Result<Outcome> {
    for criterion in &args.fail_on {
        criterion.check_of_meshes()?;
    }
    let format = output_format(args, context)?;
    let input = Input::open_shared(&args.mesh, context)?;
    let findings = match input.times() {
        Some(_) if args.output.is_some() => {
            let message = "this is a sequence, and -o writes one mesh: give one of its files, or set \
                           output.quality = \"cells\" for deform";
            return Err(Error::input(message).file(&args.mesh));
        }
        Some(times) => judge_sequence(args, context, &input, &times)?,
        None => judge_mesh(args, context, input, format)?,
    };
    let beside = args
        .output
        .as_ref()
        .is_some_and(|path| path.as_os_str() == "-");
    findings.tell(context, beside)?;
    Ok(if findings.met().is_empty() {
        Outcome::Fine
    } else {
        Outcome::CheckFailed
    })
}

impl QualityArgs {
    /// Returns whether several ranks share the work: if no mesh is written.
    pub fn is_shared(&self) -> bool {
        self.output.is_none()
    }
}

/// The format of the mesh that is written, if one is. Also refuses to replace a file.
fn output_format(args: &QualityArgs, context: &Context) -> Result<Option<&'static Format>> {
    let Some(path) = &args.output else {
        return Ok(None);
    };
    context.check_json_beside(path)?;
    guard_inputs(std::iter::once(&args.mesh).chain(&args.reference));
    args.write.check(path)?;
    output::format_of(path, context).map(Some)
}

fn judge_mesh<'a>(
    args: &'a QualityArgs,
    context: &Context,
    input: Input,
    format: Option<&'static Format>,
) -> Result<Findings<'a>> {
    let mut mesh = read(args, &input, None, context, &mut BTreeSet::new())?;
    let given = given_reference(args, context)?;
    if let Some(given) = &given {
        let checked = context.ranks.all_ok(given.check(&mut mesh));
        checked.map_err(|error| error.file(&args.mesh))?;
    }
    let judge = match given {
        Some(given) => given.judge,
        None => {
            let own = || Ok(QualityEvaluator::new(&mesh));
            let mut judge = context.stage("reference", own)?;
            if context.ranks.n() > 1 && !judge.reference.is_uniform() {
                context.tell_why_whole(input.path(), "cells that are not valid, or reversed");
                if !context.ranks.is_first() {
                    return Ok(Findings::new(args));
                }
                mesh = input.read(None, context)?.mesh;
                judge = QualityEvaluator::new(&mesh);
            }
            judge.upright(&mesh, false)
        }
    };
    // A mapped file would count as memory of the program until its end.
    drop(input);
    for remark in remarks(&mesh) {
        context.note(remark);
    }
    // Results for a written mesh refer to its coordinates in the file.
    if format.is_some_and(|format| format.rounds(args.write.precision)) {
        mesh.points.iter_mut().for_each(|x| *x = in_32_bits(*x));
    }
    let mut findings = Findings::new(args);
    findings.take(None, &mesh, &judge, context)?;
    findings.flaws = Flaws::of(&mesh, &mesh.points, &judge.reference);
    if args.reference.is_none() {
        complain_of_reference(&judge.reference, context);
    }
    let every = || Ok(statistics(&mesh, &mesh.points, &judge.reference));
    findings.metrics = Some(context.stage("metrics", every)?);
    if let (Some(path), Some(format)) = (&args.output, format) {
        let with_arrays = with_arrays(mesh, &judge);
        args.write.save(&with_arrays, path, format, context)?;
    }
    Ok(findings)
}

/// Reports cells that a mesh, as its own reference, counts as `inverted_reference`.
fn complain_of_reference(reference: &Reference, context: &Context) {
    let n_reversed = reference.n_reversed();
    let n_folded = reference.n_inverted() - n_reversed;
    if n_folded > 0 {
        context.complain(note!(
            "not_valid",
            "{} not valid in the mesh itself, counted as inverted_reference; azimesh repair moves nodes, \
             --reference MESH compares with another mesh",
            with_verb(n_folded, "cell", "is")
        ));
    }
    if n_reversed > 0 {
        context.complain(note!(
            "reversed",
            "{} listed in the other orientation, with nodes in reverse order: counted as inverted_reference, and evaluated \
             as mirror images",
            with_verb(n_reversed, "cell", "is")
        ));
    }
}

fn judge_sequence<'a>(
    args: &'a QualityArgs,
    context: &Context,
    input: &Input,
    times: &[f64],
) -> Result<Findings<'a>> {
    let mut given = given_reference(args, context)?;
    let mut findings = Findings::new(args);
    if context.ranks.n() == 1 {
        // The worst step is named with its cell.
        findings.worst = WorstCells::new(args.worst.max(1));
    }
    let mut told = BTreeSet::new();
    for (index, &time) in times.iter().enumerate() {
        let mut mesh = read(args, input, Some(index), context, &mut told)?;
        let given = given.get_or_insert_with(|| Given::new(&mesh));
        let checked = context.ranks.all_ok(given.check(&mut mesh));
        checked.map_err(|error| error.file(input.path_of(index)))?;
        for remark in remarks(&mesh) {
            if told.insert(remark.to_string()) {
                context.note(remark);
            }
        }
        let step = Some(Step { index, time });
        findings.take(step, &mesh, &given.judge, context)?;
    }
    Ok(findings)
}

/// Reads a mesh; prints notes that concern every mesh of a sequence only once.
fn read(
    args: &QualityArgs,
    input: &Input,
    step: Option<usize>,
    context: &Context,
    told: &mut BTreeSet<String>,
) -> Result<Mesh> {
    let mut is_new = |text: &str| told.insert(text.to_owned());
    let file = || match args.worst {
        0 => input.shared(step, context),
        _ => Err("--worst names the tags near cells".to_owned()),
    };
    let whole = || {
        let loaded = input.read(step, context)?;
        for note in loaded.notes.iter() {
            let note = note.clone().file(input.path());
            if is_new(&note.to_string()) {
                context.note(note);
            }
        }
        Ok(loaded.mesh)
    };
    let (mesh, reason) = context.read_shared(file, whole)?;
    if let Some(reason) = reason.filter(|reason| is_new(reason)) {
        context.tell_why_whole(input.path(), &reason);
    }
    Ok(mesh)
}

/// A reference for several meshes.
struct Given {
    judge: QualityEvaluator,
    cells: Cells,
    part: Option<Arc<RankPart>>,
}

fn given_reference(args: &QualityArgs, context: &Context) -> Result<Option<Given>> {
    let Some(path) = &args.reference else {
        return Ok(None);
    };
    let whole = || context.read_mesh(path);
    let file = || {
        let format = context.input_format().map_err(|error| error.message)?;
        SharedFile::new(path, format, &context.read_options())
    };
    let (mesh, reason) = context.read_shared(file, whole)?;
    if let Some(reason) = reason {
        context.tell_why_whole(path, &reason);
    }
    Ok(Some(Given::new(&mesh)))
}

impl Given {
    fn new(mesh: &Mesh) -> Self {
        Self {
            judge: QualityEvaluator::new(mesh),
            cells: mesh.cells.clone(),
            part: mesh.part.clone(),
        }
    }

    /// Refuses a mesh with other cells.
    fn check(&self, mesh: &mut Mesh) -> Result<()> {
        if !mesh.cells.follow(&self.cells) || self.part != mesh.part {
            let message = "its cells differ from the reference mesh, which must have the same cells in \
                           the same order";
            return Err(Error::input(message));
        }
        Ok(())
    }
}

impl<'a> Findings<'a> {
    fn new(args: &'a QualityArgs) -> Self {
        Self {
            meshes: Vec::new(),
            metrics: None,
            flaws: Flaws::default(),
            worst: WorstCells::new(args.worst),
            n_listed: args.worst,
            all: args.all,
            fail_on: &args.fail_on,
        }
    }

    /// Evaluates a mesh.
    fn take(
        &mut self,
        step: Option<Step>,
        mesh: &Mesh,
        judge: &QualityEvaluator,
        context: &Context,
    ) -> Result<()> {
        let points = &mesh.points;
        let quality = Assessment {
            cells: context.stage("cells", || Ok(judge.cells(mesh, points)))?,
            faces: context.stage("faces", || Ok(judge.faces(mesh, points)))?,
        };
        let mut met = Vec::new();
        for (i, criterion) in self.fail_on.iter().enumerate() {
            if let Some(value) = criterion.met_by(&quality.columns())? {
                met.push((i, value));
            }
        }
        self.worst.consider(step, mesh, &judge.reference);
        self.meshes.push(Judged { step, quality, met });
        Ok(())
    }

    /// Returns the conditions that hold, with their steps and notes, the worst first.
    fn met(&self) -> Vec<(&'a Criterion, Vec<StepNote>)> {
        let of = |(i, criterion): (usize, &'a Criterion)| {
            let all = self.meshes.iter().flat_map(|mesh| {
                let own = mesh.met.iter().filter(move |(met, _)| *met == i);
                own.map(|(_, value)| (mesh.step.map(|step| step.index), *value))
            });
            let mut all: Vec<(Option<usize>, f64)> = all.collect();
            all.sort_by(|a, b| criterion.worst_first(a.1, b.1));
            let note = |(step, value)| (step, criterion.note(step, value));
            (criterion, all.into_iter().map(note).collect())
        };
        let met = self.fail_on.iter().enumerate().map(of);
        met.filter(|(_, notes): &(_, Vec<_>)| !notes.is_empty())
            .collect()
    }

    /// Returns the listed cells.
    fn listed(&self) -> &[WorstCell] {
        &self.worst.cells[..self.n_listed.min(self.worst.cells.len())]
    }

    /// Returns the worst cell of a sequence.
    fn worst_of_sequence(&self) -> Option<&WorstCell> {
        self.worst.cells.first().filter(|cell| cell.step.is_some())
    }

    /// Prints the results, to stderr if a mesh is written to standard output.
    fn tell(&self, context: &Context, beside: bool) -> Result<()> {
        let met = self.met().into_iter().flat_map(|(_, met)| met);
        complain_of_all(&met.map(|(_, note)| note).collect::<Vec<Note>>(), context);
        let text = || table::as_text(self);
        match (context.common.json, beside) {
            (true, _) => context.print_json(&QualityResult::of(self))?,
            (false, true) => context.print_aside(&text()),
            (false, false) => context.print_result(&text())?,
        }
        Ok(())
    }
}

/// A condition that holds, and the index of the step of a sequence.
type StepNote = (Option<usize>, Note);

/// Returns the mesh with an array for each metric; existing arrays of the same names are replaced.
fn with_arrays(mut mesh: Mesh, judge: &QualityEvaluator) -> Mesh {
    let arrays = judge.arrays(&mesh, &mesh.points);
    mesh.cell_arrays
        .retain(|old| arrays.iter().all(|new| new.name != old.name));
    mesh.cell_arrays.extend(arrays);
    mesh
}
