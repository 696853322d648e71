//! Layers of cells between a closed surface grid and its copy further out.

use super::ray::Ray;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{CellKind, Cells};
use std::ops::Range;

/// Tetrahedra of a wedge.
const WEDGE_TETRAHEDRA: usize = 3;

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

/// Layers over a surface grid: the cells of each layer, then the innermost faces, seen from
/// outside the volume, then the outermost ones.
pub struct Extrusion {
    shape: CellShape,
    /// The nodes of each face of the grid: a quadrilateral, or its two triangles.
    faces: Vec<u32>,
    per_face: usize,
    n_nodes: usize,
    n_layers: usize,
}

impl Extrusion {
    /// `n_layers` layers over quadrilaterals of `n_nodes` nodes.
    pub fn new(quads: Vec<[u32; 4]>, n_nodes: usize, n_layers: usize, shape: CellShape) -> Self {
        let (faces, per_face) = match shape {
            CellShape::Hex => (quads.into_flattened(), 4),
            CellShape::Wedge | CellShape::Tet => (triangles(&quads).into_flattened(), 3),
        };
        Self {
            shape,
            faces,
            per_face,
            n_nodes,
            n_layers,
        }
    }

    fn n_faces(&self) -> usize {
        self.faces.len() / self.per_face
    }

    /// Kind, nodes per cell, cells per face of the volume.
    fn volume_kind(&self) -> (CellKind, usize, usize) {
        match self.shape {
            CellShape::Hex => (CellKind::Hexahedron, 8, 1),
            CellShape::Wedge => (CellKind::Wedge, 6, 1),
            CellShape::Tet => (CellKind::Tetrahedron, 4, WEDGE_TETRAHEDRA),
        }
    }

    /// The cells of some layers.
    pub fn layers(&self, layers: Range<usize>) -> Range<usize> {
        let per_layer = self.n_faces() * self.volume_kind().2;
        layers.start * per_layer..layers.end * per_layer
    }

    /// The innermost faces.
    pub fn inner(&self) -> Range<usize> {
        let first = self.layers(0..self.n_layers).end;
        first..first + self.n_faces()
    }

    /// The outermost faces.
    pub fn outer(&self) -> Range<usize> {
        let first = self.inner().end;
        first..first + self.n_faces()
    }

    /// All cells, in that order.
    pub fn cells(&self) -> Cells {
        let (kind, per_cell, per_column) = self.volume_kind();
        let (faces, per_face) = (&self.faces, self.per_face);
        let per_layer = self.layers(0..1).len() * per_cell;
        let n_in_volume = per_layer * self.n_layers;
        let mut connectivity = vec![0; n_in_volume + 2 * faces.len()];
        let (volume, boundary) = connectivity.split_at_mut(n_in_volume);
        parallel::for_blocks(volume, per_layer, &|first, entries| {
            let layer = first / per_layer;
            let [base, above] = [layer, layer + 1].map(|layer| (layer * self.n_nodes) as u32);
            let columns = entries.chunks_exact_mut(per_column * per_cell);
            for (column, face) in columns.zip(faces.chunks_exact(per_face)) {
                if let (CellShape::Tet, [a, b, c]) = (self.shape, face) {
                    let [low, high] = [base, above].map(|base| [a, b, c].map(|node| base + node));
                    column.copy_from_slice(tetrahedra(low, high).as_flattened());
                    continue;
                }
                let (low, high) = column.split_at_mut(per_face);
                low.iter_mut()
                    .zip(face)
                    .for_each(|(to, node)| *to = base + node);
                high.iter_mut()
                    .zip(face)
                    .for_each(|(to, node)| *to = above + node);
            }
        });
        let (inner, outer) = boundary.split_at_mut(faces.len());
        inner.copy_from_slice(faces);
        inner.chunks_exact_mut(per_face).for_each(<[u32]>::reverse);
        let last = (self.n_layers * self.n_nodes) as u32;
        outer
            .iter_mut()
            .zip(faces)
            .for_each(|(to, node)| *to = last + node);
        let face_kind = match self.shape {
            CellShape::Hex => CellKind::Quadrilateral,
            CellShape::Wedge | CellShape::Tet => CellKind::Triangle,
        };
        let kinds = [
            (kind, per_cell, self.inner().start),
            (face_kind, per_face, 2 * self.n_faces()),
        ];
        Cells::from_connectivity(connectivity, kinds)
    }
}

/// Two triangles for each quadrilateral, cut from its lowest node.
fn triangles(quads: &[[u32; 4]]) -> Vec<[u32; 3]> {
    quads
        .iter()
        .flat_map(|quad| {
            let lowest = (0..4).min_by_key(|&i| quad[i]).expect("there are four");
            let [a, b, c, d] = std::array::from_fn(|i| quad[(lowest + i) % 4]);
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// The tetrahedra of the wedge between two triangles that turn towards `high`. Each side is cut
/// from its lowest node, which must be in `low`, so that wedges with a common side agree.
fn tetrahedra(low: [u32; 3], high: [u32; 3]) -> [[u32; 4]; WEDGE_TETRAHEDRA] {
    let first = (0..3).min_by_key(|&i| low[i]).expect("there are three");
    let [a, b, c] = std::array::from_fn(|i| low[(first + i) % 3]);
    let [d, e, f] = std::array::from_fn(|i| high[(first + i) % 3]);
    if b < c {
        [[a, b, c, f], [a, b, f, e], [a, e, f, d]]
    } else {
        [[a, b, c, e], [a, e, c, f], [a, e, f, d]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::vector::{Vector, cross, dot, sub};

    #[test]
    fn the_tetrahedra_fill_the_wedge_whatever_its_numbers() {
        let corners: [Vector; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for low in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [2, 0, 1],
            [1, 2, 0],
            [2, 1, 0],
        ] {
            let at = |node: u32| {
                let i = low
                    .iter()
                    .position(|&n| n == node % 3)
                    .expect("it is a corner");
                [corners[i][0], corners[i][1], f64::from(node / 3)]
            };
            for tetrahedron in tetrahedra(low, low.map(|node| node + 3)) {
                let [a, b, c, d] = tetrahedron.map(at);
                let volume = dot(cross(sub(b, a), sub(c, a)), sub(d, a)) / 6.0;
                assert!(
                    (volume - 1.0 / 6.0).abs() < 1e-12,
                    "{low:?} {tetrahedron:?}"
                );
            }
        }
    }
}
