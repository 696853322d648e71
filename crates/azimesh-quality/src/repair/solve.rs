//! One region as a patch: its nodes, its cells with their targets, and where the nodes go.

use super::Task;
use super::density::Space;
use super::elements::{Elements, NewCell, Target};
use super::newton::{SolveStats, minimise, relax};
use super::patch::Patch;
use super::regions::Region;
use super::shape::median;
use super::simplices::Simplices;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::progress::Stop;
use azimesh_io::mesh::CellRef;
use std::collections::BTreeSet;

/// A least determinant below which a patch starts from what follows from its fixed nodes, and not from where its nodes are:
/// from there it takes many Newton steps, and mostly stays folded.
pub(super) const GROSS: f64 = -1e3;

/// New positions of the nodes of a region.
pub(super) struct Solved {
    /// Nodes that could move, with their places.
    pub moved: Vec<(u32, Vector)>,
    /// Cells with a folded simplex of fixed nodes.
    pub stuck: Vec<u32>,
    /// The least determinant of a simplex before.
    pub least_before: f64,
    /// Course of the solution.
    pub course: SolveStats,
}

/// Targets of single cells.
#[derive(Clone, Copy)]
pub(super) struct PatchTargets<'a> {
    /// Cells with simplices between their corners.
    pub between: &'a BTreeSet<u32>,
    /// Cells that are to become regular, whatever the reference.
    pub regular: &'a BTreeSet<u32>,
    /// Weights of the functional.
    pub weights: Weights,
}

/// Weights of the functional.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weights {
    /// Of the size against the shape.
    pub theta: f64,
    /// Of thin cells at fixed nodes against others.
    pub at_walls: f64,
}

/// Folded cells become valid fastest if both count alike.
pub(super) const OF_FOLDED: Weights = Weights {
    theta: 0.5,
    at_walls: 1.0,
};

impl Default for Weights {
    fn default() -> Self {
        OF_FOLDED
    }
}

/// Weights for valid cells of low quality; first cells keep their heights. The first ones, by which sizes count more than
/// shapes, raise most of the low cells further, but not always the lowest one.
pub(super) const OF_VALID: [Weights; 2] = [
    Weights {
        theta: 0.82,
        at_walls: 10.0,
    },
    Weights {
        theta: 0.5,
        at_walls: 10.0,
    },
];

/// Solves a region from `points`. Cells of `between` have simplices between their corners too.
pub(super) fn region(
    task: Task<'_>,
    region: &Region,
    points: &[Vector],
    between: &BTreeSet<u32>,
    most_steps: usize,
    stop: &Stop,
) -> Result<Solved> {
    let wishes = PatchTargets {
        between,
        regular: &BTreeSet::new(),
        weights: OF_FOLDED,
    };
    let (mut patch, stuck) = patch(task, region, points, wishes);
    let before = patch.state(1e-9, &patch.places);
    let mut course = if before.least < GROSS {
        SolveStats {
            steps: 0,
            iterations: 0,
            state: before,
        }
    } else {
        minimise(&mut patch, most_steps, None, stop)?
    };
    if course.state.least <= 0.0 {
        course = start_again(task, &mut patch, course, most_steps, stop)?;
    }
    Ok(Solved {
        moved: patch.moved_nodes().collect(),
        stuck,
        least_before: before.least,
        course,
    })
}

/// Has a patch that is grossly folded start from what follows from its fixed nodes.
pub(super) fn start_from_rim(task: Task<'_>, patch: &mut Patch) {
    let of_mesh = |&node: &u32| task.mesh.points[node as usize];
    let reference: Vec<Vector> = patch.nodes.iter().map(of_mesh).collect();
    relax(patch, &reference);
}

/// Takes a patch that stays folded from the start that follows from its fixed nodes; what has fewer folded simplices is
/// kept.
fn start_again(
    task: Task<'_>,
    patch: &mut Patch,
    first: SolveStats,
    most_steps: usize,
    stop: &Stop,
) -> Result<SolveStats> {
    let reached = patch.places.clone();
    start_from_rim(task, patch);
    let mut course = minimise(patch, most_steps, None, stop)?;
    course.steps += first.steps;
    course.iterations += first.iterations;
    if course.state.n_folded >= first.state.n_folded {
        patch.places = reached;
        course.state = first.state;
    }
    Ok(course)
}

