//! Which way the sides of cells turn: outward or inward, the same for all cells of a kind. Knows nothing of the
//! order of faces.
//!
//! A cell that a motion has turned inside out keeps the orientation of its kind: faces of neighbouring cells have to
//! agree, and a checker of meshes is to find the negative volume.

use crate::mesh::sides::for_each_side;
use crate::mesh::{CellKind, CellRef, CellRun, MeshView};
use azimesh_core::geometry::vector::{Vector, cross, dot, sub};
use azimesh_core::parallel::{BLOCK, map_blocks};
use std::collections::{BTreeMap, BTreeSet};

/// The orientation of the sides of the cells of a mesh.
pub(super) struct Orientation {
    /// Kinds whose sides turn inward as the kind has them.
    inward: BTreeSet<CellKind>,
    /// Polyhedra whose sides do not agree among themselves, and for each side whether it turns inward.
    mixed: BTreeMap<u32, Vec<bool>>,
}

impl Orientation {
    /// Judged by the signs of the volumes: those of most cells of a kind decide for all of them.
    pub fn of(mesh: &MeshView) -> Self {
        let mut balance: BTreeMap<CellKind, i64> = BTreeMap::new();
        let mut mixed = BTreeMap::new();
        for run in mesh.volume_runs() {
            let blocks = map_blocks(run.n_cells(), BLOCK, &|cells| {
                let mut found = (0_i64, Vec::new());
                for i in cells {
                    let nodes = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                    let (kind, index) = (run.kind, run.first_cell + i);
                    judge(mesh, &CellRef { index, kind, nodes }, &mut found);
                }
                found
            });
            for (sum, own) in blocks {
                *balance.entry(run.kind.linear()).or_default() += sum;
                mixed.extend(own);
            }
        }
        let inward = balance.into_iter().filter(|(_, sum)| *sum < 0);
        Self {
            inward: inward.map(|(kind, _)| kind).collect(),
            mixed,
        }
    }

    /// Number of cells whose sides all turn inward as their kind has them.
    pub fn n_reversed(&self, mesh: &MeshView) -> usize {
        let runs = mesh.volume_runs();
        let inward = runs.filter(|run| self.inward.contains(&run.kind.linear()));
        let of_run = |run: CellRun| {
            let cells = run.first_cell as u32..(run.first_cell + run.n_cells()) as u32;
            run.n_cells() - self.mixed.range(cells).count()
        };
        inward.map(of_run).sum()
    }

    /// Whether a side of a cell, with its corners as the cell has them, turns inward.
    pub fn is_inward(&self, cell: &CellRef<'_>, side: usize) -> bool {
        let own = || self.mixed.get(&(cell.index as u32));
        match cell.kind {
            CellKind::Polyhedron if !self.mixed.is_empty() => {
                let common = self.inward.contains(&CellKind::Polyhedron);
                own().map_or(common, |sides| sides.get(side).copied().unwrap_or(false))
            }
            kind => self.inward.contains(&kind.linear()),
        }
    }
}

/// Adds the sign of the volume of a cell, or the sides of a polyhedron that do not agree.
fn judge(mesh: &MeshView, cell: &CellRef<'_>, found: &mut (i64, Vec<(u32, Vec<bool>)>)) {
    if cell.kind == CellKind::Polyhedron {
        let faces: Vec<&[u32]> = mesh.cells.polyhedron_faces(cell.index).collect();
        if let Some(mut turned) = disagreeing(&faces) {
            if volume(mesh, cell, |side| turned[side]) < 0.0 {
                turned.iter_mut().for_each(|turned| *turned = !*turned);
            }
            found.1.push((cell.index as u32, turned));
            return;
        }
    }
    let volume = volume(mesh, cell, |_| false);
    found.0 += i64::from(volume > 0.0) - i64::from(volume < 0.0);
}

/// Six times the volume inside the sides of a cell, those that are `turned` taken the other way round.
fn volume(mesh: &MeshView, cell: &CellRef<'_>, turned: impl Fn(usize) -> bool) -> f64 {
    let Some(&first) = cell.nodes.first() else {
        return 0.0;
    };
    let origin = mesh.points[first as usize];
    let at = |node: u32| -> Vector { sub(mesh.points[node as usize], origin) };
    let mut sum = 0.0;
    for_each_side(mesh.cells, cell, |side, corners| {
        let mut own = 0.0;
        for i in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[i - 1], corners[i]].map(at);
            own += dot(a, cross(b, c));
        }
        sum += if turned(side) { -own } else { own };
    });
    sum
}

