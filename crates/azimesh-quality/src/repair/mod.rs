//! Makes folded cells valid by moving nodes near them, where a valid mesh exists.
//!
//! Owns patches (folded cells and rings of neighbours), the functional that is minimised over each, and their report. `quality`
//! decides which cells are checked, and the caller which nodes are fixed or slide, by [`Freedom`]. `docs/method.md` has the
//! equations.

mod area;
mod boundary;
mod density;
mod derivatives;
mod elements;
mod freedom;
mod history;
mod improve;
mod nearby;
mod newton;
mod numbering;
mod outcome;
mod patch;
mod regions;
mod shape;
mod simplices;
mod singular;
mod solve;
#[cfg(test)]
mod tests;

pub use area::{Area, Count, FoldedCells};
pub use boundary::CrossedFace;
pub use freedom::{Freedom, Partner};
pub use improve::{improve, low_cells};
pub use outcome::{PatchLog, Reason, Repaired, Unrepaired};

use crate::Reference;
use crate::validity::{CurvedMaps, Proof, invalid, state};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::parallel;
use azimesh_core::progress::Stop;
use azimesh_io::mesh::{CellRun, Mesh};
use boundary::Boundary;
use nearby::Nearby;
use regions::Region;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// A mesh whose cells are to become valid.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The mesh in its reference positions, which give the shapes that cells are to have.
    pub mesh: &'a Mesh,
    /// The orientation of its cells, and the cells that are checked.
    pub reference: &'a Reference,
    /// Constraints of the nodes.
    pub freedom: &'a Freedom,
}

/// Limits of a repair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Rings of neighbours at first.
    pub first_rings: usize,
    /// Rings at most: they are doubled as long as a patch has a folded cell.
    pub most_rings: usize,
    /// Newton steps of a patch for each number of rings.
    pub most_steps: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            first_rings: 1,
            most_rings: 48,
            most_steps: 60,
        }
    }
}

/// A region that is not finished.
struct Open {
    seeds: Vec<u32>,
    /// Previous positions of its nodes.
    before: BTreeMap<u32, Vector>,
    /// The least determinant when it was valid; 0 where it never was.
    least: f64,
    log: PatchLog,
}

/// A valid region is solved again with more rings while its least determinant is below this and has become larger by
/// this factor.
const ENOUGH: f64 = 0.02;
const WORTH: f64 = 1.5;
/// The same at a boundary that does not move: its first cells should keep their heights.
const ENOUGH_AT_WALL: f64 = 0.9;
const WORTH_AT_WALL: f64 = 1.05;
const MOST_RINGS_OF_VALID: usize = 24;
/// As long as it has no more nodes than these that can move.
const MOST_NODES_OF_VALID: usize = 6000;

/// Times that the nodes between corners are moved by themselves, with many samples in cells that are left.
const TRIES_BETWEEN: usize = 3;

/// Nodes of a curved cell at most: work grows with the square.
const MOST_NODES_OF_CURVED: usize = 216;

/// Moves nodes of `points` so that every checked cell becomes valid, as few of them as possible. The result is the same
/// on any number of threads.
///
/// # Errors
/// If `stop` was requested.
pub fn untangle(
    task: Task<'_>,
    points: &mut [Vector],
    limits: Limits,
    stop: &Stop,
) -> Result<Repaired> {
    let mut found = invalid(task.mesh, points, task.reference);
    let mut repaired = Repaired::default();
    let cells =
        |found: &[(u32, Proof)]| -> Vec<u32> { found.iter().map(|entry| entry.0).collect() };
    let mut seeds = cells(&found);
    if seeds.is_empty() {
        return Ok(repaired);
    }
    if let Some(reason) = refused(task.mesh) {
        repaired.give_up(seeds, reason);
        return Ok(repaired);
    }
    let (nearby, boundary) = (Nearby::new(task.mesh), OnceLock::new());
    if !task.reference.maps().is_empty() {
        repaired.patches = between_corners(task, &nearby, &seeds, points, limits, stop)?;
        found = still_invalid(task, &seeds, points);
        seeds = cells(&found);
    }
    let mut between: BTreeSet<u32> = between_of(&found);
    between.retain(|&cell| !has_map(task, cell));
    let mut rings = limits.first_rings;
    let mut open = Vec::new();
    if !seeds.is_empty() {
        open.push(Open {
            seeds,
            before: BTreeMap::new(),
            least: 0.0,
            log: PatchLog::default(),
        });
    }
    let mut n_moving = 0;
    let mut tries = 0;
    while !open.is_empty() {
        let round = Round {
            task,
            nearby: &nearby,
            boundary: &boundary,
            rings,
            limits,
            stop,
        };
        let n_before = n_moving;
        let outcome = round.run(points, &mut open, &between, &mut repaired)?;
        n_moving = outcome.n_moving;
        tries += 1;
        let new: BTreeSet<u32> = outcome.between.difference(&between).copied().collect();
        // Points between corners are added first, rings if that does not help.
        if !new.is_empty() && tries < 4 {
            between.extend(new);
            n_moving = 0;
            continue;
        }
        tries = 0;
        rings *= 2;
        if rings > limits.most_rings || n_moving == n_before {
            break;
        }
    }
    for open in open {
        repaired.finish(task, &nearby, open, points, Reason::NotFound);
    }
    repaired.unrepaired.sort_unstable_by_key(|entry| entry.cell);
    repaired.unrepaired.dedup_by_key(|entry| entry.cell);
    Ok(repaired)
}

