//! The source of a mesh, from which a writer of the same format keeps data that a mesh does not hold.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// Data that the reader of a format leaves for its writer, such as the files of an OpenFOAM mesh. Copies share it.
///
/// Meshes that differ in it alone are equal. It may outlive the cells and groups that it was read with, so a writer compares
/// it with the mesh that it writes.
#[derive(Clone, Default)]
pub struct Origin(Option<Arc<dyn Any + Send + Sync>>);

impl Origin {
    /// Stores the data of a reader.
    pub fn new(left: impl Any + Send + Sync) -> Self {
        Self(Some(Arc::new(left)))
    }

    /// Returns the data if it has this type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.as_ref()?.downcast_ref()
    }
}

impl PartialEq for Origin {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Origin" } else { "None" })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::*;

    #[test]
    fn it_is_given_back_by_type_and_is_no_part_of_the_mesh() {
        let mesh = Mesh {
            origin: Origin::new("faces"),
            ..Mesh::default()
        };
        assert_eq!(mesh.clone().origin.get::<&str>(), Some(&"faces"));
        assert_eq!(mesh.origin.get::<String>(), None);
        assert_eq!(mesh.view().origin.get::<&str>(), Some(&"faces"));
        assert_eq!(mesh, Mesh::default());
    }
}
