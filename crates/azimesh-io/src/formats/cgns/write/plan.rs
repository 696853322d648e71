//! Assigns cells to sections, and numbers to their elements. Every cell is one element. Faces of polyhedra
//! that are no cells follow.

use super::super::builder::set_of;
use super::super::element::ElementType;
use super::RULE;
use crate::formats::names::UniqueNames;
use crate::formats::portable::remedy;
use crate::mesh::{CellKind, CellRun, CellSet, Group, Mesh, MeshView};
use azimesh_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Up to this number, each run of cells of one type is a section.
const MOST_SECTIONS: usize = 500;
/// A section of a boundary is cut where tags begin and end as long as there are no more places.
const MOST_CUTS: usize = 1000;
/// Pieces of a type and its tags that are left as they are, on average.
const MOST_PIECES: usize = 2;

/// A section to be.
pub(super) struct Planned {
    pub name: String,
    pub form: Form,
    pub cells: Range<usize>,
}

/// The content of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Elements of one type.
    Fixed(ElementType),
    /// Elements that name their own type.
    Mixed,
    /// NGON_n.
    Polygons,
    /// NFACE_n.
    Polyhedra,
}

/// The mesh with its cells in the order of their types and tags, where as they are they would be many more sections
/// than types and tags.
pub(super) fn sorted(mesh: &MeshView) -> Result<Option<Mesh>> {
    let order = other_order(mesh)?;
    Ok(order.map(|order| mesh.with_cells_in_order(&order)))
}

/// The order of the cells in the file, where it is another than theirs: cells of one type and in the same groups of the
/// boundary are together where that makes much fewer sections and not too many; else cells of one type where these are too many.
pub fn other_order(mesh: &MeshView) -> Result<Option<Vec<usize>>> {
    let stretches = stretches(mesh)?;
    let changes = changes(mesh);
    if changes.len() > stretches.len() {
        let (pieces, n_classes) = pieces(&stretches, changes);
        if n_classes <= MOST_SECTIONS && pieces.len() > MOST_PIECES * n_classes {
            return Ok(Some(in_order(pieces)));
        }
    }
    if stretches.len() <= MOST_SECTIONS {
        return Ok(None);
    }
    let (pieces, _) = pieces(&runs(mesh)?, BTreeMap::new());
    Ok(Some(in_order(pieces)))
}

/// The cells of pieces in the order of their classes.
fn in_order(mut pieces: Vec<(usize, Range<usize>)>) -> Vec<usize> {
    pieces.sort_by_key(|(class, _)| *class);
    pieces.into_iter().flat_map(|(_, cells)| cells).collect()
}

/// Groups of the boundary that begin or end at a cell.
fn changes(mesh: &MeshView) -> BTreeMap<usize, Vec<usize>> {
    let dimension = mesh.dimension();
    let mut changes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let groups = mesh.groups.iter().enumerate();
    for (group, of) in groups.filter(|(_, group)| group.dimension < dimension) {
        for range in of.cells.ranges() {
            changes.entry(range.start).or_default().push(group);
            changes.entry(range.end).or_default().push(group);
        }
    }
    changes
}

/// Pieces of one form and dimension and in the same groups, each with the index of its class; and the number of classes.
fn pieces(
    stretches: &[Stretch],
    changes: BTreeMap<usize, Vec<usize>>,
) -> (Vec<(usize, Range<usize>)>, usize) {
    let mut inside: BTreeSet<usize> = BTreeSet::new();
    let mut changes = changes.into_iter().peekable();
    let mut kinds: Vec<(Form, u8)> = Vec::new();
    let mut classes: BTreeMap<(usize, Vec<usize>), usize> = BTreeMap::new();
    let mut pieces = Vec::new();
    for (form, of, cells) in stretches {
        let kind = kinds.iter().position(|kind| *kind == (*form, *of));
        let kind = kind.unwrap_or_else(|| {
            kinds.push((*form, *of));
            kinds.len() - 1
        });
        let mut start = cells.start;
        while start < cells.end {
            while let Some((_, groups)) = changes.next_if(|(at, _)| *at <= start) {
                for group in groups {
                    if !inside.remove(&group) {
                        inside.insert(group);
                    }
                }
            }
            let end = changes
                .peek()
                .map_or(cells.end, |(at, _)| cells.end.min(*at));
            let class = (kind, inside.iter().copied().collect());
            let n = classes.len();
            pieces.push((*classes.entry(class).or_insert(n), start..end));
            start = end;
        }
    }
    (pieces, classes.len())
}

