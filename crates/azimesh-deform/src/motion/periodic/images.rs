//! The images of a periodic mesh that the support radius reaches.

use super::{Periodic, Symmetry};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, cross, distance, norm};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::numbers::{in_digits, short};

/// More images than this are refused.
const MOST_IMAGES: usize = 360;
/// Relative tolerance within which an angle must be a whole part of a circle.
const PART_OF_CIRCLE: f64 = 1e-6;
/// Maps of two pairs that differ by less than this part of the extent are equal.
const SAME: f64 = 1e-6;

/// Returns every map except the identity whose image of `bounds` is within `radius` of `bounds`: all turns of a
/// rotation, and as many multiples of a translation by `L` as reach, in both directions:
///
/// ```text
/// |j| <= ceil((R + extent along L) / |L|)
/// ```
///
/// Pairs with equal maps count once; different maps are combined.
///
/// # Errors
/// More than 360 images; an angle that does not divide the circle; maps of several pairs that do not commute.
pub fn images(pairs: &[Periodic], radius: f64, bounds: &Bounds) -> Result<Vec<Transform>> {
    let symmetries = distinct(pairs, bounds)?.symmetries;
    let mut group = vec![Transform::IDENTITY];
    for symmetry in &symmetries {
        let powers = powers(symmetry, radius, bounds)?;
        let n_images = group.len().saturating_mul(powers.len() + 1) - 1;
        if n_images > MOST_IMAGES {
            return Err(too_many(n_images, radius));
        }
        let combined = powers
            .iter()
            .flat_map(|power| group.iter().map(|g| g.then(power)))
            .collect::<Vec<_>>();
        group.extend(combined);
    }
    group.remove(0);
    Ok(group)
}

fn too_many(n_images: usize, radius: f64) -> Error {
    Error::input(format!(
        "the support radius {} reaches {n_images} images of the periodic mesh; at most {MOST_IMAGES} are \
         possible: set a smaller rbf.support_radius",
        short(radius)
    ))
}

/// The different maps of some pairs.
pub(super) struct Distinct {
    /// Maps that are neither equal nor inverse to an earlier one.
    pub symmetries: Vec<Symmetry>,
    /// Index of the map of each pair, and its direction: forwards (1) or backwards (-1).
    pub of_pairs: Vec<(usize, i32)>,
}

/// # Errors
/// Maps that do not commute.
pub(super) fn distinct(pairs: &[Periodic], bounds: &Bounds) -> Result<Distinct> {
    let mut found: Vec<Symmetry> = Vec::new();
    let mut of_pairs = Vec::with_capacity(pairs.len());
    for pair in pairs {
        let sense = |other: &Symmetry| {
            [1, -1]
                .into_iter()
                .find(|&sense| are_same(&pair.transform, &other.power(sense), bounds))
        };
        let mut known = found.iter().enumerate();
        if let Some(known) = known.find_map(|(i, other)| Some((i, sense(other)?))) {
            of_pairs.push(known);
            continue;
        }
        if found.iter().any(|other| !combine(&pair.symmetry, other)) {
            return Err(Error::input(
                "the maps of two periodic pairs cannot be combined: all rotations must be the same, \
                 translations must be along their axis, and no two translations may be parallel",
            ));
        }
        of_pairs.push((found.len(), 1));
        found.push(pair.symmetry);
    }
    Ok(Distinct {
        symmetries: found,
        of_pairs,
    })
}

/// Returns whether two maps move the corners of the box to the same positions.
fn are_same(a: &Transform, b: &Transform, bounds: &Bounds) -> bool {
    let limit = SAME * bounds.diagonal();
    (0..8).all(|corner| {
        let side = |k: usize| [bounds.low[k], bounds.high[k]][corner >> k & 1];
        let x: Vector = std::array::from_fn(side);
        distance(a.apply(x), b.apply(x)) <= limit
    })
}

/// Returns whether the products of two maps form a group in which each product occurs once.
fn combine(a: &Symmetry, b: &Symmetry) -> bool {
    let across = |a: &Vector, b: &Vector| norm(cross(*a, *b)) / (norm(*a) * norm(*b));
    match (a, b) {
        (Symmetry::Translation(a), Symmetry::Translation(b)) => across(a, b) > SAME,
        (Symmetry::Translation(by), Symmetry::Rotation { axis, .. })
        | (Symmetry::Rotation { axis, .. }, Symmetry::Translation(by)) => {
            across(by, &axis.direction) <= SAME
        }
        (Symmetry::Rotation { .. }, Symmetry::Rotation { .. }) => false,
    }
}

/// Returns the needed powers of a map, without the identity.
fn powers(symmetry: &Symmetry, radius: f64, bounds: &Bounds) -> Result<Vec<Transform>> {
    match symmetry {
        Symmetry::Translation(by) => {
            let length = norm(*by);
            let sizes = (0..3).map(|k| by[k].abs() / length * (bounds.high[k] - bounds.low[k]));
            let extent = sizes.sum::<f64>().max(0.0);
            let copies = ((radius + extent) / length).ceil();
            if copies.is_nan() || 2.0 * copies > MOST_IMAGES as f64 {
                return Err(too_many((2.0 * copies) as usize, radius));
            }
            let copies = copies as i32;
            let both = (1..=copies).flat_map(|j| [j, -j]);
            Ok(both.map(|j| symmetry.power(j)).collect())
        }
        Symmetry::Rotation { angle, .. } => {
            let parts = std::f64::consts::TAU / angle.abs();
            if (parts - parts.round()).abs() > PART_OF_CIRCLE * parts {
                return Err(Error::input(format!(
                    "the periodic sides are {} degrees apart, which does not divide the full circle: it is {} \
                     sectors",
                    in_digits(angle.to_degrees().abs(), 9),
                    in_digits(parts, 9)
                )));
            }
            if parts.round() - 1.0 > MOST_IMAGES as f64 {
                return Err(too_many(parts.round() as usize - 1, radius));
            }
            Ok((1..parts.round() as i32)
                .map(|j| symmetry.power(j))
                .collect())
        }
    }
}
