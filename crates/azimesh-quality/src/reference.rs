//! The orientation of each cell of the reference mesh, with which later positions are compared.

use super::facing::Facing;
use super::flaws::has_volume;
use super::metrics::Metrics;
use super::plane::vector_area;
use super::size_skew::ReferenceSizes;
use super::validity::{self, CurvedMaps, Proof};
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::unit;
use azimesh_core::parallel::{self, block};
use azimesh_io::mesh::{Adjacency, CellKind, Mesh, orientations};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// Orientation of every volume cell in the reference mesh: one byte a cell, and 12 more in a
/// surface mesh that is not in a plane of constant z.
///
/// A solid cell is positive in the node order of the Verdict library. A plane cell is positive when
/// it turns anticlockwise seen from +z; a cell of a curved surface mesh is compared with its own
/// normal in the reference.
#[derive(Debug, Clone)]
pub struct Reference {
    signs: Vec<i8>,
    facing: Facing,
    n_inverted: usize,
    n_reversed: usize,
    /// True if all cells are valid and have the same orientation.
    is_uniform: bool,
    /// Cells that are valid at their corners but not proven to be so between them, ascending.
    doubtful: Vec<u32>,
    /// Cells that list a node twice and are measured as what they are, ascending.
    collapsed: Vec<u32>,
    maps: Arc<CurvedMaps>,
}

/// The sign of a cell that is valid in the reference, times this, where it is not: its orientation is not known later.
const INVALID: i8 = 2;
/// The same, where it has a volume of the orientation that most cells have: later its volume is checked.
pub(super) const BY_VOLUME: i8 = 3;
/// The same, for a curved cell that is valid: later its map is checked and not its corners.
const BY_MAP: i8 = 4;

impl Reference {
    /// Evaluates every volume cell of the mesh. Cannot fail.
    pub fn new(mesh: &Mesh) -> Self {
        Self::with_sizes(mesh).0
    }

    /// With the sizes of the valid cells, in the same pass.
    pub fn with_sizes(mesh: &Mesh) -> (Self, ReferenceSizes) {
        let facing = facing(mesh);
        let n_cells = mesh.cells.len();
        let solid = mesh.dimension() == 3;
        let mut signs = vec![0i8; n_cells];
        let mut sizes = parallel::collect(n_cells, |_| f64::NAN);
        let collapsed = Mutex::new(Vec::new());
        let judge = |chunk, (signs, sizes): (&mut [i8], &mut [f64])| {
            let range = block(n_cells, CHUNK, chunk);
            let first = range.start;
            visit::volume_cells(mesh, &mesh.points, &facing, range, |start, block| {
                if !block.collapsed.is_empty() {
                    let mut all = collapsed.lock().unwrap_or_else(PoisonError::into_inner);
                    all.extend(&block.collapsed);
                }
                for i in 0..block.n {
                    let valid = block.get(i).orientation();
                    let sign = if block.volume[i] < 0.0 { -1 } else { 1 };
                    signs[start + i - first] = match valid {
                        0 if has_volume(mesh, &mesh.points, start + i, block.volume[i]) => {
                            BY_VOLUME * sign
                        }
                        0 => INVALID * sign,
                        valid => valid,
                    };
                    if valid != 0 {
                        sizes[start + i - first] = block.size[i];
                    }
                }
            });
        };
        let chunks = signs.chunks_mut(CHUNK).zip(sizes.chunks_mut(CHUNK));
        parallel::for_items(chunks, &judge);
        let maps = CurvedMaps::new(mesh);
        mark_curved(mesh, &maps, &mut signs);
        let own = &signs[mesh.own_cells()];
        let count = |of: &(dyn Fn(i8) -> bool + Sync)| {
            let counts = parallel::map_blocks(own.len(), CHUNK, &|range| {
                own[range].iter().filter(|&&sign| of(sign)).count()
            });
            counts.into_iter().sum::<usize>()
        };
        let counts = [
            count(&|sign| matches!(sign.abs(), INVALID | BY_VOLUME)),
            count(&|sign| matches!(sign, -1 | -4)),
            count(&|sign| sign > 0),
            count(&|sign| sign < 0),
        ];
        let [n_invalid, n_mirrored, n_positive, n_negative] =
            mesh.ranks().ordered_fold([0; 4], counts, |sum, own| {
                (0..4).for_each(|i| sum[i] += own[i]);
            });
        let n_reversed = if solid { n_mirrored } else { 0 };
        if n_invalid > 0 {
            let common = if n_negative > n_positive { -1 } else { 1 };
            for sign in signs
                .iter_mut()
                .filter(|sign| **sign == -common * BY_VOLUME)
            {
                *sign = -common * INVALID;
            }
        }
        let mut collapsed = collapsed
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        collapsed.sort_unstable();
        let mut reference = Self {
            collapsed,
            signs,
            facing,
            n_inverted: n_invalid + n_reversed,
            n_reversed,
            is_uniform: n_invalid == 0 && n_positive.min(n_negative) == 0,
            doubtful: Vec::new(),
            maps: Arc::new(maps),
        };
        let all = 0..n_cells;
        let validity = validity::assess(mesh, &mesh.points, &reference, all);
        reference.doubtful = [validity.inside, validity.unproven].concat();
        reference.doubtful.sort_unstable();
        let sure = reference.doubtful.is_empty();
        let all_sure = mesh
            .ranks()
            .ordered_fold(true, sure, |all, own| *all &= own);
        reference.is_uniform &= all_sure;
        (reference, ReferenceSizes(sizes))
    }

