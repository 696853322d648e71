//! Where to look: a plane through the first moving body, and a window around what it cuts.

use super::cut::{Cut, Flat, Plane, Window};
use crate::record::{BodyRecord, MotionRecord};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, dot, sub};
use azimesh_io::mesh::Mesh;

/// Height of a picture in widths.
pub const ASPECT: f64 = 0.7;
/// Where along its longest extent a body is cut, from the end that is nearer to the hub.
const STATION: f64 = 0.7;
/// Half of the window in extents of what is cut.
const ROOM: f64 = 1.1;

/// A plane and the extent of what is of interest in it.
pub struct View {
    plane: Plane,
    half: Flat,
    /// Where the window is when there is nothing to follow.
    rest: Flat,
    /// Boundary tags that are followed.
    pub tags: Vec<String>,
    /// Where the body is in the reference mesh, in the plane.
    pub outline: Vec<[Flat; 2]>,
    /// What is seen, as a sentence.
    pub sentence: String,
}

impl View {
    /// Of the first body with a surface in the mesh, or of all of it where no motion is known.
    pub fn new(mesh: &Mesh, motion: Option<&MotionRecord>) -> Self {
        let bodies = motion.map_or(&[][..], |motion| &motion.bodies);
        let hub = motion.map_or([0.0; 3], |motion| motion.hub);
        let with_surface = bodies.iter().find_map(|body| {
            let bounds = bounds_of(mesh, &body.tags);
            (bounds.diagonal() > 0.0).then_some((body, bounds))
        });
        let (body, bounds) = match with_surface {
            Some((body, bounds)) => (Some(body), bounds),
            None => (None, Bounds::around(&mesh.points)),
        };
        let is_solid = mesh.dimension() == 3;
        let turns = motion.is_some_and(|motion| motion.frame == "inertial");
        let (plane, axis) = plane_through(&bounds, hub, is_solid);
        let tags = body.map_or_else(Vec::new, |body| body.tags.clone());
        let outline = Cut::new(mesh, plane).outline(&tags);
        let [centre, extent] = match around(&outline) {
            Some(found) => found,
            None => around_corners(&plane, &bounds),
        };
        let half = ROOM * extent[0].max(extent[1] / ASPECT).max(f64::MIN_POSITIVE);
        Self {
            plane,
            half: [half, half * ASPECT],
            rest: centre,
            tags,
            outline,
            sentence: sentence(body, &plane, is_solid.then_some(axis), turns),
        }
    }

    /// The plane at a step, turned with the inertial frame.
    pub fn plane(&self, motion: Option<&MotionRecord>, azimuth_deg: f64) -> Plane {
        motion.map_or(self.plane, |motion| {
            self.plane.carried(&motion.carry(azimuth_deg))
        })
    }

    /// The window around an outline, of the same size for every step.
    pub fn window(&self, outline: &[[Flat; 2]]) -> Window {
        Window {
            centre: around(outline).map_or(self.rest, |[centre, _]| centre),
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

/// The plane across the longest extent of a box, and that axis; a plane mesh has the one it lies in.
fn plane_through(bounds: &Bounds, hub: Vector, is_solid: bool) -> (Plane, usize) {
    let extent = sub(bounds.high, bounds.low);
    let longest = (0..3)
        .rev()
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]));
    let axis = if is_solid { longest.unwrap_or(0) } else { 2 };
    let unit = |along: usize| std::array::from_fn(|i| if i == along { 1.0 } else { 0.0 });
    let (right, up) = match axis {
        0 => (1, 2),
        1 => (0, 2),
        _ => (0, 1),
    };
    let mut origin = [0.0; 3];
    let (low, high) = (bounds.low[axis], bounds.high[axis]);
    origin[axis] = match (
        is_solid,
        (low - hub[axis]).abs() <= (high - hub[axis]).abs(),
    ) {
        (false, _) => low,
        (_, true) => low + STATION * extent[axis],
        (_, false) => high - STATION * extent[axis],
    };
    let plane = Plane {
        origin,
        normal: unit(axis),
        right: unit(right),
        up: unit(up),
    };
    (plane, axis)
}

/// Centre and extent of some segments; `None` without any.
fn around(segments: &[[Flat; 2]]) -> Option<[Flat; 2]> {
    let points = segments.iter().flatten().map(|[x, y]| [*x, *y, 0.0]);
    let points: Vec<Vector> = points.collect();
    let bounds = Bounds::around(&points);
    let [[x, y, _], extent] = [bounds.centre(), sub(bounds.high, bounds.low)];
    (bounds.diagonal() > 0.0).then_some([[x, y], [extent[0], extent[1]]])
}

fn around_corners(plane: &Plane, bounds: &Bounds) -> [Flat; 2] {
    let extent = sub(bounds.high, bounds.low);
    let half = [plane.right, plane.up].map(|axis| 0.5 * dot(extent, axis).abs());
    [plane.flat(bounds.centre()), half]
}

/// `turns`: whether the frame is inertial.
fn sentence(body: Option<&BodyRecord>, plane: &Plane, axis: Option<usize>, turns: bool) -> String {
    let name = body.map(|body| body.name.as_str());
    let follows = match name {
        Some(name) => {
            format!("The view follows {name}; dashed is where it is in the reference mesh.")
        }
        None => String::new(),
    };
    let what = match (axis, name) {
        (None, Some(name)) => format!("The mesh around {name}."),
        (None, None) => "The mesh.".to_owned(),
        (Some(axis), _) => {
            let place = azimesh_core::diagnostic::short(plane.origin[axis]);
            let letter = ["x", "y", "z"][axis];
            let through = name.map_or_else(String::new, |name| format!(" through {name}"));
            let turning = match turns {
                true => "; it turns with the mesh",
                false => "",
            };
            format!(
                "The plane {letter} = {place}{through}, 0.7 of the way along its longest extent{turning}."
            )
        }
    };
    format!("{what} {follows}").trim_end().to_owned()
}
