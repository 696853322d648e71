//! The rotor: hub and axes, the frame of the mesh, and signs.

use super::keys::{choice, direction, keys, names, numbers, patterns, positive, sign, string};
use super::motions::TableSource;
use super::names::Pattern;
use super::places::Places;
use super::resolved::Motion;
use super::setters::setters;
use super::steps::Step;
use super::table::{Column, History, Interpolation, Key};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, unit};
use azimesh_core::geometry::{Moving, Transform};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Sine of the angle below which span and shaft count as parallel.
const PARALLEL: f64 = 1e-6;

/// Frame in which the mesh is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Frame {
    /// Turning with the rotor: the mesh only pitches, flaps and lags.
    Rotating,
    /// At rest: the mesh is rotated by the azimuth.
    Inertial,
}

/// Factors of 1 or -1 for other conventions; each multiplies only its own angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Signs {
    /// Of the azimuth: -1 turns clockwise seen from the thrust side.
    pub azimuth: f64,
    /// Of the pitch angle.
    pub pitch: f64,
    /// Of the flap angle.
    pub flap: f64,
    /// Of the lag angle.
    pub lag: f64,
}

names! {
    Frame { "rotating" => Rotating, "inertial" => Inertial }
}

keys! {
    /// The rotor: hub, axes, frame, speed and signs of its angles.
    ///
    /// ```
    /// # use azimesh_deform as azimesh;
    /// use azimesh::{Rotor, Schedule, Steps};
    ///
    /// let rotor = Rotor::new().hub([0.0, 0.0, 1.2]).inertial().rpm(395.0).azimuth_sign(-1.0);
    /// let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 5.0)).rotor(rotor);
    /// ```
    #[derive(Debug, Clone)]
    pub struct Rotor "[rotor]" {
        /// unique among the rotors; bodies name it
        pub(super) name: Option<String>, string::<String>(), or "none; needed with several rotors";
        /// hub centre O
        pub(super) hub: Vector, numbers::<3>("3 lengths"), default [0, 0, 0];
        /// direction of the blade at zero azimuth, outward
        pub(super) span_axis: Option<Vector>, direction(), or "`[1, 0, 0]`; in 2D `[0, 0, -1]`";
        /// direction of the shaft, towards the thrust side
        pub(super) shaft_axis: Option<Vector>, direction(), or "`[0, 0, 1]`; in 2D `[0, 1, 0]`";
        /// inertial: the mesh (or its zones) also turns with the azimuth, and nodes between a turning zone and the rest
        /// are duplicated, with a [tag on each side](tasks/rotor.md). That interface must be a surface of revolution
        /// about the shaft; cells that run into others are refused
        pub(crate) frame: Frame, choice::<Frame>(), default "rotating";
        /// zones (globs) that deform and turn with this rotor, with `frame = "inertial"`
        pub(super) zones: Vec<Pattern>, patterns(), or "of an only rotor `zones` of `[boundaries]`, or all";
        /// greater than 0. With `[azimuth]`, `rpm` of the first rotor gives each step its time in s. Otherwise `rpm` gives
        /// the azimuth: 6 `rpm` x time in degrees, not together with `frequency`
        pub(super) rpm: Option<f64>, positive("1/min"), or "none; that of the first rotor";
        /// a table `time_s,azimuth_deg` (or `azimuth_rad`) that gives each step of `[time]` its azimuth, in place of
        /// `frequency`: a rotor that speeds up. It must cover all times
        pub(super) azimuth_table: Option<TableSource>, string::<TableSource>(), or "none";
        /// between its rows; with `"cubic"` the rotor speed has no jumps ([cubic
        /// tables](#bodytable-six-degrees-of-freedom))
        azimuth_interpolation: Interpolation, choice::<Interpolation>(), default "linear", with azimuth_table;
        /// -1 reverses the azimuth
        pub(super) azimuth_sign: f64, sign(), default 1;
        /// -1 reverses the pitch angle only
        pub(super) pitch_sign: f64, sign(), default 1;
        /// -1 reverses the flap angle only
        pub(super) flap_sign: f64, sign(), default 1;
        /// -1 reverses the lag angle only
        pub(super) lag_sign: f64, sign(), default 1;
    }
}

impl Rotor {
    /// A hub at the origin, in 3D the span along x and the shaft along z, in 2D the span along -z and the
    /// shaft along y; the rotating frame.
    pub fn new() -> Self {
        Self::default()
    }

