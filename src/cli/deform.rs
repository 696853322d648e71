//! `azimesh deform`: one deformed mesh per azimuth step.

use super::convert::patch_type;
use super::shared::why_not_run;
use super::{Context, Outcome, memory};
use crate::alloc::limit;
use crate::preflight::{Fits, check_memory, existing_folder};
use crate::record::{Criterion, Failed, Failure, Level, Timings, WorstStep, sentences};
use crate::run::{Finished, Request, run_after};
use azimesh_core::error::{Error, Result, counted, path_in_line};
use azimesh_core::numbers::{amount, in_digits};
use azimesh_core::progress::Stop;
use azimesh_core::ranks::Ranks;
use azimesh_core::{Note, note};
use azimesh_deform::motion::{QualityOutput, Schedule};
use azimesh_deform::{Deformation, Plan, ReadWhole};
use azimesh_io::formats::openfoam::{files_of_origin, set_patch_types};
use azimesh_io::formats::{self, SharedFile};
use azimesh_io::mesh::{Mesh, OneLayer};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest number of warnings of one kind shown without `-v`.
const SHOWN: usize = 5;

/// Arguments of `azimesh deform`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The format of the mesh is recognised by its content; --format replaces output.format of the schedule: a \
format of whole meshes, not stl or vtp (`azimesh convert DIR -o OUT --format stl` writes the surface of each step).\n\n\
In ParaView open the .pvd (VTU files), the .vtk.series (vtk) or the .cgns, in any version; a .vtkhdf \
needs 5.12 or later. Of an OpenFOAM case it lists time 0 only if there is a folder 0 and \"Skip Zero Time\" is off."
)]
pub struct DeformArgs {
    /// Mesh with boundary tags; `-` reads standard input
    mesh: PathBuf,
    /// Motion schedule (TOML)
    schedule: PathBuf,
    /// Folder for the meshes, steps.csv, base points and run.json; for OpenFOAM the case
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Base points that `azimesh select` has saved
    #[arg(long, value_name = "BASE")]
    base: Option<PathBuf>,
    /// Write only steps A to B - 1, counted from 0; the meshes equal those in a run of all steps
    #[arg(long, value_name = "A..B", value_parser = step_range)]
    steps: Option<Range<usize>>,
    /// Type of the patch that a boundary tag becomes in OpenFOAM, as for `convert`; repeatable
    #[arg(long, value_name = "TAG=TYPE", value_parser = patch_type)]
    patch_type: Vec<(String, String)>,
    /// Replace the files of an earlier run in the folder
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Continue the run in the folder, after its inputs and files are verified; start one where there
    /// is none
    #[arg(long)]
    resume: bool,
    /// Skip steps that fail, or that have inverted cells with `on_inverted = "stop"`, and continue;
    /// the exit code is 1
    #[arg(long)]
    keep_going: bool,
    /// Start even if a body leaves the bounding box of the mesh
    #[arg(long)]
    allow_outside: bool,
    /// Start even if the disk has no room for all steps
    #[arg(long)]
    no_space_check: bool,
    /// Do not wait until each step is on the disk: faster on some disks, but a power cut may lose steps
    /// that are in steps.csv
    #[arg(long)]
    no_sync: bool,
    /// Exit with code 1 if this holds at any step, such as "min_scaled_jacobian<0.1"; any column of
    /// steps.csv; repeatable. --resume without it uses the conditions of the earlier run
    #[arg(long, value_name = "EXPR")]
    fail_on: Vec<Criterion>,
}

impl DeformArgs {
    fn request(&self, context: &Context) -> Request {
        Request {
            arguments: context.arguments.clone(),
            mesh: self.mesh.clone(),
            files: Vec::new(),
            folder: self.output.clone(),
            base: self.base.clone(),
            steps: self.steps.clone(),
            tag_array: context.common.tag_array.clone(),
            force: self.force,
            resume: self.resume,
            keep_going: self.keep_going,
            allow_outside: self.allow_outside,
            no_space_check: self.no_space_check,
            no_sync: self.no_sync,
            bytes_in_files: 0,
            fail_on: self.fail_on.clone(),
        }
    }
}

