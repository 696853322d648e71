//! Where the outline of a mesh is enough for a command: nodes and cells are read piece by piece, and
//! written by ranks.

use super::Context;
use crate::deform::{MeshFile, Plan, Sharing};
use crate::error::Result;
use crate::formats::{self, Format, Loaded, Location, SharedFile, WriteOptions, by_name};
use crate::motion::{Schedule, SurfaceOutput};
use std::path::Path;
use std::sync::Arc;

/// Why something is not written piece by piece.
pub(super) fn why_not_written(format: &dyn Format, options: &WriteOptions) -> Option<&'static str> {
    let is_written = format.takes_numbers_apart(options);
    (!is_written).then_some("what is written is not written piece by piece")
}

/// Whether an outline is enough: the format to which the mesh is written, if it is written; or why not.
pub(super) type Outlining<'a> = std::result::Result<Option<&'a dyn Format>, String>;

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
    /// The plan of a schedule on a mesh that does not move here, of which the outline is read where that is `enough`.
    pub(super) fn plan(
        &self,
        path: &Path,
        schedule: Schedule,
        enough: Outlining<'_>,
    ) -> Result<Plan> {
        let (format, options) = (self.input_format()?, self.read_options());
        let outline = enough.and_then(|written| {
            let file = SharedFile::new(path, format, &options)?;
            self.outline(path, written, || MeshFile::outline(file), |found| &found.1)
        });
        let (mesh, sharing) = match outline {
            Ok((file, outline)) => (outline, Sharing::File(file)),
            Err(reason) => {
                let read = |location: &Location| match format {
                    Some(format) => formats::read_as(format, location, &options),
                    None => formats::read(location, &options),
                };
                let whole = self.reading(path, || read(&self.open(path)?))?;
                self.detail(&format!("{}: read whole: {reason}", path.display()));
                (whole, Sharing::Alone)
            }
        };
        let mesh = self.with_notes(mesh, path);
        Plan::with(Arc::new(mesh), schedule, sharing).map_err(|error| error.file(path))
    }

    /// Reads the outline of a mesh that is written to a format, if it is written.
    ///
    /// # Errors
    /// Why the mesh has to be read as a whole.
    pub(super) fn outline<T>(
        &self,
        path: &Path,
        written: Option<&dyn Format>,
        read: impl FnOnce() -> std::result::Result<T, String>,
        outline: impl Fn(&T) -> &Loaded,
    ) -> std::result::Result<T, String> {
        let found = self.reading(path, || Ok(read()));
        let found = found.map_err(|error| error.to_string())??;
        let takes = |format: &dyn Format| format.takes_cells_apart(&outline(&found).mesh.view());
        match written.is_none_or(takes) {
            true => Ok(found),
            false => Err("its cells, or arrays at them, are not written piece by piece".to_owned()),
        }
    }
}
