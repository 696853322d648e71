//! Sections of elements of an unstructured zone, and which element is which cell.

use super::super::number::Chunk;
use super::builder::MeshBuilder;
use super::element::{
    self, ElementType, MIXED, NFACE_N, NGON_N, current_number, permute, type_name,
};
use super::node::Node;
use super::zone::Zone;
use crate::mesh::Values;
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

/// The cells of the elements of a section.
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

/// Of `n` numbers from `first` on the part that is in a range, counted from `first`.
pub(super) fn part(first: i64, n: usize, range: &Range<i64>) -> Range<usize> {
    let at = |number: i64| number.saturating_sub(first).clamp(0, n as i64) as usize;
    at(range.start)..at(range.end)
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
        sections.push(Section {
            node,
            element_type,
            first,
            n_elements: n as usize,
            n_boundary: data.get(1).map_or(0, |&n| usize::try_from(n).unwrap_or(0)),
        });
    }
    sections.sort_by_key(|section| section.first);
    for two in sections.windows(2) {
        let (before, after) = (two[0].range(), two[1].range());
        if after.start < before.end && !after.is_empty() {
            return Err(two[1].node.refuse(format!(
                "its elements have numbers {} to {}, and the elements of \"{}\" have {} to {}; no two elements may share a number",
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
        let (number, n) = (self.element_type, self.n_elements);
        if number == MIXED {
            found.cells.check_space(n)?;
            self.with_rows(1, |mut rows| {
                append_mixed((0..n, n), &mut rows, zone.version, &zone.nodes(), found)
            })?;
        } else if let Some(element) = ElementType::in_version(number, zone.version) {
            self.check_entries(element)?;
            found.cells.check_space(n)?;
            self.with_rows(element.n_nodes, |rows| {
                append_rows(element, rows, &zone.nodes(), found)
            })?;
        } else {
            let name = type_name(number);
            return Err((self.node).refuse(format!("elements of {name} are not known")));
        }
        Ok(self.span(Cells::From(first_cell)))
    }

    /// Its elements as these cells.
    pub fn span(&self, cells: Cells) -> Span {
        Span {
            first: self.first,
            n_elements: self.n_elements,
            cells,
        }
    }

    /// Refuses a section that does not have all nodes of its elements.
    fn check_entries(&self, element: ElementType) -> Result<()> {
        let node = self.node.need("ElementConnectivity")?;
        let data = node.data()?;
        let mut sizes = data.shape().iter();
        let n_entries = sizes.try_fold(1, |p: u64, n| p.checked_mul(*n));
        let expected = (self.n_elements as u64).saturating_mul(element.n_nodes as u64);
        if n_entries == Some(expected) {
            return Ok(());
        }
        Err(node.refuse(format!(
            "it has {} entries; it must have {expected} for {} of type {}",
            n_entries.unwrap_or(u64::MAX),
            counted(self.n_elements, "element"),
            element.name
        )))
    }

    /// Passes the entries of its connectivity to `append`, in blocks of whole elements of `n_nodes` nodes.
    fn with_rows(&self, n_nodes: usize, append: impl FnOnce(Rows) -> Result<()>) -> Result<()> {
        let node = self.node.need("ElementConnectivity")?;
        let data = node.data()?;
        let (rows, row) = (0..data.n_rows(), data.row().unwrap_or(1));
        data.check_rows(&rows).map_err(|e| node.refuse(e.message))?;
        let step = match data.shape() {
            [_] => data.whole_chunks(BLOCK).next_multiple_of(n_nodes as u64),
            _ => u64::MAX,
        };
        let appended = append(Rows::new(rows, (row as u64, step), &|rows| data.rows(rows)));
        appended.map_err(|e| node.refuse(e.message))
    }
}

/// Appends some of `n` elements that name their own type, each before its nodes, in a file of this version.
pub(super) fn append_mixed(
    (elements, n_elements): (Range<usize>, usize),
    entries: &mut Rows,
    version: f64,
    of_zone: &Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    let mut nodes: Vec<u32> = Vec::new();
    let mut of: Option<ElementType> = None;
    for i in elements {
        let first = entries.next(1)?.map_or(0, |number| number[0]);
        let number = current_number(first, version);
        let element = ElementType::in_version(number, version);
        if element != of || nodes.len() as u64 > BLOCK {
            flush(of, &mut nodes, found);
            of = element;
        }
        let left = entries.n_left();
        let numbers = element.map_or(Ok(None), |element| entries.next(element.n_nodes))?;
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
    }
    flush(of, &mut nodes, found);
    Ok(())
}

/// Appends elements of one type.
pub(super) fn append_rows(
    element: ElementType,
    mut entries: Rows,
    of_zone: &Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    let order = element.vtk_from_cgns();
    while let Some(block) = entries.next_block()? {
        let mut nodes = indices_in(of_zone, &block).map_err(Error::input)?;
        if let Some(order) = &order {
            permute(&mut nodes, order);
        }
        push(element, &nodes, found);
    }
    Ok(())
}

/// Rows of entries of a dataset, with one block in memory at a time.
pub(super) struct Rows<'a> {
    /// Rows that were not read.
    rows: Range<u64>,
    /// Entries of a row, and rows of a block.
    sizes: (u64, u64),
    read: &'a dyn Fn(Range<u64>) -> Result<Values>,
    block: Vec<i64>,
    /// Entries of the block that were given.
    given: usize,
}

impl<'a> Rows<'a> {
    /// The rows that `read` gives; `sizes` are the entries of a row and the rows of a block.
    pub fn new(
        rows: Range<u64>,
        sizes: (u64, u64),
        read: &'a dyn Fn(Range<u64>) -> Result<Values>,
    ) -> Self {
        Self {
            rows,
            sizes,
            read,
            block: Vec::new(),
            given: 0,
        }
    }

    fn next_block(&mut self) -> Result<Option<Values>> {
        if self.rows.is_empty() {
            return Ok(None);
        }
        let start = self.rows.start;
        self.rows.start = start.saturating_add(self.sizes.1).min(self.rows.end);
        (self.read)(start..self.rows.start).map(Some)
    }

    /// The next `n` entries; `None` where there are less.
    fn next(&mut self, n: usize) -> Result<Option<&[i64]>> {
        while self.block.len() - self.given < n
            && let Some(block) = self.next_block()?
        {
            let numbers = block.to_integers();
            let refused = || Error::input("node numbers must be integers");
            self.block.drain(..self.given);
            self.given = 0;
            self.block.append(&mut numbers.ok_or_else(refused)?);
        }
        let start = self.given;
        if self.block.len() - start < n {
            return Ok(None);
        }
        self.given += n;
        Ok(Some(&self.block[start..self.given]))
    }

    /// Number of entries left.
    pub fn n_left(&self) -> u64 {
        let rows = self.rows.end - self.rows.start;
        (self.block.len() - self.given) as u64 + rows.saturating_mul(self.sizes.0)
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
    let corners = nodes.chunks_exact(element.n_nodes);
    let n = element.kind.n_nodes().unwrap_or(element.n_nodes);
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

/// The node index of the mesh for one node number of a zone with these nodes; or why there is none.
fn index_in(of_zone: &Range<usize>, number: i64) -> std::result::Result<u32, String> {
    let n = of_zone.len();
    match usize::try_from(number) {
        Ok(number) if (1..=n).contains(&number) => Ok((number - 1 + of_zone.start) as u32),
        _ => Err(not_of_zone(number, n)),
    }
}

pub(super) fn not_of_zone(number: impl Display, n: usize) -> String {
    format!("it has node {number}; the zone has nodes 1 to {n}")
}

/// Tests if a section's name only says what its elements are: an element type, or of cells their
/// shape in any words.
pub(super) fn says_nothing(name: &str, of_cells: bool) -> bool {
    const SHAPES: [&str; 14] = [
        "HEX", "TET", "PYR", "PRISM", "PENTA", "WEDGE", "TRI", "QUAD", "POLY", "ELEM", "CELL",
        "SECTION", "MIXED", "NFACE",
    ];
    let upper = name.to_ascii_uppercase();
    // "NODE" is part of other words too.
    let end = upper
        .strip_prefix("NODE")
        .map(|end| end.strip_prefix('_').unwrap_or(end));
    if end.is_some_and(|end| end.bytes().all(|byte| byte.is_ascii_digit())) {
        return true;
    }
    let has = |word: &str| upper.contains(word);
    element::names().any(has) || (of_cells && SHAPES.iter().copied().any(has))
}
