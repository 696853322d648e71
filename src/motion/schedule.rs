//! The schedule: a TOML file, checked once into types.

use super::body::Body;
use super::boundaries::Boundaries;
use super::options::{Interpolate, RbfOptions, SelectionOptions};
use super::output::{OnInverted, OutputOptions};
use super::reader::{AngleUnit, Entry, Keys, Lines, Section};
use super::resolved::Motion;
use super::rotor::{Frame, Rotor};
use super::steps::{self, Step};
use crate::error::{Error, Result};
use crate::formats::check_no_device;
use crate::mesh::Mesh;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::DeTable;

const SCHEDULE: Keys = Keys {
    known: &[
        "version",
        "angle_unit",
        "azimuth",
        "time",
        "rotor",
        "body",
        "boundaries",
        "rbf",
        "selection",
        "output",
    ],
    later: &[],
};

/// A motion schedule. Angles are in radians, lengths in mesh units.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// The file it came from; files it names are relative to it.
    pub path: PathBuf,
    /// The steps, at least one.
    pub steps: Vec<Step>,
    /// By how much the azimuth grows, in radians a second, where `rpm` or `[time]` says.
    pub azimuth_rate: Option<f64>,
    /// The rotor.
    pub rotor: Rotor,
    /// The moving bodies, at least one.
    pub bodies: Vec<Body>,
    /// Zones that deform, and boundaries that do not move with a body.
    pub boundaries: Boundaries,
    /// The interpolation.
    pub rbf: RbfOptions,
    /// The base points.
    pub selection: SelectionOptions,
    /// What is written.
    pub output: OutputOptions,
    /// A sentence where the last step is not at `stop`.
    pub note: Option<String>,
}

impl Schedule {
    /// Reads a schedule file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = check_no_device(path).and_then(|()| std::fs::read(path));
        let bytes = bytes.map_err(|error| Error::io(path, &error))?;
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()]
                .iter()
                .filter(|b| **b == b'\n')
                .count();
            let message = "the schedule is no UTF-8 text here; save it as UTF-8";
            Error::input(message).line(line as u64).file(path)
        })?;
        Self::parse(text, path)
    }

    /// Reads a schedule from its text; `path` is named in errors.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let lines = Lines::of(text);
        let document = DeTable::parse(text).map_err(|error| not_toml(&lines, &error).file(path))?;
        Section::root(&lines, document.get_ref(), &SCHEDULE)
            .and_then(|root| Self::from_document(&root, path))
            .map_err(|error| error.file(path))
    }

    fn from_document(root: &Section<'_>, path: &Path) -> Result<Self> {
        if let Some(version) = root.get("version") {
            let found = version.count()?;
            if found != 1 {
                return Err(version.error(&format!("is {found}; this program reads version 1")));
            }
        }
        let unit = match root.get("angle_unit") {
            Some(unit) => unit.choice(
                &[("deg", AngleUnit::Degrees), ("rad", AngleUnit::Radians)],
                &[],
            )?,
            None => AngleUnit::Degrees,
        };
        let rotor = section(root, "rotor", Rotor::read)?;
        let (steps, azimuth_rate) = read_steps(root, unit, &rotor)?;
        let bodies = read_bodies(root, unit)?;
        let schedule = Self {
            path: path.to_path_buf(),
            steps,
            azimuth_rate,
            rotor,
            bodies,
            boundaries: section(root, "boundaries", Boundaries::read)?,
            rbf: section(root, "rbf", RbfOptions::read)?,
            selection: section(root, "selection", |entry| {
                SelectionOptions::read(entry, unit)
            })?,
            output: section(root, "output", OutputOptions::read)?,
            note: (root.get("azimuth").or(root.get("time")))
                .and_then(|entry| steps::short_of_stop(&entry)),
        };
        if let (Some(time), None) = (root.get("time"), azimuth_rate) {
            check_needs_no_azimuth(&time, &schedule)?;
        }
        if let Some(output) = root.get("output") {
            schedule.check_velocity(&output)?;
        }
        Ok(schedule)
    }

    /// Refuses velocities where there is no time to differentiate by, and where the interpolation is
    /// not linear in the motion.
    fn check_velocity(&self, output: &Entry<'_>) -> Result<()> {
        let message = match (self.steps[0].time_s, self.rbf.interpolate) {
            _ if !self.output.velocity => return Ok(()),
            (None, _) => {
                "`velocity` = true needs the time of every step; give the schedule [time], or `rpm` in [rotor]"
            }
            (_, Interpolate::Twist) => {
                "`velocity` = true does not go with interpolate = \"twist\"; use \"displacement\""
            }
            _ if self.rbf.substeps > 1 => {
                "`velocity` = true does not go with substeps; leave them out"
            }
            _ if self.output.on_inverted == OnInverted::Substeps => {
                "`velocity` = true does not go with `on_inverted` = \"substeps\"; use \"warn\" or \"stop\""
            }
            _ => return Ok(()),
        };
        Err(Error::input(message).line(output.line()))
    }

    /// The files that the motions name, each once, in their order.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        for file in self.bodies.iter().flat_map(Body::files) {
            let path = self.path.with_file_name("").join(file);
            if !files.contains(&path) {
                files.push(path);
            }
        }
        files
    }

    /// What the schedule means on this mesh: axes, poses, and the role of every surface node.
    pub fn resolve(&self, mesh: &Mesh) -> Result<Motion> {
        Motion::new(self, mesh).map_err(|error| error.file(&self.path))
    }
}