    /// Refuses invalid numbers.
    pub(super) fn check(&self, places: &Places) -> Result<()> {
        if self.frame == Frame::Rotating && !self.zones.is_empty() {
            let message = "`zones` of a rotor turn with it in the inertial frame only; set frame = \"inertial\", or name them under `zones` of [boundaries]";
            return Err(places.error("zones", message));
        }
        places.finite("hub", &self.hub)?;
        let axes = [
            ("span_axis", self.span_axis),
            ("shaft_axis", self.shaft_axis),
        ];
        for (key, axis) in axes {
            axis.map_or(Ok(()), |axis| places.direction(key, axis))?;
        }
        if let Some(rpm) = self.rpm {
            places.positive("rpm", rpm)?;
        }
        for (key, sign) in [
            ("azimuth_sign", self.azimuth_sign),
            ("pitch_sign", self.pitch_sign),
            ("flap_sign", self.flap_sign),
            ("lag_sign", self.lag_sign),
        ] {
            places.check(sign.abs() == 1.0, key, &sign.to_string(), "1 or -1")?;
        }
        Ok(())
    }

    /// Returns whether the time of a step gives its azimuth.
    pub(super) fn turns_in_time(&self) -> bool {
        self.azimuth_table.is_some() || self.rpm.is_some()
    }

    /// Reads the azimuth over time, if a table gives it: `azimuth_deg` or `azimuth_rad` (the first of the values) over
    /// `time_s`. A file is relative to `folder`.
    pub(super) fn azimuth_history(
        &self,
        folder: &Path,
        places: &Places,
    ) -> Result<Option<AzimuthHistory>> {
        let Some(source) = &self.azimuth_table else {
            return Ok(None);
        };
        let table = source.read_in(folder, |message| places.error("azimuth_table", message))?;
        let mut columns = table.columns();
        let time = columns.require("time_s")?;
        let degrees = columns.optional("azimuth_deg");
        let azimuth = match (degrees, columns.optional("azimuth_rad")) {
            (Some(_), Some(_)) => return Err(columns.both("azimuth_deg", "azimuth_rad")),
            (None, None) => {
                let message = "the table has no column `azimuth_deg` or `azimuth_rad`";
                return Err(table.header_error(message));
            }
            (degrees, radians) => degrees.or(radians),
        };
        columns.done()?;
        let values: Vec<Column> = azimuth.into_iter().collect();
        let key = (Key::Time, time);
        Ok(Some(AzimuthHistory {
            history: History::from_table(&table, key, &values, self.azimuth_interpolation)?,
            is_degrees: degrees.is_some(),
        }))
    }

    /// Returns whether a plane mesh turns about the shaft, which is then perpendicular to it.
    pub(super) fn is_upright(&self) -> bool {
        match self.shaft_axis {
            Some(shaft) => shaft[0].hypot(shaft[1]) < PARALLEL && shaft[2] != 0.0,
            None => self.frame == Frame::Inertial,
        }
    }

    /// Returns the axes for a mesh of this dimension. The shaft is kept, the span made perpendicular to it.
    pub(super) fn axes(&self, dimension: u8, places: &Places) -> Result<RotorAxes> {
        let key = match self.shaft_axis {
            Some(_) => "shaft_axis",
            None => "span_axis",
        };
        let error = |message: &str| places.error(key, message);
        let upright = dimension == 2 && self.is_upright();
        let (span, shaft) = match dimension {
            2 if !upright => ([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
            _ => ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        };
        let span = self.span_axis.unwrap_or(span);
        let e_z = match self.shaft_axis.unwrap_or(shaft) {
            [.., z] if upright => [0.0, 0.0, z.signum()],
            shaft => shaft,
        };
        let chord = cross(e_z, span);
        if dot(chord, chord) < PARALLEL * PARALLEL {
            return Err(error(
                "span axis and shaft axis are parallel; they must be perpendicular",
            ));
        }
        let e_y = unit(chord).expect("its length was checked");
        let e_x = cross(e_y, e_z);
        if dimension == 2 && !upright {
            if self.frame == Frame::Inertial {
                let message = "`frame` = \"inertial\" turns a 2D mesh in its plane: `shaft_axis` must be along z";
                return Err(places.error("frame", message));
            }
            if e_x[0].hypot(e_x[1]) > PARALLEL {
                return Err(error(
                    "in a 2D mesh the pitch must be in its plane: `span_axis` must be along z",
                ));
            }
        }
        Ok(RotorAxes {
            hub: self.hub,
            e_x,
            e_y,
            e_z,
            frame: self.frame,
            signs: Signs {
                azimuth: self.azimuth_sign,
                pitch: self.pitch_sign,
                flap: self.flap_sign,
                lag: self.lag_sign,
            },
            in_plane: dimension == 2,
            has_span: self.span_axis.is_some(),
        })
    }
}

/// A rotor and its azimuth over time.
pub(super) struct RotorInTime<'a> {
    pub rotor: &'a Rotor,
    /// The places of its keys.
    pub places: Places,
    /// Its table, if it has one that was read.
    pub table: Option<AzimuthHistory>,
}

impl RotorInTime<'_> {
    /// Returns the azimuth at a time in degrees and in radians, and its rate in radians per second; `None` without `rpm` and
    /// table.
    pub fn azimuth_at(&self, time: f64) -> Result<Option<[f64; 3]>> {
        if let Some(table) = &self.table {
            return table.at(time).map(Some);
        }
        Ok(self.rotor.rpm.map(|rpm| {
            let degrees = 6.0 * rpm * time;
            [degrees, degrees.to_radians(), (6.0 * rpm).to_radians()]
        }))
    }

