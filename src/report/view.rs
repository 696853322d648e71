//! The plane of the cuts, through the first moving body, and a window around the outline of the body in it.

use super::cut::{Cut, Flat, Plane, Window};
use crate::record::MotionRecord;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, dot, sub};
use azimesh_core::numbers::short;
use azimesh_io::mesh::Mesh;

/// Height of a picture in widths.
const ASPECT: f64 = 0.7;
/// Position along its longest extent at which a body is cut, from the end nearer to the hub.
const STATION: f64 = 0.7;
/// Half of the window in extents of the outline.
const ROOM: f64 = 1.1;

/// A plane and a window in it.
pub struct View {
    /// The plane in the reference mesh.
    pub plane: Plane,
    /// Names of its axes.
    pub axes: [&'static str; 2],
    half: Flat,
    /// The middle of the window when there is nothing to follow.
    rest: Flat,
    /// Boundary tags that are followed.
    pub tags: Vec<String>,
    /// The outline of the body in the reference mesh.
    pub outline: Vec<[Flat; 2]>,
    /// The plane in words.
    pub sentence: String,
}

impl View {
    /// Looks at the first body with a surface in the mesh, or at all of the mesh where no motion is known.
    pub fn new(mesh: &Mesh, motion: Option<&MotionRecord>) -> Self {
        let bodies = motion.map_or(&[][..], |motion| &motion.bodies);
        let hub = motion.map_or([0.0; 3], |motion| motion.hub);
        let with_surface = bodies.iter().find_map(|body| {
            let bounds = bounds_of(mesh, &body.tags);
            (bounds.diagonal() > 0.0).then_some((Some(body), bounds))
        });
        let (body, bounds) = with_surface.unwrap_or_else(|| (None, Bounds::around(&mesh.points)));
        let is_solid = mesh.dimension() == 3;
        let (plane, axis) = plane_through(&bounds, hub, is_solid);
        let tags = body.map_or_else(Vec::new, |body| body.tags.clone());
        let outline = Cut::new(mesh, plane).outline(&tags);
        let (rest, extent) = around(&outline).unwrap_or_else(|| {
            let extent = sub(bounds.high, bounds.low);
            let half = [plane.right, plane.up].map(|axis| 0.5 * dot(extent, axis).abs());
            (plane.flat(bounds.centre()), half)
        });
        let half = ROOM * extent[0].max(extent[1] / ASPECT).max(f64::MIN_POSITIVE);
        let (mut through, mut follows) = (String::new(), String::new());
        if let Some(body) = body {
            through = format!(
                "{} {}",
                if is_solid { " through" } else { " around" },
                body.name
            );
            follows = format!(
                " The view follows {}; dashed is where it is in the reference mesh.",
                body.name
            );
        }
        let turns = motion.is_some_and(|motion| motion.frame == "inertial");
        let sentence = if is_solid {
            let (letter, place) = (["x", "y", "z"][axis], short(plane.origin[axis]));
            let turning = if turns {
                "; it turns with the mesh"
            } else {
                ""
            };
            format!(
                "The plane {letter} = {place}{through}, 0.7 of the way along its longest extent{turning}.{follows}"
            )
        } else {
            format!("The mesh{through}.{follows}")
        };
        let axes = [["y", "z"], ["x", "z"], ["x", "y"]][axis];
        Self {
            plane,
            axes,
            half: [half, half * ASPECT],
            rest,
            tags,
            outline,
            sentence,
        }
    }

    /// Returns the plane at a step, turned with the inertial frame.
    pub fn plane(&self, motion: Option<&MotionRecord>, azimuth_deg: f64) -> Plane {
        motion.map_or(self.plane, |motion| {
            self.plane.carried(&motion.carry(azimuth_deg))
        })
    }

    /// Returns the window around an outline, of the same size for every step.
    pub fn window(&self, outline: &[[Flat; 2]]) -> Window {
        Window {
            centre: around(outline).map_or(self.rest, |(centre, _)| centre),
            half: self.half,
        }
    }
}

fn bounds_of(mesh: &Mesh, tags: &[String]) -> Bounds {
    let named = mesh.boundary_tags().filter(|tag| tags.contains(&tag.name));
    let cells = named.flat_map(|tag| tag.cells.iter());
    let nodes = cells.flat_map(|cell| mesh.cells.get(cell).nodes);
    Bounds::around(nodes.map(|&node| &mesh.points[node as usize]))
}

/// Returns the plane across the longest extent of a box, and that axis; the plane of a plane mesh.
fn plane_through(bounds: &Bounds, hub: Vector, is_solid: bool) -> (Plane, usize) {
    let extent = sub(bounds.high, bounds.low);
    let longest = (0..3)
        .rev()
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]));
    let axis = if is_solid { longest.unwrap_or(0) } else { 2 };
    let (low, high) = (bounds.low[axis], bounds.high[axis]);
    let mut origin = [0.0; 3];
    origin[axis] = if !is_solid {
        low
    } else if (low - hub[axis]).abs() <= (high - hub[axis]).abs() {
        low + STATION * extent[axis]
    } else {
        high - STATION * extent[axis]
    };
    let unit = |along: usize| std::array::from_fn(|i| f64::from(u8::from(i == along)));
    let [right, up] = [[1, 2], [0, 2], [0, 1]][axis].map(unit);
    let normal = unit(axis);
    (
        Plane {
            origin,
            normal,
            right,
            up,
        },
        axis,
    )
}

/// Returns centre and extent of some segments; `None` without any.
pub fn around(segments: &[[Flat; 2]]) -> Option<(Flat, Flat)> {
    let points: Vec<Vector> = segments
        .iter()
        .flatten()
        .map(|[x, y]| [*x, *y, 0.0])
        .collect();
    let bounds = Bounds::around(&points);
    let ([x, y, _], [width, height, _]) = (bounds.centre(), sub(bounds.high, bounds.low));
    (bounds.diagonal() > 0.0).then_some(([x, y], [width, height]))
}
