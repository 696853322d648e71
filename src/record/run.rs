//! run.json: inputs of a run, its steps and its result. Keys that another version does not write are empty after reading.

use super::diagnostic::{Diagnostic, Failed, Failure};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::numbers::{in_digits, named_step, point};
use azimesh_core::{Note, note};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// The record of a run; written at its start and completed at its end.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct RunRecord {
    /// Version of this layout.
    pub version: u32,
    /// Program and version.
    pub program: String,
    /// The command line without the program; absent where a program called the library.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arguments: Vec<String>,
    /// `output.title` of the schedule; absent without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// `output.length_unit` of the schedule; absent without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_unit: Option<String>,
    /// `running`, `complete`, `complete but for N steps`, or the message of the error.
    pub outcome: String,
    /// Files that were read.
    pub inputs: Vec<InputRecord>,
    /// Bodies of a schedule made in memory that a function moves; `--resume` and `finish` compare them, and refuse a function
    /// without a name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub functions: Vec<FunctionRecord>,
    /// Options that decide what is written.
    pub options: OptionsRecord,
    /// Choices that the schedule left open, as sentences.
    pub chosen: Vec<String>,
    /// 2 or 3.
    pub dimension: Option<usize>,
    /// Nodes of the mesh.
    pub nodes: Option<usize>,
    /// Cells, boundary faces included.
    pub cells: Option<usize>,
    /// Surface nodes; nodes at one place count once.
    pub surface_points: Option<usize>,
    /// Surface nodes at the position of another one.
    pub coincident_surface_nodes: Option<usize>,
    /// Steps of the schedule.
    pub steps: Option<usize>,
    /// Modes of the motion.
    pub modes: Option<usize>,
    /// Largest error of the modes, mesh units.
    pub mode_truncation: Option<f64>,
    /// The motion in the rotating frame.
    pub motion: Option<MotionRecord>,
    /// Number of times that the run was resumed; absent in a joined sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resumed: Option<u64>,
    /// Steps that were finished before the last time; absent in a joined sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_kept: Option<usize>,
    /// Numbers of steps that the schedule had before steps were added; absent if none were.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extended: Vec<usize>,
    /// Companion files of the meshes with their hashes, by path from the folder; `*.mapbc` is the file of each step; absent if
    /// there are none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub companions: BTreeMap<String, String>,
    /// Files of base points with their hashes.
    pub base_files: BTreeMap<String, String>,
    /// One for each time base points were chosen.
    pub selections: Vec<SelectionRecord>,
    /// Conditions of `--fail-on`.
    pub fail_on: Vec<String>,
    /// Seconds of each stage, all runs of the folder together.
    pub seconds: Option<Timings>,
    /// Parts that were joined, as `A..B`; only after `finish`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<String>>,
    /// Steps with inverted cells that were computed again in substeps or repaired, and with `on_inverted = "repair"` the steps
    /// around them; not with `"warn"` or `"stop"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repairs: Option<Vec<RepairRecord>>,
    /// Byte at which each step ends, if one file holds all steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_ends: Option<Vec<u64>>,
    /// The result of the run; none while it is under way.
    #[serde(flatten)]
    pub end: Option<EndRecord>,
}

/// An input file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct InputRecord {
    /// Its kind.
    #[cfg_attr(test, schemars(extend("enum" = ["mesh", "schedule", "file", "linked file", "base"])))]
    pub what: String,
    /// Path as given.
    pub file: String,
    /// Its hash, of a case the hash of its mesh; absent for a pipe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
    /// Of a schedule, the hash of its keys and values but those that count its steps: runs with the same one may have more
    /// steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub but_steps: Option<String>,
}

/// A body that a function moves.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FunctionRecord {
    /// The body.
    pub body: String,
    /// Name of the function.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// Options that decide what is written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct OptionsRecord {
    /// Kernel of the interpolation.
    pub kernel: Option<String>,
    /// Support radius, mesh units.
    pub support_radius: Option<f64>,
    /// Displacement error allowed, mesh units.
    pub tolerance: Option<f64>,
    /// Base points at most.
    pub max_points: Option<usize>,
    /// True if surfaces are exact.
    pub correction: Option<bool>,
    /// Format of the meshes.
    pub format: Option<String>,
    /// `f64` or `f32`.
    pub precision: Option<String>,
    /// `--tag-array`; null without.
    pub tag_array: Option<String>,
    /// Kind of the surface files, `su2`; only with `output.surface`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<String>,
}

