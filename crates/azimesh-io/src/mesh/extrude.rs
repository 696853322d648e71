//! One layer of solid cells from a mesh in a plane.

use super::arrays::select_tuples;
use super::sides;
use super::{CellKind, CellSet, Cells, EMPTY, Group, Mesh, MeshView, too_many};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::vector::{Vector, sub};

impl MeshView<'_> {
    /// The quarter turn that brings the mesh to one z, with areas that are positive for the most part: the end of a sentence,
    /// empty if there is none.
    pub(crate) fn turned_flat(&self) -> String {
        let Some([low, high]) = self.bounds() else {
            return String::new();
        };
        let extent = [0, 1, 2].map(|i| high[i] - low[i]);
        let size = extent.into_iter().fold(0.0, f64::max);
        let flat = (0..2).find(|i| extent[*i] <= 1e-12 * size);
        flat.map_or_else(String::new, |i| {
            // A turn about x takes normals along +y to +z; a turn about y takes normals along -x to +z.
            let is_along = self.areas_along(i).map(|(_, area)| area).sum::<f64>() > 0.0;
            let (axis, is_positive) = [("y", !is_along), ("x", is_along)][i];
            let angle = if is_positive { 90 } else { -90 };
            format!("; {} {axis},{angle} turns it into one", option("rotate"))
        })
    }

    /// Number of plane cells whose nodes turn clockwise, seen from +z, and the first of them.
    pub fn clockwise(&self) -> (usize, Option<usize>) {
        let mut cells = self.areas_along(2).filter(|(_, area)| *area < 0.0);
        let first = cells.next().map(|(cell, _)| cell);
        (cells.count() + usize::from(first.is_some()), first)
    }

    /// Plane cells with their areas as seen from the positive side of an axis.
    fn areas_along(&self, axis: usize) -> impl Iterator<Item = (usize, f64)> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let runs = self.cells.runs().filter(|run| run.kind.dimension() == 2);
        runs.flat_map(|run| run.cell_refs()).map(move |cell| {
            let nodes = &cell.nodes[..cell.kind.n_corners(cell.nodes.len())];
            let from = |i: usize| {
                sub(
                    self.points[nodes[i] as usize],
                    self.points[nodes[0] as usize],
                )
            };
            let cross = |[a, b]: [Vector; 2]| a[u] * b[v] - a[v] * b[u];
            let twice = (2..nodes.len()).map(|i| cross([from(i - 1), from(i)]));
            (cell.index, 0.5 * twice.sum::<f64>())
        })
    }
}

/// The tags of the two sides.
const SIDES: [&str; 2] = ["back", "front"];

impl Mesh {
    /// Makes a layer of cells of this height, in the direction of z, from a mesh in a plane of constant z. The new
    /// sides and cells keep the tags and zones of their edges and cells; the two planes get the tags `back` and `front` with
    /// the condition `empty`. Node `i` stays node `i`; the node above it is `i` plus the number of nodes.
    ///
    /// # Errors
    /// For meshes that are not in such a plane, for curved cells, and where nodes or cells become too many.
    pub fn extrude(&mut self, height: f64) -> Result<()> {
        self.check_plane()?;
        let n_nodes = self.points.len();
        let volume: Vec<usize> = self
            .volume_runs()
            .flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
            .collect();
        let (most, n_cells) = (u32::MAX as usize - 1, self.cells.len() + 2 * volume.len());
        if 2 * n_nodes > most || n_cells > most {
            return Err(Error::input(too_many("nodes or cells")));
        }
        let solid = self.layer(&volume)?;
        let first = self.cells.len();
        self.cells = solid;
        self.points.extend_from_within(..);
        self.points[n_nodes..]
            .iter_mut()
            .for_each(|point| point[2] += height);
        for group in &mut self.groups {
            group.dimension += 1;
        }
        for (side, name) in SIDES.iter().enumerate() {
            let from = first + side * volume.len();
            self.tag_side(name, from..from + volume.len());
        }
        let twice: Vec<usize> = (0..2 * n_nodes).map(|node| node % n_nodes).collect();
        select_tuples(&mut self.point_arrays, &twice);
        let sides = volume.iter().chain(&volume).copied();
        let sources: Vec<usize> = (0..first).chain(sides).collect();
        select_tuples(&mut self.cell_arrays, &sources);
        self.space = None;
        self.origin = Default::default();
        Ok(())
    }

    fn check_plane(&self) -> Result<()> {
        if self.dimension() != 2 || self.space_dimension() != 2 {
            return Err(Error::input(format!(
                "{} is for meshes of plane cells at one z, and this one is not{}",
                option("extrude"),
                self.view().turned_flat()
            )));
        }
        match self.cells.runs().find(|run| run.kind.is_curved()) {
            None => Ok(()),
            Some(run) => Err(Error::input(format!(
                "cell {} is a {}; {} is for cells with straight edges, which {} makes",
                run.first_cell,
                run.kind.name(),
                option("extrude"),
                option("linearize")
            ))),
        }
    }

    /// The cells of the layer in the order of the plane's cells, then its back and its front.
    fn layer(&self, volume: &[usize]) -> Result<Cells> {
        let up = self.points.len() as u32;
        let mut cells = Cells::new();
        let mut nodes = Vec::new();
        for run in self.cells.runs() {
            for flat in run.cells() {
                nodes.clear();
                nodes.extend_from_slice(flat);
                match run.kind {
                    CellKind::Vertex => cells.push(CellKind::Line, &[flat[0], flat[0] + up]),
                    CellKind::Line => cells.push(
                        CellKind::Quadrilateral,
                        &[flat[0], flat[1], flat[1] + up, flat[0] + up],
                    ),
                    _ => {
                        self.turn_anticlockwise(&mut nodes);
                        push_prism(&mut cells, &nodes, up)?;
                    }
                }
            }
        }
        for (above, is_back) in [(0, true), (up, false)] {
            for &cell in volume {
                nodes.clear();
                nodes.extend(self.cells.get(cell).nodes.iter().map(|node| node + above));
                let flat: Vec<u32> = self.cells.get(cell).nodes.to_vec();
                if self.is_clockwise(&flat) != is_back {
                    nodes[1..].reverse();
                }
                cells.push(sides::flat(nodes.len()), &nodes);
            }
        }
        Ok(cells)
    }

