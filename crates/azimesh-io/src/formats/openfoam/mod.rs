//! OpenFOAM meshes: a case, or the folder `polyMesh` of one.
//!
//! Reads text and binary files, compressed ones, and decomposed cases. Cells are made from their faces. A case is a
//! sequence if several of its times have points. Writes a mesh, or the points of many times, into a case.
//!
//! ```
//! use azimesh_io::formats::{Commit, Location, of, read, save};
//! use azimesh_io::formats::openfoam::OPENFOAM;
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
//! save(&mesh.view(), &case, &OPENFOAM, &WriteOptions::default(), Commit::REPLACE)?;
//! assert!(case.join("constant/polyMesh/points").exists());
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! case       paths of a case: its times, regions and folders of pieces, and the mesh that a path names
//! text       words and values of one file; file: its header and blocks; lists: labels, points and faces, text or binary
//! read       the files of a step -> lists -> a mesh, its cells by `by_faces`; decomposed: lists of pieces -> one of the whole
//! topology   files and patches that a mesh keeps of its case, for the writer
//! write      a mesh -> the files of a case: as they were read, or from cells (faces), tags (boundary) and zones (zones)
//! output     the header and the lists of a written file, in the case or in each of its pieces
//! sequence   points of many times in one case (times), with copies of `system`, `0` and `constant` (copy)
//! ```

mod boundary;
mod case;
mod copy;
mod decomposed;
mod faces;
mod file;
mod lists;
mod output;
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
pub(super) use case::files_of_case;
pub use sequence::{Begun, CaseFormat, DISPLACEMENT};

use super::{Folder, Format, Holds, SharedFolder};
use crate::mesh::{Mesh, Origin};
use std::path::PathBuf;

/// The hash of a mesh that was read from a case; `None` of others.
pub fn hash_of_origin(mesh: &Mesh) -> Option<blake3::Hash> {
    let origin = mesh.origin.get::<topology::Topology>();
    origin.map(|origin| origin.content)
}

/// All files of the case that a mesh was read from, at every time; none of others.
pub fn files_of_origin(mesh: &Mesh) -> Vec<PathBuf> {
    let origin = mesh.origin.get::<topology::Topology>();
    origin.map_or(Vec::new(), |origin| origin.path.files())
}

/// The patch that a cyclic one is the image of, in a mesh that was read from a case.
pub fn neighbour_patch(origin: &Origin, patch: &str) -> Option<String> {
    let origin = origin.get::<topology::Topology>()?;
    let own = origin.patches.iter().find(|own| own.name == patch)?;
    own.entry("neighbourPatch").map(str::to_owned)
}

/// OpenFOAM case (polyMesh).
pub static OPENFOAM: Format = Format {
    name: "openfoam",
    title: "OpenFOAM case (polyMesh)",
    extensions: &["foam", "openfoam"],
    holds: Holds {
        displacement: true,
        ..Holds::NOTHING
    },
    lists_faces_again: false,
    folder: Some(Folder {
        detect: |location| case::CasePath::of(location).is_some(),
        read: read::read,
        steps: |location| {
            let steps = case::Case::at(location)?.steps;
            Ok(steps.iter().map(|step| step.time).collect())
        },
        shared: |path| {
            let folder = case::case_of(path);
            SharedFolder {
                own: case::CasePath::new(&*folder).owned(),
                mark: case::mark_of(path),
                folder,
            }
        },
    }),
    write_files: Some(write::write),
    sequence: Some(|path, options, begin, _| {
        Ok(Box::new(sequence::Sequence::create(path, options, begin)?))
    }),
    case: Some(CaseFormat),
    ..Format::NEW
};
