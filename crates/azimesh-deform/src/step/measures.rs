//! Measures the quality of deformed meshes against the reference mesh.

use super::wall_angles::WallAngles;
use crate::part::Part;
use crate::plan::Plan;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::Mesh;
use azimesh_quality::{Assessment, Quality, QualityEvaluator, Summary};

/// Data of the reference mesh for the quality of every step.
pub(crate) struct Measures {
    pub(crate) evaluator: QualityEvaluator,
    walls: WallAngles,
}

impl Measures {
    /// Computes the measures of the reference mesh of a plan. All ranks call it.
    pub fn new(plan: &Plan, mesh: &Mesh) -> Self {
        let evaluator = QualityEvaluator::new(mesh);
        let faces = plan.moving_faces.iter();
        let here: Vec<u32> = faces.filter_map(|&face| mesh.cell_here(face)).collect();
        Self {
            walls: WallAngles::find(mesh, &evaluator.adjacency, &here),
            evaluator,
        }
    }

    /// Evaluates the quality of the cells with their nodes at `points`. All ranks call it.
    pub fn cells(&self, mesh: &Mesh, points: &[Vector]) -> Summary {
        self.evaluator.cells(mesh, points)
    }

    /// Completes the assessment of the cells. All ranks call it.
    pub fn complete(&self, cells: Summary, mesh: &Mesh, points: &[Vector]) -> Assessment {
        self.evaluator.complete(cells, mesh, points)
    }

    /// Returns the largest change of the angle between a moving wall and its first cell, in degrees. All ranks call it.
    pub fn normal_change(&self, mesh: &Mesh, points: &[Vector]) -> Option<f64> {
        let own = self.walls.largest_change(mesh, points, &mesh.points);
        let all = mesh.ranks().allgather(own);
        all.into_iter().flatten().max_by(f64::total_cmp)
    }

    /// Returns the quality in plain numbers.
    pub fn quality(&self, part: &Part, points: &[Vector]) -> Quality {
        let mesh = &part.mesh;
        let all = self.complete(self.cells(mesh, points), mesh, points);
        let first_cells = part.first_cells.smallest_ratio(mesh, points);
        let normal_change = self.normal_change(mesh, points);
        Quality {
            min_first_cell_ratio: first_cells.unwrap_or(f64::NAN),
            max_normal_change_deg: normal_change.unwrap_or(f64::NAN),
            ..Quality::from(&all)
        }
    }
}
