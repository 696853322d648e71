//! Motions of a body that come from files, read and held against the mesh and the steps.

mod beam;
mod clock;
mod displaced;
mod lifting;
mod nodes;
mod sets;
mod shapes;
mod sixdof;

pub use beam::CentreLine;
pub(super) use beam::{Beam, Sections};
pub(super) use clock::Clock;
pub(super) use lifting::BladeSurface;
pub(super) use nodes::BodyNodes;
pub(super) use sets::SurfaceSets;
pub(super) use shapes::ModeShapes;
pub(super) use sixdof::SixDegrees;

use super::body::Body;
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The motions of a body that come from files.
#[derive(Debug, Clone, Default)]
pub(super) struct Driven {
    /// `[body.table]`.
    pub table: Option<SixDegrees>,
    /// `[body.beam]`.
    pub beam: Option<Beam>,
    /// `[body.surface]`.
    pub surface: Option<SurfaceSets>,
    /// `[body.modes]`.
    pub modes: Option<ModeShapes>,
    /// The nodes that both of these are for.
    pub nodes: Option<Arc<BodyNodes>>,
}

impl Driven {
    /// Reads the files of a body, which are relative to the schedule.
    pub fn read(
        body: &Body,
        schedule: &Path,
        clock: &Clock<'_>,
        in_plane: bool,
        surface: &BladeSurface<'_>,
    ) -> Result<Self> {
        let mut driven = Self::default();
        if let Some(table) = &body.table {
            let path = beside(schedule, &table.file, table.line)?;
            driven.table = Some(SixDegrees::read(table, &path, body, clock, in_plane)?);
        }
        if let Some(beam) = &body.beam {
            if in_plane {
                let message = format!(
                    "body \"{}\" is a beam, which needs a 3D mesh; in 2D a table or modes bend it",
                    body.name
                );
                return Err(Error::input(message).line(beam.line));
            }
            let table = beside(schedule, &beam.table, beam.line)?;
            let line = beam.lifting_line.as_ref();
            let line = line.map(|line| {
                let path = beside(schedule, line, beam.line);
                path.map_err(|error| Error {
                    message: format!(
                        "{}; `lifting_line` is \"quarter_chord\" or a table  station,x,y,z",
                        error.message
                    ),
                    ..error
                })
            });
            let line = line.transpose()?;
            driven.beam = Some(Beam::read(
                beam,
                (&table, line.as_deref()),
                body,
                clock,
                surface,
            )?);
        }
        driven.read_displacements(body, schedule, (clock, in_plane), surface)?;
        Ok(driven)
    }

    fn read_displacements(
        &mut self,
        body: &Body,
        schedule: &Path,
        clock: (&Clock<'_>, bool),
        surface: &BladeSurface<'_>,
    ) -> Result<()> {
        if body.surface.is_none() && body.modes.is_none() {
            return Ok(());
        }
        let nodes = Arc::new(surface.nodes());
        if let Some(motion) = &body.surface {
            let path = beside(schedule, &motion.file, motion.line)?;
            self.surface = Some(SurfaceSets::read(motion, &path, body, &nodes, clock)?);
        }
        if let Some(motion) = &body.modes {
            let shapes = beside(schedule, &motion.shapes, motion.line)?;
            let coordinates = beside(schedule, &motion.coordinates, motion.line)?;
            let paths = (shapes.as_path(), coordinates.as_path());
            self.modes = Some(ModeShapes::read(motion, paths, body, &nodes, clock)?);
        }
        self.nodes = Some(nodes);
        Ok(())
    }

    /// Whether nodes have displacements of their own.
    pub fn has_displacements(&self) -> bool {
        self.nodes.is_some()
    }

    /// What is likely to be wrong in the files, as sentences.
    pub fn warnings(&self) -> impl Iterator<Item = &String> {
        self.beam.iter().flat_map(|beam| &beam.warning)
    }

    /// What the user should know of the files, as sentences.
    pub fn notes(&self) -> impl Iterator<Item = &String> {
        let beam = self.beam.iter().flat_map(|beam| &beam.notes);
        let surface = self.surface.iter().flat_map(|surface| &surface.notes);
        let modes = self.modes.iter().flat_map(|modes| &modes.notes);
        beam.chain(surface).chain(modes)
    }
}

/// The path of a file that the schedule names near a line; an error of that line where there is none.
fn beside(schedule: &Path, file: &str, line: u64) -> Result<PathBuf> {
    let path = schedule.with_file_name("").join(file);
    match path.metadata() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let message = format!("there is no file {}", path.display());
            Err(Error::input(message).line(line))
        }
        Ok(found) if found.is_dir() => {
            let message = format!("{} is a folder; a file belongs here", path.display());
            Err(Error::input(message).line(line))
        }
        _ => Ok(path),
    }
}
