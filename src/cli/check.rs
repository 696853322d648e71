//! `azimesh check`: a dry run that reports what `deform` would do.

use super::{Context, Outcome, memory};
use crate::preflight::{
    self, BodyAtStep, LargestDisplacements, bodies_at, check_surface_files, estimate_bytes,
    estimate_memory, evenly, motion_in_words,
};
use crate::record::sentences;
use azimesh_core::error::{Result, counted, one_line};
use azimesh_core::numbers::{amount, in_digits, short};
use azimesh_core::parallel;
use azimesh_deform::Plan;
use azimesh_deform::motion::{Role, Schedule, Step, TagRole, TurningRotor};
use serde::Serialize;
use std::fmt::{Display, Write};
use std::path::PathBuf;

/// Columns of the angles of a body.
const ANGLES: [&str; 4] = ["pitch_deg", "flap_deg", "lag_deg", "angle_deg"];
/// Largest number of steps listed; of more, an even selection.
const LISTED: usize = 12;

/// Arguments of `azimesh check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Mesh with boundary tags
    #[arg(required_unless_present = "schema")]
    mesh: Option<PathBuf>,
    /// Motion schedule (TOML)
    #[arg(required_unless_present = "schema")]
    schedule: Option<PathBuf>,
    /// Print the JSON schema of schedules, by which editors complete and check them
    #[arg(long, conflicts_with_all = ["mesh", "schedule"])]
    schema: bool,
}

pub(super) fn run(args: &CheckArgs, context: &Context) -> Result<Outcome> {
    let (Some(mesh_file), Some(schedule)) = (&args.mesh, &args.schedule) else {
        context.print_result(&format!("{:#}\n", Schedule::schema()))?;
        return Ok(Outcome::Fine);
    };
    let schedule = context.read_schedule(schedule)?;
    let (plan, mesh) = context.plan(mesh_file, schedule)?;
    check_surface_files(&plan, &mesh.view(), mesh_file)?;
    let n_bytes = estimate_bytes(&plan, &mesh.view())?;
    let extremes = LargestDisplacements::new(&plan);
    extremes.refuse_turning_out(&plan)?;
    for warning in preflight::warnings(&plan, &extremes) {
        context.warn(warning);
    }
    let bytes = Bytes {
        memory: estimate_memory(&plan, &mesh),
        mapped: memory::mapped_bytes(mesh_file),
        output: n_bytes,
    };
    if context.common.json {
        context.print_json(&as_json(&plan, &extremes, bytes))?
    } else {
        context.print_result(&as_text(&plan, &extremes, bytes))?
    }
    Ok(Outcome::Fine)
}

/// The meaning of a schedule on a mesh.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Checked {
    /// Nodes of the mesh, with those that a turning zone duplicates.
    nodes: usize,
    /// Surface nodes that are base point candidates; nodes at one place count once.
    surface_points: usize,
    /// Surface nodes at the position of another one.
    coincident_surface_nodes: usize,
    /// Boundary tags with a role.
    tags: Vec<CheckedTag>,
    /// Kernel of the interpolation.
    kernel: &'static str,
    /// Support radius, mesh units.
    support_radius: f64,
    /// Displacement error allowed, mesh units.
    tolerance: f64,
    /// Choices that the schedule left open, as sentences.
    chosen: Vec<String>,
    /// Scaled Jacobian below which cells are improved; null without `improve`.
    improve: Option<f64>,
    /// Modes of the motion.
    modes: usize,
    /// Largest error of the modes, mesh units.
    mode_truncation: f64,
    /// Smallest first-cell height at a moving wall, mesh units; null where there is none.
    smallest_first_cell: Option<f64>,
    /// Memory that `deform` needs at its peak, bytes.
    memory_bytes: u64,
    /// Bytes of the input that are mapped in addition.
    mapped_bytes: u64,
    /// Frame, axes and signs, as sentences; for several rotors one each.
    conventions: Vec<String>,
    /// Estimated time of the run, s.
    seconds: f64,
    /// Bytes of all meshes; an upper bound with compression.
    output_bytes: u64,
    /// Largest displacement of a surface node at any step, mesh units.
    max_displacement: f64,
    /// The step of it.
    max_displacement_step: usize,
    /// Every body at its extreme steps, as sentences.
    motion: Vec<CheckedMotion>,
    /// Every step.
    steps: Vec<CheckedStep>,
}

/// The motion of a body in words.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CheckedMotion {
    /// Its name.
    body: String,
    /// Angles and translations at the steps where they are smallest and largest, with their directions.
    sentences: Vec<String>,
}

