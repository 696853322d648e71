//! Pairs of opposite nodes in a mesh of one layer of cells between two sides that solvers call `empty`.

use super::sides::for_each_side;
use super::{Boundary, Group, Mesh};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, cross, sub};

/// The condition of the sides.
pub const EMPTY: &str = "empty";

/// Normals of the sides may be this much off an axis of coordinates, as OpenFOAM allows.
const OFF_AXIS: f64 = 1e-6;

/// A mesh of one layer of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct OneLayer {
    /// The axis of coordinates, 0 to 2, that the layer is thin along.
    pub axis: usize,
    /// A node of the low side and the node over it, by the first.
    pub pairs: Vec<[u32; 2]>,
}

/// The sides of a mesh that are called `empty` and have faces.
fn sides(boundary: &Boundary) -> Vec<&Group> {
    let is_side = |tag: &&Group| tag.condition.as_deref() == Some(EMPTY) && !tag.cells.is_empty();
    match boundary.dimension() {
        3 => boundary.boundary_tags().filter(is_side).collect(),
        _ => Vec::new(),
    }
}

impl OneLayer {
    /// Returns whether any side of a mesh is called `empty`, of a part any side of the whole mesh.
    pub fn has_sides(mesh: &Mesh) -> bool {
        let groups = mesh.groups_of_all();
        let is_side = |of: &Group| of.condition.as_deref() == Some(EMPTY) && !of.cells.is_empty();
        mesh.dimension() == 3 && groups.iter().any(is_side)
    }

    /// The axis that the sides called `empty` are normal to; `None` where the mesh has no such sides.
    ///
    /// # Errors
    /// If they are not normal to one axis of coordinates.
    pub fn axis_of(boundary: &Boundary) -> Result<Option<usize>> {
        let sides = sides(boundary);
        if sides.is_empty() {
            return Ok(None);
        }
        let mut sum = [0.0; 3];
        for cell in sides.iter().flat_map(|side| side.cells.iter()) {
            let area = area(boundary, boundary.face(cell).nodes);
            sum = [0, 1, 2].map(|k| sum[k] + area[k].abs());
        }
        let total = sum[0] + sum[1] + sum[2];
        let axis = (0..3)
            .max_by(|&a, &b| sum[a].total_cmp(&sum[b]))
            .unwrap_or(2);
        if sum[axis] >= (1.0 - OFF_AXIS) * total {
            return Ok(Some(axis));
        }
        Err(Error::input(format!(
            "{} called empty, but not normal to one axis of coordinates; a mesh of one layer is moved only along two axes",
            names(&sides)
        )))
    }

    /// The pairs of nodes over one another; `None` where no side is called `empty`.
    ///
    /// # Errors
    /// If there is not one layer of cells between the sides.
    pub fn find(mesh: &Mesh) -> Result<Option<Self>> {
        let boundary = Boundary::of(mesh);
        let Some(axis) = Self::axis_of(&boundary)? else {
            return Ok(None);
        };
        let used = mesh.cells.used_nodes(mesh.points.len());
        let heights = || {
            mesh.points
                .iter()
                .zip(&used)
                .filter(|(_, used)| **used)
                .map(|(point, _)| point[axis])
        };
        let (low, high) = heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        let is_high = |node: u32| mesh.points[node as usize][axis] > 0.5 * (low + high);
        let mut over = vec![NONE; mesh.points.len()];
        let mut is_one = true;
        let mut join = |a: u32, b: u32| {
            if is_high(a) == is_high(b) {
                return;
            }
            for (own, other) in [(a, b), (b, a)] {
                let known = &mut over[own as usize];
                is_one &= *known == NONE || *known == other;
                *known = other;
            }
        };
        for run in mesh.volume_runs() {
            for cell in run.cell_refs() {
                for_each_side(&mesh.cells, &cell, |_, corners| {
                    for (i, &from) in corners.iter().enumerate() {
                        join(from, corners[(i + 1) % corners.len()]);
                    }
                });
            }
        }
        let nodes = || (0..mesh.points.len() as u32).filter(|node| used[*node as usize]);
        let sides = sides(&boundary);
        if !is_one || nodes().any(|node| over[node as usize] == NONE) || !covers(mesh, &sides) {
            return Err(Error::input(format!(
                "{} called empty, but the mesh is not one layer of cells between two such sides",
                names(&sides)
            )));
        }
        let pairs = nodes().filter(|node| !is_high(*node));
        Ok(Some(Self {
            axis,
            pairs: pairs.map(|node| [node, over[node as usize]]).collect(),
        }))
    }