/// Consecutive cells that are a section, or several where groups begin and end.
type Stretch = (Form, u8, Range<usize>);

/// The sections as they would be without groups; joined where these are too many.
fn stretches(mesh: &MeshView) -> Result<Vec<Stretch>> {
    let runs = runs(mesh)?;
    Ok(if runs.len() > MOST_SECTIONS {
        mixed(runs)
    } else {
        runs
    })
}

fn runs(mesh: &MeshView) -> Result<Vec<Stretch>> {
    let dimension = mesh.dimension();
    let mut stretches: Vec<Stretch> = Vec::new();
    for run in mesh.cells.runs() {
        let (form, of) = (form(mesh, &run, dimension)?, run.kind.dimension());
        match stretches.last_mut() {
            Some((last, other, cells)) if (*last, *other) == (form, of) => {
                cells.end = run.range().end;
            }
            _ => stretches.push((form, of, run.range())),
        }
    }
    Ok(stretches)
}

/// The sections of a mesh, in the order of its cells.
pub(super) fn sections(mesh: &MeshView, names: &mut UniqueNames) -> Result<Vec<Planned>> {
    let dimension = mesh.dimension();
    let (zones, others) = mesh.groups.iter().partition(|g| g.dimension == dimension);
    let mut cuts = cuts(others);
    cuts.extend(self::cuts(zones));
    let mut sections = Vec::new();
    for (form, _, cells) in stretches(mesh)? {
        let inside = cuts.range(cells.start + 1..cells.end.max(cells.start + 1));
        let mut start = cells.start;
        for end in inside.copied().chain([cells.end]) {
            let cells = start..end;
            let name = names.give(name(mesh, form, cells.clone()), &RULE);
            sections.push(Planned { name, form, cells });
            start = end;
        }
    }
    Ok(sections)
}

/// Joins neighbours of one dimension that a MIXED section can hold.
fn mixed(stretches: Vec<Stretch>) -> Vec<Stretch> {
    let mut joined: Vec<Stretch> = Vec::new();
    let can = |form: &Form| matches!(form, Form::Fixed(_) | Form::Mixed);
    for (form, dimension, range) in stretches {
        match joined.last_mut() {
            Some((last, of, cells)) if can(last) && can(&form) && *of == dimension => {
                *last = Form::Mixed;
                cells.end = range.end;
            }
            _ => joined.push((form, dimension, range)),
        }
    }
    joined
}

/// The form of a run of cells of a mesh of this dimension. VTK's reader counts edges and points of a solid mesh as cells
/// unless they are in a MIXED section after all cells.
fn form(mesh: &MeshView, run: &CellRun, dimension: u8) -> Result<Form> {
    if is_polygon(mesh, run.kind) {
        return Ok(Form::Polygons);
    }
    if run.kind == CellKind::Polyhedron {
        return Ok(Form::Polyhedra);
    }
    match ElementType::of(run.kind, run.n_nodes) {
        Some(_) if run.kind.dimension() + 1 < dimension => Ok(Form::Mixed),
        Some(element) => Ok(Form::Fixed(element)),
        None => Err(Error::input(format!(
            "cell {} is a {} with {} nodes, which CGNS cannot hold{}",
            run.first_cell,
            run.kind.name(),
            run.n_nodes,
            remedy(run.kind)
        ))),
    }
}

/// Tests if cells of this kind are elements of NGON_n: straight faces are if the mesh has polyhedra, since readers of ParaView
/// before 6 take no cells at all where these are of other types.
pub(super) fn is_polygon(mesh: &MeshView, kind: CellKind) -> bool {
    match kind {
        CellKind::Polygon => true,
        CellKind::Triangle | CellKind::Quadrilateral => mesh.cells.has_polyhedra(),
        _ => false,
    }
}

