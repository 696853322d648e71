//! Cuts single cells by a plane: polygons of any cell, segments of faces.

use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{CellRef, Cells};

/// An edge of the mesh that the plane crosses, its lower node first.
pub type Crossed = (u32, u32);

/// Memory that is used for one cell after another.
#[derive(Debug, Default)]
pub struct Scratch {
    crossings: Vec<(Crossed, bool)>,
    segments: Vec<[Crossed; 2]>,
}

impl Scratch {
    /// Calls `visit` with the corners, as crossed edges in their order, of each polygon in which the
    /// plane cuts a solid cell.
    ///
    /// `height[node]` is the node's distance to the plane; zero counts as above, so that a plane through
    /// nodes cuts the cells on one side of it and no cell twice. Faces of more than three corners need
    /// not be flat. A cell that is not closed gives open chains, which are closed as they are.
    pub fn polygons(
        &mut self,
        cells: &Cells,
        cell: &CellRef<'_>,
        height: &[f64],
        mut visit: impl FnMut(&[Crossed]),
    ) {
        let Self {
            crossings,
            segments,
        } = self;
        segments.clear();
        for_each_side(cells, cell, |_, face| {
            crossings_of(face, height, crossings);
            pair_up(crossings, segments);
        });
        let mut corners = Vec::new();
        while let Some([first, mut end]) = segments.pop() {
            corners.clear();
            corners.push(first);
            while end != first {
                corners.push(end);
                let Some(at) = segments.iter().position(|segment| segment.contains(&end)) else {
                    break;
                };
                let [a, b] = segments.swap_remove(at);
                end = if a == end { b } else { a };
            }
            visit(&corners);
        }
    }

    /// The segments in which the plane cuts a face with these corners.
    pub fn segments(&mut self, face: &[u32], height: &[f64]) -> &[[Crossed; 2]] {
        self.segments.clear();
        crossings_of(face, height, &mut self.crossings);
        pair_up(&self.crossings, &mut self.segments);
        &self.segments
    }
}

/// The edges of a face that cross the plane, in order, and whether they go down.
fn crossings_of(face: &[u32], height: &[f64], crossings: &mut Vec<(Crossed, bool)>) {
    crossings.clear();
    for (i, &from) in face.iter().enumerate() {
        let to = face[(i + 1) % face.len()];
        let (is_up, goes_up) = (height[from as usize] >= 0.0, height[to as usize] >= 0.0);
        if is_up != goes_up {
            crossings.push(((from.min(to), from.max(to)), is_up));
        }
    }
}

/// Joins the crossings around each part of a face that is below the plane.
fn pair_up(crossings: &[(Crossed, bool)], segments: &mut Vec<[Crossed; 2]>) {
    let n = crossings.len();
    let first = usize::from(crossings.first().is_some_and(|(_, goes_down)| !goes_down));
    for i in (first..first + n).step_by(2) {
        segments.push([crossings[i % n].0, crossings[(i + 1) % n].0]);
    }
}
