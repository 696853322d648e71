//! Faces and cells as finite-volume solvers have them: centres, areas and volumes by OpenFOAM's
//! decomposition, and what is measured between two centres.
//!
//! Source: OpenFOAM v1912, `primitiveMeshFaceCentresAndAreas.C`, `primitiveMeshCellCentresAndVols.C`,
//! `primitiveMeshTools.C` and `polyMeshTools.C`; its formulas, in code of our own.

use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

/// Keeps quotients finite where a length is zero, as in OpenFOAM; far below any length.
const TINY: f64 = 1e-150;
const TINIEST: f64 = 1e-300;

/// A face, or an edge of a plane mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub centre: Vector,
    /// Normal with the length of the area (in a plane mesh, of the edge).
    pub area: Vector,
}

/// A cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Centre {
    pub at: Vector,
    /// Volume, or area in a plane mesh; negative where the faces point inward.
    pub volume: f64,
}

impl Centre {
    /// In place of one that is not there.
    pub(super) const NONE: Self = Self {
        at: [f64::NAN; 3],
        volume: f64::NAN,
    };
}

/// Metrics of a face between two cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceMetrics {
    /// Cosine of the angle between its normal and the line between the centres.
    pub cosine: f64,
    pub skewness: f64,
    /// Smaller volume over larger.
    pub volume_ratio: f64,
    /// Of interpolation between the centres: 0.5 half way, 0 where the face is at a centre.
    pub weight: f64,
}

/// An edge of a plane mesh with this normal, to the right of the direction from `a` to `b`.
#[inline(always)]
pub(super) fn edge(a: Vector, b: Vector, normal: Vector) -> Face {
    Face {
        centre: scale(add(a, b), 0.5),
        area: cross(sub(b, a), normal),
    }
}

#[inline(always)]
pub(super) fn triangle(a: Vector, b: Vector, c: Vector) -> Face {
    Face {
        centre: scale(add(add(a, b), c), 1.0 / 3.0),
        area: scale(cross(sub(b, a), sub(c, a)), 0.5),
    }
}

/// A face of `n` corners as triangles `t` around the mean `m` of its corners.
///
/// ```text
/// A = sum A_t,   centre = sum |A_t| c_t / sum |A_t|,   c_t the mean of a triangle's corners
/// ```
#[inline(always)]
pub(super) fn polygon(n: usize, corner: impl Fn(usize) -> Vector) -> Face {
    let mut sum = [0.0; 3];
    for i in 0..n {
        sum = add(sum, corner(i));
    }
    let mean = scale(sum, 1.0 / n as f64);
    let (mut area, mut size, mut moment) = ([0.0; 3], 0.0, [0.0; 3]);
    for i in 0..n {
        let (a, b) = (corner(i), corner(if i + 1 == n { 0 } else { i + 1 }));
        let twice = cross(sub(b, a), sub(mean, a));
        let length = norm(twice);
        area = add(area, twice);
        size += length;
        moment = add(moment, scale(add(add(a, b), mean), length));
    }
    let centre = scale(moment, 1.0 / (3.0 * size));
    let is_flat = size < TINY;
    Face {
        centre: choose(is_flat, mean, centre),
        area: scale(area, 0.5),
    }
}

/// `a` if it is so, else `b`; for each axis, so that faces side by side need no jump.
#[inline(always)]
fn choose(is_so: bool, a: Vector, b: Vector) -> Vector {
    [
        if is_so { a[0] } else { b[0] },
        if is_so { a[1] } else { b[1] },
        if is_so { a[2] } else { b[2] },
    ]
}

/// A face by its number of corners.
#[inline(always)]
pub(super) fn face(n: usize, corner: impl Fn(usize) -> Vector, normal: Vector) -> Face {
    match n {
        2 => edge(corner(0), corner(1), normal),
        3 => triangle(corner(0), corner(1), corner(2)),
        _ => polygon(n, corner),
    }
}