/// The mesh of a rank, and the way the first rank gets the rest.
#[derive(Default)]
struct RankMesh {
    /// The whole mesh on one rank; else the part of this rank.
    mesh: Mesh,
    /// A function that reads the whole mesh, on the first of several ranks.
    whole: Option<ReadWhole>,
    /// The kinds of all cells, the groups and the arrays; on the first rank, if all ranks write the mesh together.
    layout: Option<Mesh>,
    /// Reason why the first rank has read the whole mesh.
    why_whole: Option<String>,
}

pub(super) fn run_command(args: &DeformArgs, context: &Context) -> Result<Outcome> {
    let ranks = &context.ranks;
    let stop = Arc::new(Stop::default());
    #[cfg(unix)]
    ranks.all_ok(if ranks.is_first() {
        super::signals::listen(&stop)
    } else {
        Ok(())
    })?;
    let kept = formats::KeptInputs::begin();
    let mut schedule = ranks.all_ok(context.read_schedule(&args.schedule))?;
    check_same_on_ranks(&kept, ranks)?;
    if let Some(name) = context.common.one_format()? {
        let format = formats::to_write(formats::by_name(name)?)?;
        schedule.output.format = Some(format.name.to_owned());
    }
    if let Some(kinds) = ranks.kinds_of_processors() {
        return Err(Error::input(format!(
            "ranks run on processors of several kinds ({kinds}), which round sums in different ways; start them on machines of \
             one kind"
        )));
    }
    let with_files = context.keep_in_files(&args.output);
    let Some(read) = read(args, &schedule, context)? else {
        return Ok(Outcome::Fine);
    };
    let planned = Deformation::builder(read.mesh, schedule)
        .progress(context.progress().into())
        .stop(Arc::clone(&stop))
        .on_ranks(read.whole, read.layout)
        .plan();
    let mut deformation = planned.map_err(|error| error.file(&args.mesh))?;
    check_same_on_ranks(&kept, ranks)?;
    if !ranks.is_first() {
        deformation.follow();
        return Ok(Outcome::Fine);
    }
    deformation.lead();
    let outcome = run_first(args, &deformation, with_files, context);
    deformation.end();
    let why_whole = read.why_whole.or_else(|| deformation.why_whole());
    if let Some(reason) = why_whole {
        context.tell_why_whole(&args.mesh, &reason);
    }
    outcome
}

/// Refuses input files that differ between ranks, as on an outdated network disk: ranks would compute different motions.
fn check_same_on_ranks(kept: &formats::KeptInputs, ranks: &Ranks) -> Result<()> {
    let mut seen = BTreeMap::new();
    for (path, size, modified) in ranks.allgather(kept.stamps()).concat() {
        let first = *seen.entry(path.clone()).or_insert((size, modified));
        if first != (size, modified) {
            let reason = "ranks see different versions of it; wait until the disk shows all of them the same, and start again";
            return Err(Error::input(reason).file(&path));
        }
    }
    Ok(())
}

/// Runs on the first rank, which writes; the other ranks follow.
fn run_first(
    args: &DeformArgs,
    deformation: &Deformation,
    with_files: bool,
    context: &Context,
) -> Result<Outcome> {
    let plan = deformation.plan();
    let mut request = args.request(context);
    request.files = further_files(args, plan, deformation.mesh_to_write()?);
    if let Some(limit) = context.common.max_memory {
        request.bytes_in_files =
            fit_into_memory(deformation, limit, with_files, &request, context)?;
    }
    for choice in &plan.choices {
        context.note(choice.clone());
    }
    let mut n_printed = 0;
    let finished = run_after(deformation, &request, &mut |warnings| {
        tell_warnings(warnings, context);
        n_printed = warnings.len();
    })?;
    context.tell_of_files();
    report(&args.output, finished, n_printed, context)
}

/// Returns the files that were opened besides those that the command line and the schedule name: pieces and linked files of
/// the mesh, conditions of its tags, files of files of the schedule. A case counts as one file.
fn further_files(args: &DeformArgs, plan: &Plan, mesh: &Mesh) -> Vec<PathBuf> {
    let named = [&args.mesh, &args.schedule].map(PathBuf::clone);
    let mut named: Vec<PathBuf> = named.into_iter().chain(plan.schedule.files()).collect();
    named.extend(files_of_origin(mesh));
    let named = formats::Inputs::of(named);
    let opened = formats::opened_inputs().into_iter();
    opened.filter(|path| named.find(path).is_none()).collect()
}

