//! The peak memory of a run, from a plan.
//!
//! Sums of the large arrays, in bytes of nodes, surface points, base points, modes and steps. A run has stages: selection of
//! base points, evaluation and correction of fields, writing of steps. The peak is the largest of them.

use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::amount;
use azimesh_deform::Plan;
use azimesh_deform::motion::{QualityOutput, Step};
use azimesh_io::formats::{Compression, by_name};
use azimesh_io::mesh::Mesh;
use azimesh_quality::QualityEvaluator;

/// Number of base points assumed before their selection.
const N_BASE: usize = 1000;
/// Rows of the Newton basis that the selection holds.
const BASIS: usize = 2048;
/// The program itself, its threads and the memory kept by the system's allocator.
const PROGRAM: usize = 24 << 20;
/// Least memory with arrays in files: the program, small arrays, and pages in use.
const LEAST_WITH_FILES: u64 = 64 << 20;

/// Returns the bytes of memory that a run takes from the system, without the mapped input: the sum plus a tenth for
/// temporary data within a stage.
pub fn estimate_memory(plan: &Plan, mesh: &Mesh) -> u64 {
    let stages = by_stage(plan, mesh);
    stages
        .into_iter()
        .map(|(_, bytes)| bytes)
        .max()
        .unwrap_or(0)
}

/// Returns the same for each stage of a run, with its name in a sentence.
fn by_stage(plan: &Plan, mesh: &Mesh) -> [(&'static str, u64); 3] {
    let whole = |stage: usize| {
        let sum = PROGRAM + held(plan, mesh) + stage;
        (sum + sum / 10) as u64
    };
    [
        ("base points", whole(selecting(plan))),
        ("modes", whole(evaluating(plan))),
        ("steps", whole(writing(plan, mesh))),
    ]
}

/// Storage of the arrays of a run within a limit of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fits {
    /// Its arrays fit.
    InMemory,
    /// Large arrays are stored in files: this many bytes are needed.
    InFiles(u64),
}

/// Checks if a run takes at most `limit` bytes, with large arrays in files if possible (`with_files`). `mapped` is the size
/// of the mapped input, which the system can reclaim and which does not count.
///
/// # Errors
/// If it would take more.
pub fn check_memory(
    plan: &Plan,
    mesh: &Mesh,
    limit: u64,
    with_files: bool,
    mapped: u64,
) -> Result<Fits> {
    let needed = estimate_memory(plan, mesh);
    if needed <= limit {
        return Ok(Fits::InMemory);
    }
    if with_files && limit >= LEAST_WITH_FILES {
        return Ok(Fits::InFiles(needed));
    }
    let stages = by_stage(plan, mesh).map(|(name, bytes)| format!("{name} {}", amount(bytes)));
    let remedy = if with_files {
        format!(
            "from {} on, arrays that do not fit are stored in files on the disk of the output",
            amount(LEAST_WITH_FILES)
        )
    } else {
        "the folder of the output can hold no arrays; boundaries.zones or fewer output arrays reduce that"
            .to_owned()
    };
    Err(Error::input(format!(
        "this run needs about {} of memory, and --max-memory allows {} ({}; the mapped input, {}, does not count); {remedy}",
        amount(needed),
        amount(limit),
        stages.join(", "),
        amount(mapped)
    )))
}

/// Bytes that are held from the plan to the end: cells, groups, arrays, the reference, the surface, modes, and
/// displacements of nodes from functions or files.
fn held(plan: &Plan, mesh: &Mesh) -> usize {
    let n_surface = plan.surface.nodes.len();
    let layers = plan.layers.iter().chain(&plan.velocity);
    let modes: usize = layers
        .map(|layer| 8 * n_surface * layer.modes.n_modes)
        .sum();
    // Coefficients of the modes, stored in the modes and in their criterion; twice per step.
    let coefficients = plan.motion.steps.len() * (48 * plan.n_modes() + 2 * size_of::<Step>());
    mesh.memory_bytes() + 80 * n_surface + modes + coefficients + plan.motion.memory_bytes()
}

fn n_deforming(plan: &Plan) -> usize {
    match &plan.motion.zone {
        Some(zone) => zone.sides.nodes.count(),
        None => plan.boundary.n_nodes,
    }
}

/// Residuals, Newton basis and factors.
fn selecting(plan: &Plan) -> usize {
    let n_surface = plan.surface.nodes.len();
    let n_base = n_surface
        .min(plan.schedule.selection.max_points)
        .min(N_BASE);
    residuals(plan) + 8 * BASIS * n_base + 24 * n_base * n_base
}

fn residuals(plan: &Plan) -> usize {
    8 * plan.surface.nodes.len() * plan.n_modes()
}

/// Values at the surface for the errors before the correction.
fn uncorrected(plan: &Plan) -> usize {
    if plan.layers.len() == 1 && plan.modes_are_exact() {
        0
    } else {
        residuals(plan)
    }
}

fn fields(plan: &Plan) -> usize {
    let n = n_deforming(plan);
    let numbers = if plan.motion.zone.is_some() { 4 * n } else { 0 };
    plan.layers
        .iter()
        .map(|layer| 8 * n * layer.modes.n_modes + numbers)
        .sum()
}

/// Fields, the order of their nodes, and the tree of the correction.
fn evaluating(plan: &Plan) -> usize {
    let tree = if plan.schedule.selection.correction {
        220 * plan.surface.nodes.len()
    } else {
        0
    };
    residuals(plan) + fields(plan) + 12 * n_deforming(plan) + tree
}

/// Fields, positions of this step and the next, orientations of cells, added arrays, and data that is compressed before
/// it is written.
fn writing(plan: &Plan, mesh: &Mesh) -> usize {
    let output = &plan.schedule.output;
    let (n, n_cells) = (plan.boundary.n_nodes, plan.boundary.n_cells);
    let velocity = plan.velocity.as_ref().map_or(0, |layer| {
        48 * n + 8 * layer.modes.n_modes * n_deforming(plan)
    });
    // In a case, also the reference positions of displacements.
    let in_case = by_name(output.format()).is_ok_and(|format| format.case.is_some());
    let displacement = match (output.displacement, in_case) {
        (false, _) => 0,
        (true, false) => 24 * n,
        (true, true) => 48 * n,
    };
    let judge = match output.quality {
        QualityOutput::None => 0,
        QualityOutput::Summary | QualityOutput::Cells => QualityEvaluator::estimate_bytes(mesh),
    };
    // Arrays of the step being written, and of the next one.
    let metrics = match output.quality {
        QualityOutput::Cells => 2 * QualityEvaluator::ARRAY_BYTES * n_cells,
        QualityOutput::Summary | QualityOutput::None => 0,
    };
    let packed = match output.compression {
        Compression::None => 0,
        _ => 24 * n + mesh.cells.memory_bytes() + displacement + metrics / 2,
    };
    fields(plan) + uncorrected(plan) + 48 * n + judge + velocity + displacement + metrics + packed
}
