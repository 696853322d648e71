//! Refusals before any file is written, and notes on data that the format cannot hold.

use super::disk::Demand;
use crate::record::Criterion;
use azimesh_core::error::{Error, ErrorKind, Result};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::{Note, note, parallel};
use azimesh_deform::Plan;
use azimesh_deform::motion::{QualityOutput, SelectionMethod};
use azimesh_io::formats::{
    self, Compression, Encoding, Format, OutputSet, Precision, WriteOptions,
};
use azimesh_io::mesh::MeshView;
use azimesh_quality::{Assessment, CURVED_COLUMNS};
use std::path::Path;

/// Allowed change of a first-cell height when coordinates are rounded to 32 bits.
const F32_CHANGE: f64 = 0.01;
/// Largest number of base points whose dense matrix fits a workstation: 12.8 GB.
const MOST_DENSE: usize = 40_000;

/// Makes all checks that can refuse a run before it starts. Returns notes on data that the format cannot hold, and the
/// bytes of one mesh in it, neither compressed nor as text.
pub(crate) fn before_work(
    plan: &Plan,
    mesh: &MeshView<'_>,
    format: &Format,
    fail_on: &[Criterion],
) -> Result<(Vec<Note>, u64)> {
    check_precision(plan)?;
    check_columns(plan, mesh, fail_on)?;
    check_dense(plan)?;
    format_holds(plan, mesh, format)
}

/// Returns the bytes of the meshes of a sequence before compression.
///
/// # Errors
/// If the format cannot hold the mesh.
pub fn estimate_bytes(plan: &Plan, mesh: &MeshView<'_>) -> Result<u64> {
    let format = formats::by_name(plan.schedule.output.format())?;
    let (_, mesh_bytes) = format_holds(plan, mesh, format)?;
    let n_steps = plan.motion.steps.len();
    Ok(Demand::of(plan, mesh, format, (n_steps, 0), mesh_bytes).bytes())
}

/// Refuses a dense matrix that is too large for a workstation.
fn check_dense(plan: &Plan) -> Result<()> {
    let n = plan.surface.nodes.len();
    if plan.schedule.selection.method != SelectionMethod::All || n <= MOST_DENSE {
        return Ok(());
    }
    Err(Error::input(format!(
        "method = \"all\" with {n} surface nodes needs a dense matrix of {:.0} GB; it is for at most \
         {MOST_DENSE} nodes, method = \"sequence\" is for any number",
        (n * n * 8) as f64 / 1e9
    ))
    .file(&plan.schedule.path))
}

/// Refuses conditions on columns of steps.csv that have no value in this run.
fn check_columns(plan: &Plan, mesh: &MeshView<'_>, fail_on: &[Criterion]) -> Result<()> {
    let quality = Assessment::default().columns();
    let is_quality =
        |name: &str| name == "repaired" || quality.iter().any(|(column, _)| *column == name);
    let is_curved = mesh.volume_runs().any(|run| run.kind.is_curved());
    let skipped = plan.schedule.output.quality == QualityOutput::None;
    for criterion in fail_on {
        criterion.check_column()?;
        let reason = match criterion.column() {
            "time_s" if plan.motion.steps[0].time_s().is_none() => {
                "the schedule has neither [time] nor rotor.rpm"
            }
            "azimuth_deg" if plan.motion.steps[0].azimuth_deg().is_none() => {
                "the schedule has times alone, without frequency or azimuth_table"
            }
            "min_first_cell_ratio" if plan.smallest_first_cell.is_none() => {
                "no moving wall has first cells of known height"
            }
            column if CURVED_COLUMNS.contains(&column) && !is_curved => {
                "the mesh has no curved cells"
            }
            column if skipped && (column == "max_normal_change_deg" || is_quality(column)) => {
                "output.quality = \"none\" evaluates no cell"
            }
            _ => continue,
        };
        return Err(Error::input(format!(
            "\"{criterion}\": the column {} has no values in this run, since {reason}",
            criterion.column()
        )));
    }
    Ok(())
}