/// Reads the mesh of each rank; `None` on ranks that the run does not need.
fn read(args: &DeformArgs, schedule: &Schedule, context: &Context) -> Result<Option<RankMesh>> {
    let ranks = &context.ranks;
    let whole = || {
        let mut mesh = context.read_mesh(&args.mesh)?;
        set_patch_types(&mut mesh, &args.patch_type).map_err(|error| error.file(&args.mesh))?;
        Ok(mesh)
    };
    if ranks.n() == 1 {
        let mesh = whole()?;
        return Ok(Some(RankMesh {
            mesh,
            ..RankMesh::default()
        }));
    }
    let reason = match read_together(args, schedule, context) {
        Ok(read) => return Ok(Some(read)),
        Err(reason) => reason,
    };
    let mesh = ranks.all_ok(ranks.is_first().then(whole).transpose())?;
    if ranks.broadcast(mesh.as_ref().map(OneLayer::has_sides)) {
        let reason = "it is one layer of cells; the first rank works alone";
        return Ok(mesh.map(|mesh| RankMesh {
            mesh,
            why_whole: Some(reason.to_owned()),
            ..RankMesh::default()
        }));
    }
    let mut part = Mesh::shared_of(mesh.as_ref(), ranks);
    if let Some(mesh) = &mesh {
        part.origin = mesh.origin.clone();
        part.field_arrays.clone_from(&mesh.field_arrays);
    }
    let read = mesh.map(|mesh| -> ReadWhole {
        let mesh = Arc::new(mesh);
        Box::new(move || Ok(Arc::clone(&mesh)))
    });
    Ok(Some(RankMesh {
        mesh: part,
        whole: read,
        why_whole: Some(reason),
        ..RankMesh::default()
    }))
}

/// Reads the mesh of each rank, if all ranks read it and write it together.
///
/// # Errors
/// On all ranks, the reason why the first rank has to read the mesh as a whole.
fn read_together(
    args: &DeformArgs,
    schedule: &Schedule,
    context: &Context,
) -> std::result::Result<RankMesh, String> {
    if schedule.output.quality == QualityOutput::Cells {
        return Err("it makes arrays of all cells (quality = \"cells\")".to_owned());
    }
    if let Some(reason) = why_not_run(schedule) {
        return Err(reason.to_owned());
    }
    if !args.patch_type.is_empty() {
        return Err("--patch-type may make it one layer of cells".to_owned());
    }
    let format = formats::by_name(schedule.output.format()).map_err(|error| error.message)?;
    // Created before the read: ranks use it to check that they read the same file.
    let given = context.input_format().map_err(|error| error.message)?;
    let file = SharedFile::new(&args.mesh, given, &context.read_options());
    let shared = context.read_together(|| file.clone(), format)?;
    if OneLayer::has_sides(&shared.part) {
        return Err("it is one layer of cells".to_owned());
    }
    let file = file.ok().filter(|_| context.ranks.is_first());
    Ok(RankMesh {
        mesh: shared.part,
        whole: file.map(|file| -> ReadWhole { Box::new(move || file.read_whole().map(Arc::new)) }),
        layout: shared
            .layout
            .map(|layout| context.with_notes(layout, &args.mesh)),
        ..RankMesh::default()
    })
}

/// Refuses a run that exceeds the allowed memory. Returns the bytes of its arrays in files.
fn fit_into_memory(
    deformation: &Deformation,
    limit: u64,
    with_files: bool,
    request: &Request,
    context: &Context,
) -> Result<u64> {
    let mapped = memory::mapped_bytes(&request.mesh);
    let (plan, mesh) = (deformation.plan(), deformation.mesh_to_write()?);
    match check_memory(plan, mesh, limit, with_files, mapped)? {
        Fits::InMemory => {
            limit::keep_in_memory(limit);
            Ok(0)
        }
        Fits::InFiles(needed) => {
            context.note(note!(
                "arrays_in_files",
                "this run needs about {} of memory, and --max-memory allows {}: large arrays are stored in files without a name in {} \
                 while it runs",
                amount(needed),
                amount(limit),
                existing_folder(&request.folder).display()
            ));
            // Half of the memory is used when the first array is stored in a file.
            Ok(needed - limit / 2)
        }
    }
}

/// Reads `A..B`.
fn step_range(text: &str) -> std::result::Result<Range<usize>, String> {
    let ends = text.split_once("..").and_then(|(start, end)| {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        Some(number(start)?..number(end)?)
    });
    ends.ok_or_else(|| {
        format!(
            "\"{text}\" is not a range of steps; write A..B, such as 0..90 for the first ninety"
        )
    })
}

