//! Nodes of tags, nodes of no cell, and nodes at the same place.

use super::{Group, Mesh};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{collect, sort};

impl Mesh {
    /// Nodes of the boundary tags of this name, ascending.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
    /// let nodes = mesh.tag_nodes("airfoil")?;
    /// assert!(nodes.is_sorted());
    /// assert!(mesh.tag_nodes("airfoils").is_err());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the mesh has no boundary tag of that name; the message lists those that it has.
    pub fn tag_nodes(&self, name: &str) -> Result<Vec<u32>> {
        let of_name = |tag: &&Group| tag.name == name;
        let mut tags = self.boundary_tags().filter(of_name).peekable();
        tags.peek().ok_or_else(|| {
            let names: Vec<&str> = self.boundary_tags().map(|tag| tag.name.as_str()).collect();
            Error::input(if names.is_empty() {
                format!("tag \"{name}\" is not in the mesh, which has no boundary tags")
            } else {
                format!(
                    "tag \"{name}\" is not in the mesh; it has: {}",
                    names.join(", ")
                )
            })
        })?;
        let ranges = tags.flat_map(|tag| tag.cells.ranges());
        let runs = ranges.flat_map(|cells| self.cells.runs_in(cells));
        let mut nodes: Vec<u32> = runs.flat_map(|run| run.connectivity).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Marks the nodes that a cell has.
    pub fn nodes_of_cells(&self) -> Vec<bool> {
        self.cells.used_nodes(self.points.len())
    }

    /// Number of nodes that no cell has.
    pub fn n_orphan_nodes(&self) -> usize {
        let used = self.nodes_of_cells();
        used.iter().filter(|&&used| !used).count()
    }

    /// Number of nodes at the very place of one before them.
    pub fn n_repeated_nodes(&self) -> usize {
        let mut n = 0;
        for_each_shared_place(&self.points, &mut |nodes| n += nodes.len() - 1);
        n
    }
}

/// Calls `visit` with the nodes of each place where there are several, ascending.
pub(crate) fn for_each_shared_place(points: &[[f64; 3]], visit: &mut dyn FnMut(&[u32])) {
    // -0 is the same place as 0.
    let place = |node: u32| points[node as usize].map(|x| (x + 0.0).to_bits());
    let mixed = |node: u32| {
        place(node).into_iter().fold(0u64, |hash, bits| {
            let product = u128::from(hash ^ bits ^ 0xf39c_c060_5ced_c835) * 0x9e37_79b9_7f4a_7c15;
            (product >> 64) as u64 ^ product as u64
        })
    };
    let mut keys = collect(points.len(), |node| (mixed(node as u32), node as u32));
    sort(&mut keys);
    let mut alike: Vec<([u64; 3], u32)> = Vec::new();
    for same_key in keys.chunk_by(|a, b| a.0 == b.0) {
        if same_key.len() == 1 {
            continue;
        }
        alike.clear();
        alike.extend(same_key.iter().map(|(_, node)| (place(*node), *node)));
        alike.sort_unstable();
        for same in alike.chunk_by(|a, b| a.0 == b.0) {
            if same.len() > 1 {
                visit(&same.iter().map(|(_, node)| *node).collect::<Vec<_>>());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, Group};
    use super::*;

    #[test]
    fn the_nodes_of_a_tag_are_found_and_a_tag_that_is_not_there_lists_those_that_are() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 4]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Line, &[2, 1]);
        mesh.cells.push(CellKind::Line, &[1, 0]);
        mesh.groups
            .push(Group::new(1, "wall", None, (1..3).collect()));
        assert_eq!(mesh.tag_nodes("wall").expect("it is there"), [0, 1, 2]);
        let error = mesh.tag_nodes("wing").expect_err("it is not");
        assert_eq!(
            error.to_string(),
            "tag \"wing\" is not in the mesh; it has: wall"
        );
    }

    #[test]
    fn nodes_without_a_cell_and_nodes_at_one_place_are_counted() {
        let mut mesh = Mesh::of_points(vec![
            [0.0, 1.0, 2.0],
            [-0.0, 1.0, 2.0],
            [2.0, 1.0, 0.0],
            [0.0, 1.0, 2.0],
        ]);
        mesh.cells.push(CellKind::Line, &[0, 2]);
        assert_eq!(mesh.n_orphan_nodes(), 2);
        assert_eq!(mesh.n_repeated_nodes(), 2);
    }
}