/// Moves the nodes of folded curved cells that are no corners: they have followed a field that their corners bear. Regions that
/// do not become valid are put back.
fn between_corners(
    task: Task<'_>,
    nearby: &Nearby<'_>,
    seeds: &[u32],
    points: &mut [Vector],
    limits: Limits,
    stop: &Stop,
) -> Result<Vec<PatchLog>> {
    let mut freedom = task.freedom.clone();
    for run in task.mesh.volume_runs() {
        let n_corners = run.kind.n_corners(run.n_nodes);
        let corners = run.cells().flat_map(|nodes| &nodes[..n_corners]);
        corners.for_each(|&corner| freedom.fix(corner));
    }
    let inner = Task {
        freedom: &freedom,
        ..task
    };
    let (regions, _) = regions::around(nearby, &freedom, seeds, 0);
    let new = PatchLog {
        least_before: f64::INFINITY,
        ..PatchLog::default()
    };
    let with_log = |region| (region, new.clone());
    let mut regions: Vec<(Region, PatchLog)> = regions.into_iter().map(with_log).collect();
    let original = points.to_vec();
    let mut many_samples = BTreeSet::new();
    let mut logs = Vec::new();
    for _ in 0..TRIES_BETWEEN {
        let solved = parallel::try_map(regions.len(), &|i| {
            let steps = limits.most_steps;
            solve::region(inner, &regions[i].0, points, &many_samples, steps, stop)
        })?;
        let mut open = Vec::new();
        for ((region, mut log), solved) in regions.into_iter().zip(solved) {
            log.add(&solved, 0, &region);
            for &(node, place) in &solved.moved {
                points[node as usize] = place;
            }
            let left = still_invalid(task, &region.cells, points);
            if !left.is_empty() {
                many_samples.extend(left.into_iter().map(|entry| entry.0));
                open.push((region, log));
                continue;
            }
            let place = |&node: &u32| (node, original[node as usize]);
            let before = region.moving.iter().map(place).collect();
            log.largest_move = largest_move(&before, points);
            logs.push(log);
        }
        regions = open;
    }
    for node in regions.into_iter().flat_map(|(region, _)| region.moving) {
        points[node as usize] = original[node as usize];
    }
    Ok(logs)
}

/// Returns whether a cell is checked as a curved cell.
fn has_map(task: Task<'_>, cell: u32) -> bool {
    let cell = task.mesh.cells.get(cell as usize);
    let maps = task.reference.maps();
    maps.of(cell.kind, cell.nodes.len()).is_some()
}

/// Returns the reason why no cell of a mesh can be repaired, if there is one.
pub fn refused(mesh: &Mesh) -> Option<Reason> {
    if mesh.dimension() < 2 || mesh.dimension() < mesh.space_dimension() {
        return Some(Reason::Surface);
    }
    let maps = CurvedMaps::new(mesh);
    let is_left_out = |run: CellRun<'_>| {
        run.kind.is_curved()
            && run.n_nodes > run.kind.n_corners(run.n_nodes)
            && (run.n_nodes > MOST_NODES_OF_CURVED || maps.of(run.kind, run.n_nodes).is_none())
    };
    mesh.volume_runs()
        .any(is_left_out)
        .then_some(Reason::Curved)
}

