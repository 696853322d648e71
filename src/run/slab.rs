//! One slab of a mesh at all steps: a file a step in the folder of the slab, from which [`run`](super::run()) makes the sequence
//! once all slabs have theirs.

use super::base_file;
use super::base_points::BasePointStore;
use super::compatibility::difference;
use super::finished::Finished;
use super::lock::Lock;
use super::names::{Names, RunSteps, files};
use super::record::{self, Clock, RecordFile, merged};
use super::request::Request;
use super::run::names_of;
use super::step::rounding;
use crate::deform::{Deformation, Joined, Left, Plan, SlabOf, StoredStep};
use crate::error::{Error, Result, counted};
use crate::formats::{self, Format, clear_left, read_file};
use crate::motion::Step;
use crate::preflight::{Demand, before_work, check_disk, check_surface_files};
use crate::record::{RunRecord, SelectionRecord, Timings};
use crate::sparse;
use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes of a vector in the file of a step.
const VECTOR: usize = 24;
/// Bytes beside the vectors, about.
const BESIDE: usize = 1 << 20;

/// What the work on a slab came to.
#[derive(Debug)]
pub struct FinishedSlab {
    /// Which it is.
    pub slab: SlabOf,
    /// How many nodes it has of its own.
    pub n_nodes: usize,
    /// Steps that are finished.
    pub n_steps: usize,
    /// Those of them that an earlier run had finished.
    pub n_kept: usize,
    /// Where the time went.
    pub timings: Timings,
}

/// What tells the runs of all slabs from those of other inputs, options and versions.
pub(super) fn identity(record: &RunRecord, n: usize) -> [u8; 32] {
    let inputs = record
        .inputs
        .iter()
        .map(|input| (&input.what, &input.blake3));
    let inputs: Vec<_> = inputs.collect();
    let all = serde_json::json!([record.program, inputs, record.options, n]);
    *blake3::hash(all.to_string().as_bytes()).as_bytes()
}

/// Moves the nodes of a slab and judges its cells at all steps.
///
/// # Errors
/// For inputs that do not fit and failures of the system; of kind `Interrupted` between two steps when a stop was asked for.
///
/// # Panics
/// Where the deformation is not that of one slab.
pub fn run_slab(deformation: &Deformation, request: &Request) -> Result<FinishedSlab> {
    let clock = Clock::start();
    let plan = deformation.plan();
    let slab = plan.sharing.slab().expect("it works on one slab");
    let format = formats::by_name(&plan.schedule.output.format)?;
    check_before(plan, format, request)?;
    let steps = &plan.motion.steps;
    let folder = slab.slab.folder(&request.folder);
    let part = RunSteps::new(None, steps.len())?;
    let mut names = Names::new(&folder, &request.mesh, format, steps.len(), part);
    names.folder = folder;
    names.commit.sync = !request.no_sync;
    let mut record = RecordFile::new(&names, plan, request)?;
    check_inputs(&record.content)?;
    let run = identity(&record.content, slab.slab.n);
    let own = slab.own_nodes(plan);
    let base = request.base.as_deref();
    let loaded = base.map(|path| base_file::load(plan, path)).transpose()?;
    let _lock = Lock::take(&names)?;
    let n_kept = kept(&names, &own, run, request)?;
    record.content.fail_on = request.fail_on.iter().map(ToString::to_string).collect();
    let earlier = record::read(&names.record())?.filter(|_| request.resume);
    if let Some(earlier) = earlier.as_ref().filter(|_| request.fail_on.is_empty()) {
        record.content.fail_on.clone_from(&earlier.fail_on);
    }
    let earlier = earlier.filter(|earlier| identity(earlier, slab.slab.n) == run);
    clear_left(&names.folder);
    if !request.no_space_check {
        let n_vectors = own.len() * if plan.schedule.output.velocity { 2 } else { 1 };
        let demand = demand_of(n_vectors, steps.len() - n_kept);
        check_disk(plan, &names.folder, &demand, (0, request.bytes_in_files))?;
    }
    let first_choice = (!request.force).then_some(slab.slab.number);
    let left = match loaded {
        Some(_) => None,
        None => LeftBase::find((first_choice, slab.slab.n), run, &request.folder),
    };
    let content = &mut record.content;
    if let Some(earlier) = earlier {
        (content.base_files, content.selections) = (earlier.base_files, earlier.selections);
    }
    record.save()?;
    let known = record.content.base_files.clone();
    let selections = record.content.selections.clone();
    let mut base_points = BasePointStore::new(deformation, &names, loaded, known, left);
    let mut seconds = 0.0;
    let keep = |chosen: &BasePointStore<'_>, record: &mut RecordFile| {
        let content = &mut record.content;
        content.base_files.clone_from(&chosen.base_files);
        content.selections = merged(&selections, &chosen.selections);
    };
    let result = leave_steps(
        deformation,
        (&names, run, n_kept),
        &mut base_points,
        &mut |chosen| {
            // Slabs that begin later take them from here.
            keep(chosen, &mut record);
            record.save()
        },
        &mut seconds,
    );
    keep(&base_points, &mut record);
    let is_there = |step: &&Step| path(&names, step.index).exists();
    let mut finished = Finished {
        n_steps: steps.iter().filter(is_there).count(),
        n_kept,
        ..Finished::default()
    };
    finished.timings = Timings {
        selection: base_points.seconds_selection,
        modes: base_points.seconds_modes,
        steps: seconds,
        total: clock.seconds(),
        ..Timings::default()
    };
    finished.take_selections(&record.content.selections);
    finished.warnings = base_points.warnings;
    record.close(&finished, result.as_ref().err());
    let saved = record.save_last();
    result.and(saved)?;
    Ok(FinishedSlab {
        slab: slab.slab,
        n_nodes: own.len(),
        n_steps: finished.n_steps,
        n_kept,
        timings: finished.timings,
    })
}

