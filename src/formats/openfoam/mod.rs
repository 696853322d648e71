//! OpenFOAM meshes: a case, or the folder `polyMesh` of one.
//!
//! ```text
//! case         which folders and times a path stands for
//! file         the header of a file, and its bytes
//! dictionary   text in braces: the header, the patches, the zones
//! lists        points, labels and faces: text or binary
//! topology     faces, owner, neighbour and patches of a mesh, and its files as they are
//! shapes       faces -> cells
//! read         all of it -> a mesh
//!
//! write        a mesh -> the files of a polyMesh
//! order, orientation  cells -> faces
//! boundary     tags -> patches
//! points       headers and lists, written
//! motion       points and displacement of a time; times: names of their folders
//! sequence     a case with many times; beside: what is copied to it
//! ```

mod beside;
mod boundary;
mod motion;
mod order;
mod orientation;
mod points;
mod sequence;
mod times;
mod topology;
mod write;

pub use boundary::{GIVEN, set_patch_types};
pub(crate) use topology::{Patch, StoredFile, Topology};

use super::case::CaseFormat;
use super::{
    CreateSequence, Format, Location, Notes, OutputSet, ReadOptions, SharedFolder, StepBytes, StepSize,
    WriteOptions,
};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, MeshView};
use std::path::Path;

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

    fn recognizes(&self, _location: &Location) -> bool {
        false
    }

    fn read(&self, _: &Location, _: &ReadOptions, _: &mut Notes) -> Result<Mesh> {
        Err(Error::input("OpenFOAM meshes are not read yet"))
    }

    fn write(&self, mesh: &MeshView, out: &mut OutputSet, options: &WriteOptions) -> Result<Notes> {
        write::write(mesh, out, options)
    }

    fn shared_folder(&self, path: &Path) -> Option<SharedFolder> {
        Some(SharedFolder {
            folder: write::case_of(path),
            own: "constant/polyMesh",
            mark: write::foam_file(path),
        })
    }

    fn sequence(&self) -> Option<CreateSequence> {
        use sequence::Sequence;
        Some(|path, options, begin, _| Ok(Box::new(Sequence::create(path, options, begin)?)))
    }

    fn sequence_bytes(&self, step: &StepSize) -> StepBytes {
        sequence::step_bytes(step)
    }

    fn case(&self) -> Option<&'static dyn CaseFormat> {
        Some(&OpenFoam)
    }

    fn holds_displacement(&self) -> bool {
        true
    }
}
