//! A bound that most cells pass, for blocks of cells side by side.
//!
//! Of a hexahedron with the mean edges `x, y, z` along its axes, from which single edges differ by at most `u, v, w`:
//!
//! ```text
//! |det J| >= |det(x, y, z)| - u |y x z| - v |x x z| - w |x x y| - u v |z| - v w |x| - u w |y| - u v w
//! ```
//!
//! with the sign of the determinant at the centre. A cell of the wrong sign passes too: its corners show it.

use crate::block::{BLOCK, Columns, corners_of, gather};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};
use azimesh_io::mesh::{CellRef, CellRun};
use multiversion::multiversion;

/// Largest effect of rounding, as a part of the product of the lengths.
const ROUNDING: f64 = 1e-13;

/// Calls `visit` for the hexahedra of a run that do not pass.
pub(super) fn hexahedra<'a>(
    run: &CellRun<'a>,
    points: &[Vector],
    visit: &mut dyn FnMut(CellRef<'a>),
) {
    let mut at: Columns<8> = [[[0.0; BLOCK]; 3]; 8];
    let mut passes = [false; BLOCK];
    for_blocks(run, &mut |nodes, first| {
        pass_hexahedra(nodes, run.n_nodes, points, &mut at, &mut passes);
        report(run, nodes, first, &passes, visit);
    });
}

/// Calls `visit` for the wedges of a run that do not pass.
pub(super) fn wedges<'a>(run: &CellRun<'a>, points: &[Vector], visit: &mut dyn FnMut(CellRef<'a>)) {
    let mut at: Columns<6> = [[[0.0; BLOCK]; 3]; 6];
    let mut passes = [false; BLOCK];
    for_blocks(run, &mut |nodes, first| {
        pass_wedges(nodes, run.n_nodes, points, &mut at, &mut passes);
        report(run, nodes, first, &passes, visit);
    });
}

/// Calls `act` with the nodes of each block of a run and the number of its first cell in the run.
fn for_blocks<'a>(run: &CellRun<'a>, act: &mut dyn FnMut(&'a [u32], usize)) {
    let blocks = run.connectivity.chunks(BLOCK * run.n_nodes);
    for (i, nodes) in blocks.enumerate() {
        act(nodes, i * BLOCK);
    }
}

fn report<'a>(
    run: &CellRun<'a>,
    nodes: &'a [u32],
    first: usize,
    passes: &[bool; BLOCK],
    visit: &mut dyn FnMut(CellRef<'a>),
) {
    let cells = nodes.chunks_exact(run.n_nodes).enumerate();
    for (i, nodes) in cells.filter(|(i, _)| !passes[*i]) {
        visit(CellRef {
            index: run.first_cell + first + i,
            kind: run.kind,
            nodes,
        });
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn pass_hexahedra(
    connectivity: &[u32],
    n_nodes: usize,
    points: &[Vector],
    at: &mut Columns<8>,
    passes: &mut [bool; BLOCK],
) {
    let n = gather(connectivity, n_nodes, points, at);
    let mut margins = [0.0; BLOCK];
    for i in 0..n {
        margins[i] = hexahedron(&corners_of(at, i));
    }
    for i in 0..n {
        passes[i] = margins[i] > 0.0;
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn pass_wedges(
    connectivity: &[u32],
    n_nodes: usize,
    points: &[Vector],
    at: &mut Columns<6>,
    passes: &mut [bool; BLOCK],
) {
    let n = gather(connectivity, n_nodes, points, at);
    let mut margins = [0.0; BLOCK];
    for i in 0..n {
        margins[i] = wedge(&corners_of(at, i));
    }
    for i in 0..n {
        passes[i] = margins[i] > 0.0;
    }
}

/// Positive where the bound holds.
#[inline(always)]
fn hexahedron(p: &[Vector; 8]) -> f64 {
    let edge = |i: usize, j: usize| sub(p[j], p[i]);
    let (x, u) = mean_and_spread([edge(0, 1), edge(3, 2), edge(4, 5), edge(7, 6)]);
    let (y, v) = mean_and_spread([edge(0, 3), edge(1, 2), edge(4, 7), edge(5, 6)]);
    let (z, w) = mean_and_spread([edge(0, 4), edge(1, 5), edge(2, 6), edge(3, 7)]);
    let (yz, xz, xy) = (cross(y, z), cross(x, z), cross(x, y));
    let length = |a: Vector| dot(a, a).sqrt();
    let (lx, ly, lz) = (length(x), length(y), length(z));
    let taken = u * length(yz)
        + v * length(xz)
        + w * length(xy)
        + u * v * lz
        + v * w * lx
        + u * w * ly
        + u * v * w;
    dot(x, yz).abs() - taken - ROUNDING * (lx + u) * (ly + v) * (lz + w)
}

/// The mean of four edges, and the largest distance of one from it.
#[inline(always)]
fn mean_and_spread(edges: [Vector; 4]) -> (Vector, f64) {
    let sum = add(add(edges[0], edges[1]), add(edges[2], edges[3]));
    let mean = scale(sum, 0.25);
    let mut largest = 0.0;
    for i in 0..4 {
        let off = sub(edges[i], mean);
        let square = dot(off, off);
        largest = if square > largest { square } else { largest };
    }
    (mean, largest.sqrt())
}

/// Positive where the middle coefficients of the three quadratics have the sign of the ends.
#[inline(always)]
fn wedge(p: &[Vector; 6]) -> f64 {
    let (b1, b2) = (sub(p[1], p[0]), sub(p[2], p[0]));
    let (t1, t2) = (sub(p[4], p[3]), sub(p[5], p[3]));
    let ends = add(cross(b1, b2), cross(t1, t2));
    let middle = add(cross(b1, t2), cross(t1, b2));
    let mut least = f64::INFINITY;
    for k in 0..3 {
        let up = sub(p[k + 3], p[k]);
        let (end, between) = (dot(ends, up), dot(middle, up));
        let margin = if end < 0.0 { -between } else { between };
        let margin = margin - ROUNDING * end.abs();
        least = if margin < least { margin } else { least };
    }
    least
}