    /// For cells that are to be made valid: all are checked. Cells that are valid in `mesh` keep their orientation there if
    /// it `is_reference`; else all have that in which they are listed like most valid cells of their part of the mesh.
    /// Of cells with a node twice of which nothing is left that has corners the volume is checked.
    ///
    /// `self` is made from the whole `mesh`, which no other rank shares.
    #[must_use]
    pub fn upright(self, mesh: &Mesh, adjacency: &Adjacency, is_reference: bool) -> Self {
        if self.is_uniform {
            return self;
        }
        let mut reference = self;
        let known = |cell: usize| {
            if reference.is_valid(cell) {
                reference.sign(cell)
            } else {
                0
            }
        };
        let upright = orientations(mesh, adjacency, &known);
        let is_solid = mesh.dimension() == 3;
        let mut doubtful = Vec::new();
        reference.n_reversed = 0;
        for cell in mesh.volume_runs().flat_map(|run| run.cell_refs()) {
            let index = cell.index;
            let one = cell.uncollapsed();
            let kind = one.as_ref().map_or(cell.kind, |one| one.get(0).kind);
            let has_map = reference.maps.of(cell.kind, cell.nodes.len()).is_some();
            let is_cut =
                !has_map && !matches!(kind.linear(), CellKind::Hexahedron | CellKind::Wedge);
            if is_cut && reference.is_doubtful(index) {
                doubtful.push(index as u32);
            }
            if !(is_reference && reference.is_valid(index)) {
                let corners = &cell.nodes[..cell.kind.n_corners(cell.nodes.len())];
                let is_double = (1..corners.len()).any(|i| corners[..i].contains(&corners[i]));
                let is_double = is_double && one.is_none();
                let by = match (is_double, has_map) {
                    (true, _) => BY_VOLUME,
                    (false, true) => BY_MAP,
                    (false, false) => 1,
                };
                reference.signs[index] = upright[index] * by;
            }
            reference.n_reversed += usize::from(is_solid && reference.sign(index) < 0);
        }
        reference.doubtful = doubtful;
        let invalid = validity::invalid(mesh, &mesh.points, &reference);
        reference.n_inverted = invalid.len() + reference.n_reversed;
        reference
    }

    /// Number of cells whose corner Jacobians are not all positive in the reference: they vanish or
    /// have mixed signs, or the nodes of a solid cell are in reverse order. The last are evaluated as
    /// their mirror images; of the others only volumes are checked later, where they are positive in the reference.
    pub fn n_inverted(&self) -> usize {
        self.n_inverted
    }

    /// Returns whether all cells are valid and have the same orientation.
    pub fn is_uniform(&self) -> bool {
        self.is_uniform
    }

