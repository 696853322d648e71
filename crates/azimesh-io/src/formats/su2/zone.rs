//! One zone of a file: its blocks of lines, found before any is parsed, and their nodes and cells.

use super::super::Notes;
use super::super::names::{Places, text_of};
use super::super::tokens::{Lines, Tokens};
use super::degree::Element;
use super::read::{Block, Keyword};
use super::{EXCHANGE, Extra};
use crate::mesh::{CellSet, Cells, Group, Mesh, too_many};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use std::collections::BTreeMap;
use std::ops::Range;

#[derive(Default)]
pub(super) struct Zone<'a> {
    pub number: Option<i32>,
    pub dimension: Option<usize>,
    /// Byte at which the dimension is given.
    pub dimension_at: usize,
    /// Number of nodes that are not copies, where the file gives it.
    pub own_nodes: Option<i64>,
    /// Text that is kept unchanged, by [`Extra`].
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

impl<'a> Zone<'a> {
    /// Checks if nodes, cells or markers have been found.
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
        line: &Tokens<'a>,
        lexer: &mut Tokens<'a>,
        notes: &mut Notes,
    ) -> Result<Block> {
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
            name => {
                let Some(extra) = Extra::of(name) else {
                    return Ok(Block::Unknown(keyword.name()));
                };
                self.keep(extra, line.rest(), notes);
                return Ok(Block::Text(extra));
            }
        }
        Ok(Block::None)
    }

    /// Takes the elements of a marker; one that exchanges nodes is kept as text.
    fn take_marker(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Tokens<'a>,
        lexer: &mut Tokens<'a>,
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
        let mut keep = |line: &[u8]| self.keep(Extra::Exchange, line, notes);
        keep(format!("MARKER_TAG= {name}").as_bytes());
        keep(line.rest());
        let next = lexer.peek_line();
        if let Some(next) = next.filter(|next| next.rest().starts_with(b"SEND_")) {
            keep(next.rest());
            lexer.line();
        }
        let start = lexer.position();
        lexer.take_lines(n, "nodes that are exchanged")?;
        let mut nodes = Tokens::with_comments(&lexer.bytes()[start..lexer.position()]);
        while let Some(node) = nodes.line() {
            keep(node.rest());
        }
        Ok(())
    }

    /// Refuses a zone without its parts; notes markers of one name, which are one tag, and a wrong number of markers.
    pub fn check(&self, lexer: &Tokens, notes: &mut Notes) -> Result<()> {
        for (what, is_there) in [
            ("NDIME", self.dimension.is_some()),
            ("NPOIN", self.points.is_some()),
            ("NELEM", self.has_volume),
        ] {
            if !is_there {
                let zone = self.number.map(|zone| format!("zone {zone}"));
                let zone = zone.as_deref().unwrap_or("the file");
                return Err(lexer.error(format!("{zone} has no {what}=")));
            }
        }
        if let Some(name) = &self.marker {
            return Err(lexer.error(format!("MARKER_TAG= {name} has no MARKER_ELEMS")));
        }
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for name in self.cells.iter().filter_map(|(name, _)| name.as_deref()) {
            *counts.entry(name).or_default() += 1;
        }
        for (name, n) in counts.into_iter().filter(|(_, n)| *n > 1) {
            notes.push(note!(
                "markers_joined",
                "{n} markers are called \"{name}\"; they become one tag"
            ));
        }
        if let Some(n) = self.n_markers.filter(|n| *n != self.n_found) {
            let found = counted(self.n_found, "marker");
            notes.push(note!(
                "marker_count",
                "NMARK= {n}, but the file has {found}; all are read"
            ));
        }
        Ok(())
    }

    /// Appends the zone's nodes and cells to the mesh; the range of its volume cells.
    pub fn append_to(
        &self,
        mesh: &mut Mesh,
        markers: &mut Places<(u8, String)>,
        notes: &mut Notes,
    ) -> Result<Range<usize>> {
        let dimension = self.dimension.expect("it was checked");
        let points = self.points.as_ref().expect("it was checked");
        let first_node = mesh.points.len();
        if first_node.saturating_add(points.len()) >= u32::MAX as usize {
            return Err(Error::input(too_many("nodes")));
        }
        mesh.points.resize(first_node + points.len(), [0.0; 3]);
        // After the coordinates, a line may have the index of the node.
        points.parse_into(&mut mesh.points[first_node..], 1, |line, _, point| {
            for (i, x) in point[0][..dimension].iter_mut().enumerate() {
                if line.is_done() {
                    let message = format!("a node needs {dimension} coordinates, found {i}");
                    return Err(line.error(message));
                }
                *x = line.real("a coordinate")?;
            }
            Ok(())
        })?;
        let nodes = first_node..mesh.points.len();
        let mut volume = 0..0;
        for (name, lines) in &self.cells {
            let first = mesh.cells.len();
            if first.saturating_add(lines.len()) >= u32::MAX as usize {
                return Err(Error::input(too_many("cells")));
            }
            let marker = name.as_deref();
            let parts =
                lines.parse(|line, part| parse_cell(line, &nodes, dimension, marker, part))?;
            append_cells(parts, &mut mesh.cells, notes);
            match name {
                Some(name) => add_marker(mesh, markers, name, first, dimension as u8 - 1),
                None => volume = first..mesh.cells.len(),
            }
        }
        Ok(volume)
    }
}

