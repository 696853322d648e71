//! Which cells make up which section. Every cell is one element; `numbering` has their numbers. Faces of
//! polyhedra that are no cells follow.

use super::super::element::ElementType;
use super::names::Names;
use crate::error::{Error, Result, option};
use crate::mesh::{CellKind, CellRun, Mesh, MeshView};
use std::collections::BTreeSet;
use std::ops::Range;

/// Runs of cells of one type are a section each as long as there are no more of them.
const MOST_SECTIONS: usize = 500;
/// A section of a boundary is cut where tags begin and end as long as there are no more places.
const MOST_CUTS: usize = 1000;

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

/// The mesh with its cells in the order of their types, where as they are they would be too many
/// sections.
pub(super) fn sorted(mesh: &MeshView) -> Result<Option<Mesh>> {
    let stretches = stretches(mesh)?;
    if stretches.len() <= MOST_SECTIONS {
        return Ok(None);
    }
    let dimension = mesh.dimension();
    let mut kinds: Vec<(Form, u8)> = Vec::new();
    let mut ranks = Vec::with_capacity(mesh.cells.len());
    for run in mesh.cells.runs() {
        let form = (form(&run, dimension)?, run.kind.dimension());
        let rank = kinds.iter().position(|known| *known == form);
        let rank = rank.unwrap_or_else(|| {
            kinds.push(form);
            kinds.len() - 1
        });
        ranks.resize(ranks.len() + run.n_cells(), rank);
    }
    let mut order: Vec<usize> = (0..ranks.len()).collect();
    order.sort_by_key(|cell| ranks[*cell]);
    Ok(Some(mesh.with_cells_in_order(&order)))
}

/// Consecutive cells that are a section, or several where groups begin and end.
type Stretch = (Form, u8, Range<usize>);

fn stretches(mesh: &MeshView) -> Result<Vec<Stretch>> {
    let dimension = mesh.dimension();
    let mut stretches: Vec<Stretch> = Vec::new();
    for run in mesh.cells.runs() {
        let (form, range) = (
            form(&run, dimension)?,
            run.first_cell..run.first_cell + run.n_cells(),
        );
        match stretches.last_mut() {
            Some((last, of, cells)) if *last == form && *of == run.kind.dimension() => {
                cells.end = range.end;
            }
            _ => stretches.push((form, run.kind.dimension(), range)),
        }
    }
    if stretches.len() > MOST_SECTIONS {
        stretches = mixed(stretches);
    }
    Ok(stretches)
}

/// The sections of a mesh, in the order of its cells.
pub(super) fn sections(mesh: &MeshView, names: &mut Names) -> Result<Vec<Planned>> {
    let cuts = cuts(mesh);
    let mut sections = Vec::new();
    for (form, _, cells) in stretches(mesh)? {
        let inside = cuts.range(cells.start + 1..cells.end.max(cells.start + 1));
        let mut start = cells.start;
        for end in inside.copied().chain([cells.end]) {
            let name = names.give(&name(mesh, form, start..end));
            sections.push(Planned {
                name,
                form,
                cells: start..end,
            });
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

/// The form of cells of a mesh of this dimension. VTK's reader counts edges and points of a solid mesh as cells
/// unless they are in a MIXED section after all cells.
fn form(run: &CellRun, dimension: u8) -> Result<Form> {
    let is_far_below = run.kind.dimension() + 1 < dimension;
    match run.kind {
        CellKind::Polygon => Ok(Form::Polygons),
        CellKind::Polyhedron => Ok(Form::Polyhedra),
        kind => ElementType::of(kind, run.n_nodes)
            .map(|element| match is_far_below {
                true => Form::Mixed,
                false => Form::Fixed(element),
            })
            .ok_or_else(|| {
                Error::input(format!(
                    "cell {} is a {} with {} nodes, which CGNS cannot hold; {} keeps only corner nodes",
                    run.first_cell,
                    kind.name(),
                    run.n_nodes,
                    option("linearize")
                ))
            }),
    }
}

/// Cells at which a group of the boundary or of lower dimension begins or ends.
fn cuts(mesh: &MeshView) -> BTreeSet<usize> {
    let dimension = mesh.dimension();
    let mut cuts = BTreeSet::new();
    for group in mesh.groups.iter().filter(|g| g.dimension < dimension) {
        if group.cells.ranges().len() > MOST_CUTS {
            continue;
        }
        cuts.extend(
            group
                .cells
                .ranges()
                .flat_map(|range| [range.start, range.end]),
        );
    }
    if cuts.len() > MOST_CUTS {
        cuts.clear();
    }
    cuts
}

/// A section of the cells of one group is called by it, another by its type.
fn name(mesh: &MeshView, form: Form, cells: Range<usize>) -> String {
    let dimension = mesh.dimension();
    let mut groups = mesh
        .groups
        .iter()
        .filter(|group| group.dimension < dimension);
    if let Some(group) = groups.find(|group| group.cells.contains_range(cells.clone())) {
        return group.name.clone();
    }
    let name = match form {
        Form::Fixed(element) => element.name,
        Form::Mixed => "MIXED",
        Form::Polygons => "NGON_n",
        Form::Polyhedra => "NFACE_n",
    };
    name.to_owned()
}