/// The motion of the schedule in the rotating frame, and how the inertial one turns against it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct MotionRecord {
    /// Frame; `several` where each of several rotors turns its own zones.
    #[cfg_attr(test, schemars(extend("enum" = ["rotating", "inertial", "several"])))]
    pub frame: String,
    /// Hub centre, of the first rotor.
    pub hub: Vector,
    /// Axis about which the azimuth turns, right-handed.
    pub turn_axis: Vector,
    /// The bodies, in the order of the schedule.
    pub bodies: Vec<BodyRecord>,
}

/// A body over all steps of the schedule; what it has not is empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct BodyRecord {
    /// Its name.
    pub name: String,
    /// Boundary tags that move with it.
    pub tags: Vec<String>,
    /// Pitch; of a cyclic motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pitch_deg: Vec<f64>,
    /// Flap; likewise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flap_deg: Vec<f64>,
    /// Lag; likewise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lag_deg: Vec<f64>,
    /// Angle of `rigid.rotate`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub angle_deg: Vec<f64>,
    /// Displacement of its outermost point along the span; in 3D, where `rotor.span_axis` or a cyclic or beam motion says what the
    /// span is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tip_displacement: Vec<Vector>,
    /// Largest displacement of one of its points (4096 at most).
    pub max_displacement: Vec<f64>,
}

/// One choice of base points.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SelectionRecord {
    /// First step that it serves.
    pub first_step: usize,
    /// Number of steps that it serves.
    pub steps: usize,
    /// One; with `twist` the rotations, then the translations.
    pub layers: Vec<LayerRecord>,
    /// Warnings of its evaluation; absent until then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnostics: Option<Vec<Diagnostic>>,
}

/// Base points of a layer. An error that is not finite is null.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct LayerRecord {
    /// Key of the base points in base.toml.
    #[cfg_attr(test, schemars(extend("enum" = ["nodes", "rotation_nodes"])))]
    pub of: String,
    /// Number of base points.
    pub base_points: usize,
    /// Error that was asked for; 0.99 of the schedule's.
    pub tolerance: Option<f64>,
    /// Largest error over the steps that the points were chosen for; null where it is not finite.
    pub error: Option<f64>,
    /// The error that is compared with the tolerance.
    pub measured: Option<f64>,
    /// Candidates too close to base points.
    pub skipped: usize,
    /// Base points and largest error at each sweep over all surface nodes.
    #[cfg_attr(test, schemars(with = "Vec<[Option<f64>; 2]>"))]
    pub history: Vec<(usize, Option<f64>)>,
    /// Error of each base point when it was chosen.
    pub residuals: Vec<Option<f64>>,
}

/// The repair of a step with inverted cells.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct RepairRecord {
    /// The step.
    pub step: usize,
    /// Substeps in the end; null where they did not help.
    pub substeps: Option<usize>,
    /// Kernel of the substeps, if the schedule has another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kernel: Option<String>,
    /// Inverted cells without them.
    pub inverted_before: usize,
    /// Inverted cells with them.
    pub inverted: usize,
    /// Unproven cells without them; only where there are some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unproven_before: Option<usize>,
    /// Cells below `improve`; only where there are some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_before: Option<usize>,
    /// Cells below `improve` after all; only where there are some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<usize>,
    /// The steps that were repaired together: the first, and the one after the last; only with `"repair"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[usize; 2]>,
    /// The part of the repair that the step takes: 1 where cells are folded, less before and after; only with `"repair"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Patches whose nodes were moved after the substeps; only with `"repair"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patches: Option<Vec<PatchRecord>>,
    /// Inverted and unproven cells after all; only with `"repair"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unrepaired: Option<usize>,
    /// The repair as a sentence.
    pub sentence: String,
}

/// A patch of a step whose cells were untangled.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct PatchRecord {
    /// The first cell that was not valid, from 0.
    pub first_cell: usize,
    /// Cells that were not valid.
    pub invalid_before: usize,
    /// Cells that are not valid after it.
    pub invalid: usize,
    /// Cells of the patch.
    pub cells: usize,
    /// Nodes that could move.
    pub nodes: usize,
    /// Rings of neighbours around the cells that were not valid.
    pub rings: usize,
    /// Smallest Jacobian of a simplex, relative to its target shape, before.
    pub min_jacobian_before: f64,
    /// Smallest Jacobian after it.
    pub min_jacobian: f64,
    /// Largest displacement of a node, mesh units.
    pub largest_move: f64,
}

