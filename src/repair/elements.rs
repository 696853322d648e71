//! The cells of a patch as simplices with target shapes, and the functional of one cell.
//!
//! Leaves to `patch` which nodes move, and to `newton` what is done with the derivatives.

use super::density::{Density, Space, value};
use super::shape::regular;
use super::simplices::{Edges, Simplices};
use super::singular::Columns;
use crate::geometry::vector::{Vector, add, cross, dot, scale, sub};
use crate::linear::blocks::Block;
use crate::mesh::CellKind;
use multiversion::multiversion;

/// A simplex and its target.
#[derive(Debug, Clone, Copy)]
struct Simplex {
    edges: Edges,
    /// Rows of the inverse of the target's edges.
    inverse: Columns,
    weight: f64,
}

/// Where the parts of a cell are in the lists.
#[derive(Debug, Clone, Copy)]
struct Element {
    first_node: u32,
    n_nodes: u16,
    n_means: u16,
    first_mean: u32,
    first_simplex: u32,
    n_simplices: u32,
}

/// Cells as simplices. Nodes are those of the patch.
#[derive(Debug, Clone)]
pub(super) struct Elements {
    space: Space,
    list: Vec<Element>,
    nodes: Vec<u32>,
    means: Vec<Vec<u16>>,
    simplices: Vec<Simplex>,
}

/// What a cell is to look like.
pub(super) struct Target<'a> {
    /// Corners in the reference mesh.
    pub reference: &'a [Vector],
    /// The orientation of the cell, 1 or -1.
    pub sign: f64,
    /// Whether all of its simplices must become positive. Otherwise only those that are so, and were, are kept so.
    pub whole: bool,
    /// The length of an edge where a cell has none of its own.
    pub size: f64,
    /// Whether the cell is to become regular, whatever its reference.
    pub regular: bool,
    /// Weight of each simplex.
    pub weight: f64,
}

/// A simplex of the reference flatter than this counts as flat: its determinant over the product of its edges.
const FLAT: f64 = 1e-12;

/// Derivatives of the functional of one cell with respect to its nodes, and memory for making them.
#[derive(Debug, Clone, Default)]
pub(super) struct Derivatives {
    /// The value.
    pub value: f64,
    /// The least determinant.
    pub least: f64,
    /// Simplices that are not positive.
    pub n_folded: usize,
    /// Of each node.
    pub slope: Vec<Vector>,
    /// Of nodes `a <= b` at [`pair`].
    pub blocks: Vec<Block>,
    places: Vec<Vector>,
}

/// Where the block of points `a <= b` of `n` is.
#[inline(always)]
pub(super) fn pair(n: usize, a: usize, b: usize) -> usize {
    a * (2 * n - a + 1) / 2 + b - a
}

