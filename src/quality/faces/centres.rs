//! Centres and volumes of all cells with nodes at given positions. Those of triangles and tetrahedra
//! are computed on demand, which is as fast as looking them up.

use super::super::facing::Facing;
use super::super::plane::vector_area;
use super::super::reference::Reference;
use super::geometry::{self, Centre, Face};
use crate::geometry::vector::{Vector, dot, scale, unit};
use crate::mesh::sides::for_each_side;
use crate::mesh::{CellKind, CellRef, CellRun, Mesh};
use crate::parallel;
use multiversion::multiversion;

/// Cells that one task works on.
const CHUNK: usize = 4096;
/// Cells side by side in vectors.
const BLOCK: usize = 64;

/// Centres of the cells of a mesh's own dimension.
pub(super) struct Centres<'a> {
    pub mesh: &'a Mesh,
    pub points: &'a [Vector],
    reference: &'a Reference,
    dimension: u8,
    /// For each run of cells, where those of its cells begin in `stored`.
    starts: Vec<usize>,
    stored: Vec<Centre>,
}

/// Cells whose centres are not stored.
pub(super) fn is_simplex(kind: CellKind) -> bool {
    matches!(kind.linear(), CellKind::Triangle | CellKind::Tetrahedron)
}

impl<'a> Centres<'a> {
    pub(super) fn new(mesh: &'a Mesh, points: &'a [Vector], reference: &'a Reference) -> Self {
        let dimension = mesh.dimension();
        let n_stored = |run: &CellRun| {
            if run.kind.dimension() == dimension && !is_simplex(run.kind) {
                run.n_cells()
            } else {
                0
            }
        };
        let mut n = 0;
        let starts = mesh.cells.runs().map(|run| {
            let start = n;
            n += n_stored(&run);
            start
        });
        let mut centres = Self {
            starts: starts.collect(),
            mesh,
            points,
            reference,
            dimension,
            stored: Vec::new(),
        };
        let mut stored = vec![Centre::default(); n];
        let mut rest = &mut stored[..];
        let mut tasks = Vec::new();
        let n_cells = mesh.cells.len();
        for first in (0..n_cells).step_by(CHUNK) {
            let cells = first..(first + CHUNK).min(n_cells);
            let n = mesh
                .cells
                .runs_in(cells.clone())
                .map(|run| n_stored(&run))
                .sum();
            let (own, others) = rest.split_at_mut(n);
            rest = others;
            tasks.push((cells, own));
        }
        parallel::for_items(tasks, &|_, (cells, mut own)| {
            for run in mesh.cells.runs_in(cells) {
                let (now, later) = own.split_at_mut(n_stored(&run));
                centres.fill(&run, now);
                own = later;
            }
        });
        centres.stored = stored;
        centres
    }

    fn fill(&self, run: &CellRun, centres: &mut [Centre]) {
        if centres.is_empty() {
            return;
        }
        match run.kind.linear() {
            CellKind::Hexahedron => self.fill_solid::<Hexahedron, 8>(run, centres),
            CellKind::Wedge => self.fill_solid::<Wedge, 6>(run, centres),
            CellKind::Pyramid => self.fill_solid::<Pyramid, 5>(run, centres),
            _ => {
                for (cell, centre) in run.cell_refs().zip(centres) {
                    *centre = self.of_any(&cell);
                }
            }
        }
    }

    fn fill_solid<S: Solid<N>, const N: usize>(&self, run: &CellRun, centres: &mut [Centre]) {
        let mut corners = [[[0.0; BLOCK]; 3]; N];
        let cells = run.connectivity.chunks(BLOCK * run.n_nodes);
        for (cells, centres) in cells.zip(centres.chunks_mut(BLOCK)) {
            solid_centres::<S, N>(cells, run.n_nodes, self.points, &mut corners, centres);
        }
    }

    /// Of a quadrilateral, a polygon, a polyhedron, or a prism on more corners.
    fn of_any(&self, cell: &CellRef<'_>) -> Centre {
        let normal = self.normal(cell);
        let mut faces: Vec<Face> = Vec::new();
        for_each_side(&self.mesh.cells, cell, |_, corners| {
            let corner = |i: usize| self.points[corners[i] as usize];
            faces.push(geometry::face(corners.len(), corner, normal));
        });
        geometry::cell(&faces, self.dimension)
    }

    /// Normal of a plane cell; of no meaning for a solid one.
    #[inline]
    pub(super) fn normal(&self, cell: &CellRef<'_>) -> Vector {
        let facing = self.reference.facing();
        let toward = facing.of(cell.index);
        if self.dimension != 2 || matches!(facing, Facing::Z) {
            return toward;
        }
        let n_corners = cell.kind.n_corners(cell.nodes.len());
        let area = vector_area(n_corners, |i| self.points[cell.nodes[i] as usize]);
        let normal = unit(area).unwrap_or(toward);
        scale(normal, 1f64.copysign(dot(normal, toward)))
    }
}

/// Looks up cells that are mostly near the last one.
pub(super) struct Finder<'a> {
    centres: &'a Centres<'a>,
    run: CellRun<'a>,
    end: usize,
    start: usize,
    form: Form,
    turn: f64,
}

/// How centres of a run's cells are had.
#[derive(Clone, Copy)]
enum Form {
    Triangle,
    Tetrahedron,
    Stored,
}

