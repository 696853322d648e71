//! A mesh in a plane from one layer of solid cells: the inverse of an extrusion.

use super::sides::{flat, for_each_side};
use super::transform::Turned;
use super::{CellKind, CellRef, Cells, EMPTY, Mesh};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::numbers::point;

/// Largest distance of nodes from the two sides, relative to the height of the layer.
const OFF_SIDE: f64 = 1e-3;

const NONE: u32 = u32::MAX;

/// Result of [`Mesh::flatten`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Flattened {
    /// The axis along which the layer was thin, 0 to 2.
    pub axis: usize,
    /// Arrays that were rotated with the mesh.
    pub turned: Turned,
    /// Node arrays whose values differ between the sides; the values of the low side are kept.
    pub differ: Vec<String>,
    /// Removed tags of the sides.
    pub sides: Vec<String>,
}

/// The sides of a layer that is thin along z.
struct Layer {
    low: f64,
    high: f64,
    /// True for nodes on the high side.
    is_high: Vec<bool>,
    /// Node above or below each node.
    twin: Vec<u32>,
}

impl Mesh {
    /// Makes plane cells of a layer of prisms between two plane sides, normal to x, y or z: the sides called `empty`, else the first of
    /// z, y and x along which the mesh is one layer. Faces and cells keep their tags and zones; the sides are removed. A layer along x
    /// or y is first rotated into the plane of x and y. Nodes of the low side keep their order.
    ///
    /// # Errors
    /// For meshes that are not one such layer, and curved cells.
    pub fn flatten(&mut self) -> Result<Flattened> {
        if self.dimension() != 3 {
            return Err(Error::input(format!(
                "{} is for one layer of solid cells, and this mesh has none",
                option("flatten")
            )));
        }
        if let Some(run) = self.cells.runs().find(|run| run.kind.is_curved()) {
            return Err(Error::input(format!(
                "cell {} is a {}; {} is for cells with straight edges, which {} makes",
                run.first_cell,
                run.kind.name(),
                option("flatten"),
                option("linearize")
            )));
        }
        let axis = self.thin_axis()?;
        let turned = self.transform(&to_z(axis));
        let layer = Layer::of(self)?;
        let (cells, sources) = self.flat_cells(&layer)?;
        let mut new_index = vec![usize::MAX; self.cells.len()];
        for (new, &old) in sources.iter().enumerate() {
            new_index[old] = new;
        }
        let mut sides = Vec::new();
        for group in &mut self.groups {
            let cells = group.cells.iter().map(|cell| new_index[cell]);
            let kept = cells.filter(|cell| *cell != usize::MAX).collect();
            let was_empty = group.cells.is_empty();
            group.cells = kept;
            if group.cells.is_empty() && !was_empty {
                sides.push(group.name.clone());
            }
            group.dimension = group.dimension.saturating_sub(1);
        }
        self.groups
            .retain(|group| !group.cells.is_empty() || !sides.contains(&group.name));
        for array in &mut self.cell_arrays {
            array.values = array.values.select(array.n_components, &sources);
        }
        self.cells = cells;
        let low: Vec<usize> = (0..self.points.len())
            .filter(|node| !layer.is_high[*node])
            .collect();
        let differ = self.arrays_that_differ(&layer, &low);
        self.keep_nodes(&low);
        self.space = None;
        self.origin = Default::default();
        Ok(Flattened {
            axis,
            turned,
            differ,
            sides,
        })
    }

    /// Returns the axis along which the mesh is thin.
    fn thin_axis(&self) -> Result<usize> {
        let is_empty = |condition: Option<&str>| condition == Some(EMPTY);
        let is_candidate = |axis: usize, cells: &mut dyn Iterator<Item = u32>| {
            let heights = cells.map(|node| self.points[node as usize][axis]);
            let heights: Vec<f64> = heights.collect();
            levels(&heights).is_some_and(|[low, high]| low < high)
        };
        let sides = self.boundary_tags();
        let sides = sides.filter(|tag| is_empty(tag.condition.as_deref()));
        let ranges = sides.flat_map(|tag| tag.cells.ranges());
        let of_sides: Vec<u32> = ranges
            .flat_map(|range| self.cells.runs_in(range))
            .flat_map(|run| run.connectivity)
            .copied()
            .collect();
        let solid = || self.volume_runs().flat_map(|run| run.connectivity).copied();
        let axes = [2, 1, 0];
        let between_sides = axes.into_iter().find(|&axis| {
            !of_sides.is_empty() && is_candidate(axis, &mut of_sides.iter().copied())
        });
        let found = between_sides.or_else(|| {
            let mut axes = axes.into_iter();
            axes.find(|&axis| is_candidate(axis, &mut solid()))
        });
        found.ok_or_else(|| {
            Error::input(format!(
                "{}: the nodes are not on two planes normal to z, y or x, so this is not one layer of cells",
                option("flatten")
            ))
        })
    }

