//! The sections of a bending blade at a part of a step: a rigid map for each.

use super::lifting::LiftingLine;
use crate::motion::motions::Rotation;
use crate::motion::rotor::RotorAxes;
use crate::motion::table::{RotationForm, SpanValues};
use azimesh_core::geometry::rotation::rotate_by;
use azimesh_core::geometry::vector::{Vector, add, dot, scale, sub};
use azimesh_core::geometry::{Moving, Transform};

/// The sections of a beam at a part of a step.
#[derive(Debug, Clone)]
pub(in crate::motion) struct Sections<'a> {
    values: SpanValues<'a>,
    form: RotationForm,
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
        (values, form): (SpanValues<'a>, RotationForm),
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
            form,
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
        let sections = Self::new(
            (self.values, self.form),
            of,
            self.part,
            self.key_rate,
            hinges,
        );
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
    ///
    /// with rotations in another form in place of `Rz Ry Rx`, and the pitch before them.
    pub fn map(&self, x: Vector) -> Transform {
        let station = self.station(x);
        let [dx, dy, dz, turns @ ..] = self.values_at(station);
        let turns = self.turns(self.reference(station), [turns, [0.0; 3]]);
        let turns = turns.into_iter().map(|turn| turn.part(self.part).map());
        let turned = turns.fold(Transform::IDENTITY, |all, next| all.then(&next));
        let shift = scale(self.along([dx, dy, dz]), self.part);
        let section = turned.then(&Transform::translation(shift));
        section.then(&self.after)
    }

    /// Converts a vector from the axes of the blade.
    fn along(&self, [x, y, z]: Vector) -> Vector {
        let RotorAxes { e_x, e_y, e_z, .. } = self.blade;
        add(scale(e_x, x), add(scale(e_y, y), scale(e_z, z)))
    }

    /// Returns the pitch and the table's rotations of a section about its reference point, with rates.
    fn turns(&self, origin: Vector, [values, rates]: [Vector; 2]) -> Vec<Rotation> {
        let pitch = self
            .hinges
            .map_or([0.0; 2], |[pitch, ..]| [pitch.angle, pitch.rate]);
        let axes = [self.blade.e_x, self.blade.e_y, self.blade.e_z];
        let about = |axis: usize, by| Rotation::about(axes[axis], origin, by);
        let mut turns = vec![about(0, pitch)];
        match self.form.order() {
            Some(order) => turns.extend(order.map(|axis| about(axis, [values[axis], rates[axis]]))),
            None => turns.push(Rotation::by(
                [self.along(values), self.along(rates)],
                origin,
            )),
        }
        if self.form.order().is_some_and(|order| order[0] == 0) {
            let first = turns.remove(0);
            turns[0].angle += first.angle;
            turns[0].rate += first.rate;
        }
        turns
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
        let [dx, dy, dz, turns @ ..] = values;
        let pitch = self.part * self.pitch();
        let RotorAxes { e_x, e_y, e_z, .. } = self.blade;
        let arm = sub(at, self.reference(station));
        let (along, forward, up) = (dot(e_x, arm), dot(e_y, arm), dot(e_z, arm));
        let [x, y, z] = self.turned([along, forward, up], turns, pitch);
        // As a displacement, so that points at rest keep every bit.
        let by = [x - along + dx, y - forward + dy, z - up + dz];
        let mut moved = at;
        for i in 0..3 {
            moved[i] += e_x[i] * by[0] + e_y[i] * by[1] + e_z[i] * by[2];
        }
        self.after.apply(moved)
    }

    /// Turns a vector in the axes of the blade by the pitch and the rotations of a section.
    #[inline]
    fn turned(&self, mut arm: Vector, mut turns: Vector, pitch: f64) -> Vector {
        let about = |arm: &mut Vector, axis: usize, angle: f64| {
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            (arm[a], arm[b]) = turned(arm[a], arm[b], angle);
        };
        match self.form.order() {
            Some([0, ..]) => turns[0] += pitch,
            _ => about(&mut arm, 0, pitch),
        }
        match self.form.order() {
            Some(order) => order
                .into_iter()
                .for_each(|axis| about(&mut arm, axis, turns[axis])),
            None => arm = rotate_by(turns, arm),
        }
        arm
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
        let [[shift, turns], [shift_rate, turn_rates]] =
            [values, rates].map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
        let still = Moving::still(Transform::IDENTITY);
        let turns = self.turns(origin, [turns, turn_rates]).into_iter();
        let section = turns
            .fold(still, |all, next| all.then(&next.moving()))
            .then(&Moving::translation(
                self.along(shift),
                self.along(shift_rate),
            ));
        match self.hinges {
            Some([_, flap, lag]) => section.then(&flap.moving()).then(&lag.moving()),
            None => section,
        }
    }

    /// Returns the rotations of the section that contains `x`, in their order.
    pub fn rotations(&self, x: Vector) -> Vec<Rotation> {
        let station = self.station(x);
        let [_, _, _, turns @ ..] = self.values_at(station);
        let section = self.turns(self.reference(station), [turns, [0.0; 3]]);
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
