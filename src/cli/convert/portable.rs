//! `--portable`: meshes as the readers of a format take them.

use super::Run;
use crate::formats::{Format, make_portable};
use crate::mesh::Mesh;
use std::borrow::Cow;

impl Run<'_> {
    /// The mesh without what readers of the format do not take, where that is asked for.
    pub(super) fn portable<'m>(&self, mesh: &'m Mesh, format: &dyn Format) -> Cow<'m, Mesh> {
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
