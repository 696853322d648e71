//! Cells and groups of an unstructured zone.

use super::builder::MeshBuilder;
use super::element::{NFACE_N, NGON_N};
use super::polyhedra::Polyhedra;
use super::regions::{Families, GridLocation, Region, regions, tag};
use super::sections::{Cells, Section, Span, not_of_zone, part, says_nothing, sections};
use super::zone::Zone;
use crate::mesh::NodeBits;
use crate::mesh::exterior_faces;
use azimesh_core::error::Result;
use azimesh_core::note;
use azimesh_core::numbers::with_verb;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Appends the cells of a zone, and its boundary conditions as groups.
pub(super) fn read(zone: &Zone, families: &Families, found: &mut MeshBuilder) -> Result<()> {
    let sections = sections(zone)?;
    let regions = regions(zone, families, found)?;
    let first_cell = found.cells.len();
    let spans = read_cells(zone, &sections, &regions, found)?;
    let cells = first_cell..found.cells.len();
    add_groups(zone, (&sections, spans), &regions, cells, found)
}

/// Appends the boundary conditions of a zone as groups, where its cells are there from this one on and each element is a
/// cell. Gives the end of its cells.
pub(super) fn read_groups(
    zone: &Zone,
    families: &Families,
    first_cell: usize,
    found: &mut MeshBuilder,
) -> Result<usize> {
    let sections = sections(zone)?;
    let regions = regions(zone, families, found)?;
    let mut end = first_cell;
    let spans = in_order(zone, &sections, |section| {
        let first = end;
        end += section.n_elements;
        Ok(section.span(Cells::From(first)))
    })?;
    add_groups(zone, (&sections, spans), &regions, first_cell..end, found)?;
    Ok(end)
}

fn add_groups(
    zone: &Zone,
    (sections, spans): (&[Section], Vec<Span>),
    regions: &[Region],
    of_zone: Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    check_count(zone, sections, of_zone.clone(), found)?;
    let mut by_number: Vec<usize> = (0..spans.len()).collect();
    by_number.sort_by_key(|&i| spans[i].first);
    for region in regions {
        check(region, zone, (&spans, &by_number))?;
    }
    let names = sections.iter().zip(0..);
    let mut members = Members {
        zone,
        sections,
        spans: &spans,
        by_number,
        by_name: names.map(|(section, i)| (section.node.name(), i)).collect(),
        is_covered: vec![false; spans.len()],
    };
    let of_region = |region| members.cells_of(region, found);
    let mut cells: Vec<Vec<Range<usize>>> = regions.iter().map(of_region).collect();
    make_faces(zone, regions, &mut cells, of_zone.start, found);
    for (region, cells) in regions.iter().zip(&cells) {
        region.tag(cells, zone, found);
    }
    tag_sections(zone, sections, &members, found);
    Ok(())
}

fn read_cells(
    zone: &Zone,
    sections: &[Section],
    regions: &[Region],
    found: &mut MeshBuilder,
) -> Result<Vec<Span>> {
    let has_polygons = |s: &Section| [NGON_N, NFACE_N].contains(&s.element_type);
    if !sections.iter().any(has_polygons) {
        return in_order(zone, sections, |section| section.read(zone, found));
    }
    let polyhedra = Polyhedra::read(zone, sections)?;
    let n = polyhedra.n_degenerate();
    if n > 0 {
        found.remarks.push(note!(
            "degenerate_polygons",
            "{}: {} left out, since {} fewer than 3 nodes",
            zone.node.path(),
            with_verb(n, "polygon", "is"),
            if n == 1 { "it has" } else { "they have" }
        ));
    }
    let named = named_faces(zone, &polyhedra, regions);
    let mut spans = in_order(zone, sections, |section| match section.element_type {
        NGON_N => polyhedra.append_faces(section, &named, found),
        NFACE_N => polyhedra.append_section(section, found),
        _ => section.read(zone, found),
    })?;
    spans.extend(polyhedra.append_others(zone.node, found)?);
    Ok(spans)
}

/// The spans of all sections, which `read` gives in the order in which they make up the cells.
fn in_order(
    zone: &Zone,
    sections: &[Section],
    mut read: impl FnMut(&Section) -> Result<Span>,
) -> Result<Vec<Span>> {
    let mut spans: Vec<Option<Span>> = sections.iter().map(|_| None).collect();
    for i in order(zone, sections)? {
        spans[i] = Some(read(&sections[i])?);
    }
    Ok(spans.into_iter().flatten().collect())
}

/// The order of the sections in the cells: the order of their elements, unless azimesh has written
/// which cell each begins with. Faces of polyhedra that are no cells may follow as a section.
pub(super) fn order(zone: &Zone, sections: &[Section]) -> Result<Vec<usize>> {
    let mut order: Vec<usize> = (0..sections.len()).collect();
    if let Some(node) = zone.node.child(super::CELL_ORDER)?
        && let Some(first) = node.child("FirstCell")?
    {
        let first = first.integers()?;
        if first.len() <= sections.len() {
            order.sort_by_key(|&i| first.get(i).copied().unwrap_or(i64::MAX));
        }
    }
    Ok(order)
}

