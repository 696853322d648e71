//! Reading MSH: the header, then section by section.

use super::super::tokens::shown;
use super::super::{Notes, ReadOptions};
use super::content::{CELL_NUMBERS, NODE_NUMBERS};
use super::data::{self, Data};
use super::elements::{self, Tags};
use super::groups::{self, Entities, PhysicalName};
use super::nodes::{self, Nodes};
use super::stream::{Binary, Stream, Version};
use crate::mesh::{Cells, DataArray, Mesh, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::numbers::with_verb;
use azimesh_core::{Note, note};
use std::borrow::Cow;

/// The sections that have been read so far.
#[derive(Default)]
struct FileContent<'a> {
    nodes: Option<Nodes>,
    cells: Option<Cells>,
    names: Vec<PhysicalName>,
    tags: Tags,
    entities: Entities,
    data: Vec<Data<'a>>,
    /// Set where groups are given by entity, so that `$Entities` is needed.
    needs_entities: bool,
    /// Nodes that are known already, and the end of their section.
    known: Option<(Nodes, usize)>,
    /// Set where points and cells are known already.
    only_tags: bool,
}

/// The mesh in these bytes.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let bytes = &*without_comments(bytes, notes);
    let mut parts = FileContent::default();
    let stream = sections(bytes, |name, stream| parts.read(name, stream, notes))?;
    if stream.binary.is_none() {
        notes.fortran(bytes);
    }
    if !stream.unended.is_empty() {
        notes.push(note!(
            "unended",
            "lines that end sections are missing, and the sections are read: {}",
            stream.unended.join(", ")
        ));
    }
    let mut mesh = Mesh::default();
    parts.complete(&stream, &mut mesh, options, notes)?;
    Ok(mesh)
}

/// Adds groups and arrays to a mesh in binary MSH 4.1 that has its points and cells; takes its nodes and the end of
/// their section.
pub(super) fn complete(
    bytes: &[u8],
    nodes: (Nodes, usize),
    mesh: &mut Mesh,
    options: &ReadOptions,
    notes: &mut Notes,
) -> Result<()> {
    let mut parts = FileContent {
        known: Some(nodes),
        only_tags: true,
        ..FileContent::default()
    };
    let stream = sections(bytes, |name, stream| parts.read(name, stream, notes))?;
    parts.complete(&stream, mesh, options, notes)
}

/// Times of the data, where some array is there more than once.
pub(super) fn steps(bytes: &[u8]) -> Result<Vec<f64>> {
    let mut notes = Notes::default();
    let bytes = &*without_comments(bytes, &mut notes);
    let mut all = Vec::new();
    sections(bytes, |name, stream| {
        let data = Data::read(name, stream, &mut notes)?;
        let passed = data.as_ref().map_or(Passed::Over, |_| Passed::Read);
        all.extend(data);
        Ok(passed)
    })?;
    Ok(data::times(&all))
}

/// The result of the visit of a section.
pub(super) enum Passed {
    Read,
    Over,
    /// No further section is needed.
    Last,
}

/// Passes every section to `read`, as far as they are needed.
pub(super) fn sections<'a, E: From<Error>>(
    bytes: &'a [u8],
    mut read: impl FnMut(&[u8], &mut Stream<'a>) -> std::result::Result<Passed, E>,
) -> std::result::Result<Stream<'a>, E> {
    let mut stream = Stream::new(bytes);
    let mut has_version = false;
    while let Some(name) = next_section(&mut stream) {
        match name {
            b"MeshFormat" if !has_version => {
                has_version = true;
                read_format(&mut stream)?;
                end_section(name, &mut stream)?;
                continue;
            }
            // Version 1 has no other header.
            b"NOD" | b"ELM" => has_version = true,
            b"Nodes" | b"Elements" | b"PhysicalNames" | b"Entities" if !has_version => {
                let message = format!("${} comes before $MeshFormat", show(name));
                return Err(stream.error(message).into());
            }
            _ => {}
        }
        match has_version.then(|| read(name, &mut stream)).transpose()? {
            Some(Passed::Read) => end_section(name, &mut stream)?,
            Some(Passed::Last) => return Ok(stream),
            Some(Passed::Over) | None => skip_section(name, &mut stream)?,
        }
    }
    if !has_version {
        return Err(refusal(bytes).into());
    }
    Ok(stream)
}

