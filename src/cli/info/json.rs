//! The facts as JSON.

use super::facts::Facts;
use crate::cli::context::Entries;
use crate::record::Failed;
use azimesh_io::mesh::{DataArray, Group};
use serde::Serialize;

/// The contents of a mesh; of a sequence, of the last mesh.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Info {
    /// One mesh.
    One(Box<MeshInfo>),
    /// Several meshes.
    Several {
        /// The meshes that could be read, in their order.
        meshes: Vec<NamedInfo>,
        /// An error for each of the others.
        errors: Vec<Failed>,
    },
}

/// A mesh and its path.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct NamedInfo {
    #[serde(flatten)]
    pub info: MeshInfo,
    /// Its path.
    pub file: String,
}

/// A mesh.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeshInfo {
    /// Format of the file, in words.
    format: String,
    /// Version of the format; null where the file does not say.
    format_version: Option<String>,
    /// Times of the steps of a sequence; null for one mesh.
    times: Option<Vec<f64>>,
    /// Dimension of its volume cells: 3 solid, 2 plane or shell, 0 for a cloud of points.
    dimension: u8,
    /// Number of nodes.
    nodes: usize,
    /// Nodes that no cell has.
    orphan_nodes: usize,
    /// Nodes at the position of an earlier one.
    repeated_nodes: usize,
    /// Number of cells, boundary faces included.
    cells: usize,
    /// Number of cells by kind, as `hexahedron`.
    cells_by_kind: Entries<usize>,
    /// Cells with nodes in addition to their corners.
    curved_cells: usize,
    /// Cells of negative volume in the order of their nodes; of a mesh of faces, turned against most of them.
    negative_cells: usize,
    /// Cells of `negative_cells` that are valid: their nodes are in reverse order, against those of the cells around them.
    reversed_cells: usize,
    /// Cells of no volume.
    degenerate_cells: usize,
    /// Cells of positive volume that are not valid: folded at a corner or between corners.
    folded_cells: usize,
    /// All cells that are not valid: `folded_cells`, `degenerate_cells`, and `negative_cells` without `reversed_cells`.
    invalid_cells: usize,
    /// Named groups of cells of the mesh's own dimension.
    zones: Vec<CellGroup>,
    /// Named groups of boundary faces.
    boundary_tags: Vec<FaceGroup>,
    /// Groups of any other dimension.
    other_groups: Vec<CellGroup>,
    /// Boundary faces in the file that no tag holds.
    faces_without_tag: usize,
    /// Faces of one cell that no tag holds: the boundary is open there.
    open_faces: usize,
    /// Tagged faces between two cells.
    inside_faces: usize,
    /// Boundary faces on no cell.
    loose_faces: usize,
    /// Faces of more than two cells.
    crowded_faces: usize,
    /// Smallest and largest coordinates, mesh units; null without nodes.
    bounds: Option<[[f64; 3]; 2]>,
    /// Arrays of the file.
    arrays: Vec<ArrayInfo>,
}

/// A group of cells.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CellGroup {
    /// Its name, or its number as text.
    name: String,
    /// Its number in the file; null in formats without numbers.
    number: Option<i32>,
    /// Type of boundary condition; null except in rare CGNS files.
    condition: Option<String>,
    /// Number of cells.
    cells: usize,
}

/// A boundary tag.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FaceGroup {
    /// Its name, or its number as text.
    name: String,
    /// Its number in the file; null in formats without numbers.
    number: Option<i32>,
    /// Type of boundary condition, a word of CGNS; null where the file has none.
    condition: Option<String>,
    /// Number of faces.
    faces: usize,
}

/// An array.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct ArrayInfo {
    /// Its name.
    name: String,
    /// Position of its values.
    #[cfg_attr(test, schemars(extend("enum" = ["point", "cell", "field"])))]
    at: &'static str,
    /// Type of number as `f64`, or `text`.
    r#type: &'static str,
    /// Components of a value.
    components: usize,
    /// Smallest and largest value of each component; null where there is no finite value.
    ranges: Vec<Option<[f64; 2]>>,
}

impl MeshInfo {
    /// All facts.
    pub fn of(facts: &Facts) -> Self {
        let (mesh, boundary) = (facts.mesh, &facts.boundary);
        let kinds = facts.cells.iter();
        Self {
            format: facts.format.clone(),
            format_version: facts.version.clone(),
            times: facts.times.clone(),
            dimension: mesh.dimension(),
            nodes: mesh.points.len(),
            orphan_nodes: facts.n_orphan_nodes,
            repeated_nodes: facts.n_repeated_nodes,
            cells: mesh.cells.len(),
            cells_by_kind: kinds.map(|(kind, count)| (kind.name(), *count)).collect(),
            curved_cells: facts.n_curved,
            negative_cells: facts.flaws.negative.n,
            reversed_cells: facts.flaws.reversed.n,
            degenerate_cells: facts.flaws.degenerate.n,
            folded_cells: facts.flaws.folded.n,
            invalid_cells: facts.flaws.n_invalid,
            zones: mesh.zones().map(CellGroup::of).collect(),
            boundary_tags: mesh.boundary_tags().map(FaceGroup::of).collect(),
            other_groups: facts.other_groups().map(CellGroup::of).collect(),
            faces_without_tag: boundary.n_untagged,
            open_faces: boundary.n_open,
            inside_faces: boundary.n_inside,
            loose_faces: boundary.n_dangling,
            crowded_faces: boundary.n_non_manifold,
            bounds: mesh.bounds(),
            arrays: facts.arrays().map(ArrayInfo::of).collect(),
        }
    }
}

impl CellGroup {
    fn of(group: &Group) -> Self {
        Self {
            name: group.name.clone(),
            number: group.number,
            condition: group.condition.clone(),
            cells: group.cells.len(),
        }
    }
}

impl FaceGroup {
    fn of(group: &Group) -> Self {
        Self {
            name: group.name.clone(),
            number: group.number,
            condition: group.condition.clone(),
            faces: group.cells.len(),
        }
    }
}

impl ArrayInfo {
    fn of((at, array): (&'static str, &DataArray)) -> Self {
        Self {
            name: array.name.clone(),
            at,
            r#type: array.values.type_name(),
            components: array.n_components,
            ranges: array.values.ranges(array.n_components),
        }
    }
}
