//! Layers of cells between a closed surface grid and its copy further out.

use super::ray::Ray;
use super::split::{WEDGE_TETRAHEDRA, tetrahedra, triangles};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{CellKind, Cells};
use std::ops::Range;

/// Shape of the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum CellShape {
    /// Hexahedra.
    #[default]
    Hex,
    /// Hexahedra cut into two wedges, the triangles on the wall.
    Wedge,
    /// Wedges cut into three tetrahedra.
    Tet,
}

/// Nodes of all layers, innermost first: node `i` of layer `l` is `l rays.len() + i`.
pub fn layer_nodes(rays: &[Ray], n_layers: usize) -> Vec<Vector> {
    let n = rays.len();
    parallel::collect(n * (n_layers + 1), |node| rays[node % n].node(node / n))
}

/// The surface grid as cells of the shape asked for.
enum Faces {
    /// Kept whole.
    Quads(Vec<[u32; 4]>),
    /// Cut in two.
    Triangles(Vec<[u32; 3]>),
}

impl Faces {
    /// The faces of cells of this shape, from the quadrilaterals of the grid.
    fn new(quads: Vec<[u32; 4]>, shape: CellShape) -> Self {
        match shape {
            CellShape::Hex => Self::Quads(quads),
            CellShape::Wedge | CellShape::Tet => Self::Triangles(triangles(&quads)),
        }
    }

    /// Their number.
    fn len(&self) -> usize {
        match self {
            Self::Quads(faces) => faces.len(),
            Self::Triangles(faces) => faces.len(),
        }
    }
}

/// Kind, nodes per cell, cells per face of a volume of this shape.
fn volume_kind(shape: CellShape) -> (CellKind, usize, usize) {
    match shape {
        CellShape::Hex => (CellKind::Hexahedron, 8, 1),
        CellShape::Wedge => (CellKind::Wedge, 6, 1),
        CellShape::Tet => (CellKind::Tetrahedron, 4, WEDGE_TETRAHEDRA),
    }
}

/// Layers over a surface grid: the cells of each layer, then the innermost faces, seen from
/// outside the volume, then the outermost ones.
pub struct Extrusion {
    faces: Faces,
    shape: CellShape,
    n_nodes: usize,
    n_layers: usize,
}

impl Extrusion {
    /// `n_layers` layers over quadrilaterals of `n_nodes` nodes.
    pub fn new(quads: Vec<[u32; 4]>, n_nodes: usize, n_layers: usize, shape: CellShape) -> Self {
        Self {
            faces: Faces::new(quads, shape),
            shape,
            n_nodes,
            n_layers,
        }
    }

    /// The cells of some layers.
    pub fn layers(&self, layers: Range<usize>) -> Range<usize> {
        let (_, _, cells_per_face) = volume_kind(self.shape);
        let per_layer = self.faces.len() * cells_per_face;
        layers.start * per_layer..layers.end * per_layer
    }

    /// The innermost faces.
    pub fn inner(&self) -> Range<usize> {
        let first = self.layers(0..self.n_layers).end;
        first..first + self.faces.len()
    }

    /// The outermost faces.
    pub fn outer(&self) -> Range<usize> {
        let first = self.inner().end;
        first..first + self.faces.len()
    }

    /// All cells, in that order.
    pub fn cells(&self) -> Cells {
        let (kind, per_cell, _) = volume_kind(self.shape);
        let (face_kind, per_face) = match self.faces {
            Faces::Quads(_) => (CellKind::Quadrilateral, 4),
            Faces::Triangles(_) => (CellKind::Triangle, 3),
        };
        let per_layer = self.layers(0..1).len() * per_cell;
        let n_boundary = self.faces.len() * per_face;
        let mut connectivity = vec![0; per_layer * self.n_layers + 2 * n_boundary];
        let (volume, boundary) = connectivity.split_at_mut(per_layer * self.n_layers);
        let base = |layer: usize| (layer * self.n_nodes) as u32;
        parallel::for_blocks(volume, per_layer, &|first, entries| {
            let layer = first / per_layer;
            let bases = [base(layer), base(layer + 1)];
            fill_layer(entries, &self.faces, self.shape, bases);
        });
        let (inner, outer) = boundary.split_at_mut(n_boundary);
        fill_boundary(inner, &self.faces, 0, true);
        fill_boundary(outer, &self.faces, base(self.n_layers), false);
        let n_volume = self.layers(0..self.n_layers).end;
        let kinds = [
            (kind, per_cell, n_volume),
            (face_kind, per_face, 2 * self.faces.len()),
        ];
        Cells::from_connectivity(connectivity, kinds)
    }
}

/// The cells between two layers, whose first nodes are `base`.
fn fill_layer(entries: &mut [u32], faces: &Faces, shape: CellShape, base: [u32; 2]) {
    match (faces, shape) {
        (Faces::Quads(quads), _) => {
            for (cell, quad) in entries.chunks_exact_mut(8).zip(quads) {
                let (low, high) = cell.split_at_mut(4);
                low.copy_from_slice(&quad.map(|node| base[0] + node));
                high.copy_from_slice(&quad.map(|node| base[1] + node));
            }
        }
        (Faces::Triangles(triangles), CellShape::Tet) => {
            let size = 4 * WEDGE_TETRAHEDRA;
            for (cells, triangle) in entries.chunks_exact_mut(size).zip(triangles) {
                let low = triangle.map(|node| base[0] + node);
                let high = triangle.map(|node| base[1] + node);
                cells.copy_from_slice(tetrahedra(low, high).as_flattened());
            }
        }
        (Faces::Triangles(triangles), _) => {
            for (cell, triangle) in entries.chunks_exact_mut(6).zip(triangles) {
                let (low, high) = cell.split_at_mut(3);
                low.copy_from_slice(&triangle.map(|node| base[0] + node));
                high.copy_from_slice(&triangle.map(|node| base[1] + node));
            }
        }
    }
}

fn fill_boundary(entries: &mut [u32], faces: &Faces, base: u32, reversed: bool) {
    let mut fill = |i: usize, face: &[u32]| {
        let entry = &mut entries[i * face.len()..(i + 1) * face.len()];
        entry.copy_from_slice(face);
        entry.iter_mut().for_each(|node| *node += base);
        if reversed {
            entry.reverse();
        }
    };
    match faces {
        Faces::Quads(faces) => faces.iter().enumerate().for_each(|(i, face)| fill(i, face)),
        Faces::Triangles(faces) => faces.iter().enumerate().for_each(|(i, face)| fill(i, face)),
    }
}
