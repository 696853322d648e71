//! Metrics in addition to the summary: Jacobian, aspect ratio, condition, shape, angles and skew.
//!
//! Owns what they are for each kind of cell: VTK's where VTK has the metric (but for the faults of
//! VTK that are named where they are avoided). They take roots and arc cosines of every cell, so
//! they are computed only on request.

mod plane;
mod solid;

use super::angles::Angles;
use super::reference::Reference;
use super::span::Span;
use super::summary::{Extreme, keep_less};
use super::validity::CurvedMaps;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::{self, block};
use azimesh_io::mesh::{CellKind, DataArray, Mesh, Values};
use std::ops::Range;

/// Number of these metrics.
pub(super) const N_DETAILS: usize = 9;

/// Name of each in tables, and of its cell array.
pub(super) const NAMES: [(&str, &str); N_DETAILS] = [
    ("jacobian", "Jacobian"),
    ("aspect_ratio", "AspectRatio"),
    ("condition", "Condition"),
    ("shape", "Shape"),
    ("min_angle", "MinAngle"),
    ("max_angle", "MaxAngle"),
    ("skew", "Skew"),
    CURVED[0],
    CURVED[1],
];

/// The last of them, which only meshes with curved cells have.
pub(super) const CURVED: [(&str, &str); 2] = [
    ("curved_jacobian", "CurvedJacobian"),
    ("curved_scaled_jacobian", "CurvedScaledJacobian"),
];

/// Values of one cell; NaN where its kind does not have the metric, infinite where a flat cell has
/// no bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct Detail {
    /// Smallest Jacobian at a corner (and at the centre of a hexahedron); of a triangle twice its area.
    pub jacobian: f64,
    /// Longest edge over the diameter of the inscribed circle or sphere, 1 for the ideal cell.
    pub aspect_ratio: f64,
    /// Largest condition number of the Jacobian matrix at a corner, 1 for the ideal cell.
    pub condition: f64,
    /// Smallest mean ratio at a corner: 1 for the ideal cell, 0 for an inverted one.
    pub shape: f64,
    /// Smallest and largest angle in degrees: between the faces of a tetrahedron, of the faces of
    /// other cells.
    pub angle: Span,
    /// Largest cosine between the principal axes: 0 to 1.
    pub skew: f64,
    /// Least Jacobian and least scaled Jacobian of a [curved cell](super::validity::CurvedMap::least).
    pub curved: [f64; 2],
}

impl Detail {
    pub(super) const NONE: Self = Self {
        jacobian: f64::NAN,
        aspect_ratio: f64::NAN,
        condition: f64::NAN,
        shape: f64::NAN,
        angle: Span::UNDEFINED,
        skew: f64::NAN,
        curved: [f64::NAN; 2],
    };

    /// In the order of [`NAMES`].
    pub(super) fn values(&self) -> [f64; N_DETAILS] {
        [
            self.jacobian,
            self.aspect_ratio,
            self.condition,
            self.shape,
            self.angle.low,
            self.angle.high,
            self.skew,
            self.curved[0],
            self.curved[1],
        ]
    }

    /// Of a cell with these extreme `angles`, as its mirror image where `sign` is negative.
    fn of(kind: CellKind, cell: &Placed<'_>, sign: i8, angles: &Angles) -> Self {
        let turn = f64::from(sign);
        let facing = cell.facing.map(|x| turn * x);
        let detail = match kind.linear() {
            CellKind::Triangle => plane::triangle(&cell.corners(1.0), facing),
            CellKind::Quadrilateral => plane::quadrilateral(&cell.corners(1.0), facing),
            CellKind::Tetrahedron => solid::tetrahedron(&cell.corners(turn)),
            CellKind::Pyramid => solid::pyramid(&cell.corners(turn)),
            CellKind::Wedge => solid::wedge(&cell.corners(turn)),
            CellKind::Hexahedron => solid::hexahedron(&cell.corners(turn)),
            _ => return Self::NONE,
        };
        let angle = match kind.linear() {
            CellKind::Tetrahedron => angles.between_faces(),
            _ => angles.of_faces(),
        };
        Self { angle, ..detail }
    }
}

/// A cell where it is.
struct Placed<'a> {
    nodes: &'a [u32],
    points: &'a [Vector],
    facing: Vector,
}

impl Placed<'_> {
    /// Its corners, with x multiplied by `turn`.
    fn corners<const N: usize>(&self, turn: f64) -> [Vector; N] {
        let mut corners = [[0.0; 3]; N];
        for k in 0..N {
            let [x, y, z] = self.points[self.nodes[k] as usize];
            corners[k] = [turn * x, y, z];
        }
        corners
    }
}

