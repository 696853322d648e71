//! Gmsh MSH: reads versions 2.0 to 2.2 and 4.1, writes 2.2 and 4.1, as text and binary.
//!
//! Physical groups are the groups of the mesh. Where a file has no physical group of the boundary's
//! dimension but elements there, their elementary entities, called by their number, are the tags.

mod elements;
mod elements2;
mod entities;
mod groups;
mod kinds;
mod nodes;
mod read;
mod stream;
mod write22;
mod write41;
mod written;

use super::{Format, Notes, ReadOptions, Source, WriteOptions};
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
    fn read(&self, source: &Source, _options: &ReadOptions, _notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes())
    }
    fn write(
        &self,
        mesh: &Mesh,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Vec<String>> {
        write41::write(mesh, out, options)
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
    fn read(&self, source: &Source, _options: &ReadOptions, _notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes())
    }
    fn write(
        &self,
        mesh: &Mesh,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Vec<String>> {
        write22::write(mesh, out, options)
    }
}

/// `$NOD` starts version 1, which is then refused by its name.
fn is_msh(head: &[u8]) -> bool {
    let head = head.trim_ascii_start();
    [&b"$MeshFormat"[..], b"$Comments", b"$NOD"]
        .iter()
        .any(|start| head.starts_with(start))
}

#[cfg(test)]
mod tests;
