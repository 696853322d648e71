//! Raises the least scaled Jacobian: cells below a value are given the shapes and sizes of the reference mesh, together with
//! as many rings of neighbours as that takes.

use super::area::{Area, FoldedCells};
use super::regions::Region;
use super::solve::OF_VALID;
use super::{PatchLog, Task};
use crate::{QualityEvaluator, Reference, scaled_jacobians};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::progress::Stop;
use azimesh_io::mesh::Mesh;
use std::collections::BTreeSet;

/// Rings of neighbours around low cells at first; they are doubled as long as cells are low.
const RINGS: usize = 4;
/// Nodes that may move at most.
const MOST_NODES: usize = 500_000;
/// A cell that has kept this part of its scaled Jacobian in the reference mesh is neither low nor worse.
const KEPT: f64 = 0.9;

/// Improves the checked cells whose scaled Jacobian is below `wanted`; a log for each patch of the last round that
/// improved one. Cells that are low in the reference mesh become regular. A patch whose least scaled Jacobian does not
/// rise, or that makes another least value of the mesh worse, is put back. The result is the same on any number of threads.
///
/// # Errors
/// If `stop` was asked for.
pub fn improve(
    task: Task<'_>,
    evaluator: &QualityEvaluator,
    points: &mut [Vector],
    wanted: f64,
    stop: &Stop,
) -> Result<Vec<PatchLog>> {
    let mut logs = Vec::new();
    if super::refused(task.mesh).is_some() {
        return Ok(logs);
    }
    let at = |points: &[Vector]| scaled_jacobians(task.mesh, points, task.reference);
    let at_rest = at(&task.mesh.points);
    let regular = below(&at_rest, wanted);
    let mut values = at(points);
    let summary = evaluator.cells(task.mesh, points);
    for weights in OF_VALID {
        let mut last = Area::default();
        for rings in (0..).map(|n| RINGS << n) {
            let low = FoldedCells {
                cells: below(&values, wanted),
                worse: worse(&values, &at_rest),
            };
            let area = Area::around(task, &low, rings).improving(weights, &regular);
            if area.n_nodes() == 0 || area.n_nodes() > MOST_NODES || area.covers_no_more_than(&last)
            {
                break;
            }
            let before = points.to_vec();
            let repaired = area.relax(task, points, stop)?;
            let now = at(points);
            let put_back = |region: &Region, points: &mut [Vector]| {
                for &node in &region.moving {
                    points[node as usize] = before[node as usize];
                }
            };
            let mut accepted = Vec::new();
            for (region, log) in area.regions.iter().zip(repaired.patches) {
                if log.invalid == 0 && least_of(region, &now) > least_of(region, &values) {
                    accepted.push((region, log));
                } else {
                    put_back(region, points);
                }
            }
            while let Some(cell) = evaluator.cells(task.mesh, points).fallen(&summary) {
                let has = |region: &Region| region.cells.binary_search(&(cell as u32)).is_ok();
                let Some(at) = accepted.iter().position(|(region, _)| has(region)) else {
                    break;
                };
                put_back(accepted.remove(at).0, points);
            }
            if !accepted.is_empty() {
                logs = accepted.into_iter().map(|(_, log)| log).collect();
                values = at(points);
            }
            last = area;
        }
    }
    Ok(logs)
}

/// The cells at `points` whose scaled Jacobian is below `wanted`, and has become less than in the reference mesh.
pub fn low_cells(
    mesh: &Mesh,
    reference: &Reference,
    points: &[Vector],
    wanted: f64,
) -> BTreeSet<u32> {
    FoldedCells::low(mesh, reference, points, wanted).cells
}

impl FoldedCells {
    /// Adds the cells that are low at `points`, and those that have become worse; returns the number of the low ones.
    pub fn add_low(&mut self, task: Task<'_>, points: &[Vector], wanted: f64) -> usize {
        let Self { cells, worse } = Self::low(task.mesh, task.reference, points, wanted);
        let n_low = cells.len();
        self.cells.extend(cells);
        self.worse.extend(worse);
        n_low
    }

    fn low(mesh: &Mesh, reference: &Reference, points: &[Vector], wanted: f64) -> Self {
        let values = scaled_jacobians(mesh, points, reference);
        let low = below(&values, wanted);
        if low.is_empty() {
            return Self::default();
        }
        let worse = worse(&values, &scaled_jacobians(mesh, &mesh.points, reference));
        Self {
            cells: low.intersection(&worse).copied().collect(),
            worse,
        }
    }
}

impl Area {
    /// An area around cells that leaves no cell low at `points`, with `rings` rings or more; or else the one with the largest
    /// least scaled Jacobian.
    ///
    /// # Errors
    /// If `stop` was asked for.
    pub fn lifting(
        task: Task<'_>,
        cells: &FoldedCells,
        rings: usize,
        points: &mut [Vector],
        wanted: f64,
        stop: &Stop,
    ) -> Result<Self> {
        let mut best = (f64::NEG_INFINITY, Self::default());
        for weights in OF_VALID {
            let mut last = Self::default();
            for rings in (0..).map(|n| rings << n) {
                let area = Self::around(task, cells, rings).improving(weights, &BTreeSet::new());
                let is_first = last.regions.is_empty();
                if !is_first && (area.n_nodes() > MOST_NODES || area.covers_no_more_than(&last)) {
                    break;
                }
                area.relax(task, points, stop)?;
                let values = scaled_jacobians(task.mesh, points, task.reference);
                let least = values.into_iter().fold(f64::INFINITY, f64::min);
                if low_cells(task.mesh, task.reference, points, wanted).is_empty() {
                    return Ok(area);
                }
                last = area;
                if least > best.0 {
                    best = (least, last.clone());
                }
            }
        }
        Ok(best.1)
    }
}

/// The cells that have lost much of their scaled Jacobian.
fn worse(values: &[f64], at_rest: &[f64]) -> BTreeSet<u32> {
    let both = (0..).zip(std::iter::zip(values, at_rest));
    let worse = both.filter(|(_, (value, at_rest))| **value < KEPT * **at_rest);
    worse.map(|(cell, _)| cell).collect()
}

fn below(values: &[f64], wanted: f64) -> BTreeSet<u32> {
    let low = (0..).zip(values).filter(|(_, value)| **value < wanted);
    low.map(|(cell, _)| cell).collect()
}

/// The least scaled Jacobian of a region.
fn least_of(region: &Region, values: &[f64]) -> f64 {
    let own = region.cells.iter().map(|&cell| values[cell as usize]);
    own.fold(f64::INFINITY, f64::min)
}