/// Refuses a format before the run by writing the mesh to a null sink; returns the data that it cannot hold, and the number of
/// bytes. Nodes are moved slightly, so that coordinates as text are as long as at a step even if the mesh has few digits.
fn format_holds(plan: &Plan, mesh: &MeshView<'_>, format: &Format) -> Result<(Vec<Note>, u64)> {
    if format.is_surface {
        let message = format!(
            "output.format = \"{0}\": {0} holds surfaces, and a run writes whole meshes; `azimesh convert DIR -o OUT --format {0}` \
             writes the surface of each step",
            format.name
        );
        return Err(Error::input(message).file(&plan.schedule.path));
    }
    let options = WriteOptions {
        encoding: Encoding::Raw,
        compression: Compression::None,
        ..plan.schedule.output.write_options()
    };
    let mut mesh = mesh.clone();
    // Ranks write equally many bytes for any positions.
    let points = (mesh.by_ranks.is_none()).then(|| moved_a_little(mesh.points));
    if let Some(points) = &points {
        mesh = mesh.with_points(points);
    }
    let mut out = OutputSet::nowhere(Path::new("mesh"));
    let dropped = format.write(&mesh, &mut out, &options);
    let dropped = dropped.map_err(|error| match error.kind {
        ErrorKind::Input => Error::input(format!(
            "output.format = \"{}\" cannot hold this mesh: {}",
            format.name, error.message
        ))
        .file(&plan.schedule.path),
        _ => error,
    })?;
    let mut dropped: Vec<Note> = dropped.into_iter().collect();
    dropped.extend(dropped_arrays(plan, format));
    // Returns storage options that the format does not have.
    let without_effect = plan.schedule.output.write_options().without_effect(format);
    let format = format.name;
    let note = |key| {
        note!(
            "no_effect",
            "output.{key} has no effect on files of format = \"{format}\""
        )
    };
    dropped.extend(without_effect.into_iter().map(note));
    Ok((dropped, out.finish().n_bytes))
}

/// Moves nodes slightly; they stay in their plane if they have one.
fn moved_a_little(points: &[Vector]) -> Vec<Vector> {
    const FACTOR: f64 = 1.0 + 1e-7 / 3.0;
    let bounds = Bounds::around(points);
    let shift = bounds.diagonal() * 1e-3 / 3.0;
    let is_plane = bounds.low[2] == bounds.high[2];
    let moved = |x: &Vector| {
        let moved = x.map(|x| (x + shift) * FACTOR);
        if is_plane {
            [moved[0], moved[1], x[2]]
        } else {
            moved
        }
    };
    parallel::collect(points.len(), |i| moved(&points[i]))
}

/// Returns a note if the schedule asks for arrays that the format does not hold.
fn dropped_arrays(plan: &Plan, format: &Format) -> Option<Note> {
    let output = &plan.schedule.output;
    let holds_arrays = format.holds.arrays;
    let dropped = [
        (
            "displacement",
            output.displacement && !format.holds.displacement,
        ),
        ("velocity", output.velocity && !holds_arrays),
        (
            "cell quality",
            output.quality == QualityOutput::Cells && !holds_arrays,
        ),
    ];
    let arrays = dropped.into_iter().filter(|(_, is_dropped)| *is_dropped);
    let arrays: Vec<&str> = arrays.map(|(name, _)| name).collect();
    let left_out = match &arrays[..] {
        [] => return None,
        [one] => format!("{one} is"),
        [first @ .., last] => format!("{} and {last} are", first.join(", ")),
    };
    Some(note!(
        "no_arrays",
        "output.format = \"{}\" holds no arrays: {left_out} left out",
        format.name
    ))
}

fn check_precision(plan: &Plan) -> Result<()> {
    let output = &plan.schedule.output;
    if !output.rounds()? {
        return Ok(());
    }
    let change = plan.first_cell_change_in_f32;
    if change <= F32_CHANGE {
        return Ok(());
    }
    // UGRID has other formats for 64 bits.
    let (key, remedy) = if formats::by_name(output.format())?.rounds(Precision::F64) {
        (
            format!("output.format = \"{}\", of 32 bits,", output.format()),
            "a format of 64 bits, such as \"ugrid-b8\"",
        )
    } else {
        ("output.precision = \"f32\"".to_owned(), "\"f64\"")
    };
    Err(Error::input(format!(
        "{key} would change the height of a first cell by {:.1}%; use {remedy}",
        100.0 * change
    ))
    .file(&plan.schedule.path))
}