/// The result of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct EndRecord {
    /// Finished steps, with steps of earlier runs.
    pub steps_written: usize,
    /// Number of base points; with `real` the largest.
    #[serde(default)]
    pub base_points: Option<usize>,
    /// Largest error before the correction, mesh units.
    #[serde(default)]
    pub selection_error: Option<f64>,
    /// Steps with inverted cells; null where quality was not computed.
    #[serde(default)]
    pub inverted_steps: Option<usize>,
    /// Inverted cells of the worst step; null likewise.
    #[serde(default)]
    pub max_inverted: Option<usize>,
    /// Smallest scaled Jacobian of all steps; null likewise.
    #[serde(default)]
    pub min_scaled_jacobian: Option<f64>,
    /// The step with it, the first of several; absent where quality was not computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_step: Option<WorstStep>,
    /// Largest error as written, mesh units; null without steps.
    #[serde(default)]
    pub max_surface_error: Option<f64>,
    /// Steps that `--keep-going` skipped, with the reasons.
    #[serde(default)]
    pub skipped_steps: Vec<String>,
    /// Warnings.
    #[serde(default)]
    pub diagnostics: Vec<Diagnostic>,
    /// Conditions of `--fail-on` that failed, and other checks.
    #[serde(default)]
    pub failures: Vec<Failure>,
    /// The error that ended the run before its last step; absent without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<Failed>,
}

/// The step with the smallest scaled Jacobian.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WorstStep {
    /// The step.
    pub step: usize,
    /// Its azimuth; null where the schedule has none.
    pub azimuth_deg: Option<f64>,
    /// Its time; null likewise.
    pub time_s: Option<f64>,
    /// The scaled Jacobian.
    pub scaled_jacobian: f64,
    /// The cell; like all that follows null on several ranks, and where the run that wrote the step was killed.
    pub cell: Option<usize>,
    /// Mean of its nodes.
    pub position: Option<Vector>,
    /// The boundary tag nearest to it; null also in a mesh without tags.
    pub nearest_tag: Option<String>,
    /// Its distance.
    pub distance: Option<f64>,
}

impl fmt::Display for WorstStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&named_step(self.step, self.azimuth_deg, self.time_s))?;
        if let (Some(cell), Some(position)) = (self.cell, &self.position) {
            write!(f, ", cell {cell} at {}", point(position))?;
        }
        write!(
            f,
            ": scaled Jacobian {}",
            in_digits(self.scaled_jacobian, 4)
        )?;
        if let (Some(tag), Some(distance)) = (&self.nearest_tag, self.distance) {
            write!(
                f,
                ", nearest tag {tag} at distance {}",
                in_digits(distance, 4)
            )?;
        }
        Ok(())
    }
}

/// Seconds of each stage of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Timings {
    /// Choosing base points, s.
    pub selection: f64,
    /// Evaluating the modes at all nodes, and the correction, s.
    pub modes: f64,
    /// Positions and quality, all steps, s.
    pub steps: f64,
    /// Writing, all steps, s; overlaps with the next step.
    pub writing: f64,
    /// The whole run, s.
    pub total: f64,
}

impl RunRecord {
    /// Reads a record from the bytes of a file.
    ///
    /// # Errors
    /// If they are not a record, with the line.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        serde_json::from_slice(bytes).map_err(|error| {
            let message = "this is not the record of a run; `azimesh deform --resume` with its mesh and schedule (of parts, \
                           `azimesh finish`) writes it again";
            Error::input(message).line(error.line() as u64)
        })
    }

    /// Returns the text of the file.
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("its keys are text, and numbers that are not finite are null") + "\n"
    }

    /// Returns the arguments of a run of all steps, without options for the steps to write, for existing files and for
    /// printing.
    pub fn arguments_of_all_steps(&self) -> Vec<String> {
        let mut own = Vec::new();
        let mut arguments = self.arguments.iter();
        while let Some(argument) = arguments.next() {
            let name = argument.split('=').next().unwrap_or_default();
            let letters = argument.strip_prefix('-').unwrap_or_default();
            let is_printing = !letters.is_empty() && letters.chars().all(|c| "qv".contains(c));
            if ["--steps", "--threads"].contains(&name) {
                if name == argument {
                    arguments.next();
                }
            } else if !is_printing && !LEFT_OUT.contains(&name) {
                own.push(argument.clone());
            }
        }
        own
    }

    /// Returns the command of a run of all steps, to which options may be appended; words in capitals stand for inputs that
    /// the record does not name.
    pub fn command(&self, folder: &Path) -> String {
        if !self.arguments.is_empty() {
            return in_shell_all(&self.arguments_of_all_steps());
        }
        let input = |what: &str| {
            let input = self.inputs.iter().find(|input| input.what == what);
            input.map_or(what.to_uppercase(), |input| in_shell(&input.file))
        };
        let [mesh, schedule] = ["mesh", "schedule"].map(input);
        format!(
            "azimesh deform {mesh} {schedule} -o {}",
            in_shell(&folder.display().to_string())
        )
    }

    /// Checks if the run has ended without an error: all steps are written, except skipped ones.
    pub fn is_finished(&self) -> bool {
        self.end.as_ref().is_some_and(|end| end.error.is_none())
    }

    /// Checks if the run has written all its steps.
    pub fn is_complete(&self) -> bool {
        let is_complete = |end: &EndRecord| end.error.is_none() && end.skipped_steps.is_empty();
        self.end.as_ref().is_some_and(is_complete)
    }

    /// Checks if it has inputs and options, as every run writes them.
    pub fn is_whole(&self) -> bool {
        !self.inputs.is_empty() && self.options.kernel.is_some()
    }
}

