//! Writing MSH 2.2 and 4.1, as text and little-endian binary. Version 4.1 has all nodes in one block of
//! the entity of highest dimension; 2.2 repeats a cell for each of its groups.

use super::super::names::{Rule, UniqueNames, cut};
use super::super::number::Chunk;
use super::super::records::{push_integer, push_real, write_all, write_records};
use super::super::{Encoding, Notes, WriteOptions};
use super::content::{Entity, MshContent, tag_range};
use super::data::MOST_COMPONENTS;
use crate::mesh::{DataArray, MeshView, Values};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::bounds::Bounds;
use azimesh_core::parallel::map_blocks;
use azimesh_core::{Note, note};
use std::io::Write;

/// Most values in one record: the tags of an element and its nodes.
const MOST_VALUES: usize = 1024;

/// Names of groups, without what would end them too early, and no longer than Gmsh reads.
pub(super) const NAME: Rule = Rule {
    longest: 127,
    fit: |name, longest| cut(&plain(name), longest),
    why: "names in MSH have at most 127 bytes, no quotes and no line ends",
};

const ARRAY: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| plain(name),
    why: "names in MSH have no quotes and no line ends",
};

fn plain(name: &str) -> String {
    name.replace(char::is_control, " ").replace('"', "'")
}

/// Writes the mesh in version 4.1 or 2.2; returns a note for each thing that is left out.
pub(super) fn write(
    mesh: &MeshView,
    out: &mut dyn Write,
    options: &WriteOptions,
    is_41: bool,
) -> Result<Notes> {
    let highest = if is_41 { i64::MAX } else { i32::MAX.into() };
    let mut content = MshContent::new(mesh, highest, i32::from(!is_41))?;
    let mut notes = Notes::default();
    if is_41 {
        notes.extend(content.drop_large_numbers(mesh));
        if content.entities.is_empty() {
            content.entities.push(Entity {
                dimension: 3,
                tag: 1,
                physicals: Vec::new(),
            });
        }
    }
    let numbers = Numbers::new(&content, is_41);
    if !is_41 && numbers.highest.max(mesh.points.len()) > i32::MAX as usize {
        return Err(Error::input(format!(
            "there are {} nodes and element numbers up to {}; MSH 2.2 holds numbers up to {}, MSH 4.1 larger ones",
            mesh.points.len(),
            numbers.highest,
            i32::MAX
        )));
    }
    let text = options.encoding == Encoding::Ascii;
    let mut sink = Sink { out, text, is_41 };
    sink.header()?;
    notes.extend(sink.physical_names(mesh, &content)?);
    if is_41 {
        sink.entities(mesh, &content)?;
    }
    sink.nodes(mesh, &content)?;
    sink.elements(mesh, &content, &numbers)?;
    let [point, cell] = content.data(mesh);
    let node_tag = |node: usize| content.node_tag(node as u32);
    sink.data("NodeData", point, node_tag, &mut notes)?;
    sink.data("ElementData", cell, |cell| numbers.of(cell), &mut notes)?;
    let format = "MSH";
    let names = mesh.field_arrays.iter().map(|array| array.name.clone());
    notes.of_arrays(format, "field", names.collect());
    notes.conditions_left_out(format, mesh);
    notes.in_64_bits(format, options);
    Ok(notes)
}

/// Numbers of the elements: those that the cells came with, and higher ones for a cell's copies in 2.2;
/// or counted in the order of the file.
struct Numbers<'a> {
    own: Option<&'a [i64]>,
    /// First cell and number of each block.
    stretches: Vec<[usize; 2]>,
    /// Number of the first copy of the first cell of each block. Copies of a block follow one another.
    copies: Vec<usize>,
    highest: usize,
}

