//! The unit square of 25 by 25 cells with a block of 5 by 1 cells taken out: the rotated and
//! translated block of de Boer, van der Schoot and Bijl (2007).
//!
//! Tags `left`, `right`, `bottom`, `top` and `block`.

use super::{Sample, tag};
use azimesh_core::error::{Error, Result};
use azimesh_io::mesh::{CellKind, Cells, Mesh};

/// Cells along an edge of the square.
const CELLS: usize = 25;
/// The block's first and last line of nodes in x.
const BLOCK_X: [usize; 2] = [10, 15];
/// The block's first and last line of nodes in y.
const BLOCK_Y: [usize; 2] = [12, 13];

/// The mesh and the schedule that turns the block by 60 degrees and moves it by (-0.2, -0.3). Each cell of the published
/// mesh is cut into `refine` cells along both axes.
pub fn block(refine: usize) -> Result<Sample> {
    if !(1..=400).contains(&refine) {
        return Err(Error::input(format!(
            "--refine is from 1 to 400, found {refine}"
        )));
    }
    Ok(Sample {
        mesh: Grid::new(refine).mesh(),
        schedule: SCHEDULE.to_owned(),
    })
}

/// Lines of nodes, the block's lines among them, and the numbers of the nodes.
struct Grid {
    n: usize,
    x: [usize; 2],
    y: [usize; 2],
    /// Number of each node of the full square; those inside the block have none.
    numbers: Vec<u32>,
}

impl Grid {
    fn new(refine: usize) -> Self {
        let n = CELLS * refine;
        let [x, y] = [BLOCK_X, BLOCK_Y].map(|lines| lines.map(|line| line * refine));
        let mut numbers = Vec::with_capacity((n + 1) * (n + 1));
        let mut next = 0;
        for j in 0..=n {
            for i in 0..=n {
                let inside = i > x[0] && i < x[1] && j > y[0] && j < y[1];
                numbers.push(if inside { u32::MAX } else { next });
                next += u32::from(!inside);
            }
        }
        Self { n, x, y, numbers }
    }

    fn node(&self, i: usize, j: usize) -> u32 {
        self.numbers[j * (self.n + 1) + i]
    }

    fn mesh(&self) -> Mesh {
        let n = self.n;
        let place = |index: usize| index as f64 / n as f64;
        let points = (0..self.numbers.len())
            .filter(|&node| self.numbers[node] != u32::MAX)
            .map(|node| [place(node % (n + 1)), place(node / (n + 1)), 0.0])
            .collect();
        let mut cells = Cells::new();
        for j in 0..n {
            for i in 0..n {
                let removed =
                    (self.x[0]..self.x[1]).contains(&i) && (self.y[0]..self.y[1]).contains(&j);
                if !removed {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    let nodes = corners.map(|(i, j)| self.node(i, j));
                    cells.push(CellKind::Quadrilateral, &nodes);
                }
            }
        }
        let mut groups = Vec::new();
        for (name, path) in self.boundaries() {
            let first = cells.len();
            for pair in path.windows(2) {
                cells.push(CellKind::Line, &[pair[0], pair[1]]);
            }
            groups.push(tag(name, 1, first..cells.len()));
        }
        Mesh {
            points,
            cells,
            groups,
            ..Mesh::default()
        }
    }

    /// The boundaries as lines of nodes, the cells on their left.
    fn boundaries(&self) -> [(&'static str, Vec<u32>); 5] {
        let n = self.n;
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        let along = |j: usize| move |i: usize| self.node(i, j);
        let up = |i: usize| move |j: usize| self.node(i, j);
        let mut block: Vec<u32> = (y0..y1).map(up(x0)).collect();
        block.extend((x0..x1).map(along(y1)));
        block.extend((y0 + 1..=y1).rev().map(up(x1)));
        block.extend((x0..=x1).rev().map(along(y0)));
        [
            ("left", (0..=n).rev().map(up(0)).collect()),
            ("right", (0..=n).map(up(n)).collect()),
            ("bottom", (0..=n).map(along(0)).collect()),
            ("top", (0..=n).rev().map(along(n)).collect()),
            ("block", block),
        ]
    }
}

const SCHEDULE: &str = r#"# The block turns by 60 degrees about its centre and moves by (-0.2, -0.3), in seven steps.
version = 1
angle_unit = "deg"

[azimuth]                    # here no more than the angle reached
start = 0.0
stop = 60.0
step = 10.0

[[body]]
name = "block"
tags = ["block"]

[body.rigid]
rotate = { axis = [0.0, 0.0, 1.0], origin = [0.5, 0.5, 0.0], angle = 60.0 }
translate = [-0.2, -0.3, 0.0]
ramp = true                  # nothing at the first step, all of it at the last

[boundaries]
fixed = ["left", "right", "bottom", "top"]

[rbf]
kernel = "wendland-c2"
support_radius = 5.0

[selection]
method = "all"               # so few nodes need no selection
"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_is_five_cells_by_one() {
        let mesh = block(1).expect("it is valid").mesh;
        assert_eq!(mesh.points.len(), 26 * 26);
        assert_eq!(mesh.cells.len(), 625 - 5 + 4 * 25 + 12);
        let block = mesh.groups.last().expect("it is the last");
        let nodes: Vec<u32> = block
            .cells
            .iter()
            .flat_map(|cell| mesh.cells.get(cell).nodes.to_vec())
            .collect();
        let x = |&node: &u32| mesh.points[node as usize][0];
        let y = |&node: &u32| mesh.points[node as usize][1];
        let close = |found: f64, wanted: f64| (found - wanted).abs() < 1e-12;
        assert!(nodes.iter().all(|n| close(x(n), 0.4)
            || close(x(n), 0.6)
            || close(y(n), 0.48)
            || close(y(n), 0.52)));
        assert!(close(nodes.iter().map(x).fold(1.0, f64::min), 0.4));
    }

    #[test]
    fn every_edge_with_one_cell_is_tagged() {
        for refine in [1, 3] {
            let mesh = block(refine).expect("it is valid").mesh;
            mesh.validate().expect("it is a good mesh");
            let mut balance = std::collections::BTreeMap::new();
            for cell in mesh.cells.iter() {
                let n = cell.nodes.len();
                if n == 4 {
                    for i in 0..4 {
                        *balance
                            .entry((cell.nodes[i], cell.nodes[(i + 1) % 4]))
                            .or_insert(0) += 1;
                    }
                } else {
                    *balance.entry((cell.nodes[0], cell.nodes[1])).or_insert(0) -= 1;
                }
            }
            let open =
                |(&(a, b), &n): (&(u32, u32), &i32)| n != 0 && balance.get(&(b, a)) != Some(&n);
            assert!(!balance.iter().any(open));
        }
    }
}
