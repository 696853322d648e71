//! Sections of elements of an unstructured zone, and which element is which cell.

use super::super::vtk::chunk::Chunk;
use super::builder::MeshBuilder;
use super::element::{
    self, ElementType, MIXED, NFACE_N, NGON_N, current_number, old_polygon, permute, type_name,
};
use super::node::Node;
use super::zone::Zone;
use crate::mesh::{CellKind, Values};
use azimesh_core::error::{Error, Result, counted};
use std::fmt::Display;
use std::ops::Range;

/// Node indices taken from the file at a time: what stays near the processor.
pub(super) const BLOCK: u64 = 1 << 18;

/// A section before its elements are read.
pub(super) struct Section<'a> {
    pub node: &'a Node,
    /// Number of the element type.
    pub element_type: i64,
    /// Number of its first element.
    pub first: i64,
    pub n_elements: usize,
    /// Number of boundary elements at the start of the section, where the file gives it.
    pub n_boundary: usize,
}

/// Which cells the elements of a section became.
pub(super) struct Span {
    pub first: i64,
    pub n_elements: usize,
    pub cells: Cells,
}

/// Cells of a section.
pub(super) enum Cells {
    /// Consecutive ones from this on.
    From(usize),
    /// For each element its cell, or `u32::MAX` for a face inside.
    Each(Vec<u32>),
}

/// The sections of a zone in the order of their elements.
pub(super) fn sections<'a>(zone: &Zone<'a>) -> Result<Vec<Section<'a>>> {
    let mut sections = Vec::new();
    for node in zone.node.labelled("Elements_t")? {
        let data = node.integers()?;
        let range = node.need("ElementRange")?.integers()?;
        let element_type = data.first().map(|&n| current_number(n, zone.version));
        let (Some(element_type), &[first, last]) = (element_type, &range[..]) else {
            return Err(
                node.refuse("it must have an element type and an ElementRange of two numbers")
            );
        };
        let n = last.checked_sub(first).and_then(|n| n.checked_add(1));
        let n = n.filter(|n| first >= 1 && (0..i64::from(u32::MAX)).contains(n));
        let Some(n) = n else {
            return Err(node.refuse(format!(
                "its ElementRange is {first} to {last}; it must start at 1 or higher and must not end before it starts"
            )));
        };
        let n_boundary = data.get(1).map_or(0, |&n| usize::try_from(n).unwrap_or(0));
        sections.push(Section {
            node,
            element_type,
            first,
            n_elements: n as usize,
            n_boundary,
        });
    }
    sections.sort_by_key(|section| section.first);
    for two in sections.windows(2) {
        let (before, after) = (two[0].range(), two[1].range());
        if after.start < before.end && !after.is_empty() {
            return Err(two[1].node.refuse(format!(
                "its elements have numbers {} to {}, those of \"{}\" have {} to {}; no two elements may share a number",
                after.start,
                after.end - 1,
                two[0].node.name(),
                before.start,
                before.end - 1
            )));
        }
    }
    Ok(sections)
}

