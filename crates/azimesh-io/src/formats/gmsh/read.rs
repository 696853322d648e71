//! Reading MSH: the header, then section by section.

use super::super::lexer::shown;
use super::super::{Notes, ReadOptions};
use super::data::{self, Data, DataOwner};
use super::elements2::Tags;
use super::entities::Entities;
use super::groups::{self, PhysicalName, read_names};
use super::nodes::Nodes;
use super::stream::{Binary, Stream, Version};
use super::{comments, elements, elements2, foreign, nodes};
use crate::mesh::{Cells, DataArray, Mesh, Values};
use azimesh_core::diagnostic::formats::{NotKept, Read};
use azimesh_core::error::{Error, Result};

/// The sections that have been read so far.
#[derive(Default)]
struct FileContent<'a> {
    nodes: Option<Nodes>,
    cells: Option<Cells>,
    names: Vec<PhysicalName>,
    tags: Tags,
    entities: Entities,
    data: Vec<Data<'a>>,
    /// Whether groups are given by entity, so that `$Entities` is needed.
    needs_entities: bool,
}

/// The mesh in these bytes.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    match comments::without(bytes, notes) {
        None => read_sections(bytes, options, notes),
        Some(plain) => read_sections(&plain, options, notes),
    }
}

fn read_sections(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let mut parts = FileContent::default();
    let stream = sections(bytes, |name, version, stream| {
        let is_read = parts.read(name, version, stream, notes)?;
        Ok(if is_read { Passed::Read } else { Passed::Over })
    })?;
    if stream.binary.is_none() {
        notes.fortran(bytes);
    }
    if !stream.unended.is_empty() {
        let sections = stream.unended.clone();
        notes.push(Read::Unended { sections });
    }
    parts.mesh(&stream, options, notes)
}

/// Gives the mesh of a mesh in binary MSH 4.1 its groups and arrays. Its nodes are known, and where their section ends.
pub(super) fn complete(
    bytes: &[u8],
    (nodes, end): (Nodes, usize),
    mesh: &mut Mesh,
    options: &ReadOptions,
    notes: &mut Notes,
) -> Result<()> {
    let mut parts = FileContent {
        needs_entities: true,
        ..FileContent::default()
    };
    let (mut has_nodes, mut has_elements) = (false, false);
    sections(bytes, |name, version, stream| {
        let is_second = match name {
            b"Nodes" | b"ParametricNodes" => std::mem::replace(&mut has_nodes, true),
            b"Elements" => std::mem::replace(&mut has_elements, true),
            _ => false,
        };
        if is_second {
            return Err(stream.error(format!("there is a second ${}", show(name))));
        }
        let is_read = match name {
            b"Nodes" => {
                stream.text.set_position(end);
                true
            }
            b"Elements" => {
                let tags = &mut parts.tags;
                elements::read_tags(stream, version, &mut tags.elementary, &mut tags.numbers)?;
                true
            }
            _ => parts.read(name, version, stream, notes)?,
        };
        Ok(if is_read { Passed::Read } else { Passed::Over })
    })?;
    parts.complete(nodes, mesh, options, notes)
}

/// Times of the data, where some array is there more than once.
pub(super) fn steps(bytes: &[u8]) -> Result<Vec<f64>> {
    match comments::without(bytes, &mut Notes::default()) {
        None => steps_of_sections(bytes),
        Some(plain) => steps_of_sections(&plain),
    }
}

fn steps_of_sections(bytes: &[u8]) -> Result<Vec<f64>> {
    let mut found = Vec::new();
    sections(bytes, |name, _, stream| {
        let Some(kind) = DataOwner::of(name) else {
            return Ok(Passed::Over);
        };
        found.push(Data::read(stream, kind, &mut Notes::default())?);
        Ok(Passed::Read)
    })?;
    Ok(data::times(&found))
}

/// What was done with a section.
pub(super) enum Passed {
    /// It was read.
    Read,
    /// It is to be passed over.
    Over,
    /// It was read, or not, and no further one is needed.
    Last,
}

