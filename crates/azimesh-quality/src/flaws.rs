//! Cells that no solver accepts: of negative volume, of zero volume, or folded at a corner.

use super::reference::Reference;
use super::validity;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::parallel;
use azimesh_io::mesh::{Adjacency, Mesh};
use serde::{Deserialize, Serialize};

/// Part of the volume of the box around a cell that counts as none.
const NONE: f64 = 1e-12;

/// Cells of one flaw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flawed {
    /// Number of cells.
    pub n: usize,
    /// The first of them.
    pub first: Option<usize>,
}

/// Faults of the volume cells of a mesh. Curved cells are checked as curved cells, except kinds without a map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Of negative volume in the order of their nodes; in a mesh of faces, turned against most of them.
    pub negative: Flawed,
    /// Cells of `negative` that are valid: their nodes are listed in the other orientation than those of cells around them.
    pub reversed: Flawed,
    /// Of no volume to round-off, as those with a node twice.
    pub degenerate: Flawed,
    /// Not valid, with a positive volume: folded at a corner, between corners, or as they are curved.
    pub folded: Flawed,
    /// Cells that are not valid: folded, of no volume, or of negative volume and not reversed.
    pub n_invalid: usize,
}

impl Flawed {
    fn add(&mut self, cell: usize) {
        self.n += 1;
        self.first = self.first.or(Some(cell));
    }

    fn join(&mut self, next: Self) {
        self.n += next.n;
        self.first = self.first.or(next.first);
    }
}

/// Counts of a chunk.
#[derive(Default, Serialize, Deserialize)]
struct Counts {
    /// Of positive volume and of negative: all, the valid ones, the others.
    turned: [[Flawed; 3]; 2],
    degenerate: Flawed,
}

impl Counts {
    fn join(&mut self, next: Self) {
        let both = self.turned.iter_mut().zip(next.turned);
        for (all, own) in both.flat_map(|(all, own)| all.iter_mut().zip(own)) {
            all.join(own);
        }
        self.degenerate.join(next.degenerate);
    }
}

/// [`flaws`] of a mesh by itself.
pub fn flaws(mesh: &Mesh) -> Flaws {
    let mut reference = Reference::new(mesh);
    if !reference.is_uniform() {
        reference = reference.upright(mesh, &Adjacency::of(mesh), false);
    }
    Flaws::of(mesh, &mesh.points, &reference)
}

impl Flaws {
    /// Faults of the cells that a [reference](Reference::upright) checks, with the nodes at `points`. `O(n)`; cannot fail.
    pub fn of(mesh: &Mesh, points: &[Vector], reference: &Reference) -> Self {
        let invalid = validity::invalid(mesh, points, reference);
        let is_invalid = |cell: usize| {
            let found = invalid.binary_search_by_key(&(cell as u32), |entry| entry.0);
            found.is_ok()
        };
        let offset = mesh.own_offset();
        let chunks = parallel::map_blocks_in(mesh.own_cells(), CHUNK, &|range| {
            let mut counts = Counts::default();
            visit::volume_cells(mesh, points, reference.facing(), range, |first, block| {
                for i in 0..block.n {
                    let (cell, volume) = (first + i, block.volume[i]);
                    let is_invalid = is_invalid(cell);
                    if is_invalid && !has_volume(mesh, points, cell, volume) {
                        counts.degenerate.add(cell + offset);
                        continue;
                    }
                    let counts = &mut counts.turned[usize::from(volume <= 0.0)];
                    counts[0].add(cell + offset);
                    counts[1 + usize::from(is_invalid)].add(cell + offset);
                }
            });
            counts
        });
        let all = mesh
            .ranks()
            .ordered_fold(Counts::default(), chunks, |all, own| {
                own.into_iter().for_each(|own| all.join(own));
            });
        let [[positive, ..], [negative, ..]] = all.turned;
        let is_clockwise = mesh.dimension() < 3 && negative.n > positive.n;
        let [negative, reversed, turned_over] = all.turned[usize::from(!is_clockwise)];
        let [_, _, folded] = all.turned[usize::from(is_clockwise)];
        Self {
            negative,
            reversed,
            degenerate: all.degenerate,
            folded,
            n_invalid: turned_over.n + all.degenerate.n + folded.n,
        }
    }
}

/// Returns whether the volume, or the area, of a cell is more than round-off in the cube around its corners.
pub(super) fn has_volume(mesh: &Mesh, points: &[Vector], cell: usize, volume: f64) -> bool {
    let nodes = mesh.cells.get(cell).nodes;
    let first = points[nodes[0] as usize];
    let reach = nodes
        .iter()
        .flat_map(|&node| sub(points[node as usize], first));
    let reach = reach.fold(0.0, |reach: f64, x| reach.max(x.abs()));
    volume.abs() > NONE * reach.powi(i32::from(mesh.dimension()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::CellKind;

    /// Faults of cells of one kind on these points.
    fn of<const N: usize>(points: &[Vector], kind: CellKind, cells: &[[u32; N]]) -> Flaws {
        let mut mesh = Mesh {
            points: points.to_vec(),
            ..Mesh::default()
        };
        for nodes in cells {
            mesh.cells.push(kind, nodes);
        }
        flaws(&mesh)
    }

    fn one(cell: usize) -> Flawed {
        Flawed {
            n: 1,
            first: Some(cell),
        }
    }

    #[test]
    fn cells_of_negative_and_of_no_volume_are_found() {
        let mut points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [0.0, 2.0, 2.0],
        ];
        let kind = CellKind::Tetrahedron;
        let cells = [[0, 1, 2, 3], [1, 2, 3, 4], [0, 1, 2, 1], [2, 3, 4, 5]];
        let found = of(&points, kind, &cells);
        assert_eq!(
            (found.negative.n, found.degenerate, found.n_invalid),
            (0, one(2), 1)
        );
        // Listed in the other orientation.
        let cells = [[0, 1, 2, 3], [2, 1, 3, 4], [2, 4, 3, 5]];
        let found = of(&points, kind, &cells);
        assert_eq!((found.negative.n, found.n_invalid), (2, 0));
        assert_eq!(found.reversed, found.negative);
        // A node has passed the face between two cells, or the cell has turned over.
        points[4] = [0.1, 0.1, 0.1];
        let found = of(&points, kind, &[[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!(
            (found.negative, found.reversed.n, found.n_invalid),
            (one(1), 0, 1)
        );
    }

    #[test]
    fn a_plane_mesh_may_turn_either_way_but_not_both() {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.2, 0.2, 0.0],
            [2.0, 0.0, 0.0],
        ];
        let mut cells = vec![[0, 2, 1], [0, 3, 2]];
        let kind = CellKind::Triangle;
        assert_eq!(of(&points, kind, &cells), Flaws::default());
        cells.push([1, 5, 2]);
        let found = of(&points, kind, &cells);
        assert_eq!(
            (found.negative, found.reversed, found.n_invalid),
            (one(2), one(2), 0)
        );
        // A dart: a reflex corner at node 4.
        let found = of(
            &points,
            CellKind::Quadrilateral,
            &[[4, 3, 2, 1], [0, 3, 4, 1]],
        );
        assert_eq!((found.folded, found.n_invalid), (one(1), 1));
    }
}
