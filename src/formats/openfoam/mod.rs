//! OpenFOAM meshes: a case, or the folder `polyMesh` of one.
//!
//! ```text
//! case         which folders and times a path stands for
//! file         a file, decompressed, and its header; text: its words; dictionary: text in braces
//! lists        points, labels and faces, binary; ascii: as text; zones: named lists of cells
//! cells        which faces each cell has; shapes: the kind of cell that they make
//! read         all of it -> a mesh
//! decomposed   the pieces of a case, joined by numbers (addressed) or by the faces that they share (matched)
//! topology     what is left for the writer: the files as they are, and the patches
//! ```

mod addressed;
mod ascii;
mod case;
mod cells;
mod decomposed;
mod dictionary;
mod file;
mod lists;
mod matched;
mod read;
mod shapes;
mod text;
mod topology;
mod zones;

pub(crate) use dictionary::entry_of;
pub(crate) use topology::{Patch, StoredFile, Topology};

use super::{Format, Location, Notes, ReadOptions};
use crate::error::Result;
use crate::mesh::Mesh;

/// OpenFOAM case (polyMesh).
pub struct OpenFoam;

impl Format for OpenFoam {
    fn name(&self) -> &'static str {
        "openfoam"
    }

    fn title(&self) -> &'static str {
        "OpenFOAM case (polyMesh)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["foam", "openfoam"]
    }

    fn is_folder(&self) -> bool {
        true
    }

    fn recognizes(&self, location: &Location) -> bool {
        case::Case::is_at(location)
    }

    fn lists_faces_again(&self) -> bool {
        false
    }

    fn read(&self, location: &Location, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(location, options, notes)
    }

    fn steps(&self, location: &Location) -> Result<Vec<f64>> {
        let steps = case::Case::at(location)?.steps;
        Ok(steps.iter().map(|step| step.time).collect())
    }
}
