//! The surface of a mesh as a mesh of flat cells: what formats that hold surfaces alone are given.

use super::faces::Faces;
use super::sides::{flat, side_corners};
use super::walls::is_same_way;
use super::{CellRef, CellSet, Cells, Group, Mesh, MeshView, Origin};
use azimesh_core::geometry::vector::{add, cross, dot, scale, sub};

/// The surface of a mesh, and what of the mesh is not in it.
#[derive(Debug, Clone, Default)]
pub struct Skin {
    /// The surface: cells of at most two dimensions, in ascending order of dimension. Its groups are the tags of a solid mesh,
    /// or all groups of a plane mesh.
    pub mesh: Mesh,
    /// Solid cells.
    pub n_solid: usize,
    /// Edges and vertices of a solid mesh.
    pub n_lower: usize,
    /// Outer faces of solid cells that the mesh has no boundary cell for; they come last.
    pub n_bare: usize,
    /// Curved cells, which are reduced to their corners.
    pub n_curved: usize,
}

impl Skin {
    /// The surface without the outer faces that the mesh has no boundary cell for.
    pub fn without_bare(mut self) -> Mesh {
        let n = self.mesh.cells.len() - self.n_bare;
        self.mesh.keep_cells(&(0..n).collect::<Vec<_>>());
        self.mesh
    }
}

