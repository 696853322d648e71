//! Mesh files: the list of formats, and the trait through which they are read and written.
//!
//! A format is one file or folder of this module and one line in [`FORMATS`]. Readers see bytes and give positions in
//! errors; [`read`] adds the path. Writers write front to back into any sink.

mod adf;
mod by_faces;
mod case;
pub mod cgns;
mod choice;
mod conditions;
mod decompress;
mod dialect;
pub mod exodus;
mod exterior;
pub mod fluent;
mod foreign;
pub mod gmsh;
mod grid;
mod growing;
mod hash;
mod hdf5;
mod inputs;
pub mod legacy;
mod lexer;
mod listing;
mod location;
mod memory_limit;
mod mesh_file;
mod names;
mod netcdf;
mod notes;
mod opened;
pub mod openfoam;
mod options;
mod out;
mod output_set;
pub mod plot3d;
mod portable;
pub mod pvtu;
mod records;
mod reserve;
mod rounding;
mod save;
mod sequence;
mod series;
mod shared_file;
mod sink;
pub mod slabs;
mod source;
mod staged;
mod staged_folder;
pub mod stl;
pub mod su2;
mod surface;
#[cfg(test)]
mod toy;
pub mod ugrid;
pub mod vtk;
pub mod vtkhdf;
pub mod vtu;

pub use case::{Begun, CaseFormat, DISPLACEMENT};
use choice::read_only;
pub use choice::{
    by_extension, by_name, case_name, in_pieces, is_only_read, of, recognize, to_write,
};
pub use hash::{hash_of, hash_of_input, hash_of_mesh_file, hash_of_range};
pub use inputs::{Inputs, guard_inputs, note_inputs, replaced};
pub use listing::list_nodes;
pub use location::Location;
pub use mesh_file::{save, stage, stage_sequence};
pub use notes::Notes;
pub use opened::{KeptInputs, hash_of_read};
pub use options::{Compression, Encoding, Precision, ReadOptions, WriteOptions};
pub use out::Out;
pub use output_set::{Output, OutputSet};
pub use reserve::Reserve;
pub use rounding::is_flattened;
pub use save::{Staged, save_text, stage_bytes};
pub use sequence::{Begin, CreateSequence, SequenceFile, StepBytes, StepSize};
pub use series::{Listed, check_listed, is_series, pvd, read_series, vtk_series};
pub use shared_file::{Shared, SharedFile, SharedMesh, read_parts, read_together};
pub use sink::refuse_special;
pub use source::{
    SHORTER, Source, check_file, check_no_device, read_file, read_input, release_mapped,
    with_mapped_at,
};
pub use staged::{
    Commit, clear_left, end_staged, end_staged_soon, folder_of, is_same, register_temporary,
    sync_folder, unregister_temporary,
};
pub use staged_folder::SharedFolder;
pub use surface::OuterFaces;

use crate::mesh::{Mesh, MeshView};
use azimesh_core::diagnostic::formats::{Read, Written};
use azimesh_core::error::{Error, Result};
pub use decompress::without_compression;
pub use portable::make_portable;
use std::path::{Path, PathBuf};
pub use su2::{n_zones as n_su2_zones, write_surface as write_su2_surface};

/// Every format, in the order in which files are checked against them.
pub static FORMATS: &[&dyn Format] = &[
    // The first two before the format that takes any XML of VTK.
    &pvtu::Pvtu,
    &vtu::Vtp,
    &vtu::Vtu,
    &vtkhdf::VtkHdf,
    &legacy::VTK51,
    &gmsh::MSH41,
    &su2::Su2,
    &cgns::Cgns,
    &fluent::Fluent,
    // Before UGRID, whose counts fit many texts of numbers.
    &plot3d::ANY,
    &ugrid::TEXT,
    &openfoam::OpenFoam,
    &exodus::Exodus,
    &stl::Stl,
    #[cfg(test)]
    &toy::Toy,
];

/// Every format and, after each, its flavours.
pub fn with_flavours() -> impl DoubleEndedIterator<Item = &'static dyn Format> + Clone {
    let flavours = |format: &&'static dyn Format| {
        let further = format.flavours().iter().copied();
        std::iter::once(*format).chain(further)
    };
    FORMATS.iter().flat_map(flavours)
}

/// Those of [`with_flavours`] that are written.
pub fn written() -> impl DoubleEndedIterator<Item = &'static dyn Format> + Clone {
    with_flavours().filter(|format| format.is_written())
}

