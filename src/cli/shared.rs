//! Reads meshes that several ranks share: each rank its part, or the first rank the whole, which it cuts.

use super::Context;
use crate::error::Result;
use crate::formats::{Shared, SharedFile, read_parts};
use crate::mesh::Mesh;
use std::path::Path;

impl Context {
    /// The part of each rank of the mesh in the file that `of_first` gives on the first rank. Where parts cannot be read alone, that
    /// rank reads the whole by `read`, and the reason is given too. One process alone reads the whole without a reason.
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

    /// Tells with `-v` why one rank has read a whole mesh.
    pub fn tell_why_whole(&self, path: &Path, reason: &str) {
        self.detail(&format!(
            "{}: read whole by one rank: {reason}",
            path.display()
        ));
    }

    /// Of the mesh that `read` gives on the first rank each rank gets its part.
    fn share(&self, read: impl FnOnce() -> Result<Mesh>) -> Result<Mesh> {
        let of_first = match self.ranks.is_first() {
            true => read(),
            false => Ok(Mesh::default()),
        };
        Mesh::shared(of_first, &self.ranks)
    }
}
