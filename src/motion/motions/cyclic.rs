//! `[body.cyclic]`: pitch, flap and lag as harmonics of the azimuth.

use super::link::{Link, RigidLink};
use super::series::{Harmonic, MOST_HARMONICS, Series};
use super::{At, AxisRotation, BodyMotion, FromSchedule, OnMesh, ResolvedMotion};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::motion::MotionNote;
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use crate::motion::rotor::RotorAxes;
use crate::motion::setters::setters;
use crate::motion::steps::Step;
use std::f64::consts::TAU;
use std::sync::Arc;

const CYCLIC: &[&str] = &[
    "collective",
    "pitch",
    "coning",
    "flap",
    "lag",
    "phase",
    "pitch_axis",
    "flap_hinge",
];

/// Cyclic motion of a blade (eq. 11 of the method): pitch, flap and lag as harmonics of the azimuth
/// `psi` of the blade,
///
/// ```text
/// pitch(psi) = collective + sum over m of [ A_m sin(m psi + phase) + B_m cos(m psi + phase) ]
/// ```
///
/// and likewise `flap` about its coning angle, and `lag`.
///
/// ```
/// use azimesh::{Body, Cyclic};
///
/// let cyclic = Cyclic::new()
///     .collective_deg(10.04)
///     .pitch_deg(1, -7.65, -0.96) // -7.65 sin psi - 0.96 cos psi
///     .coning_deg(2.6)
///     .flap_hinge(0.2);
/// let blade = Body::new("blade", ["blade"]).cyclic(cyclic);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Cyclic {
    /// Collective and harmonics of the pitch angle.
    pub(in crate::motion) pitch: Series,
    /// Coning and harmonics of the flap angle.
    pub(in crate::motion) flap: Series,
    /// Harmonics of the lag angle.
    pub(in crate::motion) lag: Series,
    /// Added to every harmonic's argument, in radians.
    pub(in crate::motion) phase: f64,
    /// Chordwise and shaftwise offset of the pitch axis at the hub, in mesh units.
    pub(in crate::motion) pitch_axis: [f64; 2],
    /// Spanwise offset of the flap and lag hinge, in mesh units.
    pub(in crate::motion) flap_hinge: f64,
}

impl Cyclic {
    /// No angle at any azimuth.
    pub fn new() -> Self {
        Self::default()
    }

    fn series(&self) -> [(&'static str, &Series); 3] {
        [
            ("pitch", &self.pitch),
            ("flap", &self.flap),
            ("lag", &self.lag),
        ]
    }
}

setters! { Cyclic {
    /// Mean of the pitch angle, in degrees.
    collective_deg(angle: f64) |self| self.pitch.mean = angle.to_radians();
    /// Harmonic `m` of the pitch angle, from 1 on: `sin` and `cos` in degrees.
    pitch_deg(m: usize, sin: f64, cos: f64) |self| self.pitch.set_deg(m, sin, cos);
    /// Mean of the flap angle, in degrees.
    coning_deg(angle: f64) |self| self.flap.mean = angle.to_radians();
    /// Harmonic `m` of the flap angle, from 1 on: `sin` and `cos` in degrees.
    flap_deg(m: usize, sin: f64, cos: f64) |self| self.flap.set_deg(m, sin, cos);
    /// Harmonic `m` of the lag angle, from 1 on: `sin` and `cos` in degrees.
    lag_deg(m: usize, sin: f64, cos: f64) |self| self.lag.set_deg(m, sin, cos);
    /// What is added to the argument of every harmonic, in degrees.
    phase_deg(phase: f64) |self| self.phase = phase.to_radians();
    /// Where the pitch axis, parallel to the span, passes the hub: chordwise and shaftwise, in mesh units.
    pitch_axis(chordwise: f64, shaftwise: f64) |self| self.pitch_axis = [chordwise, shaftwise];
    /// Spanwise distance of the flap and lag hinge from the hub, in mesh units.
    flap_hinge(spanwise: f64) |self| self.flap_hinge = spanwise;
} }

impl FromSchedule for Cyclic {
    const KEY: &'static str = "cyclic";

    fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.cyclic]", CYCLIC)?;
        let mut cyclic = Self::new();
        for (key, angle) in [
            ("collective", &mut cyclic.pitch.mean),
            ("coning", &mut cyclic.flap.mean),
            ("phase", &mut cyclic.phase),
        ] {
            section.set(key, angle, |entry| entry.angle(unit))?;
        }
        for (key, series) in [
            ("pitch", &mut cyclic.pitch),
            ("flap", &mut cyclic.flap),
            ("lag", &mut cyclic.lag),
        ] {
            let harmonics = &mut series.harmonics;
            section.set(key, harmonics, |entry| Harmonic::read_all(entry, unit))?;
        }
        section.set("pitch_axis", &mut cyclic.pitch_axis, Entry::numbers)?;
        section.set("flap_hinge", &mut cyclic.flap_hinge, Entry::number)?;
        Ok(cyclic)
    }
}

impl BodyMotion for Cyclic {
    fn order(&self) -> u8 {
        5
    }

    fn has_harmonics(&self) -> bool {
        let mut series = self.series().into_iter();
        series.any(|(_, series)| !series.harmonics.is_empty())
    }