impl Section<'_> {
    /// Dimension of its elements; `None` for MIXED sections.
    pub fn dimension(&self) -> Option<u8> {
        match self.element_type {
            NGON_N => Some(2),
            NFACE_N => Some(3),
            other => Some(ElementType::from_number(other)?.kind.dimension()),
        }
    }

    /// The numbers of its elements.
    pub fn range(&self) -> Range<i64> {
        self.first..self.first.saturating_add(self.n_elements as i64)
    }

    /// Appends its elements to the cells. NGON_n and NFACE_n are for `polyhedra` to read.
    pub fn read(&self, zone: &Zone, found: &mut MeshBuilder) -> Result<Span> {
        let first_cell = found.cells.len();
        match self.element_type {
            MIXED => self.read_mixed(zone, found)?,
            number if old_polygon(number, zone.version).is_some() => {
                self.read_old_polygons(zone, found)?;
            }
            number => {
                let element = ElementType::from_number(number).ok_or_else(|| {
                    let name = type_name(number);
                    self.node
                        .refuse(format!("elements of {name} are not known"))
                })?;
                self.read_fixed(element, zone, found)?;
            }
        }
        Ok(Span {
            first: self.first,
            n_elements: self.n_elements,
            cells: Cells::From(first_cell),
        })
    }

    fn read_fixed(&self, element: ElementType, zone: &Zone, found: &mut MeshBuilder) -> Result<()> {
        let node = self.node.need("ElementConnectivity")?;
        let data = node.data()?;
        let n_entries: Option<u64> = data
            .shape()
            .iter()
            .try_fold(1, |p: u64, n| p.checked_mul(*n));
        let expected = self.n_elements as u64 * element.n_nodes as u64;
        if n_entries != Some(expected) {
            return Err(node.refuse(format!(
                "it has {} entries; it must have {expected} for {} of type {}",
                n_entries.unwrap_or(u64::MAX),
                counted(self.n_elements, "element"),
                element.name
            )));
        }
        found.check_room(self.n_elements)?;
        let step = match data.shape() {
            [_] => data
                .whole_chunks(BLOCK)
                .next_multiple_of(element.n_nodes as u64),
            _ => u64::MAX,
        };
        let rows = 0..data.n_rows();
        data.check_rows(&rows).map_err(|e| node.refuse(e.message))?;
        let read = |rows| data.rows(rows);
        append_rows(element, (rows, step), &read, &zone.nodes(), found)
            .map_err(|e| node.refuse(e.message))
    }

    /// Polygons with one number of nodes, given by the element type.
    fn read_old_polygons(&self, zone: &Zone, found: &mut MeshBuilder) -> Result<()> {
        let n = old_polygon(self.element_type, zone.version).expect("the type was checked");
        let node = self.node.need("ElementConnectivity")?;
        let nodes = node_indices(&node.values()?, node, zone)?;
        if Some(nodes.len()) != n.checked_mul(self.n_elements) {
            return Err(node.refuse(format!(
                "it has {} entries, which are not {n} nodes for each of {} polygons",
                nodes.len(),
                self.n_elements
            )));
        }
        found.check_room(self.n_elements)?;
        found.cells.push_run(CellKind::Polygon, n, &nodes);
        Ok(())
    }

    fn read_mixed(&self, zone: &Zone, found: &mut MeshBuilder) -> Result<()> {
        let node = self.node.need("ElementConnectivity")?;
        let data = node.data()?;
        let rows = 0..data.n_rows();
        data.check_rows(&rows).map_err(|e| node.refuse(e.message))?;
        let row = data.row().unwrap_or(1) as u64;
        let step = match data.shape() {
            [_] => data.whole_chunks(BLOCK),
            _ => u64::MAX,
        };
        found.check_room(self.n_elements)?;
        let read = |rows| data.rows(rows);
        let mut entries = Entries::new(rows, row, step, &read);
        let elements = (0..self.n_elements, self.n_elements);
        append_mixed(elements, &mut entries, zone.version, &zone.nodes(), found)
            .map_err(|e| node.refuse(e.message))
    }
}

/// Appends some of `n` elements that name their own type, each before its nodes, in a file of this version.
pub(super) fn append_mixed(
    (elements, n_elements): (Range<usize>, usize),
    entries: &mut Entries,
    version: f64,
    of_zone: &Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    let mut nodes: Vec<u32> = Vec::new();
    let mut of: Option<ElementType> = None;
    for i in elements {
        let first = entries.next(1)?.map_or(0, |number| number[0]);
        let number = current_number(first, version);
        let polygon = old_polygon(number, version);
        let element = ElementType::from_number(number).filter(|_| polygon.is_none());
        if element != of || nodes.len() as u64 > BLOCK {
            flush(of, &mut nodes, found);
            of = element;
        }
        let n = polygon.or(element.map(|element| element.n_nodes));
        let left = entries.n_left();
        let numbers = n.map_or(Ok(None), |n| entries.next(n))?;
        let Some(numbers) = numbers else {
            return Err(Error::input(format!(
                "element {} of {n_elements} has type {}, which is not known or needs more than the {left} entries that are left",
                i + 1,
                type_name(number),
            )));
        };
        for &number in numbers {
            nodes.push(index_in(of_zone, number).map_err(Error::input)?);
        }
        if polygon.is_some() {
            found.cells.push(CellKind::Polygon, &nodes);
            nodes.clear();
        }
    }
    flush(of, &mut nodes, found);
    Ok(())
}

/// Appends elements of one type, whose nodes are in rows that `read` gives, `step` rows at a time.
pub(super) fn append_rows(
    element: ElementType,
    (rows, step): (Range<u64>, u64),
    read: &dyn Fn(Range<u64>) -> Result<Values>,
    of_zone: &Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    let order = element.vtk_from_cgns();
    let mut start = rows.start;
    while start < rows.end {
        let end = start.saturating_add(step).min(rows.end);
        let mut nodes = indices_in(of_zone, &read(start..end)?).map_err(Error::input)?;
        if let Some(order) = &order {
            permute(&mut nodes, order);
        }
        push(element, &nodes, found);
        start = end;
    }
    Ok(())
}

/// The entries of a dataset, of which a block at a time is in memory.
pub(super) struct Entries<'a> {
    /// Gives rows.
    read: &'a dyn Fn(Range<u64>) -> Result<Values>,
    /// Rows that were not read.
    rows: Range<u64>,
    /// Entries of a row.
    row: u64,
    /// Rows of a block.
    step: u64,
    block: Vec<i64>,
    /// Entries of the block that were given.
    given: usize,
}

impl<'a> Entries<'a> {
    /// The entries in rows of `row` entries, which `read` gives, `step` rows at a time.
    pub fn new(
        rows: Range<u64>,
        row: u64,
        step: u64,
        read: &'a dyn Fn(Range<u64>) -> Result<Values>,
    ) -> Self {
        Self {
            read,
            rows,
            row,
            step,
            block: Vec::new(),
            given: 0,
        }
    }

