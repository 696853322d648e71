//! `[body.rigid]`: a rotation, then a translation: constant, swinging, or growing linearly over the steps.

use super::link::{Link, RigidLink};
use super::oscillation::{Oscillation, Swing};
use super::series::Harmonic;
use super::{
    At, AxisRotation, BodyMotion, FromSchedule, OnMesh, ResolvedMotion, Rotation, TableSource,
    read_interpolation,
};
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use crate::motion::setters::setters;
use crate::motion::steps::Step;
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, scale};
use std::sync::Arc;

/// A translation, in mesh units: one that stays, or one that swings along a vector.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Translation};
///
/// let store = Body::new("store", ["store"]).translate(Translation::new([0.0, 0.0, -0.5])).ramp();
///
/// // 0.1 up and down with the azimuth of the body: 0.1 cos(psi).
/// let heave = Translation::new([0.0, 0.0, 0.1]).harmonic(1, 0.0, 1.0);
/// let foil = Body::new("foil", ["foil"]).translate(heave);
/// ```
#[derive(Debug, Clone)]
pub struct Translation {
    pub(in crate::motion) by: Vector,
    /// What the vector is multiplied with; its mean is 1 where it has no harmonics, else 0.
    factor: Oscillation,
}

impl Translation {
    /// By a vector, in mesh units.
    pub fn new(by: Vector) -> Self {
        let mut factor = Oscillation::default();
        factor.series.mean = 1.0;
        Self { by, factor }
    }

    /// The factor is the sum of the harmonics alone.
    fn swinging(mut self) -> Self {
        if !self.factor.series.harmonics.is_empty() {
            self.factor.series.mean = 0.0;
        }
        self
    }
}

setters! { Translation {
    /// Harmonic `m`, from 1 on, of the factor that the vector is multiplied with, which is then the sum of its
    /// harmonics: `sin` and `cos` are parts of the vector.
    harmonic(m: usize, sin: f64, cos: f64) |self| {
        self.factor.series.set(m, Harmonic { sin, cos });
        self = self.swinging();
    };
    /// How often the first harmonic swings, in Hz, for steps in time; with the azimuth unless it is set.
    frequency_hz(frequency: f64) |self| self.factor.frequency = Some(frequency);
} }

/// A rotation about an axis, then a translation.
#[derive(Debug, Clone, Default)]
pub(in crate::motion) struct Rigid {
    pub rotate: Option<AxisRotation>,
    pub translate: Option<Translation>,
    /// From nothing at the first step to the whole at the last.
    pub ramp: bool,
}

impl FromSchedule for Rigid {
    const KEY: &'static str = "rigid";

    fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.rigid]", &["rotate", "translate", "ramp"])?;
        Ok(Self {
            rotate: section.optional("rotate", |entry| read_rotation(entry, unit))?,
            translate: section.optional("translate", read_translation)?,
            ramp: section.optional("ramp", Entry::boolean)?.unwrap_or(false),
        })
    }
}

fn read_rotation(entry: &Entry<'_>, unit: AngleUnit) -> Result<AxisRotation> {
    let keys = [
        "axis",
        "origin",
        "angle",
        "harmonics",
        "frequency",
        "table",
        "interpolation",
    ];
    let section = entry.section("rotate = { axis, origin, angle }", &keys)?;
    let axis = section.require("axis", "axis = [0.0, 0.0, 1.0]")?;
    let mut rotation = AxisRotation::new(axis.numbers()?);
    section.set("origin", &mut rotation.origin, Entry::numbers)?;
    let angle = &mut rotation.angle;
    section.set("harmonics", &mut angle.series.harmonics, |entry| {
        Harmonic::read_all(entry, |entry| entry.angle(unit))
    })?;
    angle.frequency = section.optional("frequency", Entry::positive)?;
    let table = section.optional("table", Entry::string)?;
    angle.table = table.map(TableSource::from);
    angle.interpolation = read_interpolation(&section, "interpolation")?;
    if let (Some(entry), None) = (section.get("interpolation"), &angle.table) {
        return Err(entry.error("is that of `table`, which is not given"));
    }
    angle.series.mean = match section.optional("angle", |entry| entry.angle(unit))? {
        None if angle.is_zero() => section.require("angle", "angle = 20.0")?.angle(unit)?,
        found => found.unwrap_or(0.0),
    };
    Ok(rotation)
}

/// A vector, or `{ vector, harmonics, frequency }`.
fn read_translation(entry: &Entry<'_>) -> Result<Translation> {
    if !entry.is_table() {
        return entry.numbers().map(Translation::new);
    }
    let keys = ["vector", "harmonics", "frequency"];
    let section = entry.section("translate = { vector, harmonics }", &keys)?;
    let vector = section.require("vector", "vector = [0.0, 0.0, 0.1]")?;
    let mut translation = Translation::new(vector.numbers()?);
    let factor = &mut translation.factor;
    section.set("harmonics", &mut factor.series.harmonics, |entry| {
        Harmonic::read_all(entry, |entry| entry.number())
    })?;
    factor.frequency = section.optional("frequency", Entry::positive)?;
    Ok(translation.swinging())
}

impl BodyMotion for Rigid {
    fn order(&self) -> u8 {
        3
    }

    fn files(&self) -> Vec<&str> {
        let file = self.rotate.as_ref().and_then(|turn| turn.angle.file());
        file.into_iter().collect()
    }

