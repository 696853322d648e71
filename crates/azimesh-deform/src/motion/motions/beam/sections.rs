//! The sections of a bending blade at a part of a step: a rigid map for each.

use super::lifting::LiftingLine;
use crate::motion::motions::Rotation;
use crate::motion::rotor::RotorAxes;
use crate::motion::table::SpanValues;
use azimesh_core::geometry::vector::{Vector, add, dot, scale, sub};
use azimesh_core::geometry::{Moving, Transform};

/// The sections of a beam at a part of a step.
#[derive(Debug, Clone)]
pub(in crate::motion) struct Sections<'a> {
    values: SpanValues<'a>,
    line: &'a LiftingLine,
    blade: RotorAxes,
    part: f64,
    /// Factor of the values, and its rate per second.
    ramp: [f64; 2],
    /// Rate of the key of the table, per second.
    key_rate: f64,
    /// Full pitch, flap and lag of the cyclic motion.
    hinges: Option<[Rotation; 3]>,
    /// Flap and lag of this part.
    after: Transform,
}

/// Rotates two components from the first to the second.
#[inline]
fn turned(a: f64, b: f64, angle: f64) -> (f64, f64) {
    let (sin, cos) = angle.sin_cos();
    (cos * a - sin * b, sin * a + cos * b)
}

impl<'a> Sections<'a> {
    pub(super) fn new(
        values: SpanValues<'a>,
        (line, blade): (&'a LiftingLine, RotorAxes),
        part: f64,
        key_rate: f64,
        hinges: Option<[Rotation; 3]>,
    ) -> Self {
        let after = hinges.map_or(Transform::IDENTITY, |[_, flap, lag]| {
            flap.part(part).map().then(&lag.part(part).map())
        });
        Self {
            values,
            line,
            blade,
            part,
            ramp: [1.0, 0.0],
            key_rate,
            hinges,
            after,
        }
    }

    /// Scales the sections for the start of a motion, like [`Link::ramped`](crate::motion::motions::Link::ramped).
    pub(in crate::motion::motions) fn ramped(
        self,
        ramp: [f64; 2],
        rotation: impl Fn(Rotation) -> Rotation,
    ) -> Self {
        let hinges = self.hinges.map(|hinges| hinges.map(rotation));
        let of = (self.line, self.blade);
        let sections = Self::new(self.values, of, self.part, self.key_rate, hinges);
        Self { ramp, ..sections }
    }

    /// Returns the values at a station, times the ramp.
    #[inline]
    fn values_at(&self, station: f64) -> [f64; 6] {
        let mut values: [f64; 6] = self.values.values(station);
        for value in &mut values {
            *value *= self.ramp[0];
        }
        values
    }

    /// Returns the rigid map of the section that contains `x` of the reference mesh (eq. 2 and 3):
    ///
    /// ```text
    /// x_r = Rz(rot_z) Ry(rot_y) Rx(rot_x + pitch) (x - x_ref)
    /// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x + (dx, dy, dz))
    /// ```
    pub fn map(&self, x: Vector) -> Transform {
        let station = self.station(x);
        let [dx, dy, dz, rx, ry, rz] = self.values_at(station).map(|v| self.part * v);
        let pitch = self.part * self.pitch();
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

    /// Applies the [`map`](Self::map) of the section that contains `x` to `at`, without building the map: this is
    /// done for every surface node and step.
    #[inline]
    pub fn place(&self, x: Vector, at: Vector) -> Vector {
        let station = self.station(x);
        let mut values = self.values_at(station);
        for value in &mut values {
            *value *= self.part;
        }
        let [dx, dy, dz, rx, ry, rz] = values;
        let pitch = self.part * self.pitch();
        let RotorAxes { e_x, e_y, e_z, .. } = self.blade;
        let arm = sub(at, self.reference(station));
        let (along, forward, up) = (dot(e_x, arm), dot(e_y, arm), dot(e_z, arm));
        let (y, z) = turned(forward, up, rx + pitch);
        let (z, x) = turned(z, along, ry);
        let (x, y) = turned(x, y, rz);
        // As a displacement, so that points at rest keep every bit.
        let by = [x - along + dx, y - forward + dy, z - up + dz];
        let mut moved = at;
        for i in 0..3 {
            moved[i] += e_x[i] * by[0] + e_y[i] * by[1] + e_z[i] * by[2];
        }
        self.after.apply(moved)
    }

    /// Returns the whole map with its velocity.
    pub fn moving(&self, x: Vector) -> Moving {
        let station = self.station(x);
        let values = self.values_at(station);
        let [reached, growth] = self.ramp;
        let whole: [f64; 6] = self.values.values(station);
        let mut rates: [f64; 6] = self.values.rates(station);
        for (rate, value) in rates.iter_mut().zip(whole) {
            *rate = reached * self.key_rate * *rate + growth * value;
        }
        let origin = self.reference(station);
        let blade = &self.blade;
        let along = |v: &[f64; 6]| {
            let [x, y, z] = [v[0], v[1], v[2]];
            add(
                scale(blade.e_x, x),
                add(scale(blade.e_y, y), scale(blade.e_z, z)),
            )
        };
        let pitch = self.hinges.map(|[pitch, ..]| (pitch.angle, pitch.rate));
        let (pitch, pitch_rate) = pitch.unwrap_or((0.0, 0.0));
        let turn = |axis, i: usize, angle: f64, rate: f64| {
            Moving::rotation(axis, origin, values[i] + angle, rates[i] + rate)
        };
        let section = turn(blade.e_x, 3, pitch, pitch_rate)
            .then(&turn(blade.e_y, 4, 0.0, 0.0))
            .then(&turn(blade.e_z, 5, 0.0, 0.0))
            .then(&Moving::translation(along(&values), along(&rates)));
        match self.hinges {
            Some([_, flap, lag]) => section.then(&flap.moving()).then(&lag.moving()),
            None => section,
        }
    }

    /// Returns the rotations of the section that contains `x`, in their order.
    pub fn rotations(&self, x: Vector) -> Vec<Rotation> {
        let station = self.station(x);
        let [.., rx, ry, rz] = self.values_at(station);
        let origin = self.reference(station);
        let turn = |axis, angle| Rotation {
            axis,
            origin,
            angle,
            rate: 0.0,
        };
        let blade = &self.blade;
        let pitch = self.pitch();
        let section = [
            turn(blade.e_x, rx + pitch),
            turn(blade.e_y, ry),
            turn(blade.e_z, rz),
        ];
        let hinged = (self.hinges.into_iter()).flat_map(|[_, flap, lag]| [flap, lag]);
        section.into_iter().chain(hinged).collect()
    }

    /// Returns the pitch of the cyclic motion.
    #[inline]
    fn pitch(&self) -> f64 {
        self.hinges.map_or(0.0, |[pitch, ..]| pitch.angle)
    }

    #[inline]
    fn station(&self, x: Vector) -> f64 {
        dot(sub(x, self.blade.hub), self.blade.e_x)
    }

    /// Returns the point of the lifting line about which a section turns.
    #[inline]
    fn reference(&self, station: f64) -> Vector {
        let [x, y, z] = self.line.at(station);
        self.blade.point(x, y, z)
    }
}
