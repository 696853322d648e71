//! One step: its arrays and its row of steps.csv.

use super::base_points::BasePointStore;
use super::record::Clock;
use crate::deform::{Deformation, Evaluated, Plan, Repair, Rounding};
use crate::error::Result;
use crate::formats::DISPLACEMENT;
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{Apart, DataArray, Mesh, MeshView, PointsApart, Values};
use crate::motion::{QualityOutput, Step};
use crate::parallel;
use crate::quality::{Assessment, Extreme};
use crate::record::Row;
use crate::sparse;

/// The array of velocities.
const VELOCITY: &str = "Velocity";

/// A step that is computed and waits to be written.
#[derive(Default)]
pub(super) struct Computed {
    pub found: Evaluated,
    pub seconds: f64,
}

/// Positions and quality of one step; coordinates as they will be written. Most may stay `apart`, with the ranks that move them.
pub(super) fn compute(
    base_points: &mut BasePointStore<'_>,
    step: &Step,
    apart: bool,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = base_points.enter(step)?;
    let deformation = base_points.deformation;
    if deformation.plan().schedule.output.quality != QualityOutput::None {
        // Made once, in no step's time.
        deformation.measures();
    }
    let clock = Clock::start();
    let rounding = rounding(deformation.plan())?;
    Ok(Computed {
        found: deformation.evaluate(&interval, step, rounding, apart, points)?,
        seconds: clock.seconds(),
    })
}

/// Positions of a step that was computed before, most of which may stay `apart`, and its velocities: what its mesh consists of.
pub(super) fn recompute(
    base_points: &mut BasePointStore<'_>,
    step: &Step,
    apart: bool,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = base_points.enter(step)?;
    let deformation = base_points.deformation;
    let rounding = rounding(deformation.plan())?;
    Ok(Computed {
        found: deformation.place(&interval, step, rounding, apart, points)?,
        seconds: 0.0,
    })
}

/// What makes coordinates what they will be in the files.
pub(super) fn rounding(plan: &Plan) -> Result<Rounding> {
    Ok(match plan.schedule.output.rounds()? {
        false => Rounding::None,
        true => Rounding::Single,
    })
}

/// The arrays of a step that the schedule asks for.
#[derive(Default)]
pub(super) struct StepArrays {
    at_points: Vec<DataArray>,
    at_cells: Vec<DataArray>,
    /// Whether displacements and velocities stay where the positions are.
    is_apart: bool,
    /// Whether an array of the mesh that is called like the displacement is none of this run.
    hides_other: bool,
}

impl StepArrays {
    /// Of a step with its nodes at `points`; takes the velocities that were found.
    pub fn of(deformation: &Deformation, points: &[Vector], found: &mut Evaluated) -> Self {
        let plan = deformation.plan();
        let vectors = |name: &str, values: Vec<Vector>| {
            DataArray::tuples(name, 3, Values::F64(values.into_flattened()))
        };
        let velocities = found.velocities.take();
        let velocities = velocities.map(|values| vectors(VELOCITY, values));
        let displacement = match found.is_apart {
            false => displacement(plan, points, plan.points()),
            true => plan.schedule.output.displacement.then(|| {
                let nowhere = sparse::zeros(3 * points.len(), 0.0);
                DataArray::tuples(DISPLACEMENT, 3, Values::F64(nowhere))
            }),
        };
        Self {
            at_points: velocities.into_iter().chain(displacement).collect(),
            at_cells: match plan.schedule.output.quality {
                QualityOutput::Cells => deformation.measures().arrays(plan, points),
                QualityOutput::Summary | QualityOutput::None => Vec::new(),
            },
            is_apart: found.is_apart,
            hides_other: false,
        }
    }

    /// The displacement alone, from other positions than those of the mesh that was read.
    pub fn of_displacement(plan: &Plan, points: &[Vector], from: &[Vector]) -> Self {
        Self {
            at_points: displacement(plan, points, from).into_iter().collect(),
            hides_other: true,
            ..Self::default()
        }
    }

    /// The mesh of the step, of which most positions may be `apart`.
    pub fn view<'a>(
        &'a self,
        mesh: &'a Mesh,
        points: &'a [Vector],
        apart: Option<&'a dyn Apart>,
    ) -> MeshView<'a> {
        let made = |name| {
            let is_made = self.at_points.iter().any(|array| array.name == name);
            (self.is_apart && is_made).then_some(name)
        };
        let apart = apart.map(|by| PointsApart {
            by,
            displacement: made(DISPLACEMENT),
            velocity: made(VELOCITY),
        });
        let mut view = mesh.view().with_points(points).with_points_apart(apart);
        if self.hides_other {
            view.point_arrays.retain(|array| array.name != DISPLACEMENT);
        }
        let view = self.at_points.iter().fold(view, MeshView::with_point_array);
        self.at_cells.iter().fold(view, MeshView::with_cell_array)
    }
}

/// The displacement, where the schedule asks for it.
fn displacement(plan: &Plan, points: &[Vector], from: &[Vector]) -> Option<DataArray> {
    plan.schedule.output.displacement.then(|| {
        let values = parallel::collect(points.len(), |i| sub(points[i], from[i]));
        DataArray::tuples(DISPLACEMENT, 3, Values::F64(values.into_flattened()))
    })
}

/// The row of a step but for what writing it tells.
pub(super) fn row(step: &Step, computed: &Evaluated) -> Row {
    let value = |extreme: Option<Extreme>| extreme.map(|found| found.value);
    let mut row = Row {
        step: step.index,
        azimuth_deg: step.azimuth_deg(),
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
    if let Some(Assessment { cells, faces }) = &computed.quality {
        row.inverted = Some(cells.inverted);
        row.inverted_reference = Some(cells.inverted_reference);
        row.unproven = Some(cells.unproven);
        row.repaired = Some(computed.repair.as_ref().map_or(0, Repair::n_untangled));
        row.min_volume = value(cells.min_volume);
        row.min_scaled_jacobian = value(cells.min_scaled_jacobian);
        row.mean_scaled_jacobian = cells.mean_scaled_jacobian;
        row.p01_scaled_jacobian = cells.p01_scaled_jacobian;
        row.max_edge_ratio = value(cells.max_edge_ratio);
        row.max_skew = value(cells.max_skew);
        row.max_non_orthogonality = value(faces.max_non_orthogonality);
        row.min_size_skew = value(cells.size_skew.min);
        row.mean_size_skew = cells.size_skew.mean;
        row.mean_non_orthogonality = faces.mean_non_orthogonality;
        row.max_face_skewness = value(faces.max_face_skewness);
        row.min_volume_ratio = value(faces.min_volume_ratio);
        row.min_face_weight = value(faces.min_face_weight);
    }
    row
}
