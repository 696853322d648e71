//! Polygons and polyhedra: NGON_n and NFACE_n sections in both layouts, or faces that name the
//! cells on their two sides (ParentElements).
//!
//! With polyhedra, only polygons on the boundary are cells: polygons that a boundary
//! condition names, polygons of no polyhedron, and whole sections of boundary faces.

use super::builder::MeshBuilder;
use super::element::{NFACE_N, NGON_N};
use super::node::Node;
use super::sections::{Cells, Section, Span, node_indices, part};
use super::zone::Zone;
use crate::mesh::{CellKind, Values, check_listed};
use azimesh_core::error::Result;
use std::ops::Range;

/// The polygons and polyhedra of a zone.
pub(super) struct Polyhedra {
    faces: Faces,
    solids: Vec<Solids>,
    /// Number of polyhedra that have each face, at most 2.
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
    /// True if the parents of the faces alone give them.
    from_parents: bool,
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
        let may_be_solid = |s: &Section| s.dimension().is_none_or(|dimension| dimension == 3);
        let any_solid = sections.iter().any(|s| may_be_solid(s) && s.n_elements > 0);
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
        let mut n_listed = 0;
        for solids in &self.solids {
            for (i, number) in solids.faces.iter().enumerate() {
                let Some(face) = self.faces.find(number.unsigned_abs()) else {
                    let of = solids.starts.partition_point(|start| *start <= i) as i64;
                    return Err(zone.refuse(format!(
                        "polyhedron {} has face {number}, which is in no NGON_n section",
                        solids.first.saturating_add(of - 1)
                    )));
                };
                n_listed += self.faces.get(face).len();
                self.n_cells[face] = (self.n_cells[face] + 1).min(2);
            }
        }
        let n_uses = self.solids.iter().map(|solids| solids.faces.len()).sum();
        check_listed(n_listed, n_uses, self.faces.nodes.len()).map_err(|e| zone.refuse(e.message))
    }

    /// Number of faces with fewer than three nodes.
    pub fn n_degenerate(&self) -> usize {
        let faces = 0..self.faces.len();
        faces.filter(|&face| !self.faces.has_shape(face)).count()
    }

    /// Tests if the faces belong to polyhedra and are not cells themselves.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// Marks the faces in these elements.
    pub fn name_elements(&self, elements: &[Range<i64>], named: &mut [bool]) {
        for section in &self.faces.sections {
            let named = &mut named[section.faces.clone()];
            for range in elements {
                named[part(section.first, section.faces.len(), range)].fill(true);
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
        found.cells.check_space(section.n_elements)?;
        let first_cell = found.cells.len();
        let mut cells = vec![u32::MAX; section.n_elements];
        for (cell, (face, is_cell)) in cells.iter_mut().zip(self.is_cell(faces, named)) {
            if is_cell {
                *cell = found.cells.len() as u32;
                self.push_face(face, found);
            }
        }
        let are_all = found.cells.len() - first_cell == cells.len();
        Ok(section.span(if are_all {
            Cells::From(first_cell)
        } else {
            Cells::Each(cells)
        }))
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

    /// The faces of a section, and whether each is a cell.
    fn is_cell<'s>(
        &'s self,
        section: &'s FaceSection,
        named: &'s [bool],
    ) -> impl Iterator<Item = (usize, bool)> + 's {
        let faces = section.faces.clone();
        let mut sections = self.faces.sections.iter();
        let all_given = sections.any(|section| section.n_boundary > 0);
        let on_boundary = |face: usize| self.n_cells[face] < 2;
        let is_patch =
            !all_given && self.faces.sections.len() > 1 && faces.clone().all(on_boundary);
        let end_of_given = faces.start + section.n_boundary.min(faces.len());
        let is_wanted = move |face: usize| {
            let is_free = named[face] || self.n_cells[face] == 0;
            !self.has_solids() || is_free || is_patch || face < end_of_given
        };
        faces.map(move |face| (face, is_wanted(face) && self.faces.has_shape(face)))
    }

    /// Appends the polyhedra of a section.
    pub fn append_section(&self, section: &Section, found: &mut MeshBuilder) -> Result<Span> {
        let is_it = |s: &&Solids| s.first == section.first && s.len() == section.n_elements;
        let mut read = self.solids.iter().filter(|solids| !solids.from_parents);
        let of = read.find(is_it);
        self.append(of.expect("every section was read"), section.node, found)
    }

    /// Appends the polyhedra that are given by their faces alone.
    pub fn append_others(&self, zone: &Node, found: &mut MeshBuilder) -> Result<Vec<Span>> {
        let others = self.solids.iter().filter(|solids| solids.from_parents);
        others
            .map(|solids| self.append(solids, zone, found))
            .collect()
    }

    fn append(&self, solids: &Solids, node: &Node, found: &mut MeshBuilder) -> Result<Span> {
        let first_cell = found.cells.len();
        let n = solids.len();
        found.cells.check_space(n)?;
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
                stream.push(nodes[0]);
                if *number > 0 {
                    stream.extend(&nodes[1..]);
                } else {
                    stream.extend(nodes[1..].iter().rev());
                }
            }
            let pushed = found.cells.push_polyhedron(&stream);
            pushed.map_err(|error| {
                let number = solids.first.saturating_add(i as i64);
                node.refuse(format!("polyhedron {number}: {}", error.message))
            })?;
        }
        Ok(Span {
            first: solids.first,
            n_elements: n,
            cells: Cells::From(first_cell),
        })
    }
}

