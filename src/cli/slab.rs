//! Work on slabs of a mesh: `azimesh deform --slab I/N`, and `azimesh finish` of what that leaves.

use super::deform::{fit_into_memory, report};
use super::outline::why_not_run;
use super::{Context, Outcome};
use crate::deform::{Deformation, Outlined, Sharing, SlabOf, run_needs_whole};
use crate::error::{Error, Result, counted};
use crate::formats::{self, ReadOptions};
use crate::motion::Schedule;
use crate::progress::Stop;
use crate::run::{FinishedSlab, LeftSlabs, Request, run, run_slab};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Writes the steps of one slab.
pub(super) fn write_slab(
    slab: SlabOf,
    schedule: Schedule,
    mut request: Request,
    with_files: bool,
    stop: &Arc<Stop>,
    context: &Context,
) -> Result<Outcome> {
    if context.team.n() > 1 {
        return Err(Error::input(
            "--slab is the work of one process; without it ranks of MPI share the mesh",
        ));
    }
    let work = |mesh: &mut Outlined| mesh.one(slab);
    let deformation = deformation(&mut request, schedule, (with_files, context), work, stop)?;
    for choice in &deformation.plan().choices {
        context.note(&choice.to_string());
    }
    let finished = run_slab(&deformation, &request)?;
    tell(&request.folder, &finished, context)?;
    context.tell_of_files();
    Ok(Outcome::Fine)
}

/// Joins the slabs of the sequence in a folder: a run that reads where they have moved the nodes.
pub(super) fn join(
    folder: &Path,
    left: LeftSlabs,
    force: bool,
    context: &Context,
) -> Result<Outcome> {
    let stop = Arc::new(Stop::default());
    #[cfg(unix)]
    super::signals::listen(&stop)?;
    let LeftSlabs { n, record, fail_on } = left;
    let input = |what: &str| {
        let found = record.inputs.iter().find(|input| input.what == what);
        found.map(|input| PathBuf::from(&input.file))
    };
    let named = |what| {
        input(what).ok_or_else(|| {
            Error::input(format!("the record of its first slab names no {what}")).file(folder)
        })
    };
    let (mesh, path) = (named("mesh")?, named("schedule")?);
    let mut schedule = Schedule::read(&path).map_err(|error| from_there(error, folder))?;
    if let Some(format) = &record.options.format {
        schedule.output.format.clone_from(format);
        schedule.output.format_given = true;
    }
    let criteria = fail_on.iter().map(|criterion| criterion.parse());
    let criteria = criteria.collect::<Result<Vec<_>>>();
    let mut request = Request {
        mesh,
        folder: folder.to_path_buf(),
        base: input("base"),
        tag_array: record.options.tag_array.clone(),
        force,
        resume: !force,
        fail_on: criteria.map_err(|error| error.file(folder))?,
        ..Request::default()
    };
    let with_files = context.keep_in_files(folder);
    let work = |mesh: &mut Outlined| mesh.joined(folder, n);
    let deformation = deformation(&mut request, schedule, (with_files, context), work, &stop);
    let deformation = deformation.map_err(|error| from_there(error, folder))?;
    for choice in &deformation.plan().choices {
        context.note(&choice.to_string());
    }
    let joined = deformation.plan().joined();
    if let Some(kinds) =
        joined.and_then(|slabs| slabs.kinds_of_processors(deformation.steps().len()))
    {
        context.warn(&format!(
            "slabs were moved on processors of several kinds ({kinds}), which round sums in different ways: the last digits of \
             results are not those of one run"
        ));
    }
    let finished = run(&deformation, &request)?;
    if let Some(reason) = deformation.why_whole() {
        context.detail(&format!("the whole mesh was read as well: {reason}"));
    }
    context.tell_of_files();
    report(folder, finished, context)
}

/// An input that is not found may be another one from here.
fn from_there(mut error: Error, folder: &Path) -> Error {
    if error
        .path
        .as_ref()
        .is_some_and(|path| path.is_relative() && !path.exists())
    {
        error.message += &format!(
            "; `azimesh finish` of the slabs in {} has to run in the folder in which they were written",
            folder.display()
        );
    }
    error
}

/// A deformation of a mesh of which this process has the outline, or the whole where that is not enough.
fn deformation(
    request: &mut Request,
    schedule: Schedule,
    (with_files, context): (bool, &Context),
    work: impl FnOnce(&mut Outlined) -> Sharing,
    stop: &Arc<Stop>,
) -> Result<Deformation> {
    let path = &*request.mesh.clone();
    if path.as_os_str() == "-" {
        return Err(Error::input(
            "slabs have to be sure that all have the same mesh; write it to a file first",
        )
        .file(path));
    }
    let enough = match why_not_run(&schedule).or_else(|| run_needs_whole(&schedule)) {
        None => Ok(Some(formats::by_name(&schedule.output.format)?)),
        Some(reason) => Err(reason.to_owned()),
    };
    let options = ReadOptions {
        tag_array: request.tag_array.clone(),
        step: None,
    };
    let (mut found, why_whole) = context.outline_or_whole(path, None, &options, enough)?;
    if let Some(reason) = &why_whole {
        context.note(&format!(
            "{}: read whole, and takes the memory of that: {reason}",
            path.display()
        ));
    }
    let sharing = work(&mut found);
    let mesh = context.with_notes(found.loaded, path);
    let deformation = Deformation::builder(mesh, schedule)
        .progress(context.progress().into())
        .stop(Arc::clone(stop))
        .sharing(sharing)
        .plan()
        .map_err(|error| error.file(path))?;
    if let (Some(limit), Some(_)) = (context.common.max_memory, why_whole) {
        let plan = deformation.plan();
        request.bytes_in_files = fit_into_memory(plan, limit, with_files, request, context)?;
    }
    Ok(deformation)
}

fn tell(folder: &Path, finished: &FinishedSlab, context: &Context) -> Result<()> {
    let FinishedSlab {
        slab,
        n_nodes,
        n_steps,
        n_kept,
        timings: t,
    } = finished;
    if context.common.json {
        return context.print_json(json!({
            "folder": folder.display().to_string(),
            "slab": slab.number + 1,
            "slabs": slab.n,
            "nodes": n_nodes,
            "steps_written": n_steps,
            "steps_kept": n_kept,
            "seconds": t,
        }));
    }
    context.print_result(&format!(
        "{}: slab {slab}, {} of {}{}\n{:.2} s: selection {:.2}, modes {:.2}, steps {:.2}\n",
        folder.display(),
        counted(*n_steps, "step"),
        counted(*n_nodes, "node"),
        match n_kept {
            0 => String::new(),
            n => format!(", {n} of them from before"),
        },
        t.total,
        t.selection,
        t.modes,
        t.steps,
    ))
}