/// Cells at which one of some groups begins or ends; none where these are too many.
fn cuts(groups: Vec<&Group>) -> BTreeSet<usize> {
    let groups = groups.into_iter();
    let few = groups.filter(|group| group.cells.ranges().len() <= MOST_CUTS);
    let ranges = few.flat_map(|group| group.cells.ranges());
    let mut cuts: BTreeSet<usize> = ranges.flat_map(|range| [range.start, range.end]).collect();
    if cuts.len() > MOST_CUTS {
        cuts.clear();
    }
    cuts
}

/// A section of the cells of one group is called by it, another by its type.
fn name<'a>(mesh: &MeshView<'a>, form: Form, cells: Range<usize>) -> &'a str {
    let mut groups = mesh.groups.iter();
    let group = groups.find(|group| group.cells.contains_range(cells.clone()));
    match (group, form) {
        (Some(group), _) => &group.name,
        (_, Form::Fixed(element)) => element.name,
        (_, Form::Mixed) => "MIXED",
        (_, Form::Polygons) => "NGON_n",
        (_, Form::Polyhedra) => "NFACE_n",
    }
}

/// Numbers of elements: cells of the mesh's own dimension first, then cells of one dimension less, and so on, each in
/// the order of the mesh. VTK's reader takes the first elements of a zone, as many as it has cells, for its cells.
pub(super) struct Numbering {
    /// Runs of cells of one dimension, with the number of their first one, in the order of the mesh.
    runs: Vec<(Range<usize>, u8, usize)>,
}

impl Numbering {
    /// Of the cells of a mesh.
    pub fn of(mesh: &MeshView) -> Self {
        let mut runs: Vec<(Range<usize>, u8, usize)> = Vec::new();
        for run in mesh.cells.runs() {
            let (range, of) = (run.range(), run.kind.dimension());
            match runs.last_mut() {
                Some((last, dimension, _)) if *dimension == of => last.end = range.end,
                _ => runs.push((range, of, 0)),
            }
        }
        let mut next = 1;
        for dimension in (0..=3).rev() {
            for (range, _, first) in runs.iter_mut().filter(|(_, of, _)| *of == dimension) {
                *first = next;
                next += range.len();
            }
        }
        Self { runs }
    }

    /// True if elements are in the order of the cells.
    pub fn is_order_of_cells(&self) -> bool {
        let mut runs = self.runs.iter();
        runs.all(|(cells, _, first)| cells.start + 1 == *first)
    }

    /// The number of a cell.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn element(&self, cell: usize) -> usize {
        let at = self.runs.partition_point(|(cells, ..)| cells.end <= cell);
        let (cells, _, first) = &self.runs[at];
        first + cell - cells.start
    }

    /// The numbers of some cells, each less 1.
    pub fn elements(&self, cells: &CellSet) -> CellSet {
        let mut found: Vec<Range<usize>> = Vec::new();
        for range in cells.ranges() {
            let from = self
                .runs
                .partition_point(|(run, ..)| run.end <= range.start);
            let runs = self.runs[from..].iter();
            for (run, _, first) in runs.take_while(|(run, ..)| run.start < range.end) {
                let (start, end) = (range.start.max(run.start), range.end.min(run.end));
                found.push(first - 1 + start - run.start..first - 1 + end - run.start);
            }
        }
        set_of(found)
    }
}

#[cfg(test)]
mod tests {
    use super::super::faces::FaceTable;
    use super::*;

