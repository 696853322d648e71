//! Reading SU2: keywords with a value, some followed by a block of lines, in any order.

use super::super::lexer::{Fields, Lexer, Lines, shown};
use super::holds;
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Cells, Group, Mesh};

/// Whether the first line that is no comment sets one of the keywords that start a mesh.
pub(super) fn recognizes(head: &[u8]) -> bool {
    let mut lexer = Lexer::new(head, Some(b'%'));
    let line = lexer.line();
    let keyword = line.and_then(|line| Keyword::of(&line));
    keyword.is_some_and(|keyword| {
        matches!(
            keyword.name,
            b"NDIME" | b"NZONE" | b"NELEM" | b"NPOIN" | b"NMARK"
        )
    })
}

/// A line `NAME= value`.
struct Keyword<'a> {
    name: &'a [u8],
    value: &'a [u8],
}

impl<'a> Keyword<'a> {
    fn of(line: &Fields<'a>) -> Option<Self> {
        let text = line.rest();
        let at = memchr::memchr(b'=', text)?;
        Some(Self {
            name: text[..at].trim_ascii(),
            value: text[at + 1..].trim_ascii(),
        })
    }

    /// The first integer of the value.
    fn integer(&self, line: &Fields) -> Result<i64> {
        let name = self.name.escape_ascii();
        let number = Lexer::new(self.value, None)
            .line()
            .and_then(|mut value| value.integer("").ok());
        number.ok_or_else(|| {
            let found = shown(self.value);
            line.error(format!("{name}= needs an integer, found {found}"))
        })
    }

    fn count(&self, line: &Fields) -> Result<usize> {
        let value = self.integer(line)?;
        usize::try_from(value).map_err(|_| {
            let name = self.name.escape_ascii();
            line.error(format!("{name}= {value}, a count cannot be negative"))
        })
    }
}

/// The blocks of a file, found before any is parsed: nodes may come before the dimension.
#[derive(Default)]
struct Blocks<'a> {
    dimension: Option<usize>,
    points: Option<Lines<'a>>,
    /// Cells of the volume (no name) and of the markers, in the order of the file.
    cells: Vec<(Option<String>, Lines<'a>)>,
    has_volume: bool,
    /// A marker whose number of elements is still to come.
    marker: Option<String>,
}

/// The mesh in these bytes.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh> {
    let mut lexer = Lexer::new(bytes, Some(b'%'));
    let mut blocks = Blocks::default();
    // The lines of a block that is of no use here, such as a free-form deformation box.
    let mut skips_data = false;
    while let Some(line) = lexer.line() {
        match Keyword::of(&line) {
            Some(keyword) => skips_data = !blocks.take(&keyword, &line, &mut lexer)?,
            None if skips_data => {}
            None => {
                let found = shown(line.rest());
                return Err(line.error(format!("expected a line KEYWORD= value, found {found}")));
            }
        }
    }
    blocks.mesh(&lexer)
}

