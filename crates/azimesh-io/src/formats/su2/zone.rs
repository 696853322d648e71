//! One zone of a file: its blocks of lines, found before any is parsed, and their nodes and cells.

use super::super::Notes;
use super::super::lexer::{Fields, Lexer, Lines};
use super::super::names::{Places, text_of};
use super::degree::Element;
use super::extra::{EXCHANGE, Extra};
use super::keyword::Keyword;
use crate::mesh::too_many;
use crate::mesh::{CellSet, Cells, Group, Mesh};
use azimesh_core::diagnostic::formats::{NotKept, Read};
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::ops::Range;

/// The blocks of a zone.
#[derive(Default)]
pub(super) struct Zone<'a> {
    /// Number of the zone in the file.
    pub number: Option<i32>,
    /// 2 or 3.
    pub dimension: Option<usize>,
    /// Byte at which the dimension is given.
    pub dimension_at: usize,
    /// Number of nodes that are not copies, where the file gives it.
    pub own_nodes: Option<i64>,
    /// Text that is kept as it stands, by [`Extra`].
    pub extra: [String; 4],
    /// Number of markers that the file promises.
    n_markers: Option<usize>,
    n_found: usize,
    points: Option<Lines<'a>>,
    /// Cells of the volume (no name) and of the markers, in the order of the file.
    cells: Vec<(Option<String>, Lines<'a>)>,
    has_volume: bool,
    /// A marker whose number of elements is still to come.
    marker: Option<String>,
}

/// The meaning of a keyword.
pub(super) enum Taken {
    /// A part of the mesh, with its block.
    Mesh,
    /// Text that is kept, with the lines that follow.
    Text(Extra),
    /// Nothing that is known here.
    Unknown,
}

impl<'a> Zone<'a> {
    /// Whether nodes, cells or markers have been found.
    pub fn has_begun(&self) -> bool {
        self.points.is_some() || self.has_volume || self.n_found > 0
    }

    /// Adds a line to a text that is kept.
    pub fn keep(&mut self, extra: Extra, line: &[u8], notes: &mut Notes) {
        let text = &mut self.extra[extra as usize];
        text.push_str(&text_of(line, notes));
        text.push('\n');
    }

    /// Takes a keyword and its block of lines.
    pub fn take(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Fields<'a>,
        lexer: &mut Lexer<'a>,
        notes: &mut Notes,
    ) -> Result<Taken> {
        match keyword.name {
            b"NDIME" => {
                let dimension = keyword.integer(line)?;
                if !matches!(dimension, 2 | 3) {
                    return Err(line.error(format!("NDIME= {dimension}; it is 2 or 3")));
                }
                self.dimension = Some(dimension as usize);
                self.dimension_at = lexer.position().saturating_sub(1);
            }
            b"NPOIN" => {
                if self.points.is_some() {
                    return Err(line.error("NPOIN appears twice"));
                }
                let n = keyword.count(line)?;
                self.own_nodes = keyword.integers()[1].filter(|own| *own != n as i64);
                self.points = Some(lexer.take_lines(n, "nodes")?);
            }
            b"NELEM" => {
                if self.has_volume {
                    return Err(line.error("NELEM appears twice"));
                }
                self.has_volume = true;
                let n = keyword.count(line)?;
                self.cells.push((None, lexer.take_lines(n, "cells")?));
            }
            b"NMARK" => self.n_markers = Some(keyword.count(line)?),
            b"MARKER_TAG" => {
                if keyword.value.is_empty() {
                    return Err(line.error("MARKER_TAG= has no name"));
                }
                self.marker = Some(text_of(keyword.value, notes));
            }
            b"MARKER_ELEMS" => self.take_marker(keyword, line, lexer, notes)?,
            _ => return Ok(Extra::of(keyword).map_or(Taken::Unknown, Taken::Text)),
        }
        Ok(Taken::Mesh)
    }

