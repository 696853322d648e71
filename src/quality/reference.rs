//! How each cell of the reference mesh is oriented, so that later positions can be judged.

use super::facing::Facing;
use super::plane::vector_area;
use super::size_skew::ReferenceSizes;
use super::validity;
use super::visit::{self, CHUNK};
use crate::geometry::vector::unit;
use crate::mesh::{CellKind, Mesh};
use crate::parallel::{self, block};
use std::collections::BTreeMap;

/// Orientation of every volume cell in the reference mesh: one byte a cell, and 12 more in a
/// surface mesh that does not lie in a plane of constant z.
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
    /// Cells that are valid at their corners but not proven to be so between them, ascending.
    doubtful: Vec<u32>,
}

/// Set in addition to the sign of a cell that is not valid in the reference.
const INVALID: i8 = 2;

impl Reference {
    /// Judges every volume cell of the mesh. Cannot fail.
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
        let judge = |chunk, (signs, sizes): (&mut [i8], &mut [f64])| {
            let range = block(n_cells, CHUNK, chunk);
            let first = range.start;
            visit::volume_cells(mesh, &mesh.points, &facing, range, |start, block| {
                for i in 0..block.n {
                    let valid = block.get(i).orientation();
                    let sign = if block.volume[i] < 0.0 { -1 } else { 1 };
                    let known = if valid == 0 { INVALID * sign } else { valid };
                    signs[start + i - first] = known;
                    if valid != 0 {
                        sizes[start + i - first] = block.size[i];
                    }
                }
            });
        };
        let chunks = signs.chunks_mut(CHUNK).zip(sizes.chunks_mut(CHUNK));
        parallel::for_items(chunks, &judge);
        let own = &signs[mesh.own_cells()];
        let count = |of: &(dyn Fn(i8) -> bool + Sync)| {
            let counts = parallel::map_blocks(own.len(), CHUNK, &|range| {
                own[range].iter().filter(|&&sign| of(sign)).count()
            });
            counts.into_iter().sum::<usize>()
        };
        let n_reversed = if solid { count(&|sign| sign == -1) } else { 0 };
        let n_invalid = count(&|sign| sign.abs() == INVALID);
        let [n_invalid, n_reversed] =
            mesh.ranks()
                .fold([0; 2], [n_invalid, n_reversed], |sum, own| {
                    *sum = [sum[0] + own[0], sum[1] + own[1]];
                });
        let mut reference = Self {
            signs,
            facing,
            n_inverted: n_invalid + n_reversed,
            n_reversed,
            doubtful: Vec::new(),
        };
        let all = 0..n_cells;
        let validity = validity::assess(mesh, &mesh.points, &reference, all);
        reference.doubtful = [validity.inside, validity.unproven].concat();
        reference.doubtful.sort_unstable();
        (reference, ReferenceSizes(sizes))
    }

    /// For a mesh whose own cells are to be made valid: every cell is judged, in the orientation that most cells of
    /// its kind have. Polyhedra of positive volume are judged by that alone.
    pub fn upright(mesh: &Mesh) -> Self {
        let mut reference = Self::new(mesh);
        let plane = mesh.dimension() == 2;
        let mut balance: BTreeMap<CellKind, i64> = BTreeMap::new();
        let group = |kind: CellKind| {
            if plane {
                CellKind::Polygon
            } else {
                kind.linear()
            }
        };
        for run in mesh.volume_runs() {
            let signs = &reference.signs[run.first_cell..run.first_cell + run.n_cells()];
            let sum: i64 = signs.iter().map(|&sign| i64::from(sign.signum())).sum();
            *balance.entry(group(run.kind)).or_default() += sum;
        }
        let mut doubtful = Vec::new();
        reference.n_reversed = 0;
        for run in mesh.volume_runs() {
            let sign = if balance[&group(run.kind)] < 0 { -1 } else { 1 };
            let cells = run.first_cell..run.first_cell + run.n_cells();
            let is_cut = !matches!(run.kind.linear(), CellKind::Hexahedron | CellKind::Wedge);
            let own = reference
                .doubtful
                .iter()
                .copied()
                .filter(|&cell| cells.contains(&(cell as usize)));
            doubtful.extend(own.filter(|_| is_cut));
            if sign < 0 && !plane {
                reference.n_reversed += run.n_cells();
            }
            reference.signs[cells].fill(sign);
        }
        doubtful.sort_unstable();
        reference.doubtful = doubtful;
        reference
    }

    /// Number of cells whose corner Jacobians are not all positive in the reference: they vanish or
    /// have mixed signs, or the nodes of a solid cell are in reverse order. The last are judged as
    /// their mirror images; the others are never counted as inverted later.
    pub fn n_inverted(&self) -> usize {
        self.n_inverted
    }

    /// Number of solid cells that are judged as their mirror images, since their nodes are in reverse order.
    pub fn n_reversed(&self) -> usize {
        self.n_reversed
    }

    /// Whether a volume cell's corner Jacobians all have one sign in the reference. False for
    /// boundary faces, which are not judged.
    pub fn is_valid(&self, cell: usize) -> bool {
        self.signs[cell].abs() == 1
    }

    /// Whether a cell that is valid at its corners is not proven to be so between them in the reference: later it
    /// is judged by its corners alone.
    pub fn is_doubtful(&self, cell: usize) -> bool {
        !self.doubtful.is_empty() && self.doubtful.binary_search(&(cell as u32)).is_ok()
    }

    /// 1 or -1: the orientation in the reference, for an invalid cell that of its volume.
    #[inline]
    pub fn sign(&self, cell: usize) -> i8 {
        self.signs[cell].signum()
    }

    /// Signs of the cells from `first` on: those of [`Self::sign`], doubled for invalid cells.
    #[inline]
    pub(super) fn signs_from(&self, first: usize) -> &[i8] {
        &self.signs[first..]
    }

    pub(super) fn facing(&self) -> &Facing {
        &self.facing
    }
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
