//! Reading MSH: the header, then section by section.

use super::super::lexer::shown;
use super::entities::Physicals;
use super::groups::{PhysicalName, Shared, Tagged, groups, read_names};
use super::nodes::Nodes;
use super::stream::{Binary, Stream};
use super::{elements, elements2, entities, nodes};
use crate::error::{Error, Result};
use crate::mesh::{Cells, Mesh};

/// The versions that are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Version {
    V2,
    V41,
}

/// What has been read so far.
#[derive(Default)]
struct Parts {
    nodes: Option<Nodes>,
    cells: Option<Cells>,
    names: Vec<PhysicalName>,
    physical: Tagged,
    elementary: Tagged,
    physicals: Physicals,
    shared: Shared,
}

/// The mesh in these bytes.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh> {
    let mut stream = Stream::new(bytes);
    let mut parts = Parts::default();
    let mut version = None;
    while let Some(name) = next_section(&mut stream) {
        match (name, version) {
            (b"MeshFormat", None) => version = Some(read_format(&mut stream)?),
            (b"NOD" | b"ELM", None) => {
                return Err(stream.error("this is MSH 1.0; versions 2 and 4.1 are read"));
            }
            (b"Nodes" | b"Elements" | b"PhysicalNames" | b"Entities", None) => {
                return Err(stream.error(format!("${} before $MeshFormat", show(name))));
            }
            (_, Some(version)) if parts.read(name, version, &mut stream)? => {}
            _ => {
                skip_section(name, &mut stream)?;
                continue;
            }
        }
        end_section(name, &mut stream)?;
    }
    if version.is_none() {
        return Err(no_format(bytes));
    }
    parts.mesh(&stream)
}

/// Other programs' files end in .msh too.
fn no_format(bytes: &[u8]) -> Error {
    let head = bytes.trim_ascii_start();
    let found = match head.first() {
        None => "it is empty".to_owned(),
        Some(b'(') => "it looks like a mesh of Fluent".to_owned(),
        Some(_) => format!("it starts with {}", shown(&head[..head.len().min(24)])),
    };
    Error::input(format!(
        "no $MeshFormat, so this is no mesh of Gmsh: {found}"
    ))
    .line(1)
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

/// Moves past the end of a section that is of no use here.
fn skip_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let end = [b"$End", name].concat();
    match memchr::memmem::find(stream.text.rest(), &end) {
        Some(at) => {
            stream
                .text
                .set_position(stream.text.position() + at + end.len());
            Ok(())
        }
        None => Err(stream.error(format!("${0} has no $End{0}", show(name)))),
    }
}

fn end_section(name: &[u8], stream: &mut Stream) -> Result<()> {
    let before = stream.text.position();
    let end = [b"$End", name].concat();
    let line = stream.text.line();
    let found = match &line {
        Some(line) if line.rest() == end => return Ok(()),
        Some(line) => shown(line.rest()),
        None => "the end of the file".into(),
    };
    let message = format!("expected $End{}, found {found}", show(name));
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
        2.0..3.0 => Version::V2,
        4.1 => Version::V41,
        _ => {
            return Err(line.error(format!(
                "this is MSH {number}; versions 2 and 4.1 are read, gmsh -save writes 4.1"
            )));
        }
    };
    if !matches!((is_binary, size), (0, _) | (1, 4 | 8)) {
        return Err(line.error(format!(
            "file type {is_binary} with data size {size}; \
             they are 0 for text or 1 for binary, and 4 or 8"
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
            _ => return Err(stream.error("the integer 1 that tells the byte order is not there")),
        };
        stream.binary = Some(Binary {
            big_endian,
            size_bytes: size as usize,
        });
    }
    Ok(version)
}

impl Parts {
    /// Reads a section that matters; `false` for any other.
    fn read(&mut self, name: &[u8], version: Version, stream: &mut Stream) -> Result<bool> {
        match (name, version) {
            (b"PhysicalNames", _) => self.names.extend(read_names(stream)?),
            (b"Entities", Version::V41) => entities::read(stream, &mut self.physicals)?,
            (b"PartitionedEntities", Version::V41) => {
                entities::read_partitioned(stream, &mut self.physicals)?;
            }
            (b"Nodes" | b"ParametricNodes", _) if self.nodes.is_some() => {
                return Err(stream.error("a second section of nodes"));
            }
            (b"Nodes", Version::V41) => self.nodes = Some(nodes::read41(stream)?),
            (b"Nodes" | b"ParametricNodes", Version::V2) => {
                self.nodes = Some(nodes::read2(stream, name == b"ParametricNodes")?);
            }
            (b"Elements", _) => self.read_elements(version, stream)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn read_elements(&mut self, version: Version, stream: &mut Stream) -> Result<()> {
        let Some(Nodes { index, .. }) = &self.nodes else {
            return Err(stream.error("$Elements before $Nodes"));
        };
        if self.cells.is_some() {
            return Err(stream.error("a second section $Elements"));
        }
        let (physical, elementary) = (&mut self.physical, &mut self.elementary);
        self.cells = Some(match version {
            Version::V41 => elements::read41(stream, index, elementary)?,
            Version::V2 => elements2::read2(stream, index, physical, elementary, &mut self.shared)?,
        });
        Ok(())
    }

    fn mesh(self, stream: &Stream) -> Result<Mesh> {
        let Some(nodes) = self.nodes else {
            return Err(stream.error("no $Nodes in the file"));
        };
        let mut mesh = Mesh {
            points: nodes.points,
            cells: self.cells.unwrap_or_default(),
            ..Mesh::default()
        };
        let physical = match self.physicals.is_empty() {
            true => self.physical,
            false => self.elementary.physical(&self.physicals),
        };
        mesh.groups = groups(self.names, physical, self.elementary, mesh.dimension());
        self.shared.merge(&mut mesh);
        Ok(mesh)
    }
}