    /// The next `n` entries; `None` where there are less.
    fn next(&mut self, n: usize) -> Result<Option<&[i64]>> {
        while self.block.len() - self.given < n && !self.rows.is_empty() {
            let end = self.rows.start.saturating_add(self.step).min(self.rows.end);
            let numbers = (self.read)(self.rows.start..end)?.to_integers();
            let refused = || Error::input("node numbers must be integers");
            self.block.drain(..self.given);
            self.given = 0;
            self.block.append(&mut numbers.ok_or_else(refused)?);
            self.rows.start = end;
        }
        let start = self.given;
        if self.block.len() - start < n {
            return Ok(None);
        }
        self.given += n;
        Ok(Some(&self.block[start..self.given]))
    }

    /// How many are left.
    pub fn n_left(&self) -> u64 {
        let rows = self.rows.end - self.rows.start;
        (self.block.len() - self.given) as u64 + rows.saturating_mul(self.row)
    }
}

/// Appends elements of one type gathered from a MIXED section.
fn flush(element: Option<ElementType>, nodes: &mut Vec<u32>, found: &mut MeshBuilder) {
    if let Some(element) = element {
        if let Some(order) = element.vtk_from_cgns() {
            permute(nodes, &order);
        }
        push(element, nodes, found);
    }
    nodes.clear();
}

/// Appends elements whose nodes are in VTK's order. Of one that VTK does not have, the corners.
fn push(element: ElementType, nodes: &[u32], found: &mut MeshBuilder) {
    if element.is_kept() {
        found.cells.push_run(element.kind, element.n_nodes, nodes);
        return;
    }
    let n = element.n_kept();
    let corners = nodes.chunks_exact(element.n_nodes);
    let corners: Vec<u32> = corners.flat_map(|nodes| &nodes[..n]).copied().collect();
    found.cells.push_run(element.kind, n, &corners);
    *found.incomplete.entry(element.name).or_default() += nodes.len() / element.n_nodes;
}

/// Node indices of the mesh for the node numbers of a zone.
pub(super) fn node_indices(values: &Values, node: &Node, zone: &Zone) -> Result<Vec<u32>> {
    indices_in(&zone.nodes(), values).map_err(|message| node.refuse(message))
}

/// Node indices of the mesh for the node numbers of a zone with these nodes; or why there are none.
fn indices_in(of_zone: &Range<usize>, values: &Values) -> std::result::Result<Vec<u32>, String> {
    let is_number = |chunk: &Chunk| chunk.element.is_integer() && chunk.element.size() >= 4;
    let numbers = Chunk::of(values).filter(is_number);
    let numbers = numbers.ok_or("node numbers must be integers of 4 or 8 bytes")?;
    let mut indices = vec![0; numbers.n_values()];
    let n = of_zone.len();
    let found = numbers.indices(&mut indices, (1, n as u64), of_zone.start as u32);
    found.map_err(|(_, number)| not_of_zone(number, n))?;
    Ok(indices)
}

/// The node index of the mesh for one node number of a zone.
pub(super) fn node_index(number: i64, node: &Node, zone: &Zone) -> Result<u32> {
    index_in(&zone.nodes(), number).map_err(|message| node.refuse(message))
}

/// The node index of the mesh for one node number of a zone with these nodes; or why there is none.
fn index_in(of_zone: &Range<usize>, number: i64) -> std::result::Result<u32, String> {
    let n = of_zone.len();
    match usize::try_from(number) {
        Ok(number) if (1..=n).contains(&number) => Ok((number - 1 + of_zone.start) as u32),
        _ => Err(not_of_zone(number, n)),
    }
}

pub(super) fn outside(number: impl Display, node: &Node, n: usize) -> Error {
    node.refuse(not_of_zone(number, n))
}

fn not_of_zone(number: impl Display, n: usize) -> String {
    format!("it has node {number}; the zone has nodes 1 to {n}")
}

/// Whether a section's name only says what its elements are: an element type, or of cells their
/// shape in any words.
pub(super) fn says_nothing(name: &str, of_cells: bool) -> bool {
    const SHAPES: [&str; 14] = [
        "HEX", "TET", "PYR", "PRISM", "PENTA", "WEDGE", "TRI", "QUAD", "POLY", "ELEM", "CELL",
        "SECTION", "MIXED", "NFACE",
    ];
    let upper = name.to_ascii_uppercase();
    // "NODE" stands in other words too.
    let end = upper
        .strip_prefix("NODE")
        .map(|end| end.strip_prefix('_').unwrap_or(end));
    if end.is_some_and(|end| end.bytes().all(|byte| byte.is_ascii_digit())) {
        return true;
    }
    let has = |word: &str| upper.contains(word);
    element::names().any(has) || (of_cells && SHAPES.iter().copied().any(has))
}
