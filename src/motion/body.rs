//! A moving body: its tags and its motions, read from `[[body]]`.

use super::names::Pattern;
use super::reader::{AngleUnit, Entry, Keys, NOT_YET};
use crate::error::Result;
use crate::geometry::Transform;
use crate::geometry::vector::{Vector, scale};

const MOTION_NOT_YET: &str = "motion is not available in this version; available: cyclic, rigid";
const BODY: Keys = Keys {
    known: &["name", "tags", "azimuth_offset", "cyclic", "rigid"],
    later: &[
        ("parent", NOT_YET),
        ("beam", MOTION_NOT_YET),
        ("table", MOTION_NOT_YET),
        ("modes", MOTION_NOT_YET),
        ("surface", MOTION_NOT_YET),
    ],
};
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
const RIGID: Keys = Keys {
    known: &["rotate", "translate", "ramp"],
    later: &[],
};
const ROTATE: Keys = Keys {
    known: &["axis", "origin", "angle"],
    later: &[],
};

/// A moving body. Its motions act in the order rigid, cyclic.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name, of its own among the bodies.
    pub name: String,
    /// Boundary tags that move with it.
    pub tags: Vec<Pattern>,
    /// Azimuth of its blade when the rotor's is zero, in radians.
    pub azimuth_offset: f64,
    /// Pitch, flap and lag as functions of the azimuth.
    pub cyclic: Option<Cyclic>,
    /// A rotation and a translation.
    pub rigid: Option<Rigid>,
    /// Line of its name.
    pub(super) line: u64,
}

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
    pub(super) out_of_plane: Option<u64>,
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

    fn is_zero(&self) -> bool {
        let still = |harmonic: &Harmonic| harmonic.sin == 0.0 && harmonic.cos == 0.0;
        self.mean == 0.0 && self.harmonics.iter().all(still)
    }
}

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
    pub(super) out_of_plane: Option<u64>,
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
}

impl Body {
    pub(super) fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[[body]]", &BODY)?;
        let name = section.require("name", "name = \"blade\"")?;
        let line = name.line();
        let name = name.string()?.to_owned();
        let tags = patterns(&section.require("tags", "tags = [\"blade\"]")?, "tags")?;
        let azimuth_offset = match section.get("azimuth_offset") {
            Some(offset) => offset.angle(unit)?,
            None => 0.0,
        };
        let cyclic = section
            .get("cyclic")
            .map(|entry| Cyclic::read(&entry, unit));
        let rigid = section.get("rigid").map(|entry| Rigid::read(&entry, unit));
        if cyclic.is_none() && rigid.is_none() {
            return Err(section.error(format!(
                "body \"{name}\" has no motion; give it [body.cyclic] or [body.rigid], or list its tags as `fixed`"
            )));
        }
        Ok(Self {
            name,
            tags,
            azimuth_offset,
            cyclic: cyclic.transpose()?,
            rigid: rigid.transpose()?,
            line,
        })
    }
}

/// A list of names or globs that is not empty.
pub(super) fn patterns(entry: &Entry<'_>, what: &str) -> Result<Vec<Pattern>> {
    let elements = entry.elements("strings")?;
    if elements.is_empty() {
        return Err(entry.error(&format!("is empty; name the {what}, or leave the key out")));
    }
    elements.iter().map(pattern).collect()
}

/// A name or a glob.
pub(super) fn pattern(element: &Entry<'_>) -> Result<Pattern> {
    Ok(Pattern {
        text: element.string()?.to_owned(),
        line: element.line(),
    })
}

impl Cyclic {
    fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
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

impl Rigid {
    fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
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
