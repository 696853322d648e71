//! The schedule: from a TOML file or built in memory, with one set of checks.

use super::body::Body;
use super::boundaries::Boundaries;
use super::keys::{Keys, Kind, choice, count, keys, names, table};
use super::motions::{Displacements, TableSource, paths};
use super::names::list;
use super::options::{Interpolate, RbfOptions, SelectionOptions};
use super::output::{OnInverted, OutputOptions};
use super::places::Places;
use super::reader::{AngleUnit, Lines, Section};
use super::rotor::{Frame, Rotor, RotorInTime};
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
    /// The rotors, at least one.
    pub(super) rotors: Vec<Rotor>,
    /// The moving bodies, at least one unless a rotor turns zones.
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
        schema
    }

    /// Returns the steps, at least one.
    ///
    /// # Errors
    /// If there are none or more than a million, if a number is not finite, or if the table of the azimuth is wrong.
    pub fn steps(&self) -> Result<Vec<Step>> {
        self.steps.steps(&self.rotor_in_time(0)?, &self.places)
    }

    /// Returns a rotor with the table of its azimuth.
    pub(super) fn rotor_in_time(&self, at: usize) -> Result<RotorInTime<'_>> {
        let (rotor, places) = (&self.rotors[at], self.rotor_places(at));
        let folder = self.path.with_file_name("");
        let table = rotor.azimuth_history(&folder, &places)?;
        Ok(RotorInTime {
            rotor,
            places,
            table,
        })
    }

    /// Returns the places of the keys of a rotor.
    pub(super) fn rotor_places(&self, at: usize) -> Places {
        let key = format!("rotor.{at}");
        match (&self.rotors[at].name, self.places.of_given(&key)) {
            (_, true) => self.places.within(&key, String::new()),
            (Some(name), _) if self.rotors.len() > 1 => {
                self.places.within("rotor", format!("rotor \"{name}\""))
            }
            _ => self.places.within("rotor", "rotor".to_owned()),
        }
    }

    /// Returns the rotor that a body names, else the parent's rotor, else the only one.
    pub(super) fn rotor_of(&self, body: &Body) -> Result<usize> {
        let parent = body
            .parent
            .as_ref()
            .and_then(|parent| self.bodies.iter().find(|body| body.name == *parent));
        let inherited = parent.map(|parent| self.rotor_of(parent)).transpose()?;
        let names = || {
            let names = self.rotors.iter().filter_map(|rotor| rotor.name.as_deref());
            match names.clone().next() {
                Some(_) => format!("the schedule has the rotors {}", list(names)),
                None => "no rotor of the schedule has a name".to_owned(),
            }
        };
        let Some(name) = &body.rotor else {
            return match (inherited, self.rotors.len()) {
                (Some(rotor), _) => Ok(rotor),
                (None, 1) => Ok(0),
                (None, _) => {
                    let message = format!("body \"{}\" names no `rotor`; {}", body.name, names());
                    Err(body.places.error("", message))
                }
            };
        };
        let mut rotors = self.rotors.iter();
        let Some(rotor) = rotors.position(|rotor| rotor.name.as_ref() == Some(name)) else {
            let message = format!("`rotor` = \"{name}\" is not a rotor; {}", names());
            return Err(body.places.error("rotor", message));
        };
        if let (Some(other), Some(parent)) = (inherited.filter(|other| *other != rotor), parent) {
            let message = format!(
                "`rotor` = \"{name}\", and body \"{}\" moves with \"{}\" of the rotor \"{}\"; a body has the rotor of its parent",
                body.name,
                parent.name,
                self.rotors[other].name.as_deref().unwrap_or_default()
            );
            return Err(body.places.error("rotor", message));
        }
        Ok(rotor)
    }

    /// Refuses several rotors without unique names.
    fn check_rotors(&self) -> Result<()> {
        for (at, rotor) in self.rotors.iter().enumerate() {
            let places = self.rotor_places(at);
            rotor.check(&places)?;
            let same = |other: &Rotor| other.name.is_some() && other.name == rotor.name;
            match &rotor.name {
                None if self.rotors.len() > 1 => {
                    let message = format!(
                        "rotor {} of {} has no `name`; of several rotors each needs one, which bodies name",
                        at + 1,
                        self.rotors.len()
                    );
                    return Err(places.error("", message));
                }
                Some(name) if self.rotors[..at].iter().any(same) => {
                    let message =
                        format!("there are two rotors \"{name}\"; each needs a name of its own");
                    return Err(places.error("name", message));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns a note if the last step is not at the stop of the schedule.
    pub(crate) fn note(&self) -> Option<Note> {
        self.steps.short_of_stop()
    }

    /// Refuses values out of range and options that cannot be combined.
    pub(super) fn check(&self) -> Result<()> {
        let places = &self.places;
        self.check_rotors()?;
        let rotors = (0..self.rotors.len()).map(|at| RotorInTime {
            rotor: &self.rotors[at],
            places: self.rotor_places(at),
            table: None,
        });
        let rotors: Vec<_> = rotors.collect();
        let steps = self.steps.steps(&rotors[0], places)?;
        for rotor in &rotors[1..] {
            rotor.steps(&steps)?;
        }
        let turns = |rotor: &Rotor| rotor.frame == Frame::Inertial;
        if self.bodies.is_empty() && !self.rotors.iter().any(turns) {
            return Err(Error::input(
                "the schedule has no [[body]], so nothing would move; add one with name, tags and a motion",
            ));
        }
        for (at, body) in self.bodies.iter().enumerate() {
            body.check(&self.bodies[..at])?;
            let rotor = &self.rotors[self.rotor_of(body)?];
            body.check_moves(rotor.frame == Frame::Inertial)?;
        }
        self.rbf.check(places)?;
        self.selection.check(places)?;
        self.output.check(places)?;
        self.check_azimuth()?;
        self.check_velocity(&steps)
    }

    /// Refuses times without a frequency if something depends on the azimuth.
    fn check_azimuth(&self) -> Result<()> {
        let has_none = |rotor: &Rotor| {
            self.steps.has_no_azimuth(rotor) && self.steps.has_no_azimuth(&self.rotors[0])
        };
        let needs = |body: &&Body| {
            let rotor = self.rotor_of(body);
            body.has_harmonics() && rotor.is_ok_and(|rotor| has_none(&self.rotors[rotor]))
        };
        let inertial = |rotor: &Rotor| rotor.frame == Frame::Inertial && has_none(rotor);
        let what = match self.bodies.iter().find(needs) {
            Some(body) => format!("the harmonics of body \"{}\" need", body.name),
            None if self.selection.refresh.is_some() && has_none(&self.rotors[0]) => {
                "`refresh` in [selection] needs".to_owned()
            }
            None if self.rotors.iter().any(inertial) => "frame = \"inertial\" needs".to_owned(),
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
        let azimuth = self.rotors.iter().flat_map(|rotor| &rotor.azimuth_table);
        let motions = self.bodies.iter().flat_map(|body| &body.motions);
        let sources = azimuth.chain(motions.flat_map(|motion| motion.files()));
        let folder = self.path.with_file_name("");
        for path in sources
            .filter_map(TableSource::file)
            .flat_map(|file| paths(&folder, file))
        {
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

const ROTORS: Kind<Vec<Rotor>> = Kind {
    words: "a table, or tables, below",
    read: |entry| {
        if !entry.is_array() {
            return Ok(vec![Rotor::read(entry)?]);
        }
        let elements = entry.elements("tables")?;
        if elements.is_empty() {
            return Err(
                entry.error("is empty; write [[rotor]] for each rotor, or leave the key out")
            );
        }
        elements.iter().map(Rotor::read).collect()
    },
    schema: || {
        let rotors = json!({ "type": "array", "items": Rotor::schema(), "minItems": 1 });
        json!({ "anyOf": [Rotor::schema(), rotors] })
    },
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
    /// hub, axes, frame and signs; [several](#several-rotors) as `[[rotor]]`
    rotor => rotors, ROTORS, or "none";
    /// what moves
    body => bodies, BODIES, or "this, or zones that turn with a rotor";
    /// what does not move, and which zones deform
    boundaries => boundaries, table::<Boundaries>(), or "none";
    /// the interpolation
    rbf => rbf, table::<RbfOptions>(), or "none";
    /// base points
    selection => selection, table::<SelectionOptions>(), or "none";
    /// what is written
    output => output, table::<OutputOptions>(), or "none";
} }
