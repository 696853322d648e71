//! `map` of `[body.surface]`: transfer of displacements to a body from points that are not its nodes.

use super::OnMesh;
use super::nodes::At;
use super::surface::Rows;
use crate::motion::keys::names;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, norm};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_io::mesh::{Mesh, facets::facets};
use azimesh_rbf::SurfaceMap;
use std::collections::HashMap;
use std::path::Path;

/// Distance from the given points beyond which a node is out of their reach, as a part of their extent.
const REACH: f64 = 0.1;
/// Limits of the largest displacement of a node over the largest displacement of a given point: above the first a
/// note reports it, above the second it is an error.
const GROWTH: [f64; 2] = [2.0, 10.0];

/// Method of transferring displacements from points that are not nodes of the body to its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapMethod {
    /// Radial basis functions with a linear polynomial on overlapping patches. Exact for rigid motions.
    Rbf,
    /// The displacement of the nearest point.
    Nearest,
    /// The displacement of the nearest point on the faces of a mesh; the offset turns with the face. Exact for rigid motions.
    Plane,
}

names! {
    MapMethod { "rbf" => Rbf, "nearest" => Nearest, "plane" => Plane }
}

/// Points with a displacement in every set, and the facets between them, where they are known.
pub(super) struct GivenPoints {
    points: Vec<Vector>,
    facets: Vec<[u32; 3]>,
    sets: Vec<Vec<Vector>>,
}

impl GivenPoints {
    /// Reads a table: every set needs a row for every point. `which` names a set in errors.
    pub fn of_rows(rows: &Rows<'_>, which: impl Fn(usize) -> String) -> Result<Self> {
        let table = rows.table;
        let mut known: HashMap<[u64; 3], usize> = HashMap::new();
        let mut points: Vec<(Vector, usize)> = Vec::new();
        let mut found: Vec<Vec<Option<(Vector, usize)>>> = vec![Vec::new(); rows.places.len()];
        for row in 0..table.n_rows() {
            let At::Place(x) = rows.place.at(table, row)? else {
                let message = "a `map` needs the places x, y, z of the points; the table has the column `node`";
                return Err(table.header_error(message.to_owned()));
            };
            let at = *known
                .entry(x.map(|x| (x + 0.0).to_bits()))
                .or_insert(points.len());
            if at == points.len() {
                points.push((x, row));
            }
            let set = &mut found[rows.set_of(row)];
            set.resize(set.len().max(at + 1), None);
            let value = rows.displacement(row, x);
            match set[at] {
                Some((before, line)) if before != value => {
                    let line = table.line(line);
                    let message = format!(
                        "the point of this row is given another displacement in line {line}; keep one of the rows"
                    );
                    return Err(table.error(row, message));
                }
                _ => set[at] = Some((value, row)),
            }
        }
        let mut sets = Vec::new();
        for (at, mut set) in found.into_iter().enumerate() {
            set.resize(points.len(), None);
            if let Some(missing) = set.iter().position(Option::is_none) {
                let (x, row) = points[missing];
                let message = format!(
                    "the point ({}) of this row has no row{}; every set needs a row for each of the {} points",
                    x.map(short).join(", "),
                    which(at),
                    points.len()
                );
                return Err(table.error(row, message));
            }
            sets.push(set.into_iter().flatten().map(|(value, _)| value).collect());
        }
        let points = points.into_iter().map(|(x, _)| x).collect();
        Ok(Self {
            points,
            facets: Vec::new(),
            sets,
        })
    }

    /// Reads a mesh: the nodes of its faces, or all nodes if it has no faces.
    pub fn of_mesh(mesh: &Mesh, displacements: &[Vector]) -> Self {
        let dimension = if mesh.space_dimension() == 3 { 2 } else { 1 };
        let mut all = Vec::new();
        for run in mesh
            .cells
            .runs()
            .filter(|run| run.kind.dimension() == dimension)
        {
            let pieces = facets(run.kind, run.n_nodes);
            for nodes in run.connectivity.chunks_exact(run.n_nodes) {
                all.extend(pieces.iter().map(|piece| piece.map(|i| nodes[i])));
            }
        }
        let mut used: Vec<u32> = all.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        if used.is_empty() {
            used = (0..mesh.points.len() as u32).collect();
        }
        let number = |node: u32| used.partition_point(|&other| other < node) as u32;
        let of = |values: &[Vector]| {
            used.iter()
                .map(|&node| values[node as usize])
                .collect::<Vec<_>>()
        };
        Self {
            facets: all.into_iter().map(|facet| facet.map(number)).collect(),
            points: of(&mesh.points),
            sets: vec![of(displacements)],
        }
    }