/// A section that may be left out.
fn section<T: Default>(
    root: &Section<'_>,
    key: &str,
    read: impl Fn(&Entry<'_>) -> Result<T>,
) -> Result<T> {
    root.get(key).map_or(Ok(T::default()), |entry| read(&entry))
}

fn not_toml(lines: &Lines, error: &toml::de::Error) -> Error {
    let message = error.message().trim().replace('\n', ", ");
    let place = error.span().map_or(0, |span| span.start);
    Error::input(format!("this is not TOML: {message}")).line(lines.at(place))
}

/// The steps, and by how much the azimuth grows in a second.
fn read_steps(
    root: &Section<'_>,
    unit: AngleUnit,
    rotor: &Rotor,
) -> Result<(Vec<Step>, Option<f64>)> {
    match (root.get("azimuth"), root.get("time")) {
        (Some(azimuth), None) => {
            let rate = rotor.rpm.map(|rpm| (6.0 * rpm).to_radians());
            Ok((steps::from_azimuth(&azimuth, unit, rotor.rpm)?, rate))
        }
        (None, Some(time)) => match rotor.rpm_line {
            None => steps::from_time(&time),
            Some(line) => Err(Error::input(
                "`rpm` and [time] both say when the steps are; keep one of them",
            )
            .line(line)),
        },
        (Some(_), Some(time)) => {
            Err(time.error("and [azimuth] both say which steps there are; keep one of them"))
        }
        (None, None) => Err(Error::input(
            "the schedule has no steps; give it [azimuth] or [time] with start, stop and step, or with values",
        )),
    }
}

/// Refuses times without a frequency where something depends on the azimuth.
fn check_needs_no_azimuth(time: &Entry<'_>, schedule: &Schedule) -> Result<()> {
    let turning = schedule.bodies.iter().find(|body| body.has_harmonics());
    let what = match turning {
        Some(body) => format!("the harmonics of body \"{}\" need", body.name),
        None if schedule.selection.refresh.is_some() => "`refresh` in [selection] needs".to_owned(),
        None if schedule.rotor.frame == Frame::Inertial => "frame = \"inertial\" needs".to_owned(),
        None => return Ok(()),
    };
    let message =
        format!("has no `frequency`, and {what} the azimuth; write for instance  frequency = 2.0");
    Err(time.error(&message))
}

fn read_bodies(root: &Section<'_>, unit: AngleUnit) -> Result<Vec<Body>> {
    let elements = match root.get("body") {
        Some(entry) => entry.elements("tables; write [[body]], one for each moving body")?,
        None => Vec::new(),
    };
    if elements.is_empty() {
        return Err(Error::input(
            "the schedule has no [[body]]: nothing would move; give one with name, tags and a motion",
        ));
    }
    let mut bodies: Vec<Body> = Vec::new();
    let mut names = BTreeMap::new();
    for element in elements {
        let body = Body::read(&element, (&bodies, &names), unit)?;
        names.insert(body.name.clone(), bodies.len());
        bodies.push(body);
    }
    Ok(bodies)
}
