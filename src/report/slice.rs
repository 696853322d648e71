//! The picture of a cut: polygons coloured by quality, in few bytes.
//!
//! Polygons of one colour are one path in whole units. Polygons smaller than a dot on a screen are drawn as the dots that they
//! touch, each in the colour of its worst cell; the dots grow until there are few enough.

use super::cut::{Flat, Piece, Window};
use super::html::escape;
use azimesh_core::numbers::short;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Units across a picture; about ten to a dot on a screen.
const ACROSS: f64 = 4000.0;
/// Colours from 0 to 1.
const COLOURS: u8 = 16;
/// Width of a polygon, in units, from which on its edges are drawn.
const WITH_EDGES: f64 = 28.0;

/// The content of a picture.
pub struct Slice<'a> {
    /// The cells.
    pub pieces: &'a [Piece],
    /// Largest number of polygons and dots.
    pub most: usize,
    /// Quality of all cells of the mesh; NaN where a cell has none.
    pub quality: &'a [f64],
    /// The surface of the body.
    pub outline: &'a [[Flat; 2]],
    /// The same in the reference mesh.
    pub before: &'a [[Flat; 2]],
    /// Cells that are marked, with a text.
    pub marks: &'a [(Flat, String)],
    /// The part of the plane that is shown.
    pub window: Window,
}

/// A polygon in units of the picture.
struct Shape {
    corners: Vec<[i32; 2]>,
    colour: u8,
    has_edges: bool,
}

/// Returns the class of the style sheet for a quality: 0 for NaN, from 1 for a good cell to 16 for a bad one, 17 for an
/// inverted one. A worse cell is drawn over a better one.
pub fn colour(quality: f64) -> u8 {
    if quality.is_nan() {
        0
    } else if quality <= 0.0 {
        COLOURS + 1
    } else {
        COLOURS - ((quality * f64::from(COLOURS)) as u8).min(COLOURS - 1)
    }
}

impl Slice<'_> {
    /// Draws the SVG element.
    pub fn svg(&self, in_words: &str) -> String {
        let height = ACROSS * self.window.half[1] / self.window.half[0];
        let mut paths: BTreeMap<(u8, bool), String> = BTreeMap::new();
        for shape in self.few_enough() {
            let d = paths.entry((shape.colour, shape.has_edges)).or_default();
            *d += &outline_of(&shape.corners);
        }
        let mut svg = String::new();
        for ((colour, has_edges), d) in &paths {
            let edges = if *has_edges { " e" } else { "" };
            svg += &format!("<path class=\"q{colour}{edges}\" d=\"{d}\"/>");
        }
        for (class, segments) in [("before", self.before), ("body", self.outline)] {
            svg += &format!("<path class=\"{class}\" d=\"{}\"/>", self.lines(segments));
        }
        for (at, words) in self.marks {
            let ([x, y], words) = (self.place(*at), escape(words));
            svg += &format!(
                "<g class=\"mark\"><title>{words}</title><circle cx=\"{x}\" cy=\"{y}\" r=\"70\"/></g>"
            );
        }
        svg += &self.scale_bar(height);
        let words = escape(in_words);
        format!(
            "<svg class=\"slice\" viewBox=\"0 0 {ACROSS} {height:.0}\" role=\"img\" aria-label=\"{words}\">{svg}</svg>"
        )
    }

    /// Makes shapes with dots as small as their number allows.
    fn few_enough(&self) -> Vec<Shape> {
        let mut dot = 5;
        loop {
            let shapes = self.shapes(dot);
            if shapes.len() <= self.most || f64::from(dot) > ACROSS / 8.0 {
                return shapes;
            }
            dot += dot.div_euclid(2);
        }
    }

    fn shapes(&self, dot: i32) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let mut dots: BTreeMap<[i32; 2], u8> = BTreeMap::new();
        for piece in self.pieces {
            let colour = colour(self.quality[piece.cell]);
            let mut corners: Vec<[i32; 2]> = piece.corners.iter().map(|&x| self.place(x)).collect();
            corners.dedup();
            let [low, high] = box_around(&corners);
            let longest = (high[0] - low[0]).max(high[1] - low[1]);
            if longest < dot {
                let centre = [0, 1].map(|axis| low[axis].midpoint(high[axis]));
                for corner in corners.iter().chain([&centre]) {
                    // A little inside: a cell that ends with a dot is not in the next one.
                    let inside = [0, 1].map(|axis| (7 * corner[axis] + centre[axis]).div_euclid(8));
                    let worst = dots
                        .entry(inside.map(|x| x.div_euclid(dot)))
                        .or_insert(colour);
                    *worst = colour.max(*worst);
                }
                continue;
            }
            let thickness = twice_area(&corners).abs() as f64 / (2.0 * f64::from(longest));
            let has_edges = thickness >= WITH_EDGES;
            shapes.push(Shape {
                corners,
                colour,
                has_edges,
            });
        }
        shapes.extend(dots.into_iter().map(|([x, y], colour)| {
            let (x, y) = (x * dot, y * dot);
            let corners = vec![[x, y], [x + dot, y], [x + dot, y + dot], [x, y + dot]];
            Shape {
                corners,
                colour,
                has_edges: false,
            }
        }));
        shapes
    }

    /// Converts a point of the plane to units of the picture, y downward.
    fn place(&self, x: Flat) -> [i32; 2] {
        let scale = 0.5 * ACROSS / self.window.half[0];
        let [right, up] = [0, 1].map(|axis| x[axis] - self.window.centre[axis]);
        let unit = |x: f64| (x * scale).clamp(-1e6, 1e6).round() as i32;
        [
            unit(right + self.window.half[0]),
            unit(self.window.half[1] - up),
        ]
    }

    /// Joins segments in their order to few lines.
    fn lines(&self, segments: &[[Flat; 2]]) -> String {
        let mut d = String::new();
        let mut end = None;
        for segment in segments {
            let [from, to] = segment.map(|x| self.place(x));
            if from == to {
                continue;
            }
            if end != Some(from) {
                d += &format!("M{} {}", from[0], from[1]);
            }
            d += &format!("L{} {}", to[0], to[1]);
            end = Some(to);
        }
        d
    }

    /// Draws a bar of a round length that is about a fifth of the picture.
    fn scale_bar(&self, height: f64) -> String {
        let wanted = 0.4 * self.window.half[0];
        let power = 10f64.powf(wanted.log10().floor());
        let digits = [1.0, 2.0, 5.0]
            .into_iter()
            .filter(|digit| digit * power <= wanted);
        let length = power * digits.fold(1.0, f64::max);
        let units = length * 0.5 * ACROSS / self.window.half[0];
        let y = height - 130.0;
        format!(
            "<g class=\"scale\"><rect x=\"80\" y=\"{:.0}\" width=\"{:.0}\" height=\"230\" rx=\"40\"/>\
             <path d=\"M150 {y:.0}h{units:.0}\"/><text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text></g>",
            y - 160.0,
            units + 140.0,
            150.0 + 0.5 * units,
            y - 30.0,
            short(length)
        )
    }
}