impl<'a> Blocks<'a> {
    /// Takes a keyword and its block of lines; `false` where the keyword is of no use here.
    fn take(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Fields<'a>,
        lexer: &mut Lexer<'a>,
    ) -> Result<bool> {
        match keyword.name {
            b"NDIME" => {
                let dimension = keyword.integer(line)?;
                if !matches!(dimension, 2 | 3) {
                    return Err(line.error(format!("NDIME= {dimension}; it is 2 or 3")));
                }
                self.dimension = Some(dimension as usize);
            }
            b"NZONE" => {
                let n = keyword.integer(line)?;
                if n != 1 {
                    return Err(line.error(format!(
                        "NZONE= {n}; a mesh of one zone is read, split the file at its IZONE lines"
                    )));
                }
            }
            b"NPOIN" => {
                if self.points.is_some() {
                    return Err(line.error("a second NPOIN"));
                }
                let n = keyword.count(line)?;
                self.points = Some(lexer.take_lines(n, "nodes")?);
            }
            b"NELEM" => {
                if self.has_volume {
                    return Err(line.error("a second NELEM"));
                }
                self.has_volume = true;
                let n = keyword.count(line)?;
                self.cells.push((None, lexer.take_lines(n, "cells")?));
            }
            b"MARKER_TAG" => {
                if keyword.value.is_empty() {
                    return Err(line.error("MARKER_TAG= without a name"));
                }
                self.marker = Some(String::from_utf8_lossy(keyword.value).into_owned());
            }
            b"MARKER_ELEMS" => {
                let n = keyword.count(line)?;
                let name = self.marker.take();
                let name = name.ok_or_else(|| line.error("MARKER_ELEMS before its MARKER_TAG"))?;
                // Markers of partitioned and periodic meshes say here where they send and receive.
                let next = lexer.peek_line();
                if next.is_some_and(|next| next.rest().starts_with(b"SEND_")) {
                    lexer.line();
                }
                self.cells
                    .push((Some(name), lexer.take_lines(n, "boundary elements")?));
            }
            b"NMARK" | b"IZONE" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn mesh(self, lexer: &Lexer) -> Result<Mesh> {
        let missing = |what: &str| lexer.error(format!("no {what}= in the file"));
        let dimension = self.dimension.ok_or_else(|| missing("NDIME"))?;
        let points = self.points.ok_or_else(|| missing("NPOIN"))?;
        if !self.has_volume {
            return Err(missing("NELEM"));
        }
        if let Some(name) = self.marker {
            return Err(lexer.error(format!("MARKER_TAG= {name} without MARKER_ELEMS")));
        }
        let mut mesh = Mesh {
            points: read_points(&points, dimension)?,
            ..Mesh::default()
        };
        let n_points = mesh.points.len();
        for (name, lines) in &self.cells {
            let first = mesh.cells.len();
            if first.saturating_add(lines.len()) >= u32::MAX as usize {
                return Err(lexer.error("at most 4294967294 cells are possible"));
            }
            append_cells(lines, n_points, &mut mesh.cells)?;
            if let Some(name) = name {
                add_marker(&mut mesh, name, first, dimension as u8 - 1);
            }
        }
        Ok(mesh)
    }
}

/// Coordinates, and after them perhaps the index of the node.
fn read_points(lines: &Lines, dimension: usize) -> Result<Vec<[f64; 3]>> {
    if lines.len() >= u32::MAX as usize {
        return Err(Error::input("at most 4294967294 nodes are possible"));
    }
    let mut points = vec![[0.0; 3]; lines.len()];
    lines.parse_into(&mut points, 1, |line, point| {
        for (i, x) in point[0][..dimension].iter_mut().enumerate() {
            if line.is_done() {
                return Err(line.error(format!("a node needs {dimension} coordinates, found {i}")));
            }
            *x = line.real("a coordinate")?;
        }
        Ok(())
    })?;
    Ok(points)
}

/// Cells of one task.
#[derive(Default)]
struct Part {
    connectivity: Vec<u32>,
    runs: Vec<(CellKind, usize)>,
}

fn append_cells(lines: &Lines, n_points: usize, cells: &mut Cells) -> Result<()> {
    let parts = lines.parse(|line, part| parse_cell(line, n_points, part))?;
    cells.reserve(parts.iter().map(|part| part.connectivity.len()).sum());
    for part in parts {
        let mut rest = &part.connectivity[..];
        for (kind, n_cells) in part.runs {
            let n_nodes = kind.n_nodes().expect("SU2's kinds have a number of nodes");
            let (own, tail) = rest.split_at(n_nodes * n_cells);
            cells.push_run(kind, n_nodes, own);
            rest = tail;
        }
    }
    Ok(())
}

/// Type, nodes, and perhaps the index of the cell.
fn parse_cell(line: &mut Fields, n_points: usize, part: &mut Part) -> Result<()> {
    let number = line.integer("an element type")?;
    let kind = u8::try_from(number).ok().and_then(CellKind::from_vtk);
    let kind = kind.filter(|kind| holds(*kind)).ok_or_else(|| {
        line.error(format!(
            "element type {number} is not read; 1, 3, 5, 9, 10, 12, 13 and 14 are, all linear"
        ))
    })?;
    let n_nodes = kind.n_nodes().expect("SU2's kinds have a number of nodes");
    for i in 0..n_nodes {
        if line.is_done() {
            let name = kind.name();
            return Err(line.error(format!("a {name} needs {n_nodes} node indices, found {i}")));
        }
        let node = line.integer("a node index")?;
        let known = usize::try_from(node).is_ok_and(|node| node < n_points);
        if !known {
            let name = kind.name();
            return Err(line.error(format!(
                "a {name} has node {node}, but the mesh has {n_points} nodes, counted from 0"
            )));
        }
        part.connectivity.push(node as u32);
    }
    match part.runs.last_mut() {
        Some((last, n)) if *last == kind => *n += 1,
        _ => part.runs.push((kind, 1)),
    }
    Ok(())
}

/// Adds the cells from `first` on to the groups of this name, one for each dimension; an empty
/// marker is one of `boundary`.
fn add_marker(mesh: &mut Mesh, name: &str, first: usize, boundary: u8) {
    let ranges: Vec<_> = mesh
        .cells
        .runs_in(first..mesh.cells.len())
        .map(|run| {
            let cells = run.first_cell..run.first_cell + run.n_cells();
            (run.kind.dimension(), cells)
        })
        .collect();
    let ranges = match ranges.is_empty() {
        true => vec![(boundary, 0..0)],
        false => ranges,
    };
    for (dimension, cells) in ranges {
        let is_own = |group: &&mut Group| group.dimension == dimension && group.name == name;
        match mesh.groups.iter_mut().find(is_own) {
            Some(group) => group.cells.push_range(cells),
            None => mesh.groups.push(Group {
                dimension,
                name: name.to_owned(),
                number: None,
                condition: None,
                cells: cells.collect(),
            }),
        }
    }
}