/// Calls `visit(cell, summary's metrics, these)` for the volume cells of `range`, in order.
pub(super) fn each(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    curved: &CurvedMaps,
    range: Range<usize>,
    mut visit: impl FnMut(usize, &super::metrics::Metrics, &Detail),
) {
    let facing = reference.facing();
    visit::volume_cells(mesh, points, facing, range, |first, block| {
        let runs = mesh.cells.runs_in(first..first + block.n);
        for (i, listed) in runs.flat_map(|run| run.cell_refs()).enumerate() {
            let (cell, metrics) = (first + i, block.get(i));
            let one = listed.uncollapsed();
            let shape = one.as_ref().map_or(listed, |one| one.get(0));
            let placed = Placed {
                nodes: shape.nodes,
                points,
                facing: facing.of(cell),
            };
            let sign = reference.sign(cell);
            let mut detail = Detail::of(shape.kind, &placed, sign, &metrics.angles);
            if let Some(map) = curved.of(listed.kind, listed.nodes.len()) {
                detail.curved = map.least(listed.nodes, points, sign, metrics.volume);
            }
            visit(cell, &metrics, &detail);
        }
    });
}

/// The metrics that [`super::per_cell`] does not have as cell arrays `Jacobian`, `AspectRatio`,
/// `Condition`, `Shape`, `MinAngle`, `MaxAngle` (degrees) and `Skew`; with curved cells also `CurvedJacobian` and
/// `CurvedScaledJacobian`. Boundary faces, and cells whose kind does not have the metric, hold NaN.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` is of a mesh with fewer cells.
pub fn detail_arrays(mesh: &Mesh, points: &[Vector], reference: &Reference) -> Vec<DataArray> {
    let n_cells = mesh.cells.len();
    let curved = CurvedMaps::new(mesh);
    let names = match curved.is_empty() {
        true => &NAMES[..N_DETAILS - CURVED.len()],
        false => &NAMES,
    };
    let mut columns = vec![vec![f64::NAN; n_cells]; names.len()];
    let mut chunks: Vec<Vec<&mut [f64]>> = Vec::new();
    chunks.resize_with(n_cells.div_ceil(CHUNK), || Vec::with_capacity(N_DETAILS));
    for column in &mut columns {
        for (chunk, part) in chunks.iter_mut().zip(column.chunks_mut(CHUNK)) {
            chunk.push(part);
        }
    }
    parallel::for_items(chunks, &|chunk, mut parts| {
        let range = block(n_cells, CHUNK, chunk);
        let first = range.start;
        each(
            mesh,
            points,
            reference,
            &curved,
            range,
            |cell, _, detail| {
                for (part, value) in parts.iter_mut().zip(detail.values()) {
                    part[cell - first] = value;
                }
            },
        );
    });
    let named = names.iter().zip(columns);
    named
        .map(|((_, name), column)| DataArray::scalar(*name, Values::F64(column)))
        .collect()
}

/// The least of the last two metrics over the own cells of a mesh.
pub(super) fn least_curved(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
) -> [Option<Extreme>; 2] {
    let curved = CurvedMaps::new(mesh);
    if curved.is_empty() {
        return [None; 2];
    }
    let chunks = parallel::map_blocks_in(mesh.own_cells(), CHUNK, &|range| {
        let mut found = [None; 2];
        visit::volume_cells(mesh, points, reference.facing(), range, |first, block| {
            let runs = mesh.cells.runs_in(first..first + block.n);
            for (i, cell) in runs.flat_map(|run| run.cell_refs()).enumerate() {
                if let Some(map) = curved.of(cell.kind, cell.nodes.len()) {
                    let sign = reference.sign(cell.index);
                    let values = map.least(cell.nodes, points, sign, block.volume[i]);
                    for (found, value) in found.iter_mut().zip(values) {
                        if !value.is_nan() {
                            keep_less(found, value, cell.index + mesh.own_offset());
                        }
                    }
                }
            }
        });
        found
    });
    chunks.into_iter().fold([None; 2], least_of_both)
}

/// The lesser values of two parts of a mesh.
pub(super) fn least_of_both(
    mut all: [Option<Extreme>; 2],
    own: [Option<Extreme>; 2],
) -> [Option<Extreme>; 2] {
    for (all, own) in all.iter_mut().zip(own) {
        if let Some(own) = own {
            keep_less(all, own.value, own.cell);
        }
    }
    all
}

/// `a / b`, and infinite where `b` is not positive.
fn over(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { f64::INFINITY }
}
