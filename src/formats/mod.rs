//! Mesh files: which formats there are, and reading and writing through one trait.
//!
//! A format is one file or folder here and one line in [`FORMATS`]. A reader sees bytes and gives
//! positions; the path is added at this door. A writer writes to any sink, front to back.

pub mod gmsh;
mod lexer;
mod records;
mod save;
mod source;
pub mod su2;
pub mod vtu;

pub use save::{save, save_text, write_whole};
pub use source::Source;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;
use std::path::Path;

/// Every format, in the order in which their content is tried.
pub static FORMATS: &[&dyn Format] = &[&vtu::Vtu, &gmsh::Msh, &gmsh::Msh22, &su2::Su2];

/// A mesh file format.
pub trait Format: Sync {
    /// Name for `--format` and `output.format`.
    fn name(&self) -> &'static str;
    /// What it is, in a few words.
    fn title(&self) -> &'static str;
    /// Extensions without the dot; the first is the one written.
    fn extensions(&self) -> &'static [&'static str];
    /// Whether a file that starts like this is of this format.
    fn recognizes(&self, head: &[u8]) -> bool;
    /// The mesh in these bytes.
    fn read(&self, bytes: &[u8], options: &ReadOptions) -> Result<Mesh>;
    /// Writes the mesh; returns a sentence for each thing that the format cannot hold.
    fn write(
        &self,
        mesh: &Mesh,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Vec<String>>;
}

/// What a reader is told.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// VTK cell array that holds boundary tags, when it is not one of the known names.
    pub tag_array: Option<String>,
}

/// What a writer is told.
#[derive(Debug, Clone)]
pub struct WriteOptions {
    /// How numbers are stored.
    pub encoding: Encoding,
    /// Compression of binary data, in formats that have it.
    pub compression: Compression,
    /// Precision of coordinates.
    pub precision: Precision,
    /// Whether names of tags are written as string arrays (VTU); some readers refuse them.
    pub tag_names: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            encoding: Encoding::Raw,
            compression: Compression::None,
            precision: Precision::F64,
            tag_names: true,
        }
    }
}

/// How numbers are stored in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Encoding {
    /// Binary, as in memory.
    Raw,
    /// Binary in base64 (VTU).
    Base64,
    /// Text.
    Ascii,
}

/// Compression of binary data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Compression {
    /// None.
    None,
    /// zlib.
    Zlib,
    /// LZ4 blocks.
    Lz4,
    /// LZMA in xz containers.
    Lzma,
}

/// Precision of coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Precision {
    /// 64 bits.
    F64,
    /// 32 bits.
    F32,
}

/// The format with this name.
pub fn by_name(name: &str) -> Result<&'static dyn Format> {
    let names = || FORMATS.iter().map(|format| format.name());
    FORMATS
        .iter()
        .copied()
        .find(|format| format.name() == name)
        .ok_or_else(|| {
            let known = names().collect::<Vec<_>>().join(", ");
            Error::input(format!(
                "format \"{name}\" is not known; there are: {known}"
            ))
        })
}

/// The format that the file name says, for writing.
pub fn by_extension(path: &Path) -> Result<&'static dyn Format> {
    with_extension(path).ok_or_else(|| {
        let known = FORMATS
            .iter()
            .map(|format| format!(".{}", format.extensions()[0]))
            .collect::<Vec<_>>();
        let known = known.join(", ");
        Error::input(format!(
            "the name does not say the format; known endings: {known}"
        ))
        .file(path)
    })
}

fn with_extension(path: &Path) -> Option<&'static dyn Format> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let has = |format: &&dyn Format| format.extensions().contains(&extension.as_str());
    FORMATS.iter().copied().find(has)
}

/// Reads the mesh in a file, by its content or, where that does not tell, by its name.
pub fn read(source: &Source, options: &ReadOptions) -> Result<Mesh> {
    let format = FORMATS
        .iter()
        .copied()
        .find(|format| format.recognizes(source.bytes()))
        .or_else(|| with_extension(source.path()))
        .ok_or_else(|| unknown_content(source))?;
    read_as(format, source, options)
}

/// Reads the mesh in a file of a known format.
pub fn read_as(format: &dyn Format, source: &Source, options: &ReadOptions) -> Result<Mesh> {
    if source.bytes().is_empty() {
        return Err(Error::input("the file is empty; it should hold a mesh").file(source.path()));
    }
    let mesh = format
        .read(source.bytes(), options)
        .and_then(|mut mesh| {
            mesh.validate()?;
            mesh.merge_repeated_faces();
            Ok(mesh)
        })
        .map_err(|error| error.file(source.path()))?;
    Ok(mesh)
}

fn unknown_content(source: &Source) -> Error {
    let titles = FORMATS
        .iter()
        .map(|format| format.title())
        .collect::<Vec<_>>()
        .join(", ");
    let found = match source.bytes() {
        [] => "the file is empty".to_owned(),
        bytes => {
            let head: Vec<u8> = bytes.iter().copied().take(24).collect();
            format!("it starts with \"{}\"", head.escape_ascii())
        }
    };
    Error::input(format!("no known mesh format ({found}); known: {titles}")).file(source.path())
}