/// For each face of a polyhedron whether it turns against the first; `None` where no face does. Faces that share
/// an edge pass over it in opposite directions where they agree.
fn disagreeing(faces: &[&[u32]]) -> Option<Vec<bool>> {
    let mut edges: Vec<([u32; 2], usize, bool)> = Vec::new();
    for (face, nodes) in faces.iter().enumerate() {
        for (i, &from) in nodes.iter().enumerate() {
            let to = nodes[(i + 1) % nodes.len()];
            if from != to {
                edges.push(([from.min(to), from.max(to)], face, from < to));
            }
        }
    }
    edges.sort_unstable();
    let pairs = || {
        edges
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|pair| pair.len() == 2)
    };
    if pairs().all(|pair| pair[0].2 != pair[1].2) {
        return None;
    }
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); faces.len()];
    for pair in pairs() {
        let agrees = pair[0].2 != pair[1].2;
        beside[pair[0].1].push((pair[1].1, agrees));
        beside[pair[1].1].push((pair[0].1, agrees));
    }
    let mut turned: Vec<Option<bool>> = vec![None; faces.len()];
    for start in 0..faces.len() {
        let mut waiting = vec![start];
        turned[start].get_or_insert(false);
        while let Some(face) = waiting.pop() {
            let own = turned[face].unwrap_or(false);
            for &(other, agrees) in &beside[face] {
                if turned[other].is_none() {
                    turned[other] = Some(own == agrees);
                    waiting.push(other);
                }
            }
        }
    }
    Some(
        turned
            .into_iter()
            .map(|turned| turned.unwrap_or(false))
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    fn cube(stream_turned: &[usize]) -> Mesh {
        let corner = |i: usize| [1, 2, 4].map(|bit| f64::from(u8::from(i & bit != 0)));
        let mut faces = CellKind::Hexahedron.faces().to_vec();
        faces.sort();
        // Nodes of a hexahedron, numbered by the bits of their places.
        let bits = [0, 1, 3, 2, 4, 5, 7, 6];
        let mut stream = vec![6];
        for (i, face) in faces.iter().enumerate() {
            let mut nodes: Vec<u32> = face.iter().map(|&node| bits[usize::from(node)]).collect();
            if stream_turned.contains(&i) {
                nodes.reverse();
            }
            stream.push(4);
            stream.extend(nodes);
        }
        let mut mesh = Mesh {
            points: (0..8).map(corner).collect(),
            ..Mesh::default()
        };
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
        mesh
    }

    fn inward(mesh: &Mesh) -> Vec<usize> {
        let view = mesh.view();
        let orientation = Orientation::of(&view);
        let cell = mesh.cells.get(0);
        (0..6)
            .filter(|&side| orientation.is_inward(&cell, side))
            .collect()
    }

    #[test]
    fn faces_of_a_polyhedron_that_turn_inward_are_found() {
        assert_eq!(inward(&cube(&[])), [0; 0]);
        assert_eq!(inward(&cube(&[0, 1, 2, 3, 4, 5])), [0, 1, 2, 3, 4, 5]);
        assert_eq!(inward(&cube(&[0, 3])), [0, 3]);
        assert_eq!(inward(&cube(&[0, 1, 2, 4])), [0, 1, 2, 4]);
    }

    #[test]
    fn a_folded_cell_turns_as_the_others_of_its_kind() {
        let mut mesh = Mesh::default();
        for i in 0..3 {
            let x = 3.0 * f64::from(i);
            let height = if i == 1 { -1.0 } else { 1.0 };
            mesh.points.extend([
                [x, 0.0, 0.0],
                [x + 1.0, 0.0, 0.0],
                [x, 1.0, 0.0],
                [x, 0.0, height],
            ]);
            let first = 4 * i as u32;
            let nodes: Vec<u32> = (first..first + 4).collect();
            mesh.cells.push(CellKind::Tetrahedron, &nodes);
        }
        let view = mesh.view();
        let orientation = Orientation::of(&view);
        assert!((0..3).all(|cell| !orientation.is_inward(&mesh.cells.get(cell), 0)));
    }
}
