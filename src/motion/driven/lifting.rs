//! The line that the sections of a blade turn about: given as a table, or at a quarter of the chord
//! of the mesh.

use super::BodyNodes;
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, distance, dot, sub};
use crate::mesh::Mesh;
use crate::motion::body::Body;
use crate::motion::rotor::RotorAxes;
use crate::motion::surface::{Role, SurfaceFaces, SurfaceNodes};
use crate::motion::table::Table;
use std::path::Path;

/// Sections at the ends of a blade are cut this part of its span inside.
const INSIDE: f64 = 1e-3;
/// Where the line lies between leading and trailing edge.
const CHORDWISE: f64 = 0.25;

/// The faces of a body, seen in the frame of its blade.
#[derive(Clone, Copy)]
pub(in crate::motion) struct BladeSurface<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Faces with a role.
    pub faces: &'a SurfaceFaces,
    /// Nodes with a role.
    pub nodes: &'a SurfaceNodes,
    /// The role of the body's own.
    pub role: Role,
    /// Axes of the blade at its azimuth offset.
    pub blade: &'a RotorAxes,
}

/// Points in the frame of the blade, from the hub, over increasing stations. Past its ends it goes on
/// parallel to the span.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::motion) struct LiftingLine {
    stations: Vec<f64>,
    points: Vec<Vector>,
}

impl LiftingLine {
    /// Reads `station, x, y, z`; the blade goes from `span[0]` to `span[1]`.
    pub fn read(path: &Path, body: &Body, span: [f64; 2]) -> Result<Self> {
        let table = Table::read(path)?;
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
                "station {} does not lie outboard of station {} of line {}; rows must go from one `station` to a \
                 larger one",
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
        Ok(Self {
            points: points.collect(),
            stations,
        })
    }

    /// A quarter of the chord behind the leading edge, at some stations and at the ends of the blade.
    /// The chord of a section is its longest extent; its leading edge is the end towards `e_y`, of a
    /// clockwise rotor the other.
    pub fn quarter_chord(
        surface: &BladeSurface<'_>,
        stations: &[f64],
        body: &Body,
        line: u64,
    ) -> Result<Self> {
        let edges = surface.edges();
        let [low, high] = span_of(&edges);
        let margin = INSIDE * (high - low);
        let (first, last) = (low + margin, high - margin);
        let inside = stations.iter().copied();
        let inside = inside.filter(|r| (first..last).contains(r) && *r > first);
        let stations: Vec<f64> = [first].into_iter().chain(inside).chain([last]).collect();
        let mut cuts: Vec<Vec<Vector>> = vec![Vec::new(); stations.len()];
        for [a, b] in &edges {
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
        let mut points = Vec::with_capacity(stations.len());
        for (station, cut) in stations.iter().zip(&cuts) {
            let Some([nose, tail]) = chord(cut, surface.blade.signs.azimuth) else {
                let message = format!(
                    "body \"{}\" has no faces at station {station}, so there is no chord to take a quarter of; give \
                     `lifting_line` a table  station,x,y,z",
                    body.name
                );
                return Err(Error::input(message).line(line));
            };
            let point = std::array::from_fn(|i| nose[i] + CHORDWISE * (tail[i] - nose[i]));
            points.push(point);
        }
        Ok(Self { stations, points })
    }

    /// Its first and last point.
    pub fn ends(&self) -> [Vector; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }

    /// The point of a station.
    pub fn at(&self, station: f64) -> Vector {
        let after = self.stations.partition_point(|r| *r <= station);
        if after == 0 || after == self.stations.len() {
            let end = after.saturating_sub(1);
            let [x, y, z] = self.points[end];
            return [x + station - self.stations[end], y, z];
        }
        let (r, p) = (&self.stations[after - 1..], &self.points[after - 1..]);
        let part = (station - r[0]) / (r[1] - r[0]);
        std::array::from_fn(|i| p[0][i] + part * (p[1][i] - p[0][i]))
    }
}

/// What is said of stations that all lie off the blade.
pub(super) fn off_blade([first, last]: [f64; 2], body: &Body, [low, high]: [f64; 2]) -> String {
    format!(
        "the stations go from {first} to {last}, but body \"{}\" lies between {low} and {high} along its span; \
         stations are lengths in mesh units from the hub",
        body.name
    )
}

impl BladeSurface<'_> {
    /// The edges of the body's faces, ends in the frame of the blade.
    fn edges(&self) -> Vec<[Vector; 2]> {
        let mut edges = Vec::new();
        let faces = self.faces.cells.iter().zip(&self.faces.roles);
        for (&cell, _) in faces.filter(|(_, role)| **role == self.role) {
            let cell = self.mesh.cells.get(cell as usize);
            let place = |at: usize| self.in_blade(self.mesh.points[cell.nodes[at] as usize]);
            let pairs = cell.kind.edges();
            let n = cell.nodes.len();
            if pairs.is_empty() {
                edges.extend((0..n).map(|at| [place(at), place((at + 1) % n)]));
            }
            edges.extend(pairs.iter().map(|pair| pair.map(|at| place(at.into()))));
        }
        edges
    }

    /// Span, chord and shaft coordinates of a point from the hub.
    fn in_blade(&self, x: Vector) -> Vector {
        let from_hub = sub(x, self.blade.hub);
        [self.blade.e_x, self.blade.e_y, self.blade.e_z].map(|axis| dot(axis, from_hub))
    }

    /// The nodes of the body.
    pub fn nodes(&self) -> BodyNodes {
        let nodes = self.nodes.nodes.iter().zip(&self.nodes.roles);
        let own = nodes.filter(|(_, role)| **role == self.role);
        let nodes: Vec<u32> = own.map(|(node, _)| *node).collect();
        BodyNodes {
            places: nodes
                .iter()
                .map(|&node| self.mesh.points[node as usize])
                .collect(),
            nodes,
            n_mesh: self.mesh.points.len(),
        }
    }

    /// Where the blade begins and ends along its span.
    pub fn span(&self) -> [f64; 2] {
        span_of(&self.edges())
    }
}

fn span_of(edges: &[[Vector; 2]]) -> [f64; 2] {
    let ends = edges.iter().flatten().map(|x| x[0]);
    ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
        [low.min(r), high.max(r)]
    })
}

/// The ends of the longest extent of a section, leading edge first, which is towards `e_y` times `sign`:
/// from one point to the farthest, and on from there while the distance grows.
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
    let [a, b] = ends;
    let forward = sign * a[1] >= sign * b[1];
    Some(if forward { [a, b] } else { [b, a] })
}