impl Faces {
    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn get(&self, face: usize) -> &[u32] {
        &self.nodes[self.starts[face]..self.starts[face + 1]]
    }

    /// Tests if a face has at least three nodes, and so an area.
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
        let (before, base) = (self.len(), self.nodes.len());
        let indices = |values: Values, node: &Node| node_indices(&values, node, zone);
        let (starts, mut nodes) = lists(section, indices)?;
        self.nodes.append(&mut nodes);
        self.starts
            .extend(starts[1..].iter().map(|start| base + start));
        self.sections.push(FaceSection {
            first: section.first,
            faces: before..self.len(),
            n_boundary: section.n_boundary,
        });
        Ok(())
    }
}

impl Solids {
    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn read(section: &Section) -> Result<Self> {
        let (starts, faces) = lists(section, integers)?;
        let first = section.first;
        Ok(Self {
            first,
            starts,
            faces,
            from_parents: false,
        })
    }

    /// The polyhedra that the faces name as those on their two sides, those with consecutive numbers together.
    fn from_parents(sections: &[Section]) -> Result<Vec<Self>> {
        let mut sides: Vec<(i64, i64)> = Vec::new();
        for section in sections.iter().filter(|s| s.element_type == NGON_N) {
            let Some(node) = section.node.child("ParentElements")? else {
                return Ok(Vec::new());
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
            for (cells, sign) in [(left, 1), (right, -1)] {
                let faces = section.range().map(|face| sign * face);
                sides.extend(cells.iter().copied().zip(faces));
            }
        }
        sides.retain(|(cell, _)| *cell > 0);
        sides.sort_by_key(|(cell, face)| (*cell, face.unsigned_abs()));
        let mut all: Vec<Self> = Vec::new();
        for of_cell in sides.chunk_by(|a, b| a.0 == b.0) {
            let number = of_cell[0].0;
            let next = |solids: &Self| solids.first.saturating_add(solids.len() as i64);
            if all.last().is_none_or(|last| next(last) != number) {
                all.push(Self {
                    first: number,
                    starts: vec![0],
                    faces: Vec::new(),
                    from_parents: true,
                });
            }
            if let Some(last) = all.last_mut() {
                last.faces.extend(of_cell.iter().map(|(_, face)| *face));
                last.starts.push(last.faces.len());
            }
        }
        Ok(all)
    }
}

fn integers(values: Values, node: &Node) -> Result<Vec<i64>> {
    let integers = values.to_integers();
    integers.ok_or_else(|| node.refuse("its data must be integers"))
}

/// The entries of the elements of a section, which `convert` makes of numbers; starts of elements, and the end of the last.
fn lists<T>(
    section: &Section,
    convert: impl Fn(Values, &Node) -> Result<Vec<T>>,
) -> Result<(Vec<usize>, Vec<T>)> {
    let n = section.n_elements;
    let node = section.node.need("ElementConnectivity")?;
    if let Some(offsets) = section.node.child("ElementStartOffset")? {
        let entries = convert(node.values()?, node)?;
        let starts = starts(offsets, n, entries.len())?;
        return Ok((starts, entries));
    }
    // Before CGNS 3.4: each element is preceded by the number of its entries.
    let stream = node.integers()?;
    let mut rest = &stream[..];
    let (mut starts, mut entries) = (vec![0], Vec::new());
    for i in 0..n {
        let count = rest.first().and_then(|&count| usize::try_from(count).ok());
        let Some(count) = count.filter(|count| *count < rest.len()) else {
            return Err(node.refuse(format!("the list ends inside element {} of {n}", i + 1)));
        };
        entries.extend_from_slice(&rest[1..=count]);
        starts.push(entries.len());
        rest = &rest[1 + count..];
    }
    Ok((starts, convert(Values::I64(entries), node)?))
}

/// Starts of `n` elements among `n_entries` entries, and the end of the last.
fn starts(node: &Node, n: usize, n_entries: usize) -> Result<Vec<usize>> {
    let offsets = node.integers()?;
    let ascending = offsets.windows(2).all(|two| two[0] <= two[1]);
    let ends = [offsets.first().copied(), offsets.last().copied()];
    let fits = ends == [Some(0), i64::try_from(n_entries).ok()];
    if offsets.len() != n + 1 || !ascending || !fits {
        return Err(node.refuse(format!(
            "it has {} offsets; it must have {}, ascending from 0 to {n_entries}",
            offsets.len(),
            n + 1
        )));
    }
    Ok(offsets.into_iter().map(|offset| offset as usize).collect())
}