    /// Takes the elements of a marker; one that exchanges nodes is kept as text.
    fn take_marker(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Fields<'a>,
        lexer: &mut Lexer<'a>,
        notes: &mut Notes,
    ) -> Result<()> {
        let n = keyword.count(line)?;
        let name = self.marker.take();
        let name = name.ok_or_else(|| line.error("MARKER_ELEMS comes before its MARKER_TAG"))?;
        self.n_found += 1;
        if name != EXCHANGE {
            let elements = lexer.take_lines(n, "boundary elements")?;
            self.cells.push((Some(name), elements));
            return Ok(());
        }
        self.keep(
            Extra::Exchange,
            format!("MARKER_TAG= {name}").as_bytes(),
            notes,
        );
        self.keep(Extra::Exchange, line.rest(), notes);
        let next = lexer.peek_line();
        if let Some(next) = next.filter(|next| next.rest().starts_with(b"SEND_")) {
            self.keep(Extra::Exchange, next.rest(), notes);
            lexer.line();
        }
        let start = lexer.position();
        lexer.take_lines(n, "nodes that are exchanged")?;
        let mut nodes = Lexer::new(&lexer.bytes()[start..lexer.position()], Some(b'%'));
        while let Some(node) = nodes.line() {
            self.keep(Extra::Exchange, node.rest(), notes);
        }
        Ok(())
    }

    /// Refuses a zone without its parts, and notes markers that do not fit their number.
    pub fn check(&self, lexer: &Lexer, notes: &mut Notes) -> Result<()> {
        let missing = |what: &str| match self.number {
            Some(zone) => lexer.error(format!("zone {zone} has no {what}=")),
            None => lexer.error(format!("the file has no {what}=")),
        };
        if self.dimension.is_none() {
            return Err(missing("NDIME"));
        }
        if self.points.is_none() {
            return Err(missing("NPOIN"));
        }
        if !self.has_volume {
            return Err(missing("NELEM"));
        }
        if let Some(name) = &self.marker {
            return Err(lexer.error(format!("MARKER_TAG= {name} has no MARKER_ELEMS")));
        }
        self.note_repeated(notes);
        if let Some(n) = self.n_markers.filter(|n| *n != self.n_found) {
            notes.push(Read::MarkerCount {
                said: n,
                found: self.n_found,
            });
        }
        Ok(())
    }

    /// Notes markers of one name: they are one tag, as those of several zones are.
    fn note_repeated(&self, notes: &mut Notes) {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for name in self.cells.iter().filter_map(|(name, _)| name.as_deref()) {
            *counts.entry(name).or_default() += 1;
        }
        for (name, n) in counts.into_iter().filter(|(_, n)| *n > 1) {
            let name = name.to_owned();
            notes.push(Read::MarkersJoined { name, n });
        }
    }

    /// Appends the zone's nodes and cells to the mesh; the range of its volume cells.
    pub fn append_to(
        &self,
        mesh: &mut Mesh,
        markers: &mut Markers,
        notes: &mut Notes,
    ) -> Result<Range<usize>> {
        let dimension = self.dimension.expect("it was checked");
        let points = self.points.as_ref().expect("it was checked");
        let first_node = mesh.points.len();
        if first_node.saturating_add(points.len()) >= u32::MAX as usize {
            return Err(Error::input(too_many("nodes")));
        }
        mesh.points.resize(first_node + points.len(), [0.0; 3]);
        read_points(points, dimension, &mut mesh.points[first_node..])?;
        let nodes = first_node..mesh.points.len();
        let mut volume = 0..0;
        for (name, lines) in &self.cells {
            let first = mesh.cells.len();
            if first.saturating_add(lines.len()) >= u32::MAX as usize {
                return Err(Error::input(too_many("cells")));
            }
            let limit = Limit {
                dimension,
                marker: name.as_deref(),
            };
            append_cells(lines, &nodes, &limit, &mut mesh.cells, notes)?;
            match name {
                Some(name) => markers.add(mesh, name, first, dimension as u8 - 1),
                None => volume = first..mesh.cells.len(),
            }
        }
        Ok(volume)
    }
}

/// Coordinates, and after them perhaps the index of the node.
fn read_points(lines: &Lines, dimension: usize, points: &mut [[f64; 3]]) -> Result<()> {
    lines.parse_into(points, 1, |line, point| {
        for (i, x) in point[0][..dimension].iter_mut().enumerate() {
            if line.is_done() {
                return Err(line.error(format!("a node needs {dimension} coordinates, found {i}")));
            }
            *x = line.real("a coordinate")?;
        }
        Ok(())
    })
}

/// Cells of one task.
#[derive(Default)]
struct CellBatch {
    connectivity: Vec<u32>,
    runs: Vec<(Element, usize)>,
}

