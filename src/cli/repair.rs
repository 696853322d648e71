//! `azimesh repair`: makes folded cells of a mesh valid, without a motion.

use super::output::{self, OutputArgs};
use super::{Context, Outcome};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::vector::{distance, norm, sub};
use azimesh_core::numbers::{short, with_verb};
use azimesh_core::progress::Stop;
use azimesh_core::{Note, note};
use azimesh_io::formats::guard_inputs;
use azimesh_io::mesh::facets::facets;
use azimesh_io::mesh::{Adjacency, Coincident, Mesh, in_32_bits};
use azimesh_quality::repair::{
    CrossedFace, Freedom, Limits, PatchLog, Reason, Repaired, Task, Unrepaired, improve, untangle,
};
use azimesh_quality::{Flaws, QualityEvaluator};
use azimesh_rbf::images::Images;
use azimesh_rbf::slide::{Sliding, SlidingFacets};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Largest number of cells named in a sentence.
const MOST_NAMED: usize = 10;

/// Arguments of `azimesh repair`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Only nodes near folded cells move. Nodes of the boundary stay, but for those of --slide. Cells keep the \
shapes that they have in the reference mesh; without --reference, those that valid cells have now, and regular ones for \
the folded cells.\n\n\
Exit code 0: every cell is valid; 1: some are not, and are named; the mesh is written all the same."
)]
pub struct RepairArgs {
    /// Mesh; - is standard input
    mesh: PathBuf,
    /// Write the repaired mesh here; cells are evaluated with the coordinates in this file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Undeformed mesh with the same cells
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// Continue until the smallest scaled Jacobian is Q, or cannot be improved
    #[arg(long, value_name = "Q")]
    improve: Option<f64>,
    /// Let the nodes of this boundary tag slide in its planes and along its straight edges; repeatable
    #[arg(long, value_name = "TAG")]
    slide: Vec<String>,
    #[command(flatten)]
    write: OutputArgs,
}

/// The results.
struct Findings {
    before: Flaws,
    after: Flaws,
    n_reversed: usize,
    n_nodes: usize,
    n_moved: usize,
    largest_move: f64,
    repaired: Repaired,
    improved: Vec<PatchLog>,
    scaled_before: Option<f64>,
    scaled: Option<f64>,
}

pub(super) fn run(args: &RepairArgs, context: &Context) -> Result<Outcome> {
    if let Some(wanted) = args.improve.filter(|q| !(0.0..=1.0).contains(q)) {
        let found = short(wanted);
        return Err(Error::input(format!(
            "--improve {found}: a scaled Jacobian is between 0 and 1"
        )));
    }
    context.check_json_beside(&args.output)?;
    guard_inputs(std::iter::once(&args.mesh).chain(&args.reference));
    args.write.check(&args.output)?;
    let format = output::format_of(&args.output, context)?;
    let mut mesh = context.read_mesh(&args.mesh)?;
    let given = match &args.reference {
        Some(path) => {
            let given = context.read_mesh(path)?;
            if !mesh.cells.follow(&given.cells) {
                let message = "its cells differ from the reference mesh, which must have the same cells in the same order";
                return Err(Error::input(message).file(&args.mesh));
            }
            given
        }
        None => mesh.clone(),
    };
    let adjacency = Adjacency::of(&mesh);
    let freedom = freedom(&mesh, &adjacency, &given.points, &args.slide)?;
    let evaluator = context.stage("reference", || Ok(QualityEvaluator::new(&given)))?;
    let evaluator = evaluator.upright(&given, args.reference.is_some());
    let task = Task {
        mesh: &given,
        reference: &evaluator.reference,
        freedom: &freedom,
    };
    let is_rounded = format.rounds(args.write.precision);
    let findings = repair(
        args,
        context,
        task,
        &evaluator,
        is_rounded,
        &mut mesh.points,
    )?;
    args.write.save(&mesh, &args.output, format, context)?;
    findings.tell(context, args)?;
    Ok(if findings.repaired.unrepaired.is_empty() {
        Outcome::Fine
    } else {
        Outcome::CheckFailed
    })
}

