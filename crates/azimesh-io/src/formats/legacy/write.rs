//! Writes a mesh as a legacy file; `vtk::arrays` decides which arrays there are.

use super::super::column::Column;
use super::super::names::{Rule, decoded};
use super::super::records::push_integer;
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::number::{Element, ascii, failed};
use super::super::vtk::order;
use super::super::{Encoding, WriteOptions};
use super::cursor::encoded;
use crate::formats::Notes;
use crate::mesh::{CellKind, CellRef, Cells, MeshView, reverse_each};
use azimesh_core::error::{Error, Result};
use std::io::{BufWriter, Write};

/// Smaller pieces are gathered before they are written.
const BUFFER: usize = 1 << 20;
/// Integers made at a time.
const CHUNK: usize = 1 << 18;

/// Layout of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    /// Cells as `n, node...`, in 32 bits.
    V42,
    /// Offsets and nodes, in 64 bits.
    V51,
}

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(
    mesh: &MeshView,
    out: &mut dyn Write,
    options: &WriteOptions,
    version: Version,
) -> Result<Notes> {
    let flattened = options.check_coordinates(mesh)?;
    if version == Version::V42 && mesh.points.len() > i32::MAX as usize {
        let n = mesh.points.len();
        let message =
            format!("{n} nodes are too many for the 32-bit indices of VTK 4.2; write VTK 5.1");
        return Err(Error::input(message));
    }
    let mut plan = VtkArrays::new(mesh, options, &NAMES);
    plan.notes.extend(flattened);
    let mut out = BufWriter::with_capacity(BUFFER, out);
    let mut writer = Writer {
        out: &mut out,
        binary: options.encoding != Encoding::Ascii,
        version,
    };
    writer.all(mesh, &plan)?;
    out.flush().map_err(failed)?;
    Ok(plan.notes)
}

struct Writer<'o> {
    out: &'o mut dyn Write,
    binary: bool,
    version: Version,
}