fn append_cells(
    lines: &Lines,
    nodes: &Range<usize>,
    limit: &Limit,
    cells: &mut Cells,
    notes: &mut Notes,
) -> Result<()> {
    let parts = lines.parse(|line, part| parse_cell(line, nodes, limit, part))?;
    cells.reserve(parts.iter().map(|part| part.connectivity.len()).sum());
    let mut n_solutions = 0;
    for mut part in parts {
        let mut rest = &mut part.connectivity[..];
        for (element, n_cells) in part.runs {
            let n_nodes = element.n_nodes();
            let (own, tail) = rest.split_at_mut(n_nodes * n_cells);
            if let Some(order) = element.order() {
                reorder(own, &order);
            }
            cells.push_run(element.kind(), n_nodes, own);
            n_solutions += n_cells * usize::from(element.has_solution);
            rest = tail;
        }
    }
    notes.count(n_solutions, |n| NotKept::Of {
        what: "degrees of the solution",
        n,
        item: "element",
    });
    Ok(())
}

/// Puts the nodes of each cell into VTK's order: node `i` is what was node `order[i]`.
fn reorder(cells: &mut [u32], order: &[usize]) {
    let mut old = vec![0; order.len()];
    for cell in cells.chunks_exact_mut(order.len()) {
        old.copy_from_slice(cell);
        for (node, &from) in cell.iter_mut().zip(order) {
            *node = old[from];
        }
    }
}

/// Which elements may be where: those of a marker have a lower dimension than the mesh.
struct Limit<'a> {
    dimension: usize,
    marker: Option<&'a str>,
}

impl Limit<'_> {
    fn check(&self, element: &Element) -> std::result::Result<(), String> {
        let below = usize::from(self.marker.is_some());
        let kind = element.kind();
        if usize::from(kind.dimension()) + below <= self.dimension {
            return Ok(());
        }
        let (kind, n) = (kind.name(), self.dimension);
        Err(match self.marker {
            Some(name) => format!("a {kind} cannot be on the boundary \"{name}\" with NDIME= {n}"),
            None => format!("a {kind} cannot be in a mesh with NDIME= {n}"),
        })
    }
}

/// Type, nodes, and perhaps the index of the cell.
fn parse_cell(
    line: &mut Fields,
    nodes: &Range<usize>,
    limit: &Limit,
    part: &mut CellBatch,
) -> Result<()> {
    let number = line.integer("an element type")?;
    let element = Element::of(number).map_err(|refusal| line.error(refusal))?;
    limit
        .check(&element)
        .map_err(|refusal| line.error(refusal))?;
    let n_nodes = element.n_nodes();
    let name = || element.kind().name();
    for i in 0..n_nodes {
        if line.is_done() {
            let name = name();
            return Err(line.error(format!("a {name} needs {n_nodes} node indices, found {i}")));
        }
        let node = line.integer("a node index")?;
        let known = usize::try_from(node).is_ok_and(|node| node < nodes.len());
        if !known {
            return Err(line.error(format!(
                "a {} has node {node}, but the mesh has {} nodes, counted from 0",
                name(),
                nodes.len()
            )));
        }
        part.connectivity.push((nodes.start + node as usize) as u32);
    }
    match part.runs.last_mut() {
        Some((last, n)) if *last == element => *n += 1,
        _ => part.runs.push((element, 1)),
    }
    Ok(())
}

/// The groups of the markers read so far, by dimension and name.
#[derive(Default)]
pub(super) struct Markers(Places<(u8, String)>);

impl Markers {
    /// Adds the cells from `first` on to the groups of this name, one for each dimension; an empty
    /// marker is one of `boundary`.
    fn add(&mut self, mesh: &mut Mesh, name: &str, first: usize, boundary: u8) {
        let runs = mesh.cells.runs_in(first..mesh.cells.len());
        let range = |first: usize, n: usize| first..first + n;
        let mut ranges: Vec<(u8, Range<usize>)> = runs
            .map(|run| (run.kind.dimension(), range(run.first_cell, run.n_cells())))
            .collect();
        if ranges.is_empty() {
            ranges.push((boundary, 0..0));
        }
        for (dimension, cells) in ranges {
            let new = || Group {
                dimension,
                name: name.to_owned(),
                number: None,
                condition: None,
                cells: CellSet::new(),
            };
            let key = (dimension, name.to_owned());
            let group = self.0.entry(key, &mut mesh.groups, new);
            group.cells.push_range(cells);
        }
    }
}
