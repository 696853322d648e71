//! All measures of a mesh, with the data that is made once for all of its steps.

use super::cells::per_cell;
use super::detail::{N_DETAILS, detail_arrays, least_curved};
use super::faces::{self, FaceSummary};
use super::reference::Reference;
use super::size_skew::{self, ReferenceSizes};
use super::summary::{Summary, assess};
use super::validity;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{Adjacency, BoundedCells, DataArray, Mesh};
use std::sync::OnceLock;

/// Data of the reference mesh with which later positions are compared.
#[derive(Debug)]
pub struct QualityEvaluator {
    /// Orientation of the cells in the reference mesh.
    pub reference: Reference,
    /// Sizes of the cells in the reference mesh.
    sizes: ReferenceSizes,
    /// The cells that share each face.
    pub adjacency: Adjacency,
    /// The cell whose values a boundary face has; made with the first arrays.
    bounded: OnceLock<BoundedCells>,
    workspace: faces::Workspace,
}

/// All that a mesh is assessed by, with the cells that have the extremes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Assessment {
    /// Of its cells.
    pub cells: Summary,
    /// Of its faces.
    pub faces: FaceSummary,
}

/// Columns that only meshes with curved cells have.
pub const CURVED_COLUMNS: [&str; 2] = ["min_curved_jacobian", "min_curved_scaled_jacobian"];

impl Assessment {
    /// Names and values, with the columns of `steps.csv` among them; a metric that is not defined is `None`.
    pub fn columns(&self) -> Vec<(&'static str, Option<f64>)> {
        let mut columns = self.cells.columns().to_vec();
        columns.extend(self.faces.columns());
        columns.extend(self.cells.size_skew.columns());
        columns.push(("unproven", Some(self.cells.unproven as f64)));
        let least = self.cells.min_curved.map(|least| least.map(|e| e.value));
        columns.extend(CURVED_COLUMNS.into_iter().zip(least));
        columns
    }
}

impl QualityEvaluator {
    /// For the reference mesh: orientation of its cells, and its faces.
    pub fn new(mesh: &Mesh) -> Self {
        let (reference, sizes) = Reference::with_sizes(mesh);
        Self {
            reference,
            sizes,
            adjacency: Adjacency::of(mesh),
            bounded: OnceLock::new(),
            workspace: faces::Workspace::default(),
        }
    }

    /// Has every cell checked, in the orientation of the cells around it ([`Reference::upright`]).
    #[must_use]
    pub fn upright(self, mesh: &Mesh, is_reference: bool) -> Self {
        let reference = self.reference.upright(mesh, &self.adjacency, is_reference);
        Self { reference, ..self }
    }

    /// Quality of `mesh` with nodes at `points`, relative to the reference mesh.
    ///
    /// # Panics
    /// When there are fewer positions than nodes, or the mesh has other cells than the reference.
    pub fn assess(&self, mesh: &Mesh, points: &[Vector]) -> Assessment {
        self.complete(self.cells(mesh, points), mesh, points)
    }

    /// The part of [`QualityEvaluator::assess`] that counts inverted cells.
    pub fn cells(&self, mesh: &Mesh, points: &[Vector]) -> Summary {
        let mut cells = assess(mesh, points, &self.reference, &self.sizes);
        let validity = validity::assess(mesh, points, &self.reference, mesh.own_cells());
        let curved = least_curved(mesh, points, &self.reference);
        cells.take_validity(&validity, curved, mesh);
        cells
    }

    /// The result of [`QualityEvaluator::assess`], from [`QualityEvaluator::cells`].
    pub fn complete(&self, cells: Summary, mesh: &Mesh, points: &[Vector]) -> Assessment {
        Assessment {
            cells,
            faces: self.faces(mesh, points),
        }
    }

    /// The part of [`QualityEvaluator::assess`] that measures faces.
    pub fn faces(&self, mesh: &Mesh, points: &[Vector]) -> FaceSummary {
        faces::assess(
            mesh,
            points,
            &self.reference,
            &self.adjacency,
            &self.workspace,
        )
    }

    /// All metrics of every cell as cell arrays: [`CellMetrics`](crate::CellMetrics) and
    /// further ones of the Verdict library, then `NonOrthogonality`, `FaceSkewness`, `VolumeRatio` and `SizeSkew`. A boundary
    /// face has the values of the cell that it bounds, so that pictures of a boundary show them.
    ///
    /// # Panics
    /// As [`QualityEvaluator::assess`].
    pub fn arrays(&self, mesh: &Mesh, points: &[Vector]) -> Vec<DataArray> {
        let mut arrays = per_cell(mesh, points, &self.reference).into_arrays();
        arrays.extend(detail_arrays(mesh, points, &self.reference));
        let faces = faces::per_cell(mesh, points, &self.reference, &self.adjacency);
        arrays.extend(faces.into_arrays());
        let size_skew = size_skew::per_cell(mesh, points, &self.reference, &self.sizes);
        arrays.push(size_skew);
        let bounded = self.bounded.get_or_init(|| BoundedCells::of(mesh));
        for array in &mut arrays {
            bounded.give_values(array);
        }
        arrays
    }

    /// Bytes of one cell in all [arrays](Self::arrays): a flag, four metrics of the summary, the
    /// details, three of faces, and the size-skew. The cells of boundary faces are in
    /// [estimate_bytes](Self::estimate_bytes).
    pub const ARRAY_BYTES: usize = 1 + 8 * (4 + N_DETAILS + 3 + 1);

    /// Bytes that the quality of a mesh will need, one step at a time, before anything is made.
    pub fn estimate_bytes(mesh: &Mesh) -> usize {
        let dimension = mesh.dimension();
        let runs = mesh.cells.runs();
        let below = runs.filter(|run| run.kind.dimension() + 1 == dimension);
        let bounded = 8 * below.map(|run| run.n_cells()).sum::<usize>();
        9 * mesh.cells.len() + Adjacency::estimate_bytes(mesh) + faces::step_bytes(mesh) + bounded
    }
}
