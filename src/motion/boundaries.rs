//! What the schedule says of the boundaries that belong to no body, and of zones.

use super::body::{pattern, patterns};
use super::names::Pattern;
use super::reader::{Entry, Keys};
use crate::error::Result;

const BOUNDARIES: Keys = Keys {
    known: &["zones", "fixed", "slide", "periodic", "others"],
    later: &[],
};
const PERIODIC: Keys = Keys {
    known: &["pair"],
    later: &[],
};

/// What becomes of boundary tags that are not named anywhere.
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
pub struct PeriodicPair {
    /// Tags of the one side.
    pub a: Pattern,
    /// Tags of the other side.
    pub b: Pattern,
    /// Line in the schedule.
    pub line: u64,
}

/// `[boundaries]`: which zones deform and what the boundaries that belong to no body do.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Boundaries {
    /// Zones that deform; all when empty.
    pub zones: Vec<Pattern>,
    /// Tags that stay where they are.
    pub fixed: Vec<Pattern>,
    /// Tags whose nodes move along the boundary and never leave it.
    pub slide: Vec<Pattern>,
    /// Pairs of tags that are images of one another.
    pub periodic: Vec<PeriodicPair>,
    /// Tags not named anywhere; an error when left out and there are any.
    pub others: Option<Others>,
    pub(super) line: Option<u64>,
}

impl Boundaries {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[boundaries]", &BOUNDARIES)?;
        let names = |key: &str, what: &str| {
            let entry = section.get(key);
            entry.map_or(Ok(Vec::new()), |entry| patterns(&entry, what))
        };
        let periodic = section.get("periodic");
        let known = [
            ("fixed", Others::Fixed),
            ("free", Others::Free),
            ("slide", Others::Slide),
        ];
        let others = section.get("others");
        Ok(Self {
            zones: names("zones", "zones")?,
            fixed: names("fixed", "tags")?,
            slide: names("slide", "tags")?,
            periodic: periodic.map_or(Ok(Vec::new()), |entry| read_pairs(&entry))?,
            others: others.map(|entry| entry.choice(&known, &[])).transpose()?,
            line: Some(section.line),
        })
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
    let section = element.section("{ pair = [\"side_a\", \"side_b\"] }", &PERIODIC)?;
    let pair = section.require("pair", "pair = [\"side_a\", \"side_b\"]")?;
    let sides = pair.elements("two strings")?;
    let [a, b] = &sides[..] else {
        let n = sides.len();
        return Err(pair.error(&format!("has {n} names; it must have 2, one for each side")));
    };
    Ok(PeriodicPair {
        a: pattern(a)?,
        b: pattern(b)?,
        line: pair.line(),
    })
}
