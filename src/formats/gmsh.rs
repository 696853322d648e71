//! Gmsh.

use super::{Format, ReadOptions, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;

/// Gmsh MSH 4.1 (.msh).
pub struct Msh;

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
    fn recognizes(&self, _head: &[u8]) -> bool {
        false
    }
    fn read(&self, _bytes: &[u8], _options: &ReadOptions) -> Result<Mesh> {
        Err(Error::input("stub"))
    }
    fn write(&self, _: &Mesh, _: &mut dyn Write, _: &WriteOptions) -> Result<Vec<String>> {
        Err(Error::input("stub"))
    }
}

/// Gmsh MSH 2.2 (.msh2).
pub struct Msh22;

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
    fn recognizes(&self, _head: &[u8]) -> bool {
        false
    }
    fn read(&self, _bytes: &[u8], _options: &ReadOptions) -> Result<Mesh> {
        Err(Error::input("stub"))
    }
    fn write(&self, _: &Mesh, _: &mut dyn Write, _: &WriteOptions) -> Result<Vec<String>> {
        Err(Error::input("stub"))
    }
}
