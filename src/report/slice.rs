//! The picture of a cut: polygons coloured by quality, in so few bytes that a page holds several.
//!
//! Polygons of one colour are one path in whole units. What is smaller than a dot on a screen is drawn
//! as the dots that it touches, each in the colour of the worst cell that is in it; the dots grow until there are few enough.

use super::cut::{Flat, Piece, Window};
use super::html::escape;
use azimesh_core::diagnostic::short;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Units across a picture; about ten to a dot on a screen.
const ACROSS: f64 = 4000.0;
/// Colours from 0 to 1.
const COLOURS: usize = 16;
/// Units across a polygon from which on its edges are drawn.
const WITH_EDGES: f64 = 28.0;

/// What is in a picture.
pub struct Slice<'a> {
    /// The cells.
    pub pieces: &'a [Piece],
    /// Polygons and dots that are drawn, at most.
    pub most: usize,
    /// Quality of the cell of each piece; NaN where it has none.
    pub quality: &'a [f64],
    /// The surface of the body.
    pub outline: &'a [[Flat; 2]],
    /// Where that was.
    pub before: &'a [[Flat; 2]],
    /// What is seen.
    pub window: Window,
}

/// A polygon in units of the picture.
struct Shape {
    corners: Vec<[i32; 2]>,
    colour: Colour,
    has_edges: bool,
}

/// A colour, best first: later ones are drawn over earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Colour {
    None,
    Good(std::cmp::Reverse<usize>),
    Inverted,
}

impl Colour {
    fn of(quality: f64) -> Self {
        match quality {
            q if q.is_nan() => Colour::None,
            q if q <= 0.0 => Colour::Inverted,
            q => {
                let colour = (q * COLOURS as f64) as usize;
                Colour::Good(std::cmp::Reverse(colour.min(COLOURS - 1)))
            }
        }
    }

    fn class(self) -> String {
        match self {
            Colour::None => "qn".to_owned(),
            Colour::Good(std::cmp::Reverse(colour)) => format!("q{colour}"),
            Colour::Inverted => "qi".to_owned(),
        }
    }
}

impl Slice<'_> {
    /// The SVG element.
    pub fn svg(&self, in_words: &str) -> String {
        let height = ACROSS * self.window.half[1] / self.window.half[0];
        let shapes = self.few_enough();
        let mut paths: BTreeMap<(Colour, bool), String> = BTreeMap::new();
        for shape in &shapes {
            let d = paths.entry((shape.colour, shape.has_edges)).or_default();
            outline_of(&shape.corners, d);
        }
        let mut svg = String::new();
        for ((colour, has_edges), d) in &paths {
            let edges = if *has_edges { " e" } else { "" };
            write!(svg, "<path class=\"{}{edges}\" d=\"{d}\"/>", colour.class())
                .expect("a string takes any text");
        }
        for (class, segments) in [("before", self.before), ("body", self.outline)] {
            let d = self.lines(segments);
            write!(svg, "<path class=\"{class}\" d=\"{d}\"/>").expect("a string takes any text");
        }
        self.scale_bar(height, &mut svg);
        format!(
            "<svg class=\"slice\" viewBox=\"0 0 {ACROSS} {height:.0}\" role=\"img\" aria-label=\"{}\">{svg}</svg>",
            escape(in_words)
        )
    }

    /// Shapes with dots as small as their number allows.
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
        let mut dots: BTreeMap<[i32; 2], Colour> = BTreeMap::new();
        for (piece, quality) in self.pieces.iter().zip(self.quality) {
            let colour = Colour::of(*quality);
            let mut corners: Vec<[i32; 2]> = piece.corners.iter().map(|&x| self.place(x)).collect();
            corners.dedup();
            let [low, high] = box_around(&corners);
            let longest = (high[0] - low[0]).max(high[1] - low[1]);
            if longest < dot {
                let centre = [0, 1].map(|axis| low[axis].midpoint(high[axis]));
                for corner in corners.iter().chain([&centre]) {
                    // A little inside: a cell that ends with a dot is not in the next one.
                    let inside = [0, 1].map(|axis| (7 * corner[axis] + centre[axis]).div_euclid(8));
                    let worst = dots.entry(inside.map(|x| x.div_euclid(dot)));
                    let worst = worst.or_insert(colour);
                    *worst = colour.max(*worst);
                }
                continue;
            }
            let thickness = twice_area(&corners).abs() as f64 / (2.0 * f64::from(longest));
            shapes.push(Shape {
                corners,
                colour,
                has_edges: thickness >= WITH_EDGES,
            });
        }
        shapes.extend(dots.into_iter().map(|([x, y], colour)| {
            let (x, y) = (x * dot, y * dot);
            Shape {
                corners: vec![[x, y], [x + dot, y], [x + dot, y + dot], [x, y + dot]],
                colour,
                has_edges: false,
            }
        }));
        shapes
    }

    /// A place of the plane in units of the picture, y downward.
    fn place(&self, x: Flat) -> [i32; 2] {
        let scale = 0.5 * ACROSS / self.window.half[0];
        let [right, up] = [0, 1].map(|axis| x[axis] - self.window.centre[axis]);
        let unit = |x: f64| x.clamp(-1e6, 1e6).round() as i32;
        [
            unit((right + self.window.half[0]) * scale),
            unit((self.window.half[1] - up) * scale),
        ]
    }

    /// Segments as few lines as they can be joined to in their order.
    fn lines(&self, segments: &[[Flat; 2]]) -> String {
        let mut d = String::new();
        let mut end = None;
        for [from, to] in segments
            .iter()
            .map(|segment| segment.map(|x| self.place(x)))
        {
            if from == to {
                continue;
            }
            if end != Some(from) {
                write!(d, "M{} {}", from[0], from[1]).expect("a string takes any text");
            }
            write!(d, "L{} {}", to[0], to[1]).expect("a string takes any text");
            end = Some(to);
        }
        d
    }

    /// A bar of a round length that is about a fifth of the picture.
    fn scale_bar(&self, height: f64, svg: &mut String) {
        let wanted = 0.4 * self.window.half[0];
        let power = 10f64.powf(wanted.log10().floor());
        let digits = [5.0, 2.0, 1.0].into_iter();
        let digit = digits
            .filter(|digit| digit * power <= wanted)
            .fold(1.0, f64::max);
        let units = digit * power * 0.5 * ACROSS / self.window.half[0];
        let y = height - 130.0;
        write!(
            svg,
            "<g class=\"scale\"><rect x=\"80\" y=\"{:.0}\" width=\"{:.0}\" height=\"230\" rx=\"40\"/>\
             <path d=\"M150 {y:.0}h{units:.0}\"/><text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text></g>",
            y - 160.0,
            units + 140.0,
            150.0 + 0.5 * units,
            y - 30.0,
            short(digit * power)
        )
        .expect("a string takes any text");
    }
}

