//! A Fourier series of the azimuth: a mean and its harmonics.

use crate::motion::keys::{Kind, object};
use crate::motion::places::Places;
use crate::motion::reader::Entry;
use azimesh_core::error::Result;
use serde_json::{Value, json};

/// Largest number of harmonics of a series.
pub(super) const MOST_HARMONICS: usize = 1000;

/// A mean and any number of harmonics, in radians.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::motion) struct Series {
    /// Collective or coning.
    pub mean: f64,
    /// First, second, ... harmonic.
    pub harmonics: Vec<Harmonic>,
    /// The number of an invalid harmonic.
    pub(super) wrong: Option<usize>,
}

/// One harmonic, in radians.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::motion) struct Harmonic {
    /// Factor of `sin(m psi + phase)`.
    pub sin: f64,
    /// Factor of `cos(m psi + phase)`.
    pub cos: f64,
}

impl Series {
    /// `mean + sum_m [ A_m sin(m psi + phase) + B_m cos(m psi + phase) ]`, all in radians.
    pub fn at(&self, psi: f64, phase: f64) -> f64 {
        let mut sum = self.mean;
        for (i, harmonic) in self.harmonics.iter().enumerate() {
            let (sin, cos) = ((i + 1) as f64 * psi + phase).sin_cos();
            sum += harmonic.sin * sin + harmonic.cos * cos;
        }
        sum
    }

    /// Returns the derivative of [`at`](Self::at) with respect to `psi`.
    pub fn slope(&self, psi: f64, phase: f64) -> f64 {
        let mut sum = 0.0;
        for (i, harmonic) in self.harmonics.iter().enumerate() {
            let m = (i + 1) as f64;
            let (sin, cos) = (m * psi + phase).sin_cos();
            sum += m * (harmonic.sin * cos - harmonic.cos * sin);
        }
        sum
    }

    /// Returns an upper bound of the magnitude of the angle at any azimuth.
    pub fn bound(&self) -> f64 {
        let sizes = (self.harmonics.iter()).map(|harmonic| harmonic.sin.hypot(harmonic.cos));
        self.mean.abs() + sizes.sum::<f64>()
    }

    /// Sets harmonic `m`, counted from 1, in degrees.
    pub(super) fn set_deg(&mut self, m: usize, sin: f64, cos: f64) {
        let [sin, cos] = [sin, cos].map(f64::to_radians);
        self.set(m, Harmonic { sin, cos });
    }

    /// Sets harmonic `m`, counted from 1.
    pub(super) fn set(&mut self, m: usize, harmonic: Harmonic) {
        if !(1..=MOST_HARMONICS).contains(&m) {
            self.wrong = Some(m);
            return;
        }
        let n = self.harmonics.len().max(m);
        self.harmonics.resize(n, Harmonic::default());
        self.harmonics[m - 1] = harmonic;
    }

    /// Refuses invalid numbers; `name` is its name in messages, `key` its key.
    pub(super) fn check(&self, places: &Places, key: &str, name: &str) -> Result<()> {
        if let Some(m) = self.wrong {
            let message =
                format!("the {name} has a harmonic {m}; harmonics go from 1 to {MOST_HARMONICS}");
            return Err(places.error(key, message));
        }
        let harmonics = self.harmonics.iter();
        let angles = harmonics.flat_map(|harmonic| [harmonic.sin, harmonic.cos]);
        let mut angles = angles.chain([self.mean]);
        angles.try_for_each(|angle| places.angle(key, angle))
    }

    /// Returns whether the angle is zero at every azimuth.
    pub(super) fn is_zero(&self) -> bool {
        let still = |harmonic: &Harmonic| harmonic.sin == 0.0 && harmonic.cos == 0.0;
        self.mean == 0.0 && self.harmonics.iter().all(still)
    }
}

/// Harmonics of an angle.
pub(super) const ANGLES: Kind<Vec<Harmonic>> = Kind {
    words: "array of `{ sin, cos }`, angles",
    read: |entry| read(entry, |entry| entry.angle()),
    schema,
};

/// Harmonics of a factor.
pub(super) const FACTORS: Kind<Vec<Harmonic>> = Kind {
    words: "array of `{ sin, cos }`",
    read: |entry| read(entry, |entry| entry.number()),
    schema,
};

fn read(entry: &Entry<'_>, number: fn(&Entry<'_>) -> Result<f64>) -> Result<Vec<Harmonic>> {
    let read = |element: &Entry<'_>| {
        let section = element.section("a harmonic { sin, cos }", &["sin", "cos"])?;
        let [sin, cos] = ["sin", "cos"].map(|key| section.optional(key, number));
        let (sin, cos) = (sin?.unwrap_or(0.0), cos?.unwrap_or(0.0));
        Ok(Harmonic { sin, cos })
    };
    let elements = entry.elements("harmonics such as { sin = -7.65, cos = -0.96 }")?;
    elements.iter().map(read).collect()
}

fn schema() -> Value {
    let number = |key: &str| (key.to_owned(), json!({ "type": "number", "default": 0 }));
    let harmonic = object(["sin", "cos"].map(number).into_iter().collect(), Vec::new());
    json!({ "type": "array", "items": harmonic })
}
