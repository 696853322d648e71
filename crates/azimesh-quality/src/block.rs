//! Metrics of some cells side by side: one array a number, so that whole vectors of cells are
//! measured at once. One compiled version per instruction set is chosen at run time.

use super::angles::{Angles, N_CLASSES};
use super::facing::Facing;
use super::metrics::{Knupp, Metrics};
use super::span::Span;
use azimesh_core::geometry::vector::Vector;
use multiversion::multiversion;

/// Most cells in a block: small enough that corners and metrics stay in the first cache.
pub(super) const BLOCK: usize = 64;

/// A number of each cell of a block.
pub(super) type Column = [f64; BLOCK];
/// Corners of the cells of a block, one column a coordinate.
pub(super) type Columns<const N: usize> = [[Column; 3]; N];

/// A [`Span`] of each cell.
#[derive(Debug, Clone)]
pub(super) struct Spans {
    pub low: Column,
    pub high: Column,
}

/// [`Metrics`] of up to [`BLOCK`] cells that follow one another.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Number of cells; entries of columns beyond them are undefined.
    pub n: usize,
    pub volume: Column,
    pub corner: Spans,
    pub scaled: Spans,
    pub edge: Spans,
    pub angles: [Spans; N_CLASSES],
    pub size: Column,
    pub skew: Column,
    /// Cells that list a node twice and are measured as what they are.
    pub collapsed: Vec<u32>,
}

impl Spans {
    const EMPTY: Self = Self {
        low: [0.0; BLOCK],
        high: [0.0; BLOCK],
    };

    #[inline(always)]
    fn set(&mut self, i: usize, span: Span) {
        self.low[i] = span.low;
        self.high[i] = span.high;
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Span {
        Span {
            low: self.low[i],
            high: self.high[i],
        }
    }
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        n: 0,
        volume: [0.0; BLOCK],
        corner: Spans::EMPTY,
        scaled: Spans::EMPTY,
        edge: Spans::EMPTY,
        angles: [Spans::EMPTY; N_CLASSES],
        size: [0.0; BLOCK],
        skew: [0.0; BLOCK],
        collapsed: Vec::new(),
    };

    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, metrics: &Metrics) {
        self.volume[i] = metrics.volume;
        self.corner.set(i, metrics.corner);
        self.scaled.set(i, metrics.scaled);
        self.edge.set(i, metrics.edge);
        for class in 0..N_CLASSES {
            self.angles[class].set(i, metrics.angles.classes[class]);
        }
        self.size[i] = metrics.knupp.size;
        self.skew[i] = metrics.knupp.skew;
    }

    #[inline]
    pub(super) fn get(&self, i: usize) -> Metrics {
        Metrics {
            volume: self.volume[i],
            corner: self.corner.get(i),
            scaled: self.scaled.get(i),
            edge: self.edge.get(i),
            angles: self.angles(i),
            knupp: Knupp {
                size: self.size[i],
                skew: self.skew[i],
            },
        }
    }

    /// Extreme angles of cell `i`.
    #[inline]
    pub(super) fn angles(&self, i: usize) -> Angles {
        Angles {
            classes: std::array::from_fn(|class| self.angles[class].get(i)),
        }
    }
}

/// A kind of cell with `N` corners.
pub(super) trait Shape<const N: usize> {
    /// True if its metrics depend on the direction that it faces.
    const FACES: bool;

    /// Metrics of one cell; must be free of branches, or the loop over cells stays scalar.
    fn measure(p: &[Vector; N], facing: Vector) -> Metrics;
}

/// Corners of the cells of a block, and where they face.
pub(super) struct Corners<const N: usize> {
    at: Columns<N>,
    facing: [Column; 3],
}

impl<const N: usize> Corners<N> {
    pub(super) const EMPTY: Self = Self {
        at: [[[0.0; BLOCK]; 3]; N],
        facing: [[0.0; BLOCK]; 3],
    };
}

/// Puts the corners of cells of `n_nodes` nodes each, at most [`BLOCK`] of them, side by side; gives their number.
#[inline(always)]
pub(super) fn gather<const N: usize>(
    connectivity: &[u32],
    n_nodes: usize,
    points: &[Vector],
    at: &mut Columns<N>,
) -> usize {
    for (i, nodes) in connectivity.chunks_exact(n_nodes).take(BLOCK).enumerate() {
        let nodes = nodes.first_chunk::<N>().expect("a cell has its corners");
        for k in 0..N {
            let point = points[nodes[k] as usize];
            for axis in 0..3 {
                at[k][axis][i] = point[axis];
            }
        }
    }
    (connectivity.len() / n_nodes).min(BLOCK)
}

/// The corners of one cell of a block.
#[inline(always)]
pub(super) fn corners_of<const N: usize>(at: &Columns<N>, i: usize) -> [Vector; N] {
    let mut p = [[0.0; 3]; N];
    for k in 0..N {
        p[k] = [at[k][0][i], at[k][1][i], at[k][2][i]];
    }
    p
}

/// Measures cells of `n_nodes` nodes each, at most [`BLOCK`] of them, the first being `first_cell`.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn measure<S: Shape<N>, const N: usize>(
    connectivity: &[u32],
    n_nodes: usize,
    points: &[Vector],
    facing: &Facing,
    first_cell: usize,
    corners: &mut Corners<N>,
    block: &mut Block,
) {
    let n = gather(connectivity, n_nodes, points, &mut corners.at);
    if S::FACES {
        for i in 0..n {
            let facing = facing.of(first_cell + i);
            for axis in 0..3 {
                corners.facing[axis][i] = facing[axis];
            }
        }
    }
    block.n = n;
    for i in 0..n {
        let facing = [
            corners.facing[0][i],
            corners.facing[1][i],
            corners.facing[2][i],
        ];
        block.set(i, &S::measure(&corners_of(&corners.at, i), facing));
    }
}