/// The patch of a region, and cells with a folded simplex of fixed nodes.
pub(super) fn patch(
    task: Task<'_>,
    region: &Region,
    points: &[Vector],
    wishes: PatchTargets<'_>,
) -> (Patch, Vec<u32>) {
    let mesh = task.mesh;
    let space = match mesh.dimension() {
        3 => Space::Solid,
        _ => Space::Plane,
    };
    let cells = || {
        region
            .cells
            .iter()
            .map(|&cell| mesh.cells.get(cell as usize))
    };
    let nodes = nodes_of(cells(), task, region);
    let size = typical_size(cells().take(1000), &mesh.points);
    let mut elements = Elements::new(space);
    let mut stuck = Vec::new();
    for listed in cells() {
        let one = listed.uncollapsed();
        let of = one.as_ref().unwrap_or(&mesh.cells);
        let cell = one.as_ref().map_or(listed, |one| one.get(0));
        let own = cell.nodes;
        let local: Vec<u32> = own
            .iter()
            .map(|node| nodes.binary_search(node).expect("all nodes are listed") as u32)
            .collect();
        let places =
            |of: &[Vector]| -> Vec<Vector> { own.iter().map(|&node| of[node as usize]).collect() };
        let is_between = wishes.between.contains(&(listed.index as u32));
        let can_move = own
            .iter()
            .map(|node| region.moving.binary_search(node).is_ok());
        let can_move: Vec<bool> = can_move.collect();
        let reference = task.reference;
        let is_seed = || region.seeds.binary_search(&(listed.index as u32)).is_ok();
        let target = Target {
            reference: &places(&mesh.points),
            sign: f64::from(reference.sign(listed.index)),
            whole: if reference.is_judged_by_volume(listed.index) {
                is_seed()
            } else {
                reference.is_valid(listed.index) && !reference.is_doubtful(listed.index)
            },
            size,
            regular: wishes.regular.contains(&(listed.index as u32)),
            weight: if own.iter().any(|&node| task.freedom.is_fixed(node))
                && is_thin(&places(&mesh.points)[..cell.kind.n_corners(own.len())])
            {
                wishes.weights.at_walls
            } else {
                1.0
            },
            theta: wishes.weights.theta,
        };
        let whole = target.whole;
        let new = NewCell {
            kind: cell.kind,
            nodes: &local,
            at: &places(points),
            can_move: &can_move,
            target,
        };
        let n_stuck = match reference.maps().of(cell.kind, own.len()) {
            Some(map) => elements.push_curved(&new, map.samples(is_between)),
            None => elements.push(&new, Simplices::of(of, &cell, is_between)),
        };
        if n_stuck > 0 && whole {
            stuck.push(listed.index as u32);
        }
    }
    let places = nodes.iter().map(|&node| points[node as usize]).collect();
    let patch = Patch::new(space, nodes, places, &region.moving, task.freedom, elements);
    (patch, stuck)
}

/// All nodes of the cells, and leaders of those that follow others; ascending.
fn nodes_of<'a>(
    cells: impl Iterator<Item = CellRef<'a>>,
    task: Task<'_>,
    region: &Region,
) -> Vec<u32> {
    let mut nodes: Vec<u32> = region.moving.clone();
    for cell in cells {
        nodes.extend_from_slice(cell.nodes);
    }
    let followers = region
        .moving
        .iter()
        .filter_map(|&node| task.freedom.partner(node));
    nodes.extend(followers.map(|partner| partner.leader));
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Returns whether some corner of a cell is ten times as far from the next one as another.
fn is_thin(corners: &[Vector]) -> bool {
    let n = corners.len();
    let lengths = (0..n).map(|i| distance(corners[i], corners[(i + 1) % n]));
    let (least, most) = lengths.fold((f64::INFINITY, 0.0f64), |(least, most), length| {
        (least.min(length), most.max(length))
    });
    most > 10.0 * least
}

/// The middle length of the first edges of some cells.
fn typical_size<'a>(cells: impl Iterator<Item = CellRef<'a>>, points: &[Vector]) -> f64 {
    let lengths = cells.map(|cell| {
        let at = |i: usize| points[cell.nodes[i.min(cell.nodes.len() - 1)] as usize];
        distance(at(0), at(1)).max(distance(at(1), at(2)))
    });
    let size = median(lengths.filter(|length| *length > 0.0).collect());
    if size > 0.0 { size } else { 1.0 }
}
