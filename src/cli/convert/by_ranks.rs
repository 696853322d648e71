//! One mesh that several ranks read and write together.

use super::super::outline::why_not_written;
use super::{Changes, Input, Run};
use crate::deform::Team;
use crate::error::Result;
use crate::formats::{Format, Loaded};
use std::path::Path;
use std::sync::Arc;

impl Run<'_> {
    /// Writes the mesh of an input by all ranks, each its nodes and cells; tells whether they could. Where not, it says why with `-v`
    /// and writes nothing.
    pub(super) fn by_ranks(
        &self,
        input: &Input,
        path: &Path,
        format: &'static dyn Format,
    ) -> Result<bool> {
        let file = input.shared(self.args.step, self.context);
        let Some(team) = Team::of(&self.context.team, file) else {
            return Ok(false);
        };
        let outline = match self.outline(&team, input, path, format) {
            Ok(outline) => outline,
            Err(reason) => {
                self.context.tell_why_whole(input.path(), &reason);
                return Ok(false);
            }
        };
        self.tell_notes(input, &outline);
        team.set_sync(self.args.write.commit().sync);
        self.save(&outline.mesh, path, format)?;
        team.settle()?;
        Ok(true)
    }

    /// What the first rank knows of the mesh, once each has read its part.
    fn outline(
        &self,
        team: &Arc<Team>,
        input: &Input,
        path: &Path,
        format: &'static dyn Format,
    ) -> std::result::Result<Loaded, String> {
        let args = self.args;
        if args.changes != Changes::default() || args.reorder || args.portable {
            return Err("one rank changes it".to_owned());
        }
        if let Some(reason) = why_not_written(format, &self.options()) {
            return Err(reason.to_owned());
        }
        let is_pipe = path.metadata().is_ok_and(|found| !found.is_file());
        if args.pieces.is_some() || path.as_os_str() == "-" || is_pipe {
            return Err("what is written is not one file".to_owned());
        }
        let read = || team.outline();
        self.context
            .outline(input.path(), Some(format), read, |found| found)
    }
}
