//! The boundary tag nearest to a position.

use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{Mesh, facets::facets};

/// The tagged boundary faces as triangles, or as edges in 2D.
pub struct TaggedSurface<'a> {
    facets: Vec<[u32; 3]>,
    /// Each tag with the end of its facets.
    tags: Vec<(&'a str, usize)>,
}

impl<'a> TaggedSurface<'a> {
    /// Of a mesh, or of a part of one.
    pub fn new(mesh: &'a Mesh) -> Self {
        let (mut all, mut tags) = (Vec::new(), Vec::new());
        for tag in mesh.boundary_tags() {
            let ranges = tag.cells.ranges();
            for run in ranges.flat_map(|range| mesh.cells.runs_in(range)) {
                let pieces = facets(run.kind, run.n_nodes);
                let corners = run
                    .cells()
                    .flat_map(|nodes| pieces.iter().map(|piece| piece.map(|i| nodes[i])));
                all.extend(corners);
            }
            tags.push((&tag.name[..], all.len()));
        }
        Self { facets: all, tags }
    }

    /// For each position the square of the distance to the nearest tag and the place of that tag; `None` without tags.
    /// The nodes of the mesh are at `points`.
    pub fn nearest(&self, points: &[Vector], positions: &[Vector]) -> Vec<Option<(f64, usize)>> {
        let surface = ClosestSurface::new(points, &self.facets);
        let nearest = |position| {
            let foot = surface.nearest(position, f64::INFINITY)?;
            let tag = self.tags.partition_point(|(_, end)| *end <= foot.facet);
            Some((foot.distance_squared, tag))
        };
        positions.iter().map(nearest).collect()
    }

    /// Name of the tag at a place.
    pub fn name(&self, tag: usize) -> &'a str {
        self.tags[tag].0
    }
}
