//! Meshes as a format takes them: `--portable`, and the surface for formats that hold no more.

use super::Run;
use crate::formats::{Format, make_portable};
use crate::mesh::Mesh;
use std::borrow::Cow;

impl Run<'_> {
    /// The mesh without what readers of the format do not take, where that is asked for; its surface for a format of surfaces.
    pub(super) fn portable<'m>(&self, mesh: &'m Mesh, format: &dyn Format) -> Cow<'m, Mesh> {
        if let Some((surface, notes)) = format.surface(&mesh.view()) {
            for note in notes.iter() {
                self.tell(format!("{}: {note}", format.title()));
            }
            return Cow::Owned(surface);
        }
        if !self.args.portable {
            return Cow::Borrowed(mesh);
        }
        let mut portable = mesh.clone();
        match make_portable(&mut portable, format.name()) {
            Some(remark) => {
                self.tell(remark);
                Cow::Owned(portable)
            }
            None => Cow::Borrowed(mesh),
        }
    }
}