/// A tag.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CheckedTag {
    /// Its name.
    name: String,
    /// Its role in words.
    role: String,
}

/// A step.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CheckedStep {
    /// Its number, from 0.
    step: usize,
    /// Azimuth, degrees; null where the schedule has times only.
    azimuth_deg: Option<f64>,
    /// Time, s; null without `[time]` or `rpm`.
    time_s: Option<f64>,
    /// Largest displacement of a surface node, mesh units.
    max_displacement: f64,
    /// Every body.
    bodies: Vec<CheckedBody>,
}

/// A body.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CheckedBody {
    /// Its name.
    name: String,
    /// Pitch; null without a cyclic motion.
    pitch_deg: Option<f64>,
    /// Flap; likewise.
    flap_deg: Option<f64>,
    /// Lag; likewise.
    lag_deg: Option<f64>,
    /// Angle of `rigid.rotate`; null without it.
    angle_deg: Option<f64>,
    /// Displacement of its outermost point along the span; null in 2D, and where neither `rotor.span_axis` nor a cyclic or
    /// beam motion says what the span is.
    tip_displacement: Option<[f64; 3]>,
    /// Largest displacement of one of its points (4096 at most).
    max_displacement: f64,
}

/// Bytes that a run takes.
#[derive(Clone, Copy)]
struct Bytes {
    memory: u64,
    /// Of the mapped input.
    mapped: u64,
    output: u64,
}

fn role_name(plan: &Plan, tag: &TagRole) -> String {
    match tag.role {
        Some(Role::Moving(body)) => {
            format!("moves with {}", plan.motion.bodies[usize::from(body)].name)
        }
        Some(Role::Fixed) => "fixed".into(),
        Some(Role::Sliding) => "slides".into(),
        None if tag.periodic => "periodic".into(),
        None if is_outside(plan, tag) => "outside the zones that deform".into(),
        None => "free".into(),
    }
}

/// Returns whether a tag has no face in the deforming zones.
fn is_outside(plan: &Plan, tag: &TagRole) -> bool {
    let Some(zone) = &plan.motion.zone else {
        return false;
    };
    let mut own = plan
        .boundary
        .boundary_tags()
        .filter(|own| own.name == tag.tag);
    let is_inside = |cell: usize| {
        let nodes = plan.boundary.face(cell).nodes;
        nodes.iter().all(|&node| zone.sides.nodes.has(node))
    };
    !own.any(|own| own.cells.iter().any(is_inside))
}

/// Estimates the seconds of a run on this machine's threads: a thousand base points, a billion kernel evaluations per
/// second and thread, a gigabyte per second to disk. Order of magnitude only.
fn seconds(plan: &Plan, n_bytes: u64) -> f64 {
    let threads = parallel::n_threads() as f64;
    let evaluations = 1e3 * (plan.boundary.n_nodes + 10 * plan.surface.nodes.len()) as f64;
    evaluations / (1e9 * threads) + n_bytes as f64 / 1e9
}

fn as_json(plan: &Plan, extremes: &LargestDisplacements, bytes: Bytes) -> Checked {
    let tags = plan.motion.surface.tags.iter();
    let steps = plan.motion.steps.iter();
    let tag = |tag: &TagRole| CheckedTag {
        name: tag.tag.clone(),
        role: role_name(plan, tag),
    };
    let step = |step: &Step| CheckedStep {
        step: step.index(),
        azimuth_deg: step.azimuth_deg(),
        time_s: step.time_s(),
        max_displacement: plan.largest_displacement(step.index()),
        bodies: bodies_at(plan, &[step])
            .iter()
            .map(|body| checked_body(plan, body))
            .collect(),
    };
    let (max_displacement_step, max_displacement) = extremes.largest();
    Checked {
        nodes: plan.boundary.n_nodes,
        surface_points: plan.surface.nodes.len(),
        coincident_surface_nodes: plan.surface.n_coincident,
        tags: tags.map(tag).collect(),
        kernel: plan.basis.kernel.name(),
        support_radius: plan.basis.radius,
        tolerance: plan.tolerance,
        chosen: sentences(&plan.choices),
        improve: plan.schedule.output.improve,
        modes: plan.n_modes(),
        mode_truncation: plan.truncation(),
        smallest_first_cell: plan.smallest_first_cell,
        memory_bytes: bytes.memory,
        mapped_bytes: bytes.mapped,
        conventions: conventions(plan),
        seconds: seconds(plan, bytes.output),
        output_bytes: bytes.output,
        max_displacement,
        max_displacement_step,
        motion: motion_in_words(plan)
            .into_iter()
            .zip(&plan.motion.bodies)
            .map(|(sentences, body)| CheckedMotion {
                body: body.name.clone(),
                sentences,
            })
            .collect(),
        steps: steps.map(step).collect(),
    }
}