/// Notes a zone whose declared number of cells is wrong, as Gmsh writes where it leaves out cells
/// of high order. Ghost cells of a section may count or not.
fn check_count(
    zone: &Zone,
    sections: &[Section],
    of_zone: Range<usize>,
    found: &mut MeshBuilder,
) -> Result<()> {
    for section in sections {
        if section.node.labelled("Rind_t")?.next().is_some() {
            return Ok(());
        }
    }
    let runs = found.cells.runs_in(of_zone);
    let runs = runs.filter(|run| run.kind.dimension() == zone.cell_dimension);
    let n: usize = runs.map(|run| run.n_cells()).sum();
    let said = zone.n_cells[0];
    if said != n {
        found.remarks.push(note!(
            "cell_count",
            "{}: the number of cells of dimension {} is given as {said}, but its sections have {n}",
            zone.node.path(),
            zone.cell_dimension
        ));
    }
    Ok(())
}

/// Refuses a region of nodes or elements that the zone does not have.
fn check(region: &Region, zone: &Zone, spans: (&[Span], &[usize])) -> Result<()> {
    let ranges = region.ranges();
    if region.is_range && region.numbers.len() != 2 {
        return Err(region.node.refuse(format!(
            "its range has {} numbers; in an unstructured zone it must have 2",
            region.numbers.len()
        )));
    }
    if region.place == GridLocation::Nodes {
        let n = zone.nodes().len();
        let outside = |range| not_within(range, 1..n as i64 + 1);
        match ranges.iter().find_map(outside) {
            None => return Ok(()),
            Some(node) if region.says_place => {
                return Err(region.node.refuse(not_of_zone(node, n)));
            }
            Some(_) => {}
        }
    }
    let Some(number) = ranges.iter().find_map(|range| not_in(range, spans)) else {
        return Ok(());
    };
    let first = spans.1.first().map_or(0, |&i| spans.0[i].first);
    let last = spans.0.iter().map(|span| span.end() - 1).max().unwrap_or(0);
    Err(region.node.refuse(format!(
        "it has element {number}, which is in no section; the sections have elements {first} to {last}"
    )))
}

/// The first number of a range that is not in another.
fn not_within(range: &Range<i64>, whole: Range<i64>) -> Option<i64> {
    if !whole.contains(&range.start) {
        return Some(range.start);
    }
    (range.end > whole.end).then_some(whole.end)
}

/// The first number of a range that belongs to no element.
fn not_in(range: &Range<i64>, (spans, by_number): (&[Span], &[usize])) -> Option<i64> {
    let first = by_number.partition_point(|&i| spans[i].end() <= range.start);
    let mut next = range.start;
    for span in by_number[first..].iter().map(|&i| &spans[i]) {
        if next >= range.end || span.first > next {
            break;
        }
        next = next.max(span.end());
    }
    (next < range.end).then_some(next)
}

fn named_faces(zone: &Zone, polyhedra: &Polyhedra, regions: &[Region]) -> Vec<bool> {
    let mut named = polyhedra.none_named();
    if !polyhedra.has_solids() {
        return named;
    }
    for region in regions {
        match region.nodes(zone) {
            Some(nodes) => polyhedra.name_nodes(|node| nodes.has(node), &mut named),
            None => polyhedra.name_elements(&region.ranges(), &mut named),
        }
    }
    named
}

/// The sections of a zone and their cells, to find the cells of regions.
struct Members<'a> {
    zone: &'a Zone<'a>,
    sections: &'a [Section<'a>],
    spans: &'a [Span],
    /// The spans in the order of their elements.
    by_number: Vec<usize>,
    by_name: BTreeMap<&'a str, usize>,
    /// Sections with elements of a region.
    is_covered: Vec<bool>,
}