    /// Returns the steps at the azimuths of this rotor, which is not the first; `None` if they equal those of the first.
    pub fn steps(&self, of_first: &[Step]) -> Result<Option<Vec<Step>>> {
        if !self.rotor.turns_in_time() {
            return Ok(None);
        }
        let key = match self.rotor.azimuth_table {
            Some(_) if self.rotor.rpm.is_some() => {
                let message = "`rpm` and `azimuth_table` both define the azimuth; keep one of them";
                return Err(self.places.error("rpm", message));
            }
            Some(_) => "azimuth_table",
            None => "rpm",
        };
        let at_own_azimuth = |step: &Step| {
            let Some(time) = step.time_s else {
                let message = format!(
                    "`{key}` needs the time of every step; give the first rotor its `rpm`, or give the steps as [time]"
                );
                return Err(self.places.error(key, message));
            };
            let Some([azimuth_deg, azimuth, rate]) = self.azimuth_at(time)? else {
                return Ok(*step);
            };
            if !azimuth.is_finite() {
                let message = format!(
                    "`{key}` gives step {} an azimuth that is not finite",
                    step.index
                );
                return Err(self.places.error(key, message));
            }
            Ok(Step {
                azimuth_deg,
                azimuth,
                azimuth_rate: Some(rate),
                has_azimuth: true,
                ..*step
            })
        };
        of_first
            .iter()
            .map(at_own_azimuth)
            .collect::<Result<_>>()
            .map(Some)
    }
}

/// The azimuth over time.
#[derive(Debug)]
pub(super) struct AzimuthHistory {
    history: History,
    /// True if its values are in degrees, false if in radians.
    is_degrees: bool,
}

impl AzimuthHistory {
    /// Returns the azimuth at a time in degrees and in radians, and its rate in radians per second.
    pub fn at(&self, time: f64) -> Result<[f64; 3]> {
        let azimuth = self.history.at(time)?[0];
        let rate = self.history.rates_at(time)?[0];
        Ok(if self.is_degrees {
            [azimuth, azimuth.to_radians(), rate.to_radians()]
        } else {
            [azimuth.to_degrees(), azimuth, rate]
        })
    }
}

