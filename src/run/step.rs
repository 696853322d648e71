//! One step: its node positions, its quality, its arrays and its row of steps.csv.

use super::intervals::Stretches;
use super::record::Clock;
use crate::deform::Plan;
use crate::deform::WallAngles;
use crate::deform::{Repair, repair as take_in_substeps, wants_repair};
use crate::error::Result;
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{DataArray, Mesh, Values};
use crate::motion::{QualityOutput, Step};
use crate::quality::{Extreme, Judge, Quality};
use crate::record::Row;
use rayon::prelude::*;

/// What the quality of every step is measured by.
pub(super) struct Measures {
    judge: Judge,
    walls: WallAngles,
}

impl Measures {
    /// For the reference mesh.
    pub fn new(mesh: &Mesh, plan: &Plan) -> Self {
        let judge = Judge::new(mesh);
        Self {
            walls: WallAngles::find(mesh, &judge.adjacency, &plan.moving_faces),
            judge,
        }
    }
}

/// A step that is computed and waits to be written.
#[derive(Default)]
pub(super) struct Computed {
    pub quality: Option<Quality>,
    pub normal_change: Option<f64>,
    pub first_cell_ratio: Option<f64>,
    pub selection_error: f64,
    pub surface_error: (f64, f64),
    pub largest_displacement: f64,
    pub velocities: Option<Vec<Vector>>,
    pub n_base: usize,
    pub repair: Option<Repair>,
    pub seconds: f64,
}

impl Computed {
    /// The first inverted cell, where there is one.
    pub fn first_inverted(&self) -> Option<usize> {
        let cells = self.quality.as_ref().map(|quality| &quality.cells);
        let summary = cells.filter(|summary| summary.inverted > 0);
        summary.map(|summary| summary.inverted_cells.first().copied().unwrap_or_default())
    }
}

/// Positions and quality of one step; coordinates as they will be written.
pub(super) fn compute(
    stretches: &mut Stretches<'_>,
    measures: Option<&Measures>,
    mesh: &Mesh,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let deformer = stretches.enter(step)?;
    let clock = Clock::start();
    let plan = deformer.plan;
    let mut selection_error = deformer.points_at(step, points)?;
    round(plan, points)?;
    let mut cells = measures.map(|by| by.judge.cells(mesh, points));
    let mut repair = None;
    if let (Some(by), Some(cells)) = (measures, &mut cells)
        && wants_repair(plan, cells)
    {
        let attempt = |n: usize, points: &mut [Vector]| {
            let error = deformer.points_through(step, n, points)?;
            round(plan, points)?;
            Ok((error, by.judge.cells(mesh, points)))
        };
        repair = Some(take_in_substeps(
            plan,
            points,
            cells,
            &mut selection_error,
            attempt,
        )?);
    }
    Ok(Computed {
        quality: measures
            .zip(cells)
            .map(|(by, cells)| by.judge.complete(cells, mesh, points, &plan.reference)),
        normal_change: measures
            .and_then(|by| by.walls.largest_change(mesh, points, &plan.reference)),
        repair,
        first_cell_ratio: plan.first_cells.smallest_ratio(points, &plan.reference),
        selection_error,
        surface_error: deformer.surface_error(step, points),
        largest_displacement: plan.largest_displacement(step.index),
        velocities: deformer.velocities_at(step, points),
        n_base: deformer.n_base,
        seconds: clock.seconds(),
    })
}

/// Positions of a step that was computed before, and its velocities: what its mesh consists of.
pub(super) fn compute_again(
    stretches: &mut Stretches<'_>,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let deformer = stretches.enter(step)?;
    deformer.points_at(step, points)?;
    round(deformer.plan, points)?;
    Ok(Computed {
        velocities: deformer.velocities_at(step, points),
        ..Computed::default()
    })
}

/// Coordinates as they will be written.
fn round(plan: &Plan, points: &mut [Vector]) -> Result<()> {
    if plan.schedule.output.rounds()? {
        points
            .par_iter_mut()
            .for_each(|x| *x = x.map(|x| f64::from(x as f32)));
    }
    Ok(())
}

/// Adds the arrays of a step that the schedule asks for, in place of the last step's.
pub(super) fn add_arrays(
    plan: &Plan,
    mesh: &mut Mesh,
    computed: &mut Computed,
    measures: Option<&Measures>,
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
    if let (QualityOutput::Cells, Some(by)) = (plan.schedule.output.quality, measures) {
        for array in by.judge.arrays(mesh, &mesh.points, &plan.reference) {
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
pub(super) fn row(step: &Step, computed: &Computed) -> Row {
    let value = |extreme: Option<Extreme>| extreme.map(|found| found.value);
    let mut row = Row {
        step: step.index,
        azimuth_deg: step.azimuth_deg,
        time_s: step.time_s,
        base_points: computed.n_base,
        max_displacement: computed.largest_displacement,
        selection_error: computed.selection_error,
        max_surface_error: computed.surface_error.0,
        rms_surface_error: computed.surface_error.1,
        min_first_cell_ratio: computed.first_cell_ratio,
        max_normal_change_deg: computed.normal_change,
        ..Row::default()
    };
    if let Some(Quality {
        cells,
        faces,
        size_skew,
    }) = &computed.quality
    {
        row.inverted = Some(cells.inverted);
        row.inverted_reference = Some(cells.inverted_reference);
        row.min_volume = value(cells.min_volume);
        row.min_scaled_jacobian = value(cells.min_scaled_jacobian);
        row.mean_scaled_jacobian = cells.mean_scaled_jacobian;
        row.p01_scaled_jacobian = cells.p01_scaled_jacobian;
        row.max_edge_ratio = value(cells.max_edge_ratio);
        row.max_skew = value(cells.max_skew);
        row.max_non_orthogonality = value(faces.max_non_orthogonality);
        row.min_size_skew = value(size_skew.min);
        row.mean_size_skew = size_skew.mean;
    }
    row
}