/// Prints the result of a sequence; the first `n_told` warnings have been printed.
///
/// # Errors
/// The failed check that ended it early, after its JSON.
pub(super) fn report(
    folder: &Path,
    finished: Finished,
    n_told: usize,
    context: &Context,
) -> Result<Outcome> {
    if finished.ended_by.is_none() {
        tell_warnings(&finished.warnings[n_told..], context);
        if context.common.quiet {
            complain_of_some(&finished.inverted, context);
        }
        for notes in [&finished.skipped, &finished.failures] {
            complain_of_all(notes, context);
        }
    } else {
        keep(&finished.warnings[n_told..], context);
    }
    if context.common.json {
        context.print_json(&as_json(folder, &finished))?;
    } else if finished.ended_by.is_none() {
        context.print_result(&summary(folder, &finished))?;
    }
    if let Some(error) = finished.ended_by {
        return Err(error);
    }
    Ok(if finished.is_failed() {
        Outcome::CheckFailed
    } else {
        Outcome::Fine
    })
}

fn as_json(folder: &Path, finished: &Finished) -> Deformed {
    Deformed {
        folder: folder.display().to_string(),
        outcome: finished.outcome.clone(),
        steps_written: finished.n_steps,
        steps_kept: finished.n_kept,
        skipped_steps: sentences(&finished.skipped),
        base_points: finished.n_base,
        selection_error: Some(finished.selection_error),
        max_surface_error: Some(finished.surface_error),
        inverted_steps: finished.inverted_steps,
        max_inverted: finished.max_inverted,
        min_scaled_jacobian: finished.min_scaled_jacobian,
        worst_step: finished.worst_step.clone(),
        mesh_bytes: finished.mesh_bytes,
        failures: finished.failures.iter().map(Failure::from).collect(),
        error: finished.ended_by.as_ref().map(Failed::from),
        seconds: finished.timings,
    }
}

/// The result of a run, or of parts that were joined, with the keys of run.json.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Deformed {
    /// The folder.
    folder: String,
    /// `complete`, `complete but for N steps`, or the failed check that ended the run.
    outcome: String,
    /// Steps that are in the folder.
    steps_written: usize,
    /// Of them, steps that were there before; after `finish` all where nothing had to be written, else 0.
    steps_kept: usize,
    /// Steps that `--keep-going` skipped, with the reasons.
    skipped_steps: Vec<String>,
    /// Number of base points; with `real` the largest.
    base_points: usize,
    /// Largest error before the correction, mesh units.
    selection_error: Option<f64>,
    /// Largest error as written, mesh units.
    max_surface_error: Option<f64>,
    /// Steps with inverted cells; null where quality was not computed.
    inverted_steps: Option<usize>,
    /// Inverted cells of the worst step; null likewise.
    max_inverted: Option<usize>,
    /// Smallest scaled Jacobian of all steps; null likewise.
    min_scaled_jacobian: Option<f64>,
    /// The step with it; null likewise.
    worst_step: Option<WorstStep>,
    /// Bytes of one mesh file (of all steps where one file holds them).
    mesh_bytes: u64,
    /// Conditions of `--fail-on` that failed, and other checks.
    failures: Vec<Failure>,
    /// The error that ended the run before its last step; absent without.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Failed>,
    /// Seconds of each stage, all runs of the folder together.
    seconds: Timings,
}

/// Warnings: in JSON all of them, printed some unless quiet.
fn tell_warnings(warnings: &[Note], context: &Context) {
    if context.common.quiet {
        keep(warnings, context);
    } else {
        complain_of_all(warnings, context);
    }
}

/// Failed checks: in JSON all of them, printed the first of each kind.
pub(super) fn complain_of_all(notes: &[Note], context: &Context) {
    complain_of_some(notes, context);
    keep(notes, context);
}

fn keep(warnings: &[Note], context: &Context) {
    for warning in warnings {
        context.keep(Level::Warning, warning);
    }
}

/// Prints the first notes of each kind, or all with `-v`: a condition may fail at every step.
fn complain_of_some(notes: &[Note], context: &Context) {
    for alike in by_sort(notes) {
        let shown = match context.common.verbose {
            0 => alike.len().min(SHOWN),
            _ => alike.len(),
        };
        for note in &alike[..shown] {
            context.print_warning(&note.to_string());
        }
        if shown < alike.len() {
            context.print_warning(&format!(
                "and {} more like these; -v shows them, run.json and steps.csv have them",
                alike.len() - shown
            ));
        }
    }
}

