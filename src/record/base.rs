//! base.toml: the base points of a mesh, and their purpose.

use azimesh_core::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Content of base.toml.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseFile {
    /// Version of this layout.
    pub version: u32,
    /// Kernel of the interpolation.
    pub kernel: String,
    /// Support radius, in mesh units.
    pub support_radius: f64,
    /// Requested tolerance, in mesh units.
    pub tolerance: f64,
    /// Largest error at any surface node and step, in mesh units.
    pub error: f64,
    /// Number of nodes of the mesh.
    pub mesh_nodes: usize,
    /// Hash of the node positions of the mesh.
    pub mesh_points_blake3: String,
    /// Mesh nodes that are base points, in the order of selection; with `twist` for the translations.
    pub nodes: Vec<u32>,
    /// With `twist`, the base points of the rotations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_nodes: Option<Vec<u32>>,
    /// Support radius of the rotations, if it differs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_radius: Option<f64>,
}

impl BaseFile {
    /// Returns the text of the file.
    ///
    /// # Errors
    /// If TOML cannot hold it; it can hold every number.
    pub fn text(&self) -> Result<String> {
        toml::to_string(self)
            .map_err(|error| Error::system(format!("the base points cannot be written: {error}")))
    }

    /// Parses the bytes of a file.
    ///
    /// # Errors
    /// If they are not base points, with the line.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let no_base = |reason: &str| {
            Error::input(format!(
                "this is not a file of base points, as `azimesh select -o` and `azimesh deform` write them: {reason}"
            ))
        };
        let text = std::str::from_utf8(bytes).map_err(|_| no_base("it is not text"))?;
        toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = text[..start].bytes().filter(|b| *b == b'\n').count() + 1;
            no_base(error.message()).line(line as u64)
        })
    }
}