    fn check(&self, body: &Body) -> Result<()> {
        for (name, series) in self.series() {
            let key = format!("cyclic.{name}");
            if let Some(m) = series.wrong {
                let message = format!(
                    "the {name} has a harmonic {m}; harmonics go from 1 to {MOST_HARMONICS}"
                );
                return Err(body.places.error(&key, message));
            }
            let harmonics = series.harmonics.iter();
            let angles = harmonics.flat_map(|harmonic| [harmonic.sin, harmonic.cos]);
            for angle in angles.chain([series.mean]) {
                body.places.angle(&key, angle)?;
            }
        }
        body.places.angle("cyclic.phase", self.phase)?;
        body.places.finite("cyclic.pitch_axis", &self.pitch_axis)?;
        body.places.finite("cyclic.flap_hinge", &[self.flap_hinge])
    }

    fn check_plane(&self, body: &Body) -> Result<()> {
        if self.flap.is_zero() && self.lag.is_zero() {
            return Ok(());
        }
        let keys = ["cyclic.coning", "cyclic.flap", "cyclic.lag"];
        let message = format!(
            "body \"{}\" flaps or lags, which needs a 3D mesh; in 2D a cyclic motion is pitch alone",
            body.name
        );
        Err(Error::input(message).at(body.places.first_of(&keys)))
    }

    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        Ok(Arc::new(Blade {
            hinges: Hinges {
                cyclic: self.clone(),
                blade: on.blade,
                offset: on.offset,
            },
            bends: on.body.bends(),
            warning: self.more_than_a_turn(&on.body.name),
        }))
    }
}

impl Cyclic {
    /// A note where pitch, flap or lag is more than a turn, which no blade does.
    fn more_than_a_turn(&self, body: &str) -> Option<Diagnostic> {
        let mut far = (self.series().into_iter()).filter(|(_, series)| series.bound() > TAU);
        let (angle, series) = far.next()?;
        let note = MotionNote::MoreThanATurn {
            body: body.to_owned(),
            angle,
            sum_deg: series.bound().to_degrees(),
        };
        Some(note.into())
    }
}

/// The cyclic motion of a blade on a mesh.
#[derive(Debug)]
struct Blade {
    hinges: Hinges,
    /// Whether the blade is a beam, which turns about its hinges itself.
    bends: bool,
    warning: Option<Diagnostic>,
}

/// Pitch, flap and lag of a blade.
#[derive(Debug, Clone)]
pub(super) struct Hinges {
    cyclic: Cyclic,
    blade: RotorAxes,
    offset: f64,
}

impl Hinges {
    /// Those of the blade of a body, where it has a cyclic motion.
    pub fn of(on: &OnMesh<'_>) -> Option<Self> {
        Some(Self {
            cyclic: on.body.motion::<Cyclic>()?.clone(),
            blade: on.blade,
            offset: on.offset,
        })
    }

    /// Equations 2 and 3 of the method without a beam, in the blade's own frame at its azimuth `psi`:
    ///
    /// ```text
    /// x_r = Rx(pitch) (x - x_ref),                 x_ref = O + r e_x + pitch_axis
    /// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x)
    /// ```
    ///
    /// Its rotations, pitch first. The pitch axis is parallel to the span, so that turning about it needs
    /// no station `r`.
    pub fn rotations(&self, at: &At<'_>) -> [AxisRotation; 3] {
        let (cyclic, blade) = (&self.cyclic, &self.blade);
        let (signs, psi) = (&blade.signs, at.step.azimuth + self.offset);
        let rate = at.clock.azimuth_rate.unwrap_or(0.0);
        let hinge = blade.point(cyclic.flap_hinge, 0.0, 0.0);
        let rotation = |axis, origin, series: &Series, sign: f64| AxisRotation {
            axis,
            origin,
            angle: sign * series.at(psi, cyclic.phase),
            rate: sign * series.slope(psi, cyclic.phase) * rate,
        };
        [
            rotation(blade.e_x, self.pitch_centre(), &cyclic.pitch, signs.pitch),
            rotation(blade.e_y, hinge, &cyclic.flap, -signs.flap),
            rotation(blade.e_z, hinge, &cyclic.lag, signs.lag),
        ]
    }

    /// The point of the pitch axis at the hub.
    fn pitch_centre(&self) -> Vector {
        let [chordwise, shaftwise] = self.cyclic.pitch_axis;
        self.blade.point(0.0, chordwise, shaftwise)
    }
}

impl ResolvedMotion for Blade {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let rotations = || {
            self.hinges
                .rotations(at)
                .map(|rotation| rotation.part(at.part))
        };
        (!self.bends).then(|| {
            Link::Rigid(RigidLink {
                rotations: rotations().to_vec(),
                translation: None,
            })
        })
    }

    fn centre(&self) -> Option<Vector> {
        Some(self.hinges.pitch_centre())
    }

    fn cyclic_angles(&self, step: &Step) -> Option<[f64; 3]> {
        let (cyclic, psi) = (&self.hinges.cyclic, step.azimuth + self.hinges.offset);
        Some(
            cyclic
                .series()
                .map(|(_, series)| series.at(psi, cyclic.phase)),
        )
    }

    fn warning(&self) -> Option<Diagnostic> {
        self.warning.clone()
    }
}
