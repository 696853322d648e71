//! Polygons and polyhedra: NGON_n and NFACE_n sections in both layouts, or faces that name the
//! cells on their two sides (ParentElements).
//!
//! Where there are polyhedra, only polygons on the boundary are cells: those that a boundary
//! condition names, those of no polyhedron, and whole sections of boundary faces.

use super::builder::MeshBuilder;
use super::element::{NFACE_N, NGON_N};
use super::node::Node;
use super::sections::{Cells, Section, Span, node_index, node_indices};
use super::zone::Zone;
use crate::mesh::CellKind;
use azimesh_core::error::Result;
use std::ops::Range;

/// The polygons and polyhedra of a zone.
pub(super) struct Polyhedra {
    faces: Faces,
    solids: Vec<Solids>,
    /// How many polyhedra have each face, at most 2 of them counted.
    n_cells: Vec<u8>,
}

/// Faces of all NGON_n sections.
#[derive(Default)]
struct Faces {
    sections: Vec<FaceSection>,
    starts: Vec<usize>,
    nodes: Vec<u32>,
}

struct FaceSection {
    first: i64,
    faces: Range<usize>,
    n_boundary: usize,
}

/// Polyhedra of one section: their faces, negative where they are turned round.
struct Solids {
    first: i64,
    starts: Vec<usize>,
    faces: Vec<i64>,
}

impl Polyhedra {
    /// Reads the faces, and the polyhedra that consist of them.
    pub fn read(zone: &Zone, sections: &[Section]) -> Result<Self> {
        let mut faces = Faces {
            starts: vec![0],
            ..Faces::default()
        };
        for section in sections.iter().filter(|s| s.element_type == NGON_N) {
            faces.read(section, zone)?;
        }
        let mut solids = Vec::new();
        for section in sections.iter().filter(|s| s.element_type == NFACE_N) {
            solids.push(Solids::read(section)?);
        }
        let any_solid = sections
            .iter()
            .any(|section| section.dimension() != Some(2));
        if zone.cell_dimension == 3 && !any_solid {
            solids.extend(Solids::from_parents(sections)?);
        }
        let mut polyhedra = Self {
            n_cells: vec![0; faces.len()],
            faces,
            solids,
        };
        polyhedra.count(zone.node)?;
        Ok(polyhedra)
    }

    fn count(&mut self, zone: &Node) -> Result<()> {
        for solids in &self.solids {
            for (i, number) in solids.faces.iter().enumerate() {
                let Some(face) = self.faces.find(number.unsigned_abs()) else {
                    let of = solids.starts.partition_point(|start| *start <= i) as i64;
                    return Err(zone.refuse(format!(
                        "polyhedron {} has face {number}, which is in no NGON_n section",
                        solids.first.saturating_add(of - 1)
                    )));
                };
                self.n_cells[face] = (self.n_cells[face] + 1).min(2);
            }
        }
        Ok(())
    }

    /// Number of faces with fewer than three nodes.
    pub fn n_degenerate(&self) -> usize {
        let faces = 0..self.faces.len();
        faces.filter(|&face| !self.faces.has_shape(face)).count()
    }

    /// Whether the faces are those of polyhedra rather than cells themselves.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// Marks the faces in these elements.
    pub fn name_elements(&self, elements: &[Range<i64>], named: &mut [bool]) {
        for section in &self.faces.sections {
            let n = section.faces.len() as i64;
            for range in elements {
                let start = range.start.saturating_sub(section.first).clamp(0, n) as usize;
                let end = range.end.saturating_sub(section.first).clamp(0, n) as usize;
                if start < end {
                    named[section.faces.start + start..section.faces.start + end].fill(true);
                }
            }
        }
    }

    /// Marks the faces on the boundary that have only nodes that `is_in`.
    pub fn name_nodes(&self, is_in: impl Fn(u32) -> bool, named: &mut [bool]) {
        for (face, named) in named.iter_mut().enumerate() {
            let on_boundary = self.n_cells[face] < 2;
            *named |= on_boundary && self.faces.get(face).iter().all(|&node| is_in(node));
        }
    }

    /// No face marked yet.
    pub fn none_named(&self) -> Vec<bool> {
        vec![false; self.faces.len()]
    }

    /// Appends those faces of a section that are cells.
    pub fn append_faces(
        &self,
        section: &Section,
        named: &[bool],
        found: &mut MeshBuilder,
    ) -> Result<Span> {
        let faces = self.faces.section(section);
        found.check_room(section.n_elements)?;
        let first_cell = found.cells.len();
        let is_cell = self.is_cell(faces, named);
        if is_cell.iter().all(|is_cell| *is_cell) {
            for face in faces.faces.clone() {
                self.push_face(face, found);
            }
            let n = section.n_elements;
            return Ok(span(section.first, n, Cells::From(first_cell)));
        }
        let mut cells = vec![u32::MAX; section.n_elements];
        for (i, face) in faces.faces.clone().enumerate() {
            if is_cell[i] {
                cells[i] = found.cells.len() as u32;
                self.push_face(face, found);
            }
        }
        Ok(span(section.first, section.n_elements, Cells::Each(cells)))
    }