impl Writer<'_> {
    fn all(&mut self, mesh: &MeshView, plan: &VtkArrays) -> Result<()> {
        let sections = plan.sections();
        let version = if self.version == Version::V42 {
            "4.2"
        } else {
            "5.1"
        };
        let encoding = if self.binary { "BINARY" } else { "ASCII" };
        let title = if order::has_wedges(mesh.cells) {
            order::TITLE
        } else {
            "written by azimesh"
        };
        self.text(&format!(
            "# vtk DataFile Version {version}\n{title}\n{encoding}\n\
             DATASET UNSTRUCTURED_GRID\n"
        ))?;
        self.field(&sections.fields)?;
        let points = &sections.points[0];
        let n_points = mesh.points.len();
        let kind = self.type_name(points.element);
        self.text(&format!("POINTS {n_points} {kind}\n"))?;
        self.values(points)?;
        self.cells(mesh, plan)?;
        let types = sections.cells.iter().find(|array| array.name == "types");
        self.types(types.expect("every list of cells has types"))?;
        let n_cells = plan.n_cells();
        for (name, n, arrays) in [
            ("CELL_DATA", n_cells, &sections.cell_data),
            ("POINT_DATA", n_points, &sections.point_data),
        ] {
            if !arrays.is_empty() {
                self.text(&format!("{name} {n}\n"))?;
                self.field(arrays)?;
            }
        }
        Ok(())
    }

    fn text(&mut self, text: &str) -> Result<()> {
        self.out.write_all(text.as_bytes()).map_err(failed)
    }

    /// VTK's name of a type in legacy files.
    fn type_name(&self, element: Element) -> &'static str {
        match (element, self.version) {
            (Element::Int8, _) => "char",
            (Element::UInt8, _) => "unsigned_char",
            (Element::Int16, _) => "short",
            (Element::UInt16, _) => "unsigned_short",
            (Element::Int32, _) => "int",
            (Element::UInt32, _) => "unsigned_int",
            // Readers of the older version know it by this name only.
            (Element::Int64, Version::V42) => "long",
            (Element::UInt64, Version::V42) => "unsigned_long",
            (Element::Int64, Version::V51) => "vtktypeint64",
            (Element::UInt64, Version::V51) => "vtktypeuint64",
            (Element::Float32, _) => "float",
            (Element::Float64, _) => "double",
            (Element::String, _) => "string",
        }
    }

    fn field(&mut self, arrays: &[Column]) -> Result<()> {
        if arrays.is_empty() {
            return Ok(());
        }
        self.text(&format!("FIELD FieldData {}\n", arrays.len()))?;
        for array in arrays {
            let name = encoded_name(array.name);
            let (n_components, n_tuples) = (array.n_components, array.n_tuples);
            let kind = self.type_name(array.element);
            self.text(&format!("{name} {n_components} {n_tuples} {kind}\n"))?;
            if array.element == Element::String {
                self.strings(array)?;
            } else {
                self.values(array)?;
            }
            if !array.component_names.is_empty() {
                self.component_names(array)?;
            }
        }
        Ok(())
    }

    fn component_names(&mut self, array: &Column) -> Result<()> {
        self.text("METADATA\nCOMPONENT_NAMES\n")?;
        for i in 0..array.n_components {
            let name = array.component_names.get(i).map_or("", String::as_str);
            self.text(&format!("{}\n", encoded(name)))?;
        }
        self.text("\n")
    }

    fn values(&mut self, array: &Column) -> Result<()> {
        if !self.binary {
            return ascii(array, self.out);
        }
        let size = array.element.size();
        let mut swapped = Vec::new();
        array.for_each(&mut |bytes| {
            for some in bytes.chunks(CHUNK * size) {
                swapped.clear();
                swapped.extend_from_slice(some);
                if cfg!(target_endian = "little") {
                    reverse_each(&mut swapped, size);
                }
                self.out.write_all(&swapped).map_err(failed)?;
            }
            Ok(())
        })?;
        self.text("\n")
    }

    /// Strings, which the content holds with a zero after each.
    fn strings(&mut self, array: &Column) -> Result<()> {
        let mut bytes = Vec::new();
        array.for_each(&mut |some| {
            bytes.extend_from_slice(some);
            Ok(())
        })?;
        for string in bytes.split_inclusive(|byte| *byte == 0) {
            let string = &string[..string.len() - 1];
            if self.binary {
                self.out.write_all(&length(string.len())).map_err(failed)?;
                self.out.write_all(string).map_err(failed)?;
            } else {
                self.text(&format!("{}\n", encoded(&decoded(string))))?;
            }
        }
        self.text("\n")
    }

    /// Types of cells, four bytes each.
    fn types(&mut self, types: &Column) -> Result<()> {
        self.text(&format!("CELL_TYPES {}\n", types.n_tuples))?;
        let mut out = Integers::new(self.out, self.binary, 4);
        types.for_each(&mut |bytes| bytes.iter().try_for_each(|vtk| out.push((*vtk).into())))?;
        out.finish()
    }

    fn cells(&mut self, mesh: &MeshView, plan: &VtkArrays) -> Result<()> {
        let old_order;
        let cells = match self.version {
            Version::V42 if mesh.cells.runs().any(|run| order::concerns(run.kind)) => {
                let mut arrays = mesh.cell_arrays.iter().copied();
                let degrees = arrays.find(|array| order::is_degrees(array));
                old_order = order::swapped(mesh.cells, degrees).0;
                &old_order
            }
            _ => mesh.cells,
        };
        let n_cells = plan.n_cells();
        let repeated = || plan.repeated.iter().map(|cell| cells.get(*cell));
        let all = || cells.iter().chain(repeated());
        let n_entries: usize = all().map(|cell| entries(cells, &cell).len()).sum();
        if self.version == Version::V42 {
            let size = n_entries + n_cells;
            self.text(&format!("CELLS {n_cells} {size}\n"))?;
            let mut out = Integers::new(self.out, self.binary, 4);
            for cell in all() {
                let entries = entries(cells, &cell);
                out.push(entries.len() as u64)?;
                out.nodes(cell.kind, entries)?;
                out.end_line();
            }
            return out.finish();
        }
        self.text(&format!(
            "CELLS {} {n_entries}\nOFFSETS vtktypeint64\n",
            n_cells + 1
        ))?;
        let mut out = Integers::new(self.out, self.binary, 8);
        let mut end = 0;
        out.push(0)?;
        for cell in all() {
            end += entries(cells, &cell).len() as u64;
            out.push(end)?;
        }
        out.finish()?;
        self.text("CONNECTIVITY vtktypeint64\n")?;
        let mut out = Integers::new(self.out, self.binary, 8);
        for cell in all() {
            out.nodes(cell.kind, entries(cells, &cell))?;
        }
        out.finish()
    }
}