#[derive(Default)]
struct CellBatch {
    connectivity: Vec<u32>,
    runs: Vec<(Element, usize)>,
}

/// Appends cells, with their nodes in VTK's order.
fn append_cells(parts: Vec<CellBatch>, cells: &mut Cells, notes: &mut Notes) {
    cells.reserve(parts.iter().map(|part| part.connectivity.len()).sum());
    let mut n_solutions = 0;
    for mut part in parts {
        let mut rest = &mut part.connectivity[..];
        for (element, n_cells) in part.runs {
            let n_nodes = element.n_nodes();
            let (own, tail) = rest.split_at_mut(n_nodes * n_cells);
            if let Some(order) = element.order() {
                let mut old = vec![0; n_nodes];
                for cell in own.chunks_exact_mut(n_nodes) {
                    old.copy_from_slice(cell);
                    for (node, &from) in cell.iter_mut().zip(&order) {
                        *node = old[from];
                    }
                }
            }
            cells.push_run(element.kind(), n_nodes, own);
            n_solutions += n_cells * usize::from(element.has_solution);
            rest = tail;
        }
    }
    notes.count(n_solutions, |n| {
        let n = counted(n, "element");
        note!(
            "solution_degrees",
            "degrees of the solution of {n} are not kept"
        )
    });
}

/// Type, nodes, and perhaps the index of the cell. Cells of a marker have a lower dimension than the mesh.
fn parse_cell(
    line: &mut Tokens,
    nodes: &Range<usize>,
    dimension: usize,
    marker: Option<&str>,
    part: &mut CellBatch,
) -> Result<()> {
    let number = line.integer("an element type")?;
    let element = Element::of(number).map_err(|refusal| line.error(refusal))?;
    let kind = element.kind();
    if usize::from(kind.dimension()) + usize::from(marker.is_some()) > dimension {
        let kind = kind.name();
        let boundary = marker.map(|name| format!("on the boundary \"{name}\""));
        let place = boundary.as_deref().unwrap_or("in a mesh");
        return Err(line.error(format!(
            "a {kind} cannot be {place} with NDIME= {dimension}"
        )));
    }
    let n_nodes = element.n_nodes();
    for i in 0..n_nodes {
        if line.is_done() {
            let kind = kind.name();
            return Err(line.error(format!("a {kind} needs {n_nodes} node indices, found {i}")));
        }
        let node = line.integer("a node index")?;
        if !usize::try_from(node).is_ok_and(|node| node < nodes.len()) {
            let (kind, n) = (kind.name(), nodes.len());
            return Err(line.error(format!(
                "a {kind} has node {node}, but the mesh has {n} nodes, counted from 0"
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

/// Adds the cells from `first` on to the groups of this name, one for each dimension; an empty marker has the dimension
/// `boundary`.
fn add_marker(
    mesh: &mut Mesh,
    markers: &mut Places<(u8, String)>,
    name: &str,
    first: usize,
    boundary: u8,
) {
    let runs = mesh.cells.runs_in(first..mesh.cells.len());
    let ranges = runs.map(|run| (run.kind.dimension(), run.range()));
    let mut ranges: Vec<(u8, Range<usize>)> = ranges.collect();
    if ranges.is_empty() {
        ranges.push((boundary, 0..0));
    }
    for (dimension, cells) in ranges {
        let new = || Group::new(dimension, name, None, CellSet::new());
        let group = markers.entry((dimension, name.to_owned()), &mut mesh.groups, new);
        group.cells.push_range(cells);
    }
}