impl Members<'_> {
    fn cells_of(&mut self, region: &Region, found: &MeshBuilder) -> Vec<Range<usize>> {
        let Some(nodes) = region.nodes(self.zone) else {
            return self.cells_in(&region.ranges());
        };
        let section = self.section_of_name(region, &nodes, found);
        section.unwrap_or_else(|| self.faces_within(&nodes, region.dimension, found))
    }

    /// The cells of the section that has the name of a region and all of its nodes: the region gives that section its
    /// name, and is no boundary.
    fn section_of_name(
        &mut self,
        region: &Region,
        nodes: &NodeBits,
        found: &MeshBuilder,
    ) -> Option<Vec<Range<usize>>> {
        let names = region.names.iter().map(String::as_str);
        let names = names.chain([region.node.name()]);
        let named = names.filter_map(|name| self.by_name.get(name).copied());
        for i in named.collect::<BTreeSet<usize>>() {
            let cells = self.spans[i].cells(0..self.sections[i].n_elements);
            let are_solid = found
                .cells_in(&cells)
                .all(|run| run.kind.dimension() == self.zone.cell_dimension);
            if !cells.is_empty() && are_solid && self.are_all(&cells, nodes, found) {
                self.is_covered[i] = true;
                return Some(cells);
            }
        }
        None
    }

    /// The cells of these elements.
    fn cells_in(&mut self, elements: &[Range<i64>]) -> Vec<Range<usize>> {
        let mut cells = Vec::new();
        for range in elements {
            let ends_before = |&i: &usize| self.spans[i].end() <= range.start;
            let first = self.by_number.partition_point(ends_before);
            for &i in &self.by_number[first..] {
                let span = &self.spans[i];
                if span.first >= range.end {
                    break;
                }
                let own = part(span.first, span.n_elements, range);
                self.is_covered[i] |= !own.is_empty();
                cells.extend(span.cells(own));
            }
        }
        cells
    }

    /// The faces that have only nodes of a set. A section of all these nodes and no other is meant
    /// alone: faces across a corner may have only such nodes too.
    fn faces_within(
        &mut self,
        nodes: &NodeBits,
        dimension: u8,
        found: &MeshBuilder,
    ) -> Vec<Range<usize>> {
        let mut cells = Vec::new();
        for (i, span) in self.spans.iter().enumerate() {
            let all = span.cells(0..span.n_elements);
            let (mut within, mut n) = (Vec::new(), 0);
            for run in found.cells_in(&all) {
                n += run.n_cells();
                if run.kind.dimension() != dimension {
                    continue;
                }
                for (k, face) in run.cells().enumerate() {
                    if face.iter().all(|&node| nodes.has(node)) {
                        within.push(run.first_cell + k..run.first_cell + k + 1);
                    }
                }
            }
            self.is_covered[i] |= !within.is_empty();
            if n > 0 && within.len() == n && self.are_all(&within, nodes, found) {
                return within;
            }
            cells.extend(within);
        }
        cells
    }

    /// Tests if cells have all nodes of a set.
    fn are_all(&self, cells: &[Range<usize>], nodes: &NodeBits, found: &MeshBuilder) -> bool {
        let seen = NodeBits::new(&self.zone.nodes());
        seen.add_nodes_of(&found.cells, cells);
        seen.count() == nodes.count()
    }
}

/// Makes faces for the regions that are given by nodes where the file has no elements of them.
fn make_faces(
    zone: &Zone,
    regions: &[Region],
    cells: &mut [Vec<Range<usize>>],
    first_cell: usize,
    found: &mut MeshBuilder,
) {
    let mut wanted: Vec<(usize, NodeBits)> = Vec::new();
    for (i, region) in regions.iter().enumerate() {
        if cells[i].is_empty() && region.dimension + 1 == zone.cell_dimension {
            wanted.extend(region.nodes(zone).map(|nodes| (i, nodes)));
        }
    }
    if wanted.is_empty() {
        return;
    }
    let any = NodeBits::new(&zone.nodes());
    for (_, nodes) in &wanted {
        any.add(&nodes.clone().take());
    }
    let end = found.cells.len();
    let has = |node| any.has(node);
    let faces = exterior_faces(&found.cells, first_cell..end, zone.cell_dimension, has);
    for (i, nodes) in &wanted {
        let start = found.cells.len();
        for (kind, face) in &faces {
            if face.iter().all(|&node| nodes.has(node)) {
                found.cells.push(*kind, face);
            }
        }
        cells[*i].extend((start < found.cells.len()).then(|| start..found.cells.len()));
    }
}

/// Sections without an element in a region are groups by their own name: many programs name the
/// boundary so. Names of the only section of cells, or that say their kind, are not.
fn tag_sections(zone: &Zone, sections: &[Section], members: &Members, found: &mut MeshBuilder) {
    let mut n_solid = 0;
    let mut named = Vec::new();
    for (i, section) in sections.iter().enumerate() {
        let cells = members.spans[i].cells(0..section.n_elements);
        let has_solids = found
            .cells_in(&cells)
            .any(|run| run.kind.dimension() == zone.cell_dimension);
        n_solid += usize::from(has_solids);
        if !members.is_covered[i] && !says_nothing(section.node.name(), has_solids) {
            named.push((section.node.name(), has_solids, cells));
        }
    }
    for (name, has_solids, cells) in named {
        if !has_solids || n_solid > 1 {
            tag(name, None, &cells, zone, found);
        }
    }
}

impl Span {
    fn end(&self) -> i64 {
        self.first.saturating_add(self.n_elements as i64)
    }

    /// The cells of some of its elements, counted from its first.
    fn cells(&self, elements: Range<usize>) -> Vec<Range<usize>> {
        let mut found: Vec<Range<usize>> = Vec::new();
        match &self.cells {
            _ if elements.is_empty() => {}
            Cells::From(first) => found.push(first + elements.start..first + elements.end),
            Cells::Each(cells) => {
                for &cell in cells[elements].iter().filter(|cell| **cell != u32::MAX) {
                    let cell = cell as usize;
                    match found.last_mut() {
                        Some(last) if last.end == cell => last.end += 1,
                        _ => found.push(cell..cell + 1),
                    }
                }
            }
        }
        found
    }
}