    /// Marks the upper nodes of the pairs among `n_nodes` nodes.
    pub fn high_nodes(&self, n_nodes: usize) -> Vec<bool> {
        let mut high = vec![false; n_nodes];
        for pair in &self.pairs {
            high[pair[1] as usize] = true;
        }
        high
    }

    /// Makes both sides of moved positions alike: each node over another one goes with that, and none leaves its side.
    /// Positions that were alike in the mesh are alike to the last bit.
    pub fn level(&self, before: &[Vector], out: &mut [Vector]) {
        for &[low, high] in &self.pairs {
            let (low, high) = (low as usize, high as usize);
            let (a, b) = (before[low], before[high]);
            out[low][self.axis] = a[self.axis];
            let moved = out[low];
            out[high] = std::array::from_fn(|k| match k {
                k if k == self.axis => b[k],
                k if a[k].to_bits() == b[k].to_bits() => moved[k],
                k => b[k] + (moved[k] - a[k]),
            });
        }
    }

    /// Makes directions at both sides alike, such as velocities.
    pub fn level_directions(&self, out: &mut [Vector]) {
        for &[low, high] in &self.pairs {
            out[low as usize][self.axis] = 0.0;
            out[high as usize] = out[low as usize];
        }
    }
}

const NONE: u32 = u32::MAX;

fn names(sides: &[&Group]) -> String {
    let names: Vec<String> = sides
        .iter()
        .map(|side| format!("\"{}\"", side.name))
        .collect();
    match names.len() {
        1 => format!("boundary tag {} is", names[0]),
        _ => format!("boundary tags {} are", names.join(", ")),
    }
}

/// Returns whether the sides have two faces for each volume cell.
fn covers(mesh: &Mesh, sides: &[&Group]) -> bool {
    let n_cells: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
    let n_faces: usize = sides.iter().map(|side| side.cells.len()).sum();
    n_faces == 2 * n_cells
}

/// Twice the area vector of a face.
fn area(boundary: &Boundary, nodes: &[u32]) -> Vector {
    let at = |i: usize| boundary.position(nodes[i]);
    let mut sum = [0.0; 3];
    for i in 2..nodes.len() {
        let part = cross(sub(at(i - 1), at(0)), sub(at(i), at(0)));
        sum = [0, 1, 2].map(|k| sum[k] + part[k]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    fn layer() -> Mesh {
        let mut mesh = Mesh::read("testdata/naca0012.vtu").expect("it is there");
        mesh.extrude(0.1).expect("it is plane");
        mesh
    }

    #[test]
    fn nodes_over_one_another_are_found_and_kept_alike() {
        let mesh = layer();
        let n = mesh.points.len() as u32 / 2;
        let found = OneLayer::find(&mesh)
            .expect("it is one layer")
            .expect("it has empty sides");
        assert_eq!(found.axis, 2);
        assert!(
            found
                .pairs
                .iter()
                .eq(&(0..n).map(|node| [node, node + n]).collect::<Vec<_>>())
        );
        let mut out: Vec<Vector> = mesh
            .points
            .iter()
            .map(|x| [x[0] + 0.1 * x[2], x[1] / 3.0, x[2] + 0.5])
            .collect();
        found.level(&mesh.points, &mut out);
        for &[low, high] in &found.pairs {
            let (low, high) = (out[low as usize], out[high as usize]);
            assert_eq!(
                (low[0].to_bits(), low[1].to_bits()),
                (high[0].to_bits(), high[1].to_bits())
            );
            assert_eq!((low[2], high[2]), (0.0, 0.1));
        }
    }

    #[test]
    fn what_is_not_one_layer_is_refused_by_name() {
        let mut twice = layer();
        let back = twice
            .groups
            .iter()
            .position(|tag| tag.name == "back")
            .expect("it has one");
        twice.groups[back].condition = None;
        let error = OneLayer::find(&twice)
            .expect_err("one side is missing")
            .message;
        assert!(
            error.starts_with("boundary tag \"front\" is called empty"),
            "{error}"
        );
        let mut slanted = layer();
        slanted
            .points
            .iter_mut()
            .for_each(|x| *x = [x[0], x[1] + x[2], x[2] + 0.3 * x[0]]);
        let error = OneLayer::find(&slanted).expect_err("it is slanted").message;
        assert_says(
            &error,
            "\"back\", \"front\" are called empty, but not normal",
        );
        let mut none = layer();
        none.groups.iter_mut().for_each(|tag| tag.condition = None);
        assert_eq!(OneLayer::find(&none).expect("it has no such sides"), None);
    }
}
