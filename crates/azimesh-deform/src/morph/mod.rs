//! The [`Morph`]: a linear map from displacements of the moving nodes to positions of all nodes, with its
//! exact transpose, for displacements that are not known beforehand.
//!
//! ```text
//! A d = E X S u_b + C (u - P E_s X S u_b),   u = G d
//! ```
//! `G` maps displacements to surface points, `S` solves for the weights of the base points, `X` adds periodic images, `E`
//! evaluates, `C` is the correction of the exact surface; then surface nodes are set. Everything but `d` is fixed in
//! [`Morph::new`].

mod base;
mod fade;
mod options;
mod pairs;
mod surface;

pub use options::{MorphOptions, Nodes};

use crate::plan::checks::check_length;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, add, norm, scale, sub};
use azimesh_core::geometry::{Bounds, Transform, curve};
use azimesh_core::numbers::short;
use azimesh_core::parallel;
use azimesh_core::{Note, note};
use azimesh_io::mesh::Mesh;
use azimesh_rbf::Basis;
use azimesh_rbf::constrained::FactoredSystem;
use azimesh_rbf::constraint::Constraint;
use azimesh_rbf::correct::Faded;
use azimesh_rbf::field::{BLOCK, evaluate_along};
use azimesh_rbf::images::Images;
use azimesh_rbf::interpolant::Interpolant;
use azimesh_rbf::space::Space;
use azimesh_rbf::transposed::transposed;
use fade::{FadeRows, fade_rows};
use pairs::Pairs;
use std::sync::Arc;
use surface::{MorphSurface, check_finite};

/// Residuals above this part of the fade radius may fold cells in the correction.
const STEEP: f64 = 0.1;

/// A mesh that follows displacements of its moving nodes.
///
/// Positions are exact at moving and fixed nodes, and `points(d) - points(0)` is linear in `d`:
///
/// ```text
/// points(d) = x + A d,     <g, A d> = <pull_back(g), d>
/// ```
///
/// [`new`](Self::new) selects base points, factors their system and finds closest points once. After that `points` and
/// `pull_back` cost `N n` kernel evaluations each for `N` nodes and `n` base points. It owns its mesh, and is `Send` and
/// `Sync`.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{CellKind, Cells, Mesh, Morph, MorphOptions};
///
/// // Three by three nodes of a plane; the left side moves, the right one stays.
/// let node = |n: i32| [f64::from(n % 3), f64::from(n / 3), 0.0];
/// let mut cells = Cells::new();
/// for first in [0, 1, 3, 4] {
///     let corners = [first, first + 1, first + 4, first + 3];
///     cells.push(CellKind::Quadrilateral, &corners);
/// }
/// for edge in [[0, 3], [3, 6], [2, 5], [5, 8]] {
///     cells.push(CellKind::Line, &edge);
/// }
/// let mut mesh = Mesh::new((0..9).map(node).collect(), cells)?;
/// mesh.add_tag("left", [4, 5])?;
/// mesh.add_tag("right", [6, 7])?;
///
/// let morph = Morph::new(
///     mesh,
///     MorphOptions {
///         moving: "left".into(),
///         fixed: "right".into(),
///         ..Default::default()
///     },
/// )?;
/// assert_eq!(morph.moving(), [0, 3, 6]);
/// let points = morph.points(&[[0.1, 0.2, 0.0]; 3])?;
/// assert_eq!(points[3], [0.1, 1.2, 0.0]);
/// assert_eq!(points[5], [2.0, 1.0, 0.0]);
///
/// // Derivative of the height of the middle node with respect to the displacements of the moving ones.
/// let mut gradient = vec![[0.0; 3]; 9];
/// gradient[4][1] = 1.0;
/// let by_moving = morph.pull_back(&gradient)?;
/// let height: f64 = by_moving.iter().map(|g| 0.2 * g[1]).sum();
/// assert!((points[4][1] - 1.0 - height).abs() < 1e-12);
/// # Ok::<(), azimesh::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Morph {
    mesh: Arc<Mesh>,
    surface: MorphSurface,
    pairs: Pairs,
    basis: Basis,
    /// Indices of the base points among the surface points, ascending.
    base: Vec<usize>,
    /// The error that they leave.
    error: f64,
    tolerance: f64,
    system: FactoredSystem,
    /// Base points and their images.
    sources: Vec<Vector>,
    /// The nodes that they influence, along a space-filling curve.
    order: Vec<u32>,
    fade_radius: Vec<f64>,
    rows: Vec<Faded>,
    /// The surface point that each added point of the rows is an image of, and its map.
    added: Vec<(u32, Transform)>,
}

