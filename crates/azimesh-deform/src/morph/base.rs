//! Base points of a morph: selected by the samples if there are any, else by the power function.

use super::options::MorphOptions;
use super::surface::MorphSurface;
use crate::plan::prepare::kernel;
use crate::plan::surface::SurfacePoints;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::vector::{Vector, norm};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::parallel::{SMALL_BLOCK, collect_in_blocks};
use azimesh_rbf::criterion::Criterion;
use azimesh_rbf::power::by_power;
use azimesh_rbf::select::{Limits, select};
use azimesh_rbf::space::Space;
use azimesh_rbf::targets::Targets;
use azimesh_rbf::{Basis, Kernel};

/// Largest default of the support radius, in diagonals of the moving surface.
const DEFAULT_RADIUS: f64 = 10.0;
/// Largest number of points at which the power function is evaluated, per base point.
const CANDIDATES: usize = 8;
/// Spacing of base points on surfaces at rest: at this distance from the moving surface (as a part of its diagonal)
/// it is twice as large, at twice the distance three times, and so on.
const GRADED: f64 = 0.1;

/// Returns the kernel and the support radius.
///
/// # Errors
/// If all nodes are at one position, so that no radius can be chosen.
pub fn basis(options: &MorphOptions, points: &[Vector], surface: &MorphSurface) -> Result<Basis> {
    let region = Bounds::around(points).diagonal();
    let moving = DEFAULT_RADIUS * moving_bounds(&surface.points).diagonal();
    // A single moving node has no diagonal.
    let chosen = if moving > 0.0 {
        region.min(moving)
    } else {
        region
    };
    match options.support_radius.unwrap_or(chosen) {
        radius if radius > 0.0 => Ok(Basis {
            kernel: kernel(options.kernel),
            radius,
        }),
        _ => Err(Error::input(
            "all nodes are at one position; no `support_radius` can be chosen",
        )),
    }
}

/// Selects base points. Returns their ascending indices among the surface points, which follow the space-filling curve,
/// and the error that they leave, in the sense of the tolerance.
pub fn choose(
    options: &MorphOptions,
    space: &Space,
    surface: &MorphSurface,
    is_image: &[bool],
) -> Result<(Vec<usize>, f64)> {
    let (mut base, error) = if options.samples.is_empty() {
        by_geometry(options, space, &surface.points, is_image)
    } else {
        by_samples(options, space, surface, is_image)?
    };
    base.sort_unstable();
    Ok((base, error))
}

fn moving_bounds(points: &SurfacePoints) -> Bounds {
    let all = points.points.iter().zip(&points.body);
    let moving = all.filter(|(_, body)| body.is_some());
    Bounds::around(moving.map(|(point, _)| point))
}

/// Selects greedily by the samples, each scaled to a largest displacement of one.
fn by_samples(
    options: &MorphOptions,
    space: &Space,
    surface: &MorphSurface,
    is_image: &[bool],
) -> Result<(Vec<usize>, f64)> {
    let n_points = surface.points.points.len();
    let r = 3 * options.samples.len();
    let mut values = vec![0.0; n_points * r];
    for (at, sample) in options.samples.iter().enumerate() {
        let named = |error: Error| Error::input(format!("sample {at}: {}", error.message));
        let field = surface.values(sample).map_err(named)?;
        let largest = field.iter().map(|d| norm(*d)).fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(Error::input(format!(
                "sample {at} has only zero displacements"
            )));
        }
        for (row, d) in values.chunks_exact_mut(r).zip(&field) {
            for axis in 0..3 {
                row[3 * at + axis] = d[axis] / largest;
            }
        }
    }
    let size = 3 * r;
    let mut coefficients = vec![0.0; options.samples.len() * size];
    for (sample, c) in coefficients.chunks_exact_mut(size).enumerate() {
        for axis in 0..3 {
            c[3 * (3 * sample + axis) + axis] = 1.0;
        }
    }
    let targets = Targets {
        points: &surface.points.points,
        values: &values,
        criterion: &Criterion::new(r, &coefficients)?,
        images: is_image,
        lever_arms: &[],
    };
    let limits = Limits::in_rounds(options.tolerance, options.max_points, n_points);
    let selection = select(space, targets, limits, &mut |_, _| {})?;
    Ok((selection.base, selection.measured))
}

/// Selects greedily by the power function, at points spread like the nodes of the surface.
fn by_geometry(
    options: &MorphOptions,
    space: &Space,
    points: &SurfacePoints,
    is_image: &[bool],
) -> (Vec<usize>, f64) {
    let weights = weights(space, points);
    let may_serve = |&at: &usize| weights[at] > 0.0 && !is_image.get(at).is_some_and(|is| *is);
    let all: Vec<usize> = (0..points.points.len()).filter(may_serve).collect();
    let most = CANDIDATES.saturating_mul(options.max_points);
    let some: Vec<usize> = all
        .iter()
        .step_by(all.len().div_ceil(most).max(1))
        .copied()
        .collect();
    let places: Vec<Vector> = some.iter().map(|&at| points.points[at]).collect();
    let weights: Vec<f64> = some.iter().map(|&at| weights[at]).collect();
    let (chosen, left) = by_power(
        space,
        &places,
        &weights,
        options.tolerance,
        options.max_points,
    );
    (chosen.into_iter().map(|at| some[at]).collect(), left)
}

/// Returns the weight of the power function at each point. `D` is the distance from the moving surface or an image of
/// it, and `L` the diagonal of the moving surface:
///
/// ```text
/// (1 + 10 D / L)^-beta,     0 where D >= R
/// ```
///
/// The power function falls with the `beta`-th power of the distance between base points, so their spacing grows as
/// `1 + 10 D / L`: fields of a moving surface are smoother farther away, and zero beyond the support radius.
fn weights(space: &Space, points: &SurfacePoints) -> Vec<f64> {
    let beta = match space.basis.kernel {
        Kernel::WendlandC0 => 0.5,
        Kernel::WendlandC2 => 1.5,
        Kernel::WendlandC4 => 2.5,
        Kernel::WendlandC6 => 3.5,
    };
    let moving: Vec<Vector> = points
        .points
        .iter()
        .zip(&points.body)
        .filter_map(|(point, body)| body.map(|_| *point))
        .collect();
    let lone: Vec<[u32; 3]> = (0..moving.len() as u32).map(|point| [point; 3]).collect();
    let graded = GRADED * Bounds::around(&moving).diagonal();
    let moving = ClosestSurface::new(moving, &lone);
    let weight = |point: &Vector| {
        let around = std::iter::once(&Transform::IDENTITY).chain(space.images.iter());
        let feet = around.filter_map(|g| moving.nearest(&g.apply(*point), space.basis.radius));
        let nearest = feet
            .map(|foot| foot.distance_squared)
            .min_by(f64::total_cmp);
        nearest.map_or(0.0, |squared| {
            let away = squared.sqrt();
            // A single moving node has no diagonal.
            let graded = if graded > 0.0 {
                graded
            } else {
                space.basis.radius
            };
            (1.0 + away / graded).powf(-beta)
        })
    };
    let points = &points.points;
    collect_in_blocks(points.len(), SMALL_BLOCK, |at| weight(&points[at]))
}
