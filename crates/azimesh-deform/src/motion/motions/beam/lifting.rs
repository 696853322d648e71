//! The line about which the sections of a blade turn: given as a table, or measured at a quarter of the chord of
//! the mesh.

use super::coverage::{are_of_radius, off_blade};
use crate::motion::motions::OnMesh;
use crate::motion::table::Table;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, add, distance, dot, sub, unit};
use azimesh_core::numbers::{self, in_digits, short};
use azimesh_core::{Note, note};
use serde::{Deserialize, Serialize};

/// A rounded end of a blade extends inwards by this part of the chord, half the thickness of a thick section, ...
const CAP: f64 = 0.1;
/// ... and by at least this part of the span; the chord is measured at `NEAR`.
const INSIDE: f64 = 1e-3;
const NEAR: f64 = 0.05;
/// A lifting line whose distance from the blade is more than this fraction of the blade's extent gives a warning.
const BESIDE: f64 = 0.5;
/// Extents that differ by less than this part are equally long.
const AS_LONG: f64 = 1e-6;
/// Chordwise position of the line, from the leading edge, as a fraction of the chord.
const CHORDWISE: f64 = 0.25;

/// The edges of a body's faces, with ends in the frame of its blade: span, chord and shaft coordinates from the hub.
pub(super) struct BladeEdges {
    edges: Vec<[Vector; 2]>,
    /// 1, or -1 if the leading edge is opposite to `e_y`.
    forward: f64,
}

/// Points in the frame of the blade, from the hub, over increasing stations. Past its ends the line continues
/// parallel to the span.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct LiftingLine {
    stations: Vec<f64>,
    points: Vec<Vector>,
}

impl LiftingLine {
    /// Reads the columns `station, x, y, z`; the blade extends from `span[0]` to `span[1]`.
    pub fn from_table(table: &Table, body: &str, span: [f64; 2]) -> Result<Self> {
        let mut columns = table.columns();
        let station = columns.require("station")?;
        let names = ["x", "y", "z"].map(|name| columns.require(name));
        let [x, y, z] = names;
        let axes = [x?, y?, z?];
        columns.done()?;
        let rows = 0..table.n_rows();
        let stations: Vec<f64> = rows.clone().map(|row| table.value(row, station)).collect();
        if let Some(row) = (1..stations.len()).find(|&row| stations[row] <= stations[row - 1]) {
            let message = format!(
                "station {} is not larger than station {} of line {}; `station` must increase from row to row",
                stations[row],
                stations[row - 1],
                table.line(row - 1)
            );
            return Err(table.error(row, message));
        }
        let ends @ [first, last] = [stations[0], stations[stations.len() - 1]];
        if last < span[0] || first > span[1] {
            let nearest = if last < span[0] {
                stations.len() - 1
            } else {
                0
            };
            return Err(table.error(nearest, off_blade(ends, body, span)));
        }
        let points = rows.map(|row| axes.map(|axis| table.value(row, axis)));
        let points: Vec<Vector> = points.collect();
        // A line parallel to the span does not depend on its stations.
        let is_bent = points.iter().any(|p| p[1..] != points[0][1..]);
        if is_bent && are_of_radius(ends, span[1]) {
            let message = format!(
                "the stations of the lifting line go from {first} to {last}, but body \"{body}\" ends at {} along its \
                 span; `station`, `x`, `y` and `z` are lengths from the hub in mesh units",
                short(span[1])
            );
            return Err(table.error(stations.len() - 1, message));
        }
        Ok(Self { points, stations })
    }

