//! Transfer of displacements from the points of one surface to the points of another.
//!
//! ```text
//! x_j (n, 3), d_j (n, 3)    given points and their displacements: a structure, another mesh
//! y_i (N, 3)                points that need displacements: the nodes of a wall
//!
//! d(y) = d(foot) + (Q(foot) - 1) o,    o = y - foot
//! ```
//!
//! `foot` is a point of the given surface, `Q` the rotation of the surface there, `o` the offset, which turns with the
//! surface. The three methods differ in the foot:
//!
//! - [`nearest`](SurfaceMap::nearest): the nearest given point; no rotation. Exact for translations.
//! - [`plane`](SurfaceMap::plane): the nearest point of given triangles, or of edges in the plane. Exact for rigid motions.
//! - [`rbf`](SurfaceMap::rbf): radial basis functions with a linear polynomial on overlapping patches of the given points,
//!   blended smoothly. Exact for rigid motions, and for linear displacements where the points of a patch fill space.
//!
//! Forces go the other way by the transpose of the map at rest, [`pull_back`](SurfaceMap::pull_back): it keeps their virtual
//! work, and so the sums of forces (every method) and of moments (`plane` and `rbf`).
//!
//! Sources: D. Schneider et al., preCICE, SIAM J. Sci. Comput. 2023 (partition of unity for coupling); H. Wendland, Scattered Data
//! Approximation, 2005, chapter 15.

mod frame;
mod patch;
mod patches;

use crate::{Error, Result, Vector};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::closest::{ClosestPoint, ClosestSurface};
use azimesh_core::geometry::vector::{add, cross, norm, scale, sub, weighted_sum};
use azimesh_core::parallel;
use frame::{Frame, Slopes};
use patches::Patches;

/// A map of displacements from given points to the points of another surface, and of forces back.
///
/// ```
/// use azimesh_rbf::SurfaceMap;
///
/// // A plate of 25 points that turns by 90 degrees about the z axis, and two points of a wall near it.
/// let plate: Vec<[f64; 3]> = (0..25).map(|i| [f64::from(i % 5), f64::from(i / 5), 0.0]).collect();
/// let turned = |x: [f64; 3]| [-x[1], x[0], x[2]];
/// let moved: Vec<[f64; 3]> = plate.iter().map(|x| std::array::from_fn(|k| turned(*x)[k] - x[k])).collect();
/// let wall = [[1.3, 2.6, 0.2], [4.1, 0.0, -0.3]];
///
/// let map = SurfaceMap::rbf(&plate, &wall)?;
/// for (y, d) in wall.iter().zip(map.displacements(&moved)?) {
///     assert!((0..3).all(|k| (y[k] + d[k] - turned(*y)[k]).abs() < 1e-12));
/// }
/// let forces = map.pull_back(&[[0.0, 0.0, 2.0], [1.0, 0.0, 0.0]])?; // at the points of the plate
/// assert!((forces.iter().map(|f| f[2]).sum::<f64>() - 2.0).abs() < 1e-12);
/// # Ok::<(), azimesh_rbf::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SurfaceMap {
    given: Vec<Vector>,
    wall: Vec<Vector>,
    method: Method,
    distances: Vec<f64>,
}

#[derive(Debug, Clone)]
enum Method {
    /// The nearest given point of each wall point.
    Nearest(Vec<u32>),
    /// The nearest point of a facet for each wall point.
    Plane(Vec<ClosestPoint>),
    Rbf(Patches),
}

impl SurfaceMap {
    /// Takes the displacement of the nearest given point.
    ///
    /// # Errors
    /// Of kind `Input` if there is no point or a coordinate is not finite.
    pub fn nearest(given: &[Vector], wall: &[Vector]) -> Result<Self> {
        let feet = feet_on_points(given, wall)?;
        let nearest = feet.iter().map(|foot| foot.corners[0]).collect();
        Ok(Self::new(given, wall, Method::Nearest(nearest), &feet))
    }

    /// Takes the nearest point of `facets`, triangles of given points or, in the plane, edges `[a, b, b]`. The offset from it
    /// turns with the facet.
    ///
    /// # Errors
    /// Of kind `Input` if there is no facet, if a facet names a point that does not exist, or if a coordinate is not finite.
    pub fn plane(given: &[Vector], facets: &[[u32; 3]], wall: &[Vector]) -> Result<Self> {
        check(given, wall)?;
        if facets.is_empty() {
            return Err(Error::input(
                "there are no facets to take the nearest point of",
            ));
        }
        if let Some(facet) = facets
            .iter()
            .find(|facet| facet.iter().any(|&i| i as usize >= given.len()))
        {
            let n = given.len();
            return Err(Error::input(format!(
                "the facet {facet:?} has a point that is none of the {n}"
            )));
        }
        let feet = feet(&ClosestSurface::new(given, facets), wall)?;
        let method = Method::Plane(feet.clone());
        Ok(Self::new(given, wall, method, &feet))
    }

    /// Interpolates by radial basis functions on overlapping patches of about 50 given points.
    ///
    /// # Errors
    /// Of kind `Input` if there is no point, if a coordinate is not finite, or if all points are on a line in space, which do not
    /// determine a rotation about the line.
    pub fn rbf(given: &[Vector], wall: &[Vector]) -> Result<Self> {
        let feet = feet_on_points(given, wall)?;
        let patches = Patches::new(given, wall)?;
        Ok(Self::new(given, wall, Method::Rbf(patches), &feet))
    }

