//! A blade that bends: translations and rotations of its sections over azimuth and span.

use super::lifting::{LiftingLine, off_blade};
use super::{BladeSurface, Clock};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, add, dot, norm, scale, sub};
use crate::geometry::{Moving, Transform};
use crate::motion::body::{BeamMotion, Body};
use crate::motion::rotor::RotorAxes;
use crate::motion::steps::Step;
use crate::motion::table::{SpanHistory, SpanValues, Table};
use crate::motion::turn::Turn;
use std::path::Path;

/// A blade may go on past the ends of its table by this part of its span before it is told of.
const BEYOND: f64 = 0.05;
/// Stations so many times as far out as the blade are told of.
const FAR: f64 = 2.0;

/// Six values at every station and azimuth, and the line that sections turn about.
#[derive(Debug, Clone)]
pub(in crate::motion) struct Beam {
    span: SpanHistory,
    line: LiftingLine,
    /// What the user should know, as sentences.
    pub notes: Vec<String>,
    /// What is likely to be wrong with the line, as a sentence.
    pub warning: Option<String>,
}

/// The sections of a beam at a part of a step.
#[derive(Debug, Clone)]
pub(in crate::motion) struct Sections<'a> {
    values: SpanValues<'a>,
    line: &'a LiftingLine,
    blade: RotorAxes,
    part: f64,
    /// By how much the key of the table grows in a second.
    key_rate: f64,
    /// Pitch, flap and lag of the cyclic motion.
    turns: Option<[Turn; 3]>,
    /// Flap and lag of this part.
    after: Transform,
}

impl Beam {
    /// Reads the table and the lifting line of a body; there must be values at every step.
    pub fn read(
        motion: &BeamMotion,
        (table, line): (&Path, Option<&Path>),
        body: &Body,
        clock: &Clock<'_>,
        surface: &BladeSurface<'_>,
    ) -> Result<Self> {
        let offset_axis = body.cyclic.as_ref().map(|cyclic| cyclic.pitch_axis);
        if offset_axis.is_some_and(|offset| offset != [0.0; 2]) {
            let message = format!(
                "body \"{}\" has both `pitch_axis` and a beam, whose sections pitch about its lifting line; leave \
                 `pitch_axis` out",
                body.name
            );
            return Err(Error::input(message).line(motion.line));
        }
        let (span, path) = (read_span(motion, table)?, table);
        clock.check(span.history(), body.azimuth_offset, motion.line)?;
        let mut notes = check_span(&span, path, body, surface.span())?;
        let line = match line {
            Some(line) => LiftingLine::read(line, body, surface.span())?,
            None => LiftingLine::quarter_chord(surface, span.stations(), body, motion.line)?,
        };
        let name = match motion.lifting_line {
            Some(_) => "lifting line",
            None => "quarter chord",
        };
        notes.push(where_it_is(name, &line, body, surface.blade));
        Ok(Self {
            warning: line.beside(body, &surface.bounds()),
            span,
            line,
            notes,
        })
    }

    /// The sections at a part of a step; `turns` are those of the cyclic motion.
    pub fn at(
        &self,
        step: &Step,
        offset: f64,
        part: f64,
        (blade, turns): (RotorAxes, Option<[Turn; 3]>),
        clock: &Clock<'_>,
    ) -> Sections<'_> {
        let promise = "the table was checked at every step";
        let key = self.span.history().key();
        let at = Clock::place(key, step, offset).expect(promise);
        let after = turns.map_or(Transform::IDENTITY, |[_, flap, lag]| {
            flap.part(part).then(&lag.part(part))
        });
        Sections {
            values: self.span.at(at).expect(promise),
            line: &self.line,
            blade,
            part,
            key_rate: clock.rate(key, step),
            turns,
            after,
        }
    }
}

/// The lifting line of a blade in the reference mesh, its ends held.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreLine {
    line: LiftingLine,
    blade: RotorAxes,
    span: [f64; 2],
}

impl CentreLine {
    /// The point of the line at the station of `x`.
    pub fn at(&self, x: Vector) -> Vector {
        let station = dot(sub(x, self.blade.hub), self.blade.e_x);
        let [x, y, z] = self.line.at(station.clamp(self.span[0], self.span[1]));
        self.blade.point(x, y, z)
    }
}

