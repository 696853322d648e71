//! Rotations and translations that follow one another: what a motion of a body is made of.

use super::body::{Cyclic, Rigid};
use super::rotor::RotorAxes;
use crate::geometry::vector::{Vector, scale};
use crate::geometry::{Moving, Transform};

/// A rotation about an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Unit axis.
    pub axis: Vector,
    /// A point of the axis, in mesh units.
    pub origin: Vector,
    /// In radians.
    pub angle: f64,
    /// In radians a second; 0 where the schedule has no time.
    pub rate: f64,
}

impl Turn {
    /// The part, from 0 to 1, of the rotation.
    pub fn part(&self, part: f64) -> Transform {
        Transform::rotation(self.axis, self.origin, part * self.angle)
    }

    /// The rotation with its velocity.
    pub fn moving(&self) -> Moving {
        Moving::rotation(self.axis, self.origin, self.angle, self.rate)
    }
}

/// Turns, then a translation.
#[derive(Debug, Clone, Default)]
pub(super) struct Displaced {
    /// The rotations, in their order.
    pub turns: Vec<Turn>,
    /// In mesh units.
    pub translation: Vector,
    /// In mesh units a second; 0 where the schedule has no time.
    pub rate: Vector,
}

impl Displaced {
    /// The part, from 0 to 1, of every angle and of the translation.
    pub fn part(&self, part: f64) -> Transform {
        let turns = self.turns.iter().map(|turn| turn.part(part));
        let turned = turns.reduce(|first, next| first.then(&next));
        let shift = Transform::translation(scale(self.translation, part));
        turned.unwrap_or(Transform::IDENTITY).then(&shift)
    }

    /// The whole with its velocity.
    pub fn moving(&self) -> Moving {
        let turns = self.turns.iter().map(Turn::moving);
        let turned = turns.fold(Moving::still(Transform::IDENTITY), |first, next| {
            first.then(&next)
        });
        turned.then(&Moving::translation(self.translation, self.rate))
    }
}

/// The part `reached` of a rigid motion, which grows by `rate` a second.
pub(super) fn rigid_displaced(rigid: &Rigid, reached: f64, rate: f64) -> Displaced {
    let turn = rigid.rotate.map(|(axis, origin, angle)| Turn {
        axis,
        origin,
        angle: angle * reached,
        rate: angle * rate,
    });
    Displaced {
        turns: turn.into_iter().collect(),
        translation: scale(rigid.translate, reached),
        rate: scale(rigid.translate, rate),
    }
}

/// Equations 2 and 3 of the method without a beam, in the blade's own frame at its azimuth `psi`:
///
/// ```text
/// x_r = Rx(pitch) (x - x_ref),                 x_ref = O + r e_x + pitch_axis
/// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x)
/// ```
///
/// Its turns, pitch first. The pitch axis is parallel to the span, so that turning about it needs no
/// station `r`. The azimuth grows by `rate` radians a second.
pub(super) fn cyclic_turns(cyclic: &Cyclic, blade: &RotorAxes, psi: f64, rate: f64) -> [Turn; 3] {
    let signs = &blade.signs;
    let [chordwise, shaftwise] = cyclic.pitch_axis;
    let pitch_axis = blade.point(0.0, chordwise, shaftwise);
    let hinge = blade.point(cyclic.flap_hinge, 0.0, 0.0);
    let turn = |axis, origin, series: &super::body::Series, sign: f64| Turn {
        axis,
        origin,
        angle: sign * series.at(psi, cyclic.phase),
        rate: sign * series.slope(psi, cyclic.phase) * rate,
    };
    [
        turn(blade.e_x, pitch_axis, &cyclic.pitch, signs.pitch),
        turn(blade.e_y, hinge, &cyclic.flap, -signs.flap),
        turn(blade.e_z, hinge, &cyclic.lag, signs.lag),
    ]
}
