//! A mesh file format, as a record.

use super::choice::read_only;
use super::portable::not_taken;
use super::slabs::Opened;
use super::{
    CaseFormat, CreateSequence, Encoding, Location, Notes, Out, OutputSet, Precision, ReadOptions,
    SharedFolder, Source, WriteOptions,
};
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::note;
use std::path::{Path, PathBuf};

/// A mesh file format: constants, and functions that read and write it. Written as
/// `Format { name: .., ..Format::NEW }`.
pub struct Format {
    /// Name for `--format` and `output.format`.
    pub name: &'static str,
    /// The format in a few words.
    pub title: &'static str,
    /// File name extensions without the first dot; new files get the first one. Of several formats, the one with the
    /// longest matching extension is taken.
    pub extensions: &'static [&'static str],
    /// Contents that are written.
    pub holds: Holds,
    /// True if it holds surfaces alone.
    pub is_surface: bool,
    /// True if a mesh is written in pieces ([`WriteOptions::pieces`]).
    pub is_in_pieces: bool,
    /// True if a boundary face in several tags is listed once for each; else faces at one place are several faces.
    pub lists_faces_again: bool,
    /// Encodings of numbers that can be chosen for written files.
    pub encodings: &'static [Encoding],
    /// Precisions that coordinates are written in.
    pub precisions: &'static [Precision],
    /// True if binary data can be compressed.
    pub compresses: bool,
    /// Extension of a list of the files of a sequence that programs read besides the `.pvd`.
    pub list_ending: Option<&'static str>,

    /// Recognizes a file by its content.
    pub detect: fn(&Source) -> bool,
    /// The title of a file with these first bytes, where it differs.
    pub title_of: Option<fn(&[u8]) -> String>,
    /// The version of the format that these first bytes of a file give.
    pub version: fn(&[u8]) -> Option<String>,
    /// Reads a mesh from a file; adds a note for each kind of data that it cannot hold.
    pub read: fn(&Source, &ReadOptions, &mut Notes) -> Result<Mesh>,
    /// Times of the steps of a sequence in a file; empty where it holds one mesh.
    pub steps: fn(&Source) -> Result<Vec<f64>>,
    /// Opens a file by slabs, where its mesh can be read so.
    pub slabs: Option<for<'a> fn(&'a Source, &ReadOptions) -> Result<Opened<'a>>>,
    /// Reads and recognizes folders, for a format whose meshes are folders.
    pub folder: Option<Folder>,

    /// Writes a mesh front to back; gives a note for each thing that the format cannot hold.
    pub write: Option<WriteFile>,
    /// Writes a mesh to several files.
    pub write_files: Option<WriteFiles>,
    /// Small files next to a mesh written to a path, with their content, which does not depend on the positions of
    /// the nodes.
    pub companions: Companions,
    /// The surface of a mesh, as a format of surfaces writes it, and notes on the rest.
    pub surface: Option<SurfaceOf>,
    /// Opens a file for a whole sequence.
    pub sequence: Option<CreateSequence>,
    /// Writes the steps of a run into a folder that holds more than meshes.
    pub case: Option<CaseFormat>,
    /// True if ranks that have coordinates can write them into the file.
    pub takes_numbers_apart: fn(&WriteOptions) -> bool,
    /// True if ranks that have the cells of this mesh can write their nodes into such a file too: the file has each
    /// cell once, in the order of the mesh or by kind. Uses only the kinds of cells, the groups and the boundary
    /// faces of the reference mesh.
    pub takes_cells_apart: fn(&MeshView) -> bool,
}

/// [`Format::write`].
pub type WriteFile = fn(&MeshView, &mut dyn Out, &WriteOptions) -> Result<Notes>;
/// [`Format::write_files`].
pub type WriteFiles = fn(&MeshView, &mut OutputSet, &WriteOptions) -> Result<Notes>;
/// [`Format::companions`].
pub type Companions = fn(&MeshView, &Path) -> Vec<(PathBuf, Vec<u8>)>;
/// [`Format::surface`].
pub type SurfaceOf = fn(&MeshView, OuterFaces) -> (Mesh, Notes);

