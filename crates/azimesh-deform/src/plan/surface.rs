//! The surface nodes as interpolation data: in the order of a space-filling curve, with distinct positions, and with the
//! facets between them.

use crate::motion::{Role, Surface, SurfaceNodes};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::{curve, vector::Vector};
use azimesh_core::parallel::{BLOCK, collect, concat_blocks, filter_map};
use azimesh_io::mesh::facets::facets;
use azimesh_io::mesh::{Boundary, CellKind, CellRef, Cells, Numbering};
use azimesh_quality::FaceTerms;
use azimesh_rbf::constraint::Constraint;
use azimesh_rbf::images::Images;
use azimesh_rbf::modes::RigidSurface;
use azimesh_rbf::slide::{CurvedFace, FaceMap, Sliding, SlidingFacets};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Facets of a face by its kind and number of nodes.
type Splits = BTreeMap<(CellKind, usize), Vec<[usize; 3]>>;

/// Distinct surface points with the body each moves with.
#[derive(Debug, Clone, Default)]
pub struct SurfacePoints {
    /// Mesh node of each point; the lowest of several at one position.
    pub nodes: Vec<u32>,
    /// Their positions in the reference mesh.
    pub points: Vec<Vector>,
    /// The body each moves with; `None` stays.
    pub body: Vec<Option<u16>>,
    /// Triangles between the points; in the plane edges, with the second corner repeated.
    pub facets: Vec<[u32; 3]>,
    /// Number of surface nodes at the position of another.
    pub n_coincident: usize,
    /// For each surface node of the motion, its point.
    pub point_of: Vec<u32>,
    /// Facets of sliding boundaries.
    pub sliding_facets: SlidingFacets,
    /// The periodic images of the points.
    pub images: Images,
    /// Constraints of sliding points; `None` if there are none.
    pub sliding: Option<Sliding>,
}

impl SurfacePoints {
    /// Builds the points of a surface on the boundary of a mesh; `interface` has its faces that are not cells of the mesh.
    pub fn new(boundary: &Boundary, of: &Surface, interface: Option<&Cells>) -> Result<Self> {
        let SurfaceNodes { nodes, roles } = &of.nodes;
        let places = collect(nodes.len(), |at| boundary.position(nodes[at]));
        let along = curve::along(&places);
        let same = first_at_each_place(&places, &along);
        check_roles(nodes, roles, &same)?;
        let kept = filter_map(along.len(), |i| {
            let at = along[i].1;
            (same[at as usize] == at).then_some(at)
        });
        drop(along);
        let mut point_of = vec![u32::MAX; nodes.len()];
        for (&at, point) in kept.iter().zip(0..) {
            point_of[at as usize] = point;
        }
        let mut surface = Self {
            nodes: collect(kept.len(), |i| nodes[kept[i] as usize]),
            points: collect(kept.len(), |i| places[kept[i] as usize]),
            body: collect(kept.len(), |i| body_of(roles[kept[i] as usize])),
            point_of: collect(same.len(), |at| point_of[same[at] as usize]),
            ..Self::default()
        };
        surface.n_coincident = nodes.len() - surface.nodes.len();
        surface.add_facets(boundary, of, interface);
        surface.sliding = surface.find_sliding(&of.nodes, &surface.points);
        Ok(surface)
    }

    /// Builds the sliding points with the surface points at given positions; `None` if there are none.
    pub fn find_sliding(&self, nodes: &SurfaceNodes, points: &[Vector]) -> Option<Sliding> {
        let mut slides = vec![false; points.len()];
        for (role, &point) in nodes.roles.iter().zip(&self.point_of) {
            slides[point as usize] |= *role == Role::Sliding;
        }
        slides
            .contains(&true)
            .then(|| Sliding::new(points, &self.sliding_facets, &slides, &self.images))
    }

    /// Continues the surface by periodic images.
    pub fn set_images(&mut self, nodes: &SurfaceNodes, images: Images) {
        self.images = images;
        if self.sliding.is_some() && !self.images.maps.is_empty() {
            self.sliding = self.find_sliding(nodes, &self.points);
        }
    }

