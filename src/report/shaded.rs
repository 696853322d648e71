//! A still picture of surfaces in space: triangles in parallel projection, the far ones first, shaded by a light.

use super::html::escape;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, sub, unit};
use std::fmt::Write;

/// Units across a picture, and its height.
const ACROSS: f64 = 1000.0;
const HEIGHT: f64 = 700.0;
/// Shades from dark to bright.
const SHADES: f64 = 12.0;

/// From where surfaces are seen; the script of the page begins with the same view.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    /// What is in the middle.
    pub centre: Vector,
    /// Half of the height that is seen.
    pub radius: f64,
    /// From the middle towards the eye.
    pub towards: Vector,
    /// Upward.
    pub up: Vector,
}

impl Camera {
    /// Axes of the picture: right, up, towards the eye.
    fn axes(&self) -> [Vector; 3] {
        let towards = unit(self.towards).unwrap_or([0.0, 0.0, 1.0]);
        let right = unit(cross(self.up, towards)).unwrap_or([1.0, 0.0, 0.0]);
        [right, cross(towards, right), towards]
    }
}

impl Camera {
    /// How far a point is before the centre, towards the eye.
    pub fn depth(&self, x: Vector) -> f64 {
        dot(sub(x, self.centre), self.axes()[2])
    }

    /// The radius with which a point is just in view.
    pub fn needs(&self, x: Vector) -> f64 {
        let [right, up, _] = self.axes().map(|axis| dot(sub(x, self.centre), axis).abs());
        up.max(right * HEIGHT / ACROSS)
    }
}

/// A triangle in space, and the class of its colour.
pub struct Face {
    /// Its corners.
    pub corners: [Vector; 3],
    /// Class of the style sheet.
    pub class: String,
    /// 1 where it turns anticlockwise seen from outside, -1 where clockwise, 0 where that is not known.
    pub outward: f64,
}

/// Triangles that turn away are drawn this part of the radius farther off, below the other side of a thin body.
const BEHIND: f64 = 0.15;

/// The SVG element.
pub fn svg(faces: &[Face], camera: &Camera, in_words: &str) -> String {
    let axes = camera.axes();
    let seen = |x: Vector| axes.map(|axis| dot(sub(x, camera.centre), axis));
    let scale = 0.5 * HEIGHT / camera.radius;
    let light = unit([-0.35, 0.75, 0.9]).unwrap_or([0.0, 0.0, 1.0]);
    let mut drawn = Vec::with_capacity(faces.len());
    for face in faces {
        let corners = face.corners.map(seen);
        let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let length = norm(normal);
        if length == 0.0 {
            continue;
        }
        // Either side may be outside.
        let facing = if normal[2] < 0.0 { -1.0 } else { 1.0 };
        let shade = (facing * dot(normal, light) / length).max(0.0);
        let depth = (corners[0][2] + corners[1][2] + corners[2][2]) / 3.0;
        let is_behind = face.outward * normal[2] < 0.0;
        let depth = if is_behind {
            depth - BEHIND * camera.radius
        } else {
            depth
        };
        let place = |x: Vector| {
            let unit = |x: f64| x.clamp(-1e5, 1e5).round() as i32;
            [
                unit(0.5 * ACROSS + scale * x[0]),
                unit(0.5 * HEIGHT - scale * x[1]),
            ]
        };
        drawn.push((
            depth,
            face,
            (shade * (SHADES - 1.0)).round() as usize,
            corners.map(place),
        ));
    }
    drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut svg = String::new();
    let mut open = None;
    for (_, face, shade, [a, b, c]) in &drawn {
        // Neighbours in depth with one colour are one path.
        let class = format!("{} l{shade}", face.class);
        if open.as_ref() != Some(&class) {
            if open.is_some() {
                svg += "\"/>";
            }
            write!(svg, "<path class=\"{class}\" d=\"").expect("a string takes any text");
            open = Some(class);
        }
        write!(
            svg,
            "M{} {}l{} {} {} {}z",
            a[0],
            a[1],
            b[0] - a[0],
            b[1] - a[1],
            c[0] - b[0],
            c[1] - b[1]
        )
        .expect("a string takes any text");
    }
    if open.is_some() {
        svg += "\"/>";
    }
    format!(
        "<svg class=\"solid\" viewBox=\"0 0 {ACROSS} {HEIGHT}\" role=\"img\" aria-label=\"{}\">{svg}</svg>",
        escape(in_words)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sides of a plate, of which the centre of the upper one is farther from the eye.
    #[test]
    fn the_side_that_turns_away_is_drawn_first() {
        let camera = Camera {
            centre: [0.0; 3],
            radius: 2.0,
            towards: [0.0, 0.0, 1.0],
            up: [0.0, 1.0, 0.0],
        };
        let face = |corners, class: &str, outward| Face {
            corners,
            class: class.to_owned(),
            outward,
        };
        let upper = [[-1.0, -1.0, 0.01], [1.0, -1.0, 0.01], [0.0, 1.0, -0.2]];
        let lower = [[-1.0, -1.0, 0.0], [0.0, 0.1, 0.0], [1.0, -1.0, 0.0]];
        let order = |outward: f64| {
            let faces = [face(upper, "upper", outward), face(lower, "lower", outward)];
            let drawn = svg(&faces, &camera, "a plate");
            drawn.find("lower") < drawn.find("upper")
        };
        assert!(order(1.0));
        assert!(!order(0.0) && !order(-1.0));
    }
}
