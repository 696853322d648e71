//! `[body.rigid]`: a rotation, then a translation: constant, oscillating, or growing linearly over the steps.

use super::link::{Link, RigidLink};
use super::oscillation::{Oscillation, Swing};
use super::series::{ANGLES, FACTORS, Harmonic};
use super::{At, AxisRotation, BodyMotion, OnMesh, ResolvedMotion, Rotation, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{
    Keys, Kind, angle, boolean, choice, direction, keys, numbers, positive, string, table,
};
use crate::motion::setters::setters;
use crate::motion::steps::Step;
use crate::motion::table::Interpolation;
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, scale};
use serde_json::json;
use std::sync::Arc;

/// A translation, in mesh units: constant, or oscillating along a vector.
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
    /// Factor of the vector; its mean is 1 without harmonics, else 0.
    factor: Oscillation,
}

impl Translation {
    /// Creates a translation by a vector, in mesh units.
    pub fn new(by: Vector) -> Self {
        let mut factor = Oscillation::default();
        factor.series.mean = 1.0;
        Self { by, factor }
    }

    /// The sum of the harmonics is the factor.
    fn swinging(mut self) -> Self {
        if !self.factor.series.harmonics.is_empty() {
            self.factor.series.mean = 0.0;
        }
        self
    }
}

setters! { Translation {
    /// Sets harmonic `m`, from 1, of the factor of the vector, which is then the sum of its harmonics: `sin` and `cos`
    /// are parts of the vector.
    harmonic(m: usize, sin: f64, cos: f64) |self| {
        self.factor.series.set(m, Harmonic { sin, cos });
        self = self.swinging();
    };
    /// Sets the frequency of the first harmonic in Hz, for steps in time; by default it follows the azimuth.
    frequency_hz(frequency: f64) |self| self.factor.frequency = Some(frequency);
} }

/// A rotation about an axis, then a translation.
#[derive(Debug, Clone, Default)]
pub(in crate::motion) struct Rigid {
    pub rotate: Option<AxisRotation>,
    pub translate: Option<Translation>,
    /// Grows from zero at the first step to the full motion at the last.
    pub ramp: bool,
}

keys! { impl Rigid "[body.rigid]" = Self::default(), {
    /// right-handed about an axis
    rotate => rotate, ROTATION, or "none";
    /// along a vector
    translate => translate, TRANSLATION, or "`[0, 0, 0]`";
    /// `true`: angle and translation times `k / (K - 1)` at step `k` of `K` steps, counted from 0, whatever the times or azimuths are; the full motion in a schedule of one step. `false`: the full motion at every step
    ramp => ramp, boolean(), default false;
} }

keys! { impl AxisRotation "rotate = { axis, origin, angle }" = Self::new([0.0; 3]), {
    /// its direction; it stays in the mesh while the body turns
    axis => axis, direction(), needed "axis = [0.0, 0.0, 1.0]";
    /// a point of the axis
    origin => origin, numbers::<3>("3 lengths"), default [0, 0, 0];
    /// the mean; required without `harmonics` and `table`
    angle => angle.series.mean, angle(), default 0;
    /// added: `sum_m [ sin_m sin(m psi) + cos_m cos(m psi) ]`, with the azimuth `psi` of the body (`azimuth_offset` included)
    harmonics => angle.series.harmonics, ANGLES, default [];
    /// of the first harmonic: `psi` is then 360 degrees x frequency x time, without offset. Steps need times: `[time]`, or `rpm`
    frequency => angle.frequency, positive("Hz"), or "none";
    /// added: `angle_deg` (or `angle_rad`) over `azimuth_deg`, `time_s` or `step`
    table => angle.table, string::<TableSource>(), or "none";
    /// between rows of the table
    interpolation => angle.interpolation, choice::<Interpolation>(), default "linear", with table;
} }

keys! { impl Translation "translate = { vector, harmonics }" = Self::new([0.0; 3]), {
    /// in mesh units
    vector => by, numbers::<3>("3 lengths"), needed "vector = [0.0, 0.0, 0.1]";
    /// the vector times `sum_m [ sin_m sin(m psi) + cos_m cos(m psi) ]`; without harmonics it is the vector itself
    harmonics => factor.series.harmonics, FACTORS, default [];
    /// as for `rotate`
    frequency => factor.frequency, positive("Hz"), or "none";
} }

const ROTATION: Kind<AxisRotation> = Kind {
    read: |entry| {
        let rotation = AxisRotation::read(entry)?;
        if rotation.angle.is_zero() {
            AxisRotation::section(entry)?.require("angle", "angle = 20.0")?;
        }
        Ok(rotation)
    },
    ..table::<AxisRotation>()
};

/// A vector, or a table.
const TRANSLATION: Kind<Translation> = Kind {
    words: "3 lengths, or a table, below",
    read: |entry| {
        if entry.is_table() {
            Translation::read(entry).map(Translation::swinging)
        } else {
            entry.numbers().map(Translation::new)
        }
    },
    schema: || json!({ "anyOf": [(numbers::<3>("").schema)(), Translation::schema()] }),
};

impl BodyMotion for Rigid {
    fn files(&self) -> Vec<&TableSource> {
        let rotations = self.rotate.iter();
        rotations.flat_map(|turn| &turn.angle.table).collect()
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
    /// The oscillations with their keys.
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
    /// The vector, and its factor.
    translate: Option<(Vector, Swing)>,
    ramp: bool,
    notes: Vec<Note>,
}

impl ResolvedMotion for RigidMotion {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let reached = self.reached(at.step, at.clock.steps.len());
        let growth = if self.ramp {
            at.clock.steps_a_second(at.step) / n_intervals(at.clock.steps.len())
        } else {
            0.0
        };
        // Scales the value at a step by `part`; the rate is that of the whole.
        let of = |swing: &Swing| {
            let [value, rate] = swing.at(at);
            [at.part * reached * value, growth * value + reached * rate]
        };
        let rotation = self
            .rotate
            .as_ref()
            .map(|(rotation, swing)| Rotation::about(rotation.axis, rotation.origin, of(swing)));
        let translation = self.translate.as_ref();
        let by = translation.map_or([[0.0; 3]; 2], |(by, swing)| {
            of(swing).map(|factor| scale(*by, factor))
        });
        Some(Link::Rigid(RigidLink {
            rotations: rotation.into_iter().collect(),
            translation: Some(by),
        }))
    }

    fn axis_angle(&self, at: &At<'_>) -> Option<f64> {
        let reached = at.part * self.reached(at.step, at.clock.steps.len());
        let (_, swing) = self.rotate.as_ref()?;
        Some(reached * swing.at(at)[0])
    }

    fn notes(&self) -> &[Note] {
        &self.notes
    }

    fn centre(&self) -> Option<Vector> {
        let turns = |(rotation, _): &&(AxisRotation, Swing)| !rotation.angle.is_zero();
        let turning = self.rotate.as_ref().filter(turns);
        turning.map(|(rotation, _)| rotation.origin)
    }
}

impl RigidMotion {
    /// Returns the part of the motion at a step: a ramp grows from 0 at the first step to 1 at the last. It is 1
    /// if there is only one step.
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
