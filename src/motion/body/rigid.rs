//! `[body.rigid]`: a rotation, then a translation, the same at every step or growing with the steps.

use crate::error::Result;
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, scale};
use crate::motion::reader::{AngleUnit, Entry, Keys};

const RIGID: Keys = Keys {
    known: &["rotate", "translate", "ramp"],
    later: &[],
};
const ROTATE: Keys = Keys {
    known: &["axis", "origin", "angle"],
    later: &[],
};

/// A rotation about an axis, then a translation.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// Unit axis, origin in mesh units, angle in radians.
    pub rotate: Option<(Vector, Vector, f64)>,
    /// In mesh units.
    pub translate: Vector,
    /// From nothing at the first step to the whole at the last.
    pub ramp: bool,
    /// Line of the first key that leaves the plane of a 2D mesh.
    pub(in crate::motion) out_of_plane: Option<u64>,
}

impl Rigid {
    /// The part `fraction` of the motion: angle and translation scale with it.
    pub fn part(&self, fraction: f64) -> Transform {
        let turn = match self.rotate {
            Some((axis, origin, angle)) => Transform::rotation(axis, origin, fraction * angle),
            None => Transform::IDENTITY,
        };
        turn.then(&Transform::translation(scale(self.translate, fraction)))
    }

    pub(super) fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.rigid]", &RIGID)?;
        let mut rigid = Self {
            rotate: None,
            translate: [0.0; 3],
            ramp: false,
            out_of_plane: None,
        };
        let mut leaves_plane = Vec::new();
        if let Some(rotate) = section.get("rotate") {
            let (axis, origin, angle) = read_rotation(&rotate, unit)?;
            if (axis[0], axis[1]) != (0.0, 0.0) {
                leaves_plane.push(rotate.line());
            }
            rigid.rotate = Some((axis, origin, angle));
        }
        if let Some(translate) = section.get("translate") {
            rigid.translate = translate.numbers()?;
            if rigid.translate[2] != 0.0 {
                leaves_plane.push(translate.line());
            }
        }
        if rigid.rotate.is_none() && section.get("translate").is_none() {
            return Err(section
                .error("[body.rigid] has neither `rotate` nor `translate`; give one of them"));
        }
        if let Some(ramp) = section.get("ramp") {
            rigid.ramp = ramp.boolean()?;
        }
        rigid.out_of_plane = leaves_plane.into_iter().min();
        Ok(rigid)
    }
}

fn read_rotation(entry: &Entry<'_>, unit: AngleUnit) -> Result<(Vector, Vector, f64)> {
    let section = entry.section("rotate = { axis, origin, angle }", &ROTATE)?;
    let axis = section
        .require("axis", "axis = [0.0, 0.0, 1.0]")?
        .direction()?;
    let angle = section.require("angle", "angle = 20.0")?.angle(unit)?;
    let origin = match section.get("origin") {
        Some(origin) => origin.numbers()?,
        None => [0.0; 3],
    };
    Ok((axis, origin, angle))
}