fn repair(
    args: &RepairArgs,
    context: &Context,
    task: Task<'_>,
    evaluator: &QualityEvaluator,
    is_rounded: bool,
    points: &mut [[f64; 3]],
) -> Result<Findings> {
    let scaled = |points: &[[f64; 3]]| {
        let summary = evaluator.cells(task.mesh, points);
        summary.min_scaled_jacobian.map(|extreme| extreme.value)
    };
    let flaws = |points: &[[f64; 3]]| Flaws::of(task.mesh, points, task.reference);
    let (before, scaled_before, original) = (flaws(points), scaled(points), points.to_vec());
    let (limits, stop) = (Limits::default(), Stop::default());
    let untangled = || untangle(task, points, limits, &stop);
    let mut repaired = context.stage("repair", untangled)?;
    let improved = match args.improve {
        Some(wanted) => context.stage("improve", || {
            improve(task, evaluator, points, wanted, &stop)
        })?,
        None => Vec::new(),
    };
    let moves = points.iter().zip(&original).map(|(a, b)| distance(*a, *b));
    let n_moved = moves.clone().filter(|way| *way > 0.0).count();
    let largest_move = moves.fold(0.0, f64::max);
    if is_rounded {
        points.iter_mut().for_each(|x| *x = in_32_bits(*x));
        repaired.judge_rounded(task, points);
    }
    Ok(Findings {
        before,
        after: flaws(points),
        n_nodes: points.len(),
        n_moved,
        largest_move,
        n_reversed: task.reference.n_reversed(),
        repaired,
        improved,
        scaled_before,
        scaled: scaled(points),
    })
}

/// Returns the freedom of the nodes. The boundary is fixed, except nodes of sliding tags that are in no other tag. Their
/// planes come from the reference, in which no face is folded, if the nodes are still in them.
fn freedom(
    mesh: &Mesh,
    adjacency: &Adjacency,
    reference: &[[f64; 3]],
    slide: &[String],
) -> Result<Freedom> {
    let outer = Freedom::inner(mesh, adjacency, &Coincident::default());
    // Two nodes inside a folded mesh may lie at one place by chance.
    let copies = Coincident::of(
        reference,
        |node| if outer.is_fixed(node) { 0 } else { node + 1 },
    );
    let mut freedom = match copies.is_empty() {
        true => outer,
        false => Freedom::inner(mesh, adjacency, &copies),
    };
    if slide.is_empty() {
        freedom.unite(&copies);
        return Ok(freedom);
    }
    let mut nodes: Vec<u32> = Vec::new();
    for name in slide {
        nodes.extend(mesh.tag_nodes(name)?);
    }
    nodes.sort_unstable();
    nodes.dedup();
    let mut slides = vec![true; nodes.len()];
    let (mut pieces, mut numbers) = (Vec::new(), Vec::new());
    for (number, tag) in (0..).zip(mesh.boundary_tags()) {
        let cells = tag
            .cells
            .ranges()
            .flat_map(|range| mesh.cells.runs_in(range));
        for cell in cells.flat_map(|run| run.cell_refs()) {
            let place = |&node: &u32| nodes.binary_search(&node).ok();
            if !slide.contains(&tag.name) {
                cell.nodes
                    .iter()
                    .filter_map(place)
                    .for_each(|at| slides[at] = false);
                continue;
            }
            for facet in facets(cell.kind, cell.nodes.len()) {
                let corner = |i: usize| place(&cell.nodes[i]).unwrap_or_default() as u32;
                pieces.push(facet.map(corner));
                numbers.push(number);
            }
        }
    }
    let of = |points: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let own = nodes.iter().map(|&node| points[node as usize]);
        own.collect()
    };
    let (now, then) = (of(&mesh.points), of(reference));
    let alone = Images::default();
    let facets = SlidingFacets::flat(pieces, numbers);
    let mut sliding = Sliding::new(&then, &facets, &slides, &alone);
    let has_left = |at: usize| {
        let way = sub(now[at], then[at]);
        let kept = sliding.constraint(at).remove(way);
        let rounding = 1e-12 * norm(now[at]);
        sliding.is_linear(at) && distance(way, kept) > 1e-6 * norm(way) + rounding
    };
    if (0..nodes.len()).any(has_left) {
        sliding = Sliding::new(&now, &facets, &slides, &alone);
    }
    for (at, &node) in nodes.iter().enumerate() {
        if sliding.is_linear(at) {
            freedom.hold(node, sliding.constraint(at));
        }
    }
    freedom.unite(&copies);
    Ok(freedom)
}

