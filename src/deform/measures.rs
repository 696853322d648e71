//! Measures the quality of deformed meshes against the reference mesh.

use super::plan::Plan;
use super::team::Team;
use super::wall_angles::WallAngles;
use crate::geometry::vector::Vector;
use crate::mesh::{Adjacency, DataArray};
use crate::quality::{Assessment, Judge, Quality, Reference, Summary};
use std::sync::{Arc, OnceLock};

/// Data of the reference mesh that the quality of every step is measured with.
pub(crate) struct Measures {
    /// Of the whole mesh; where ranks share it, made when it is needed.
    judge: OnceLock<Judge>,
    walls: WallAngles,
    team: Option<Arc<Team>>,
}

impl Measures {
    /// For the reference mesh of a plan.
    pub fn new(plan: &Plan) -> Self {
        let mut measures = Self {
            judge: OnceLock::new(),
            walls: WallAngles::default(),
            team: plan.team.clone().filter(|_| plan.judges()),
        };
        match &measures.team {
            Some(_) => plan.share(),
            None => {
                let adjacency = &measures.judge(plan).adjacency;
                measures.walls = WallAngles::find(&plan.mesh, adjacency, &plan.moving_faces);
            }
        }
        measures
    }

    fn judge(&self, plan: &Plan) -> &Judge {
        self.judge.get_or_init(|| Judge::new(plan.whole()))
    }

    /// Orientation of the cells in the reference mesh.
    pub fn orientation(&self, plan: &Plan) -> &Reference {
        &self.judge(plan).reference
    }

    /// Which cells share each face.
    pub fn adjacency(&self, plan: &Plan) -> &Adjacency {
        &self.judge(plan).adjacency
    }

    /// The quality of the cells with their nodes at `points`, which are those of a step `by_fields` alone where that says so.
    pub fn cells(&self, plan: &Plan, points: &[Vector], by_fields: Option<usize>) -> Summary {
        match &self.team {
            Some(team) => team.cells(points, by_fields),
            None => self.judge(plan).cells(&plan.mesh, points),
        }
    }

    /// The whole assessment, from that of the cells.
    pub fn complete(
        &self,
        plan: &Plan,
        cells: Summary,
        points: &[Vector],
        by_fields: Option<usize>,
    ) -> Assessment {
        let faces = match &self.team {
            Some(team) => team.faces(points, by_fields),
            None => self.judge(plan).faces(&plan.mesh, points),
        };
        Assessment { cells, faces }
    }

    /// Largest change of the angle between a moving wall and its first cell, in degrees.
    pub fn normal_change(
        &self,
        plan: &Plan,
        points: &[Vector],
        by_fields: Option<usize>,
    ) -> Option<f64> {
        let before = &plan.mesh.points;
        match &self.team {
            Some(team) => team.normal_change(points, by_fields),
            None => self.walls.largest_change(&plan.mesh, points, before),
        }
    }

    /// Every metric as a cell array.
    pub fn arrays(&self, plan: &Plan, points: &[Vector]) -> Vec<DataArray> {
        self.judge(plan).arrays(&plan.mesh, points)
    }

    /// The quality in plain numbers.
    pub fn quality(&self, plan: &Plan, points: &[Vector]) -> Quality {
        let all = self.complete(plan, self.cells(plan, points, None), points, None);
        let first_cells = plan.first_cells.smallest_ratio(points, &plan.mesh.points);
        let normal_change = self.normal_change(plan, points, None);
        Quality {
            min_first_cell_ratio: first_cells.unwrap_or(f64::NAN),
            max_normal_change_deg: normal_change.unwrap_or(f64::NAN),
            ..Quality::from(&all)
        }
    }
}
