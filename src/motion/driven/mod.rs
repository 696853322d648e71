//! Motions of a body that come from files, read and held against the mesh and the steps.

mod beam;
mod clock;
mod lifting;
mod sixdof;

pub(super) use beam::{Beam, Sections};
pub(super) use clock::Clock;
pub(super) use lifting::BladeSurface;
pub(super) use sixdof::SixDegrees;

use super::body::Body;
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// The motions of a body that come from files.
#[derive(Debug, Clone, Default)]
pub(super) struct Driven {
    /// `[body.table]`.
    pub table: Option<SixDegrees>,
    /// `[body.beam]`.
    pub beam: Option<Beam>,
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
            let path = beside(schedule, &table.file);
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
            let table = beside(schedule, &beam.table);
            let line = beam.lifting_line.as_ref();
            let line = line.map(|line| beside(schedule, line));
            driven.beam = Some(Beam::read(
                beam,
                (&table, line.as_deref()),
                body,
                clock,
                surface,
            )?);
        }
        Ok(driven)
    }
}

/// The path of a file that the schedule names.
fn beside(schedule: &Path, file: &str) -> PathBuf {
    match schedule.parent() {
        Some(folder) => folder.join(file),
        None => PathBuf::from(file),
    }
}