impl Findings {
    fn tell(&self, context: &Context, args: &RepairArgs) -> Result<()> {
        for log in self.repaired.patches.iter().chain(&self.improved) {
            context.detail(&sentence(log));
        }
        if self.n_reversed > 0 {
            context.note(note!(
                "reversed",
                "{} listed in the other orientation: evaluated as mirror images, and the nodes keep their order",
                with_verb(self.n_reversed, "cell", "is")
            ));
        }
        if let (Some(wanted), Some(found)) = (args.improve, self.scaled)
            && found < wanted
        {
            let (found, wanted) = (short(found), short(wanted));
            context.note(note!(
                "not_improved",
                "the smallest scaled Jacobian is {found}, not {wanted}; no better was found"
            ));
        }
        for reason in [
            Reason::Fixed,
            Reason::Boundary,
            Reason::NotFound,
            Reason::Surface,
            Reason::Curved,
            Reason::Rounded,
        ] {
            let cells = self
                .repaired
                .unrepaired
                .iter()
                .filter(|left| left.reason == reason);
            let cells: Vec<&Unrepaired> = cells.collect();
            if !cells.is_empty() {
                context.complain(left_over(&cells, reason));
            }
        }
        let overtaken = &self.repaired.overtaken;
        for face in overtaken.iter().take(MOST_NAMED) {
            context.complain(in_the_way(face));
        }
        if overtaken.len() > MOST_NAMED {
            let more = counted(overtaken.len() - MOST_NAMED, "more face");
            context.complain(note!(
                "more_overtaken",
                "and {more} on the wrong side of the boundary"
            ));
        }
        match (context.common.json, args.output.as_os_str() == "-") {
            (true, _) => context.print_json(&self.as_json())?,
            (false, true) => context.print_aside(&self.as_text()),
            (false, false) => context.print_result(&self.as_text())?,
        }
        Ok(())
    }

    fn as_text(&self) -> String {
        let mut text = String::new();
        let mut row = |name: &str, value: String| {
            writeln!(text, "{name:28}{value}").expect("a string takes any text");
        };
        let value = |value: Option<f64>| value.map_or_else(|| "-".into(), short);
        let patches = &self.repaired.patches;
        let mut before_after = |name: &str, of: fn(&Flaws) -> usize| {
            row(&format!("{name} before"), of(&self.before).to_string());
            row(&format!("{name} after"), of(&self.after).to_string());
        };
        before_after("invalid cells", |flaws| flaws.n_invalid);
        before_after("negative volume", |flaws| flaws.negative.n);
        row("patches", patches.len().to_string());
        if !self.improved.is_empty() {
            row("patches improved", self.improved.len().to_string());
        }
        let (n, all) = (self.n_moved, self.n_nodes);
        let share = 100.0 * n as f64 / all.max(1) as f64;
        row("nodes moved", format!("{n} of {all} ({share:.1} %)"));
        row("largest move", short(self.largest_move));
        row("min_scaled_jacobian before", value(self.scaled_before));
        row("min_scaled_jacobian after", value(self.scaled));
        text
    }

    fn as_json(&self) -> RepairResult {
        let (unrepaired, overtaken) = (&self.repaired.unrepaired, &self.repaired.overtaken);
        RepairResult {
            invalid_before: self.before.n_invalid,
            invalid: self.after.n_invalid,
            negative_cells_before: self.before.negative.n,
            negative_cells: self.after.negative.n,
            nodes: self.n_nodes,
            nodes_moved: self.n_moved,
            largest_move: self.largest_move,
            min_scaled_jacobian_before: self.scaled_before,
            min_scaled_jacobian: self.scaled,
            patches: self.repaired.patches.iter().map(Patch::of).collect(),
            improved: self.improved.iter().map(Patch::of).collect(),
            unrepaired: unrepaired
                .iter()
                .map(|left| Left {
                    cell: left.cell,
                    reason: left.reason.name(),
                })
                .collect(),
            overtaken: overtaken
                .iter()
                .map(|face| Face {
                    cell: face.cell,
                    nodes: face.nodes.clone(),
                })
                .collect(),
        }
    }
}

