//! Cells that no solver takes: of negative volume, of none, folded at a corner.

use super::reference::facing;
use super::visit::{self, CHUNK};
use crate::geometry::vector::sub;
use crate::mesh::Mesh;
use crate::parallel;

/// Part of the volume of the box around a cell that counts as none.
const NONE: f64 = 1e-12;

/// Cells of one flaw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flawed {
    /// How many.
    pub n: usize,
    /// The first of them.
    pub first: Option<usize>,
}

/// What is wrong with the volume cells of a mesh as it stands. Curved cells are judged by their corners.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Of negative volume; in a mesh of faces, turned against most of them.
    pub negative: Flawed,
    /// Of no volume to round-off, as those with a node twice.
    pub degenerate: Flawed,
    /// Of positive volume, with a corner that is folded.
    pub folded: Flawed,
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

/// Counts of a chunk: with volumes as they are, and how many cells are turned each way.
#[derive(Default)]
struct Counts {
    positive: Flawed,
    negative: Flawed,
    degenerate: Flawed,
    folded: Flawed,
}

/// Looks at every volume cell once. `O(n)`; cannot fail.
pub fn flaws(mesh: &Mesh) -> Flaws {
    let facing = facing(mesh);
    let n_cells = mesh.cells.len();
    let chunks = parallel::map_blocks(n_cells, CHUNK, &|range| {
        let mut counts = Counts::default();
        visit::volume_cells(mesh, &mesh.points, &facing, range, |first, block| {
            for i in 0..block.n {
                let (cell, volume) = (first + i, block.volume[i]);
                let is_valid = block.get(i).orientation() != 0;
                if !is_valid && volume.abs() <= NONE * box_volume(mesh, cell) {
                    counts.degenerate.add(cell);
                    continue;
                }
                match volume > 0.0 {
                    true => counts.positive.add(cell),
                    false => counts.negative.add(cell),
                }
                if !is_valid {
                    counts.folded.add(cell);
                }
            }
        });
        counts
    });
    let mut all = Counts::default();
    for counts in chunks {
        all.positive.join(counts.positive);
        all.negative.join(counts.negative);
        all.degenerate.join(counts.degenerate);
        all.folded.join(counts.folded);
    }
    let is_clockwise = mesh.dimension() < 3 && all.negative.n > all.positive.n;
    let negative = if is_clockwise {
        all.positive
    } else {
        all.negative
    };
    Flaws {
        negative,
        degenerate: all.degenerate,
        folded: all.folded,
    }
}

/// The volume, or the area, of the cube around the corners of a cell.
fn box_volume(mesh: &Mesh, cell: usize) -> f64 {
    let nodes = mesh.cells.get(cell).nodes;
    let first = mesh.points[nodes[0] as usize];
    let reach = nodes
        .iter()
        .flat_map(|&node| sub(mesh.points[node as usize], first));
    let reach = reach.fold(0.0, |reach: f64, x| reach.max(x.abs()));
    reach.powi(i32::from(mesh.dimension()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    #[test]
    fn cells_of_negative_and_of_no_volume_are_found() {
        let mut mesh = Mesh {
            points: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
            ],
            ..Mesh::default()
        };
        for nodes in [[0, 1, 2, 3], [1, 0, 2, 3], [0, 1, 2, 1], [0, 2, 1, 3]] {
            mesh.cells.push(CellKind::Tetrahedron, &nodes);
        }
        let found = flaws(&mesh);
        assert_eq!((found.negative.n, found.negative.first), (2, Some(1)));
        assert_eq!((found.degenerate.n, found.degenerate.first), (1, Some(2)));
        assert_eq!(found.folded.n, 0);
    }

    #[test]
    fn a_plane_mesh_may_turn_either_way_but_not_both() {
        let points = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.2, 0.2, 0.0],
        ];
        let mut mesh = Mesh {
            points,
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Triangle, &[0, 2, 1]);
        mesh.cells.push(CellKind::Triangle, &[0, 3, 2]);
        assert_eq!(flaws(&mesh), Flaws::default());
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        assert_eq!(
            flaws(&mesh).negative,
            Flawed {
                n: 1,
                first: Some(2)
            }
        );
        // A dart: a reflex corner at node 4.
        mesh.cells.push(CellKind::Quadrilateral, &[4, 3, 2, 1]);
        mesh.cells.push(CellKind::Quadrilateral, &[0, 3, 4, 1]);
        assert_eq!(
            flaws(&mesh).folded,
            Flawed {
                n: 1,
                first: Some(4)
            }
        );
    }
}