    /// Measures the line a quarter of the chord behind the leading edge, at some stations and inside the rounded ends
    /// of the blade, and extends it straight through these.
    /// The chord of a section is its longest extent; of several equally long ones, their mean. The leading edge is the
    /// end towards `e_y`, or the other end for a clockwise rotor.
    pub fn quarter_chord(blade: &BladeEdges, stations: &[f64], body: &str) -> Result<Self> {
        let [low, high] = blade.span();
        let length = high - low;
        let chords = |stations: &[f64]| -> Result<Vec<[Vector; 2]>> {
            let cuts = cuts(&blade.edges, stations);
            let chords = stations.iter().zip(&cuts).map(|(station, cut)| {
                let none = || no_chord(*station, body);
                chord(cut, blade.forward).ok_or_else(none)
            });
            chords.collect()
        };
        let near = chords(&[low + NEAR * length, high - NEAR * length])?;
        let depth = |[nose, tail]: &[Vector; 2]| {
            (CAP * distance(*nose, *tail)).clamp(INSIDE * length, 0.5 * NEAR * length)
        };
        let [root, tip] = [depth(&near[0]), depth(&near[1])];
        let (first, last) = (low + root, high - tip);
        let inside = stations.iter().copied().chain([first + root, last - tip]);
        let inside = inside.filter(|r| first < *r && *r < last);
        let mut stations: Vec<f64> = inside.chain([first, last]).collect();
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        let quarter = |[nose, tail]: [Vector; 2]| -> Vector {
            std::array::from_fn(|i| nose[i] + CHORDWISE * (tail[i] - nose[i]))
        };
        let chords = chords(&stations)?;
        let mut points: Vec<Vector> = chords.into_iter().map(quarter).collect();
        // Extends straight through the rounded ends, whose sections are not profiles.
        let of = |r: f64| stations.partition_point(|station| *station < r);
        let beyond = |at: usize, inner: usize| -> Vector {
            std::array::from_fn(|i| 2.0 * points[at][i] - points[inner][i])
        };
        let ends = [
            beyond(0, of(first + root)),
            beyond(points.len() - 1, of(last - tip)),
        ];
        points.insert(0, ends[0]);
        points.push(ends[1]);
        stations.insert(0, low);
        stations.push(high);
        Ok(Self { stations, points })
    }

    /// Returns a note if a point of the line, within the span of the blade, is far from the blade's box `bounds`.
    pub fn beside(&self, body: &str, bounds: &Bounds) -> Option<Note> {
        let across = (1..3).map(|i| bounds.high[i] - bounds.low[i]);
        let allowed = BESIDE * across.fold(0.0, f64::max);
        let (low, high) = (bounds.low[0], bounds.high[0]);
        let inside = self.stations.iter().filter(|r| (low..=high).contains(*r));
        let off = [low, high].into_iter().chain(inside.copied()).map(|r| {
            let x = self.at(r);
            (r, x, distance(x, bounds.nearest(&x)))
        });
        let (station, point, distance) =
            off.reduce(|most, next| if next.2 > most.2 { next } else { most })?;
        (distance > allowed).then(|| {
            note!(
                "line_beside",
                "body \"{body}\": the lifting line is at {} at station {}, {} from the blade, which is \
                 between {} and {}; give its points along the blade's axes from the hub",
                numbers::point(&point),
                short(station),
                in_digits(distance, 3),
                numbers::point(&bounds.low),
                numbers::point(&bounds.high)
            )
        })
    }

    /// Returns its first and last point.
    pub fn ends(&self) -> [Vector; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }

    /// Returns the point of a station.
    #[inline]
    pub fn at(&self, station: f64) -> Vector {
        let after = self.stations.partition_point(|r| *r <= station);
        if after == 0 || after == self.stations.len() {
            let end = after.saturating_sub(1);
            let [x, y, z] = self.points[end];
            return [x + station - self.stations[end], y, z];
        }
        let (r, p) = (&self.stations[after - 1..], &self.points[after - 1..]);
        let part = (station - r[0]) / (r[1] - r[0]);
        let between = |i: usize| p[0][i] + part * (p[1][i] - p[0][i]);
        [between(0), between(1), between(2)]
    }
}

