//! The quality of a mesh in plain numbers.

use super::evaluator::{Assessment, QualityEvaluator};
use azimesh_core::error::Result;
use azimesh_io::mesh::Mesh;

/// Quality of a mesh in plain numbers: the columns of `steps.csv`. A metric that no cell has is NaN.
///
/// ```
/// use azimesh_io::Mesh;
/// use azimesh_quality::quality;
///
/// let found = quality(&Mesh::read("testdata/naca0012.vtu")?)?;
/// assert_eq!((found.inverted, found.inverted_reference), (0, 0));
/// assert!(found.min_first_cell_ratio.is_nan()); // no mesh to compare with
/// # Ok::<(), azimesh_io::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Cells of the mesh's own dimension.
    pub n_cells: usize,
    /// Cells that are valid in the reference mesh and have a Jacobian of zero or of the other sign, at a corner or
    /// between corners; and cells not valid there, of positive volume, whose volume is not positive.
    pub inverted: usize,
    /// Cells whose corner Jacobians are not all positive in the reference mesh.
    pub inverted_reference: usize,
    /// Cells that are valid at their corners and neither proven to be so between them nor refuted.
    pub unproven: usize,
    /// Smallest volume (area in 2D), in mesh units cubed (squared).
    pub min_volume: f64,
    /// Smallest scaled Jacobian.
    pub min_scaled_jacobian: f64,
    /// Mean scaled Jacobian.
    pub mean_scaled_jacobian: f64,
    /// First percentile of the scaled Jacobian.
    pub p01_scaled_jacobian: f64,
    /// Largest ratio of longest to shortest edge.
    pub max_edge_ratio: f64,
    /// Largest equiangle skew.
    pub max_skew: f64,
    /// Least Jacobian of a curved cell, relative to its mean in the cell with straight edges.
    pub min_curved_jacobian: f64,
    /// Least scaled Jacobian of a curved cell.
    pub min_curved_scaled_jacobian: f64,
    /// Largest angle between the normal of a face and the line between the centres of its cells, in degrees.
    pub max_non_orthogonality: f64,
    /// The angle whose cosine is the mean of the cosines at inner faces, in degrees.
    pub mean_non_orthogonality: f64,
    /// Largest skewness of a face as in OpenFOAM's checkMesh, outer faces included.
    pub max_face_skewness: f64,
    /// Smallest ratio of the smaller to the larger volume of the two cells at a face.
    pub min_volume_ratio: f64,
    /// Smallest interpolation weight of a face between its two cells; 0.5 at best.
    pub min_face_weight: f64,
    /// Smallest size-skew against the reference mesh.
    pub min_size_skew: f64,
    /// Mean size-skew against the reference mesh.
    pub mean_size_skew: f64,
    /// Smallest ratio of a first-cell height at a moving wall to its height in the reference mesh.
    pub min_first_cell_ratio: f64,
    /// Largest change of the angle between a moving wall and its first cell, in degrees.
    pub max_normal_change_deg: f64,
}

impl From<&Assessment> for Quality {
    fn from(found: &Assessment) -> Self {
        let columns = found.columns();
        let value = |name: &str| {
            let column = columns.iter().find(|(column, _)| *column == name);
            column.and_then(|(_, value)| *value).unwrap_or(f64::NAN)
        };
        Self {
            n_cells: found.cells.n_cells,
            inverted: found.cells.inverted,
            inverted_reference: found.cells.inverted_reference,
            unproven: found.cells.unproven,
            min_volume: value("min_volume"),
            min_scaled_jacobian: value("min_scaled_jacobian"),
            mean_scaled_jacobian: value("mean_scaled_jacobian"),
            p01_scaled_jacobian: value("p01_scaled_jacobian"),
            max_edge_ratio: value("max_edge_ratio"),
            max_skew: value("max_skew"),
            min_curved_jacobian: value("min_curved_jacobian"),
            min_curved_scaled_jacobian: value("min_curved_scaled_jacobian"),
            max_non_orthogonality: value("max_non_orthogonality"),
            mean_non_orthogonality: value("mean_non_orthogonality"),
            max_face_skewness: value("max_face_skewness"),
            min_volume_ratio: value("min_volume_ratio"),
            min_face_weight: value("min_face_weight"),
            min_size_skew: value("min_size_skew"),
            mean_size_skew: value("mean_size_skew"),
            min_first_cell_ratio: f64::NAN,
            max_normal_change_deg: f64::NAN,
        }
    }
}

/// The quality of a mesh by itself: its size-skew is relative to itself, as if undeformed.
///
/// # Errors
/// If the mesh is not valid: an index out of range, or a coordinate that is not finite.
///
/// ```
/// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
/// assert!(azimesh_quality::quality(&mesh)?.min_scaled_jacobian > 0.0);
/// # Ok::<(), azimesh_io::Error>(())
/// ```
pub fn quality(mesh: &Mesh) -> Result<Quality> {
    mesh.validate()?;
    let all = QualityEvaluator::new(mesh)
        .upright(mesh, false)
        .assess(mesh, &mesh.points);
    Ok(Quality::from(&all))
}
