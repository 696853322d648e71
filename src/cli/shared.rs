//! Reads meshes that several ranks share: each rank reads its part, or the first rank reads and distributes the whole.

use super::Context;
use azimesh_core::error::Result;
use azimesh_deform::motion::{Schedule, SurfaceOutput};
use azimesh_io::formats::{
    Format, Shared, SharedFile, SharedMesh, WriteOptions, by_name, read_parts, read_together,
};
use azimesh_io::mesh::Mesh;
use std::path::Path;

/// Returns the reason why ranks do not write a file together.
pub(super) fn why_not_written(format: &Format, options: &WriteOptions) -> Option<&'static str> {
    let is_written = (format.takes_numbers_apart)(options);
    (!is_written).then_some("ranks do not write this format together")
}

/// Returns the reason why ranks do not write the meshes of a schedule together.
pub(super) fn why_not_run(schedule: &Schedule) -> Option<&'static str> {
    let output = &schedule.output;
    let Ok(format) = by_name(output.format()) else {
        return Some("its format is not known");
    };
    let surfaces = (output.surface != SurfaceOutput::None).then_some("it writes surfaces");
    let cells = (!output.boundary_faces).then_some("it writes the volume cells alone");
    why_not_written(format, &output.write_options())
        .or(surfaces)
        .or(cells)
}

/// Returns the reason why ranks do not write a mesh with this layout together.
pub(super) fn why_not_cells(format: &Format, layout: &Mesh) -> std::result::Result<(), String> {
    if layout.dimension() != 3 {
        Err("it has no solid cells".to_owned())
    } else if (format.takes_cells_apart)(&layout.view()) {
        Ok(())
    } else {
        Err("ranks do not write its cells, or arrays at them, together".to_owned())
    }
}

impl Context {
    /// Reads the part of each rank of the mesh in a file; `of_first` names the file on the first rank. If parts cannot be read
    /// separately, that rank reads the whole by `read`, and the reason is returned too. A single process reads the whole without a
    /// reason.
    pub fn read_shared(
        &self,
        of_first: impl FnOnce() -> Shared,
        read: impl FnOnce() -> Result<Mesh>,
    ) -> Result<(Mesh, Option<String>)> {
        if self.ranks.n() == 1 {
            return Ok((read()?, None));
        }
        let file = self.ranks.broadcast(self.ranks.is_first().then(of_first));
        let parts = |file: SharedFile| {
            let parts = self.reading(file.path(), || Ok(read_parts(&file, &self.ranks)));
            parts.unwrap_or_else(|error| Err(error.to_string()))
        };
        match file.and_then(parts) {
            Ok(part) => Ok((part, None)),
            Err(reason) => Ok((self.share(read)?, Some(reason))),
        }
    }

    /// Reads the part of each rank of the mesh in the file that `of_first` names on the first rank, for output in `format`.
    ///
    /// # Errors
    /// On all ranks, the reason why the first rank has to read the mesh as a whole.
    pub fn read_together(
        &self,
        of_first: impl FnOnce() -> Shared,
        format: &Format,
    ) -> std::result::Result<SharedMesh, String> {
        let file = self.ranks.broadcast(self.ranks.is_first().then(of_first))?;
        let allows = |layout: &Mesh| why_not_cells(format, layout);
        let read = || Ok(read_together(&file, &self.ranks, allows));
        let read = self.reading(file.path(), read);
        read.unwrap_or_else(|error| Err(error.to_string()))
    }

    /// Prints with `-v` the reason why one rank has read a whole mesh.
    pub fn tell_why_whole(&self, path: &Path, reason: &str) {
        self.detail(&format!(
            "{}: read whole by one rank: {reason}",
            path.display()
        ));
    }

    /// Distributes the mesh that `read` returns on the first rank: each rank gets its part.
    pub fn share(&self, read: impl FnOnce() -> Result<Mesh>) -> Result<Mesh> {
        let of_first = if self.ranks.is_first() {
            read()
        } else {
            Ok(Mesh::default())
        };
        Mesh::shared(of_first, &self.ranks)
    }
}