/// A closed polygon with relative coordinates, which are shorter.
fn outline_of(corners: &[[i32; 2]], d: &mut String) {
    let mut last: Option<[i32; 2]> = None;
    for &[x, y] in corners {
        match last {
            None => write!(d, "M{x} {y}l"),
            Some([from_x, from_y]) => {
                let (right, down) = (x - from_x, y - from_y);
                // A minus separates as well as a blank does.
                let blank = |value: i32| if value < 0 { "" } else { " " };
                let lead = if d.ends_with('l') { "" } else { blank(right) };
                write!(d, "{lead}{right}{}{down}", blank(down))
            }
        }
        .expect("a string takes any text");
        last = Some([x, y]);
    }
    d.push('z');
}

fn box_around(corners: &[[i32; 2]]) -> [[i32; 2]; 2] {
    let start = [[i32::MAX; 2], [i32::MIN; 2]];
    corners.iter().fold(start, |[low, high], corner| {
        [
            [0, 1].map(|axis| low[axis].min(corner[axis])),
            [0, 1].map(|axis| high[axis].max(corner[axis])),
        ]
    })
}

fn twice_area(corners: &[[i32; 2]]) -> i64 {
    let wide = |corner: [i32; 2]| corner.map(i64::from);
    let next = corners.iter().cycle().skip(1);
    let pairs = corners.iter().zip(next).map(|(&a, &b)| (wide(a), wide(b)));
    pairs
        .map(|([x, y], [next_x, next_y])| x * next_y - next_x * y)
        .sum()
}

/// The colours, dark to bright.
pub fn colour_bar(in_words: &str) -> String {
    let mut svg = String::new();
    for colour in 0..COLOURS {
        write!(
            svg,
            "<path class=\"q{colour}\" d=\"M{} 0h20v12h-20z\"/>",
            colour * 20
        )
        .expect("a string takes any text");
    }
    format!("<svg viewBox=\"0 0 320 12\" role=\"img\" aria-label=\"{in_words}\">{svg}</svg>")
}

/// The colours and what they stand for.
pub fn colour_key() -> String {
    format!(
        "<p class=\"key\"><span>0</span>{}<span>1</span> <span>scaled Jacobian</span> \
         <span><svg class=\"chip\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path class=\"qi\" d=\"M0 0h12v12h-12z\"/></svg> inverted</span> \
         <span><svg class=\"chip\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path class=\"qn\" d=\"M0 0h12v12h-12z\"/></svg> not defined \
         for the cell</span></p>",
        colour_bar("Colours from 0, dark, to 1, bright")
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
            quality: &vec![0.9; pieces.len()],
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
