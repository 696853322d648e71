//! Faces between two cells, measured side by side. One compiled version per instruction set is
//! chosen at run time.

use super::geometry::{self, Centre, FaceMetrics};
use crate::block::{BLOCK, Column};
use crate::column::{greatest, least, sum};
use azimesh_core::geometry::vector::Vector;
use multiversion::multiversion;

/// Centres of cells side by side: three coordinates and the volume.
pub(super) type CentreColumns = [Column; 4];

/// Up to [`BLOCK`] faces of `N` corners each; entries of columns beyond them are undefined.
pub(super) struct FaceBlock<const N: usize> {
    n: usize,
    corners: [[Column; 3]; N],
    /// Normal of a plane mesh.
    normal: [Column; 3],
    /// 1, or -1 where the corners turn so that the area points at the owner.
    turn: Column,
    /// Of the owner, then of the other cell.
    centres: [CentreColumns; 2],
    cells: [[u32; BLOCK]; 2],
}

/// Indices of the numbers of up to [`BLOCK`] faces of `N` corners, as in [`FaceBlock`].
pub(super) struct Faces<'a, const N: usize> {
    pub corners: [&'a [Column; 3]; N],
    pub normal: &'a [Column; 3],
    pub turn: &'a Column,
    pub centres: [&'a CentreColumns; 2],
}

/// Metrics of the faces of a block. They are NaN for a face whose other centre is NaN, see [`Faces::measure`].
pub(super) struct Measured<'a> {
    /// Owner of each face and the other cell.
    pub cells: [&'a [u32]; 2],
    pub cosine: &'a [f64],
    pub skewness: &'a [f64],
    pub volume_ratio: &'a [f64],
    pub weight: &'a [f64],
    pub extremes: Extremes,
}

/// Over the faces of a block.
#[derive(Default, Clone, Copy)]
pub(super) struct Extremes {
    pub cosine_sum: f64,
    pub least_cosine: f64,
    pub most_skewness: f64,
    pub least_volume_ratio: f64,
    pub least_weight: f64,
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
        let faces = Faces {
            corners: self.corners.each_ref(),
            normal: &self.normal,
            turn: &self.turn,
            centres: self.centres.each_ref(),
        };
        faces.measure([&self.cells[0][..n], &self.cells[1][..n]], take);
    }
}

impl<const N: usize> Faces<'_, N> {
    /// Measures the faces of these cells. For a face without another cell, its centre is NaN, and so are the metrics.
    pub(super) fn measure(&self, cells: [&[u32]; 2], take: &mut impl FnMut(&Measured<'_>)) {
        let n = cells[0].len();
        let mut found = [[0.0; BLOCK]; 4];
        let extremes = measure(self, n, &mut found);
        take(&Measured {
            cells,
            cosine: &found[0][..n],
            skewness: &found[1][..n],
            volume_ratio: &found[2][..n],
            weight: &found[3][..n],
            extremes,
        });
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn measure<const N: usize>(faces: &Faces<'_, N>, n: usize, found: &mut [Column; 4]) -> Extremes {
    for i in 0..BLOCK {
        let vector = |columns: &[Column; 3]| [columns[0][i], columns[1][i], columns[2][i]];
        let mut p = [[0.0; 3]; N];
        for k in 0..N {
            p[k] = vector(faces.corners[k]);
        }
        let centre = |side: usize| {
            let [x, y, z, volume] = faces.centres[side];
            Centre {
                at: [x[i], y[i], z[i]],
                volume: volume[i],
            }
        };
        let normal = vector(faces.normal);
        let metrics = turned(&p, normal, faces.turn[i], &centre(0), &centre(1));
        found[0][i] = metrics.cosine;
        found[1][i] = metrics.skewness;
        found[2][i] = metrics.volume_ratio;
        found[3][i] = metrics.weight;
    }
    Extremes {
        cosine_sum: sum(&found[0][..n]),
        least_cosine: least(&found[0][..n]),
        most_skewness: greatest(&found[1][..n]),
        least_volume_ratio: least(&found[2][..n]),
        least_weight: least(&found[3][..n]),
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
    let cosine = face.turn * metrics.cosine;
    take(&Measured {
        cells: [&face.cells[..1], &face.cells[1..]],
        cosine: &[cosine],
        skewness: &[metrics.skewness],
        volume_ratio: &[metrics.volume_ratio],
        weight: &[metrics.weight],
        extremes: Extremes {
            cosine_sum: cosine,
            least_cosine: cosine,
            most_skewness: metrics.skewness,
            least_volume_ratio: metrics.volume_ratio,
            least_weight: metrics.weight,
        },
    });
}