    /// Appends a face as a cell: of solid cells a triangle or a quadrilateral where it has so many corners.
    fn push_face(&self, face: usize, found: &mut MeshBuilder) {
        let nodes = self.faces.get(face);
        let kind = match nodes.len() {
            3 if self.has_solids() => CellKind::Triangle,
            4 if self.has_solids() => CellKind::Quadrilateral,
            _ => CellKind::Polygon,
        };
        found.cells.push(kind, nodes);
    }

    fn is_cell(&self, section: &FaceSection, named: &[bool]) -> Vec<bool> {
        let faces = section.faces.clone();
        if !self.has_solids() {
            return faces.map(|face| self.faces.has_shape(face)).collect();
        }
        let on_boundary = |face: usize| self.n_cells[face] < 2;
        let told = self
            .faces
            .sections
            .iter()
            .any(|section| section.n_boundary > 0);
        let is_patch = !told && self.faces.sections.len() > 1 && faces.clone().all(on_boundary);
        let end_of_told = section.n_boundary.min(faces.len());
        let cells = faces.clone().enumerate().map(|(i, face)| {
            let is_wanted = named[face] || self.n_cells[face] == 0 || is_patch || i < end_of_told;
            is_wanted && self.faces.has_shape(face)
        });
        cells.collect()
    }

    /// Appends the polyhedra of a section.
    pub fn append_section(&self, section: &Section, found: &mut MeshBuilder) -> Result<Span> {
        let of = self.solids.iter().find(|s| s.first == section.first);
        self.append(of.expect("every section was read"), section.node, found)
    }

    /// Appends the polyhedra that are given by their faces alone.
    pub fn append_others(
        &self,
        sections: &[Section],
        zone: &Node,
        found: &mut MeshBuilder,
    ) -> Result<Vec<Span>> {
        let has_section = |solids: &&Solids| sections.iter().any(|s| s.first == solids.first);
        let others = self.solids.iter().filter(|solids| !has_section(solids));
        others
            .map(|solids| self.append(solids, zone, found))
            .collect()
    }

    fn append(&self, solids: &Solids, node: &Node, found: &mut MeshBuilder) -> Result<Span> {
        let first_cell = found.cells.len();
        let n = solids.starts.len() - 1;
        found.check_room(n)?;
        let mut stream: Vec<u32> = Vec::new();
        for (i, ends) in solids.starts.windows(2).enumerate() {
            stream.clear();
            stream.push(0);
            for number in &solids.faces[ends[0]..ends[1]] {
                let face = self.faces.find(number.unsigned_abs());
                let face = face.expect("all faces were found before");
                if !self.faces.has_shape(face) {
                    continue;
                }
                stream[0] += 1;
                let nodes = self.faces.get(face);
                stream.push(nodes.len() as u32);
                match *number > 0 {
                    true => stream.extend(nodes),
                    false => {
                        stream.extend(&nodes[..1]);
                        stream.extend(nodes[1..].iter().rev());
                    }
                }
            }
            let number = solids.first.saturating_add(i as i64);
            found
                .cells
                .push_polyhedron(&stream)
                .map_err(|error| node.refuse(format!("polyhedron {number}: {}", error.message)))?;
        }
        Ok(span(solids.first, n, Cells::From(first_cell)))
    }
}

fn span(first: i64, n_elements: usize, cells: Cells) -> Span {
    Span {
        first,
        n_elements,
        cells,
    }
}

impl Faces {
    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn get(&self, face: usize) -> &[u32] {
        &self.nodes[self.starts[face]..self.starts[face + 1]]
    }

    /// Whether a face has the nodes of a polygon; with fewer than three it has no area.
    fn has_shape(&self, face: usize) -> bool {
        self.get(face).len() >= 3
    }

    /// The face with this element number.
    fn find(&self, number: u64) -> Option<usize> {
        let number = i64::try_from(number).ok()?;
        let after = self
            .sections
            .partition_point(|section| section.first <= number);
        let section = &self.sections[after.checked_sub(1)?];
        let face = section.faces.start + (number - section.first) as usize;
        section.faces.contains(&face).then_some(face)
    }

    fn section(&self, section: &Section) -> &FaceSection {
        let mut sections = self.sections.iter();
        sections
            .find(|s| s.first == section.first && s.faces.len() == section.n_elements)
            .expect("every section was read")
    }

