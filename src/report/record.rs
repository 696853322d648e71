//! run.json as far as the page shows it. What a run of another version does not say is left empty.

use crate::error::{Error, Result};
use crate::formats::check_file;
use crate::geometry::Transform;
use crate::geometry::vector::Vector;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::path::Path;

/// A run.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Record {
    /// Program and version.
    pub program: String,
    /// `running`, `complete`, or the message of the error.
    pub outcome: String,
    /// The mesh, the schedule, and the files that it names.
    pub inputs: Vec<Input>,
    /// Options by name.
    pub options: Map<String, Value>,
    /// Sentences about what the schedule left open.
    pub chosen: Vec<String>,
    /// 3, or 2 for a mesh in a plane.
    pub dimension: Option<u64>,
    /// Nodes of the mesh.
    pub nodes: Option<u64>,
    /// Its cells, boundary faces included.
    pub cells: Option<u64>,
    /// Surface points.
    pub surface_points: Option<u64>,
    /// Steps of the schedule.
    pub steps: Option<usize>,
    /// Modes of the motion.
    pub modes: Option<u64>,
    /// One for each time base points were chosen.
    pub selections: Vec<Selection>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Conditions that failed.
    pub failures: Vec<String>,
    /// Steps that were passed over, with the reasons.
    pub passed_over: Vec<String>,
    /// Seconds of each stage.
    pub seconds: Map<String, Value>,
    /// What moves, and how.
    pub motion: Option<Motion>,
}

/// An input file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Input {
    /// Its path as it was given.
    pub file: String,
    /// Its hash; none for standard input.
    pub blake3: Option<String>,
}

/// One choice of base points.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Selection {
    /// The first step that it serves.
    pub first_step: usize,
    /// One, or with `twist` the rotations and the translations.
    pub layers: Vec<Layer>,
}

/// Base points of a layer.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Layer {
    /// Key of the base points in base.toml.
    pub of: String,
    /// How many there are.
    pub base_points: usize,
    /// Error that was asked for.
    pub tolerance: Option<f64>,
    /// Base points and largest error at each sweep over all surface nodes.
    pub history: Vec<(usize, Option<f64>)>,
    /// Error of each base point when it was chosen.
    pub residuals: Vec<Option<f64>>,
}

/// The motion of the schedule.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Motion {
    /// `rotating` or `inertial`.
    pub frame: String,
    /// Centre of the hub.
    pub hub: Vector,
    /// Axis about which the azimuth turns, right-handed.
    pub turn_axis: Vector,
    /// The bodies, in the order of the schedule.
    pub bodies: Vec<Body>,
}

/// A body over all steps of the schedule.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Boundary tags that move with it.
    pub tags: Vec<String>,
    /// Pitch in degrees.
    pub pitch_deg: Vec<f64>,
    /// Flap in degrees.
    pub flap_deg: Vec<f64>,
    /// Lag in degrees.
    pub lag_deg: Vec<f64>,
    /// Displacement of its outermost point.
    pub tip_displacement: Vec<Vector>,
    /// Largest displacement of one of its points.
    pub max_displacement: Vec<f64>,
}

impl Record {
    /// Reads a run.json.
    pub fn read(path: &Path) -> Result<Self> {
        let text = check_file(path).and_then(|()| std::fs::read_to_string(path));
        let text = text.map_err(|error| Error::io(path, &error))?;
        serde_json::from_str(&text).map_err(|error| {
            let line = error.line() as u64;
            let message = format!(
                "this is not the record of a run: {error}; `azimesh deform --resume` with its mesh and schedule (of parts, \
                 `azimesh finish`) writes it again"
            );
            Error::input(message).line(line).file(path)
        })
    }

    /// How far the run came, in a word or two.
    pub fn state(&self) -> &str {
        match self.outcome.as_str() {
            "" => "not known",
            "running" => "not finished",
            outcome if outcome.starts_with("complete") => outcome,
            _ => "stopped",
        }
    }
}

impl Motion {
    /// The rotation that carries the mesh round at an azimuth.
    pub fn carry(&self, azimuth_deg: f64) -> Transform {
        match self.frame == "inertial" {
            true => Transform::rotation(self.turn_axis, self.hub, azimuth_deg.to_radians()),
            false => Transform::IDENTITY,
        }
    }
}
