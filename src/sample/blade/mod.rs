//! A rotor blade in a cylinder: a boundary-layer grid of hexahedra, wedges or tetrahedra.
//!
//! The blade's sections are NACA 0012 (rounded trailing edge), its root and tip are rounded. Every
//! node of its surface grid has a ray of nodes out to a grid of the same kind on the cylinder.
//! Tags `blade` and `outer`. A rotor of several blades has a sector for each in place of the cylinder.

pub mod geometry;
mod schedule;
mod sector;
mod several;
mod shape;
mod tube;

pub use geometry::BladeShape;

use super::extrude::{CellShape, Extrusion, layer_nodes};
use super::ray::{Ray, START};
use super::size::SizeOptions;
use super::{Sample, tag};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;
use geometry::Geometry;
use shape::Shape;
use tube::Tube;

/// Cells along the span for each from leading to trailing edge.
const SPAN_TO_CHORD: f64 = 1.4;

/// Nodes when nothing is asked for.
const NODES: usize = 60_000;

/// The fewest nodes on the wall that resolve the blade's edges.
const LEAST_WALL: usize = 240;

/// Options of the sample; nodes are 60,000 unless given.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct BladeOptions {
    /// Nodes, layers and first cell.
    #[command(flatten)]
    pub size: SizeOptions,
    /// Shape of the cells
    #[arg(long, value_enum, default_value = "hex")]
    pub cells: CellShape,
    /// Measures of blade and cylinder.
    #[command(flatten)]
    pub shape: BladeShape,
}

/// The mesh and the schedule of a rotor in forward flight.
pub fn blade(options: &BladeOptions) -> Result<Sample> {
    let geometry = options.shape.resolve()?;
    let grid = BladeGrid::new(&geometry, &options.size)?;
    let rays = grid.rays(&geometry, grid.n_layers);
    let volume = Extrusion::new(grid.tube.quads(), rays.len(), grid.n_layers, options.cells);
    let groups = vec![
        tag("blade", 2, volume.inner()),
        tag("outer", 2, volume.outer()),
    ];
    Ok(Sample {
        mesh: Mesh {
            points: layer_nodes(&rays, grid.n_layers),
            cells: volume.cells(),
            groups,
            ..Mesh::default()
        },
        schedule: schedule::blade(&geometry),
    })
}

/// The mesh and the schedule of a blade whose cylinder is a zone of its own.
///
/// The zone `rotor` is the cylinder of [`blade`], the zone `background` fills a larger one around
/// it; they share the nodes of the cylinder between them, which has no tag. Tags `blade` and
/// `farfield`.
pub fn rotor(options: &BladeOptions) -> Result<Sample> {
    let geometry = options.shape.resolve()?;
    let grid = BladeGrid::new(&geometry, &options.size)?;
    let n_around = (grid.n_layers / 5).max(2);
    let n_rotor = grid.n_layers - n_around;
    let rays = grid.rays(&geometry, n_rotor);
    let mut points = layer_nodes(&rays, n_rotor);
    points.extend(background_nodes(&geometry, &rays, n_around));
    let volume = Extrusion::new(grid.tube.quads(), rays.len(), grid.n_layers, options.cells);
    let groups = vec![
        tag("rotor", 3, volume.layers(0..n_rotor)),
        tag("background", 3, volume.layers(n_rotor..grid.n_layers)),
        tag("blade", 2, volume.inner()),
        tag("farfield", 2, volume.outer()),
    ];
    Ok(Sample {
        mesh: Mesh {
            points,
            cells: volume.cells(),
            groups,
            ..Mesh::default()
        },
        schedule: schedule::rotor(&geometry),
    })
}

/// The mesh and the schedule of a rotor with 3 to 5 blades around a hub, without a background.
pub fn rotor_of(options: &BladeOptions, n_blades: usize) -> Result<Sample> {
    let geometry = options.shape.resolve()?;
    Ok(Sample {
        mesh: several::mesh(options, n_blades)?,
        schedule: schedule::rotor_of(&geometry, n_blades),
    })
}

/// The grid on a blade and the layers around it.
struct BladeGrid {
    tube: Tube,
    n_layers: usize,
    /// Height of the wall cells, in mesh units.
    first: f64,
}

impl BladeGrid {
    fn new(geometry: &Geometry, size: &SizeOptions) -> Result<Self> {
        let usual_layers = |nodes: usize| ((1.1 * (nodes as f64).cbrt()) as usize).clamp(16, 96);
        let size = size.resolve(NODES, usual_layers, LEAST_WALL)?;
        let tube = Tube::with_nodes(size.wall_nodes, SPAN_TO_CHORD);
        Ok(Self {
            tube,
            n_layers: size.layers(tube.n_nodes()),
            first: size.first_cell * geometry.chord,
        })
    }

    /// The rays from blade to cylinder, in node order.
    fn rays(&self, geometry: &Geometry, n_layers: usize) -> Vec<Ray> {
        let shape = Shape::new(geometry, self.tube);
        parallel::map(self.tube.n_nodes(), &|node| {
            Ray::new(shape.ends(None, node), START, self.first, n_layers)
        })
    }
}

/// Nodes of the layers outside the cylinder: on straight rays that go on with the height of the
/// last layer inside.
fn background_nodes(geometry: &Geometry, rays: &[Ray], n_around: usize) -> Vec<Vector> {
    let onward: Vec<Ray> = parallel::map(rays.len(), &|i| {
        rays[i].onward(|node| geometry.cylinder.far(node), n_around)
    });
    let mut nodes = layer_nodes(&onward, n_around);
    nodes.drain(..rays.len());
    nodes
}