    fn read(&mut self, section: &Section, zone: &Zone) -> Result<()> {
        let before = self.len();
        let base = self.nodes.len();
        let node = section.node.need("ElementConnectivity")?;
        match section.node.child("ElementStartOffset")? {
            Some(offsets) => {
                let mut nodes = node_indices(&node.values()?, node, zone)?;
                let starts = starts(offsets, section.n_elements, nodes.len())?;
                self.nodes.append(&mut nodes);
                self.starts
                    .extend(starts[1..].iter().map(|start| base + start));
            }
            None => {
                let stream = node.integers()?;
                for part in counted(&stream, node, section.n_elements) {
                    for &number in part? {
                        self.nodes.push(node_index(number, node, zone)?);
                    }
                    self.starts.push(self.nodes.len());
                }
            }
        }
        self.sections.push(FaceSection {
            first: section.first,
            faces: before..self.len(),
            n_boundary: section.n_boundary,
        });
        Ok(())
    }
}

impl Solids {
    fn read(section: &Section) -> Result<Self> {
        let node = section.node.need("ElementConnectivity")?;
        let mut solids = Self {
            first: section.first,
            starts: vec![0],
            faces: Vec::new(),
        };
        match section.node.child("ElementStartOffset")? {
            Some(offsets) => {
                solids.faces = node.integers()?;
                solids.starts = starts(offsets, section.n_elements, solids.faces.len())?;
            }
            None => {
                let stream = node.integers()?;
                for part in counted(&stream, node, section.n_elements) {
                    solids.faces.extend(part?);
                    solids.starts.push(solids.faces.len());
                }
            }
        }
        Ok(solids)
    }

    /// The polyhedra that the faces name as those on their two sides.
    fn from_parents(sections: &[Section]) -> Result<Option<Self>> {
        let mut sides: Vec<(i64, i64)> = Vec::new();
        for section in sections.iter().filter(|s| s.element_type == NGON_N) {
            let Some(node) = section.node.child("ParentElements")? else {
                return Ok(None);
            };
            let parents = node.integers()?;
            if parents.len() != 2 * section.n_elements {
                return Err(node.refuse(format!(
                    "it has {} entries; it must have {}, two parents for each face",
                    parents.len(),
                    2 * section.n_elements
                )));
            }
            let (left, right) = parents.split_at(section.n_elements);
            let faces = section.range();
            sides.extend(
                left.iter()
                    .zip(faces.clone())
                    .map(|(&cell, face)| (cell, face)),
            );
            sides.extend(right.iter().zip(faces).map(|(&cell, face)| (cell, -face)));
        }
        sides.retain(|(cell, _)| *cell > 0);
        sides.sort_by_key(|(cell, face)| (*cell, face.unsigned_abs()));
        let Some(&(first, _)) = sides.first() else {
            return Ok(None);
        };
        let mut starts = Vec::new();
        for (i, (cell, _)) in sides.iter().enumerate() {
            if i == 0 || sides[i - 1].0 != *cell {
                starts.push(i);
            }
        }
        starts.push(sides.len());
        Ok(Some(Self {
            first,
            starts,
            faces: sides.into_iter().map(|(_, face)| face).collect(),
        }))
    }
}

/// Starts of `n` elements among `n_entries` entries, and the end of the last.
fn starts(node: &Node, n: usize, n_entries: usize) -> Result<Vec<usize>> {
    let offsets = node.integers()?;
    let ascending = offsets.windows(2).all(|two| two[0] <= two[1]);
    let fits = offsets.first() == Some(&0)
        && offsets
            .last()
            .is_some_and(|last| usize::try_from(*last) == Ok(n_entries));
    if offsets.len() != n + 1 || !ascending || !fits {
        return Err(node.refuse(format!(
            "it has {} offsets; it must have {}, ascending from 0 to {n_entries}",
            offsets.len(),
            n + 1
        )));
    }
    Ok(offsets.into_iter().map(|offset| offset as usize).collect())
}

/// The entries of `n` elements that are each preceded by their number: how it was before CGNS 3.4.
fn counted<'s>(
    stream: &'s [i64],
    node: &Node,
    n: usize,
) -> impl Iterator<Item = Result<&'s [i64]>> {
    let mut rest = stream;
    (0..n).map(move |i| {
        let count = rest.first().and_then(|&count| usize::try_from(count).ok());
        let Some(count) = count.filter(|count| *count < rest.len()) else {
            return Err(node.refuse(format!("the list ends inside element {} of {n}", i + 1)));
        };
        let (part, others) = rest[1..].split_at(count);
        rest = others;
        Ok(part)
    })
}
