//! Faces between two cells, measured side by side. One compiled version per instruction set is
//! chosen at run time.

use super::geometry::{self, Centre, FaceMetrics};
use crate::geometry::vector::Vector;
use multiversion::multiversion;

/// Most faces in a block: small enough to stay in the first cache.
pub(super) const BLOCK: usize = 64;

type Column = [f64; BLOCK];

/// Up to [`BLOCK`] faces of `N` corners each; entries of columns beyond them are undefined.
pub(super) struct FaceBlock<const N: usize> {
    n: usize,
    corners: [[Column; 3]; N],
    /// Normal of a plane mesh.
    normal: [Column; 3],
    /// 1, or -1 where the corners turn so that the area points at the owner.
    turn: Column,
    /// Centre and volume of the owner, then of the other cell.
    centres: [[Column; 4]; 2],
    cells: [[u32; BLOCK]; 2],
}

/// What was measured on the faces of a block.
pub(super) struct Measured<'a> {
    /// Owner of each face and the other cell.
    pub cells: [&'a [u32]; 2],
    pub cosine: &'a [f64],
    pub skewness: &'a [f64],
    pub volume_ratio: &'a [f64],
    pub weight: &'a [f64],
}

/// A face between two cells.
pub(super) struct Between<'a> {
    pub corners: &'a [u32],
    /// Normal of the owner in a plane mesh.
    pub normal: Vector,
    /// See [`FaceBlock::turn`].
    pub turn: f64,
    pub cells: [u32; 2],
    pub centres: [Centre; 2],
}

impl<const N: usize> FaceBlock<N> {
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            n: 0,
            corners: [[[0.0; BLOCK]; 3]; N],
            normal: [[0.0; BLOCK]; 3],
            turn: [0.0; BLOCK],
            centres: [[[0.0; BLOCK]; 4]; 2],
            cells: [[0; BLOCK]; 2],
        })
    }

    /// Adds a face of `N` corners; when the block is full, it is measured and emptied.
    #[inline]
    pub(super) fn push(
        &mut self,
        points: &[Vector],
        face: &Between<'_>,
        take: &mut impl FnMut(&Measured<'_>),
    ) {
        let i = self.n;
        let nodes = face.corners.first_chunk::<N>().expect("N corners");
        for k in 0..N {
            let point = points[nodes[k] as usize];
            for axis in 0..3 {
                self.corners[k][axis][i] = point[axis];
            }
        }
        if N == 2 {
            for axis in 0..3 {
                self.normal[axis][i] = face.normal[axis];
            }
        }
        self.turn[i] = face.turn;
        for side in 0..2 {
            let Centre { at, volume } = face.centres[side];
            for axis in 0..3 {
                self.centres[side][axis][i] = at[axis];
            }
            self.centres[side][3][i] = volume;
            self.cells[side][i] = face.cells[side];
        }
        self.n += 1;
        if self.n == BLOCK {
            self.flush(take);
        }
    }

    /// Measures what is left.
    pub(super) fn flush(&mut self, take: &mut impl FnMut(&Measured<'_>)) {
        let n = std::mem::take(&mut self.n);
        if n == 0 {
            return;
        }
        let mut found = [[0.0; BLOCK]; 4];
        measure(self, &mut found);
        take(&Measured {
            cells: [&self.cells[0][..n], &self.cells[1][..n]],
            cosine: &found[0][..n],
            skewness: &found[1][..n],
            volume_ratio: &found[2][..n],
            weight: &found[3][..n],
        });
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn measure<const N: usize>(block: &FaceBlock<N>, found: &mut [Column; 4]) {
    for i in 0..BLOCK {
        let vector = |columns: &[Column; 3]| [columns[0][i], columns[1][i], columns[2][i]];
        let mut p = [[0.0; 3]; N];
        for k in 0..N {
            p[k] = vector(&block.corners[k]);
        }
        let centre = |side: usize| {
            let [x, y, z, volume] = &block.centres[side];
            Centre {
                at: [x[i], y[i], z[i]],
                volume: volume[i],
            }
        };
        let metrics = turned(
            &p,
            vector(&block.normal),
            block.turn[i],
            &centre(0),
            &centre(1),
        );
        found[0][i] = metrics.cosine;
        found[1][i] = metrics.skewness;
        found[2][i] = metrics.volume_ratio;
        found[3][i] = metrics.weight;
    }
}

#[inline(always)]
fn turned<const N: usize>(
    p: &[Vector; N],
    normal: Vector,
    turn: f64,
    first: &Centre,
    second: &Centre,
) -> FaceMetrics {
    let face = geometry::face(N, |k| p[k], normal);
    let metrics = geometry::inner(&face, N, |k| p[k], first, second);
    FaceMetrics {
        cosine: turn * metrics.cosine,
        ..metrics
    }
}

/// A face of more corners, on its own.
pub(super) fn one(points: &[Vector], face: &Between<'_>, take: &mut impl FnMut(&Measured<'_>)) {
    let n = face.corners.len();
    let corner = |k: usize| points[face.corners[k] as usize];
    let shape = geometry::face(n, corner, face.normal);
    let [first, second] = &face.centres;
    let metrics = geometry::inner(&shape, n, corner, first, second);
    take(&Measured {
        cells: [&face.cells[..1], &face.cells[1..]],
        cosine: &[face.turn * metrics.cosine],
        skewness: &[metrics.skewness],
        volume_ratio: &[metrics.volume_ratio],
        weight: &[metrics.weight],
    });
}