impl<'a> Numbers<'a> {
    fn new(content: &'a MshContent, is_41: bool) -> Self {
        let own = content.cell_numbers.as_deref();
        let highest_own = own.and_then(|own| own.iter().max());
        let mut next = highest_own.map_or(1, |n| *n as usize + 1);
        let (mut stretches, mut copies): (Vec<[usize; 2]>, _) = (Vec::new(), Vec::new());
        for block in &content.blocks {
            let n = block.cells.len();
            if own.is_none() {
                stretches.push([block.cells.start, next]);
                next += n;
            }
            copies.push(next);
            if !is_41 {
                next += n * (content.physicals(block).len() - 1);
            }
        }
        Self {
            own,
            stretches,
            copies,
            highest: next - 1,
        }
    }

    /// Number of a cell's element.
    fn of(&self, cell: usize) -> u64 {
        if let Some(own) = self.own {
            return own[cell] as u64;
        }
        let at = self.stretches.partition_point(|[first, _]| *first <= cell) - 1;
        let [first, number] = self.stretches[at];
        (number + cell - first) as u64
    }
}

/// A number outside large arrays.
#[derive(Clone, Copy)]
enum Scalar {
    Int(i32),
    Size(usize),
    Real(f64),
}
use Scalar::{Int, Real, Size};

/// A file of either version and encoding.
struct Sink<'a> {
    out: &'a mut dyn Write,
    text: bool,
    is_41: bool,
}

