//! Measures the quality of deformed meshes against the reference mesh.

use super::plan::Plan;
use super::team::Team;
use super::wall_angles::WallAngles;
use crate::geometry::vector::Vector;
use crate::mesh::{Adjacency, DataArray, Slots};
use crate::quality::{Assessment, Judge, Quality, Reference, Summary};
use std::sync::OnceLock;

/// Data of the reference mesh that the quality of every step is measured with.
pub(crate) struct Measures {
    /// Of the whole mesh; where others share it, made when it is needed.
    judge: OnceLock<Judge>,
    walls: OnceLock<WallAngles>,
}

impl Measures {
    /// For the reference mesh of a plan.
    pub fn new(plan: &Plan) -> Self {
        let measures = Self {
            judge: OnceLock::new(),
            walls: OnceLock::new(),
        };
        match judging_team(plan) {
            Some(_) => plan.share(),
            None => {
                measures.walls.get_or_init(|| measures.find_walls(plan));
            }
        }
        measures
    }

    fn find_walls(&self, plan: &Plan) -> WallAngles {
        let adjacency = &self.judge(plan).adjacency;
        WallAngles::find(plan.whole(), adjacency, &plan.moving_faces)
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
        match judging_team(plan) {
            Some(team) => team.cells(points, by_fields),
            None => self.judge(plan).cells(plan.whole(), points),
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
        let faces = match judging_team(plan) {
            Some(team) => team.faces(points, by_fields),
            None => self.judge(plan).faces(plan.whole(), points),
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
        match judging_team(plan) {
            Some(team) => team.normal_change(points, by_fields),
            None => {
                let mesh = plan.whole();
                let walls = self.walls.get_or_init(|| self.find_walls(plan));
                walls.largest_change(mesh, points, &mesh.points)
            }
        }
    }

    /// Every metric as a cell array.
    pub fn arrays(&self, plan: &Plan, points: &[Vector]) -> Vec<DataArray> {
        self.judge(plan).arrays(&plan.mesh, points)
    }

    /// The quality in plain numbers.
    pub fn quality(&self, plan: &Plan, points: &[Vector]) -> Quality {
        let all = self.complete(plan, self.cells(plan, points, None), points, None);
        let first_cells = plan
            .first_cells
            .smallest_ratio((Slots::All, points), &plan.mesh);
        let normal_change = self.normal_change(plan, points, None);
        Quality {
            min_first_cell_ratio: first_cells.unwrap_or(f64::NAN),
            max_normal_change_deg: normal_change.unwrap_or(f64::NAN),
            ..Quality::from(&all)
        }
    }
}

/// The ranks that judge meshes, where they do.
fn judging_team(plan: &Plan) -> Option<&Team> {
    let team = plan.team().filter(|_| plan.judges());
    team.map(|team| &**team)
}
