//! One step: its node positions, its quality, its arrays and its row of steps.csv.

use super::output::{COLUMNS, number};
use super::plan::Plan;
use super::record::Clock;
use super::stretches::Stretches;
use crate::error::Result;
use crate::formats;
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{DataArray, Mesh, Values};
use crate::motion::{QualityOutput, Step};
use crate::quality::{self, Reference, Summary};
use rayon::prelude::*;

/// A step that is computed and waits to be written.
pub(super) struct Computed {
    pub summary: Option<Summary>,
    pub first_cell_ratio: Option<f64>,
    pub selection_error: f64,
    pub surface_error: (f64, f64),
    pub largest_displacement: f64,
    pub velocities: Option<Vec<Vector>>,
    pub n_base: usize,
    pub seconds: f64,
}

/// Positions and quality of one step; coordinates as they will be written.
pub(super) fn compute(
    stretches: &mut Stretches<'_>,
    reference: Option<&Reference>,
    mesh: &Mesh,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let deformer = stretches.enter(step)?;
    let clock = Clock::start();
    let plan = deformer.plan;
    let selection_error = deformer.points_at(step, points)?;
    if rounds(plan)? {
        points
            .par_iter_mut()
            .for_each(|x| *x = x.map(|x| f64::from(x as f32)));
    }
    Ok(Computed {
        summary: reference.map(|reference| quality::assess(mesh, points, reference)),
        first_cell_ratio: plan.first_cells.smallest_ratio(points, &plan.reference),
        selection_error,
        surface_error: deformer.surface_error(step, points),
        largest_displacement: plan.largest_displacement(step.index),
        velocities: deformer.velocities_at(step, points),
        n_base: deformer.n_base,
        seconds: clock.seconds(),
    })
}

/// Whether coordinates are written in 32 bits.
pub(super) fn rounds(plan: &Plan) -> Result<bool> {
    let output = &plan.schedule.output;
    Ok(formats::by_name(&output.format)?.rounds(output.precision))
}

/// Adds the arrays of a step that the schedule asks for, in place of the last step's.
pub(super) fn add_arrays(
    plan: &Plan,
    mesh: &mut Mesh,
    computed: &mut Computed,
    reference: Option<&Reference>,
) {
    if let Some(velocities) = computed.velocities.take() {
        let values = Values::F64(velocities.into_flattened());
        let array = DataArray::tuples("Velocity", 3, values);
        replace(&mut mesh.point_arrays, array);
    }
    if plan.schedule.output.displacement {
        let moved = mesh.points.par_iter().zip(&plan.reference);
        let moved: Vec<Vector> = moved.map(|(x, reference)| sub(*x, *reference)).collect();
        let values = Values::F64(moved.into_flattened());
        let array = DataArray::tuples("Displacement", 3, values);
        replace(&mut mesh.point_arrays, array);
    }
    if let (QualityOutput::Cells, Some(reference)) = (plan.schedule.output.quality, reference) {
        for array in quality::per_cell(mesh, &mesh.points, reference).into_arrays() {
            replace(&mut mesh.cell_arrays, array);
        }
    }
}

fn replace(arrays: &mut Vec<DataArray>, array: DataArray) {
    match arrays.iter_mut().find(|old| old.name == array.name) {
        Some(old) => *old = array,
        None => arrays.push(array),
    }
}

/// The row of a step but for what writing it tells.
pub(super) fn row(step: &Step, computed: &Computed) -> Vec<String> {
    let mut row = vec![String::new(); COLUMNS.len()];
    set(&mut row, "step", step.index.to_string());
    set(&mut row, "azimuth_deg", step.azimuth_deg.to_string());
    set(
        &mut row,
        "time_s",
        step.time_s.map_or(String::new(), |t| t.to_string()),
    );
    set(&mut row, "base_points", computed.n_base.to_string());
    set(
        &mut row,
        "max_displacement",
        number(computed.largest_displacement),
    );
    set(
        &mut row,
        "selection_error",
        number(computed.selection_error),
    );
    set(
        &mut row,
        "max_surface_error",
        number(computed.surface_error.0),
    );
    set(
        &mut row,
        "rms_surface_error",
        number(computed.surface_error.1),
    );
    if let Some(ratio) = computed.first_cell_ratio {
        set(&mut row, "min_first_cell_ratio", number(ratio));
    }
    for (column, value) in computed.summary.iter().flat_map(Summary::columns) {
        if let Some(value) = value {
            set(&mut row, column, number(value));
        }
    }
    row
}

pub(super) fn set(row: &mut [String], column: &str, value: String) {
    let at = COLUMNS.iter().position(|name| *name == column);
    row[at.expect("the columns of a summary are columns of steps.csv")] = value;
}