impl Sink<'_> {
    /// Writes a line or several, in text and binary files alike.
    fn line(&mut self, line: &str) -> Result<()> {
        write_all(self.out, line.as_bytes())?;
        write_all(self.out, b"\n")
    }

    /// Writes numbers, as a line in text.
    fn row(&mut self, scalars: impl IntoIterator<Item = Scalar>) -> Result<()> {
        let mut bytes = Vec::new();
        for scalar in scalars {
            match (scalar, self.text) {
                (Int(value), true) => bytes.extend_from_slice(value.to_string().as_bytes()),
                (Size(value), true) => push_integer(&mut bytes, value as u64),
                (Real(value), true) => push_real(&mut bytes, value),
                (Int(value), false) => bytes.extend_from_slice(&value.to_le_bytes()),
                (Size(value), false) => bytes.extend_from_slice(&(value as u64).to_le_bytes()),
                (Real(value), false) => bytes.extend_from_slice(&value.to_le_bytes()),
            }
            if self.text {
                bytes.push(b' ');
            }
        }
        if self.text {
            bytes.pop();
            bytes.push(b'\n');
        }
        write_all(self.out, &bytes)
    }

    fn end_section(&mut self, name: &str) -> Result<()> {
        let line_end = if self.text { "" } else { "\n" };
        self.line(&format!("{line_end}$End{name}"))
    }

    fn header(&mut self) -> Result<()> {
        let version = if self.is_41 { "4.1" } else { "2.2" };
        let is_binary = u8::from(!self.text);
        self.line(&format!("$MeshFormat\n{version} {is_binary} 8"))?;
        if !self.text {
            self.row([Int(1)])?;
        }
        self.end_section("MeshFormat")
    }

    /// Writes `$PhysicalNames`. A nameless group goes without, unless it is empty: then the line is
    /// all that remains of it. Returns notes on names that had to change.
    fn physical_names(&mut self, mesh: &MeshView, content: &MshContent) -> Result<Vec<Note>> {
        let mut notes = Vec::new();
        let mut lines = Vec::new();
        let names: [_; 4] = std::array::from_fn(|dimension| {
            let groups = mesh.groups.iter();
            let here = groups.filter(|group| usize::from(group.dimension) == dimension);
            NAME.by_name(here.map(|group| group.name.as_str()))
        });
        for (group, number) in mesh.groups.iter().zip(&content.numbers) {
            if group.name == number.to_string() && !group.cells.is_empty() {
                continue;
            }
            if let Some(own) = group.number.filter(|own| own != number) {
                let name = &group.name;
                notes.push(note!(
                    "renumbered",
                    "group \"{name}\" gets number {number}: its own, {own}, is taken or not allowed in MSH"
                ));
            }
            let name = &names[usize::from(group.dimension)][group.name.as_str()];
            notes.extend(NAME.note("group", &group.name, name));
            lines.push(format!("{} {number} \"{name}\"", group.dimension));
        }
        if !lines.is_empty() {
            let n = lines.len();
            let lines = lines.join("\n");
            self.line(&format!("$PhysicalNames\n{n}\n{lines}\n$EndPhysicalNames"))?;
        }
        Ok(notes)
    }

    /// Writes `$Entities`: tag, position or box, physical groups, and no bounding entities.
    fn entities(&mut self, mesh: &MeshView, content: &MshContent) -> Result<()> {
        let of = |dimension: u8| {
            let entities = content.entities.iter().enumerate();
            entities.filter(move |(_, entity)| entity.dimension == dimension)
        };
        self.line("$Entities")?;
        self.row((0..4).map(|dimension| Size(of(dimension).count())))?;
        let bounds = bounds(mesh, content);
        for (i, entity) in (0..4).flat_map(of) {
            let Bounds { low, high } = bounds[i];
            let is_point = entity.dimension == 0;
            let mut row = vec![Int(entity.tag)];
            row.extend(low.map(Real));
            row.extend(high.into_iter().filter(|_| !is_point).map(Real));
            row.push(Size(entity.physicals.len()));
            row.extend(entity.physicals.iter().map(|number| Int(*number)));
            row.extend((!is_point).then_some(Size(0)));
            self.row(row)?;
        }
        self.end_section("Entities")
    }

    fn nodes(&mut self, mesh: &MeshView, content: &MshContent) -> Result<()> {
        let n = mesh.points.len();
        let &mut Self { text, is_41, .. } = self;
        self.line("$Nodes")?;
        if is_41 {
            let [lowest, highest] = tag_range(content.node_numbers.as_deref(), n);
            self.row([1, n, lowest, highest].map(Size))?;
            let home = content.entities.iter().max_by_key(|entity| {
                // The first of the highest dimension.
                (entity.dimension, std::cmp::Reverse(entity.tag))
            });
            let home = home.expect("there is one entity at least");
            self.row([Int(home.dimension.into()), Int(home.tag), Int(0), Size(n)])?;
            self.integers(n, 1, |i, tag| tag[0] = content.node_tag(i as u32))?;
        } else {
            self.line(&n.to_string())?;
        }
        write_records(self.out, n, &|range, buffer| {
            for i in range {
                if !is_41 {
                    push_tag(text, buffer, content.node_tag(i as u32));
                }
                push_reals(text, buffer, &mesh.points[i]);
            }
        })?;
        self.end_section("Nodes")
    }

    fn elements(&mut self, mesh: &MeshView, content: &MshContent, numbers: &Numbers) -> Result<()> {
        self.line("$Elements")?;
        if self.is_41 {
            let n = mesh.cells.len();
            let [lowest, highest] = tag_range(content.cell_numbers.as_deref(), n);
            self.row([content.blocks.len(), n, lowest, highest].map(Size))?;
        } else {
            let n_copies = |block| content.physicals(block).len();
            let sizes = content.blocks.iter().map(|b| b.cells.len() * n_copies(b));
            self.line(&sizes.sum::<usize>().to_string())?;
        }
        for (block, first_copy) in content.blocks.iter().zip(&numbers.copies) {
            let n = block.cells.len();
            let tag = content.entities[block.entity].tag;
            let (kind, of) = &content.types[block.of];
            let physicals = match content.physicals(block) {
                [first, ..] if self.is_41 => std::slice::from_ref(first),
                all => all,
            };
            for (copy, physical) in physicals.iter().enumerate() {
                // Integers between the number of an element and its nodes.
                let tags = match (self.is_41, self.text) {
                    (true, _) => {
                        let dimension = of.kind.dimension();
                        self.row([Int(dimension.into()), Int(tag), Int(*kind), Size(n)])?;
                        vec![]
                    }
                    (false, true) => vec![*kind, 2, *physical, tag],
                    (false, false) => {
                        self.row([*kind, n as i32, 2].map(Int))?;
                        vec![*physical, tag]
                    }
                };
                let front = 1 + tags.len();
                for run in mesh.cells.runs_in(block.cells.clone()) {
                    let own = numbers.own.filter(|_| copy == 0);
                    let first = if copy == 0 {
                        numbers.of(run.first_cell)
                    } else {
                        let start = run.first_cell - block.cells.start;
                        (first_copy + (copy - 1) * n + start) as u64
                    };
                    self.integers(run.n_cells(), front + run.n_nodes, |i, values| {
                        let number = || first + i as u64;
                        values[0] = own.map_or_else(number, |own| own[run.first_cell + i] as u64);
                        for (value, tag) in values[1..].iter_mut().zip(&tags) {
                            *value = *tag as u64;
                        }
                        let cell = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                        for (j, tag) in values[front..].iter_mut().enumerate() {
                            *tag = content.node_tag(cell[of.vtk(j)]);
                        }
                    })?;
                }
            }
        }
        self.end_section("Elements")
    }

    /// Writes many records of integers as lines or in binary, of 8 bytes each in version 4.1 and of 4 in
    /// 2.2: `record` puts record `i` into the slice of `n_values`.
    fn integers(
        &mut self,
        n: usize,
        n_values: usize,
        record: impl Fn(usize, &mut [u64]) + Sync,
    ) -> Result<()> {
        let &mut Self { text, is_41, .. } = self;
        let record_bytes = n_values * if is_41 { 8 } else { 4 };
        write_records(self.out, n, &|range, buffer| {
            let mut values = [0; MOST_VALUES];
            let values = &mut values[..n_values];
            if text {
                for i in range {
                    record(i, values);
                    for (at, value) in values.iter().enumerate() {
                        push_integer(buffer, *value);
                        buffer.push(if at + 1 < n_values { b' ' } else { b'\n' });
                    }
                }
                return;
            }
            buffer.resize(range.len() * record_bytes, 0);
            for (i, bytes) in range.zip(buffer.chunks_exact_mut(record_bytes)) {
                record(i, values);
                if is_41 {
                    put(bytes, values, u64::to_le_bytes);
                } else {
                    put(bytes, values, |x| (x as u32).to_le_bytes());
                }
            }
        })
    }

    /// Writes arrays of numbers as 64-bit reals; `tag` gives the tag of each node or element.
    fn data(
        &mut self,
        section: &str,
        arrays: Vec<&DataArray>,
        tag: impl Fn(usize) -> u64 + Sync,
        notes: &mut Notes,
    ) -> Result<()> {
        let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
        let names = UniqueNames::default().give_all(&names, &ARRAY);
        for (array, name) in arrays.into_iter().zip(names) {
            let own_name = &array.name;
            let n = array.n_components;
            let Some(values) = Chunk::of(&array.values) else {
                let note = note!(
                    "text_left_out",
                    "MSH holds no text; array \"{own_name}\" is left out"
                );
                notes.push(note.with("name", &**own_name));
                continue;
            };
            if n > MOST_COMPONENTS {
                notes.push(note!(
                    "too_many_components",
                    "array \"{own_name}\" is left out: it has {n} components; MSH holds at most {MOST_COMPONENTS}"
                ));
                continue;
            }
            notes.extend(ARRAY.note("array", &array.name, &name));
            if !all_are_exact(&array.values) {
                notes.push(note!(
                    "integers_rounded",
                    "array \"{own_name}\" has integers above 2^53, which MSH holds as the nearest 64-bit real"
                ));
            }
            let rows = match &array.values {
                Values::F32(values) => rows_of_numbers(values, n),
                Values::F64(values) => rows_of_numbers(values, n),
                _ => (0..array.n_tuples() as u32).collect(),
            };
            self.line(&format!(
                "${section}\n1\n\"{name}\"\n1\n0.0\n3\n0\n{n}\n{}",
                rows.len()
            ))?;
            let text = self.text;
            write_records(self.out, rows.len(), &|range, buffer| {
                let mut own = vec![0.0; n];
                for &row in &rows[range] {
                    let row = row as usize;
                    values.part(row * n..(row + 1) * n).few_reals(&mut own);
                    push_tag(text, buffer, tag(row));
                    push_reals(text, buffer, &own);
                }
            })?;
            self.end_section(section)?;
        }
        Ok(())
    }
}

