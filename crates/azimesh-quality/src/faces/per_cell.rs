//! Face metrics as cell arrays: of each cell the worst of its faces.

use super::block::Measured;
use super::centres::Centres;
use super::{angle_deg, walk};
use crate::reference::Reference;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{Adjacency, DataArray, Mesh, Values};
use std::sync::atomic::{AtomicI64, Ordering};

/// One value a cell of the mesh. Boundary faces hold NaN, and so do cells without a face that has the
/// metric.
#[derive(Debug, Clone)]
pub struct FaceArrays {
    /// Largest non-orthogonality of its faces, in degrees.
    pub non_orthogonality: Vec<f64>,
    /// Largest skewness of its faces.
    pub skewness: Vec<f64>,
    /// Smallest volume ratio to a neighbour.
    pub volume_ratio: Vec<f64>,
}

impl FaceArrays {
    /// As cell arrays `NonOrthogonality`, `FaceSkewness`, `VolumeRatio`.
    pub fn into_arrays(self) -> Vec<DataArray> {
        vec![
            DataArray::scalar("NonOrthogonality", Values::F64(self.non_orthogonality)),
            DataArray::scalar("FaceSkewness", Values::F64(self.skewness)),
            DataArray::scalar("VolumeRatio", Values::F64(self.volume_ratio)),
        ]
    }
}

/// Face metrics of every cell of `mesh` with its nodes at `points`.
///
/// # Panics
/// As [`super::assess`].
pub fn per_cell(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    adjacency: &Adjacency,
) -> FaceArrays {
    let centres = Centres::new(mesh, points, reference, Vec::new());
    let nothing = || {
        (0..mesh.cells.len())
            .map(|_| AtomicI64::new(NOTHING))
            .collect()
    };
    let worst = Worst {
        cosine: nothing(),
        skewness: nothing(),
        volume_ratio: nothing(),
    };
    parallel::for_each(adjacency.n_chunks(), &|chunk| {
        walk::faces_of(&centres, adjacency, chunk, &mut &worst);
    });
    let values = |least: Vec<AtomicI64>, value: fn(f64) -> f64| {
        let read = |key: AtomicI64| match key.into_inner() {
            NOTHING => f64::NAN,
            key => value(from_key(key)),
        };
        least.into_iter().map(read).collect()
    };
    FaceArrays {
        non_orthogonality: values(worst.cosine, angle_deg),
        skewness: values(worst.skewness, |x| -x),
        volume_ratio: values(worst.volume_ratio, |x| x),
    }
}

/// The least value of each cell so far, as a key: which faces come first does not matter.
struct Worst {
    cosine: Vec<AtomicI64>,
    /// Of minus the skewness.
    skewness: Vec<AtomicI64>,
    volume_ratio: Vec<AtomicI64>,
}

const NOTHING: i64 = i64::MAX;

/// Integers in the order of the numbers they stand for; its own inverse on the bits.
fn to_key(value: f64) -> i64 {
    let bits = value.to_bits() as i64;
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

fn from_key(key: i64) -> f64 {
    f64::from_bits((key ^ ((key >> 63) as u64 >> 1) as i64) as u64)
}

fn lower(least: &AtomicI64, value: f64) {
    if !value.is_nan() {
        least.fetch_min(to_key(value), Ordering::Relaxed);
    }
}

impl walk::Sink for &Worst {
    fn inner(&mut self, faces: &Measured<'_>) {
        for cells in faces.cells {
            for (i, &cell) in cells.iter().enumerate() {
                for (least, value) in [
                    (&self.cosine, faces.cosine[i]),
                    (&self.skewness, -faces.skewness[i]),
                    (&self.volume_ratio, faces.volume_ratio[i]),
                ] {
                    lower(&least[cell as usize], value);
                }
            }
        }
    }

    fn outer(&mut self, cell: usize, skewness: f64) {
        lower(&self.skewness[cell], -skewness);
    }
}