/// Parts of a mesh besides nodes, cells and tags that a format holds.
#[derive(Clone, Copy)]
pub struct Holds {
    /// Arrays at nodes and cells.
    pub arrays: bool,
    /// The displacement of the nodes, where it is asked for.
    pub displacement: bool,
    /// Names of tags as arrays of their own, which can be left out.
    pub tag_names: bool,
}

impl Holds {
    /// Nothing else.
    pub const NOTHING: Self = Self {
        arrays: false,
        displacement: false,
        tag_names: false,
    };
    /// Arrays.
    pub const ARRAYS: Self = Self {
        arrays: true,
        displacement: true,
        ..Self::NOTHING
    };
    /// Arrays, also of names of tags.
    pub const NAMED_ARRAYS: Self = Self {
        tag_names: true,
        ..Self::ARRAYS
    };
}

/// Functions of a format whose meshes are folders.
pub struct Folder {
    /// Recognizes a folder, or a file in one.
    pub detect: fn(&Location) -> bool,
    /// Reads a mesh, as [`Format::read`] does.
    pub read: fn(&Location, &ReadOptions, &mut Notes) -> Result<Mesh>,
    /// Times of the steps of a sequence.
    pub steps: fn(&Location) -> Result<Vec<f64>>,
    /// The folder that a mesh written to a path shares with files that are not of the mesh.
    pub shared: fn(&Path) -> SharedFolder,
}

impl Format {
    /// A format that reads and writes nothing.
    pub const NEW: Self = Self {
        name: "",
        title: "",
        extensions: &[],
        holds: Holds::NOTHING,
        is_surface: false,
        is_in_pieces: false,
        lists_faces_again: true,
        encodings: &[Encoding::Raw, Encoding::Ascii],
        precisions: &[Precision::F64],
        compresses: false,
        list_ending: None,
        detect: |_| false,
        title_of: None,
        version: |_| None,
        read: |source, _, _| Err(Error::input("this is not a mesh file").file(source.path())),
        steps: |_| Ok(Vec::new()),
        slabs: None,
        folder: None,
        write: None,
        write_files: None,
        companions: |_, _| Vec::new(),
        surface: None,
        sequence: None,
        case: None,
        takes_numbers_apart: |_| false,
        takes_cells_apart: |_| false,
    };

    /// Checks if meshes are written; else they are read only.
    pub fn is_written(&self) -> bool {
        self.write.is_some() || self.write_files.is_some()
    }

    /// Checks if a mesh, or a sequence, is a folder.
    pub fn is_folder(&self) -> bool {
        self.folder.is_some()
    }

    /// Checks if coordinates are written in 32 bits for the precision that is `asked` for.
    pub fn rounds(&self, asked: Precision) -> bool {
        let is_there = self.precisions.contains(&asked);
        (if is_there { asked } else { self.precisions[0] }) == Precision::F32
    }

    /// Checks if the file or folder is of this format.
    pub fn recognizes(&self, location: &Location) -> bool {
        match &self.folder {
            Some(folder) => (folder.detect)(location),
            None => location.file().is_ok_and(self.detect),
        }
    }

    /// The title of a file with these first bytes.
    pub fn title_of(&self, head: &[u8]) -> String {
        let title = self.title_of.map(|title_of| title_of(head));
        title.unwrap_or_else(|| self.title.to_owned())
    }

    /// Reads a mesh, without the checks of [`read`](super::read).
    pub fn read(
        &self,
        location: &Location,
        options: &ReadOptions,
        notes: &mut Notes,
    ) -> Result<Mesh> {
        match &self.folder {
            Some(folder) => (folder.read)(location, options, notes),
            None => (self.read)(location.file()?, options, notes),
        }
    }

