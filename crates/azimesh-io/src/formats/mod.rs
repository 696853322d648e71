//! Mesh files: the list of formats.
//!
//! A format is one file or folder of this module and one line in [`FORMATS`]. Readers see bytes and give positions in
//! errors; [`read`] adds the path. Writers write front to back into any sink.

pub mod abaqus;
mod adf;
mod by_faces;
pub mod cgns;
mod choice;
pub mod column;
mod decompress;
pub mod exodus;
pub mod fluent;
mod format;
pub mod gmsh;
mod grid;
mod growing;
mod hdf5;
mod inputs;
pub mod legacy;
mod listing;
pub mod medit;
mod memory_limit;
mod mesh_file;
mod moves;
mod names;
mod netcdf;
mod notes;
mod number;
pub mod openfoam;
mod options;
mod output_set;
mod pieces;
pub mod plot3d;
mod portable;
pub mod pvtu;
mod records;
mod rounding;
mod save;
mod series;
mod shared_file;
pub mod slabs;
mod source;
mod staged;
pub mod stl;
pub mod su2;
mod tokens;
pub mod ugrid;
pub mod vtk;
pub mod vtkhdf;
pub mod vtu;

pub use choice::{
    by_extension, by_name, case_name, in_pieces, is_only_read, of, recognize, to_write, written,
};
pub use format::{Folder, Format, Holds, OuterFaces};
pub use inputs::{
    Inputs, KeptInputs, files_in, guard_inputs, hash_of, hash_of_input, hash_of_range,
    hash_of_read, note_inputs, opened_inputs, replaced,
};
pub use listing::list_nodes;
use mesh_file::note_steps;
pub use mesh_file::{
    Begin, CreateSequence, Loaded, SequenceFile, parse, read, read_as, save, stage, stage_sequence,
};
pub use notes::Notes;
pub use openfoam::{Begun, CaseFormat, DISPLACEMENT};
pub use options::{Compression, Encoding, Precision, ReadOptions, WriteOptions};
pub use output_set::{Output, OutputSet, SharedFolder};
pub use rounding::is_flattened;
pub use save::{Out, Staged, refuse_special, save_text, stage_bytes};
pub use series::{Listed, check_listed, is_series, pvd, read_series, vtk_series};
pub use shared_file::{Shared, SharedFile, SharedMesh, read_parts, read_together};
pub use source::{
    Location, SHORTER, Source, check_file, check_no_device, read_file, read_input, release_mapped,
    with_mapped_at,
};
pub use staged::{
    Commit, Reserve, clear_left, end_staged, end_staged_soon, folder_of, is_same,
    register_temporary, sync_folder, unregister_temporary,
};

pub use decompress::without_compression;
pub use portable::make_portable;
use std::path::{Path, PathBuf};
pub use su2::{n_zones as n_su2_zones, write_surface as write_su2_surface};

/// Every format, in the order in which files are checked against them.
pub static FORMATS: &[&Format] = &[
    // The first two before the format that takes any XML of VTK.
    &pvtu::PVTU,
    &vtu::VTP,
    &vtu::VTU,
    &vtkhdf::VTKHDF,
    &legacy::VTK51,
    &legacy::VTK42,
    &gmsh::MSH41,
    &gmsh::MSH22,
    &su2::SU2,
    &cgns::CGNS,
    &fluent::FLUENT,
    // Before UGRID, whose counts fit many texts of numbers.
    &plot3d::ANY,
    &plot3d::SINGLE,
    &plot3d::MULTI,
    &plot3d::PLANE,
    &plot3d::SOLID,
    &plot3d::BLANKED,
    &plot3d::PLAIN,
    &plot3d::F32,
    &plot3d::F64,
    &ugrid::TEXT,
    &ugrid::B8,
    &ugrid::LB8,
    &ugrid::B4,
    &ugrid::LB4,
    &ugrid::R8,
    &ugrid::LR8,
    &ugrid::R4,
    &ugrid::LR4,
    &ugrid::B8L,
    &ugrid::LB8L,
    &openfoam::OPENFOAM,
    &exodus::EXODUS,
    &medit::MEDIT,
    &abaqus::ABAQUS,
    &stl::STL,
];

/// The folder of records of a run in a case, where there is one.
pub fn records_in(folder: &Path) -> Option<PathBuf> {
    let records = folder.join(CaseFormat.records());
    records.is_dir().then_some(records)
}

/// The case and the index in it of the step whose file this is, where the file has a part of the mesh only.
pub fn step_in_case(path: &Path) -> Option<(Location, usize)> {
    CaseFormat.step_at(path)
}

/// The word that follows `before` in the first bytes of a text file, up to a blank or a quote.
fn word_after(head: &[u8], before: &[u8]) -> Option<String> {
    let head = &head[..head.len().min(4096)];
    let start = memchr::memmem::find(head, before)? + before.len();
    let rest = head[start..].trim_ascii_start();
    let is_end = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'"';
    let n = rest.iter().position(is_end)?;
    let word = String::from_utf8(rest[..n].to_vec()).ok();
    word.filter(|word| !word.is_empty())
}
