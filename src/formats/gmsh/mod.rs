//! Gmsh MSH: reads versions 1 to 4.1, writes 2.2 and 4.1, as text and binary.
//!
//! Physical groups are the groups of the mesh. Where a file has no physical group of the boundary's
//! dimension but elements there, their elementary entities, called by their number, are the tags.
//! Values at nodes and elements are arrays of the mesh.

mod data;
mod elements;
mod elements2;
mod entities;
mod foreign;
mod groups;
mod index;
mod kinds;
mod lattice;
mod nodes;
mod read;
mod sink;
mod stream;
mod write22;
mod write41;
mod write_data;
mod written;

use super::{Format, Notes, Precision, ReadOptions, Source, WriteOptions};
use crate::error::Result;
use crate::mesh::Mesh;
use std::io::Write;

/// Gmsh MSH 4.1 (.msh). Reads every version.
pub struct Msh;

/// Gmsh MSH 2.2 (.msh2). Reads every version.
pub struct Msh22;

impl Format for Msh {
    fn name(&self) -> &'static str {
        "msh"
    }
    fn title(&self) -> &'static str {
        "Gmsh MSH 4.1 (.msh)"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["msh", "msh4"]
    }
    fn recognizes(&self, head: &[u8]) -> bool {
        is_msh(head)
    }
    fn version(&self, head: &[u8]) -> Option<String> {
        super::word_after(head, b"$MeshFormat")
    }

    fn read(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes(), options, notes)
    }
    fn steps(&self, source: &Source) -> Result<Vec<f64>> {
        read::steps(source.bytes())
    }
    fn write(
        &self,
        mesh: &Mesh,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Vec<String>> {
        write41::write(mesh, out, options)
    }
    fn holds_arrays(&self) -> bool {
        true
    }
    fn rounds(&self, _asked: Precision) -> bool {
        false
    }
}

impl Format for Msh22 {
    fn name(&self) -> &'static str {
        "msh22"
    }
    fn title(&self) -> &'static str {
        "Gmsh MSH 2.2 (.msh2)"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["msh2", "msh22"]
    }
    fn recognizes(&self, head: &[u8]) -> bool {
        is_msh(head)
    }
    fn read(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes(), options, notes)
    }
    fn steps(&self, source: &Source) -> Result<Vec<f64>> {
        read::steps(source.bytes())
    }
    fn write(
        &self,
        mesh: &Mesh,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Vec<String>> {
        write22::write(mesh, out, options)
    }
    fn holds_arrays(&self) -> bool {
        true
    }
    fn rounds(&self, _asked: Precision) -> bool {
        false
    }
}

/// Whether a file starts as one of Gmsh's does; `$NOD` starts version 1.
fn is_msh(head: &[u8]) -> bool {
    let head = head.trim_ascii_start();
    [&b"$MeshFormat"[..], b"$Comments", b"$NOD"]
        .iter()
        .any(|start| head.starts_with(start))
}

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;