/// Writes a closed polygon with relative coordinates, which are shorter.
fn outline_of(corners: &[[i32; 2]]) -> String {
    let mut d = format!("M{} {}l", corners[0][0], corners[0][1]);
    for pair in corners.windows(2) {
        for axis in [0, 1] {
            let step = pair[1][axis] - pair[0][axis];
            // A minus separates as well as a blank does.
            let blank = if step < 0 || d.ends_with('l') {
                ""
            } else {
                " "
            };
            write!(d, "{blank}{step}").expect("a string takes any text");
        }
    }
    d + "z"
}

fn box_around(corners: &[[i32; 2]]) -> [[i32; 2]; 2] {
    let of = |axis: usize| corners.iter().map(move |corner| corner[axis]);
    let low = [0, 1].map(|axis| of(axis).min().unwrap_or(0));
    [low, [0, 1].map(|axis| of(axis).max().unwrap_or(0))]
}

fn twice_area(corners: &[[i32; 2]]) -> i64 {
    let wide = |corner: [i32; 2]| corner.map(i64::from);
    let next = corners.iter().cycle().skip(1);
    let pairs = corners.iter().zip(next).map(|(&a, &b)| (wide(a), wide(b)));
    pairs
        .map(|([x, y], [next_x, next_y])| x * next_y - next_x * y)
        .sum()
}

/// Draws the colours, dark to bright.
pub fn colour_bar(in_words: &str) -> String {
    let bars = (0..COLOURS).map(|at| {
        format!(
            "<path class=\"q{}\" d=\"M{} 0h20v12h-20z\"/>",
            COLOURS - at,
            20 * u32::from(at)
        )
    });
    let bars: String = bars.collect();
    format!("<svg viewBox=\"0 0 320 12\" role=\"img\" aria-label=\"{in_words}\">{bars}</svg>")
}

/// Draws the colours of the quality with their meaning.
pub fn colour_key() -> String {
    let chip = |class: u8, words: &str| {
        format!(
            "<span><svg class=\"chip\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path class=\"q{class}\" d=\"M0 0h12v12h-12z\"/></svg> {words}</span>"
        )
    };
    format!(
        "<span>0</span>{}<span>1</span> <span>scaled Jacobian</span> {} {}",
        colour_bar("Colours from 0, dark, to 1, bright"),
        chip(COLOURS + 1, "inverted"),
        chip(0, "not defined for the cell")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_beside_large_cells_leave_no_gap() {
        let square = |x: f64, y: f64, size: f64| {
            let corners = vec![[x, y], [x + size, y], [x + size, y + size], [x, y + size]];
            Piece { cell: 0, corners }
        };
        // Cells of 8 units to the left, of 80 to the right.
        let small = (0..100).flat_map(|i| (0..100).map(move |j| (i, j)));
        let small = small.map(|(i, j)| {
            square(
                -0.4 + 0.004 * f64::from(i),
                -0.2 + 0.004 * f64::from(j),
                0.004,
            )
        });
        let large = (0..50).map(|i| {
            square(
                0.04 * f64::from(i % 5),
                -0.2 + 0.04 * f64::from(i / 5),
                0.04,
            )
        });
        let pieces: Vec<Piece> = small.chain(large).collect();
        let slice = Slice {
            pieces: &pieces,
            most: 2000,
            quality: &[0.9],
            marks: &[],
            outline: &[],
            before: &[],
            window: Window {
                centre: [0.0; 2],
                half: [1.0; 2],
            },
        };
        let shapes = slice.few_enough();
        assert!(shapes.len() <= 2000 && shapes.len() > 500);
        let is_covered = |place: [i32; 2]| {
            shapes.iter().any(|shape| {
                let [low, high] = box_around(&shape.corners);
                (0..2).all(|axis| low[axis] <= place[axis] && place[axis] <= high[axis])
            })
        };
        let middle = |piece: &Piece| {
            slice.place([0, 1].map(|axis| 0.5 * (piece.corners[0][axis] + piece.corners[2][axis])))
        };
        let corner = |piece: &Piece| slice.place(piece.corners[2].map(|x| x - 1e-3));
        for piece in &pieces {
            assert!(
                is_covered(middle(piece)) && is_covered(corner(piece)),
                "{piece:?}"
            );
        }
    }
}