/// Errors of the base points at the surface, before the correction.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Mesh, Morph, MorphOptions};
///
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// let options = MorphOptions {
///     moving: "airfoil".into(),
///     fixed: "farfield".into(),
///     ..Default::default()
/// };
/// let morph = Morph::new(mesh, options)?;
/// let report = morph.report(&vec![[0.0, 0.01, 0.0]; morph.moving().len()])?;
/// assert!(report.largest_residual < 0.01);
/// # Ok::<(), azimesh::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MorphReport {
    /// Largest distance between a prescribed displacement and the interpolant, in mesh units.
    pub largest_residual: f64,
    /// Largest ratio of these distances to the fade radius of the correction. The correction compresses cells by up to 2.1
    /// times this ratio.
    pub largest_slope: f64,
    /// The node where it is largest.
    pub steepest_node: u32,
    /// Surface nodes where it is above 0.1, ascending: cells near them may fold. The remedy is more base points, or samples
    /// like these displacements.
    pub steep_nodes: Vec<u32>,
}

impl Morph {
    /// Selects base points, factors their system and finds the closest surface points of all nodes.
    ///
    /// It stores 4 bytes for each node that base points influence, 40 for each node within the fade radius of the
    /// correction, and `8 n^2` for each factor, in addition to the mesh.
    ///
    /// # Errors
    /// A mesh that is not valid; options out of range; a tag or node that is not in the mesh; a node in two lists; sliding
    /// on curved boundaries, which is not linear; pairs of sides that do not match; base points too close for the support
    /// radius.
    pub fn new(mesh: impl Into<Arc<Mesh>>, options: MorphOptions) -> Result<Self> {
        let mesh = mesh.into();
        options.check()?;
        mesh.validate()?;
        let (mut surface, pairs) = MorphSurface::new(&mesh, &options)?;
        let basis = base::basis(&options, &mesh.points, &surface)?;
        let space = Space {
            constraints: surface.points.constraints(surface.points.sliding.as_ref()),
            images: Arc::new(pairs.images(basis.radius)?),
            ..Space::radial(basis)
        };
        let (base, error) = base::choose(&options, &space, &surface, &pairs.is_image)?;
        let places: Vec<Vector> = base.iter().map(|&at| surface.points.points[at]).collect();
        let constraint = |&at: &usize| surface.constraint(at);
        let constraints: Vec<Constraint> = base.iter().map(constraint).collect();
        let system = FactoredSystem::new(basis, &places, &constraints, &space.images)?;
        let sources = system.points();
        let within = Bounds::around(&sources).grown(basis.radius);
        let order = curve::rough_order(mesh.points.len(), |node| mesh.points[node], &within);
        let mut is_placed = vec![false; mesh.points.len()];
        for node in surface.nodes().chain(pairs.following()) {
            is_placed[node as usize] = true;
        }
        let images = Images {
            maps: space.images,
            leaders: pairs.leaders.clone(),
        };
        let (nodes, radius) = (&mesh.points, basis.radius);
        let FadeRows {
            fade_radius,
            rows,
            added,
        } = fade_rows(&surface, &images, &sources, radius, nodes, &is_placed);
        surface.points.facets = Vec::new();
        Ok(Self {
            mesh,
            surface,
            pairs,
            basis,
            base,
            error,
            tolerance: options.tolerance,
            system,
            sources,
            order,
            fade_radius,
            rows,
            added,
        })
    }

    /// Returns the mesh at rest.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Returns the numbers of the moving nodes, in the order of the displacements.
    pub fn moving(&self) -> &[u32] {
        &self.surface.moving
    }

    /// Returns the numbers of the nodes that are base points.
    pub fn base_points(&self) -> Vec<u32> {
        let base = self.base.iter();
        base.map(|&at| self.surface.points.nodes[at]).collect()
    }

    /// Returns the error that the base points leave, in the sense of [`MorphOptions::tolerance`].
    pub fn selection_error(&self) -> f64 {
        self.error
    }