impl Elements {
    pub(super) fn new(space: Space) -> Self {
        Self {
            space,
            list: Vec::new(),
            nodes: Vec::new(),
            means: Vec::new(),
            simplices: Vec::new(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds a cell of these nodes of the patch, which are now `at`, as far as it can be given a target. `can_move`
    /// tells of its nodes whether they can. Gives the number of its simplices that are folded and cannot move, which
    /// are left out.
    pub(super) fn push(
        &mut self,
        kind: CellKind,
        nodes: &[u32],
        simplices: Simplices,
        target: &Target<'_>,
        at: &[Vector],
        can_move: &[bool],
    ) -> usize {
        let with_means = |corners: &[Vector]| {
            let means = simplices.means.iter().map(|mean| middle(mean, corners));
            let means: Vec<Vector> = means.collect();
            [corners, &means].concat()
        };
        let reference = with_means(target.reference);
        let now = with_means(at);
        let is_good =
            |edges: &Edges| determinant(self.space, edges, &reference, target.sign) > FLAT;
        let keeps_shape = simplices
            .edges
            .iter()
            .all(|edges| is_double(edges, nodes) || is_good(edges));
        let shaped = match keeps_shape && !target.regular {
            true => None,
            false => regular(kind, target.reference, target.sign, target.size),
        };
        let shaped = shaped.map(|corners| with_means(&corners));
        let first_simplex = self.simplices.len();
        let mut n_stuck = 0;
        for edges in &simplices.edges {
            let is_double = is_double(edges, nodes);
            if is_double && shaped.is_none() {
                continue;
            }
            let positive = determinant(self.space, edges, &now, target.sign) > 0.0;
            if !(target.whole || (positive && is_good(edges))) {
                continue;
            }
            let moves = |point: u16| match simplices
                .means
                .get(usize::from(point).wrapping_sub(at.len()))
            {
                Some(mean) => mean.iter().any(|&node| can_move[usize::from(node)]),
                None => can_move[usize::from(point)],
            };
            if !edges.as_flattened().iter().any(|&point| moves(point)) {
                n_stuck += usize::from(!positive);
                continue;
            }
            let corners = shaped.as_ref().unwrap_or(&reference);
            if let Some(inverse) = self.inverse(edges, corners, target) {
                self.simplices.push(Simplex {
                    edges: *edges,
                    inverse,
                    weight: target.weight,
                });
            }
        }
        let n_simplices = self.simplices.len() - first_simplex;
        if n_simplices > 0 {
            self.list.push(Element {
                first_node: self.nodes.len() as u32,
                n_nodes: nodes.len() as u16,
                n_means: simplices.means.len() as u16,
                first_mean: self.means.len() as u32,
                first_simplex: first_simplex as u32,
                n_simplices: n_simplices as u32,
            });
            self.nodes.extend_from_slice(nodes);
            self.means.extend(simplices.means);
        }
        n_stuck
    }

    /// Rows of the inverse of the target's edges. A simplex that is folded in a reference that has no regular shape
    /// is given equal upright edges.
    fn inverse(&self, edges: &Edges, corners: &[Vector], target: &Target<'_>) -> Option<Columns> {
        let n = self.space.n_edges();
        let mut e = [[0.0, 0.0, 1.0]; 3];
        for k in 0..n {
            e[k] = edge(edges[k], corners);
        }
        if determinant(self.space, edges, corners, target.sign) <= FLAT {
            let lengths = e[..n].iter().map(|edge| dot(*edge, *edge).sqrt());
            let length = lengths.fold(0.0, f64::max);
            let length = if length > 0.0 { length } else { target.size };
            e = [
                [length, 0.0, 0.0],
                [0.0, target.sign * length, 0.0],
                [0.0, 0.0, 1.0],
            ];
            if n == 3 {
                e[2][2] = length;
            }
        }
        let normals = [cross(e[1], e[2]), cross(e[2], e[0]), cross(e[0], e[1])];
        let determinant = dot(e[0], normals[0]);
        let inverse = normals.map(|normal| scale(normal, 1.0 / determinant));
        let finite = inverse.as_flattened().iter().all(|x| x.is_finite());
        finite.then_some(inverse)
    }

    /// The nodes of a cell.
    #[inline]
    pub(super) fn nodes(&self, cell: usize) -> &[u32] {
        let element = &self.list[cell];
        let first = element.first_node as usize;
        &self.nodes[first..first + usize::from(element.n_nodes)]
    }

    fn means_of(&self, element: &Element) -> &[Vec<u16>] {
        let first = element.first_mean as usize;
        &self.means[first..first + usize::from(element.n_means)]
    }

    fn simplices_of(&self, element: &Element) -> &[Simplex] {
        let first = element.first_simplex as usize;
        &self.simplices[first..first + element.n_simplices as usize]
    }

    /// The places of the points of a cell.
    #[inline(always)]
    fn gather(&self, cell: usize, at: &[Vector], places: &mut Vec<Vector>) {
        places.clear();
        places.extend(self.nodes(cell).iter().map(|&node| at[node as usize]));
        for mean in self.means_of(&self.list[cell]) {
            places.push(middle(mean, places));
        }
    }

    /// The value of the functional of a cell, its least determinant, and how many are not positive.
    pub(super) fn value(
        &self,
        cell: usize,
        eps: f64,
        at: &[Vector],
        places: &mut Vec<Vector>,
    ) -> (f64, f64, usize) {
        self.gather(cell, at, places);
        values(self.space, eps, self.simplices_of(&self.list[cell]), places)
    }

    /// Value and derivatives of the functional of a cell.
    pub(super) fn derive(&self, cell: usize, eps: f64, at: &[Vector], found: &mut Derivatives) {
        let mut places = std::mem::take(&mut found.places);
        self.gather(cell, at, &mut places);
        let element = &self.list[cell];
        let n = places.len();
        found.slope.clear();
        found.slope.resize(n, [0.0; 3]);
        found.blocks.clear();
        found.blocks.resize(n * (n + 1) / 2, [0.0; 9]);
        derivatives(self.space, eps, self.simplices_of(element), &places, found);
        found.places = places;
        if element.n_means > 0 {
            found.condense(usize::from(element.n_nodes), self.means_of(element));
        }
    }
}

/// Whether an edge of a simplex is between nodes that are one and the same.
fn is_double(edges: &Edges, nodes: &[u32]) -> bool {
    let same = |[a, b]: [u16; 2]| {
        let node = |point: u16| nodes.get(usize::from(point));
        a != b && node(a).is_some() && node(a) == node(b)
    };
    let (n, own) = (edges.len(), |i: usize| edges[i]);
    let tips_meet = (0..n).any(|i| (0..i).any(|k| same([own(i)[1], own(k)[1]])));
    edges.iter().any(|edge| same(*edge)) || tips_meet
}

fn middle(of: &[u16], points: &[Vector]) -> Vector {
    let sum = of
        .iter()
        .fold([0.0; 3], |sum, &i| add(sum, points[usize::from(i)]));
    scale(sum, 1.0 / of.len().max(1) as f64)
}

#[inline(always)]
fn edge([from, to]: [u16; 2], points: &[Vector]) -> Vector {
    sub(points[usize::from(to)], points[usize::from(from)])
}

/// The determinant of the edges over the product of their lengths, positive for the orientation `sign`.
fn determinant(space: Space, edges: &Edges, points: &[Vector], sign: f64) -> f64 {
    let mut e = [[0.0, 0.0, 1.0]; 3];
    for k in 0..space.n_edges() {
        e[k] = edge(edges[k], points);
    }
    let lengths = e.map(|edge| dot(edge, edge).sqrt());
    let product = lengths[0] * lengths[1] * lengths[2];
    sign * dot(e[0], cross(e[1], e[2])) / product.max(f64::MIN_POSITIVE)
}

/// `J = sum_k d_k g_k^T` by columns, of edges `d` and rows `g` of the inverse of the target's.
#[inline(always)]
fn jacobian(space: Space, simplex: &Simplex, places: &[Vector]) -> Columns {
    let n = space.n_edges();
    let mut j = [[0.0; 3]; 3];
    for k in 0..n {
        let d = edge(simplex.edges[k], places);
        for column in 0..3 {
            let g = simplex.inverse[k][column];
            for axis in 0..3 {
                j[column][axis] += d[axis] * g;
            }
        }
    }
    if n == 2 {
        j[0][2] = 0.0;
        j[1][2] = 0.0;
        j[2] = [0.0, 0.0, 1.0];
    }
    j
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn values(space: Space, eps: f64, simplices: &[Simplex], places: &[Vector]) -> (f64, f64, usize) {
    let (mut sum, mut least, mut n_folded) = (0.0, f64::INFINITY, 0);
    for simplex in simplices {
        let j = jacobian(space, simplex, places);
        let (value, determinant) = value(space, eps, &j);
        sum += simplex.weight * value;
        least = f64::min(least, determinant);
        n_folded += usize::from(determinant <= 0.0);
    }
    (sum, least, n_folded)
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn derivatives(
    space: Space,
    eps: f64,
    simplices: &[Simplex],
    places: &[Vector],
    found: &mut Derivatives,
) {
    (found.value, found.least, found.n_folded) = (0.0, f64::INFINITY, 0);
    for simplex in simplices {
        let j = jacobian(space, simplex, places);
        let density = Density::new(space, eps, &j);
        found.value += simplex.weight * density.value;
        found.least = f64::min(found.least, density.determinant);
        found.n_folded += usize::from(density.determinant <= 0.0);
        match space {
            Space::Plane => found.add::<2>(simplex, &density),
            Space::Solid => found.add::<3>(simplex, &density),
        }
    }
}

impl Derivatives {
    /// Adds those of a simplex.
    #[inline(always)]
    fn add<const N: usize>(&mut self, simplex: &Simplex, density: &Density) {
        let mut right = [[0.0; 3]; N];
        let w = simplex.weight;
        for k in 0..N {
            let g = simplex.inverse[k];
            right[k] = density.right(g);
            let mut slope = [0.0; 3];
            for axis in 0..3 {
                slope[axis] = w
                    * (density.slope[0][axis] * g[0]
                        + density.slope[1][axis] * g[1]
                        + density.slope[2][axis] * g[2]);
            }
            let [from, to] = simplex.edges[k].map(usize::from);
            for axis in 0..3 {
                self.slope[to][axis] += slope[axis];
                self.slope[from][axis] -= slope[axis];
            }
        }
        let mut blocks = [[[0.0; 9]; N]; N];
        for k in 0..N {
            for l in k..N {
                let mut block = density.block(right[k], right[l]);
                for value in &mut block {
                    *value *= w;
                }
                blocks[k][l] = block;
                if l > k {
                    blocks[l][k] = transposed(&block);
                }
            }
        }
        let from = simplex.edges[0][0];
        if simplex.edges[..N].iter().all(|edge| edge[0] == from) {
            self.add_corner(usize::from(from), simplex, &blocks);
        } else {
            self.add_crossing(simplex, &blocks);
        }
    }

    /// Of edges that leave one point.
    #[inline(always)]
    fn add_corner<const N: usize>(
        &mut self,
        from: usize,
        simplex: &Simplex,
        blocks: &[[Block; N]; N],
    ) {
        let mut own = [0.0; 9];
        for k in 0..N {
            let mut column = [0.0; 9];
            for l in 0..N {
                for m in 0..9 {
                    column[m] -= blocks[l][k][m];
                }
            }
            for m in 0..9 {
                own[m] -= column[m];
            }
            let to = usize::from(simplex.edges[k][1]);
            self.add_block(from, to, &column);
            self.add_block(to, to, &blocks[k][k]);
            for l in k + 1..N {
                let other = usize::from(simplex.edges[l][1]);
                self.add_block(to, other, &blocks[k][l]);
            }
        }
        self.add_block(from, from, &own);
    }

    /// Of edges in general.
    fn add_crossing<const N: usize>(&mut self, simplex: &Simplex, blocks: &[[Block; N]; N]) {
        for k in 0..N {
            for l in 0..N {
                let [a, b] = [simplex.edges[k], simplex.edges[l]];
                for (i, row) in a.into_iter().enumerate() {
                    for (j, column) in b.into_iter().enumerate() {
                        // All pairs are met in both orders: each is counted once.
                        if row <= column {
                            let sign = if i == j { 1.0 } else { -1.0 };
                            let block = blocks[k][l].map(|x| sign * x);
                            self.add_block(usize::from(row), usize::from(column), &block);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_block(&mut self, row: usize, column: usize, block: &Block) {
        let n = self.slope.len();
        if row <= column {
            let to = &mut self.blocks[pair(n, row, column)];
            for m in 0..9 {
                to[m] += block[m];
            }
        } else {
            let to = &mut self.blocks[pair(n, column, row)];
            for (m, value) in transposed(block).into_iter().enumerate() {
                to[m] += value;
            }
        }
    }

    /// Hands what further points have on to the nodes that they are means of.
    fn condense(&mut self, n_nodes: usize, means: &[Vec<u16>]) {
        let n = self.slope.len();
        // The whole symmetric matrix; rows of means go first to rows, then columns to columns.
        let mut whole = vec![[0.0; 9]; n * n];
        for a in 0..n {
            for b in a..n {
                let block = self.blocks[pair(n, a, b)];
                whole[a * n + b] = block;
                if b > a {
                    whole[b * n + a] = transposed(&block);
                }
            }
        }
        for (i, mean) in means.iter().enumerate() {
            let (from, share) = (n_nodes + i, 1.0 / mean.len().max(1) as f64);
            for &to in mean {
                let to = usize::from(to);
                self.slope[to] = add(self.slope[to], scale(self.slope[from], share));
                for column in 0..n {
                    let block = whole[from * n + column];
                    for m in 0..9 {
                        whole[to * n + column][m] += share * block[m];
                    }
                }
            }
        }
        for (i, mean) in means.iter().enumerate() {
            let (from, share) = (n_nodes + i, 1.0 / mean.len().max(1) as f64);
            for row in 0..n_nodes {
                let block = whole[row * n + from];
                for &to in mean {
                    for m in 0..9 {
                        whole[row * n + usize::from(to)][m] += share * block[m];
                    }
                }
            }
        }
        self.slope.truncate(n_nodes);
        self.blocks.clear();
        for a in 0..n_nodes {
            for b in a..n_nodes {
                self.blocks.push(whole[a * n + b]);
            }
        }
    }
}

/// `A^T`.
#[inline(always)]
pub(super) fn transposed(a: &Block) -> Block {
    [a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]]
}
