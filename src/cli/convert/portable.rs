//! Meshes as a format takes them: `--portable`, and the surface for formats that hold no more.

use super::Run;
use azimesh_core::diagnostic::NoteKind;
use azimesh_core::diagnostic::formats::{FormatNote, GroupWritten, Written};
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::{Format, Notes, OuterFaces, make_portable};
use azimesh_io::mesh::Mesh;
use std::borrow::Cow;

impl Run<'_> {
    /// Where some of the notes are on outer faces without a tag, says that zones which share no nodes have left them.
    pub(super) fn tell_of_zones_apart(&self, mesh: &Mesh, notes: &Notes) {
        if !notes.iter().any(|note| is_on_bare_faces(&note.kind)) {
            return;
        }
        let n = mesh.n_joinable_faces();
        if n > 0 {
            self.tell(format!(
                "of the outer faces without a tag, {} lie on one another: they are interfaces of zones that share no nodes \
                 (`repeated` in azimesh info); --join makes these one mesh",
                2 * n
            ));
        }
    }

    /// The mesh without what readers of the format do not take, where that is asked for; its surface for a format of surfaces,
    /// without the faces of tags that were removed.
    pub(super) fn portable<'m>(&self, mesh: &'m Mesh, format: &Format) -> Result<Cow<'m, Mesh>> {
        let outer = match self.args.changes.removes_tags() {
            true => OuterFaces::Listed,
            false => OuterFaces::All,
        };
        if let Some(surface_of) = format.surface {
            let (surface, notes) = surface_of(&mesh.view(), outer);
            if surface.cells.is_empty() {
                return Err(Error::input(
                    "no boundary face is left after --keep-tag or --drop-tag",
                ));
            }
            for note in notes.iter() {
                self.tell(format!("{}: {note}", format.title));
            }
            self.tell_of_zones_apart(mesh, &notes);
            return Ok(Cow::Owned(surface));
        }
        if !self.args.portable {
            return Ok(Cow::Borrowed(mesh));
        }
        let mut portable = mesh.clone();
        Ok(match make_portable(&mut portable, format.name) {
            Some(remark) => {
                self.tell(remark);
                Cow::Owned(portable)
            }
            None => Cow::Borrowed(mesh),
        })
    }
}

fn is_on_bare_faces(kind: &NoteKind) -> bool {
    let NoteKind::Format(note) = kind else {
        return false;
    };
    matches!(
        note,
        FormatNote::Written(Written::BareFaces { .. })
            | FormatNote::GroupWritten(GroupWritten::UntaggedPatch { .. })
    )
}