impl MeshView<'_> {
    /// The surface of the mesh. Of a solid mesh, and of a surface in space, its boundary cells, and the outer faces
    /// without one; they turn so that their normals point out of the solid. Of a plane mesh, a shell or a cloud of
    /// points all cells. In arrays a face without a boundary cell has the values of the solid cell behind it.
    ///
    /// Time and memory as [`Faces::of`].
    pub fn skin(&self) -> Skin {
        let mut skin = Skin::default();
        let is_boundary = self.dimension() == 3;
        let kept = |of: u8| if is_boundary { of == 2 } else { of < 3 };
        // Where the values of each cell come from.
        let mut sources = Vec::new();
        let mut place = vec![u32::MAX; self.cells.len()];
        let mut cells = Cells::new();
        for wanted in 0..3 {
            let of_dimension = self.cells.runs();
            for run in of_dimension.filter(|run| run.kind.dimension() == wanted) {
                if !kept(wanted) {
                    skin.n_lower += run.n_cells();
                    continue;
                }
                let n_corners = run.kind.n_corners(run.n_nodes);
                skin.n_curved += usize::from(run.kind.is_curved()) * run.n_cells();
                for (i, nodes) in run.cells().enumerate() {
                    place[run.first_cell + i] = sources.len() as u32;
                    sources.push(run.first_cell + i);
                    cells.push(run.kind.linear(), &nodes[..n_corners]);
                }
            }
        }
        let solid = self.cells.runs().filter(|run| run.kind.dimension() == 3);
        skin.n_solid = solid.map(|run| run.n_cells()).sum();
        if skin.n_solid > 0 {
            cells = self.with_outer_faces(cells, &place, &mut sources);
            skin.n_bare = sources.len() - place.iter().filter(|at| **at != u32::MAX).count();
        }
        skin.mesh = self.with_cells(cells, &sources, &place);
        skin
    }

    /// The cells turned outwards, and after them the outer faces that are none.
    fn with_outer_faces(&self, cells: Cells, place: &[u32], sources: &mut Vec<usize>) -> Cells {
        let faces = Faces::of_view(self, |_| true);
        let mut turned = vec![false; cells.len()];
        let mut bare = Cells::new();
        for outer in &faces.outer {
            let cell = self.cells.get(outer.cell as usize);
            side_corners(self.cells, &cell, outer.face as usize, |corners| {
                let outwards = self.points_out(&cell, corners);
                match outer.boundary.map(|face| place[face as usize] as usize) {
                    Some(at) => {
                        turned[at] = is_same_way(cells.get(at).nodes, corners) != outwards;
                    }
                    None => {
                        let mut corners = corners.to_vec();
                        if !outwards {
                            corners[1..].reverse();
                        }
                        sources.push(cell.index);
                        bare.push(flat(corners.len()), &corners);
                    }
                }
            });
        }
        let mut all = Cells::new();
        for cell in cells.iter() {
            let mut nodes = cell.nodes.to_vec();
            if turned[cell.index] {
                nodes[1..].reverse();
            }
            all.push(cell.kind, &nodes);
        }
        all.append(&bare);
        all
    }

    /// Returns whether a face turns so that its normal points away from the middle of its cell. (In files cells of either turn
    /// are met.)
    fn points_out(&self, cell: &CellRef<'_>, corners: &[u32]) -> bool {
        let point = |node: &u32| self.points[*node as usize];
        let mean = |nodes: &[u32]| {
            let sum = nodes.iter().map(point).fold([0.0; 3], add);
            scale(sum, 1.0 / nodes.len() as f64)
        };
        let arm = |i: usize| sub(point(&corners[i]), point(&corners[0]));
        let normal = (2..corners.len()).map(|i| cross(arm(i - 1), arm(i)));
        let normal = normal.fold([0.0; 3], add);
        dot(normal, sub(mean(corners), mean(cell.nodes))) >= 0.0
    }

    /// A mesh of these cells with the values and groups of the `sources`, without unused nodes.
    fn with_cells(&self, cells: Cells, sources: &[usize], place: &[u32]) -> Mesh {
        let of_group = |group: &&Group| self.dimension() < 3 || group.dimension == 2;
        let groups = self.groups.iter().filter(of_group).map(|group| {
            let cells = group.cells.iter().map(|cell| place[cell] as usize);
            let cells = cells.collect::<CellSet>();
            Group {
                cells,
                ..group.clone()
            }
        });
        let used_before = self.cells.used_nodes(self.points.len());
        let used = cells.used_nodes(self.points.len());
        let is_kept = |node: &usize| used[*node] || !used_before[*node] && self.dimension() < 3;
        let nodes: Vec<usize> = (0..self.points.len()).filter(is_kept).collect();
        let mut mesh = Mesh {
            points: self.points.to_vec(),
            groups: groups.collect(),
            cell_arrays: (self.cell_arrays.iter())
                .map(|of| of.select(sources))
                .collect(),
            point_arrays: self.point_arrays.iter().copied().cloned().collect(),
            field_arrays: self.field_arrays.iter().copied().cloned().collect(),
            cells,
            part: None,
            space: self.space.or((self.dimension() == 3).then_some(3)),
            origin: Origin::default(),
        };
        if nodes.len() < mesh.points.len() {
            mesh.keep_nodes(&nodes);
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, DataArray, Values};
    use super::*;

    /// A tetrahedron with two of its faces, the second the wrong way round, an edge, and a face inside.
    fn solid() -> Mesh {
        let mut mesh = Mesh::of_points(vec![
            [9.0; 3],
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]);
        mesh.cells.push(CellKind::Line, &[1, 2]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        mesh.cells.push(CellKind::Triangle, &[1, 3, 2]);
        mesh.cells.push(CellKind::Triangle, &[2, 4, 1]);
        mesh.add_tag("low", [2]).expect("it is a face");
        mesh.add_tag("side", [3]).expect("it is a face");
        mesh.cell_arrays = vec![DataArray::scalar("p", Values::I32(vec![0, 1, 2, 3]))];
        mesh
    }

    fn normals_point_out(mesh: &Mesh) -> bool {
        mesh.cells.iter().all(|cell| {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.points[cell.nodes[i] as usize]);
            let normal = cross(sub(b, a), sub(c, a));
            dot(normal, sub(a, [0.2; 3])) > 0.0
        })
    }

    #[test]
    fn the_skin_of_a_solid_is_its_boundary_turned_outwards_and_whole() {
        let skin = solid().view().skin();
        assert_eq!(
            (skin.n_solid, skin.n_lower, skin.n_bare, skin.n_curved),
            (1, 1, 2, 0)
        );
        assert_eq!((skin.mesh.points.len(), skin.mesh.cells.len()), (4, 4));
        assert!(normals_point_out(&skin.mesh));
        let tags = skin.mesh.boundary_tags();
        let tags: Vec<_> = tags
            .map(|tag| (tag.name.as_str(), tag.cells.iter().collect::<Vec<_>>()))
            .collect();
        assert_eq!(tags, [("low", vec![0]), ("side", vec![1])]);
        assert_eq!(
            skin.mesh.cell_arrays[0].values,
            Values::I32(vec![2, 3, 1, 1])
        );
        skin.mesh.validate().expect("it is a mesh");
        // Nor does the order of the cell's own nodes matter.
        let mut reversed = solid();
        reversed.cells = Cells::new();
        for cell in solid().cells.iter() {
            let mut nodes = cell.nodes.to_vec();
            nodes[1..].reverse();
            reversed.cells.push(cell.kind, &nodes);
        }
        assert!(normals_point_out(&reversed.view().skin().mesh));
        let again = skin.mesh.view().skin();
        assert_eq!(again.mesh, skin.mesh);
        let tagged = skin.without_bare();
        tagged.validate().expect("it is a mesh");
        assert!(normals_point_out(&tagged));
        assert_eq!((tagged.points.len(), tagged.cells.len()), (4, 2));
        assert_eq!(tagged.cell_arrays[0].values, Values::I32(vec![2, 3]));
    }

    #[test]
    fn the_skin_of_a_plane_mesh_is_the_mesh_with_edges_before_cells() {
        let mut mesh = Mesh::of_points((0..6).map(|i| [f64::from(i), 0.0, 0.0]).collect());
        mesh.cells.push(CellKind::Triangle6, &[0, 1, 2, 3, 4, 5]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.add_tag("wall", [1]).expect("it is an edge");
        let skin = mesh.view().skin();
        assert_eq!((skin.n_solid, skin.n_curved, skin.n_bare), (0, 1, 0));
        assert_eq!(skin.mesh.points.len(), 3);
        let kinds: Vec<CellKind> = skin.mesh.cells.iter().map(|cell| cell.kind).collect();
        assert_eq!(kinds, [CellKind::Line, CellKind::Triangle]);
        let tag = skin.mesh.boundary_tags().next().expect("it stays");
        assert_eq!(tag.cells.iter().collect::<Vec<_>>(), [0]);
    }
}