/// The patches whose nodes moved, and the cells that are not valid.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RepairResult {
    /// Cells that were not valid: inverted at a corner or between corners, or unproven.
    invalid_before: usize,
    /// Cells that are not valid now.
    invalid: usize,
    /// Cells that had a negative volume, as in `info`.
    negative_cells_before: usize,
    /// Cells of negative volume now: those whose nodes are in reverse order stay so.
    negative_cells: usize,
    /// Nodes of the mesh.
    nodes: usize,
    /// Nodes that have moved.
    nodes_moved: usize,
    /// Largest displacement of a node, mesh units.
    largest_move: f64,
    /// Smallest scaled Jacobian before; null where no cell has one.
    min_scaled_jacobian_before: Option<f64>,
    /// Smallest scaled Jacobian now; null where no cell has one.
    min_scaled_jacobian: Option<f64>,
    /// The patches, by their number of rings.
    patches: Vec<Patch>,
    /// Patches of the last round of `--improve`.
    improved: Vec<Patch>,
    /// Cells that are not valid now.
    unrepaired: Vec<Left>,
    /// Faces of the boundary that prove that there is no valid mesh: their nodes are fixed, and the outside of the mesh is
    /// on their inner side.
    overtaken: Vec<Face>,
}

/// A patch.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Patch {
    /// The first cell that was not valid, from 0.
    first_cell: usize,
    /// Cells that were not valid.
    invalid_before: usize,
    /// Cells that are not valid after it.
    invalid: usize,
    /// Cells of the patch.
    cells: usize,
    /// Nodes that could move.
    nodes: usize,
    /// Rings of neighbours around the cells that were not valid.
    rings: usize,
    /// Newton steps.
    newton_steps: usize,
    /// Iterations of the linear systems, all steps together.
    solver_iterations: usize,
    /// Smallest Jacobian of a simplex, relative to its target shape, before.
    min_jacobian_before: f64,
    /// Smallest Jacobian after it.
    min_jacobian: f64,
    /// Largest displacement of a node, mesh units.
    largest_move: f64,
}

/// A cell.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Left {
    /// The cell, from 0.
    cell: usize,
    /// The reason.
    #[cfg_attr(test, schemars(extend("enum" = ["fixed", "boundary", "not_found", "surface", "curved", "rounded"])))]
    reason: &'static str,
}

/// A face, an edge in 2D.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Face {
    /// Its cell, from 0.
    cell: usize,
    /// Its nodes, from 0.
    nodes: Vec<u32>,
}

impl Patch {
    fn of(log: &PatchLog) -> Self {
        Self {
            first_cell: log.first_cell,
            invalid_before: log.invalid_before,
            invalid: log.invalid,
            cells: log.n_cells,
            nodes: log.n_nodes,
            rings: log.rings,
            newton_steps: log.steps,
            solver_iterations: log.iterations,
            min_jacobian_before: log.least_before,
            min_jacobian: log.least,
            largest_move: log.largest_move,
        }
    }
}

/// Returns a sentence on a face that proves that there is no valid mesh.
fn in_the_way(face: &CrossedFace) -> Note {
    let nodes: Vec<String> = face.nodes.iter().map(u32::to_string).collect();
    let note = note!(
        "overtaken",
        "the face of cell {} on nodes {} has the outside of the mesh on its inner side, and its nodes are fixed",
        face.cell,
        nodes.join(", ")
    );
    note.with("cell", face.cell)
}

fn sentence(log: &PatchLog) -> String {
    format!(
        "patch at cell {}: {} of {} before, {} after; {} rings, {} nodes, {} Newton steps, {} solver iterations; \
         Jacobian relative to the reference from {} to {}; largest move {}",
        log.first_cell,
        counted(log.invalid_before, "invalid cell"),
        log.n_cells,
        log.invalid,
        log.rings,
        log.n_nodes,
        log.steps,
        log.iterations,
        short(log.least_before),
        short(log.least),
        short(log.largest_move),
    )
}

/// Returns a note on cells that are left, and the reason.
fn left_over(cells: &[&Unrepaired], reason: Reason) -> Note {
    let named = cells
        .iter()
        .take(MOST_NAMED)
        .map(|left| left.cell.to_string());
    let more = match cells.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let named = named.collect::<Vec<_>>().join(", ");
    let n = counted(cells.len(), "invalid cell");
    let note = note!(
        "not_repaired",
        "{n} left ({named}{more}): {}",
        reason.sentence()
    );
    note.with("cells", cells.len())
        .with("reason", reason.name())
}