/// A cell of these faces as pyramids between them and the mean `m` of their centres.
///
/// ```text
/// d V_f = A_f . (c_f - m),   V = sum V_f,   centre = sum V_f (d c_f + m) / (d + 1) / V
/// ```
///
/// `d` is 3; it is 2 in a plane mesh, where faces are edges. Sides that have collapsed are left out.
#[inline(always)]
pub(super) fn cell(faces: &[Face], dimension: u8) -> Centre {
    let d = f64::from(dimension);
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    for i in 0..faces.len() {
        let is_there = dot(faces[i].area, faces[i].area) > 0.0;
        let counts = if is_there { 1.0 } else { 0.0 };
        sum = add(sum, scale(faces[i].centre, counts));
        n += counts;
    }
    let mean = scale(sum, 1.0 / n);
    let (mut volume, mut moment) = (0.0, [0.0; 3]);
    for i in 0..faces.len() {
        let Face { centre, area } = faces[i];
        let part = dot(area, sub(centre, mean));
        moment = add(moment, scale(add(scale(centre, d), mean), part));
        volume += part;
    }
    let centre = scale(moment, 1.0 / ((d + 1.0) * volume));
    let is_empty = volume.abs() <= TINIEST;
    Centre {
        at: choose(is_empty, mean, centre),
        volume: volume / d,
    }
}

/// A triangle of a plane mesh; the same as [`cell`] of its edges.
#[inline(always)]
pub(super) fn plane_simplex(p: [Vector; 3], normal: Vector) -> Centre {
    Centre {
        at: scale(add(add(p[0], p[1]), p[2]), 1.0 / 3.0),
        volume: 0.5 * dot(cross(sub(p[1], p[0]), sub(p[2], p[0])), normal),
    }
}

/// A tetrahedron; the same as [`cell`] of its faces.
#[inline(always)]
pub(super) fn solid_simplex(p: [Vector; 4]) -> Centre {
    let [a, b, c] = [sub(p[1], p[0]), sub(p[2], p[0]), sub(p[3], p[0])];
    Centre {
        at: scale(add(add(p[0], p[1]), add(p[2], p[3])), 0.25),
        volume: dot(a, cross(b, c)) / 6.0,
    }
}

/// A face of `n` corners between two cells, its area pointing from the first to the second, with
/// centres `o` and `p`, and `d = p - o`.
///
/// ```text
/// cosine    d . A / (|d| |A|)
/// skewness  |s| / max(0.2 |d|, max over corners of |s . (x - c)| / |s|),   s = c - o - (A . (c - o) / A . d) d
/// ratio     min(V_o, V_p) / max(V_o, V_p)
/// weight    min(h_o, h_p) / (h_o + h_p),   h_o = |A . (c - o)|,  h_p = |A . (p - c)|
/// ```
#[inline(always)]
pub(super) fn inner(
    face: &Face,
    n: usize,
    corner: impl Fn(usize) -> Vector,
    first: &Centre,
    second: &Centre,
) -> FaceMetrics {
    let to_face = sub(face.centre, first.at);
    let between = sub(second.at, first.at);
    let length = norm(between);
    let along = dot(face.area, between);
    let before = dot(face.area, to_face);
    let off = sub(to_face, scale(between, before / (along + TINY)));
    let after = dot(face.area, sub(second.at, face.centre));
    let (h_first, h_second) = (before.abs(), after.abs());
    let (low, high) = if first.volume < second.volume {
        (first.volume, second.volume)
    } else {
        (second.volume, first.volume)
    };
    FaceMetrics {
        cosine: along / (length * norm(face.area) + TINY),
        skewness: skewness(off, 0.2 * length, face.centre, n, corner),
        volume_ratio: low / (high + TINIEST),
        weight: (if h_first < h_second {
            h_first
        } else {
            h_second
        }) / (h_first + h_second + TINIEST),
    }
}

/// Skewness of a face on the boundary, with its cell's mirror image behind it.
///
/// ```text
/// |s| / max(0.4 |d|, max over corners of |s . (x - c)| / |s|),   d = n (n . (c - o)),  s = c - o - d
/// ```
pub(super) fn outer_skewness(
    face: &Face,
    n: usize,
    corner: impl Fn(usize) -> Vector,
    cell: &Centre,
) -> f64 {
    let to_face = sub(face.centre, cell.at);
    let normal = scale(face.area, 1.0 / (norm(face.area) + TINIEST));
    let height = scale(normal, dot(normal, to_face));
    let part = dot(face.area, to_face) / (dot(face.area, height) + TINY);
    let off = sub(to_face, scale(height, part));
    skewness(off, 0.4 * norm(height), face.centre, n, corner)
}

/// Distance of the centre of the face from a line, as a part of the face's extent in that direction.
#[inline(always)]
fn skewness(
    off: Vector,
    least: f64,
    centre: Vector,
    n: usize,
    corner: impl Fn(usize) -> Vector,
) -> f64 {
    let length = norm(off);
    let inverse = 1.0 / (length + TINY);
    let mut extent = least + TINY;
    for i in 0..n {
        let reach = dot(off, sub(corner(i), centre)).abs() * inverse;
        extent = if reach > extent { reach } else { extent };
    }
    length / extent
}
