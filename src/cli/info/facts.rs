//! The facts about a mesh file.

use crate::cli::input::Input;
use azimesh_core::Note;
use azimesh_io::formats::Loaded;
use azimesh_io::mesh::{CellKind, DataArray, Faces, Group, Mesh};
use azimesh_quality::{Flaws, flaws, remarks};
use std::collections::BTreeMap;

/// The output of `azimesh info`.
pub struct Facts<'a> {
    /// The mesh; of a sequence, the last or the requested one.
    pub mesh: &'a Mesh,
    /// Format of the file.
    pub format: String,
    /// Version of the format, if the file states it.
    pub version: Option<String>,
    /// Remarks of the reader.
    pub notes: Vec<Note>,
    /// Times of a sequence.
    pub times: Option<Vec<f64>>,
    /// The requested step of the sequence.
    pub step: Option<usize>,
    /// Number of cells of each kind.
    pub cells: BTreeMap<CellKind, usize>,
    /// Number of cells with nodes in addition to their corners.
    pub n_curved: usize,
    /// Nodes that no cell has.
    pub n_orphan_nodes: usize,
    /// Nodes at the position of an earlier one.
    pub n_repeated_nodes: usize,
    /// Cells of negative or no volume.
    pub flaws: Flaws,
    /// Faces and boundary cells that do not make a closed boundary.
    pub boundary: Boundary,
}

/// Relation of the boundary cells to the cells.
pub struct Boundary {
    /// Boundary cells in the file that no tag holds.
    pub n_untagged: usize,
    /// Faces of one cell that no tag holds.
    pub n_open: usize,
    /// Boundary cells with a tag between two cells.
    pub n_inside: usize,
    /// Boundary cells on no face of a cell.
    pub n_dangling: usize,
    /// Faces of more than two cells.
    pub n_non_manifold: usize,
}

impl<'a> Facts<'a> {
    /// Collects the facts.
    pub fn of(input: &Input, step: Option<usize>, loaded: &'a Loaded) -> Self {
        let mesh = &loaded.mesh;
        let mut cells = BTreeMap::new();
        for run in mesh.cells.runs() {
            *cells.entry(run.kind).or_default() += run.n_cells();
        }
        let curved = cells.iter().filter(|(kind, _)| kind.is_curved());
        let n_curved = curved.map(|(_, count)| count).sum();
        let (notes, remarks) = (loaded.notes.iter(), remarks(mesh));
        let notes = notes.chain(&remarks).cloned();
        let nodes = || (mesh.n_orphan_nodes(), mesh.n_repeated_nodes());
        let ((n_orphan_nodes, n_repeated_nodes), boundary) =
            rayon::join(nodes, || Boundary::of(mesh));
        let flaws = flaws(mesh);
        Self {
            mesh,
            format: input
                .title()
                .unwrap_or_else(|| loaded.format.title.to_owned()),
            version: input.version(),
            notes: input.remark_on_times().into_iter().chain(notes).collect(),
            times: input.times(),
            step,
            cells,
            n_curved,
            n_orphan_nodes,
            n_repeated_nodes,
            flaws,
            boundary,
        }
    }

    /// Groups that are neither boundary tags nor zones.
    pub fn other_groups(&self) -> impl Iterator<Item = &'a Group> {
        let dimension = self.mesh.dimension();
        self.mesh
            .groups
            .iter()
            .filter(move |group| group.dimension + 1 < dimension || group.dimension > dimension)
    }

    /// Arrays and where their values are.
    pub fn arrays(&self) -> impl Iterator<Item = (&'static str, &'a DataArray)> {
        [
            ("point", &self.mesh.point_arrays),
            ("cell", &self.mesh.cell_arrays),
            ("field", &self.mesh.field_arrays),
        ]
        .into_iter()
        .flat_map(|(place, arrays)| arrays.iter().map(move |array| (place, array)))
    }
}

impl Boundary {
    fn of(mesh: &Mesh) -> Self {
        let tagged = mesh.in_a_boundary_tag();
        let faces = Faces::of(mesh);
        let is_open = |boundary: Option<u32>| boundary.is_none_or(|cell| !tagged[cell as usize]);
        let open = faces.outer.iter().filter(|face| is_open(face.boundary));
        let inside = faces.inside.iter().filter(|cell| tagged[**cell as usize]);
        Self {
            n_untagged: untagged(mesh, &tagged),
            n_open: open.count(),
            n_inside: inside.count(),
            n_dangling: faces.dangling.len(),
            n_non_manifold: faces.n_non_manifold,
        }
    }
}

fn untagged(mesh: &Mesh, tagged: &[bool]) -> usize {
    let runs = mesh.cells.runs();
    let runs = runs.filter(|run| run.kind.dimension() + 1 == mesh.dimension());
    runs.map(|run| {
        let cells = &tagged[run.first_cell..run.first_cell + run.n_cells()];
        cells.iter().filter(|&&tagged| !tagged).count()
    })
    .sum()
}