    /// Returns the plane cells, each with the number of its original cell.
    fn flat_cells(&self, layer: &Layer) -> Result<(Cells, Vec<usize>)> {
        let (mut cells, mut sources) = (Cells::new(), Vec::new());
        for cell in self.cells.iter() {
            let flattened = match cell.kind.dimension() {
                3 => Some(self.base(&cell, layer)?),
                2 => lower_edge(cell.nodes, layer).map(|edge| (CellKind::Line, edge.to_vec())),
                1 if layer.twin[cell.nodes[0] as usize] == cell.nodes[1] => {
                    let low = cell
                        .nodes
                        .iter()
                        .find(|node| !layer.is_high[**node as usize]);
                    low.map(|node| (CellKind::Vertex, vec![*node]))
                }
                _ => None,
            };
            if let Some((kind, nodes)) = flattened {
                cells.push(kind, &nodes);
                sources.push(cell.index);
            }
        }
        Ok((cells, sources))
    }

    /// Returns the plane cell of a prism: its low face, anticlockwise seen from above.
    fn base(&self, cell: &CellRef<'_>, layer: &Layer) -> Result<(CellKind, Vec<u32>)> {
        let is_high = |node: &u32| layer.is_high[*node as usize];
        let (mut high, mut n_sides, mut is_prism) = (Vec::new(), 0, true);
        for_each_side(&self.cells, cell, |_, corners| {
            let n_high = corners.iter().filter(|node| is_high(node)).count();
            if n_high == corners.len() && high.is_empty() {
                high = corners.to_vec();
            } else if n_high == 0 || n_high == corners.len() {
                n_sides += 1;
            } else {
                is_prism &= lower_edge(corners, layer).is_some();
            }
        });
        if !is_prism || n_sides != 1 || 2 * high.len() != cell.nodes.len() {
            return Err(Error::input(format!(
                "{}: cell {} is a {} and not a prism between the two sides",
                option("flatten"),
                cell.index,
                cell.kind.name()
            )));
        }
        let mut low: Vec<u32> = high.iter().map(|node| layer.twin[*node as usize]).collect();
        let at = |node: u32| self.points[node as usize];
        let edges = low.iter().zip(low.iter().cycle().skip(1));
        let twice_area: f64 = edges
            .map(|(&a, &b)| at(a)[0] * at(b)[1] - at(b)[0] * at(a)[1])
            .sum();
        if twice_area < 0.0 {
            low[1..].reverse();
        }
        Ok((flat(low.len()), low))
    }

    /// Returns the names of node arrays whose values differ between the sides.
    fn arrays_that_differ(&self, layer: &Layer, low: &[usize]) -> Vec<String> {
        let paired = low.iter().copied().filter(|node| layer.twin[*node] != NONE);
        let low: Vec<usize> = paired.collect();
        let high: Vec<usize> = low.iter().map(|node| layer.twin[*node] as usize).collect();
        let arrays = self.point_arrays.iter();
        let differ = arrays.filter(|array| {
            let at = |nodes: &[usize]| array.values.select(array.n_components, nodes);
            at(&low) != at(&high)
        });
        differ.map(|array| array.name.clone()).collect()
    }
}

impl Layer {
    /// Returns the sides, with pairs of nodes that an edge between the sides connects.
    fn of(mesh: &Mesh) -> Result<Self> {
        let used = mesh.nodes_of_cells();
        let nodes = mesh.points.iter().zip(&used).filter(|(_, used)| **used);
        let bounds = Bounds::around(nodes.map(|(point, _)| point));
        let (low, high) = (bounds.low[2], bounds.high[2]);
        let mut layer = Self {
            low,
            high,
            is_high: mesh
                .points
                .iter()
                .map(|x| x[2] > 0.5 * (low + high))
                .collect(),
            twin: vec![NONE; mesh.points.len()],
        };
        layer.check_nodes(mesh, &used)?;
        let mut torn = None;
        for cell in mesh.volume_runs().flat_map(|run| run.cell_refs()) {
            for_each_side(&mesh.cells, &cell, |_, corners| {
                for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                    if layer.is_high[a as usize] == layer.is_high[b as usize] {
                        continue;
                    }
                    for (own, other) in [(a, b), (b, a)] {
                        let known = &mut layer.twin[own as usize];
                        if *known != NONE && *known != other {
                            torn.get_or_insert((cell.index, own));
                        }
                        *known = other;
                    }
                }
            });
        }
        match torn {
            None => Ok(layer),
            Some((cell, node)) => Err(Error::input(format!(
                "{}: node {node} of cell {cell} is joined with two nodes of the other side; the cells between the sides must be prisms",
                option("flatten")
            ))),
        }
    }

    fn check_nodes(&self, mesh: &Mesh, used: &[bool]) -> Result<()> {
        let off = |x: f64| (x - self.low).min(self.high - x);
        let is_off = |node: &usize| {
            used[*node] && off(mesh.points[*node][2]) > OFF_SIDE * (self.high - self.low)
        };
        let nodes = (0..used.len()).filter(is_off);
        let Some(first) = nodes.clone().next() else {
            return Ok(());
        };
        Err(Error::input(format!(
            "{}: {} of {} nodes are between the two sides of the layer; the first is node {first} at {}",
            option("flatten"),
            nodes.count(),
            used.len(),
            point(&mesh.points[first])
        )))
    }
}