/// Refuses what `finish` would refuse, and more slabs than nodes.
fn check_before(plan: &Plan, format: &dyn Format, request: &Request) -> Result<()> {
    let n_nodes = plan.mesh.points.len();
    let n = plan.sharing.slab().map_or(1, |slab| slab.slab.n);
    if n > n_nodes {
        return Err(Error::input(format!(
            "there are {n} slabs of {}",
            counted(n_nodes, "node")
        )));
    }
    before_work(plan, format, &request.fail_on)?;
    check_surface_files(plan, &request.mesh)?;
    names_of(plan, format, request).map(drop)
}

/// The room that the files of some steps take, with so many vectors at the nodes of a slab.
fn demand_of(n_vectors: usize, n_steps: usize) -> Demand {
    let bytes = (VECTOR * n_vectors + BESIDE) as u64;
    Demand {
        n_steps: n_steps as u64,
        first: bytes,
        others: bytes,
    }
}

/// Refuses inputs that have no hash.
fn check_inputs(record: &RunRecord) -> Result<()> {
    match record.inputs.iter().find(|input| input.blake3.is_none()) {
        None => Ok(()),
        Some(input) => Err(Error::input(
            "is not a file, and slabs have to be sure that all have the same; write it to a file first",
        )
        .file(Path::new(&input.file))),
    }
}