/// Names of arrays; any can be encoded except none.
const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" => "unnamed".to_owned(),
        name => name.replace('\0', "_"),
    },
    why: "names in legacy VTK files have at least one character and no zero byte",
};

/// The name of an array; what readers take for something else is encoded.
fn encoded_name(name: &str) -> String {
    let is_keyword = name == "NULL_ARRAY" || name.eq_ignore_ascii_case("metadata");
    match name.as_bytes() {
        [first, ..] if is_keyword => format!("%{first:02X}{}", &name[1..]),
        _ => encoded(name),
    }
}

/// The entries of a cell in the list of cells: its nodes, or the face stream of a polyhedron.
fn entries<'c>(cells: &'c Cells, cell: &CellRef<'c>) -> &'c [u32] {
    match cell.kind {
        CellKind::Polyhedron => cells.face_stream(cell.index).unwrap_or(&[]),
        _ => cell.nodes,
    }
}

/// Writes integers one after another, as text or in 4 or 8 bytes.
struct Integers<'o> {
    out: &'o mut dyn Write,
    binary: bool,
    width: usize,
    bytes: Vec<u8>,
    in_line: usize,
}

impl<'o> Integers<'o> {
    fn new(out: &'o mut dyn Write, binary: bool, width: usize) -> Self {
        Self {
            out,
            binary,
            width,
            bytes: Vec::with_capacity(CHUNK * width + 64),
            in_line: 0,
        }
    }

    fn push(&mut self, value: u64) -> Result<()> {
        if self.binary {
            let bytes = &value.to_be_bytes()[8 - self.width..];
            self.bytes.extend_from_slice(bytes);
        } else {
            push_integer(&mut self.bytes, value);
            self.bytes.push(b' ');
            self.in_line += 1;
            if self.in_line == 16 {
                self.end_line();
            }
        }
        self.flush(CHUNK * self.width)
    }

    fn nodes(&mut self, kind: CellKind, entries: &[u32]) -> Result<()> {
        let listed = order::listed(kind, entries);
        listed.iter().try_for_each(|node| self.push((*node).into()))
    }

    fn end_line(&mut self) {
        if !self.binary && self.in_line > 0 {
            self.in_line = 0;
            self.bytes.pop();
            self.bytes.push(b'\n');
        }
    }

    fn flush(&mut self, at: usize) -> Result<()> {
        if self.bytes.len() >= at {
            self.out.write_all(&self.bytes).map_err(failed)?;
            self.bytes.clear();
        }
        Ok(())
    }

    fn finish(mut self) -> Result<()> {
        self.end_line();
        if self.binary {
            self.bytes.push(b'\n');
        }
        self.flush(0)
    }
}

/// Length of a string in a binary file: its first two bits say how many bytes it takes.
fn length(n: usize) -> Vec<u8> {
    let n = n as u64;
    match n {
        0..64 => vec![0xC0 | n as u8],
        64..16384 => (0x8000 | n as u16).to_be_bytes().to_vec(),
        16384..0x4000_0000 => (0x4000_0000 | n as u32).to_be_bytes().to_vec(),
        _ => n.to_be_bytes().to_vec(),
    }
}
