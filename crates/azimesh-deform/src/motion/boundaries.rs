//! `[boundaries]`: boundary tags that belong to no body, and zones.

use super::names::Pattern;
use super::reader::Entry;
use azimesh_core::error::{Position, Result};

const BOUNDARIES: &[&str] = &["zones", "fixed", "slide", "free", "periodic", "others"];

/// What becomes of boundary tags that are not named anywhere.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Others, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).others(Others::Slide);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Others {
    /// They stay where they are.
    Fixed,
    /// They follow the interpolation like the inside of the mesh.
    Free,
    /// Their nodes move along the boundary and never leave it.
    Slide,
}

/// Two boundaries that are images of one another; their nodes move identically.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PeriodicPair {
    /// Tags of the one side.
    pub a: Pattern,
    /// Tags of the other side.
    pub b: Pattern,
    /// Where the schedule has it.
    pub(super) place: Option<Position>,
}

/// `[boundaries]`: which zones deform and what the boundaries that belong to no body do.
#[derive(Debug, Clone, Default)]
pub(super) struct Boundaries {
    /// Zones that deform; all when empty.
    pub zones: Vec<Pattern>,
    /// Tags that stay where they are.
    pub fixed: Vec<Pattern>,
    /// Tags whose nodes move along the boundary and never leave it.
    pub slide: Vec<Pattern>,
    /// Tags inside the mesh whose nodes follow the interpolation.
    pub free: Vec<Pattern>,
    /// Pairs of tags that are images of one another.
    pub periodic: Vec<PeriodicPair>,
    /// Tags not named anywhere; an error when left out and there are any.
    pub others: Option<Others>,
}

impl Boundaries {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[boundaries]", BOUNDARIES)?;
        let mut boundaries = Self::default();
        for (key, what, names) in [
            ("zones", "zones", &mut boundaries.zones),
            ("fixed", "tags", &mut boundaries.fixed),
            ("slide", "tags", &mut boundaries.slide),
            ("free", "tags", &mut boundaries.free),
        ] {
            let remedy = format!("name the {what}, or leave the key out");
            section.set(key, names, |entry| entry.patterns(&remedy))?;
        }
        section.set("periodic", &mut boundaries.periodic, read_pairs)?;
        let known = [
            ("fixed", Others::Fixed),
            ("free", Others::Free),
            ("slide", Others::Slide),
        ];
        boundaries.others = section.optional("others", |entry| entry.choice(&known))?;
        Ok(boundaries)
    }
}

fn read_pairs(entry: &Entry<'_>) -> Result<Vec<PeriodicPair>> {
    let elements = entry.elements("pairs such as { pair = [\"side_a\", \"side_b\"] }")?;
    if elements.is_empty() {
        return Err(entry.error("is empty; name the pairs, or leave the key out"));
    }
    elements.iter().map(read_pair).collect()
}

fn read_pair(element: &Entry<'_>) -> Result<PeriodicPair> {
    let section = element.section("{ pair = [\"side_a\", \"side_b\"] }", &["pair"])?;
    let pair = section.require("pair", "pair = [\"side_a\", \"side_b\"]")?;
    let sides = pair.elements("two strings")?;
    let [a, b] = &sides[..] else {
        let n = sides.len();
        return Err(pair.error(&format!("has {n} names; it must have 2, one for each side")));
    };
    Ok(PeriodicPair {
        a: a.pattern()?,
        b: b.pattern()?,
        place: Some(Position::Line(pair.line())),
    })
}
