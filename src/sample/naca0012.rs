//! A NACA 0012 in a circle of five chords' diameter: an O-grid of quadrilaterals.
//!
//! Chord one, quarter chord at the origin. Tags `airfoil` and `farfield`.

use super::airfoil::{NOSE_RADIUS, Section};
use super::ray::{Ray, START};
use super::size::SizeOptions;
use super::spacing::{LineEnd, graded_from_ends};
use super::{Sample, tag};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{CellKind, Cells, Mesh};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radius of the outer circle, in chords.
const OUTER_RADIUS: f64 = 2.5;

/// The mesh and a schedule that pitches the airfoil by 10 degrees either way; nodes are 25,000 unless given.
pub fn naca0012(size: &SizeOptions) -> Result<Sample> {
    let usual_layers = |nodes: usize| ((nodes as f64 / 2.6).sqrt() as usize).clamp(8, 400);
    let size = size.resolve(25_000, usual_layers, 24)?;
    let n_side = size.wall_nodes / 2;
    let n_layers = size.layers(2 * n_side);
    let rays = rays(n_side, size.first_cell, n_layers);
    Ok(Sample {
        mesh: mesh(&rays, n_layers),
        schedule: SCHEDULE.to_owned(),
    })
}

/// One ray a wall node, counter-clockwise from the trailing edge.
fn rays(n_side: usize, first: f64, n_layers: usize) -> Vec<Ray> {
    let section = Section::new();
    let cells_at_ends = (n_side as f64 / 16.0).max(2.0);
    let quarter = FRAC_PI_2 * section.trailing_radius();
    let ends = [
        LineEnd {
            size: quarter / cells_at_ends,
            hold: quarter,
        },
        LineEnd {
            size: NOSE_RADIUS / cells_at_ends,
            hold: 0.0,
        },
    ];
    let arcs = graded_from_ends(section.length(), n_side, ends);
    (0..2 * n_side)
        .map(|i| {
            let upper = i <= n_side;
            let from_rear = if upper { i } else { 2 * n_side - i };
            let arc = section.length() - arcs[from_rear];
            let point = section.point(section.parameter_at_arc(arc));
            let side = if upper { 1.0 } else { -1.0 };
            let wall = [point.at[0] - 0.25, side * point.at[1], 0.0];
            let normal = [point.normal[0], side * point.normal[1], 0.0];
            let angle = PI * i as f64 / n_side as f64;
            let outer: Vector = [OUTER_RADIUS * angle.cos(), OUTER_RADIUS * angle.sin(), 0.0];
            Ray::new([wall, normal, outer], START, first, n_layers)
        })
        .collect()
}

fn mesh(rays: &[Ray], n_layers: usize) -> Mesh {
    let n = rays.len();
    let points = (0..=n_layers)
        .flat_map(|layer| rays.iter().map(move |ray| ray.node(layer)))
        .collect();
    let mut cells = Cells::new();
    cells.reserve(4 * n * n_layers + 4 * n);
    let node = |layer: usize, i: usize| (layer * n + i % n) as u32;
    for layer in 0..n_layers {
        for i in 0..n {
            let (low, high) = (layer, layer + 1);
            let nodes = [
                node(low, i),
                node(high, i),
                node(high, i + 1),
                node(low, i + 1),
            ];
            cells.push(CellKind::Quadrilateral, &nodes);
        }
    }
    for i in 0..n {
        cells.push(CellKind::Line, &[node(0, i + 1), node(0, i)]);
    }
    for i in 0..n {
        cells.push(CellKind::Line, &[node(n_layers, i), node(n_layers, i + 1)]);
    }
    let walls = n * n_layers;
    Mesh {
        points,
        cells,
        groups: vec![
            tag("airfoil", 1, walls..walls + n),
            tag("farfield", 1, walls + n..walls + 2 * n),
        ],
        ..Mesh::default()
    }
}

const SCHEDULE: &str = r#"# The airfoil pitches by 10 degrees about its quarter chord, once in 36 steps.
version = 1
angle_unit = "deg"

[azimuth]
start = 0.0
stop = 360.0
step = 10.0

# In 2D the span axis is [0, 0, -1]: pitch is nose up for flow along +x.

[[body]]
name = "airfoil"
tags = ["airfoil"]

[body.cyclic]
pitch = [ { sin = 10.0 } ]

[boundaries]
fixed = ["farfield"]

[rbf]
kernel = "wendland-c2"
support_radius = 10.0        # chords: larger than the region, for a smooth field

[selection]
tolerance = 1e-4             # chords
"#;
