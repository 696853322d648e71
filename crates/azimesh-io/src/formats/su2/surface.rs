//! The file that SU2 reads at each iteration of an unsteady run with `SURFACE_MOVEMENT= EXTERNAL`: the index of
//! each node of the moving surfaces in the SU2 mesh, and where it is.
//!
//! SU2 reads line by line, and takes a line that is no node for node 0: so there is no header. It takes a node of a
//! moving marker that is not in the file to the origin: so all of them are in it.

use super::super::records::{push_integer, push_real, write_records};
use super::parts::WrittenZones;
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::io::Write;

/// Writes the places of some nodes: index, x, y and, in space, z.
///
/// # Errors
/// Where they cannot be written.
pub fn write_surface(mesh: &MeshView, nodes: &[u32], out: &mut dyn Write) -> Result<()> {
    let dimension = usize::from(mesh.dimension().clamp(2, 3));
    write_records(out, nodes.len(), &|range, buffer| {
        for &node in &nodes[range] {
            push_integer(buffer, node.into());
            for x in &mesh.points[node as usize][..dimension] {
                buffer.push(b' ');
                push_real(buffer, *x);
            }
            buffer.push(b'\n');
        }
    })
}

/// Into how many SU2 zones a mesh is written; each numbers its nodes from 0.
pub fn n_zones(mesh: &MeshView) -> usize {
    match mesh.zones().next() {
        None => 1,
        Some(_) => WrittenZones::of(mesh).zones.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn a_surface_file_has_the_index_and_the_place_of_each_node() {
        let mesh = Mesh::read("testdata/airfoil_hybrid.su2").expect("it is there");
        let nodes = [3, 0, 7];
        let mut text = Vec::new();
        write_surface(&mesh.view(), &nodes, &mut text).expect("it can be written");
        let text = String::from_utf8(text).expect("it is text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        for (line, node) in lines.iter().zip(nodes) {
            let numbers: Vec<f64> = line
                .split(' ')
                .map(|x| x.parse().expect("a number"))
                .collect();
            let [x, y, _] = mesh.points[node as usize];
            assert_eq!(numbers, [f64::from(node), x, y]);
        }
    }

    #[test]
    fn a_solid_has_three_coordinates() {
        let mesh = Mesh::read("testdata/mixed_cells.su2").expect("it is there");
        let mut text = Vec::new();
        write_surface(&mesh.view(), &[1], &mut text).expect("it can be written");
        assert_eq!(text.iter().filter(|byte| **byte == b' ').count(), 3);
    }
}
