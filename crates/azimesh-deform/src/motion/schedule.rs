//! The schedule: from a TOML file or built in memory, with one set of checks.

use super::body::Body;
use super::boundaries::Boundaries;
use super::keys::{Keys, Kind, choice, count, keys, names, table};
use super::motions::{Displacements, TableSource};
use super::options::{Interpolate, RbfOptions, SelectionOptions};
use super::output::{OnInverted, OutputOptions};
use super::places::Places;
use super::reader::{AngleUnit, Lines, Section};
use super::rotor::{Frame, Rotor};
use super::steps::{Azimuths, Step, Steps, Times};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::read_input;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// A motion schedule: the motions of bodies at steps, and options of the mesh deformation. It comes from a file or is
/// built in memory; both get the same checks when it is [resolved](Self::resolve) on a mesh.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Cyclic, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 10.0))
///     .body(Body::new("airfoil", ["airfoil"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0)))
///     .fixed(["farfield"]);
/// assert_eq!(schedule.steps()?.len(), 37);
/// # Ok::<(), azimesh::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Schedule {
    /// The file it came from, empty without one; files it names are relative to it.
    #[doc(hidden)]
    pub path: PathBuf,
    /// The text that was read, empty without a file.
    #[doc(hidden)]
    pub text: String,
    pub(super) steps: Steps,
    pub(crate) rotor: Rotor,
    /// The moving bodies, at least one.
    pub(super) bodies: Vec<Body>,
    /// Zones that deform, and boundaries that do not move with a body.
    pub(super) boundaries: Boundaries,
    /// The interpolation.
    #[doc(hidden)]
    pub rbf: RbfOptions,
    /// The base points.
    #[doc(hidden)]
    pub selection: SelectionOptions,
    /// The output.
    #[doc(hidden)]
    pub output: OutputOptions,
    pub(super) places: Places,
}

impl Schedule {
    /// Reads a schedule file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_input(path).map_err(|error| Error::io(path, &error))?;
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()]
                .iter()
                .filter(|b| **b == b'\n')
                .count();
            let message = "the schedule is not UTF-8 text here; save it as UTF-8";
            Error::input(message).line(line as u64).file(path)
        })?;
        Self::parse(text, path)
    }

    /// Reads a schedule from its text; `path` is named in errors.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        Self::parse_with(text, path, &|_, body| body)
    }

    /// Reads a schedule from its text. `complete` adds to each body, given with its name, what text cannot hold; the
    /// schedule is checked after it.
    pub fn parse_with(
        text: &str,
        path: &Path,
        complete: &dyn Fn(&str, Body) -> Body,
    ) -> Result<Self> {
        let lines = Lines::of(text);
        let document = DeTable::parse(text).map_err(|error| not_toml(&lines, &error).file(path))?;
        let root = Section::root(&lines, document.get_ref(), Self::TITLE);
        Self::from_document(&lines, &root, complete)
            .map(|schedule| Self {
                path: path.to_path_buf(),
                text: text.to_owned(),
                ..schedule
            })
            .map_err(|error| error.file(path))
    }

    fn from_document(
        lines: &Lines,
        root: &Section<'_>,
        complete: &dyn Fn(&str, Body) -> Body,
    ) -> Result<Self> {
        root.check_keys(&Self::known())?;
        if let Some(version) = root.get("version") {
            let found = version.count()?;
            if found != 1 {
                return Err(version.error(&format!("is {found}; this program reads version 1")));
            }
        }
        let unit = root.optional("angle_unit", choice().read)?;
        lines.unit.set(unit.unwrap_or_default());
        let mut schedule = Self::new(Steps::read(root)?);
        schedule.places = root.places();
        schedule.set(root)?;
        let bodies = schedule.bodies.into_iter();
        let completed = bodies.map(|body| complete(&body.name.clone(), body));
        schedule.bodies = completed.collect();
        schedule.check()?;
        Ok(schedule)
    }

    /// Returns the JSON schema of a schedule, for completion and checks in editors.
    pub fn schema() -> Value {
        let mut schema = <Self as Keys>::schema();
        schema["$schema"] = "http://json-schema.org/draft-07/schema#".into();
        schema["title"] = "Motion schedule of azimesh".into();
        schema["required"] = json!(["body"]);
        schema
    }

    /// Returns the steps, at least one.
    ///
    /// # Errors
    /// If there are none or more than a million, if a number is not finite, or if the table of the azimuth is wrong.
    pub fn steps(&self) -> Result<Vec<Step>> {
        let folder = self.path.with_file_name("");
        let azimuth = self.rotor.azimuth_history(&folder, &self.places)?;
        self.steps
            .steps(&self.rotor, &self.places, azimuth.as_ref())
    }

    /// Returns a note if the last step is not at the stop of the schedule.
    pub(crate) fn note(&self) -> Option<Note> {
        self.steps.short_of_stop()
    }

    /// Refuses values out of range and options that cannot be combined.
    pub(super) fn check(&self) -> Result<()> {
        let places = &self.places;
        self.rotor.check(places)?;
        let steps = self.steps.steps(&self.rotor, &self.places, None)?;
        if self.bodies.is_empty() {
            return Err(Error::input(
                "the schedule has no [[body]], so nothing would move; add one with name, tags and a motion",
            ));
        }
        for (at, body) in self.bodies.iter().enumerate() {
            body.check(&self.bodies[..at])?;
        }
        self.rbf.check(places)?;
        self.selection.check(places)?;
        self.output.check(places)?;
        self.check_azimuth()?;
        self.check_velocity(&steps)
    }

    /// Refuses times without a frequency if something depends on the azimuth.
    fn check_azimuth(&self) -> Result<()> {
        let turning = self.bodies.iter().find(|body| body.has_harmonics());
        let what = match turning {
            _ if !self.steps.has_no_azimuth(&self.rotor) => return Ok(()),
            Some(body) => format!("the harmonics of body \"{}\" need", body.name),
            None if self.selection.refresh.is_some() => "`refresh` in [selection] needs".to_owned(),
            None if self.rotor.frame == Frame::Inertial => "frame = \"inertial\" needs".to_owned(),
            None => return Ok(()),
        };
        let section = self.steps.section();
        let message = if section == "steps" {
            format!(
                "`steps` has no azimuth, and {what} it; give the steps as [azimuth], or as [time] with a `frequency`"
            )
        } else {
            format!(
                "`time` has no `frequency`, and {what} the azimuth; add for example  frequency = 2.0, or `azimuth_table` in [rotor]"
            )
        };
        Err(self.places.error(section, message))
    }

    /// Refuses velocities if steps have no time, or if the interpolation is not linear in the motion.
    fn check_velocity(&self, steps: &[Step]) -> Result<()> {
        let message = match (steps[0].time_s, self.rbf.interpolate) {
            _ if !self.output.velocity => return Ok(()),
            (None, _) => {
                "`velocity` = true needs the time of every step; give the schedule [time], or `rpm` in [rotor]"
            }
            (_, Interpolate::Twist) => {
                "`velocity` = true cannot be used with interpolate = \"twist\"; use \"displacement\""
            }
            _ if self.rbf.substeps > 1 => {
                "`velocity` = true cannot be used with substeps; leave them out"
            }
            _ if self.output.on_inverted == OnInverted::Substeps => {
                "`velocity` = true cannot be used with `on_inverted` = \"substeps\"; use \"repair\", \"warn\" or \"stop\""
            }
            _ => return Ok(()),
        };
        Err(self.places.error("output", message))
    }

    /// Returns the files that the rotor and the motions name, without duplicates, in their order.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        let azimuth = self.rotor.azimuth_table.iter();
        let motions = self.bodies.iter().flat_map(|body| &body.motions);
        let sources = azimuth.chain(motions.flat_map(|motion| motion.files()));
        for file in sources.filter_map(TableSource::file) {
            let path = self.path.with_file_name("").join(file);
            if !files.contains(&path) {
                files.push(path);
            }
        }
        files
    }

    /// Returns the bodies that a function moves, with the name of the function if it has one.
    pub fn functions(&self) -> Vec<(&str, Option<&str>)> {
        let bodies = self.bodies.iter();
        let functions = bodies.filter_map(|body| Some((body, body.motion::<Displacements>()?)));
        functions
            .map(|(body, function)| (body.name.as_str(), function.name.as_deref()))
            .collect()
    }
}

