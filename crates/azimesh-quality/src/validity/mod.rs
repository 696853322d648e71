//! Proves that cells are valid everywhere, not only at their corners.
//!
//! Owns the proofs: simplices, quadrilaterals and pyramids by their corners (there the Jacobian is linear between them),
//! wedges by the three quadratics along their upright edges, hexahedra by the Bernstein coefficients of the Jacobian with
//! subdivision, polyhedra by their tetrahedra of edge, face mean and cell mean. `summary` checks the corners; this module only
//! the points between them.
//!
//! Most cells pass a bound that costs little; the full proof is for the others.

mod bound;
pub(crate) mod curved;
mod hexahedron;
mod polyhedron;
#[cfg(test)]
mod tests;
mod wedge;

pub use curved::{CurvedMap, Samples};
pub use hexahedron::hexahedron;
pub use polyhedron::least_tetrahedron;
pub use wedge::wedge;

use super::reference::Reference;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{CellKind, CellRef, CellRun, Cells, Mesh};
use std::ops::Range;

/// Verdict on a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proof {
    /// The Jacobian is positive everywhere.
    Valid,
    /// It is not positive at a corner.
    Corner,
    /// It is positive at the corners and negative at a point between them.
    Inside,
    /// Neither: within rounding of zero or not decided by subdivision, or a tetrahedron of a polyhedron of positive
    /// volume that is not positive.
    Unproven,
}

/// The cells that are valid at their corners but not proven to be so everywhere.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Validity {
    /// Cells that are inverted between their corners, ascending.
    pub inside: Vec<u32>,
    /// Cells neither proven nor refuted, ascending.
    pub unproven: Vec<u32>,
}

/// Checks between the corners of cells that have the mesh's dimension, are valid in the reference, and were
/// proven there. One parallel pass.
pub fn assess(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    cells: Range<usize>,
) -> Validity {
    // These proofs do not look at the corners or the volume, by which the cell may be counted as inverted.
    let is_counted = |cell: usize| {
        let kind = mesh.cells.get(cell).kind;
        (kind.is_curved() || has_faces(kind)) && !corners_are_good(mesh, points, reference, cell)
    };
    let judged =
        |cell: usize| reference.is_valid(cell) && !reference.is_doubtful(cell) && !is_counted(cell);
    let sign = |cell: usize| reference.sign(cell);
    find(mesh, points, cells, &sign, &judged)
}

/// [`assess`] for cells with the orientations `sign`; cells selected by `judged` are checked.
pub(super) fn find(
    mesh: &Mesh,
    points: &[Vector],
    cells: Range<usize>,
    sign: &(dyn Fn(usize) -> i8 + Sync),
    judged: &(dyn Fn(usize) -> bool + Sync),
) -> Validity {
    let curved = CurvedMaps::new(mesh);
    if mesh.dimension() < 3 && curved.is_empty() {
        return Validity::default();
    }
    let parts = parallel::map_blocks_in(cells, CHUNK, &|range| {
        let mut found = Validity::default();
        for run in mesh.volume_runs_in(range) {
            doubtful(mesh, &run, points, &curved, &mut |cell| {
                if !judged(cell.index) {
                    return;
                }
                match prove(&mesh.cells, &cell, points, sign(cell.index), &curved) {
                    Proof::Inside => found.inside.push(cell.index as u32),
                    Proof::Unproven => found.unproven.push(cell.index as u32),
                    Proof::Valid | Proof::Corner => {}
                }
            });
        }
        found
    });
    let mut all = Validity::default();
    for part in parts {
        all.inside.extend(part.inside);
        all.unproven.extend(part.unproven);
    }
    all
}

/// The maps of the curved cells of a mesh; none of a surface that is not plane.
#[derive(Debug, Default)]
pub struct CurvedMaps(Vec<(CellKind, usize, CurvedMap)>);

impl CurvedMaps {
    /// The maps of the kinds that are checked.
    pub fn new(mesh: &Mesh) -> Self {
        let mut maps: Vec<(CellKind, usize, CurvedMap)> = Vec::new();
        let runs = mesh.volume_runs().filter(|run| run.kind.is_curved());
        for run in runs.filter(|_| mesh.dimension() == 3 || mesh.is_level()) {
            let is_known = maps
                .iter()
                .any(|(kind, n, _)| (*kind, *n) == (run.kind, run.n_nodes));
            if !is_known && let Some(map) = CurvedMap::new(run.kind, run.n_nodes) {
                maps.push((run.kind, run.n_nodes, map));
            }
        }
        Self(maps)
    }