/// A mesh file format.
pub trait Format: Sync {
    /// Name for `--format` and `output.format`.
    fn name(&self) -> &'static str;
    /// The format in a few words.
    fn title(&self) -> &'static str;
    /// File name extensions without the first dot; new files get the first one. Of several formats, the one with the
    /// longest matching extension is taken.
    fn extensions(&self) -> &'static [&'static str];
    /// Variants of the format, each with its name and extensions.
    fn flavours(&self) -> &'static [&'static dyn Format] {
        &[]
    }
    /// Whether meshes are written; else they are read only.
    fn is_written(&self) -> bool {
        true
    }
    /// Whether a mesh, or a sequence, is a folder.
    fn is_folder(&self) -> bool {
        false
    }
    /// Whether it holds surfaces alone.
    fn is_surface(&self) -> bool {
        false
    }
    /// The surface that a format of surfaces holds of a mesh, as it will be written, and notes on the rest.
    fn surface(&self, _mesh: &MeshView, _outer: OuterFaces) -> Option<(Mesh, Notes)> {
        None
    }
    /// The folder that a mesh written to `path` shares with files that are not of the mesh.
    fn shared_folder(&self, _path: &Path) -> Option<SharedFolder> {
        None
    }
    /// Whether the file or folder is of this format.
    fn recognizes(&self, location: &Location) -> bool {
        location.file().is_ok_and(|file| self.recognizes_file(file))
    }
    /// Whether a file with these first bytes is of this format.
    fn recognizes_start(&self, _head: &[u8]) -> bool {
        false
    }
    /// Whether a file is of this format, where its first bytes alone do not tell.
    fn recognizes_file(&self, source: &Source) -> bool {
        self.recognizes_start(source.bytes())
    }
    /// The title of a file with these first bytes.
    fn title_of(&self, _head: &[u8]) -> String {
        self.title().to_owned()
    }
    /// The version of the format that these first bytes of a file give.
    fn version(&self, _head: &[u8]) -> Option<String> {
        None
    }
    /// Reads a mesh; adds a note for each kind of data that it cannot hold.
    fn read(&self, location: &Location, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        self.read_file(location.file()?, options, notes)
    }
    /// Reads a mesh from a file, for formats of one file.
    fn read_file(&self, source: &Source, _: &ReadOptions, _: &mut Notes) -> Result<Mesh> {
        Err(
            Error::input(format!("{} is not read from a single file", self.title()))
                .file(source.path()),
        )
    }
    /// Opens a file by slabs, where its mesh can be read so.
    ///
    /// # Errors
    /// Those of [`read`](Self::read), as far as they are found here.
    fn slabs<'a>(&self, _: &'a Source, _: &ReadOptions) -> Result<slabs::Opened<'a>> {
        Ok(Err(format!("{} is not read by slabs", self.title())))
    }
    /// Whether a boundary face in several tags is listed once for each; else faces at one place are several faces.
    fn lists_faces_again(&self) -> bool {
        true
    }
    /// Times of the steps of a sequence in one file or folder; empty where it holds one mesh.
    fn steps(&self, location: &Location) -> Result<Vec<f64>> {
        location
            .file()
            .map_or(Ok(Vec::new()), |file| self.steps_of_file(file))
    }
    /// Times of the steps of a sequence in a file, for formats of one file.
    fn steps_of_file(&self, _source: &Source) -> Result<Vec<f64>> {
        Ok(Vec::new())
    }
    /// Writes the mesh; returns a note for each thing that the format cannot hold.
    fn write(&self, mesh: &MeshView, out: &mut OutputSet, options: &WriteOptions) -> Result<Notes> {
        let companions = self.companion_files(mesh, out.path());
        if !companions.is_empty() && out.path().as_os_str() == "-" {
            return Err(Error::input(format!(
                "{} has a second file, for names and conditions of tags; standard output can hold only one, so write to a file",
                self.name()
            )));
        }
        let is_stream = out.is_stream();
        for (path, content) in companions.iter().filter(|_| !is_stream) {
            out.companion(path, content)?;
        }
        let mut notes = out.main(|out| self.write_file(mesh, out, options))?;
        notes.extend(portable::not_taken(mesh, self.name()));
        if is_stream && !companions.is_empty() {
            notes.push(Written::CompanionLeftOut);
        }
        Ok(notes)
    }
    /// Writes the mesh front to back, for formats of one file.
    fn write_file(&self, _: &MeshView, _: &mut dyn Out, _: &WriteOptions) -> Result<Notes> {
        Err(match self.is_written() {
            true => Error::input(format!("{} is not written as a single file", self.title())),
            false => read_only(self.title()),
        })
    }
    /// Whether ranks that have coordinates can write them into the file.
    fn takes_numbers_apart(&self, _: &WriteOptions) -> bool {
        false
    }
    /// Whether ranks that have the cells of this mesh can write their nodes into such a file too: cells are there in their order, or
    /// in that of their kinds, each once. Asks for nothing but the kinds of cells, the groups and where boundary faces are at rest.
    fn takes_cells_apart(&self, _: &MeshView) -> bool {
        false
    }
    /// Small files that belong next to a mesh written to `path`, with their content, which does not depend on the
    /// positions of the nodes.
    fn companion_files(&self, _mesh: &MeshView, _path: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        Vec::new()
    }
    /// Whether arrays at nodes and cells are written.
    fn holds_arrays(&self) -> bool {
        false
    }
    /// Whether the displacement of the nodes is written where it is asked for.
    fn holds_displacement(&self) -> bool {
        self.holds_arrays()
    }
    /// Encodings of numbers that can be chosen for written files.
    fn encodings(&self) -> &'static [Encoding] {
        &[Encoding::Raw, Encoding::Ascii]
    }
    /// Whether binary data can be compressed.
    fn compresses(&self) -> bool {
        false
    }
    /// Whether names of tags are arrays apart from the tags, which can be left out.
    fn has_tag_names(&self) -> bool {
        false
    }
    /// Whether a mesh is written in pieces ([`WriteOptions::pieces`]).
    fn is_in_pieces(&self) -> bool {
        false
    }
    /// Whether coordinates are written in 32 bits for the precision that is `asked` for. The formats of VTK and
    /// CGNS, which hold arrays too, have both.
    fn rounds(&self, asked: Precision) -> bool {
        asked == Precision::F32 && self.holds_arrays()
    }
    /// Extension of a list of the files of a sequence that programs read besides the `.pvd`.
    fn list_ending(&self) -> Option<&'static str> {
        None
    }
    /// Opens a file for a whole sequence, where the format has that.
    fn sequence(&self) -> Option<CreateSequence> {
        None
    }
    /// The way in which a run writes its steps, where they lie in a folder that holds more than meshes.
    fn case(&self) -> Option<&'static dyn CaseFormat> {
        None
    }
    /// Bytes that each mesh but the first adds to the file of a sequence.
    fn sequence_bytes(&self, _step: &StepSize) -> StepBytes {
        StepBytes::default()
    }
}