/// Options that are not repeated in a command.
const LEFT_OUT: [&str; 5] = ["--force", "--resume", "--quiet", "--verbose", "--json"];

/// A command of the program.
pub fn in_shell_all(arguments: &[String]) -> String {
    let words = arguments.iter().map(|word| in_shell(word));
    let words: Vec<String> = std::iter::once("azimesh".to_owned()).chain(words).collect();
    words.join(" ")
}

/// Quotes a word for a shell if necessary.
pub fn in_shell(word: &str) -> String {
    if word
        .chars()
        .any(|c| c.is_whitespace() || "'\"$&;()*?<>|".contains(c))
    {
        format!("'{}'", word.replace('\'', "'\\''"))
    } else {
        word.to_owned()
    }
}

impl OptionsRecord {
    /// Returns names and values as in the file.
    pub fn entries(&self) -> Map<String, Value> {
        match serde_json::to_value(self) {
            Ok(Value::Object(entries)) => entries,
            _ => unreachable!("a struct with named fields is an object"),
        }
    }
}

impl RepairRecord {
    /// Checks if a cell of the step was inverted or unproven before the repair.
    pub fn was_folded(&self) -> bool {
        self.inverted_before + self.unproven_before.unwrap_or(0) > 0
    }

    /// Returns the note of this repair; azimuth in degrees and time in seconds of the step.
    pub fn note(&self, azimuth_deg: Option<f64>, time_s: Option<f64>) -> Note {
        let step = named_step(self.step, azimuth_deg, time_s);
        note!("repair", "{step} {}", self.told())
            .with("step", self.step)
            .with("inverted_before", self.inverted_before)
            .with("left", self.unrepaired.unwrap_or(self.inverted))
    }

    /// Describes the cells before the repair, and the repair.
    fn told(&self) -> String {
        let before = (self.inverted_before, self.unproven_before.unwrap_or(0));
        if let (Some(low), (0, 0)) = (self.low_before, before) {
            let cells = counted(low, "cell");
            let nodes = self.patches.iter().flatten().map(|patch| patch.nodes);
            let nodes = counted(nodes.sum(), "node");
            let left = match self.low {
                Some(left) => format!(", and {left} are left"),
                None => String::new(),
            };
            return format!("had {cells} below `improve`: {nodes} could move{left}");
        }
        if let (Some(weight), (0, 0)) = (self.weight, before) {
            let percent = (100.0 * weight).round();
            return format!("takes {percent}% of the repair of steps near it");
        }
        let cells = match before {
            (0, n) if n > 0 => counted(n, "unproven cell"),
            (n, _) => counted(n, "inverted cell"),
        };
        let patches = self.patches.as_ref().map_or(0, Vec::len);
        let with = match &self.kernel {
            Some(kernel) => format!(" with the kernel {kernel}"),
            None => String::new(),
        };
        let mut done = Vec::new();
        match (self.substeps, self.inverted) {
            (None, _) if patches > 0 => {}
            (None, _) => done.push("substeps do not reduce them".to_owned()),
            (Some(n), 0) => done.push(format!("{n} substeps{with} leave none")),
            (Some(n), after) => done.push(format!("{n} substeps{with} leave {after}")),
        }
        if patches > 0 {
            let moved = match patches {
                1 => "1 patch moved".to_owned(),
                n => format!("{n} patches moved"),
            };
            done.push(match self.unrepaired.unwrap_or(self.inverted) {
                0 => format!("{moved}, and none is left"),
                left => format!("{moved}, and {left} are left"),
            });
        }
        format!("had {cells}: {}", done.join("; "))
    }
}

impl MotionRecord {
    /// Returns the rotation of the mesh at an azimuth.
    pub fn carry(&self, azimuth_deg: f64) -> Transform {
        if self.frame == "inertial" {
            Transform::rotation(self.turn_axis, self.hub, azimuth_deg.to_radians())
        } else {
            Transform::IDENTITY
        }
    }
}

impl Timings {
    /// Returns the sum of two runs.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            selection: self.selection + other.selection,
            modes: self.modes + other.modes,
            steps: self.steps + other.steps,
            writing: self.writing + other.writing,
            total: self.total + other.total,
        }
    }
}
