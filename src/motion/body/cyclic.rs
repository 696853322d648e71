//! `[body.cyclic]`: pitch, flap and lag as harmonics of the azimuth.

use crate::error::Result;
use crate::motion::reader::{AngleUnit, Entry, Keys};

const CYCLIC: Keys = Keys {
    known: &[
        "collective",
        "pitch",
        "coning",
        "flap",
        "lag",
        "phase",
        "pitch_axis",
        "flap_hinge",
    ],
    later: &[],
};
const HARMONIC: Keys = Keys {
    known: &["sin", "cos"],
    later: &[],
};

/// Cyclic motion (eq. 11 of the method), in radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Cyclic {
    /// Collective and harmonics of the pitch angle.
    pub pitch: Series,
    /// Coning and harmonics of the flap angle.
    pub flap: Series,
    /// Harmonics of the lag angle.
    pub lag: Series,
    /// Added to every harmonic's argument, in radians.
    pub phase: f64,
    /// Chordwise and shaftwise offset of the pitch axis at the hub, in mesh units.
    pub pitch_axis: [f64; 2],
    /// Spanwise offset of the flap and lag hinge, in mesh units.
    pub flap_hinge: f64,
    /// Line of the first key that leaves the plane of a 2D mesh.
    pub(in crate::motion) out_of_plane: Option<u64>,
}

/// A mean and any number of harmonics, in radians.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Collective or coning.
    pub mean: f64,
    /// First, second, ... harmonic.
    pub harmonics: Vec<Harmonic>,
}

/// One harmonic, in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
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

    /// The derivative of [`at`](Self::at) by `psi`.
    pub fn slope(&self, psi: f64, phase: f64) -> f64 {
        let mut sum = 0.0;
        for (i, harmonic) in self.harmonics.iter().enumerate() {
            let m = (i + 1) as f64;
            let (sin, cos) = (m * psi + phase).sin_cos();
            sum += m * (harmonic.sin * cos - harmonic.cos * sin);
        }
        sum
    }

    /// Not below the size of the angle at any azimuth.
    pub fn bound(&self) -> f64 {
        let harmonics = self.harmonics.iter();
        let sizes = harmonics.map(|harmonic| harmonic.sin.hypot(harmonic.cos));
        self.mean.abs() + sizes.sum::<f64>()
    }

    fn is_zero(&self) -> bool {
        let still = |harmonic: &Harmonic| harmonic.sin == 0.0 && harmonic.cos == 0.0;
        self.mean == 0.0 && self.harmonics.iter().all(still)
    }
}

impl Cyclic {
    pub(super) fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.cyclic]", &CYCLIC)?;
        let angle = |key: &str| section.get(key).map_or(Ok(0.0), |entry| entry.angle(unit));
        let harmonics = |key: &str| match section.get(key) {
            Some(entry) => read_harmonics(&entry, unit),
            None => Ok(Vec::new()),
        };
        let pitch_axis = match section.get("pitch_axis") {
            Some(entry) => entry.numbers()?,
            None => [0.0; 2],
        };
        let flap_hinge = match section.get("flap_hinge") {
            Some(entry) => entry.number()?,
            None => 0.0,
        };
        let mut cyclic = Self {
            pitch: Series {
                mean: angle("collective")?,
                harmonics: harmonics("pitch")?,
            },
            flap: Series {
                mean: angle("coning")?,
                harmonics: harmonics("flap")?,
            },
            lag: Series {
                mean: 0.0,
                harmonics: harmonics("lag")?,
            },
            phase: angle("phase")?,
            pitch_axis,
            flap_hinge,
            out_of_plane: None,
        };
        if !(cyclic.flap.is_zero() && cyclic.lag.is_zero()) {
            let lines =
                ["coning", "flap", "lag"].map(|key| section.get(key).map(|entry| entry.line()));
            cyclic.out_of_plane = lines.into_iter().flatten().min();
        }
        Ok(cyclic)
    }
}

fn read_harmonics(entry: &Entry<'_>, unit: AngleUnit) -> Result<Vec<Harmonic>> {
    let read = |element: &Entry<'_>| {
        let section = element.section("a harmonic { sin, cos }", &HARMONIC)?;
        let angle = |key: &str| section.get(key).map_or(Ok(0.0), |entry| entry.angle(unit));
        Ok(Harmonic {
            sin: angle("sin")?,
            cos: angle("cos")?,
        })
    };
    let elements = entry.elements("harmonics such as { sin = -7.65, cos = -0.96 }")?;
    elements.iter().map(read).collect()
}
