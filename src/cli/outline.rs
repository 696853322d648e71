//! Where the outline of a mesh is enough for a command: nodes and cells are read and written piece by piece, by ranks or for slabs.

use super::Context;
use crate::formats::{Format, Loaded, WriteOptions, by_name};
use crate::motion::{Schedule, SurfaceOutput};
use std::path::Path;

/// Why something is not written piece by piece.
pub(super) fn why_not_written(format: &dyn Format, options: &WriteOptions) -> Option<&'static str> {
    let is_written = format.takes_numbers_apart(options);
    (!is_written).then_some("what is written is not written piece by piece")
}

/// Why the run of a schedule is not written piece by piece.
pub(super) fn why_not_run(schedule: &Schedule) -> Option<&'static str> {
    let output = &schedule.output;
    let Ok(format) = by_name(&output.format) else {
        return Some("its format is not known");
    };
    let surfaces = (output.surface != SurfaceOutput::None).then_some("it writes surfaces");
    why_not_written(format, &output.write_options()).or(surfaces)
}

impl Context {
    /// Reads the outline of a mesh that is written to a format.
    ///
    /// # Errors
    /// Why the mesh has to be read as a whole.
    pub(super) fn outline<T>(
        &self,
        path: &Path,
        format: &dyn Format,
        read: impl FnOnce() -> std::result::Result<T, String>,
        outline: impl Fn(&T) -> &Loaded,
    ) -> std::result::Result<T, String> {
        let found = self.reading(path, || Ok(read()));
        let found = found.map_err(|error| error.to_string())??;
        match format.takes_cells_apart(&outline(&found).mesh.view()) {
            true => Ok(found),
            false => Err("cells are not written in their order".to_owned()),
        }
    }
}