/// Computes the steps that the slab lacks; `chosen` keeps base points once they are chosen.
fn leave_steps(
    deformation: &Deformation,
    (names, run, n_kept): (&Names, [u8; 32], usize),
    base_points: &mut BasePointStore<'_>,
    chosen: &mut dyn FnMut(&BasePointStore<'_>) -> Result<()>,
    seconds: &mut f64,
) -> Result<()> {
    let (plan, progress) = (deformation.plan(), deformation.progress());
    let slab = plan.sharing.slab().expect("it works on one slab");
    let mut points = sparse::zeros(plan.mesh.points.len(), [0.0; 3]);
    let steps = &plan.motion.steps;
    let todo = steps
        .iter()
        .filter(|step| !path(names, step.index).exists());
    let mut known = base_points.base_files.clone();
    for (i, step) in todo.enumerate() {
        deformation.stop().check().map_err(|mut error| {
            error.message += match i + n_kept {
                0 => "; no step was finished",
                _ => "; finished steps are kept, and --resume continues from there",
            };
            error
        })?;
        let interval = base_points.enter(step)?;
        if known != base_points.base_files {
            known.clone_from(&base_points.base_files);
            chosen(base_points)?;
        }
        if i == 0 {
            progress.start("steps", Some((steps.len() - n_kept) as u64));
        }
        let _held = deformation.stop().hold();
        let clock = Clock::start();
        let left = Left {
            path: &path(names, step.index),
            commit: names.commit,
            run,
        };
        slab.leave_step(&interval, step, rounding(plan)?, &mut points, &left)?;
        *seconds += clock.seconds();
        progress.advance(1);
    }
    progress.finish();
    Ok(())
}

fn path(names: &Names, step: usize) -> PathBuf {
    names.path(&StoredStep::file_name(step))
}

/// How many steps of an earlier run are kept; the others are removed.
fn kept(names: &Names, own: &Range<usize>, run: [u8; 32], request: &Request) -> Result<usize> {
    let there = files(names, |name| name.ends_with(".slab"));
    if !there.is_empty() && !request.force && !request.resume {
        return Err(Error::input(format!(
            "holds {} of this slab; --resume continues its run, --force replaces it",
            counted(there.len(), "step")
        ))
        .file(&names.folder));
    }
    let mut n_kept = 0;
    for path in there {
        let found = match request.force {
            true => None,
            false => StoredStep::open(&path).ok(),
        };
        if let Some(mut found) = found {
            if found.run() != run {
                return Err(Error::input(
                    "this step is of another mesh, schedule, option or version of azimesh; --force replaces those of this slab",
                )
                .file(&path));
            }
            let is_ours = found.nodes() == *own
                && path.ends_with(StoredStep::file_name(found.step()))
                && found.check().is_ok();
            if is_ours {
                n_kept += 1;
                continue;
            }
        }
        fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
    }
    Ok(n_kept)
}

/// Refuses slabs whose records say that they are of another run than this one.
pub(super) fn check_alike(joined: &Joined, own: &RunRecord) -> Result<()> {
    for (slab, folder) in SlabOf::all(joined.n()).zip(joined.folders()) {
        // Without a record their steps tell.
        let of_slab = record::read(&folder.join("run.json")).ok().flatten();
        if let Some(difference) = of_slab.and_then(|of_slab| difference(own, &of_slab)) {
            return Err(Error::input(format!(
                "slab {slab} does not go with the inputs of the first slab as they are now: {}; `azimesh deform --slab {slab} \
                 --force`, with those inputs, writes it anew",
                difference.since()
            ))
            .file(&folder));
        }
    }
    Ok(())
}

/// Holds the folders of all slabs, so that none is written while they are joined.
pub(super) fn hold_all(joined: &Joined, names: &Names) -> Result<Vec<Lock>> {
    let hold = |folder| {
        let mut names = names.clone();
        names.folder = folder;
        Lock::take(&names)
    };
    joined.folders().map(hold).collect()
}

/// Base points that a slab has chosen, or taken from another.
pub(super) struct LeftBase {
    /// What was noted of each selection.
    selections: Vec<SelectionRecord>,
    /// Their files by name.
    files: BTreeMap<String, Vec<u8>>,
}

impl LeftBase {
    /// Those of the slab of a run that has most of them, of the `own` one where others have no more; none where no slab has any.
    pub fn find((own, n): (Option<usize>, usize), run: [u8; 32], sequence: &Path) -> Option<Self> {
        let of_slab = |slab: SlabOf| {
            let folder = slab.folder(sequence);
            let record = record::read(&folder.join("run.json")).ok()??;
            let read = |(name, hash): (&String, &String)| {
                let bytes = read_file(&folder.join(name)).ok()?;
                (blake3::hash(&bytes).to_string() == *hash).then_some((name.clone(), bytes))
            };
            let files: BTreeMap<_, _> = record.base_files.iter().filter_map(read).collect();
            let selections = record.selections.clone();
            (identity(&record, n) == run && !files.is_empty()).then_some(Self { selections, files })
        };
        let mut slabs: Vec<SlabOf> = SlabOf::all(n).collect();
        // Of several with as many files the last counts.
        slabs.sort_by_key(|slab| Some(slab.number) == own);
        let all = slabs.into_iter().filter_map(of_slab);
        all.max_by_key(|of| of.files.len())
    }

    /// What files of these names hold, and what was noted of the selection for the steps from `first_step` on.
    pub fn of(
        &self,
        names: &[String; 2],
        first_step: usize,
    ) -> Option<([Vec<u8>; 2], SelectionRecord)> {
        let content = |name| self.files.get(name).cloned();
        let mut selections = self.selections.iter();
        let selection = selections.find(|selection| selection.first_step == first_step)?;
        let contents = [content(&names[0])?, content(&names[1])?];
        Some((contents, selection.clone()))
    }
}

/// The slabs of a sequence that is to be joined.
pub struct LeftSlabs {
    /// How many there are.
    pub n: usize,
    /// What the first of them was asked for.
    pub record: RunRecord,
    /// Conditions of all of them that fail the run.
    pub fail_on: Vec<String>,
}

/// The slabs in the folder of a sequence; none where there are none.
///
/// # Errors
/// Where there are several numbers of them, or the first has no record.
pub fn slabs_in(folder: &Path) -> Result<Option<LeftSlabs>> {
    let n = match SlabOf::numbers_in(folder)[..] {
        [] => return Ok(None),
        [n] => n,
        [first, second, ..] => {
            return Err(Error::input(format!(
                "holds slabs_{first} and slabs_{second}: remove the folders of slabs that are not to be joined"
            ))
            .file(folder));
        }
    };
    let first = SlabOf { number: 0, n };
    let path = first.folder(folder).join("run.json");
    let lost = || {
        Error::input(format!(
            "there is no whole record of slab {first}; `azimesh deform --slab {first} --resume`, with the mesh and the schedule \
             of the others, writes it"
        ))
        .file(&path)
    };
    let record = record::read(&path)?.ok_or_else(lost)?;
    let mut fail_on = record.fail_on.clone();
    for other in SlabOf::all(n) {
        let other = record::read(&other.folder(folder).join("run.json"))?;
        for criterion in other.into_iter().flat_map(|other| other.fail_on) {
            if !fail_on.contains(&criterion) {
                fail_on.push(criterion);
            }
        }
    }
    Ok(Some(LeftSlabs { n, record, fail_on }))
}