fn put<const WIDTH: usize>(bytes: &mut [u8], values: &[u64], encode: impl Fn(u64) -> [u8; WIDTH]) {
    for (bytes, value) in bytes.chunks_exact_mut(WIDTH).zip(values) {
        bytes.copy_from_slice(&encode(*value));
    }
}

/// Appends a tag of 4 bytes, or the start of a line.
fn push_tag(text: bool, buffer: &mut Vec<u8>, tag: u64) {
    if text {
        push_integer(buffer, tag);
        buffer.push(b' ');
    } else {
        buffer.extend_from_slice(&(tag as i32).to_le_bytes());
    }
}

/// Appends reals, in text as the end of a line.
fn push_reals(text: bool, buffer: &mut Vec<u8>, values: &[f64]) {
    for (i, value) in values.iter().enumerate() {
        if text {
            push_real(buffer, *value);
            buffer.push(if i + 1 < values.len() { b' ' } else { b'\n' });
        } else {
            buffer.extend_from_slice(&value.to_le_bytes());
        }
    }
}

/// Rows with a number in them: rows of NaN have no value in the file.
#[allow(clippy::eq_op)] // only NaN differs from itself
fn rows_of_numbers<T: PartialEq>(values: &[T], n_components: usize) -> Vec<u32> {
    let rows = (0..).zip(values.chunks_exact(n_components));
    let numbers = rows.filter(|(_, row)| row.iter().any(|value| value == value));
    numbers.map(|(row, _)| row).collect()
}