impl Beam {
    /// The lifting line, held within the span of some points.
    pub fn centre_line(&self, blade: RotorAxes, points: &[Vector]) -> CentreLine {
        let stations = points.iter().map(|x| dot(sub(*x, blade.hub), blade.e_x));
        let span = stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
            [low.min(r), high.max(r)]
        });
        CentreLine {
            line: self.line.clone(),
            blade,
            // A body that shares all of its nodes with others has no point of its own.
            span: if span[0] <= span[1] { span } else { [0.0; 2] },
        }
    }
}

/// A sentence on the ends of a lifting line, in the mesh.
fn where_it_is(name: &str, line: &LiftingLine, body: &Body, blade: &RotorAxes) -> String {
    let ends = line.ends().map(|[x, y, z]| blade.point(x, y, z));
    let length = norm(sub(ends[1], ends[0]));
    let digits = (4.0 - length.log10().floor()).clamp(0.0, 17.0) as usize;
    let shown = |x: Vector, digits: usize| {
        // What rounds to zero has no sign.
        let least = 0.5 * 0.1_f64.powi(digits as i32);
        let numbers = x.map(|x| format!("{:.digits$}", if x.abs() < least { 0.0 } else { x }));
        format!("[{}]", numbers.join(", "))
    };
    let [root, tip] = ends.map(|end| shown(end, digits));
    let nose = shown(blade.leading_edge(), 3);
    format!(
        "body \"{}\": its {name} goes from {root} to {tip}, with the leading edge towards {nose}",
        body.name
    )
}

fn read_span(motion: &BeamMotion, path: &Path) -> Result<SpanHistory> {
    let table = Table::read(path)?;
    let mut columns = table.columns();
    let key = columns.optional_key()?;
    let station = columns.require("station")?;
    let shifts = ["dx", "dy", "dz"].map(|name| columns.require(name));
    let turns = ["rot_x", "rot_y", "rot_z"].map(|name| columns.require_angle(name));
    let six = shifts
        .into_iter()
        .chain(turns)
        .collect::<Result<Vec<_>>>()?;
    columns.done()?;
    SpanHistory::from_table(&table, key, station, &six, motion.interpolation)
}

/// Refuses a table that lies wholly off the blade; tells of a blade that goes on far past its table,
/// and of stations far off the blade.
fn check_span(
    table: &SpanHistory,
    path: &Path,
    body: &Body,
    [low, high]: [f64; 2],
) -> Result<Vec<String>> {
    let stations = table.stations();
    let (first, last) = (stations[0], stations[stations.len() - 1]);
    if last < low || first > high {
        let nearest = if last < low { stations.len() - 1 } else { 0 };
        let message = off_blade([first, last], body, [low, high]);
        return Err(Error::input(message).line(table.line(nearest)).file(path));
    }
    let mut notes = Vec::new();
    for (beyond, from, to) in [(first - low, low, first), (high - last, last, high)] {
        if beyond > BEYOND * (high - low) {
            notes.push(format!(
                "body \"{}\": {} has no stations between {from} and {to}; the values of its {} are held there",
                body.name,
                path.display(),
                if from == low { "first one" } else { "last one" }
            ));
        }
    }
    let reach = FAR * low.abs().max(high.abs());
    if let Some(at) = stations.iter().position(|station| station.abs() > reach) {
        notes.push(format!(
            "{}:{}: station {} lies far off body \"{}\", which goes from {low} to {high} along its span; stations are \
             lengths in mesh units from the hub",
            path.display(),
            table.line(at),
            stations[at],
            body.name
        ));
    }
    Ok(notes)
}

/// Two components turned from the first to the second.
#[inline]
fn turned(a: f64, b: f64, angle: f64) -> (f64, f64) {
    let (sin, cos) = angle.sin_cos();
    (cos * a - sin * b, sin * a + cos * b)
}