/// Cells whose simplices between corners are needed.
fn between_of(found: &[(u32, Proof)]) -> BTreeSet<u32> {
    let inside = found
        .iter()
        .filter(|(_, proof)| matches!(proof, Proof::Inside | Proof::Unproven));
    inside.map(|entry| entry.0).collect()
}

/// All regions for one number of rings.
struct Round<'a> {
    task: Task<'a>,
    nearby: &'a Nearby<'a>,
    /// Made when a region is not valid after its first round.
    boundary: &'a OnceLock<Option<Boundary>>,
    rings: usize,
    limits: Limits,
    stop: &'a Stop,
}

/// Remainder of a round.
struct Outcome {
    /// Nodes that could move.
    n_moving: usize,
    /// Cells that are valid at their corners alone.
    between: BTreeSet<u32>,
}

impl Round<'_> {
    /// Solves the regions around all open seeds; valid ones are added to `repaired`, the others stay open.
    fn run(
        &self,
        points: &mut [Vector],
        open: &mut Vec<Open>,
        between: &BTreeSet<u32>,
        repaired: &mut Repaired,
    ) -> Result<Outcome> {
        let task = self.task;
        let mut seeds: Vec<u32> = open.iter().flat_map(|open| open.seeds.clone()).collect();
        seeds.sort_unstable();
        seeds.dedup();
        let (regions, stuck) = regions::around(self.nearby, task.freedom, &seeds, self.rings);
        repaired.give_up(stuck, Reason::Fixed);
        let solved = parallel::try_map(regions.len(), &|i| {
            solve::region(
                task,
                &regions[i],
                points,
                between,
                self.limits.most_steps,
                self.stop,
            )
        })?;
        let earlier = std::mem::take(open);
        let mut outcome = Outcome {
            n_moving: regions.iter().map(|region| region.moving.len()).sum(),
            between: BTreeSet::new(),
        };
        for (region, solved) in regions.iter().zip(solved) {
            let mut next = self.opened(region, &earlier, points);
            next.log.add(&solved, self.rings, region);
            for &(node, place) in &solved.moved {
                points[node as usize] = place;
            }
            let left = still_invalid(task, &region.cells, points);
            outcome.between.extend(between_of(&left));
            next.log.invalid = left.len();
            next.log.largest_move = largest_move(&next.before, points);
            let stuck: BTreeSet<u32> = solved.stuck.iter().copied().collect();
            if left.is_empty() && self.is_squeezed(&mut next, region) {
                open.push(next);
            } else if left.iter().all(|(cell, _)| stuck.contains(cell)) {
                repaired.give_up(
                    left.into_iter().map(|entry| entry.0).collect(),
                    Reason::Fixed,
                );
                repaired.patches.push(next.log);
            } else {
                let left: Vec<u32> = left.into_iter().map(|entry| entry.0).collect();
                match self.overtaken(points, region, &left) {
                    proof if proof.is_empty() => open.push(next),
                    proof => {
                        repaired.finish(task, self.nearby, next, points, Reason::Boundary);
                        repaired.overtaken.extend(proof);
                    }
                }
            }
        }
        Ok(outcome)
    }

    /// Faces of a region that prove that there is no valid mesh.
    fn overtaken(&self, points: &[Vector], region: &Region, left: &[u32]) -> Vec<CrossedFace> {
        let task = self.task;
        let boundary = self.boundary.get_or_init(|| Boundary::of(task, points));
        match boundary {
            Some(boundary) if !left.is_empty() => {
                boundary.overtaken(task, points, &region.cells, left)
            }
            _ => Vec::new(),
        }
    }

    /// Returns whether a valid region should be solved again with more rings, since its cells are much smaller than in the
    /// reference, and more rings have helped so far.
    fn is_squeezed(&self, open: &mut Open, region: &Region) -> bool {
        let least = open.log.least;
        let before = std::mem::replace(&mut open.least, least);
        let is_small = open.log.n_nodes <= MOST_NODES_OF_VALID;
        let (mesh, freedom) = (self.task.mesh, self.task.freedom);
        let is_at_wall = |cell: &u32| {
            let nodes = mesh.cells.get(*cell as usize).nodes;
            nodes.iter().any(|&node| freedom.is_fixed(node))
        };
        let (enough, worth) = if region.cells.iter().any(is_at_wall) {
            (ENOUGH_AT_WALL, WORTH_AT_WALL)
        } else {
            (ENOUGH, WORTH)
        };
        let helped = least > worth * before;
        least < enough && helped && is_small && 2 * self.rings <= MOST_RINGS_OF_VALID
    }

    /// A region with what is known of it from rounds of fewer rings.
    fn opened(&self, region: &Region, earlier: &[Open], points: &[Vector]) -> Open {
        let mut next = Open {
            seeds: region.seeds.clone(),
            before: BTreeMap::new(),
            least: 0.0,
            log: PatchLog {
                least_before: f64::INFINITY,
                ..PatchLog::default()
            },
        };
        for old in earlier {
            if old
                .seeds
                .iter()
                .any(|seed| region.seeds.binary_search(seed).is_ok())
            {
                next.before
                    .extend(old.before.iter().map(|(node, place)| (*node, *place)));
                next.log.steps += old.log.steps;
                next.log.iterations += old.log.iterations;
                next.least = next.least.max(old.least);
                if old.log.rings > 0 {
                    next.log.least_before = next.log.least_before.min(old.log.least_before);
                }
            }
        }
        for &node in &region.moving {
            next.before.entry(node).or_insert(points[node as usize]);
        }
        next
    }
}