    /// Returns a warning if the base points do not meet the tolerance, as with
    /// [`max_points`](MorphOptions::max_points) of them.
    pub fn warning(&self) -> Option<Note> {
        (self.error > self.tolerance).then(|| {
            note!(
                "morph_tolerance",
                "{} base points leave an error of {}, above the tolerance of {}; a larger `max_points` or `tolerance` would help",
                self.base.len(),
                short(self.error),
                short(self.tolerance)
            )
        })
    }

    /// Returns the kernel and the support radius.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// Returns the positions of all nodes (n, 3) for `displacements` (n_moving, 3), in mesh units. Moving and fixed nodes are
    /// exact to the last bit.
    ///
    /// # Errors
    /// A wrong number of displacements; one that is not finite, or leaves the plane of a plane mesh; different ones at nodes
    /// of one position or of a periodic pair.
    pub fn points(&self, displacements: &[[f64; 3]]) -> Result<Vec<[f64; 3]>> {
        let mut points = self.displacements_of(displacements)?;
        let reference = &self.mesh.points;
        parallel::update(&mut points, |node, x| *x = add(reference[node], *x));
        for &node in &self.surface.fixed {
            points[node as usize] = reference[node as usize];
        }
        for &(node, point) in &self.surface.sliding {
            let held = self.surface.constraint(point as usize);
            points[node as usize] = held.hold(reference[node as usize], points[node as usize]);
        }
        self.pairs.place(reference, &mut points);
        Ok(points)
    }

    /// Applies the linear part `A d`: returns displacements of all nodes (n, 3) for displacements of the moving nodes
    /// (n_moving, 3).
    ///
    /// # Errors
    /// Like [`points`](Self::points).
    pub fn displacements_of(&self, displacements: &[[f64; 3]]) -> Result<Vec<[f64; 3]>> {
        let values = self.surface.values(displacements)?;
        let mut out = vec![[0.0; 3]; self.mesh.points.len()];
        let interpolant = self.interpolant(&values);
        let rows = out.as_flattened_mut();
        evaluate_along(&interpolant, &self.mesh.points, &self.order, rows, &|_| {});
        let residuals = self.residuals(&values, |point| {
            out[self.surface.points.nodes[point] as usize]
        });
        self.correct(&residuals, &mut out);
        for (node, point) in self.surface.moving_points() {
            out[node as usize] = values[point as usize];
        }
        for &node in &self.surface.fixed {
            out[node as usize] = [0.0; 3];
        }
        for &(node, point) in &self.surface.sliding {
            let held = self.surface.constraint(point as usize);
            out[node as usize] = held.remove(out[node as usize]);
        }
        self.pairs.follow(&mut out);
        Ok(out)
    }

    /// Applies the transpose `A^T g`. For a function with derivatives `gradient` (n, 3) with respect to the positions of all
    /// nodes, it returns the derivatives (n_moving, 3) with respect to the displacements of the moving nodes.
    ///
    /// Of moving nodes at one position, or of a periodic pair, the leader has the derivatives of all. In a plane mesh the
    /// third component is zero.
    ///
    /// # Errors
    /// A wrong number of derivatives, and one that is not finite.
    pub fn pull_back(&self, gradient: &[[f64; 3]]) -> Result<Vec<[f64; 3]>> {
        check_length("derivative", gradient.len(), self.mesh.points.len())?;
        for (g, node) in gradient.iter().zip(0..) {
            check_finite("derivative", g, node)?;
        }
        let mut g: Vec<Vector> = gradient.iter().map(|g| self.surface.in_mesh(*g)).collect();
        self.pairs.pull_back(&mut g);
        let mut by_values = vec![[0.0; 3]; self.surface.points.points.len()];
        for (node, point) in self.surface.moving_points() {
            let by_value = &mut by_values[point as usize];
            *by_value = add(*by_value, std::mem::take(&mut g[node as usize]));
        }
        for &node in &self.surface.fixed {
            g[node as usize] = [0.0; 3];
        }
        for &(node, point) in &self.surface.sliding {
            let held = self.surface.constraint(point as usize);
            g[node as usize] = held.remove(g[node as usize]);
        }
        self.pull_back_correction(&mut g, &mut by_values);
        let by_weights = transposed(
            self.basis,
            &self.sources,
            &self.mesh.points,
            &self.order,
            &g,
        );
        let by_base = self.system.transposed(&by_weights);
        for (&at, by_base) in self.base.iter().zip(&by_base) {
            by_values[at] = add(by_values[at], *by_base);
        }
        Ok(self.surface.pull_back(&by_values))
    }