    /// Reads a mesh from a file, as [`Format::read`] does.
    pub fn read_file(
        &self,
        source: &Source,
        options: &ReadOptions,
        notes: &mut Notes,
    ) -> Result<Mesh> {
        (self.read)(source, options, notes)
    }

    /// Opens a file by slabs, where its mesh can be read so.
    ///
    /// # Errors
    /// As [`Format::read`], if they are found here.
    pub fn slabs<'a>(&self, source: &'a Source, options: &ReadOptions) -> Result<Opened<'a>> {
        match self.slabs {
            Some(open) => open(source, options),
            None => Ok(Err(format!("{} is not read by slabs", self.title))),
        }
    }

    /// Times of the steps of a sequence in one file or folder; empty where it holds one mesh.
    pub fn steps(&self, location: &Location) -> Result<Vec<f64>> {
        match (&self.folder, location.file()) {
            (Some(folder), _) => (folder.steps)(location),
            (None, Ok(file)) => (self.steps)(file),
            (None, Err(_)) => Ok(Vec::new()),
        }
    }

    /// Writes the mesh; returns a note for each thing that the format cannot hold.
    pub fn write(
        &self,
        mesh: &MeshView,
        out: &mut OutputSet,
        options: &WriteOptions,
    ) -> Result<Notes> {
        if let Some(write) = self.write_files {
            return write(mesh, out, options);
        }
        let companions = (self.companions)(mesh, out.path());
        if !companions.is_empty() && out.path().as_os_str() == "-" {
            return Err(Error::input(format!(
                "{} has a second file, for names and conditions of tags; standard output can hold only one, so write to a file",
                self.name
            )));
        }
        let is_stream = out.is_stream();
        for (path, content) in companions.iter().filter(|_| !is_stream) {
            out.companion(path, content)?;
        }
        let mut notes = out.main(|out| self.write_file(mesh, out, options))?;
        notes.extend(not_taken(mesh, self.name));
        if is_stream && !companions.is_empty() {
            notes.push(note!(
                "companion_left_out",
                "names and conditions of tags are not written: they need a second file, which a device or a pipe cannot hold"
            ));
        }
        Ok(notes)
    }

    /// Writes the mesh front to back, for formats of one file.
    pub fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        match self.write {
            Some(write) => write(mesh, out, options),
            None if self.is_written() => Err(Error::input(format!(
                "{} is not written as a single file",
                self.title
            ))),
            None => Err(read_only(self.title)),
        }
    }
}

/// Outer faces of a solid mesh that are its surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OuterFaces {
    /// All of them.
    All,
    /// Boundary cells of the mesh.
    Listed,
}

/// The surface of a mesh, and notes on what of the mesh is not in it.
pub(super) fn surface_of(
    mesh: &MeshView,
    format: &'static str,
    outer: OuterFaces,
) -> (Mesh, Notes) {
    let skin = mesh.skin();
    let mut notes = Notes::default();
    notes.count(skin.n_solid, |n| {
        note!(
            "boundary_alone",
            "{format} holds surfaces: the boundary alone is written; solid cells left out, with their zones: {n}"
        )
    });
    notes.lower_cells(skin.n_lower);
    notes.count(skin.n_bare, |n| match outer {
        OuterFaces::All => note!(
            "bare_faces",
            "outer faces without a boundary element are written too, without a tag ({n})"
        ),
        OuterFaces::Listed => note!(
            "bare_faces_left_out",
            "outer faces without a boundary element, such as those that {} or {} removed, are left out ({n})",
            option("keep-tag"),
            option("drop-tag")
        ),
    });
    notes.count(skin.n_curved, |n| {
        note!(
            "curved_faces_flat",
            "curved cells are written flat, with their corners only ({n})"
        )
    });
    let surface = match outer {
        OuterFaces::All => skin.mesh,
        OuterFaces::Listed => skin.without_bare(),
    };
    (surface, notes)
}
