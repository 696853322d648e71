//! VTU.

use super::{Format, ReadOptions, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;

/// VTK XML unstructured grid (.vtu).
pub struct Vtu;

impl Format for Vtu {
    fn name(&self) -> &'static str {
        "vtu"
    }
    fn title(&self) -> &'static str {
        "VTK XML unstructured grid (.vtu)"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["vtu"]
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