setters! { Rotor {
    /// Sets its name, unique among the rotors; bodies name it.
    name(name: impl Into<String>) |self| self.name = Some(name.into());
    /// Adds zones that deform and turn with it, in the inertial frame.
    zones(zones: impl IntoIterator<Item = impl Into<String>>) |self|
        self.zones.extend(Pattern::all(zones, &Places::of_item("rotor".into()), "zones"));
    /// Sets the hub centre, in mesh units.
    hub(hub: Vector) |self| self.hub = hub;
    /// Sets the direction, of any length, of the span of the blade at zero azimuth.
    span_axis(direction: Vector) |self| self.span_axis = Some(unit(direction).unwrap_or_default());
    /// Sets the direction, of any length, of the shaft, towards the thrust side.
    shaft_axis(direction: Vector) |self| self.shaft_axis = Some(unit(direction).unwrap_or_default());
    /// Writes meshes in the inertial frame: rotated by the azimuth.
    inertial() |self| self.frame = Frame::Inertial;
    /// Writes meshes in the rotating frame, the default.
    rotating() |self| self.frame = Frame::Rotating;
    /// Sets the revolutions per minute, from which steps over azimuth get their times.
    rpm(rpm: f64) |self| self.rpm = Some(rpm);
    /// Sets the azimuth of steps in time, for a rotor that speeds up: a table of `time_s` and `azimuth_deg` (or
    /// `azimuth_rad`).
    azimuth_table(table: impl Into<TableSource>) |self| self.azimuth_table = Some(table.into());
    /// Interpolates that table with a cubic spline, so that the rotor speed has no jumps.
    cubic_azimuth() |self| self.azimuth_interpolation = Interpolation::Cubic;
    /// Sets the sense of rotation: 1, or -1 for a rotor that turns clockwise seen from the thrust side.
    azimuth_sign(sign: f64) |self| self.azimuth_sign = sign;
    /// Sets the sign of the pitch angle: 1, or -1 for the other convention.
    pitch_sign(sign: f64) |self| self.pitch_sign = sign;
    /// Sets the sign of the flap angle: 1, or -1 for the other convention.
    flap_sign(sign: f64) |self| self.flap_sign = sign;
    /// Sets the sign of the lag angle: 1, or -1 for the other convention.
    lag_sign(sign: f64) |self| self.lag_sign = sign;
} }

/// A rotor on a mesh.
#[derive(Debug, Clone)]
pub struct TurningRotor {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its axes.
    pub axes: RotorAxes,
    /// The steps at its azimuths; `None` if they equal those of the schedule.
    pub(super) steps: Option<Vec<Step>>,
}

impl TurningRotor {
    /// Returns a step of the schedule at the azimuth of this rotor.
    pub fn step<'a>(&'a self, step: &'a Step) -> &'a Step {
        self.steps.as_ref().map_or(step, |steps| &steps[step.index])
    }

    /// Returns whether the mesh turns with it.
    pub fn is_inertial(&self) -> bool {
        self.axes.frame == Frame::Inertial
    }

    /// Returns the rotation to the inertial frame at a step; `None` if the mesh does not turn with it.
    fn to_inertial(&self, step: &Step) -> Option<Transform> {
        let turn = || self.axes.turn(self.step(step).azimuth);
        self.is_inertial().then(turn)
    }

    /// Returns the rotation to the inertial frame with its velocity.
    fn to_inertial_moving(&self, step: &Step) -> Option<Moving> {
        let (axes, step) = (&self.axes, self.step(step));
        let [angle, rate] = [step.azimuth, step.azimuth_rate.unwrap_or(0.0)];
        let sign = axes.signs.azimuth;
        let turn = || Moving::rotation(axes.e_z, axes.hub, sign * angle, sign * rate);
        self.is_inertial().then(turn)
    }
}

/// The rotations of each rotor from its frame, in which its zones deform, to the inertial frame.
pub struct ToInertial<'a, T = Transform> {
    motion: &'a Motion,
    /// By rotor; `None` if the mesh does not turn with it.
    of_rotors: Vec<Option<T>>,
}

impl<T> ToInertial<'_, T> {
    /// Returns the rotation of a node of the mesh; `None` if it does not turn.
    pub fn of_node(&self, node: u32) -> Option<&T> {
        let rotor = self.motion.rotor_of_node(node)?;
        self.of_rotors[rotor].as_ref()
    }

    /// Returns the rotation of a body; `None` if it does not turn.
    pub fn of_body(&self, body: usize) -> Option<&T> {
        self.of_rotors[self.motion.bodies[body].rotor].as_ref()
    }

    /// Converts each of them.
    #[must_use]
    pub fn map<U>(&self, change: impl Fn(&T) -> U) -> ToInertial<'_, U> {
        let of_rotors = self.of_rotors.iter();
        ToInertial {
            motion: self.motion,
            of_rotors: of_rotors.map(|of| of.as_ref().map(&change)).collect(),
        }
    }
}