    fn add_facets(&mut self, boundary: &Boundary, of: &Surface, interface: Option<&Cells>) {
        let numbering = Numbering::new(&of.nodes.nodes);
        let point_at = |node: u32| match numbering.place(node) {
            Some(at) => self.point_of[at],
            None => u32::MAX,
        };
        let faces = &of.faces;
        let interface = || interface.into_iter().flat_map(Cells::iter);
        let tagged = faces.cells.iter();
        let tagged = tagged.map(|&cell| boundary.face(cell as usize));
        let splits = splits(tagged.chain(interface()));
        let facets = |face: CellRef<'_>| {
            let split = &splits[&(face.kind, face.nodes.len())];
            let point = |i: usize| point_at(face.nodes[i]);
            let facets = split.iter().map(|facet| facet.map(point));
            facets
                .filter(|facet| !facet.contains(&u32::MAX))
                .collect::<Vec<_>>()
        };
        self.facets = concat_blocks(faces.cells.len(), BLOCK, &|range| {
            let cells = faces.cells[range].iter();
            cells
                .flat_map(|&cell| facets(boundary.face(cell as usize)))
                .collect()
        });
        let mut maps = BTreeMap::new();
        let sliding = &mut self.sliding_facets;
        for (at, &cell) in faces.cells.iter().enumerate() {
            if faces.roles[at] != Role::Sliding {
                continue;
            }
            let face = boundary.face(cell as usize);
            let nodes: Vec<u32> = face.nodes.iter().map(|&node| point_at(node)).collect();
            let map: &Option<Arc<FaceMap>> = maps
                .entry((face.kind, nodes.len()))
                .or_insert_with(|| face_map(face));
            let map = map.clone().filter(|_| !nodes.contains(&u32::MAX));
            let number = map
                .as_ref()
                .map_or(u32::MAX, |_| sliding.curved.len() as u32);
            for facet in facets(face) {
                sliding.corners.push(facet);
                sliding.tags.push(faces.tags[at]);
                sliding.faces.push(number);
            }
            sliding
                .curved
                .extend(map.map(|map| CurvedFace { nodes, map }));
        }
        self.facets.extend(interface().flat_map(facets));
    }

    /// Returns the directions in which each point is held; `None` if none slides.
    pub fn constraints(&self, sliding: Option<&Sliding>) -> Option<Arc<Vec<Constraint>>> {
        let sliding = sliding?;
        let points = 0..self.points.len();
        Some(Arc::new(points.map(|i| sliding.constraint(i)).collect()))
    }

    /// Returns the directions in which the rotation vectors of the points are held; `None` for all of them.
    pub fn rotation_constraints(&self) -> Option<Arc<Vec<Constraint>>> {
        let sliding = self.sliding.as_ref()?;
        let points = 0..self.points.len();
        let held: Vec<Constraint> = points.map(|i| sliding.rotation_constraint(i)).collect();
        let free = held.iter().any(|held| *held != Constraint::ALL);
        free.then(|| Arc::new(held))
    }

    /// Returns the positions of the points of a body.
    pub fn points_of(&self, body: usize) -> Vec<Vector> {
        let points = self.points.iter().zip(&self.body);
        let own = points.filter(|(_, of)| of.map(usize::from) == Some(body));
        own.map(|(point, _)| *point).collect()
    }

    /// Returns the points with the body of each.
    pub fn rigid(&self) -> RigidSurface<'_> {
        RigidSurface {
            points: &self.points,
            body: &self.body,
        }
    }

    /// Returns the indices of given mesh nodes among the surface points.
    pub fn find(&self, nodes: &[u32]) -> Result<Vec<usize>> {
        let mut sorted: Vec<(u32, usize)> = self.nodes.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let find = |node: &u32| {
            let at = sorted
                .binary_search_by_key(node, |entry| entry.0)
                .map_err(|_| {
                    Error::input(format!(
                        "base point {node} is not a surface node of this mesh and schedule"
                    ))
                })?;
            Ok(sorted[at].1)
        };
        nodes.iter().map(find).collect()
    }
}

fn body_of(role: Role) -> Option<u16> {
    match role {
        Role::Moving(body) => Some(body),
        Role::Fixed | Role::Sliding => None,
    }
}

/// Returns for each position the first equal position; `along` has them along the curve, where equal positions have
/// equal curve coordinates.
fn first_at_each_place(places: &[Vector], along: &[(u64, u32)]) -> Vec<u32> {
    let bits = |i: u32| places[i as usize].map(|x| (x + 0.0).to_bits());
    let mut first: Vec<u32> = (0..places.len() as u32).collect();
    let mut near: Vec<u32> = Vec::new();
    for cell in along.chunk_by(|a, b| a.0 == b.0) {
        if cell.len() == 1 {
            continue;
        }
        near.clear();
        near.extend(cell.iter().map(|(_, i)| *i));
        near.sort_unstable_by_key(|&i| (bits(i), i));
        for group in near.chunk_by(|&a, &b| bits(a) == bits(b)) {
            for &i in group {
                first[i as usize] = group[0];
            }
        }
    }
    first
}

fn check_roles(nodes: &[u32], roles: &[Role], same: &[u32]) -> Result<()> {
    for (i, &first) in same.iter().enumerate() {
        let first = first as usize;
        if roles[i] != roles[first] {
            return Err(Error::input(format!(
                "nodes {} and {} lie at the same place and have different roles, so the mesh would tear there; \
                 merge the nodes or give their tags the same role",
                nodes[first], nodes[i]
            )));
        }
    }
    Ok(())
}

/// Returns the polynomial map of a kind of face; `None` if its facets stand for it.
fn face_map(face: CellRef<'_>) -> Option<Arc<FaceMap>> {
    let terms = FaceTerms::new(face.kind, face.nodes.len())?;
    Some(Arc::new(FaceMap {
        places: terms.places,
        exponents: terms.exponents,
        shares: terms.shares,
    }))
}

/// Returns the facets of every kind of face among the cells, by kind and number of nodes.
fn splits<'a>(cells: impl Iterator<Item = CellRef<'a>>) -> Splits {
    let mut splits = Splits::new();
    let mut last = None;
    for cell in cells {
        let key = (cell.kind, cell.nodes.len());
        if last != Some(key) {
            let split = || facets(key.0, key.1);
            splits.entry(key).or_insert_with(split);
            last = Some(key);
        }
    }
    splits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_at_one_place_are_found_whatever_the_sign_of_zero() {
        let places = [[0.0, 1.0, 2.0], [5.0, 0.0, 0.0], [-0.0, 1.0, 2.0]];
        assert_eq!(
            first_at_each_place(&places, &curve::along(&places)),
            [0, 1, 0]
        );
    }
}