    fn turn_anticlockwise(&self, nodes: &mut [u32]) {
        if self.is_clockwise(nodes) {
            nodes[1..].reverse();
        }
    }

    fn is_clockwise(&self, nodes: &[u32]) -> bool {
        let at = |i: usize| -> Vector { self.points[nodes[i % nodes.len()] as usize] };
        let origin = at(0);
        let from = |i: usize| [at(i)[0] - origin[0], at(i)[1] - origin[1]];
        let cross = |i: usize| from(i)[0] * from(i + 1)[1] - from(i)[1] * from(i + 1)[0];
        (0..nodes.len()).map(cross).sum::<f64>() < 0.0
    }

    fn tag_side(&mut self, name: &str, cells: std::ops::Range<usize>) {
        let is_taken = |name: &str| {
            self.groups
                .iter()
                .any(|group| group.dimension == 2 && group.name == name)
        };
        let mut unique = name.to_owned();
        let mut n = 2;
        while is_taken(&unique) {
            unique = format!("{name}_{n}");
            n += 1;
        }
        let mut set = CellSet::new();
        set.push_range(cells);
        self.groups.push(Group {
            dimension: 2,
            name: unique,
            number: None,
            condition: Some(EMPTY.to_owned()),
            cells: set,
        });
    }
}

/// A prism over a polygon that turns anticlockwise seen from above.
fn push_prism(cells: &mut Cells, low: &[u32], up: u32) -> Result<()> {
    let n = low.len();
    let kind = match n {
        3 => CellKind::Wedge,
        4 => CellKind::Hexahedron,
        5 => CellKind::PentagonalPrism,
        6 => CellKind::HexagonalPrism,
        _ => return push_polyhedron(cells, low, up),
    };
    let high = low.iter().map(|node| node + up);
    let nodes: Vec<u32> = low.iter().copied().chain(high).collect();
    cells.push(kind, &nodes);
    Ok(())
}

fn push_polyhedron(cells: &mut Cells, low: &[u32], up: u32) -> Result<()> {
    let n = low.len();
    let mut stream = vec![n as u32 + 2, n as u32];
    stream.extend(low.iter().rev());
    stream.push(n as u32);
    stream.extend(low.iter().map(|node| node + up));
    for (i, &from) in low.iter().enumerate() {
        let to = low[(i + 1) % n];
        stream.extend([4, from, to, to + up, from + up]);
    }
    cells.push_polyhedron(&stream)
}

#[cfg(test)]
mod tests {
    use super::super::DataArray;
    use super::*;
    use crate::mesh::Values;

    fn plane() -> Mesh {
        let mut mesh = Mesh {
            points: vec![
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [2.0, 0.5, 0.0],
            ],
            point_arrays: vec![DataArray::scalar(
                "p",
                Values::F64(vec![0.0, 1.0, 2.0, 3.0, 4.0]),
            )],
            cell_arrays: vec![DataArray::scalar("c", Values::F64(vec![7.0, 8.0, 9.0]))],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        // Clockwise.
        mesh.cells.push(CellKind::Triangle, &[1, 2, 4]);
        mesh.add_tag("back", [1]).expect("it is a boundary edge");
        mesh
    }

    #[test]
    fn a_plane_mesh_becomes_one_layer_with_two_empty_sides() {
        let mut mesh = plane();
        mesh.extrude(0.5).expect("it is plane");
        mesh.validate().expect("it is a mesh");
        let kinds: Vec<_> = (0..7).map(|cell| mesh.cells.get(cell).kind).collect();
        use CellKind::{Hexahedron as Hex, Quadrilateral as Quad, Triangle, Wedge};
        assert_eq!(kinds, [Hex, Quad, Wedge, Quad, Triangle, Quad, Triangle]);
        assert_eq!(mesh.cells.get(2).nodes, [1, 4, 2, 6, 9, 7]);
        assert_eq!(mesh.cells.get(3).nodes, [0, 3, 2, 1]);
        assert_eq!(mesh.cells.get(6).nodes, [6, 9, 7]);
        let tags: Vec<_> = mesh
            .boundary_tags()
            .map(|tag| (&*tag.name, tag.condition.as_deref(), tag.cells.len()))
            .collect();
        assert_eq!(
            tags,
            [
                ("back", None, 1),
                ("back_2", Some("empty"), 2),
                ("front", Some("empty"), 2)
            ]
        );
        assert_eq!(
            mesh.cell_arrays[0].values,
            Values::F64(vec![7.0, 8.0, 9.0, 7.0, 9.0, 7.0, 9.0])
        );
        assert_eq!(mesh.points[9], [2.0, 0.5, 0.5]);
    }

    #[test]
    fn what_is_not_a_plane_is_refused() {
        let mut bent = plane();
        bent.points[4][2] = 1.0;
        assert!(bent.extrude(1.0).is_err());
        let mut curved = Mesh::read("testdata/naca0012.vtu").expect("it is there");
        curved.extrude(0.1).expect("it is plane");
        assert!(curved.extrude(0.1).is_err(), "it is solid now");
    }
}