    /// Reports the errors of the base points at the surface for these displacements, and the nodes where the correction may
    /// fold cells.
    ///
    /// # Errors
    /// Like [`points`](Self::points).
    pub fn report(&self, displacements: &[[f64; 3]]) -> Result<MorphReport> {
        let values = self.surface.values(displacements)?;
        let places = &self.surface.points.points;
        let mut found = vec![[0.0; 3]; places.len()];
        self.interpolant(&values)
            .add_at(places, found.as_flattened_mut());
        let residuals = self.residuals(&values, |point| found[point]);
        let nodes = &self.surface.points.nodes;
        let mut report = MorphReport {
            largest_residual: 0.0,
            largest_slope: 0.0,
            steepest_node: nodes[0],
            steep_nodes: Vec::new(),
        };
        for ((residual, fade_radius), &node) in residuals.iter().zip(&self.fade_radius).zip(nodes) {
            let residual = norm(*residual);
            let slope = if residual > 0.0 {
                residual / fade_radius
            } else {
                0.0
            };
            report.largest_residual = report.largest_residual.max(residual);
            if slope > report.largest_slope {
                report.largest_slope = slope;
                report.steepest_node = node;
            }
            if slope > STEEP {
                report.steep_nodes.push(node);
            }
        }
        report.steep_nodes.sort_unstable();
        Ok(report)
    }

    /// Returns the interpolant of values (N_s, 3) at the surface points.
    fn interpolant(&self, values: &[Vector]) -> Interpolant {
        let at_base: Vec<Vector> = self.base.iter().map(|&at| values[at]).collect();
        let weighted = self.system.weights(&at_base);
        Interpolant {
            basis: self.basis,
            points: weighted.points,
            weights: weighted.weights,
            n_columns: 3,
            polynomial: None,
        }
    }

    /// Returns the residual at every surface point, along its constraint.
    fn residuals(&self, values: &[Vector], found: impl Fn(usize) -> Vector) -> Vec<Vector> {
        let values = values.iter().enumerate();
        values
            .map(|(at, value)| self.surface.constraint(at).project(sub(*value, found(at))))
            .collect()
    }

    /// Adds the residuals, fading out.
    fn correct(&self, residuals: &[Vector], out: &mut [Vector]) {
        let mut residuals = residuals.to_vec();
        for (point, map) in &self.added {
            residuals.push(map.turn(residuals[*point as usize]));
        }
        parallel::for_blocks(out, BLOCK, &|first, out| {
            let before = |end: usize| self.rows.partition_point(|row| (row.point as usize) < end);
            for row in &self.rows[before(first)..before(first + out.len())] {
                let out = &mut out[row.point as usize - first];
                for (&corner, weight) in row.corners.iter().zip(row.weights) {
                    *out = add(*out, scale(residuals[corner as usize], weight));
                }
            }
        });
    }

    /// Applies the transpose of the correction and of its residuals: adds to the derivatives with respect to surface values,
    /// and subtracts from the derivatives at the nodes of the residuals.
    fn pull_back_correction(&self, g: &mut [Vector], by_values: &mut [Vector]) {
        let n = by_values.len();
        let mut by_residuals = vec![[0.0; 3]; n + self.added.len()];
        for row in &self.rows {
            for (&corner, weight) in row.corners.iter().zip(row.weights) {
                let sum = &mut by_residuals[corner as usize];
                *sum = add(*sum, scale(g[row.point as usize], weight));
            }
        }
        for ((point, map), at) in self.added.iter().zip(n..) {
            let of_image = map.inverse().turn(by_residuals[at]);
            let sum = &mut by_residuals[*point as usize];
            *sum = add(*sum, of_image);
        }
        let nodes = &self.surface.points.nodes;
        for (at, (by_residual, &node)) in by_residuals.iter().zip(nodes).enumerate() {
            let along = self.surface.constraint(at).project(*by_residual);
            by_values[at] = add(by_values[at], along);
            g[node as usize] = sub(g[node as usize], along);
        }
    }
}

#[cfg(test)]
mod tests;