fn not_toml(lines: &Lines, error: &toml::de::Error) -> Error {
    let message = error.message().trim().replace('\n', ", ");
    let place = error.span().map_or(0, |span| span.start);
    Error::input(format!("this is not TOML: {message}")).line(lines.at(place))
}

names! {
    AngleUnit { "deg" => Degrees, "rad" => Radians }
}

const VERSION: Kind<usize> = Kind {
    schema: || json!({ "type": "integer", "enum": [1] }),
    ..count("integer")
};

const BODIES: Kind<Vec<Body>> = Kind {
    words: "tables, below",
    read: |entry| {
        let elements = entry.elements("tables; write [[body]], one for each moving body")?;
        elements.iter().map(Body::read).collect()
    },
    schema: || json!({ "type": "array", "items": Body::schema(), "minItems": 1 }),
};

keys! { impl Schedule "the schedule" = Self::new(Steps::azimuths_deg([])), {
    /// version of the schedule; 1 is the only one
    version, VERSION, default 1;
    /// unit of **every** angle in the file, azimuths included
    angle_unit, choice::<AngleUnit>(), default "deg";
    /// the steps, as azimuths
    azimuth, table::<Azimuths>(), or "this, `time` or `steps`";
    /// the steps, as times
    time, table::<Times>(), or "this, `azimuth` or `steps`";
    /// the steps 0 to this one, without azimuths and times
    steps, count("integer"), or "this, `azimuth` or `time`";
    /// hub, axes, frame and signs
    rotor => rotor, table::<Rotor>(), or "none";
    /// what moves
    body => bodies, BODIES, or "required";
    /// what does not move, and which zones deform
    boundaries => boundaries, table::<Boundaries>(), or "none";
    /// the interpolation
    rbf => rbf, table::<RbfOptions>(), or "none";
    /// base points
    selection => selection, table::<SelectionOptions>(), or "none";
    /// what is written
    output => output, table::<OutputOptions>(), or "none";
} }
