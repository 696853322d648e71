//! A rotor of several blades: a sector for each, all alike, turned about the shaft.
//!
//! Neighbours share the nodes of the plane between them. The grid on a sector's boundary is its own
//! mirror image across the blade, so the leading side of one is the trailing side of the next.
//! Tags `blade_1`, `blade_2`, ..., `hub` and `outer`.

use super::sector::{Sector, boundary_of};
use super::shape::Shape;
use super::tube::Tube;
use super::{BladeGrid, BladeOptions};
use crate::sample::extrude::{Extrusion, layer_nodes};
use crate::sample::ray::Ray;
use crate::sample::{SizeOptions, tag};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::transform::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{Cells, Group, Mesh};

/// Part of the distance to the sector's boundary that a ray starts with along the normal: rays bend
/// early, since the nodes of the trailing edge go to a plane that is far behind it.
const START: f64 = 0.12;

/// The mesh of a rotor with `n_blades` blades, of as many nodes in all as the options say.
pub(super) fn mesh(options: &BladeOptions, n_blades: usize) -> Result<Mesh> {
    let geometry = options.shape.resolve()?;
    let sector = Sector::new(&geometry, n_blades)?;
    let size = SizeOptions {
        nodes: Some(options.size.nodes.unwrap_or(super::NODES) / n_blades)
            .filter(|_| options.size.nodes.is_some() || options.size.surface_nodes.is_none()),
        surface_nodes: options.size.surface_nodes.map(|n| n / n_blades),
        ..options.size
    };
    let grid = BladeGrid::new(&geometry, &size);
    let of_each = |error: Error| Error {
        message: format!("for each of {n_blades} blades, {}", error.message),
        ..error
    };
    let grid = grid.map_err(of_each)?;
    let (tube, n_layers) = (grid.tube, grid.n_layers);
    let order = mirrored_order(&tube);
    let shape = Shape::new(&geometry, tube);
    let rays: Vec<Ray> = parallel::map(order.len(), &|at| {
        Ray::new(
            shape.ends(Some(&sector), order[at]),
            START,
            grid.first,
            n_layers,
        )
    });
    let numbering = Numbering::new(&tube, &order, n_layers);
    let points = layer_nodes(&rays, n_layers);
    let mut place = vec![0u32; order.len()];
    for (at, &node) in order.iter().enumerate() {
        place[node] = at as u32;
    }
    let quads = tube.quads().into_iter();
    let quads = quads.map(|quad| quad.map(|node| place[node as usize]));
    let volume = Extrusion::new(quads.collect(), rays.len(), n_layers, options.cells);
    let (cells, groups) = cells(&volume, &tube, &numbering, n_blades);
    Ok(Mesh {
        points: numbering.points(&points, n_blades),
        cells,
        groups,
        ..Mesh::default()
    })
}

/// The nodes of the tube row by row, so that a node on the leading side and its mirror image on the
/// trailing side come in the same order: what is cut at the lowest node is cut alike on both.
fn mirrored_order(tube: &Tube) -> Vec<usize> {
    let (n, half) = (tube.n_loop(), tube.n_loop() / 2);
    let upper = (0..=half / 2).flat_map(|i| [i, half - i]);
    let lower = (1..=half / 2).flat_map(|i| [n - i, half + i]);
    let mut row: Vec<usize> = Vec::with_capacity(n);
    for around in upper.chain(lower) {
        // The middle of a side is its own mirror image.
        if row.last() != Some(&around) {
            row.push(around);
        }
    }
    let n_wrap = n * tube.n_rows();
    let rows = (0..n_wrap)
        .step_by(n)
        .flat_map(|first| row.iter().map(move |around| first + around));
    rows.chain(n_wrap..tube.n_nodes()).collect()
}

/// Node numbers of all sectors. A sector owns all its nodes except those on its trailing side, which belong to the previous
/// sector.
struct Numbering {
    /// Nodes of a sector in all layers but the outermost.
    n_inner: usize,
    /// Nodes of its own.
    n_own: usize,
    /// For the nodes of the outermost layer: their index among the sector's own, or on the trailing side the index of the
    /// mirror node on the leading side; and whether the sector owns them, or the previous one in the direction of rotation.
    outermost: Vec<(u32, bool)>,
}

