//! OpenFOAM meshes: a case, or the folder `polyMesh` of one.
//!
//! Reads text and binary files, compressed ones, and decomposed cases. Cells are made from their faces. A case is a
//! sequence if several of its times have points. Writes a mesh, or the points of many times, into a case.
//!
//! ```
//! use azimesh_io::formats::{Commit, Location, of, read, save};
//! use azimesh_io::formats::openfoam::OpenFoam;
//! use azimesh_io::{Mesh, ReadOptions, WriteOptions};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let case = folder.path().join("copy");
//!
//! let location = Location::open("testdata/openfoam/ascii".as_ref())?;
//! assert_eq!(of(&location)?.steps(&location)?, [0.0, 0.5, 1.0]);
//! let first = ReadOptions { step: Some(0), ..ReadOptions::default() };
//! let mesh = read(&location, &first)?.mesh;
//!
//! // Patches are tags; types other than `patch` are their conditions. Cell zones are zones.
//! let floor = mesh.tags().find(|tag| tag.name == "floor").expect("a patch");
//! assert_eq!(floor.condition.as_deref(), Some("wall"));
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert_eq!(zones, ["rotor", "stator"]);
//!
//! save(&mesh.view(), &case, &OpenFoam, &WriteOptions::default(), Commit::REPLACE)?;
//! assert!(case.join("constant/polyMesh/points").exists());
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! case         which folders and times a path stands for; folders: what a case has of them
//! file         a file, decompressed, and its header; text: its words; dictionary: text in braces
//! lists, faces points, labels and faces, binary; ascii: as text; zones: named lists
//! read         all of it -> a mesh (`by_faces`: cells from faces)
//! decomposed   the pieces of a case, joined by numbers (addressed) or by the faces that they share (matched)
//! topology     what is left for the writer: the files as they are, and the patches
//!
//! write        a mesh -> the files of a polyMesh; place: where in a case
//! order, orientation  cells -> faces
//! boundary     tags -> patches; kept: zones of faces and points, which a mesh does not hold
//! points       headers and lists, written; pieces: files of each piece of a decomposed case
//! motion       points and displacement of a time; times: names of their folders
//! sequence     a case with many times; beside: what is copied to it
//! ```

mod addressed;
mod ascii;
mod beside;
mod boundary;
mod case;
mod decomposed;
mod dictionary;
mod faces;
mod file;
mod folders;
mod kept;
mod lists;
mod matched;
mod motion;
mod order;
mod orientation;
mod pieces;
mod place;
mod points;
mod read;
mod sequence;
mod text;
mod times;
mod topology;
mod write;
mod zones;

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;

pub use boundary::set_patch_types;

use super::case::CaseFormat;
use super::{
    CreateSequence, Format, Location, Notes, OutputSet, ReadOptions, SharedFolder, StepBytes,
    StepSize, WriteOptions,
};
use crate::mesh::{Mesh, MeshView, Origin};
use azimesh_core::error::Result;
use std::path::Path;

/// The hash of a mesh that was read from a case; `None` of others.
pub fn hash_of_origin(mesh: &Mesh) -> Option<blake3::Hash> {
    let origin = mesh.origin.get::<topology::Topology>();
    origin.map(topology::Topology::content)
}

/// The patch that a cyclic one is the image of, in a mesh that was read from a case.
pub fn neighbour_patch(origin: &Origin, patch: &str) -> Option<String> {
    let origin = origin.get::<topology::Topology>()?;
    let own = origin.patches.iter().find(|own| own.name == patch)?;
    own.entry("neighbourPatch").map(str::to_owned)
}

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

    fn write(&self, mesh: &MeshView, out: &mut OutputSet, options: &WriteOptions) -> Result<Notes> {
        write::write(mesh, out, options)
    }

    fn shared_folder(&self, path: &Path) -> Option<SharedFolder> {
        Some(SharedFolder {
            folder: place::case_of(path),
            own: place::owned_in(&place::case_of(path)),
            mark: place::foam_file(path),
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