impl Sections<'_> {
    /// The rigid map of the section that `x` of the reference mesh is in (eq. 2 and 3):
    ///
    /// ```text
    /// x_r = Rz(rot_z) Ry(rot_y) Rx(rot_x + pitch) (x - x_ref)
    /// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x + (dx, dy, dz))
    /// ```
    pub fn map(&self, x: Vector) -> Transform {
        let station = self.station(x);
        let [dx, dy, dz, rx, ry, rz] = self.values.values(station).map(|v| self.part * v);
        let pitch = self
            .turns
            .map_or(0.0, |[pitch, ..]| self.part * pitch.angle);
        let origin = self.reference(station);
        let RotorAxes { e_x, e_y, e_z, .. } = self.blade;
        let turn = Transform::rotation(e_x, [0.0; 3], rx + pitch)
            .then(&Transform::rotation(e_y, [0.0; 3], ry))
            .then(&Transform::rotation(e_z, [0.0; 3], rz));
        let shift = add(scale(e_x, dx), add(scale(e_y, dy), scale(e_z, dz)));
        let section = Transform {
            translation: add(sub(origin, turn.turn(origin)), shift),
            ..turn
        };
        section.then(&self.after)
    }

    /// The image of `at` under the [`map`](Self::map) of the section that `x` is in, without the map
    /// itself: this is done for every surface node and step.
    #[inline]
    pub fn place(&self, x: Vector, at: Vector) -> Vector {
        let station = self.station(x);
        let [dx, dy, dz, rx, ry, rz] = self.values.values(station).map(|v| self.part * v);
        let pitch = self
            .turns
            .map_or(0.0, |[pitch, ..]| self.part * pitch.angle);
        let RotorAxes { e_x, e_y, e_z, .. } = self.blade;
        let arm = sub(at, self.reference(station));
        let [x, y, z] = [e_x, e_y, e_z].map(|axis| dot(axis, arm));
        let [along, forward, up] = [x, y, z];
        let (y, z) = turned(y, z, rx + pitch);
        let (z, x) = turned(z, x, ry);
        let (x, y) = turned(x, y, rz);
        // As a displacement, so that what does not move stays to the last bit.
        let by = [x - along + dx, y - forward + dy, z - up + dz];
        let moved: Vector =
            std::array::from_fn(|i| at[i] + (e_x[i] * by[0] + e_y[i] * by[1] + e_z[i] * by[2]));
        self.after.apply(moved)
    }

    /// The whole map with its velocity.
    pub fn moving(&self, x: Vector) -> Moving {
        let station = self.station(x);
        let values: [f64; 6] = self.values.values(station);
        let rates: [f64; 6] = self.values.rates(station).map(|rate| self.key_rate * rate);
        let origin = self.reference(station);
        let blade = &self.blade;
        let along = |v: &[f64; 6]| {
            let [x, y, z] = [v[0], v[1], v[2]];
            add(
                scale(blade.e_x, x),
                add(scale(blade.e_y, y), scale(blade.e_z, z)),
            )
        };
        let (pitch, pitch_rate) = self
            .turns
            .map_or((0.0, 0.0), |[pitch, ..]| (pitch.angle, pitch.rate));
        let turn = |axis, i: usize, angle: f64, rate: f64| {
            Moving::rotation(axis, origin, values[i] + angle, rates[i] + rate)
        };
        let section = turn(blade.e_x, 3, pitch, pitch_rate)
            .then(&turn(blade.e_y, 4, 0.0, 0.0))
            .then(&turn(blade.e_z, 5, 0.0, 0.0))
            .then(&Moving::translation(along(&values), along(&rates)));
        match self.turns {
            Some([_, flap, lag]) => section.then(&flap.moving()).then(&lag.moving()),
            None => section,
        }
    }

    /// The rotations of the section that `x` is in, in their order.
    pub fn turns(&self, x: Vector) -> Vec<Turn> {
        let station = self.station(x);
        let [.., rx, ry, rz] = self.values.values::<6>(station);
        let origin = self.reference(station);
        let turn = |axis, angle| Turn {
            axis,
            origin,
            angle,
            rate: 0.0,
        };
        let blade = &self.blade;
        let pitch = self.turns.map_or(0.0, |[pitch, ..]| pitch.angle);
        let section = [
            turn(blade.e_x, rx + pitch),
            turn(blade.e_y, ry),
            turn(blade.e_z, rz),
        ];
        let hinged = self
            .turns
            .into_iter()
            .flat_map(|[_, flap, lag]| [flap, lag]);
        section.into_iter().chain(hinged).collect()
    }

    fn station(&self, x: Vector) -> f64 {
        dot(sub(x, self.blade.hub), self.blade.e_x)
    }

    /// The point of the lifting line that a section turns about.
    fn reference(&self, station: f64) -> Vector {
        let [x, y, z] = self.line.at(station);
        self.blade.point(x, y, z)
    }
}