fn all_are_exact(values: &Values) -> bool {
    const LARGEST: i64 = 1 << 53;
    match values {
        Values::I64(v) => v.iter().all(|x| (-LARGEST..=LARGEST).contains(x)),
        Values::U64(v) => v.iter().all(|x| *x <= LARGEST as u64),
        _ => true,
    }
}

/// Smallest and largest coordinates of each entity's cells; of all nodes where it has none, or all
/// cells of the mesh's own dimension.
fn bounds(mesh: &MeshView, content: &MshContent) -> Vec<Bounds> {
    let [low, high] = mesh.bounds().unwrap_or([[0.0; 3]; 2]);
    let dimensions = || content.entities.iter().map(|entity| entity.dimension);
    let of_mesh = mesh.dimension();
    let is_alone = dimensions().filter(|of| *of == of_mesh).count() == 1;
    let mut boxes = vec![Bounds::EMPTY; content.entities.len()];
    for block in &content.blocks {
        if is_alone && content.entities[block.entity].dimension == of_mesh {
            continue;
        }
        let known = &mut boxes[block.entity];
        for run in mesh.cells.runs_in(block.cells.clone()) {
            let parts = map_blocks(run.connectivity.len(), 1 << 16, &|entries| {
                let nodes = run.connectivity[entries].iter();
                Bounds::around(nodes.map(|node| &mesh.points[*node as usize]))
            });
            *known = parts.iter().fold(*known, Bounds::union);
        }
    }
    let empty = boxes.iter_mut().filter(|known| **known == Bounds::EMPTY);
    empty.for_each(|known| *known = Bounds { low, high });
    boxes
}