/// Groups notes by their kind, in the order of the first of each.
fn by_sort(notes: &[Note]) -> Vec<Vec<&Note>> {
    let mut sorts: Vec<Vec<&Note>> = Vec::new();
    for note in notes {
        let mut known = sorts.iter_mut();
        match known.find(|alike| is_like(alike[0], note)) {
            Some(alike) => alike.push(note),
            None => sorts.push(vec![note]),
        }
    }
    sorts
}

/// Checks if two notes differ only in names and numbers.
fn is_like(a: &Note, b: &Note) -> bool {
    let is_alike = match &*a.code {
        "skipped" => words(&a.text).eq(words(&b.text)),
        _ => a.get("metric") == b.get("metric"),
    };
    a.code == b.code && is_alike
}

/// Returns the words of a sentence without those that contain numbers, in the singular.
fn words(sentence: &str) -> impl Iterator<Item = &str> {
    let has_digit = |word: &&str| word.contains(|c: char| c.is_ascii_digit());
    let words = sentence.split_whitespace();
    words
        .filter(move |word| !has_digit(word))
        .map(|word| word.trim_end_matches('s'))
}

fn summary(folder: &Path, finished: &Finished) -> String {
    let kept = match finished.n_kept {
        0 => String::new(),
        1 if finished.n_steps == 1 => {
            "complete already: the file of the one step was verified\n".to_owned()
        }
        n if n == finished.n_steps => {
            format!("complete already: the files of all {n} steps were verified\n")
        }
        n => {
            let were = if n == 1 { "step was" } else { "steps were" };
            let added = finished.n_steps.saturating_sub(n);
            format!("{n} {were} finished before and verified, {added} added\n")
        }
    };
    let jacobian = finished.min_scaled_jacobian.map_or(String::new(), |value| {
        format!(", smallest scaled Jacobian {}", in_digits(value, 4))
    });
    let inverted = match finished.inverted_steps {
        Some(0) => "no inverted cells".to_owned(),
        Some(n) => format!("{} with inverted cells", counted(n, "step")),
        None => "cell quality was not computed".to_owned(),
    };
    let worst = (finished.worst_step.as_ref())
        .map_or_else(String::new, |worst| format!("worst: {worst}\n"));
    let t = &finished.timings;
    // Computed from rounded numbers, so that the printed numbers add up.
    let shown = |seconds: f64| (seconds * 100.0).round() / 100.0;
    let parts = [t.selection, t.modes, t.steps].map(shown);
    let other = (shown(t.total) - parts.iter().sum::<f64>()).max(0.0);
    format!(
        "{kept}{}: {}, {}, surface error {} ({} before the correction)\n\
         {inverted}{jacobian}\n\
         {:.2} s: selection {:.2}, modes {:.2}, steps {:.2}, other {other:.2} (writing {:.2}, partly during the steps)\n{worst}",
        path_in_line(folder),
        counted(finished.n_steps, "step"),
        counted(finished.n_base, "base point"),
        in_digits(finished.surface_error, 2),
        in_digits(finished.selection_error, 2),
        t.total,
        t.selection,
        t.modes,
        t.steps,
        t.writing,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_of_one_sort_stand_together_and_hide_no_other() {
        let inverted =
            |step: usize| note!("inverted", "step {step} has {} inverted cells", 7 * step);
        let mut notes: Vec<Note> = (0..9).map(inverted).collect();
        let gap = note!("narrow_gap", "two surfaces are near each other");
        notes.insert(8, gap.clone());
        let sorts = by_sort(&notes);
        assert_eq!(sorts.iter().map(Vec::len).collect::<Vec<_>>(), [9, 1]);
        assert_eq!(sorts[1], [&gap]);
        let skipped = ["step 1 has 2", "step 3 has 4", "body b moves"];
        let skipped = skipped.map(|text| Note::new("skipped", text));
        let holds = ["max_skew", "max_skew", "inverted"];
        let holds = holds.map(|metric| note!("condition_holds", "{metric}").with("metric", metric));
        for notes in [skipped, holds] {
            let sorts = by_sort(&notes);
            assert_eq!(sorts.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        }
    }
}