fn as_text(plan: &Plan, extremes: &LargestDisplacements, bytes: Bytes) -> String {
    let mut lines = Lines(String::new());
    lines.surface(plan);
    lines.interpolation(plan);
    lines.push("steps", plan.motion.steps.len());
    lines.push(
        "memory",
        format!(
            "about {}, and the mapped input, {}",
            amount(bytes.memory),
            amount(bytes.mapped)
        ),
    );
    lines.push("meshes", format!("about {}", amount(bytes.output)));
    let time = match seconds(plan, bytes.output) {
        seconds if seconds < 1.0 => "about a second or less".to_owned(),
        seconds => format!("about {} s", in_digits(seconds, 1)),
    };
    lines.push("time", time);
    if has_rotor(plan) {
        let name = match plan.motion.rotors.len() {
            1 => "convention",
            _ => "rotor",
        };
        for convention in conventions(plan) {
            lines.push(name, convention);
        }
    }
    let steps = listed(plan);
    lines.displacements(plan, extremes, &steps);
    lines.0 + &bodies_as_text(plan, &steps)
}

/// Returns frame, axes and senses of angles; for several rotors one sentence each, with the azimuths.
fn conventions(plan: &Plan) -> Vec<String> {
    let of_rotor = |rotor: &TurningRotor| {
        let azimuth = |step: &Step| rotor.step(step).azimuth_deg();
        let steps = &plan.motion.steps;
        let [first, last] = [steps.first(), steps.last()].map(|step| step.and_then(azimuth));
        let azimuths = first.zip(last).map(|(first, last)| {
            format!("azimuth from {} to {} degrees", short(first), short(last))
        });
        let sentences: Vec<String> = rotor
            .axes
            .conventions()
            .into_iter()
            .chain(azimuths)
            .collect();
        let name = rotor.name.as_deref().unwrap_or_default();
        format!("{name}: {}", sentences.join("; "))
    };
    match &plan.motion.rotors[..] {
        [only] => only.axes.conventions(),
        several => several.iter().map(of_rotor).collect(),
    }
}

/// Returns whether hub, axes and senses of angles are relevant for the motion.
fn has_rotor(plan: &Plan) -> bool {
    let motion = &plan.motion;
    let mut bodies = 0..motion.bodies.len();
    let is_told = |rotor: &TurningRotor| rotor.axes.has_span || rotor.is_inertial();
    let told = motion.rotors.len() > 1 || motion.rotors.iter().any(is_told);
    told || bodies.any(|body| motion.is_of_blade(body))
}

/// Lines of a name and a value.
struct Lines(String);

impl Lines {
    fn push(&mut self, name: &str, value: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name:<21} {}", one_line(&value.to_string()));
    }

    fn surface(&mut self, plan: &Plan) {
        self.push("nodes", plan.boundary.n_nodes);
        let n = plan.surface.nodes.len();
        let all = n + plan.surface.n_coincident;
        self.push(
            "surface nodes",
            format!("{all} at {}", counted(n, "position")),
        );
        for tag in &plan.motion.surface.tags {
            self.push("tag", format!("{}: {}", tag.tag, role_name(plan, tag)));
        }
    }

    fn interpolation(&mut self, plan: &Plan) {
        let (kernel, radius) = (plan.basis.kernel.name(), plan.basis.radius);
        self.push(
            "kernel",
            format!("{kernel}, support radius {}", short(radius)),
        );
        self.push("tolerance", short(plan.tolerance));
        for choice in &plan.choices {
            self.push("", choice);
        }
        let (n, off) = (plan.n_modes(), plan.truncation());
        self.push("modes", format!("{n}, error at most {}", in_digits(off, 2)));
        if let Some(height) = plan.smallest_first_cell {
            self.push("smallest first cell", in_digits(height, 4));
        }
        if let Some(wanted) = plan.schedule.output.improve {
            let cells = format!(
                "cells with a scaled Jacobian below {}, and neighbours",
                short(wanted)
            );
            self.push("improved", cells);
        }
    }

    fn displacements(&mut self, plan: &Plan, extremes: &LargestDisplacements, steps: &[&Step]) {
        let n_steps = plan.motion.steps.len();
        let (step, largest) = extremes.largest();
        let of = if extremes.n_steps == n_steps {
            "all steps".to_owned()
        } else {
            format!("{} steps checked", extremes.n_steps)
        };
        self.push(
            "largest displacement",
            format!("{} at step {step}, the largest of {of}", short(largest)),
        );
        let at_some = if steps.len() < n_steps {
            format!(
                ", at {} of {n_steps} steps; --json has them all",
                steps.len()
            )
        } else {
            String::new()
        };
        self.push(place_name(plan), format!("largest displacement{at_some}"));
        for step in steps {
            let here = fixed(plan.largest_displacement(step.index()), decimals(largest));
            self.push(&format!("{:>11}", place_of(step)), here);
        }
    }
}

