//! `[boundaries]`: boundary tags that belong to no body, and zones.

use super::keys::{Kind, choice, keys, names, object, patterns};
use super::names::Pattern;
use super::reader::Entry;
use azimesh_core::error::{Position, Result};
use serde_json::json;

/// Treatment of boundary tags that the schedule does not name.
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
    /// Position in the schedule.
    pub(super) place: Option<Position>,
}

names! {
    Others { "fixed" => Fixed, "free" => Free, "slide" => Slide }
}

/// Pairs of sides.
const PAIRS: Kind<Vec<PeriodicPair>> = Kind {
    words: "array of `{ pair = [a, b] }`",
    read: read_pairs,
    schema: || {
        let sides = json!({ "type": "array", "items": { "type": "string", "minLength": 1 }, "minItems": 2, "maxItems": 2 });
        let pair = object(
            [("pair".to_owned(), sides)].into_iter().collect(),
            vec!["pair"],
        );
        json!({ "type": "array", "items": pair, "minItems": 1 })
    },
};

keys! {
    /// `[boundaries]`: which zones deform and what the boundaries that belong to no body do.
    #[derive(Debug, Clone)]
    pub(super) struct Boundaries "[boundaries]" {
        /// only these zones deform (globs as in `tags`); nodes that they share with other zones stay fixed
        pub zones: Vec<Pattern>, patterns(), or "all";
        /// boundary tags that do not move
        pub fixed: Vec<Pattern>, patterns(), or "none";
        /// boundary tags whose nodes move along the boundary and never leave it: symmetry planes, walls and outer edges
        /// next to a moving body. Nodes that a body shares with such a plane move with the body; a warning says if they
        /// leave the plane
        pub slide: Vec<Pattern>, patterns(), or "none";
        /// tags whose nodes follow the mesh around them: lines and surfaces inside the flow, such as a wake
        pub free: Vec<Pattern>, patterns(), or "none";
        /// pairs of boundaries that are images of one another by a translation or a rotation; paired nodes follow the
        /// mesh and move identically. A side is one name or glob and may stand for several tags
        pub periodic: Vec<PeriodicPair>, PAIRS, or "none";
        /// what the remaining tags do; `"free"` ones follow the mesh around them. Without this key, a tag that is named nowhere is
        /// an error
        pub others: Option<Others>, choice::<Others>(), or "none";
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