/// Moves past the next line that starts a section; its name without the `$`.
fn next_section<'a>(stream: &mut Stream<'a>) -> Option<&'a [u8]> {
    std::iter::from_fn(|| stream.text.line()).find_map(|line| line.rest().strip_prefix(b"$"))
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

/// Moves past the end of a section that is not needed.
fn skip_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let end = end_of(name);
    let rest = stream.text.left();
    if let Some(at) = memchr::memmem::find(rest, &end) {
        let next = stream.text.position() + at + end.len();
        stream.text.set_position(next);
        return Ok(());
    }
    if stream.binary.is_some() {
        return Err(stream.error(format!("${0} has no $End{0}", show(name))));
    }
    // Real files leave it out, before the next section or at the end of the file.
    stream.unended.push(format!("${}", show(name)));
    if memchr::memmem::find(rest, b"\n$").is_none() {
        stream.text.set_position(stream.text.bytes().len());
    }
    Ok(())
}

fn end_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let before = stream.text.position();
    let end = end_of(name);
    let line = stream.text.line();
    let text = line.as_ref().map(|line| line.rest());
    let is_text = stream.binary.is_none();
    let is_open = match text {
        Some(text) if text == end => return Ok(()),
        // Real files misspell the end of a section, or leave it out before the next one or at the end of the file.
        Some(text) if is_text && text.starts_with(b"$End") => return Ok(()),
        Some(text) => text.starts_with(b"$"),
        None => true,
    };
    if is_text && is_open {
        if text.is_some() {
            stream.text.set_position(before);
        }
        stream.unended.push(format!("${}", show(name)));
        return Ok(());
    }
    let found = text.map_or("the end of the file".into(), shown);
    let message = format!("expected {}, found {found}", end.escape_ascii());
    if let Some(line) = line.filter(|_| is_text) {
        return Err(line.error(message));
    }
    stream.text.set_position(before);
    Err(stream.error(message))
}

/// Reads version, encoding and byte order.
fn read_format(stream: &mut Stream) -> Result<()> {
    let line = stream.text.line();
    let mut line = line.ok_or_else(|| stream.error("the file ends within $MeshFormat"))?;
    let number = line.real("the version")?;
    let is_binary = line.integer("the file type")?;
    let size = line.integer("the data size")?;
    stream.version = match number {
        1.0..2.0 => Version::V1,
        2.0..3.0 => Version::V2,
        4.0 => Version::V40,
        4.1 => Version::V41,
        _ => {
            return Err(line.error(format!(
                "this is MSH {number}; versions 1, 2, 4.0 and 4.1 are read, gmsh -save writes 4.1"
            )));
        }
    };
    if !matches!((is_binary, size), (0, _) | (1, 4 | 8)) {
        return Err(line.error(format!(
            "the file type is {is_binary} and the data size {size}; they must be 0 (text) or 1 (binary), and 4 or 8"
        )));
    }
    if is_binary == 1 {
        let mut binary = Binary {
            big_endian: false,
            size_bytes: size as usize,
        };
        stream.binary = Some(binary);
        binary.big_endian = match stream.take(1, 4, "the byte order")? {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            _ => return Err(stream.error("the integer 1, which gives the byte order, is missing")),
        };
        stream.binary = Some(binary);
    }
    Ok(())
}

impl<'a> FileContent<'a> {
    /// Reads a section that is needed; adds a note of any other.
    fn read(&mut self, name: &[u8], stream: &mut Stream<'a>, notes: &mut Notes) -> Result<Passed> {
        let is_v4 = stream.version >= Version::V40;
        match name {
            b"PhysicalNames" => self.names.extend(groups::read_names(stream, notes)?),
            b"Entities" | b"PartitionedEntities" if is_v4 => {
                self.entities.read(stream, name == b"PartitionedEntities")?;
            }
            b"Nodes" | b"ParametricNodes" | b"NOD" => {
                if self.nodes.is_some() {
                    return Err(stream.error("there is a second section of nodes"));
                }
                self.nodes = Some(match self.known.take() {
                    Some((nodes, end)) => {
                        stream.text.set_position(end);
                        nodes
                    }
                    None => nodes::read(stream, name == b"ParametricNodes")?,
                });
            }
            b"Elements" | b"ELM" => self.read_elements(stream)?,
            _ => match Data::read(name, stream, notes)? {
                Some(data) => self.data.push(data),
                None => {
                    if !matches!(name, b"Comments" | b"Comment") {
                        notes.push(section_not_kept(&show(name)));
                    }
                    return Ok(Passed::Over);
                }
            },
        }
        Ok(Passed::Read)
    }