/// Returns the steps to list: all, or an even selection of many.
fn listed(plan: &Plan) -> Vec<&Step> {
    evenly(plan, LISTED)
}

fn checked_body(plan: &Plan, at: &BodyAtStep) -> CheckedBody {
    let [pitch_deg, flap_deg, lag_deg, angle_deg] = angles_deg(at);
    CheckedBody {
        name: plan.motion.bodies[at.body].name.clone(),
        pitch_deg,
        flap_deg,
        lag_deg,
        angle_deg,
        tip_displacement: at.tip,
        max_displacement: at.largest,
    }
}

fn angles_deg(at: &BodyAtStep) -> [Option<f64>; 4] {
    at.angles.map(|angle| angle.map(f64::to_degrees))
}

/// Formats a table for each body: its angles and its tip if it has them, and its largest displacement.
fn bodies_as_text(plan: &Plan, steps: &[&Step]) -> String {
    let mut text = String::new();
    let found = bodies_at(plan, steps);
    let decimals = decimals(found.iter().map(|at| at.largest).fold(0.0, f64::max));
    let words = motion_in_words(plan);
    for (index, body) in plan.motion.bodies.iter().enumerate() {
        let own: Vec<&BodyAtStep> = found.iter().filter(|at| at.body == index).collect();
        let has_angle = |i: &usize| own.iter().any(|at| at.angles[*i].is_some());
        let shown: Vec<usize> = (0..ANGLES.len()).filter(has_angle).collect();
        let has_tip = own.iter().any(|at| at.tip.is_some());
        let angles: String = shown
            .iter()
            .map(|&i| format!(" {:>9}", ANGLES[i]))
            .collect();
        let tip = has_tip.then_some("      tip_dx      tip_dy      tip_dz");
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "body {}\n{:>11}{}{} {:>11}",
            one_line(&body.name),
            place_name(plan),
            angles,
            tip.unwrap_or_default(),
            "largest"
        );
        for at in own {
            let angles = angles_deg(at);
            let angles = shown.iter().filter_map(|&i| angles[i]);
            let angles = cells(angles, 9, |x| fixed(x, 3));
            let tip = cells(at.tip.into_iter().flatten(), 11, |x| fixed(x, decimals));
            let place = place_of(&plan.motion.steps[at.step]);
            let largest = fixed(at.largest, decimals);
            let _ = writeln!(text, "{place:>11}{angles}{tip} {largest:>11}");
        }
        for sentence in &words[index] {
            let _ = writeln!(text, "  {}", one_line(sentence));
        }
    }
    text
}

/// Returns the keys of listed steps: azimuth and time, if they have them.
fn place_name(plan: &Plan) -> &'static str {
    let first = &plan.motion.steps[0];
    match (first.azimuth_deg(), first.time_s()) {
        (None, None) => "step",
        (None, Some(_)) => "time_s",
        (Some(_), None) => "azimuth_deg",
        (Some(_), Some(_)) => "azimuth_deg      time_s",
    }
}

fn place_of(step: &Step) -> String {
    match (step.azimuth_deg(), step.time_s()) {
        (Some(azimuth), Some(time)) => format!("{:>11} {:>11}", short(azimuth), short(time)),
        _ => short(step.azimuth_deg().unwrap_or_else(|| step.time())),
    }
}

/// Returns the decimals for six digits of the numbers in a column; `largest` is the largest of them.
fn decimals(largest: f64) -> usize {
    let before = largest.log10().floor();
    if largest > 0.0 {
        (5.0 - before).clamp(0.0, 12.0) as usize
    } else {
        0
    }
}

/// Formats a number for a column; a number that rounds to zero has no sign.
fn fixed(x: f64, decimals: usize) -> String {
    let least = 0.5 * 0.1_f64.powi(decimals as i32);
    format!("{:.decimals$}", if x.abs() < least { 0.0 } else { x })
}

/// Formats numbers, each after a blank.
fn cells(numbers: impl Iterator<Item = f64>, width: usize, text: impl Fn(f64) -> String) -> String {
    numbers.map(|x| format!(" {:>width$}", text(x))).collect()
}