impl<'a> Finder<'a> {
    /// For a mesh that has cells.
    pub(super) fn new(centres: &'a Centres<'a>, cell: usize) -> Self {
        let run = centres.mesh.cells.run(0);
        let mut finder = Self {
            centres,
            run,
            end: 0,
            start: 0,
            form: Form::Stored,
            turn: 1.0,
        };
        finder.go_to(cell);
        finder
    }

    #[cold]
    fn go_to(&mut self, cell: usize) {
        let at = self.centres.mesh.cells.run_of(cell);
        self.run = self.centres.mesh.cells.run(at);
        self.end = self.run.first_cell + self.run.n_cells();
        self.start = self.centres.starts[at];
        self.form = match self.run.kind.linear() {
            CellKind::Triangle => Form::Triangle,
            CellKind::Tetrahedron => Form::Tetrahedron,
            _ => Form::Stored,
        };
        // The only kind whose faces point inward where the Verdict library has it positive.
        let is_wedge = self.run.kind.linear() == CellKind::Wedge;
        self.turn = if is_wedge { -1.0 } else { 1.0 };
    }

    /// Centre of a cell, its volume positive for the orientation that it has in the reference mesh; and
    /// 1 where its faces point outward there as its kind lists them, else -1.
    #[inline(always)]
    pub(super) fn centre(&mut self, cell: usize) -> (Centre, f64) {
        if cell < self.run.first_cell || cell >= self.end {
            self.go_to(cell);
        }
        let n = self.run.n_nodes;
        let at = cell - self.run.first_cell;
        let nodes = &self.run.connectivity[at * n..at * n + n];
        let point = |node: u32| self.centres.points[node as usize];
        let centre = match self.form {
            Form::Tetrahedron => {
                let nodes = nodes.first_chunk::<4>().expect("a cell has its corners");
                geometry::solid_simplex(nodes.map(point))
            }
            Form::Triangle => {
                let cell = CellRef {
                    index: cell,
                    kind: self.run.kind,
                    nodes,
                };
                let nodes = nodes.first_chunk::<3>().expect("a cell has its corners");
                geometry::plane_simplex(nodes.map(point), self.centres.normal(&cell))
            }
            Form::Stored => self.centres.stored[self.start + at],
        };
        let outward = self.turn * f64::from(self.centres.reference.sign(cell));
        let volume = centre.volume * outward;
        (Centre { volume, ..centre }, outward)
    }
}

/// A kind of solid cell with `N` corners.
trait Solid<const N: usize> {
    fn centre(corner: impl Fn(usize) -> Vector) -> Centre;
}

#[inline(always)]
fn tri(corner: &impl Fn(usize) -> Vector, nodes: [usize; 3]) -> Face {
    geometry::triangle(corner(nodes[0]), corner(nodes[1]), corner(nodes[2]))
}

#[inline(always)]
fn quad(corner: &impl Fn(usize) -> Vector, nodes: [usize; 4]) -> Face {
    geometry::polygon(4, |i| corner(nodes[i]))
}

macro_rules! solids {
    ($($name:ident $n:literal: $($face:ident $nodes:expr),+;)*) => {
        $(
            struct $name;

            impl Solid<$n> for $name {
                #[inline(always)]
                fn centre(corner: impl Fn(usize) -> Vector) -> Centre {
                    geometry::cell(&[$($face(&corner, $nodes)),+], 3)
                }
            }
        )*
    };
}

// As in `CellKind::faces`.
solids! {
    Hexahedron 8: quad [0, 4, 7, 3], quad [1, 2, 6, 5], quad [0, 1, 5, 4], quad [3, 7, 6, 2], quad [0, 3, 2, 1],
        quad [4, 5, 6, 7];
    Wedge 6: tri [0, 1, 2], tri [3, 5, 4], quad [0, 3, 4, 1], quad [1, 4, 5, 2], quad [2, 5, 3, 0];
    Pyramid 5: quad [0, 3, 2, 1], tri [0, 1, 4], tri [1, 2, 4], tri [2, 3, 4], tri [3, 0, 4];
}

/// Centres of at most [`BLOCK`] cells of `n_nodes` nodes each.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn solid_centres<S: Solid<N>, const N: usize>(
    cells: &[u32],
    n_nodes: usize,
    points: &[Vector],
    corners: &mut [[[f64; BLOCK]; 3]; N],
    centres: &mut [Centre],
) {
    for (i, nodes) in cells.chunks_exact(n_nodes).take(BLOCK).enumerate() {
        let nodes = nodes.first_chunk::<N>().expect("a cell has its corners");
        for k in 0..N {
            let point = points[nodes[k] as usize];
            for axis in 0..3 {
                corners[k][axis][i] = point[axis];
            }
        }
    }
    let mut found = [[0.0; BLOCK]; 4];
    for i in 0..BLOCK {
        let centre = S::centre(|k| [corners[k][0][i], corners[k][1][i], corners[k][2][i]]);
        found[0][i] = centre.at[0];
        found[1][i] = centre.at[1];
        found[2][i] = centre.at[2];
        found[3][i] = centre.volume;
    }
    for (i, centre) in centres.iter_mut().take(BLOCK).enumerate() {
        *centre = Centre {
            at: [found[0][i], found[1][i], found[2][i]],
            volume: found[3][i],
        };
    }
}
