//! Centres and volumes of all cells with nodes at given positions, volumes positive for the orientation of a cell
//! in the reference mesh. Triangles and tetrahedra are computed on demand, which is as fast as looking them up.

use super::super::facing::Facing;
use super::super::plane::vector_area;
use super::super::reference::Reference;
use super::geometry::{self, Centre, Face};
use super::solids::{self, Hexahedron, Pyramid, Solid, Wedge};
use crate::block::{BLOCK, gather};
use azimesh_core::geometry::vector::{Vector, dot, scale, unit};
use azimesh_core::parallel;
use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{CellKind, CellRef, CellRun, Cells, Mesh};

/// Cells that one task works on.
const CHUNK: usize = 4096;

/// Centres of the cells of a mesh's own dimension.
pub(super) struct Centres<'a> {
    pub mesh: &'a Mesh,
    pub points: &'a [Vector],
    reference: &'a Reference,
    dimension: u8,
    /// For each run of cells, the index in `stored` of its first cell.
    starts: Vec<usize>,
    pub stored: Vec<Centre>,
}

/// Cells whose centres are not stored.
pub(super) fn is_simplex(kind: CellKind) -> bool {
    matches!(kind.linear(), CellKind::Triangle | CellKind::Tetrahedron)
}

impl<'a> Centres<'a> {
    /// `stored` is memory that was used before.
    pub(super) fn new(
        mesh: &'a Mesh,
        points: &'a [Vector],
        reference: &'a Reference,
        mut stored: Vec<Centre>,
    ) -> Self {
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
        if stored.len() != n {
            stored = parallel::collect(n, |_| Centre::default());
        }
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
            CellKind::Hexahedron => self.fill_solid::<Hexahedron, 8, 6>(run, centres),
            CellKind::Wedge => self.fill_solid::<Wedge, 6, 5>(run, centres),
            CellKind::Pyramid => self.fill_solid::<Pyramid, 5, 5>(run, centres),
            _ => {
                for (cell, centre) in run.cell_refs().zip(centres.iter_mut()) {
                    *centre = self.of_any(&self.mesh.cells, &cell, self.normal(&cell));
                }
            }
        }
        for &cell in self.reference.collapsed(run.range()) {
            let listed = self.mesh.cells.get(cell as usize);
            if let Some(one) = listed.uncollapsed() {
                let normal = self.normal(&listed);
                centres[cell as usize - run.first_cell] = self.of_any(&one, &one.get(0), normal);
            }
        }
        for (cell, centre) in (run.first_cell..).zip(centres) {
            centre.volume *= f64::from(self.reference.sign(cell));
        }
    }

    fn fill_solid<S: Solid<N, F>, const N: usize, const F: usize>(
        &self,
        run: &CellRun,
        centres: &mut [Centre],
    ) {
        let mut corners = [[[0.0; BLOCK]; 3]; N];
        let mut found = [[0.0; BLOCK]; 4];
        let cells = run.connectivity.chunks(BLOCK * run.n_nodes);
        for (cells, centres) in cells.zip(centres.chunks_mut(BLOCK)) {
            gather(cells, run.n_nodes, self.points, &mut corners);
            solids::centres::<S, N, F>(&corners, &mut found);
            for (i, centre) in centres.iter_mut().enumerate() {
                *centre = Centre {
                    at: [found[0][i], found[1][i], found[2][i]],
                    volume: found[3][i],
                };
            }
        }
    }

    /// Of a quadrilateral, a polygon, a polyhedron, or a prism on more corners.
    fn of_any(&self, cells: &Cells, cell: &CellRef<'_>, normal: Vector) -> Centre {
        let mut faces: Vec<Face> = Vec::new();
        for_each_side(cells, cell, |_, corners| {
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
}

/// Source of the centres of a run's cells.
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
    }

    /// 1 where the faces of a cell point outward in the reference mesh as its kind lists them, else -1.
    #[inline(always)]
    pub(super) fn turn(&self, cell: usize) -> f64 {
        f64::from(self.centres.reference.sign(cell))
    }

    /// Returns whether the centres of the cells of the last cell's run are computed on demand.
    pub(super) fn is_simplex(&self) -> bool {
        is_simplex(self.run.kind)
    }

    /// Centre of a cell.
    #[inline(always)]
    pub(super) fn centre(&mut self, cell: usize) -> Centre {
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
                geometry::solid_simplex([
                    point(nodes[0]),
                    point(nodes[1]),
                    point(nodes[2]),
                    point(nodes[3]),
                ])
            }
            Form::Triangle => {
                let cell = CellRef {
                    index: cell,
                    kind: self.run.kind,
                    nodes,
                };
                let nodes = nodes.first_chunk::<3>().expect("a cell has its corners");
                geometry::plane_simplex(
                    [point(nodes[0]), point(nodes[1]), point(nodes[2])],
                    self.centres.normal(&cell),
                )
            }
            Form::Stored => return self.centres.stored[self.start + at],
        };
        let volume = centre.volume * f64::from(self.centres.reference.sign(cell));
        Centre { volume, ..centre }
    }
}
