//! Shapes for cells whose reference is folded or flat: regular ones, with the edge lengths that the cell has.
//!
//! Folding changes the lengths of edges least of all, so that a thin cell stays thin.

use azimesh_core::geometry::vector::{Vector, distance, scale};
use azimesh_io::mesh::CellKind;

/// Corners of a regular cell of this kind with the edge lengths of the cell at `p`; of orientation `sign`. `size` is
/// the length that is used where edges have none. `None` for polygons, polyhedra and prisms on five or six corners.
pub(super) fn regular(kind: CellKind, p: &[Vector], sign: f64, size: f64) -> Option<Vec<Vector>> {
    let length = |edges: &[[usize; 2]]| {
        let lengths = edges.iter().map(|&[a, b]| distance(p[a], p[b]));
        let middle = median(lengths.collect());
        if middle > 1e-6 * size { middle } else { size }
    };
    let flat = |points: &[[f64; 2]], by: [f64; 2]| -> Vec<Vector> {
        let mirrored = points
            .iter()
            .map(|[x, y]| [by[0] * x, sign * by[1] * y, 0.0]);
        mirrored.collect()
    };
    Some(match kind.linear() {
        CellKind::Triangle => flat(&TRIANGLE, [length(&[[0, 1], [1, 2], [2, 0]]); 2]),
        CellKind::Quadrilateral => {
            let by = [length(&[[0, 1], [3, 2]]), length(&[[0, 3], [1, 2]])];
            flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], by)
        }
        CellKind::Tetrahedron => {
            let edge = length(&[[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
            let upright = TETRAHEDRON.map(|[x, y, z]| [x, y, sign * z]);
            upright.map(|x| scale(x, edge)).to_vec()
        }
        CellKind::Pyramid => {
            let base = length(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
            let side = length(&[[0, 4], [1, 4], [2, 4], [3, 4]]);
            let height = (side * side - 0.5 * base * base)
                .max(0.01 * base * base)
                .sqrt();
            let mut corners = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [base; 2]);
            corners.push([0.5 * base, sign * 0.5 * base, height]);
            corners
        }
        CellKind::Wedge => {
            let side = length(&[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]]);
            upright(
                flat(&TRIANGLE, [side; 2]),
                length(&[[0, 3], [1, 4], [2, 5]]),
            )
        }
        CellKind::Hexahedron => {
            let by = [
                length(&[[0, 1], [3, 2], [4, 5], [7, 6]]),
                length(&[[0, 3], [1, 2], [4, 7], [5, 6]]),
            ];
            let base = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], by);
            upright(base, length(&[[0, 4], [1, 5], [2, 6], [3, 7]]))
        }
        _ => return None,
    })
}

/// The equilateral triangle with unit edges.
const TRIANGLE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.866_025_403_784_438_6]];

/// The regular tetrahedron with unit edges.
const TETRAHEDRON: [Vector; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.5, 0.866_025_403_784_438_6, 0.0],
    [0.5, 0.288_675_134_594_812_9, 0.816_496_580_927_726],
];

/// A prism over a base.
fn upright(base: Vec<Vector>, height: f64) -> Vec<Vector> {
    let top = base.iter().map(|[x, y, _]| [*x, *y, height]);
    let top: Vec<Vector> = top.collect();
    [base, top].concat()
}

/// The middle value, or the mean of the two in the middle.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}