    fn read_elements(&mut self, stream: &mut Stream) -> Result<()> {
        let Some(Nodes { index, .. }) = &self.nodes else {
            return Err(stream.error("$Elements comes before $Nodes"));
        };
        if self.cells.is_some() {
            return Err(stream.error("there is a second $Elements"));
        }
        self.needs_entities = stream.version >= Version::V40;
        self.cells = Some(if self.only_tags {
            elements::read_tags(stream, &mut self.tags)?;
            Cells::default()
        } else {
            elements::read(stream, index, &mut self.tags)?
        });
        Ok(())
    }

    /// Adds what was read to a mesh.
    fn complete(
        self,
        stream: &Stream,
        mesh: &mut Mesh,
        options: &ReadOptions,
        notes: &mut Notes,
    ) -> Result<()> {
        let missing = || stream.error("the file has no $Nodes");
        let nodes = self.nodes.ok_or_else(missing)?;
        if !self.only_tags {
            mesh.points = nodes.points;
            mesh.cells = self.cells.unwrap_or_default();
        }
        notes.count(nodes.n_parametric, |n| {
            let nodes = counted(n, "node");
            note!(
                "parametric_coordinates",
                "parametric coordinates of {nodes} are not kept"
            )
        });
        let tags = self.tags;
        notes.count(tags.n_ghosts, |n| {
            note!(
                "several_partitions",
                "{} in several partitions; the first of these is kept",
                with_verb(n, "element", "is")
            )
        });
        let named = self.names.len();
        if self.needs_entities && !self.entities.are_known && named > 0 {
            notes.push(note!(
                "groups_without_entities",
                "{} left without elements: the file has no $Entities to say which they are",
                with_verb(named, "physical group", "is")
            ));
        }
        let physical = if self.entities.physicals.is_empty() {
            tags.physical
        } else {
            tags.elementary.physical(&self.entities)
        };
        let of_parts = tags.elementary.of_parts(&self.entities);
        let (elementary, partition) = of_parts.unwrap_or((tags.elementary, tags.partition));
        mesh.groups = groups::groups(self.names, physical, &elementary, mesh.dimension(), notes);
        mesh.cell_arrays = groups::arrays(&elementary, &partition, mesh);
        let numbers = tags.numbers.values();
        let index = (&nodes.index, numbers.as_deref());
        data::add(&self.data, index, mesh, options, notes)?;
        for (arrays, name, numbers) in [
            (&mut mesh.point_arrays, NODE_NUMBERS, nodes.numbers),
            (&mut mesh.cell_arrays, CELL_NUMBERS, numbers),
        ] {
            arrays.extend(numbers.map(|n| DataArray::scalar(name, Values::I64(n))));
        }
        tags.shared.merge(mesh);
        data::note_missing(mesh, notes);
        Ok(())
    }
}

/// The text with blanks in place of `$Comments` within sections, which Gmsh itself does not take; with the same lines.
pub(super) fn without_comments<'a>(bytes: &'a [u8], notes: &mut Notes) -> Cow<'a, [u8]> {
    const END: &[u8] = b"\n$EndComments";
    let mut plain = Cow::Borrowed(bytes);
    let mut from = 0;
    while let Some(at) = memchr::memmem::find(&bytes[from..], b"\n$Comments").map(|at| from + at) {
        let Some(end) = memchr::memmem::find(&bytes[at..], END).map(|n| at + n + END.len()) else {
            return bytes.into();
        };
        if let Some(section) = section_at(&bytes[..at]) {
            let comment = plain.to_mut()[at..end].iter_mut();
            let visible = comment.filter(|byte| !matches!(byte, b'\n' | b'\r'));
            visible.for_each(|byte| *byte = b' ');
            notes.push(note!(
                "comments_within",
                "$Comments within ${section} are passed over"
            ));
        }
        from = end;
    }
    plain
}