impl Motion {
    /// Returns the azimuth rotations `Rz(psi)` from the frames of the rotors to the inertial frame at a step; `None` if no
    /// rotor has that frame.
    pub fn to_inertial(&self, step: &Step) -> Option<ToInertial<'_>> {
        self.turns(|rotor| rotor.to_inertial(step))
    }

    /// Returns the rotations of [`to_inertial`](Self::to_inertial) with their velocities.
    pub fn to_inertial_moving(&self, step: &Step) -> Option<ToInertial<'_, Moving>> {
        self.turns(|rotor| rotor.to_inertial_moving(step))
    }

    fn turns<T>(&self, of: impl Fn(&TurningRotor) -> Option<T>) -> Option<ToInertial<'_, T>> {
        let of_rotors: Vec<Option<T>> = self.rotors.iter().map(of).collect();
        let turns = of_rotors.iter().any(Option::is_some);
        turns.then_some(ToInertial {
            motion: self,
            of_rotors,
        })
    }
}

/// The rotor's axes at zero azimuth: right-handed and orthonormal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RotorAxes {
    /// Hub centre `O`.
    pub hub: Vector,
    /// Along the span, outward.
    pub e_x: Vector,
    /// Along the chord, towards the leading edge of a counter-clockwise rotor.
    pub e_y: Vector,
    /// Along the shaft, towards the thrust side.
    pub e_z: Vector,
    /// Frame in which the mesh is written.
    pub frame: Frame,
    /// Signs of the angles.
    pub signs: Signs,
    /// True if the mesh is plane, in x and y.
    pub in_plane: bool,
    /// True if the schedule gives the span; the default is along x.
    pub has_span: bool,
}

impl RotorAxes {
    /// Returns whether the mesh is plane and turns about the shaft.
    pub(super) fn is_upright(&self) -> bool {
        self.in_plane && self.e_z[2] != 0.0
    }

    /// Returns the axis about which a sector of the mesh may be repeated: the shaft, or the normal of a plane mesh.
    pub fn axis_of_sectors(&self) -> Vector {
        if self.in_plane && !self.is_upright() {
            [0.0, 0.0, 1.0]
        } else {
            self.e_z
        }
    }

    /// Returns the frame of a blade: these axes turned by its azimuth offset (radians) about the shaft. A 2D mesh with
    /// the shaft in its plane has one frame; there an offset only shifts the azimuth.
    pub(super) fn blade(&self, azimuth_offset: f64) -> Self {
        if self.in_plane && !self.is_upright() {
            return *self;
        }
        let turn = self.turn(azimuth_offset);
        Self {
            e_x: turn.turn(self.e_x),
            e_y: turn.turn(self.e_y),
            ..*self
        }
    }

    /// Returns the azimuth rotation `Rz(psi)` about the shaft, `psi` in radians.
    pub fn turn(&self, psi: f64) -> Transform {
        Transform::rotation(self.e_z, self.hub, self.signs.azimuth * psi)
    }

    /// Returns the direction of the leading edge of a blade at zero azimuth: its direction of motion.
    pub fn leading_edge(&self) -> Vector {
        // Adding 0 removes the sign of a zero.
        scale(self.e_y, self.signs.azimuth).map(|x| x + 0.0)
    }

    /// Describes the frame and the senses of the angles, one sentence each. Pitch raises the side towards `e_y`, and lag
    /// moves the blade in that direction: towards the trailing edge of a clockwise rotor.
    pub fn conventions(&self) -> Vec<String> {
        let signs = &self.signs;
        let way = |sign: f64, plus: &'static str, minus: &'static str| {
            if sign < 0.0 { minus } else { plus }
        };
        let frame = match self.frame {
            Frame::Rotating => "rotating frame: the mesh is not carried round",
            Frame::Inertial => "inertial frame: the mesh is carried round with the azimuth",
        };
        vec![
            frame.to_owned(),
            format!(
                "hub {:?}, span {:?}, chord (leading edge) {:?}, shaft (thrust) {:?}",
                self.hub,
                self.e_x,
                self.leading_edge(),
                self.e_z
            ),
            format!(
                "azimuth {} seen from the thrust side, pitch positive nose {}, flap positive {}, lag {} positive",
                way(signs.azimuth, "counter-clockwise", "clockwise"),
                way(signs.azimuth * signs.pitch, "up", "down"),
                way(signs.flap, "up", "down"),
                way(signs.azimuth * signs.lag, "lead", "trail"),
            ),
        ]
    }

    /// Returns the point `O + x e_x + y e_y + z e_z`.
    #[inline]
    pub fn point(&self, x: f64, y: f64, z: f64) -> Vector {
        let offset = add(
            scale(self.e_x, x),
            add(scale(self.e_y, y), scale(self.e_z, z)),
        );
        add(self.hub, offset)
    }
}