    /// The map of a kind of cell with so many nodes.
    pub fn of(&self, kind: CellKind, n_nodes: usize) -> Option<&CurvedMap> {
        let mut found = self
            .0
            .iter()
            .filter(|(own, n, _)| (*own, *n) == (kind, n_nodes));
        found.next().map(|(_, _, map)| map)
    }

    /// Returns whether no cell is checked as a curved cell.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Calls `visit` for the cells of a run whose corners do not prove them, and that do not pass the bound.
fn doubtful<'a>(
    mesh: &Mesh,
    run: &CellRun<'a>,
    points: &[Vector],
    curved: &CurvedMaps,
    visit: &mut dyn FnMut(CellRef<'a>),
) {
    if curved.of(run.kind, run.n_nodes).is_some() {
        run.cell_refs().for_each(visit);
        return;
    }
    match run.kind.linear() {
        CellKind::Hexahedron => bound::hexahedra(run, points, visit),
        CellKind::Wedge => bound::wedges(run, points, visit),
        kind if has_faces(kind) => {
            for cell in run.cell_refs() {
                // Faces may be listed inward.
                let (least, most) = least_tetrahedron(&mesh.cells, &cell, points);
                if least <= 0.0 && most >= 0.0 {
                    visit(cell);
                }
            }
        }
        _ => {}
    }
}

/// The proof for one of these cells, of orientation `sign`.
pub fn prove(
    cells: &Cells,
    cell: &CellRef<'_>,
    points: &[Vector],
    sign: i8,
    curved: &CurvedMaps,
) -> Proof {
    if let Some(map) = curved.of(cell.kind, cell.nodes.len()) {
        return map.prove(cell.nodes, points, sign);
    }
    if let Some(one) = cell.uncollapsed() {
        return prove(&one, &one.get(0), points, sign, curved);
    }
    match cell.kind.linear() {
        CellKind::Hexahedron => hexahedron(&corners(cell, points), f64::from(sign)),
        CellKind::Wedge => wedge(&corners(cell, points), f64::from(sign)),
        kind if has_faces(kind) => {
            let (least, most) = least_tetrahedron(cells, cell, points);
            let least = if sign < 0 { -most } else { least };
            if least > 0.0 {
                Proof::Valid
            } else {
                Proof::Unproven
            }
        }
        _ => Proof::Valid,
    }
}

/// Kinds that are checked by the tetrahedra between their faces and their centre.
fn has_faces(kind: CellKind) -> bool {
    matches!(
        kind,
        CellKind::Polyhedron | CellKind::PentagonalPrism | CellKind::HexagonalPrism
    )
}

/// Returns whether a cell is not inverted at its corners, or by its volume.
fn corners_are_good(mesh: &Mesh, points: &[Vector], reference: &Reference, cell: usize) -> bool {
    let mut are_good = true;
    let one = cell..cell + 1;
    visit::volume_cells(mesh, points, reference.facing(), one, |_, block| {
        are_good = !reference.is_inverted(cell, &block.get(0));
    });
    are_good
}

/// The places of the corners of a cell.
fn corners<const N: usize>(cell: &CellRef<'_>, points: &[Vector]) -> [Vector; N] {
    std::array::from_fn(|i| points[cell.nodes[i] as usize])
}

/// Checks whether a cell is valid with its nodes at `points`; one that is not checked counts as valid.
pub fn state(mesh: &Mesh, points: &[Vector], reference: &Reference, cell: usize) -> Proof {
    match corners_are_good(mesh, points, reference, cell) {
        false => Proof::Corner,
        true if reference.is_doubtful(cell) || !reference.is_valid(cell) => Proof::Valid,
        true => prove(
            &mesh.cells,
            &mesh.cells.get(cell),
            points,
            reference.sign(cell),
            reference.maps(),
        ),
    }
}

/// The checked cells that are not valid with their nodes at `points`, ascending.
pub fn invalid(mesh: &Mesh, points: &[Vector], reference: &Reference) -> Vec<(u32, Proof)> {
    let corners = parallel::concat_blocks(mesh.cells.len(), CHUNK, &|range| {
        let mut found = Vec::new();
        visit::volume_cells(mesh, points, reference.facing(), range, |first, block| {
            let cells = (0..block.n).map(|i| (first + i, block.get(i)));
            let bad = cells.filter(|(cell, metrics)| reference.is_inverted(*cell, metrics));
            found.extend(bad.map(|(cell, _)| (cell as u32, Proof::Corner)));
        });
        found
    });
    let between = assess(mesh, points, reference, 0..mesh.cells.len());
    let mut all = corners;
    all.extend(between.inside.into_iter().map(|cell| (cell, Proof::Inside)));
    all.extend(
        between
            .unproven
            .into_iter()
            .map(|cell| (cell, Proof::Unproven)),
    );
    all.sort_unstable_by_key(|entry| entry.0);
    all
}