    fn has_harmonics(&self) -> bool {
        self.oscillations()
            .any(|(_, swings)| swings.has_harmonics())
    }

    fn check(&self, body: &Body) -> Result<()> {
        let places = &body.places;
        if self.rotate.is_none() && self.translate.is_none() {
            let message = "[body.rigid] has neither `rotate` nor `translate`; give one of them";
            return Err(places.error("rigid", message));
        }
        if let Some(rotation) = &self.rotate {
            places.direction("rigid.rotate.axis", rotation.axis)?;
            places.finite("rigid.rotate.origin", &rotation.origin)?;
            let series = &rotation.angle.series;
            series.check(places, "rigid.rotate.angle", "rotation")?;
        }
        if let Some(translation) = &self.translate {
            places.finite("rigid.translate", &translation.by)?;
            let series = &translation.factor.series;
            series.check(places, "rigid.translate.harmonics", "translation")?;
        }
        let mut oscillations = self.oscillations();
        oscillations.try_for_each(|(key, swings)| swings.check(places, key))
    }

    fn check_plane(&self, body: &Body, _: bool) -> Result<()> {
        let axis = self.rotate.as_ref().map(|rotation| rotation.axis);
        let tilts = axis.is_some_and(|axis| (axis[0], axis[1]) != (0.0, 0.0));
        let lifts = (self.translate.as_ref()).is_some_and(|translation| translation.by[2] != 0.0);
        let keys = [("rigid.rotate", tilts), ("rigid.translate", lifts)];
        let leaves = keys.iter().filter(|(_, leaves)| *leaves);
        let leaves: Vec<&str> = leaves.map(|(key, _)| *key).collect();
        if leaves.is_empty() {
            return Ok(());
        }
        let message = format!(
            "body \"{}\" leaves the plane of the 2D mesh; turn it about [0, 0, 1] and translate it in x and y",
            body.name
        );
        Err(Error::input(message).at(body.places.first_of(&leaves)))
    }

    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let turns = |rotation: &AxisRotation| {
            let angle = rotation.angle.resolve(on, "rigid.rotate")?;
            Ok((rotation.clone(), angle))
        };
        let moves = |translation: &Translation| {
            let factor = translation.factor.resolve(on, "rigid.translate")?;
            Ok((translation.by, factor))
        };
        let rotate: Result<Option<_>> = self.rotate.as_ref().map(turns).transpose();
        let translate: Result<Option<_>> = self.translate.as_ref().map(moves).transpose();
        let rotate = rotate?;
        Ok(Arc::new(RigidMotion {
            notes: rotate
                .iter()
                .filter_map(|(_, angle)| angle.note())
                .collect(),
            rotate,
            translate: translate?,
            ramp: self.ramp,
        }))
    }
}

impl Rigid {
    /// What may swing, with its key.
    fn oscillations(&self) -> impl Iterator<Item = (&'static str, &Oscillation)> {
        let rotate = self
            .rotate
            .as_ref()
            .map(|turn| ("rigid.rotate", &turn.angle));
        let translate = self.translate.as_ref();
        let translate = translate.map(|translation| ("rigid.translate", &translation.factor));
        rotate.into_iter().chain(translate)
    }
}

/// A rigid motion on the steps of a schedule.
#[derive(Debug)]
struct RigidMotion {
    rotate: Option<(AxisRotation, Swing)>,
    /// The vector, and what it is multiplied with.
    translate: Option<(Vector, Swing)>,
    ramp: bool,
    notes: Vec<Diagnostic>,
}

impl ResolvedMotion for RigidMotion {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let reached = self.reached(at.step, at.clock.steps.len());
        let growth = if self.ramp {
            at.clock.steps_a_second(at.step) / n_intervals(at.clock.steps.len())
        } else {
            0.0
        };
        // A part of the value of a step, and the rate of the whole of it.
        let of = |swing: &Swing| {
            let [value, rate] = swing.at(at);
            [at.part * reached * value, growth * value + reached * rate]
        };
        let rotation = self.rotate.as_ref().map(|(rotation, swing)| {
            let [angle, rate] = of(swing);
            Rotation {
                axis: rotation.axis,
                origin: rotation.origin,
                angle,
                rate,
            }
        });
        let translation = self.translate.as_ref();
        let by = translation.map_or([[0.0; 3]; 2], |(by, swing)| {
            of(swing).map(|factor| scale(*by, factor))
        });
        Some(Link::Rigid(RigidLink {
            rotations: rotation.into_iter().collect(),
            translation: Some(by),
        }))
    }

    fn notes(&self) -> &[Diagnostic] {
        &self.notes
    }

    fn centre(&self) -> Option<Vector> {
        let turns = |(rotation, _): &&(AxisRotation, Swing)| !rotation.angle.is_zero();
        let turning = self.rotate.as_ref().filter(turns);
        turning.map(|(rotation, _)| rotation.origin)
    }
}

impl RigidMotion {
    /// How much of the motion a step has: a ramp goes from 0 at the first step to 1 at the last. It is 1
    /// when there is one step.
    fn reached(&self, step: &Step, n_steps: usize) -> f64 {
        if self.ramp && n_steps > 1 {
            step.index as f64 / n_intervals(n_steps)
        } else {
            1.0
        }
    }
}

fn n_intervals(n_steps: usize) -> f64 {
    n_steps.saturating_sub(1).max(1) as f64
}
