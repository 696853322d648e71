//! One step: its arrays and its row of steps.csv.

use super::intervals::Intervals;
use super::record::Clock;
use crate::deform::{Deformation, Evaluated, Plan};
use crate::error::Result;
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{DataArray, Mesh, MeshView, Values};
use crate::motion::{QualityOutput, Step};
use crate::quality::Assessment;
use crate::record::{COLUMNS, Row, number};
use rayon::prelude::*;

/// A step that is computed and waits to be written.
#[derive(Default)]
pub(super) struct Computed {
    pub found: Evaluated,
    pub seconds: f64,
}

/// Positions and quality of one step; coordinates as they will be written.
pub(super) fn compute(
    intervals: &mut Intervals<'_>,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = intervals.enter(step)?;
    let clock = Clock::start();
    let deformation = intervals.deformation;
    let round = rounding(deformation.plan())?;
    Ok(Computed {
        found: deformation.evaluate(&interval, step, round, points)?,
        seconds: clock.seconds(),
    })
}

/// Positions of a step that was computed before, and its velocities: what its mesh consists of.
pub(super) fn compute_again(
    intervals: &mut Intervals<'_>,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = intervals.enter(step)?;
    interval.points_at(step, points)?;
    rounding(intervals.deformation.plan())?(points);
    Ok(Computed {
        found: Evaluated {
            velocities: interval.velocities_at(step, points),
            ..Evaluated::default()
        },
        seconds: 0.0,
    })
}

/// What makes coordinates what they will be in the files.
fn rounding(plan: &Plan) -> Result<&'static dyn Fn(&mut [Vector])> {
    Ok(match plan.schedule.output.rounds()? {
        false => &|_| (),
        true => &|points| {
            let points = points.par_iter_mut();
            points.for_each(|x| *x = x.map(|x| f64::from(x as f32)));
        },
    })
}

/// The arrays of a step that the schedule asks for.
#[derive(Default)]
pub(super) struct StepArrays {
    at_points: Vec<DataArray>,
    at_cells: Vec<DataArray>,
}

impl StepArrays {
    /// Of a step with its nodes at `points`; takes the velocities that were found.
    pub fn of(deformation: &Deformation, points: &[Vector], found: &mut Evaluated) -> Self {
        let plan = deformation.plan();
        let vectors = |name: &str, values: Vec<Vector>| {
            DataArray::tuples(name, 3, Values::F64(values.into_flattened()))
        };
        let velocities = found.velocities.take();
        let displacement = plan.schedule.output.displacement.then(|| {
            let moved = points.par_iter().zip(&plan.mesh.points);
            moved.map(|(x, before)| sub(*x, *before)).collect()
        });
        let velocities = velocities.map(|values| vectors("Velocity", values));
        let displacement = displacement.map(|values| vectors("Displacement", values));
        Self {
            at_points: velocities.into_iter().chain(displacement).collect(),
            at_cells: match plan.schedule.output.quality {
                QualityOutput::Cells => deformation.measures().arrays(plan, points),
                QualityOutput::Summary | QualityOutput::None => Vec::new(),
            },
        }
    }

    /// The mesh of the step.
    pub fn view<'a>(&'a self, mesh: &'a Mesh, points: &'a [Vector]) -> MeshView<'a> {
        let view = mesh.view().with_points(points);
        let view = self.at_points.iter().fold(view, MeshView::with_point_array);
        self.at_cells.iter().fold(view, MeshView::with_cell_array)
    }
}

/// The row of a step but for what writing it tells.
pub(super) fn row(step: &Step, computed: &Evaluated) -> Row {
    let time = step.time_s.map_or(String::new(), |t| t.to_string());
    let mut row = Row::new();
    row.set("step", step.index.to_string());
    row.set("azimuth_deg", step.azimuth_deg.to_string());
    row.set("time_s", time);
    row.set("base_points", computed.n_base.to_string());
    let lengths = [
        ("max_displacement", computed.largest_displacement),
        ("selection_error", computed.selection_error),
        ("max_surface_error", computed.surface_error.0),
        ("rms_surface_error", computed.surface_error.1),
    ];
    for (column, length) in lengths {
        row.set(column, number(length));
    }
    if let Some(ratio) = computed.first_cell_ratio {
        row.set("min_first_cell_ratio", number(ratio));
    }
    if let Some(change) = computed.normal_change {
        row.set("max_normal_change_deg", number(change));
    }
    let measured = computed.quality.iter().flat_map(Assessment::columns);
    for (column, value) in measured.filter(|(column, _)| COLUMNS.contains(column)) {
        if let Some(value) = value {
            row.set(column, number(value));
        }
    }
    row
}
