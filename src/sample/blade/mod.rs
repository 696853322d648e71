//! A rotor blade in a cylinder: a boundary-layer grid of hexahedra, wedges or tetrahedra.
//!
//! The blade's sections are NACA 0012 (rounded trailing edge), its root and tip are rounded. Every
//! node of its surface grid has a ray of nodes out to a grid of the same kind on the cylinder.
//! Tags `blade` and `outer`.

pub mod geometry;
mod shape;
mod tube;

pub use geometry::BladeShape;

use super::extrude::{CellShape, Faces, cells, layer_nodes};
use super::ray::Ray;
use super::size::SizeOptions;
use super::{Sample, tag};
use crate::error::Result;
use crate::mesh::Mesh;
use geometry::Geometry;
use rayon::prelude::*;
use shape::Shape;
use tube::Tube;

/// Cells along the span for each from leading to trailing edge.
const SPAN_TO_CHORD: f64 = 1.4;

/// Options of the sample; nodes are 60,000 unless given.
#[derive(Debug, Clone, Copy, Default)]
pub struct BladeOptions {
    /// Nodes, layers and first cell.
    pub size: SizeOptions,
    /// Measures of blade and cylinder.
    pub shape: BladeShape,
    /// Shape of the cells.
    pub cells: CellShape,
}

/// The mesh and the schedule of a rotor in forward flight.
pub fn blade(options: &BladeOptions) -> Result<Sample> {
    let geometry = options.shape.resolve()?;
    let body = Body::new(&geometry, &options.size)?;
    let faces = Faces::new(body.tube.quads(), options.cells);
    let n_nodes = body.rays.len();
    let cells = cells(&faces, n_nodes, body.n_layers, options.cells);
    let first = cells.len() - 2 * faces.len();
    let middle = first + faces.len();
    let groups = vec![
        tag("blade", 2, first..middle),
        tag("outer", 2, middle..cells.len()),
    ];
    let mesh = Mesh {
        points: layer_nodes(&body.rays, body.n_layers),
        cells,
        groups,
        ..Mesh::default()
    };
    Ok(Sample {
        mesh,
        schedule: String::new(),
    })
}

/// The rays of a blade's grid.
struct Body {
    tube: Tube,
    rays: Vec<Ray>,
    n_layers: usize,
}

impl Body {
    fn new(geometry: &Geometry, size: &SizeOptions) -> Result<Self> {
        let usual_layers = |nodes: usize| ((1.1 * (nodes as f64).cbrt()) as usize).clamp(16, 96);
        let size = size.resolve(60_000, usual_layers, 240)?;
        let tube = Tube::with_nodes(size.wall_nodes, SPAN_TO_CHORD);
        let n_layers = size.layers(tube.n_nodes());
        let shape = Shape::new(geometry, tube);
        let first = size.first_cell * geometry.chord;
        let rays = (0..tube.n_nodes())
            .into_par_iter()
            .map(|node| {
                let pair = shape.pair(node);
                Ray::new(pair.wall, pair.normal, pair.outer, first, n_layers)
            })
            .collect();
        Ok(Self {
            tube,
            rays,
            n_layers,
        })
    }
}