    /// Number of solid cells that are evaluated as mirror images, since their nodes are in reverse order.
    pub fn n_reversed(&self) -> usize {
        self.n_reversed
    }

    /// Returns whether a volume cell's corner Jacobians all have one sign in the reference. False for
    /// boundary faces, which are not evaluated.
    pub fn is_valid(&self, cell: usize) -> bool {
        matches!(self.signs[cell].abs(), 1 | BY_MAP)
    }

    /// Returns whether a cell that is valid at its corners is not proven to be so between them in the reference: later it
    /// is checked at its corners only.
    pub fn is_doubtful(&self, cell: usize) -> bool {
        !self.doubtful.is_empty() && self.doubtful.binary_search(&(cell as u32)).is_ok()
    }

    /// Returns whether a cell that is not valid in the reference has a positive volume there; only its volume is checked later.
    pub fn is_judged_by_volume(&self, cell: usize) -> bool {
        self.signs[cell].abs() == BY_VOLUME
    }

    /// Returns whether a cell is inverted at its corners, or by its volume where only that is checked.
    #[inline]
    pub(super) fn is_inverted(&self, cell: usize, metrics: &Metrics) -> bool {
        let sign = self.sign(cell);
        match self.signs[cell].abs() {
            1 => !metrics.is_valid(sign),
            BY_VOLUME => metrics.volume(sign).is_nan() || metrics.volume(sign) <= 0.0,
            _ => false,
        }
    }

    /// 1 or -1: the orientation in the reference, for an invalid cell the sign of its volume.
    #[inline]
    pub fn sign(&self, cell: usize) -> i8 {
        self.signs[cell].signum()
    }

    /// Signs of the cells from `first` on: [`Self::sign`], doubled for invalid cells, three times it for
    /// cells whose volume is checked.
    #[inline]
    pub(super) fn signs_from(&self, first: usize) -> &[i8] {
        &self.signs[first..]
    }

    /// Returns the cells in a range that list a node twice and are measured as what they are.
    pub(super) fn collapsed(&self, cells: Range<usize>) -> &[u32] {
        let before = |end: usize| {
            self.collapsed
                .partition_point(|&cell| (cell as usize) < end)
        };
        &self.collapsed[before(cells.start)..before(cells.end)]
    }

    /// The maps of the curved cells that are checked.
    pub fn maps(&self) -> &CurvedMaps {
        &self.maps
    }

    pub(super) fn facing(&self) -> &Facing {
        &self.facing
    }
}

/// Replaces the signs of curved cells that are proven to be valid or folded.
fn mark_curved(mesh: &Mesh, maps: &CurvedMaps, signs: &mut [i8]) {
    if maps.is_empty() {
        return;
    }
    let n_cells = signs.len();
    let mark = |chunk, signs: &mut [i8]| {
        let range = block(n_cells, CHUNK, chunk);
        let first = range.start;
        for run in mesh.volume_runs_in(range) {
            let Some(map) = maps.of(run.kind, run.n_nodes) else {
                continue;
            };
            for cell in run.cell_refs() {
                let sign = &mut signs[cell.index - first];
                *sign = match map.prove(cell.nodes, &mesh.points, sign.signum()) {
                    Proof::Valid => sign.signum() * BY_MAP,
                    Proof::Inside | Proof::Corner if sign.abs() == 1 => sign.signum() * BY_VOLUME,
                    Proof::Inside | Proof::Corner | Proof::Unproven => *sign,
                };
            }
        }
    };
    parallel::for_items(signs.chunks_mut(CHUNK), &mark);
}

pub(super) fn facing(mesh: &Mesh) -> Facing {
    if mesh.dimension() != 2 || mesh.is_level() {
        return Facing::Z;
    }
    let mut normals = vec![[0.0f32; 3]; mesh.cells.len()];
    for run in mesh.volume_runs() {
        let n_corners = run.kind.n_corners(run.n_nodes);
        for (cell, nodes) in (run.first_cell..).zip(run.cells()) {
            let area = vector_area(n_corners, |i| mesh.points[nodes[i] as usize]);
            normals[cell] = unit(area).unwrap_or_default().map(|x| x as f32);
        }
    }
    Facing::Normals(normals)
}