impl Numbering {
    fn new(tube: &Tube, order: &[usize], n_layers: usize) -> Self {
        let mut n_outermost = 0;
        let mut own = vec![0u32; tube.n_nodes()];
        for &node in order {
            if !tube.is_trailing(node) {
                own[node] = n_outermost;
                n_outermost += 1;
            }
        }
        let outermost = order.iter().map(|&node| {
            let is_own = !tube.is_trailing(node);
            let owned = if is_own { node } else { tube.mirrored(node) };
            (own[owned], is_own)
        });
        let n_inner = n_layers * tube.n_nodes();
        Self {
            n_inner,
            n_own: n_inner + n_outermost as usize,
            outermost: outermost.collect(),
        }
    }

    /// The node of the mesh that is node `local` of a sector.
    fn node(&self, sector: usize, n_sectors: usize, local: u32) -> u32 {
        let Some(outermost) = (local as usize).checked_sub(self.n_inner) else {
            return (sector * self.n_own) as u32 + local;
        };
        let (place, is_own) = self.outermost[outermost];
        let back = if is_own { 0 } else { n_sectors - 1 };
        let sector = (sector + back) % n_sectors;
        (sector * self.n_own + self.n_inner) as u32 + place
    }

    /// The nodes of the mesh, from the nodes of a sector.
    fn points(&self, local: &[Vector], n_sectors: usize) -> Vec<Vector> {
        let (inner, outermost) = local.split_at(self.n_inner);
        let outermost = outermost.iter().zip(&self.outermost);
        let own: Vec<Vector> = outermost
            .filter(|(_, (_, is_own))| *is_own)
            .map(|(x, _)| *x)
            .collect();
        let mut points = Vec::with_capacity(n_sectors * self.n_own);
        for sector in 0..n_sectors {
            let angle = std::f64::consts::TAU * sector as f64 / n_sectors as f64;
            let turn = Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], angle);
            points.extend(inner.iter().chain(&own).map(|x| turn.apply(*x)));
        }
        points
    }
}

/// The cells of all sectors, then the faces of each blade, of the hub and of the outer boundary.
fn cells(
    volume: &Extrusion,
    tube: &Tube,
    numbering: &Numbering,
    n_sectors: usize,
) -> (Cells, Vec<Group>) {
    let sector = volume.cells();
    let (n_inside, n_faces) = (volume.inner().start, volume.inner().len());
    let node = |sector: usize| move |&local: &u32| numbering.node(sector, n_sectors, local);
    let mut connectivity = Vec::with_capacity(n_sectors * sector.connectivity().len());
    let mut kinds = Vec::new();
    for run in sector.runs_in(0..n_inside) {
        kinds.push((run.kind, run.n_nodes, n_sectors * run.n_cells()));
        for at in 0..n_sectors {
            connectivity.extend(run.connectivity.iter().map(node(at)));
        }
    }
    let mut groups = Vec::new();
    let mut n_cells = n_sectors * n_inside;
    let mut close = |name: String, n_added: usize| {
        groups.push(tag(&name, 2, n_cells..n_cells + n_added));
        n_cells += n_added;
    };
    for at in 0..n_sectors {
        for run in sector.runs_in(volume.inner()) {
            connectivity.extend(run.connectivity.iter().map(node(at)));
        }
        close(format!("blade_{}", at + 1), n_faces);
    }
    let faces_a_quad = n_faces / tube.n_quads();
    for name in ["hub", "outer"] {
        let quad = |face: usize| (face - volume.outer().start) / faces_a_quad;
        let faces = volume.outer();
        let faces = faces.filter(|&face| boundary_of(tube, quad(face)) == Some(name));
        let faces: Vec<usize> = faces.collect();
        for at in 0..n_sectors {
            let nodes = faces.iter().flat_map(|&face| sector.get(face).nodes);
            connectivity.extend(nodes.map(node(at)));
        }
        close(name.to_owned(), n_sectors * faces.len());
    }
    let face = sector.get(volume.inner().start);
    kinds.push((face.kind, face.nodes.len(), n_cells - n_sectors * n_inside));
    (Cells::from_connectivity(connectivity, kinds), groups)
}