    /// Returns the displacements of the nodes of a body, and notes on the map.
    pub fn carry(
        mut self,
        method: MapMethod,
        path: &Path,
        on: &OnMesh<'_>,
    ) -> Result<(Vec<Vec<Vector>>, Vec<Note>)> {
        let nodes = on.nodes();
        let wall = &nodes.places;
        if on.in_plane()
            && let Some([.., z]) = wall.first()
        {
            self.points.iter_mut().for_each(|x| x[2] = *z);
            self.sets.iter_mut().flatten().for_each(|d| d[2] = 0.0);
        }
        let map = match method {
            MapMethod::Rbf => SurfaceMap::rbf(&self.points, wall),
            MapMethod::Nearest => SurfaceMap::nearest(&self.points, wall),
            MapMethod::Plane if self.facets.is_empty() => {
                let message = "there are no faces in the file, whose nearest points map = \"plane\" takes; give a mesh with faces, or \
                               map = \"rbf\"";
                return Err(Error::input(message).file(path));
            }
            MapMethod::Plane => SurfaceMap::plane(&self.points, &self.facets, wall),
        };
        let map = map.map_err(|error| error.file(path))?;
        let extent = Bounds::around(&self.points).diagonal();
        let mut notes = vec![
            self.distances(&map, extent, on)
                .map_err(|error| error.file(path))?
                .file(path),
        ];
        let mut sets = Vec::new();
        let largest = |set: &[Vector]| set.iter().map(|d| norm(*d)).fold(0.0, f64::max);
        let (mut given, mut carried) = (0.0, 0.0);
        for set in &self.sets {
            let at_nodes = map.displacements(set).map_err(|error| error.file(path))?;
            given = f64::max(given, largest(set));
            carried = f64::max(carried, largest(&at_nodes));
            sets.push(at_nodes);
        }
        if carried > GROWTH[0] * given {
            let message = format!(
                "nodes of body \"{}\" are displaced by up to {}, given points by up to {}: they lie beyond the given points, whose \
                 displacements are extrapolated",
                on.body.name,
                short(carried),
                short(given)
            );
            if carried > GROWTH[1] * given {
                let remedy = "; give points near all nodes of the body, or map = \"nearest\"";
                return Err(Error::input(message + remedy).file(path));
            }
            notes.push(Note::new("extrapolated", message).file(path));
        }
        Ok((sets, notes))
    }

    /// Returns a note on the distance between the two surfaces; an error where they cannot match.
    fn distances(&self, map: &SurfaceMap, extent: f64, on: &OnMesh<'_>) -> Result<Note> {
        let distances = map.distances();
        let farthest = distances.iter().copied().fold(0.0, f64::max);
        let (body, n_points) = (&on.body.name, self.points.len());
        if farthest > extent {
            return Err(Error::input(format!(
                "nodes of body \"{body}\" are up to {} from the {n_points} points, which extend over {}: check the unit of \
                 their coordinates and their origin",
                short(farthest),
                short(extent)
            )));
        }
        let n_far = distances
            .iter()
            .filter(|away| **away > REACH * extent)
            .count();
        let far = match n_far {
            0 => String::new(),
            n => format!(
                "; {n} of them are more than {} away, a tenth of the extent of the points",
                short(REACH * extent)
            ),
        };
        let note = note!(
            "surface_map",
            "body \"{body}\": the displacements of {n_points} points are carried to {} nodes, which are up to {} away{far}",
            distances.len(),
            short(farthest)
        );
        Ok(note
            .with("body", body.as_str())
            .with("points", n_points)
            .with("nodes", distances.len())
            .with("largest_distance", farthest)
            .with("far_nodes", n_far))
    }
}