/// Returns the low edge of a face between the sides: two nodes, and the nodes above them.
fn lower_edge(nodes: &[u32], layer: &Layer) -> Option<[u32; 2]> {
    let next = |i: usize| nodes[(i + 1) % nodes.len()];
    let is_low = |node: u32| !layer.is_high[node as usize];
    let at = (0..nodes.len()).find(|&i| is_low(nodes[i]) && is_low(next(i)))?;
    let twins = [nodes[at], next(at)].map(|node| layer.twin[node as usize]);
    let is_whole = nodes.len() == 4 && twins.iter().all(|twin| nodes.contains(twin));
    is_whole.then(|| [nodes[at], next(at)])
}

/// Returns the two planes of the heights; `None` if some height is on neither.
fn levels(heights: &[f64]) -> Option<[f64; 2]> {
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let off = |x: &f64| (x - low).min(high - x);
    let is_on = |x: &f64| off(x) <= OFF_SIDE * (high - low);
    heights.iter().all(is_on).then_some([low, high])
}

/// Rotates a coordinate axis to z by exact quarter turns.
fn to_z(axis: usize) -> Transform {
    let rotation = match axis {
        0 => [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        1 => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        _ => Transform::IDENTITY.rotation,
    };
    Transform {
        rotation,
        ..Transform::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DataArray, Values};

    fn plane() -> Mesh {
        let mut mesh = Mesh::read("testdata/naca0012.vtu").expect("it is there");
        let numbers = (0..mesh.points.len()).map(|i| i as f64).collect();
        mesh.point_arrays = vec![DataArray::scalar("n", Values::F64(numbers))];
        mesh
    }

    #[test]
    fn a_layer_becomes_the_plane_mesh_that_it_came_from() {
        let before = plane();
        let mut mesh = before.clone();
        mesh.extrude(0.1).expect("it is plane");
        let flattened = mesh.flatten().expect("it is one layer");
        assert_eq!(
            (flattened.axis, &*flattened.sides),
            (2, &["back".to_owned(), "front".to_owned()][..])
        );
        assert_eq!(mesh, before);
    }

    #[test]
    fn a_layer_along_another_axis_turns_with_its_vectors() {
        for (axis, turn) in [(0, to_z(0).inverse()), (1, to_z(1).inverse())] {
            let before = plane();
            let mut mesh = before.clone();
            mesh.extrude(0.1).expect("it is plane");
            let vectors = mesh.points.concat();
            mesh.point_arrays
                .push(DataArray::tuples("v", 3, Values::F64(vectors)));
            mesh.transform(&turn);
            mesh.groups.iter_mut().for_each(|tag| tag.condition = None);
            let flattened = mesh.flatten().expect("it is one layer");
            assert_eq!(flattened.axis, axis);
            assert_eq!(flattened.turned.turned, ["v"]);
            assert_eq!(flattened.differ, ["v"]);
            assert_eq!(mesh.points, before.points);
            assert_eq!(mesh.cells, before.cells);
            let vectors = mesh.point_arrays[1].values.to_f64().expect("reals");
            assert_eq!(vectors, before.points.concat());
        }
    }

    #[test]
    fn what_is_not_one_layer_of_prisms_is_refused() {
        let mut bent = plane();
        bent.extrude(0.1).expect("it is plane");
        bent.groups.iter_mut().for_each(|tag| tag.condition = None);
        bent.points[5][2] += 0.02;
        let error = bent.clone().flatten().expect_err("a node is off");
        assert!(
            error.message.contains("not on two planes"),
            "{}",
            error.message
        );
        assert!(plane().flatten().is_err());
        let mut tetrahedra = Mesh {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            ..Mesh::default()
        };
        tetrahedra.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        let error = tetrahedra.flatten().expect_err("it is no prism");
        assert!(
            error.message.contains("joined with two nodes")
                || error.message.contains("not a prism")
        );
    }
}
