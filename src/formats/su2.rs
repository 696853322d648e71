//! SU2.

use super::{Format, ReadOptions, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;

/// SU2 mesh (.su2).
pub struct Su2;

impl Format for Su2 {
    fn name(&self) -> &'static str {
        "su2"
    }
    fn title(&self) -> &'static str {
        "SU2 mesh (.su2)"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["su2"]
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