/// The folder of records of a run in a case, where there is one.
pub fn records_in(folder: &Path) -> Option<PathBuf> {
    let mut cases = FORMATS.iter().filter_map(|format| format.case());
    cases.find_map(|case| {
        let records = folder.join(case.records());
        records.is_dir().then_some(records)
    })
}

/// The case and the index in it of the step whose file this is, where the file has a part of the mesh only.
pub fn step_in_case(path: &Path) -> Option<(Location, usize)> {
    let mut cases = FORMATS.iter().filter_map(|format| format.case());
    cases.find_map(|case| case.step_at(path))
}

/// A mesh that was read, with its format and notes. See [`Mesh::read_with`].
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// Notes on what the mesh does not hold of the file.
    pub notes: Notes,
    /// The file's format.
    pub format: &'static dyn Format,
}

/// Reads a mesh in the format of its content or, where that does not tell, of its name.
pub fn read(location: &Location, options: &ReadOptions) -> Result<Loaded> {
    read_as(of(location)?, location, options)
}

/// Reads a mesh of a known format.
pub fn read_as(
    format: &'static dyn Format,
    location: &Location,
    options: &ReadOptions,
) -> Result<Loaded> {
    let is_empty = |file: &Source| file.bytes().is_empty();
    if location.file().is_ok_and(is_empty) && !format.recognizes(location) {
        return Err(Error::input("the file is empty; it should hold a mesh").file(location.path()));
    }
    let mut notes = Notes::default();
    if let Ok(file) = location.file() {
        if let Some(refusal) = foreign::refusal(file).filter(|_| !format.recognizes(location)) {
            return Err(refusal);
        }
        if file.n_padding() > 0 {
            notes.push(Read::ZeroPadding {
                n: file.n_padding(),
            });
        }
    }
    note_steps(format, location, options, &mut notes);
    let read = format.read(location, options, &mut notes);
    if let Ok(file) = location.file() {
        file.check_whole()?;
    }
    let mesh = read
        .and_then(|mut mesh| {
            mesh.validate()?;
            if format.lists_faces_again() {
                mesh.merge_repeated_faces();
            }
            names::check(&mut mesh, &mut notes);
            Ok(mesh)
        })
        .map_err(|error| error.file(location.path()))?;
    notes.close();
    Ok(Loaded {
        mesh,
        notes,
        format,
    })
}

/// Notes which step of a sequence is read where none is asked for. What is wrong with the file its reader tells.
fn note_steps(format: &dyn Format, location: &Location, options: &ReadOptions, notes: &mut Notes) {
    if options.step.is_some() {
        return;
    }
    let steps = format.steps(location).unwrap_or_default();
    if let [.., _, last] = steps[..] {
        let n = steps.len();
        notes.push(Read::LastOfSteps { n, last });
    }
}

/// The mesh in bytes of a known format, as the format gives it, without the checks of [`read`].
pub fn parse(format: &dyn Format, bytes: &[u8], options: &ReadOptions) -> Result<Mesh> {
    let source = Source::from_bytes(Path::new("<memory>"), bytes.to_vec());
    format.read_file(&source, options, &mut Notes::default())
}

/// The word that follows `before` in the first bytes of a text file, up to a blank or a quote.
fn word_after(head: &[u8], before: &[u8]) -> Option<String> {
    let head = &head[..head.len().min(4096)];
    let start = memchr::memmem::find(head, before)? + before.len();
    let rest = head[start..].trim_ascii_start();
    let n = rest
        .iter()
        .position(|byte| byte.is_ascii_whitespace() || *byte == b'"')?;
    let word = String::from_utf8(rest[..n].to_vec()).ok()?;
    (!word.is_empty()).then_some(word)
}
