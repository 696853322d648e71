//! One step: its arrays and its row of steps.csv.

use super::base_points::BasePointStore;
use super::record::Clock;
use crate::record::Row;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::parallel;
use azimesh_core::sparse;
use azimesh_deform::motion::{QualityOutput, Step};
use azimesh_deform::{Deformation, Evaluated, Plan, Repair, Rounding};
use azimesh_io::formats::DISPLACEMENT;
use azimesh_io::mesh::{Apart, ByRanks, DataArray, Mesh, MeshView, Values};
use azimesh_quality::{Assessment, Extreme};

/// The array of velocities.
const VELOCITY: &str = "Velocity";

/// A step that is computed and waits to be written.
#[derive(Default)]
pub(super) struct Computed {
    pub found: Evaluated,
    pub seconds: f64,
}

/// Positions and quality of one step; coordinates as they will be written.
pub(super) fn compute(
    base_points: &mut BasePointStore<'_>,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = base_points.enter(step)?;
    let deformation = base_points.deformation;
    if deformation.plan().schedule.output.quality != QualityOutput::None {
        // Made once, in no step's time.
        deformation.prepare_measures();
    }
    let clock = Clock::start();
    let rounding = rounding(deformation.plan())?;
    Ok(Computed {
        found: deformation.evaluate(&interval, step, rounding, points)?,
        seconds: clock.seconds(),
    })
}

/// Positions of a step that was computed before, and its velocities: what its mesh consists of.
pub(super) fn recompute(
    base_points: &mut BasePointStore<'_>,
    step: &Step,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = base_points.enter(step)?;
    let deformation = base_points.deformation;
    let rounding = rounding(deformation.plan())?;
    Ok(Computed {
        found: deformation.place(&interval, step, rounding, points)?,
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

/// The mesh of a step as it is written.
pub(super) struct StepMesh<'a> {
    mesh: &'a Mesh,
    points: &'a [Vector],
    at_points: Vec<DataArray>,
    at_cells: Vec<DataArray>,
    /// Whether an array of the mesh that has the name of the displacement is not of this run.
    hides_other: bool,
    /// Whether all ranks write it together: then `points` and the arrays at nodes have the values of no node.
    is_together: bool,
}

impl<'a> StepMesh<'a> {
    /// Of a step with its nodes at `points`, without arrays.
    pub fn new(deformation: &'a Deformation, points: &'a [Vector]) -> Result<Self> {
        Ok(Self {
            mesh: deformation.mesh_to_write()?,
            points,
            at_points: Vec::new(),
            at_cells: Vec::new(),
            hides_other: false,
            is_together: deformation.is_written_together(),
        })
    }

    /// With the arrays that the schedule asks for; takes the velocities of all nodes, where they are here.
    pub fn with_arrays(
        mut self,
        deformation: &Deformation,
        velocities: &mut Vec<Vector>,
    ) -> Result<Self> {
        let plan = deformation.plan();
        let values = match self.is_together {
            true => sparse::zeros(3 * self.mesh.points.len(), 0.0),
            false => std::mem::take(velocities).into_flattened(),
        };
        if plan.velocity.is_some() && !values.is_empty() {
            let array = DataArray::tuples(VELOCITY, 3, Values::F64(values));
            self.at_points.push(array);
        }
        self.add_displacement(plan, &self.mesh.points);
        if plan.schedule.output.quality == QualityOutput::Cells {
            self.at_cells = deformation.cell_arrays(self.points)?;
        }
        Ok(self)
    }

    /// With the displacement alone, from other positions than those of the mesh that was read.
    pub fn with_displacement(mut self, plan: &Plan, from: Option<&[Vector]>) -> Self {
        self.add_displacement(plan, from.unwrap_or(&self.mesh.points));
        self.hides_other = true;
        self
    }

    fn add_displacement(&mut self, plan: &Plan, from: &[Vector]) {
        if plan.schedule.output.displacement {
            let values = match self.is_together {
                true => sparse::zeros(3 * self.mesh.points.len(), 0.0),
                false => {
                    let moved = |i: usize| sub(self.points[i], from[i]);
                    parallel::collect(self.points.len(), moved).into_flattened()
                }
            };
            let array = DataArray::tuples(DISPLACEMENT, 3, Values::F64(values));
            self.at_points.push(array);
        }
    }

    /// The mesh, of which `by` has the values of nodes and cells where all ranks write it together.
    pub fn view<'b>(&'b self, by: Option<&'b dyn Apart>) -> MeshView<'b> {
        let made = |name| {
            let is_made = self.at_points.iter().any(|array| array.name == name);
            is_made.then_some(name)
        };
        let by_ranks = by.map(|by| ByRanks {
            by,
            displacement: made(DISPLACEMENT),
            velocity: made(VELOCITY),
        });
        let view = self.mesh.view();
        let mut view = match by_ranks {
            Some(by_ranks) => view.by_ranks(by_ranks),
            None => view.with_points(self.points),
        };
        if self.hides_other {
            view.point_arrays.retain(|array| array.name != DISPLACEMENT);
        }
        let view = self.at_points.iter().fold(view, MeshView::with_point_array);
        self.at_cells.iter().fold(view, MeshView::with_cell_array)
    }
}

/// The row of a step but for what writing it tells.
pub(super) fn row(step: &Step, computed: &Evaluated) -> Row {
    let value = |extreme: Option<Extreme>| extreme.map(|found| found.value);
    let mut row = Row {
        step: step.index(),
        azimuth_deg: step.azimuth_deg(),
        time_s: step.time_s(),
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
