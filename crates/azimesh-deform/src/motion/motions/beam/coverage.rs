//! Checks that the stations of a table match the blade: the unit, and coverage of most of the span.

use crate::motion::table::{SpanHistory, Table};
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};

/// A table that covers less than this part of the blade's span is refused, unless its ends are held.
const LEAST: f64 = 0.9 - 1e-9;
/// A blade that extends past the ends of its table by more than this part of its span gives a note.
const BEYOND: f64 = 0.05;
/// Stations beyond this many times the farthest end of the blade are refused.
const FAR: f64 = 3.0;
/// A last station within these limits may be a fraction of the radius, ...
const FRACTIONS: [f64; 2] = [0.9, 1.02];
/// ... if the blade ends further out than the last station by more than this factor.
const APART: f64 = 1.1;

const IN_MESH_UNITS: &str = "stations are lengths from the hub in mesh units";
const OF_RADIUS: &str = "fractions of the radius need `units = { station = \"radius\" }`";

/// Refuses stations in another unit. With `hold_ends` false, refuses a table that covers too little of the blade,
/// which extends from `low` to `high`. Notes report where the end values are used beyond the table.
pub(super) fn check_span(
    span: &SpanHistory,
    table: &Table,
    body: &str,
    [low, high]: [f64; 2],
    hold_ends: bool,
) -> Result<Vec<Note>> {
    let (stations, path) = (span.stations(), table.path());
    let ends @ [first, last] = [stations[0], stations[stations.len() - 1]];
    let wrong =
        |at: usize, message: String| Err(Error::input(message).line(span.line(at)).file(path));
    if last < low || first > high {
        let nearest = if last < low { stations.len() - 1 } else { 0 };
        return wrong(nearest, off_blade(ends, body, [low, high]));
    }
    let farthest = low.abs().max(high.abs());
    let is_far = |station: &f64| station.abs() > FAR * farthest;
    let as_fractions = are_fractions(ends) && last > APART * farthest;
    if let Some(at) = stations
        .iter()
        .position(|r| is_far(r) || (as_fractions && *r == last))
    {
        return wrong(at, past_end(stations[at], body, [low, high]));
    }
    let covered = (last.min(high) - first.max(low)) / (high - low);
    let (before, after) = (first - low, high - last);
    if covered < LEAST && !hold_ends {
        let at = if before > after {
            0
        } else {
            stations.len() - 1
        };
        return wrong(at, too_short(ends, body, [low, high], covered));
    }
    let told = [(before, low, first), (after, last, high)];
    let told = told
        .into_iter()
        .filter(|(beyond, ..)| *beyond > BEYOND * (high - low));
    let notes = told.map(|(_, from, to)| {
        note!(
            "no_stations",
            "body \"{body}\": {} has no stations between {} and {}; the values of its {} station are used there",
            path.display(),
            short(from),
            short(to),
            if from == low { "first" } else { "last" }
        )
    });
    Ok(notes.collect())
}

/// Returns whether stations with these ends are fractions of a radius.
fn are_fractions([first, last]: [f64; 2]) -> bool {
    let [least, most] = FRACTIONS;
    first >= 0.0 && (least..=most).contains(&last)
}

/// Returns whether stations with these ends are fractions of the radius, and not lengths along a blade that ends at `high`.
pub(super) fn are_of_radius(ends: [f64; 2], high: f64) -> bool {
    are_fractions(ends) && !(ends[1] / APART..=ends[1] * APART).contains(&high)
}

fn goes(body: &str, [low, high]: [f64; 2]) -> String {
    format!(
        "body \"{body}\" goes from {} to {} along its span",
        short(low),
        short(high)
    )
}

/// Returns the error message for stations that are all outside the blade.
pub(super) fn off_blade([first, last]: [f64; 2], body: &str, span: [f64; 2]) -> String {
    let remedy = if are_fractions([first, last]) {
        format!("{IN_MESH_UNITS}; {OF_RADIUS}")
    } else {
        IN_MESH_UNITS.to_owned()
    };
    format!(
        "the stations go from {first} to {last}, but {}; {remedy}",
        goes(body, span)
    )
}

/// Returns the error message for a station far past the end of the blade.
fn past_end(station: f64, body: &str, span: [f64; 2]) -> String {
    format!(
        "station {} is far past the end of the blade: {}; {IN_MESH_UNITS}; {OF_RADIUS}, and a table of this blade ends at \
         its tip",
        short(station),
        goes(body, span)
    )
}

/// Returns the error message for a table that covers too little of the blade.
fn too_short([first, last]: [f64; 2], body: &str, span: [f64; 2], covered: f64) -> String {
    let fractions = if are_of_radius([first, last], span[1]) {
        format!("; {OF_RADIUS}")
    } else {
        String::new()
    };
    format!(
        "the stations go from {} to {}, which is {:.0}% of the blade: {}; {IN_MESH_UNITS}{fractions}; with `hold_ends = true` \
         the values of the first and the last station hold for the rest of the blade",
        short(first),
        short(last),
        (100.0 * covered).floor(),
        goes(body, span)
    )
}