    /// A row of quadrilaterals, whose edges below and above take turns in `n` pieces of three tags.
    fn row(n: usize) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..=n {
            mesh.points
                .extend([[i as f64, 0.0, 0.0], [i as f64, 1.0, 0.0]]);
        }
        let corner = |i: usize| 2 * i as u32;
        for i in 0..n {
            let nodes = [corner(i), corner(i + 1), corner(i + 1) + 1, corner(i) + 1];
            mesh.cells.push(CellKind::Quadrilateral, &nodes);
        }
        let mut tags = vec![Vec::new(); 3];
        for i in 0..n {
            tags[i % 3].push(mesh.cells.len());
            mesh.cells.push(CellKind::Line, &[corner(i), corner(i + 1)]);
        }
        for (name, cells) in ["a", "b", "c"].into_iter().zip(tags) {
            mesh.add_tag(name, cells).expect("they are faces");
        }
        mesh
    }

    fn names(mesh: &MeshView) -> Vec<String> {
        let sections = sections(mesh, &mut UniqueNames::default()).expect("it can be written");
        sections.into_iter().map(|section| section.name).collect()
    }

    #[test]
    fn a_tag_in_many_pieces_is_one_section() {
        let mesh = row(75);
        assert_eq!(names(&mesh.view()).len(), 76);
        let sorted = sorted(&mesh.view())
            .expect("it can be written")
            .expect("it is sorted");
        assert_eq!(names(&sorted.view()), ["QUAD_4", "a", "b", "c"]);
        for (tag, was) in sorted.groups.iter().zip(&mesh.groups) {
            let places = |mesh: &Mesh, tag: &crate::mesh::Group| -> Vec<Vec<u32>> {
                tag.cells
                    .iter()
                    .map(|cell| mesh.cells.get(cell).nodes.to_vec())
                    .collect()
            };
            assert_eq!(places(&sorted, tag), places(&mesh, was), "{}", tag.name);
        }
    }

    #[test]
    fn tags_in_few_pieces_keep_their_order() {
        assert!(sorted(&row(6).view()).expect("it can be written").is_none());
    }

    #[test]
    fn sections_of_cells_are_cut_at_zones_and_named_after_them() {
        let mut mesh = row(4);
        for (name, cells) in [("left", 0..1), ("right", 1..4)] {
            mesh.groups.push(Group::new(2, name, None, cells.collect()));
        }
        assert_eq!(names(&mesh.view())[..2], ["left", "right"]);
        mesh.groups.pop();
        assert_eq!(names(&mesh.view())[..2], ["left", "QUAD_4"]);
    }

    #[test]
    fn straight_faces_beside_polyhedra_are_polygons_and_faces_of_these() {
        let mut mesh = Mesh::of_points(vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]);
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let mut stream = vec![4];
        for face in faces {
            stream.push(3);
            stream.extend(face);
        }
        mesh.cells.push_polyhedron(&stream).expect("a good stream");
        mesh.cells.push(CellKind::Triangle, &faces[0]);
        mesh.cells.push(CellKind::Triangle, &faces[1]);
        let view = mesh.view();
        let sections = sections(&view, &mut UniqueNames::default()).expect("it can be written");
        let forms: Vec<Form> = sections.iter().map(|section| section.form).collect();
        assert_eq!(forms, [Form::Polyhedra, Form::Polygons]);
        let table = FaceTable::of(&view, &Numbering::of(&view));
        assert_eq!(table.len(), 2);
        assert_eq!(table.of_polyhedron(&view, 0), [2, 3, 4, 5]);
    }

    #[test]
    fn cells_come_before_faces_and_edges_and_keep_their_order() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 4]);
        mesh.cells.push(CellKind::Vertex, &[0]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 3, 2]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 3]);
        let numbering = Numbering::of(&mesh.view());
        let numbers: Vec<usize> = (0..6).map(|cell| numbering.element(cell)).collect();
        assert_eq!(numbers, [6, 3, 1, 5, 2, 4]);
        assert!(!numbering.is_order_of_cells());
        let all = [1, 2, 4, 5].into_iter().collect();
        let numbers: Vec<usize> = numbering.elements(&all).iter().collect();
        assert_eq!(numbers, [0, 1, 2, 3]);
        let last = mesh.cells.select([2, 4, 1, 5, 3, 0]);
        let ordered = Mesh {
            cells: last,
            ..mesh
        };
        assert!(Numbering::of(&ordered.view()).is_order_of_cells());
    }
}
