//! One step: its arrays and its row of steps.csv.

use super::base_points::BasePointStore;
use crate::record::Row;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::{parallel, sparse};
use azimesh_deform::motion::{QualityOutput, Step};
use azimesh_deform::{Deformation, Evaluated, Repair, Rounding};
use azimesh_io::formats::{DISPLACEMENT, Format};
use azimesh_io::mesh::{Apart, ByRanks, DataArray, Mesh, MeshView, Values};
use azimesh_quality::{Assessment, Extreme};
use std::time::Instant;

/// The array of velocities.
const VELOCITY: &str = "Velocity";

/// A computed step that waits to be written.
#[derive(Default)]
pub(super) struct Computed {
    pub found: Evaluated,
    pub seconds: f64,
}

/// Computes the positions of a step, with coordinates rounded as in the file, and its velocities; if `is_evaluated`, also
/// its quality and errors.
pub(super) fn compute(
    base_points: &mut BasePointStore<'_>,
    step: &Step,
    is_evaluated: bool,
    points: &mut [Vector],
) -> Result<Computed> {
    let interval = base_points.enter(step)?;
    let deformation = base_points.deformation;
    let output = &deformation.plan().schedule.output;
    let rounding = if output.rounds()? {
        Rounding::Single
    } else {
        Rounding::None
    };
    if !is_evaluated {
        let found = deformation.place(&interval, step, rounding, points)?;
        return Ok(Computed {
            found,
            seconds: 0.0,
        });
    }
    if output.quality != QualityOutput::None {
        // Built once; its time counts for no step.
        deformation.prepare_measures();
    }
    let clock = Instant::now();
    let found = deformation.evaluate(&interval, step, rounding, points)?;
    let seconds = clock.elapsed().as_secs_f64();
    Ok(Computed { found, seconds })
}

/// The mesh of a step for writing.
pub(super) struct StepMesh<'a> {
    mesh: &'a Mesh,
    points: &'a [Vector],
    at_points: Vec<DataArray>,
    at_cells: Vec<DataArray>,
    /// True if an array of the mesh with the name of the displacement does not belong to this run, and is left out.
    hides_other: bool,
}

impl<'a> StepMesh<'a> {
    /// Creates the mesh of a step with its nodes at `points`, and the arrays that the schedule asks for and the format holds; the
    /// format would report any other array as left out, which is already known. Takes the velocities of all nodes. Displacements
    /// are relative to `origin`, or else to the mesh that was read. `volume` has the volume cells and their numbers, if these
    /// alone are written. If all ranks write the mesh together, arrays at nodes hold no values.
    pub fn new(
        deformation: &'a Deformation,
        format: &Format,
        points: &'a [Vector],
        velocities: &mut Vec<Vector>,
        origin: Option<&[Vector]>,
        volume: Option<&'a (Mesh, Vec<usize>)>,
    ) -> Result<Self> {
        let (plan, mesh) = (deformation.plan(), deformation.mesh_to_write()?);
        let (output, holds) = (&plan.schedule.output, &format.holds);
        let values = |own: &mut dyn FnMut() -> Vec<Vector>| {
            if deformation.is_written_together() {
                return sparse::zeros(3 * mesh.points.len(), 0.0);
            }
            own().into_flattened()
        };
        let mut arrays = Vec::new();
        if holds.arrays && plan.velocity.is_some() {
            arrays.push((VELOCITY, values(&mut || std::mem::take(velocities))));
        }
        if output.displacement && (holds.arrays || holds.displacement) {
            let from = origin.unwrap_or(&mesh.points);
            let moved = |i: usize| sub(points[i], from[i]);
            let moved = &mut || parallel::collect(points.len(), moved);
            arrays.push((DISPLACEMENT, values(moved)));
        }
        let arrays = arrays.into_iter().filter(|(_, values)| !values.is_empty());
        let array = |(name, values)| DataArray::tuples(name, 3, Values::F64(values));
        let has_cells = holds.arrays && output.quality == QualityOutput::Cells;
        let mut at_cells = match has_cells {
            true => deformation.cell_arrays(points)?,
            false => Vec::new(),
        };
        if let Some((_, kept)) = volume {
            let arrays = at_cells.iter();
            at_cells = arrays.map(|array| array.select(kept)).collect();
        }
        Ok(Self {
            mesh: volume.map_or(mesh, |(volume, _)| volume),
            points,
            at_points: arrays.map(array).collect(),
            at_cells,
            hides_other: !holds.arrays && holds.displacement,
        })
    }

    /// Returns the mesh; `by` has the values of nodes and cells if all ranks write it together.
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

/// Builds the row of a step, without the results of writing it.
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
        [row.min_curved_jacobian, row.min_curved_scaled_jacobian] = cells.min_curved.map(value);
    }
    row
}
