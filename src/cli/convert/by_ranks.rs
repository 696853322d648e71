//! One mesh that several ranks read and write together.

use super::super::Context;
use super::super::shared::why_not_written;
use super::{Changes, Input, Run};
use azimesh_core::error::Result;
use azimesh_deform::{OwnValues, write_together};
use azimesh_io::formats::{Format, Shared, SharedFile, SharedMesh, by_name};
use azimesh_io::mesh::{ByRanks, Mesh};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A mesh that all ranks convert.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Task {
    file: SharedFile,
    /// The name of the format that is written.
    format: String,
    sync: bool,
}

/// Converts with the first rank the meshes that it says, on another rank.
pub(super) fn follow(context: &Context) {
    while let Some(task) = context.ranks.broadcast::<Option<Task>>(None) {
        if let Ok(format) = by_name(&task.format)
            && let Ok(mesh) = context.read_together(|| Err(String::new()), format)
        {
            // The first rank has the error of any rank.
            let _ = write_together::<()>(own_values(&mesh.part), task.sync, None);
        }
    }
}

/// Ends the work of the other ranks.
pub(super) fn end(context: &Context) {
    if context.ranks.n() > 1 {
        context.ranks.broadcast(Some(None::<Task>));
    }
}

fn own_values(part: &Mesh) -> OwnValues<'_> {
    OwnValues {
        mesh: part,
        points: &part.points,
        velocities: &[],
    }
}

impl Run<'_> {
    /// Writes the mesh of an input by all ranks, each its nodes and cells; returns whether they could. Where not, it says why with
    /// `-v` and writes nothing.
    pub(super) fn by_ranks(
        &self,
        input: &Input,
        path: &Path,
        format: &'static Format,
    ) -> Result<bool> {
        if self.context.ranks.n() == 1 {
            return Ok(false);
        }
        let mesh = match self.read_together(input, path, format) {
            Ok(mesh) => mesh,
            Err(reason) => {
                self.context.tell_why_whole(input.path(), &reason);
                return Ok(false);
            }
        };
        let layout = mesh.layout.expect("this is the first rank");
        self.tell_notes(input, &layout);
        let sync = self.args.write.commit().sync;
        write_together(
            own_values(&mesh.part),
            sync,
            Some(&mut |by| {
                let by = ByRanks {
                    by,
                    displacement: None,
                    velocity: None,
                };
                self.save(&layout.mesh, Some(by), path, format)
            }),
        )?;
        Ok(true)
    }

    fn read_together(
        &self,
        input: &Input,
        path: &Path,
        format: &'static Format,
    ) -> std::result::Result<SharedMesh, String> {
        let args = self.args;
        if args.changes != Changes::default() || args.reorder || args.portable {
            return Err("one rank changes it".to_owned());
        }
        if let Some(reason) = why_not_written(format, &self.options()) {
            return Err(reason.to_owned());
        }
        let is_pipe = path.metadata().is_ok_and(|found| !found.is_file());
        if args.pieces.is_some() || path.as_os_str() == "-" || is_pipe {
            return Err("the output is not one file".to_owned());
        }
        let file: Shared = input.shared(args.step, self.context);
        let task = Task {
            file: file.clone()?,
            format: format.name.to_owned(),
            sync: args.write.commit().sync,
        };
        self.context.ranks.broadcast(Some(Some(task)));
        self.context.read_together(|| file, format)
    }
}