/// Passes every section to `read`, as far as they are needed.
pub(super) fn sections<'a, E: From<Error>>(
    bytes: &'a [u8],
    mut read: impl FnMut(&[u8], Version, &mut Stream<'a>) -> std::result::Result<Passed, E>,
) -> std::result::Result<Stream<'a>, E> {
    let mut stream = Stream::new(bytes);
    let mut version = None;
    while let Some(name) = next_section(&mut stream) {
        let known = match (name, version) {
            (b"MeshFormat", None) => {
                version = Some(read_format(&mut stream)?);
                end_section(name, &mut stream)?;
                continue;
            }
            // Version 1 has no other header.
            (b"NOD" | b"ELM", None) => *version.insert(Version::V1),
            (b"Nodes" | b"Elements" | b"PhysicalNames" | b"Entities", None) => {
                let message = format!("${} comes before $MeshFormat", show(name));
                return Err(stream.error(message).into());
            }
            (_, Some(version)) => version,
            (_, None) => {
                skip_section(name, &mut stream)?;
                continue;
            }
        };
        match read(name, known, &mut stream)? {
            Passed::Read => end_section(name, &mut stream)?,
            Passed::Over => skip_section(name, &mut stream)?,
            Passed::Last => return Ok(stream),
        }
    }
    match version {
        Some(_) => Ok(stream),
        None => Err(foreign::refusal(bytes).into()),
    }
}

/// Moves past the next line that starts a section; its name without the `$`.
fn next_section<'a>(stream: &mut Stream<'a>) -> Option<&'a [u8]> {
    while let Some(line) = stream.text.line() {
        if let Some(name) = line.rest().strip_prefix(b"$") {
            return Some(name);
        }
    }
    None
}

fn show(name: &[u8]) -> String {
    name[..name.len().min(40)].escape_ascii().to_string()
}

/// The line that ends a section; version 1 has it in capitals.
fn end_of(name: &[u8]) -> Vec<u8> {
    match name {
        b"NOD" | b"ELM" => [b"$END", name].concat(),
        _ => [b"$End", name].concat(),
    }
}

/// Moves past the end of a section that is of no use here.
fn skip_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let end = end_of(name);
    match memchr::memmem::find(stream.text.rest(), &end) {
        Some(at) => {
            stream
                .text
                .set_position(stream.text.position() + at + end.len());
            Ok(())
        }
        // Real files leave it out before the next section.
        None if stream.binary.is_none()
            && memchr::memmem::find(stream.text.rest(), b"\n$").is_some() =>
        {
            stream.unended.push(format!("${}", show(name)));
            Ok(())
        }
        // Whether it is whole, who reads it finds out.
        None if stream.binary.is_none() => {
            stream.unended.push(format!("${}", show(name)));
            stream.text.set_position(stream.text.bytes().len());
            Ok(())
        }
        None => Err(stream.error(format!("${0} has no $End{0}", show(name)))),
    }
}

fn end_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let before = stream.text.position();
    let end = end_of(name);
    let line = stream.text.line();
    let found = match &line {
        Some(line) if line.rest() == end => return Ok(()),
        // Real files misspell the end of a section, or leave it out before the next one.
        Some(line) if stream.binary.is_none() && line.rest().starts_with(b"$") => {
            if !line.rest().starts_with(b"$End") {
                stream.text.set_position(before);
                stream.unended.push(format!("${}", show(name)));
            }
            return Ok(());
        }
        // The content is whole: its counts say so.
        None if stream.binary.is_none() => {
            stream.unended.push(format!("${}", show(name)));
            return Ok(());
        }
        Some(line) => shown(line.rest()),
        None => "the end of the file".into(),
    };
    let message = format!("expected {}, found {found}", end.escape_ascii());
    match (&stream.binary, line) {
        (None, Some(line)) => Err(line.error(message)),
        _ => {
            stream.text.set_position(before);
            Err(stream.error(message))
        }
    }
}

/// Reads version, encoding and byte order.
fn read_format(stream: &mut Stream) -> Result<Version> {
    let line = stream.text.line();
    let mut line = line.ok_or_else(|| stream.error("the file ends within $MeshFormat"))?;
    let number = line.real("the version")?;
    let is_binary = line.integer("the file type")?;
    let size = line.integer("the data size")?;
    let version = match number {
        1.0..2.0 => Version::V1,
        2.0..3.0 => Version::V2,
        3.0..4.0 => Version::V3,
        4.0 => Version::V40,
        4.1 => Version::V41,
        _ => {
            return Err(line.error(format!(
                "this is MSH {number}; versions 1 to 4.1 are read, gmsh -save writes 4.1"
            )));
        }
    };
    if !matches!((is_binary, size), (0, _) | (1, 4 | 8)) {
        return Err(line.error(format!(
            "the file type is {is_binary} and the data size {size}; they must be 0 (text) or 1 (binary), and 4 or 8"
        )));
    }
    if is_binary == 1 {
        stream.binary = Some(Binary {
            big_endian: false,
            size_bytes: size as usize,
        });
        let one = stream.take(1, 4, "the byte order")?;
        let big_endian = match one {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            _ => return Err(stream.error("the integer 1, which tells the byte order, is missing")),
        };
        stream.binary = Some(Binary {
            big_endian,
            size_bytes: size as usize,
        });
    }
    Ok(version)
}