    fn new(given: &[Vector], wall: &[Vector], method: Method, feet: &[ClosestPoint]) -> Self {
        Self {
            given: given.to_vec(),
            wall: wall.to_vec(),
            method,
            distances: feet
                .iter()
                .map(|foot| foot.distance_squared.sqrt())
                .collect(),
        }
    }

    /// The distance of each wall point from the given surface: from its facets, or its points where none are given.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// Returns the displacements (N, 3) of the wall points for displacements (n, 3) of the given ones. Rotations may be large.
    ///
    /// # Errors
    /// Of kind `Input` if the numbers of displacements and points differ, if one is not finite, or if points at one position
    /// have different ones.
    pub fn displacements(&self, displacements: &[Vector]) -> Result<Vec<Vector>> {
        check_values("displacements", displacements, self.given.len())?;
        Ok(match &self.method {
            Method::Nearest(nearest) => {
                nearest.iter().map(|&i| displacements[i as usize]).collect()
            }
            Method::Plane(feet) => parallel::collect(feet.len(), |i| {
                self.carried(&feet[i], &self.wall[i], displacements)
            }),
            Method::Rbf(patches) => {
                patches.displacements(&self.given, &self.wall, displacements)?
            }
        })
    }

    /// Returns the forces (n, 3) at the given points that do the same virtual work as forces (N, 3) at the wall points, both at
    /// rest. The sum of forces is preserved; with `plane` and `rbf` also the sum of moments.
    ///
    /// # Errors
    /// Of kind `Input` if the numbers of forces and wall points differ, or if one is not finite.
    pub fn pull_back(&self, forces: &[Vector]) -> Result<Vec<Vector>> {
        check_values("forces", forces, self.wall.len())?;
        let mut given = vec![[0.0; 3]; self.given.len()];
        match &self.method {
            Method::Nearest(nearest) => {
                for (&i, force) in nearest.iter().zip(forces) {
                    given[i as usize] = add(given[i as usize], *force);
                }
            }
            Method::Plane(feet) => {
                for ((foot, y), force) in feet.iter().zip(&self.wall).zip(forces) {
                    self.spread(foot, y, *force, &mut given);
                }
            }
            Method::Rbf(patches) => {
                patches.pull_back(&self.given, &self.wall, forces, &mut given)?
            }
        }
        Ok(given)
    }

    /// Returns the displacement of a wall point by its closest point on a facet.
    fn carried(&self, foot: &ClosestPoint, y: &Vector, displacements: &[Vector]) -> Vector {
        let corners = foot.corners.map(|i| self.given[i as usize]);
        let moved = foot.corners.map(|i| displacements[i as usize]);
        let frame = Frame::new(along(corners));
        let offset = sub(*y, weighted_sum(&foot.weights, &corners));
        let displacement = weighted_sum(&foot.weights, &moved);
        add(displacement, frame.turned(along(moved), offset))
    }

    /// Adds the force of a wall point to the corners of its facet.
    fn spread(&self, foot: &ClosestPoint, y: &Vector, force: Vector, given: &mut [Vector]) {
        let corners = foot.corners.map(|i| self.given[i as usize]);
        let offset = sub(*y, weighted_sum(&foot.weights, &corners));
        let couple = Frame::new(along(corners)).couple(cross(offset, force));
        for (k, &i) in foot.corners.iter().enumerate() {
            let slope = |of: Vector, corner: usize| match k {
                0 => scale(of, -1.0),
                _ if k == corner => of,
                _ => [0.0; 3],
            };
            let from_slopes = add(slope(couple[0], 1), slope(couple[1], 2));
            let all = add(scale(force, foot.weights[k]), from_slopes);
            given[i as usize] = add(given[i as usize], all);
        }
    }
}

/// Returns the differences along two sides of a facet; zero along the second side of an edge.
fn along([a, b, c]: [Vector; 3]) -> Slopes {
    [sub(b, a), sub(c, a)]
}

/// Returns the nearest given point of each wall point.
fn feet_on_points(given: &[Vector], wall: &[Vector]) -> Result<Vec<ClosestPoint>> {
    check(given, wall)?;
    let points: Vec<[u32; 3]> = (0..given.len() as u32).map(|i| [i; 3]).collect();
    feet(&ClosestSurface::new(given, &points), wall)
}

fn feet(surface: &ClosestSurface<'_>, wall: &[Vector]) -> Result<Vec<ClosestPoint>> {
    parallel::try_map(wall.len(), &|i| {
        let foot = surface.nearest(&wall[i], f64::INFINITY);
        foot.ok_or_else(|| {
            Error::input(format!(
                "point {i} is too far from the given points for their squares"
            ))
        })
    })
}

fn check(given: &[Vector], wall: &[Vector]) -> Result<()> {
    if given.is_empty() {
        return Err(Error::input("there are no given points"));
    }
    for (name, points) in [("given", given), ("wall", wall)] {
        if let Some(i) = points.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
            return Err(Error::input(format!(
                "a coordinate of {name} point {i} is not finite"
            )));
        }
    }
    Ok(())
}

fn check_values(what: &str, values: &[Vector], n: usize) -> Result<()> {
    if values.len() != n {
        let found = values.len();
        return Err(Error::input(format!(
            "there are {found} {what} for {n} points"
        )));
    }
    match values.iter().position(|value| !norm(*value).is_finite()) {
        Some(i) => Err(Error::input(format!(
            "number {i} of the {what} is not finite"
        ))),
        None => Ok(()),
    }
}

/// True if all points have one z: the maps turn about z alone.
fn in_plane(given: &[Vector], wall: &[Vector]) -> bool {
    let bounds = Bounds::around(given.iter().chain(wall));
    bounds.low[2] == bounds.high[2]
}

#[cfg(test)]
mod tests;
