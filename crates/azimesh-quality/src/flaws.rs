//! Cells that no solver accepts: of negative volume, of zero volume, or folded at a corner.

use super::metrics::Metrics;
use super::reference::facing;
use super::validity::{CurvedMaps, Proof};
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::sub;
use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;

/// Part of the volume of the box around a cell that counts as none.
const NONE: f64 = 1e-12;

/// Cells of one flaw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flawed {
    /// Number of cells.
    pub n: usize,
    /// The first of them.
    pub first: Option<usize>,
}

/// Faults of the volume cells of a mesh. Curved cells are checked as curved cells, except kinds without a map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Of negative volume; in a mesh of faces, turned against most of them.
    pub negative: Flawed,
    /// Cells of `negative` that are valid as mirror images: their nodes are listed in the other orientation.
    pub reversed: Flawed,
    /// Of no volume to round-off, as those with a node twice.
    pub degenerate: Flawed,
    /// Of positive volume, with a corner that is folded, or folded as they are curved.
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
    /// Of positive volume and of negative, and of these the ones that are valid.
    turned: [[Flawed; 2]; 2],
    degenerate: Flawed,
    folded: Flawed,
}

/// Looks at every volume cell once. `O(n)`; cannot fail.
pub fn flaws(mesh: &Mesh) -> Flaws {
    let facing = facing(mesh);
    let n_cells = mesh.cells.len();
    let maps = CurvedMaps::new(mesh);
    // The orientation of a cell, 0 where it is not valid.
    let orientation = |cell: usize, metrics: &Metrics| {
        let by_corners = metrics.orientation();
        if maps.is_empty() {
            return by_corners;
        }
        let cell = mesh.cells.get(cell);
        let Some(map) = maps.of(cell.kind, cell.nodes.len()) else {
            return by_corners;
        };
        let sign = if metrics.volume(1) < 0.0 { -1 } else { 1 };
        match map.prove(cell.nodes, &mesh.points, sign) {
            Proof::Valid => sign,
            Proof::Unproven => by_corners,
            Proof::Inside | Proof::Corner => 0,
        }
    };
    let chunks = parallel::map_blocks(n_cells, CHUNK, &|range| {
        let mut counts = Counts::default();
        visit::volume_cells(mesh, &mesh.points, &facing, range, |first, block| {
            for i in 0..block.n {
                let (cell, volume) = (first + i, block.volume[i]);
                let is_valid = orientation(cell, &block.get(i)) != 0;
                if !is_valid && !has_volume(mesh, cell, volume) {
                    counts.degenerate.add(cell);
                    continue;
                }
                let [all, valid] = &mut counts.turned[usize::from(volume <= 0.0)];
                all.add(cell);
                if is_valid {
                    valid.add(cell)
                } else {
                    counts.folded.add(cell)
                }
            }
        });
        counts
    });
    let mut all = Counts::default();
    for counts in chunks {
        let both = all.turned.iter_mut().zip(counts.turned);
        for (all, own) in both.flat_map(|(all, own)| all.iter_mut().zip(own)) {
            all.join(own);
        }
        all.degenerate.join(counts.degenerate);
        all.folded.join(counts.folded);
    }
    let [[positive, _], [negative, _]] = all.turned;
    let is_clockwise = mesh.dimension() < 3 && negative.n > positive.n;
    let [negative, reversed] = all.turned[usize::from(!is_clockwise)];
    Flaws {
        negative,
        reversed,
        degenerate: all.degenerate,
        folded: all.folded,
    }
}

/// Returns whether the volume, or the area, of a cell is more than round-off in the cube around its corners.
pub(super) fn has_volume(mesh: &Mesh, cell: usize, volume: f64) -> bool {
    let nodes = mesh.cells.get(cell).nodes;
    let first = mesh.points[nodes[0] as usize];
    let reach = nodes
        .iter()
        .flat_map(|&node| sub(mesh.points[node as usize], first));
    let reach = reach.fold(0.0, |reach: f64, x| reach.max(x.abs()));
    volume.abs() > NONE * reach.powi(i32::from(mesh.dimension()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::CellKind;

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
        assert_eq!(found.reversed, found.negative);
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
        let found = flaws(&mesh);
        let third = Flawed {
            n: 1,
            first: Some(2),
        };
        assert_eq!((found.negative, found.reversed), (third, third));
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