impl<'a> FileContent<'a> {
    /// Reads a section that matters; `false` for any other, of which there is a note.
    fn read(
        &mut self,
        name: &[u8],
        version: Version,
        stream: &mut Stream<'a>,
        notes: &mut Notes,
    ) -> Result<bool> {
        match (name, version) {
            (b"PhysicalNames", _) => self.names.extend(read_names(stream, notes)?),
            (b"Entities", Version::V3 | Version::V40 | Version::V41) => {
                self.entities.read(stream, version)?;
            }
            (b"PartitionedEntities", Version::V40 | Version::V41) => {
                self.entities.read_partitioned(stream, version)?;
            }
            (b"Nodes" | b"ParametricNodes" | b"NOD", _) => {
                if self.nodes.is_some() {
                    return Err(stream.error("there is a second section of nodes"));
                }
                self.nodes = Some(nodes::read(stream, version, name == b"ParametricNodes")?);
            }
            (b"Elements" | b"ELM", _) => self.read_elements(version, stream)?,
            _ => match DataOwner::of(name) {
                Some(kind) => self.data.push(Data::read(stream, kind, notes)?),
                None => {
                    if !matches!(name, b"Comments" | b"Comment") {
                        notes.push(NotKept::Section { name: show(name) });
                    }
                    return Ok(false);
                }
            },
        }
        Ok(true)
    }

    fn read_elements(&mut self, version: Version, stream: &mut Stream) -> Result<()> {
        let Some(Nodes { index, .. }) = &self.nodes else {
            return Err(stream.error("$Elements comes before $Nodes"));
        };
        if self.cells.is_some() {
            return Err(stream.error("there is a second $Elements"));
        }
        self.needs_entities = matches!(version, Version::V3 | Version::V40 | Version::V41);
        let tags = &mut self.tags;
        self.cells = Some(match version {
            Version::V40 | Version::V41 => {
                let (elementary, numbers) = (&mut tags.elementary, &mut tags.numbers);
                elements::read(stream, version, index, elementary, numbers)?
            }
            _ => elements2::read(stream, version, index, tags)?,
        });
        Ok(())
    }

    fn mesh(mut self, stream: &Stream, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        let Some(mut nodes) = self.nodes.take() else {
            return Err(stream.error("the file has no $Nodes"));
        };
        let mut mesh = Mesh {
            points: std::mem::take(&mut nodes.points),
            cells: self.cells.take().unwrap_or_default(),
            ..Mesh::default()
        };
        self.complete(nodes, &mut mesh, options, notes)?;
        Ok(mesh)
    }

    /// Gives a mesh that has its nodes and cells its groups and arrays.
    fn complete(
        self,
        nodes: Nodes,
        mesh: &mut Mesh,
        options: &ReadOptions,
        notes: &mut Notes,
    ) -> Result<()> {
        notes.count(nodes.n_parametric, |n| NotKept::Of {
            what: "parametric coordinates",
            n,
            item: "node",
        });
        if self.tags.n_ghosts > 0 {
            let n = self.tags.n_ghosts;
            notes.push(Read::SeveralPartitions { n });
        }
        let named = self.names.len();
        if self.needs_entities && !self.entities.are_known && named > 0 {
            notes.push(Read::GroupsWithoutEntities { n: named });
        }
        let physical = match self.entities.physicals.is_empty() {
            true => self.tags.physical,
            false => self.tags.elementary.physical(&self.entities),
        };
        let (elementary, of_parts) = self.tags.elementary.of_parts(&self.entities);
        mesh.groups = groups::groups(self.names, physical, &elementary, mesh.dimension(), notes);
        let partition = match of_parts.is_empty() {
            true => self.tags.partition,
            false => of_parts,
        };
        mesh.cell_arrays = groups::arrays(&elementary, &partition, mesh);
        let numbers = self.tags.numbers.values();
        data::add(
            &self.data,
            &nodes.index,
            numbers.as_deref(),
            mesh,
            options,
            notes,
        )?;
        let array = |name: &str, numbers| DataArray::scalar(name, Values::I64(numbers));
        mesh.point_arrays
            .extend(nodes.numbers.map(|numbers| array("node_number", numbers)));
        mesh.cell_arrays
            .extend(numbers.map(|numbers| array("cell_number", numbers)));
        self.tags.shared.merge(mesh);
        data::note_missing(mesh, notes);
        Ok(())
    }
}