/// Returns the points where the edges of a blade cross the given increasing stations.
fn cuts(edges: &[[Vector; 2]], stations: &[f64]) -> Vec<Vec<Vector>> {
    let mut cuts: Vec<Vec<Vector>> = vec![Vec::new(); stations.len()];
    for [a, b] in edges {
        let (a, b) = if a[0] <= b[0] { (a, b) } else { (b, a) };
        let from = stations.partition_point(|r| *r < a[0]);
        let to = stations.partition_point(|r| *r <= b[0]);
        for at in from..to {
            let part = match b[0] - a[0] {
                0.0 => 0.0,
                length => (stations[at] - a[0]) / length,
            };
            cuts[at].push(std::array::from_fn(|i| a[i] + part * (b[i] - a[i])));
        }
    }
    cuts
}

fn no_chord(station: f64, body: &str) -> Error {
    Error::input(format!(
        "body \"{body}\" has no faces at station {station}, so its quarter chord is unknown there; give \
         `lifting_line` a table  station,x,y,z"
    ))
}

impl BladeEdges {
    pub fn of(on: &OnMesh<'_>) -> Self {
        let mut edges = Vec::new();
        let faces = on.faces.cells.iter().zip(&on.faces.roles);
        for (&cell, _) in faces.filter(|(_, role)| **role == on.role) {
            let cell = on.boundary.face(cell as usize);
            let place = |at: usize| in_blade(on, on.boundary.position(cell.nodes[at]));
            let pairs = cell.kind.edges();
            let n = cell.nodes.len();
            if pairs.is_empty() {
                edges.extend((0..n).map(|at| [place(at), place((at + 1) % n)]));
            }
            edges.extend(pairs.iter().map(|pair| pair.map(|at| place(at.into()))));
        }
        Self {
            edges,
            forward: on.blade.signs.azimuth,
        }
    }

    /// Returns the box around the blade.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.edges.iter().flatten())
    }

    /// Returns the ends of the blade along its span.
    pub fn span(&self) -> [f64; 2] {
        let ends = self.edges.iter().flatten().map(|x| x[0]);
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
            [low.min(r), high.max(r)]
        })
    }
}

/// Returns the span, chord and shaft coordinates of a point from the hub.
fn in_blade(on: &OnMesh<'_>, x: Vector) -> Vector {
    let from_hub = sub(x, on.blade.hub);
    [on.blade.e_x, on.blade.e_y, on.blade.e_z].map(|axis| dot(axis, from_hub))
}

/// Returns the ends of the chord of a section, leading edge (towards `e_y` times `sign`) first. The search for the
/// longest extent goes from a point to the farthest one, and continues from there while the distance grows.
fn chord(cut: &[Vector], sign: f64) -> Option<[Vector; 2]> {
    let farthest = |from: &Vector| {
        let others = cut.iter();
        others.reduce(|best, x| {
            if distance(*x, *from) > distance(*best, *from) {
                x
            } else {
                best
            }
        })
    };
    let mut ends = [*cut.first()?, *farthest(cut.first()?)?];
    loop {
        let next = *farthest(&ends[1])?;
        if distance(next, ends[1]) <= distance(ends[0], ends[1]) {
            break;
        }
        ends = [ends[1], next];
    }
    middles(cut, forward(ends, sign), sign)
}

/// Orders the ends of an extent: the one towards `e_y` times `sign` first.
fn forward([a, b]: [Vector; 2], sign: f64) -> [Vector; 2] {
    if sign * a[1] >= sign * b[1] {
        [a, b]
    } else {
        [b, a]
    }
}

