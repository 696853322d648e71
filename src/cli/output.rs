//! Common parts of commands that write a mesh: options of the file, and refusal to replace one.

use super::Context;
use azimesh_core::error::Result;
use azimesh_core::{Note, note};
use azimesh_io::formats::{self, Commit, Compression, Encoding, Format, Precision, WriteOptions};
use azimesh_io::mesh::Mesh;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use std::path::Path;

/// Options for writing a mesh.
#[derive(Debug, Clone, clap::Args)]
pub struct OutputArgs {
    /// Encoding of numbers in the file
    #[arg(long, value_parser = one_of(Encoding::ALL), default_value = "raw")]
    pub encoding: Encoding,
    /// Compression of binary data, in formats that have it
    #[arg(long, value_parser = one_of(Compression::ALL), default_value = "none")]
    pub compression: Compression,
    /// Precision of coordinates
    #[arg(long, value_parser = one_of(Precision::ALL), default_value = "f64")]
    pub precision: Precision,
    /// Write names of tags as string arrays (VTK formats); some readers refuse them
    #[arg(long, value_parser = one_of(TAG_NAMES), action = clap::ArgAction::Set, default_value = "yes")]
    pub tag_names: bool,
    /// Replace existing files
    #[arg(long)]
    pub force: bool,
}

/// True if VTK files carry the names of tags.
const TAG_NAMES: [(&str, bool, &str); 2] = [
    ("yes", true, "Names are written"),
    ("none", false, "Numbers only"),
];

/// Creates a parser for these names; the help lists their meanings.
fn one_of<const N: usize, T: Copy + Send + Sync + 'static>(
    all: [(&'static str, T, &'static str); N],
) -> impl TypedValueParser<Value = T> {
    let names = all.map(|(name, _, meaning)| PossibleValue::new(name).help(meaning));
    PossibleValuesParser::new(names).map(move |found| {
        let known = all.iter().find(|(name, _, _)| *name == found);
        known.expect("the parser takes these names alone").1
    })
}

/// The format of an output: of `--format`, or of the name.
pub fn format_of(output: &Path, context: &Context) -> Result<&'static Format> {
    match context.common.one_format()? {
        Some(name) => formats::to_write(formats::by_name(name)?),
        None => formats::by_extension(output),
    }
}

impl OutputArgs {
    /// Returns the options of the writer.
    pub fn options(&self) -> WriteOptions {
        WriteOptions {
            encoding: self.encoding,
            compression: self.compression,
            precision: self.precision,
            tag_names: self.tag_names,
            pieces: None,
        }
    }

    /// Returns a note on each option that has no effect on files of this format.
    pub fn remarks(&self, format: &Format) -> Vec<Note> {
        let dropped = self.options().without_effect(format);
        let name = format.name;
        dropped
            .iter()
            .map(|option| match *option {
                "compression" if self.encoding == Encoding::Ascii => {
                    note!("no_effect", "--compression has no effect on text files")
                }
                option => note!(
                    "no_effect",
                    "--{option} has no effect on files of format {name}"
                ),
            })
            .collect()
    }

    /// Returns the mode of committing the file.
    pub fn commit(&self) -> Commit {
        Commit::with_force(self.force)
    }

    /// Refuses to replace a file without `--force`. Called before any work is done.
    pub fn check(&self, path: &Path) -> Result<()> {
        self.commit().check(path)
    }

    /// Writes the mesh, and its companion files; notes report data that the format cannot hold.
    pub fn save(&self, mesh: &Mesh, path: &Path, format: &Format, context: &Context) -> Result<()> {
        for remark in self.remarks(format) {
            context.note(remark);
        }
        let write = || formats::save(&mesh.view(), path, format, &self.options(), self.commit());
        for dropped in context.stage("writing", write)? {
            context.note(dropped.file(path));
        }
        Ok(())
    }
}