/// Notes a section that a mesh does not hold.
fn section_not_kept(name: &str) -> Note {
    let section = match name {
        "Periodic" => "periodic links between entities ($Periodic) are".to_owned(),
        "GhostElements" => "ghost elements of partitions ($GhostElements) are".to_owned(),
        "ElementNodeData" => "values at each element's own nodes ($ElementNodeData) are".to_owned(),
        name => format!("section ${name} is"),
    };
    note!("section_not_kept", "{section} not kept").with("section", name)
}

/// The section that is open at the end of a text; `None` in binary.
fn section_at(before: &[u8]) -> Option<String> {
    let mut lines = memchr::memrchr_iter(b'$', before);
    let at = lines.find(|at| *at == 0 || before[at - 1] == b'\n')?;
    let name = before[at + 1..].split(u8::is_ascii_whitespace).next()?;
    let is_name = !name.is_empty() && name.iter().all(u8::is_ascii_alphanumeric);
    let is_text = !before[at..].contains(&0);
    let is_open = is_name && is_text && !name.starts_with(b"End");
    is_open.then(|| String::from_utf8_lossy(name).into_owned())
}

/// The refusal of a file without `$MeshFormat`, which names its format.
pub(super) fn refusal(bytes: &[u8]) -> Error {
    let head = bytes.trim_ascii_start();
    let head = &head[..head.len().min(4096)];
    let known = [
        ("(", "it is a Fluent mesh, which is read as format fluent"),
        (
            "*",
            "it is an Abaqus or CalculiX mesh, which is read as format abaqus",
        ),
        ("MESH", "it is a GiD mesh"),
        ("$PostFormat", "it holds Gmsh views (.pos) and no mesh"),
        (
            "MeshVersionFormatted",
            "it is a Medit mesh, which is read as format medit",
        ),
    ];
    let starts = |text: &str| {
        let start = head.get(..text.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(text.as_bytes()))
    };
    let found = match known.iter().find(|(text, _)| starts(text)) {
        _ if head.is_empty() => "it is empty".to_owned(),
        Some((_, found)) => (*found).to_owned(),
        None if is_format_line(head) => {
            "it looks like a Gmsh mesh without section names".to_owned()
        }
        None => format!("it starts with {}", shown(&head[..head.len().min(24)])),
    };
    Error::input(format!(
        "there is no $MeshFormat, so this is not a Gmsh mesh: {found}"
    ))
    .line(1)
}

/// Checks if the first line is version, file type and data size, without the line before it.
fn is_format_line(head: &[u8]) -> bool {
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let words = line.split(u8::is_ascii_whitespace);
    let words: Vec<&[u8]> = words.filter(|word| !word.is_empty()).collect();
    matches!(
        words[..],
        [[b'1'..=b'4', b'.', ..], [b'0' | b'1'], [b'4' | b'8']]
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    #[test]
    fn comments_within_a_section_are_passed_over_and_noted() {
        let plain = std::fs::read_to_string("testdata/mixed_cells_v22.msh").expect("it is there");
        let comment = "$Comments\nby hand, 1 2 3\n$EndComments\n";
        let at = plain.find("$Nodes").expect("nodes");
        let at = at + plain[at..].find("\n2 ").expect("a second node") + 1;
        let odd = format!("{}{comment}{}", &plain[..at], &plain[at..]);
        let mut notes = Notes::default();
        assert_eq!(
            without_comments(odd.as_bytes(), &mut notes).len(),
            odd.len()
        );
        assert!(notes.says("$Comments within $Nodes are passed over"));
        let read = |text: &str| {
            read(
                text.as_bytes(),
                &ReadOptions::default(),
                &mut Notes::default(),
            )
            .expect("a mesh")
        };
        assert_eq!(read(&odd), read(&plain));
        let between = plain.replacen("$Nodes", &format!("{comment}$Nodes"), 1);
        let mut notes = Notes::default();
        without_comments(between.as_bytes(), &mut notes);
        assert!(notes.is_empty());
    }

    #[test]
    fn other_programs_files_are_named() {
        for (head, word) in [
            ("(0 \"GAMBIT to Fluent File\")", "Fluent"),
            ("*NODE, NSET=Nall", "CalculiX"),
            ("MESH    dimension 2 ElemType Triangle", "GiD"),
            ("\n2.2 0 8\n\n\n7443", "section names"),
            ("27\n7 17 48", "starts with"),
            ("", "empty"),
        ] {
            let sentence = refusal(head.as_bytes()).to_string();
            assert_says(&sentence, word);
        }
    }
}