/// Returns the ends of the chord of a section; `ends` are a longest extent. A blunt section has several
/// longest extents, from corner to corner: the chord is along their mean, between the middles of the edges at both ends.
fn middles(cut: &[Vector], ends: [Vector; 2], sign: f64) -> Option<[Vector; 2]> {
    let least = (1.0 - AS_LONG) * distance(ends[0], ends[1]);
    let middle: Vector = std::array::from_fn(|i| 0.5 * (ends[0][i] + ends[1][i]));
    let from_middle = |x: &Vector| distance(*x, middle);
    let farthest = cut.iter().map(from_middle).fold(0.0, f64::max);
    // Other points are not ends of an equally long extent.
    let mut corners: Vec<Vector> = cut.to_vec();
    corners.retain(|x| from_middle(x) + farthest >= least);
    corners.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[2].total_cmp(&b[2])));
    corners.dedup();
    let pairs = (0..corners.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let pairs = pairs.map(|(i, j)| forward([corners[i], corners[j]], sign));
    let (mut n, mut along) = (0, [0.0; 3]);
    // A pair at right angles to the chord has no leading edge.
    let is_end =
        |[a, b]: &[Vector; 2]| distance(*a, *b) >= least && (a[1] - b[1]).abs() > AS_LONG * least;
    for [nose, tail] in pairs.filter(is_end) {
        n += 1;
        along = add(along, sub(nose, tail));
    }
    let Some(along) = unit(along).filter(|_| n > 1) else {
        return Some(ends);
    };
    let across = [0.0, -along[2], along[1]];
    let middle_of_edge = |sense: f64| {
        let height = |x: &&Vector| sense * dot(along, **x);
        let top = corners
            .iter()
            .map(|x| height(&x))
            .fold(f64::NEG_INFINITY, f64::max);
        let edge = || {
            corners
                .iter()
                .filter(|x| height(x) >= top - AS_LONG * least)
        };
        let side = |a: &&Vector, b: &&Vector| dot(across, **a).total_cmp(&dot(across, **b));
        let (a, b) = (edge().min_by(side)?, edge().max_by(side)?);
        Some(std::array::from_fn(|i| 0.5 * (a[i] + b[i])))
    };
    let found = [middle_of_edge(1.0)?, middle_of_edge(-1.0)?];
    // Copies of one point that differ by round-off do not form an edge.
    let is_same = |i: usize| distance(found[i], ends[i]) <= AS_LONG * least;
    Some(if is_same(0) && is_same(1) {
        ends
    } else {
        found
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(points: &[[f64; 2]]) -> Vec<Vector> {
        points.iter().map(|[y, z]| [2.0, *y, *z]).collect()
    }

    #[test]
    fn the_chord_of_a_blunt_section_is_between_the_middles_of_its_ends() {
        let corners = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]];
        let between = [[0.5, 0.1], [-0.5, 0.3], [0.2, 0.5], [0.0, -0.5]];
        let square = section(&[corners, between].concat());
        assert_eq!(
            chord(&square, 1.0),
            Some([[2.0, 0.5, 0.0], [2.0, -0.5, 0.0]])
        );
        assert_eq!(
            chord(&square, -1.0),
            Some([[2.0, -0.5, 0.0], [2.0, 0.5, 0.0]])
        );
        // A blunt trailing edge below a round nose.
        let blunt = section(&[
            [1.0, 0.0],
            [0.9, 0.06],
            [0.9, -0.06],
            [0.0, 0.01],
            [0.0, -0.01],
        ]);
        assert_eq!(chord(&blunt, 1.0), Some([[2.0, 1.0, 0.0], [2.0, 0.0, 0.0]]));
    }

    #[test]
    fn one_longest_extent_is_the_chord_to_the_last_bit() {
        let sharp = section(&[[1.0, 0.1], [0.7, 0.2], [0.6, -0.1], [0.0, -0.03]]);
        assert_eq!(chord(&sharp, 1.0), Some([sharp[0], sharp[3]]));
        let mut again = sharp.clone();
        again.push([2.0, 1.0 + f64::EPSILON, 0.1]);
        let found = chord(&again, 1.0).expect("it has two ends");
        assert_eq!(found[1], sharp[3]);
        assert!(found[0] == sharp[0] || found[0] == again[4]);
    }
}