impl PatchLog {
    fn add(&mut self, solved: &solve::Solved, rings: usize, region: &Region) {
        self.invalid_before = region.seeds.len();
        self.first_cell = region.seeds.first().map_or(0, |&cell| cell as usize);
        self.n_cells = region.cells.len();
        self.n_nodes = region.moving.len();
        self.rings = rings;
        self.steps += solved.course.steps;
        self.iterations += solved.course.iterations;
        if self.least_before == f64::INFINITY {
            self.least_before = solved.least_before;
        }
        self.least = solved.course.state.least;
    }
}

impl Repaired {
    /// Checks the cells again after the coordinates were rounded to 32 bits.
    pub fn judge_rounded(&mut self, task: Task<'_>, points: &[Vector]) {
        let before = std::mem::take(&mut self.unrepaired);
        for (cell, _) in invalid(task.mesh, points, task.reference) {
            let cell = cell as usize;
            let known = before.iter().find(|left| left.cell == cell);
            self.unrepaired.push(Unrepaired {
                cell,
                reason: known.map_or(Reason::Rounded, |left| left.reason),
            });
        }
    }

    /// Closes a region that is not finished when no more rings are left. One that has not become valid, and has as
    /// many invalid cells as before, is put back.
    fn finish(
        &mut self,
        task: Task<'_>,
        nearby: &Nearby<'_>,
        mut open: Open,
        points: &mut [Vector],
        reason: Reason,
    ) {
        if open.log.invalid == 0 {
            self.patches.push(open.log);
            return;
        }
        if open.log.invalid >= open.log.invalid_before {
            for (&node, &place) in &open.before {
                points[node as usize] = place;
            }
            open.log.largest_move = 0.0;
            open.log.least = open.log.least_before;
            open.log.invalid = open.log.invalid_before;
        }
        let moved: Vec<u32> = open.before.keys().copied().collect();
        let cells = nearby.cells_of(&moved);
        let left = still_invalid(task, &cells, points);
        self.give_up(left.into_iter().map(|entry| entry.0).collect(), reason);
        self.patches.push(open.log);
    }
}

fn largest_move(before: &BTreeMap<u32, Vector>, points: &[Vector]) -> f64 {
    let moves = before
        .iter()
        .map(|(&node, &place)| distance(place, points[node as usize]));
    moves.fold(0.0, f64::max)
}

/// The cells that are not valid.
fn still_invalid(task: Task<'_>, cells: &[u32], points: &[Vector]) -> Vec<(u32, Proof)> {
    let states = parallel::map_blocks(cells.len(), 256, &|range| {
        let of = |&cell: &u32| {
            (
                cell,
                state(task.mesh, points, task.reference, cell as usize),
            )
        };
        cells[range]
            .iter()
            .map(of)
            .filter(|(_, proof)| *proof != Proof::Valid)
            .collect::<Vec<_>>()
    });
    states.concat()
}
