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
use azimesh_io::mesh::facets::facets;
use azimesh_io::mesh::sides::side;
use azimesh_io::mesh::{CellKind, Faces, Mesh};
use azimesh_rbf::SurfaceMap;
use std::collections::HashMap;
use std::path::Path;

/// Distance from the given points beyond which a node is out of their reach, as a part of their extent.
const REACH: f64 = 0.1;
/// Limits of the largest displacement of a node over the largest displacement of a given point: above the first a
/// note reports it, above the second it is an error.
const GROWTH: [f64; 2] = [2.0, 10.0];

/// Two units of length, their ratio, and the factor within which the ratio of two extents suggests them.
const UNITS: [(f64, f64, &str, &str); 6] = [
    (1000.0, 1.6, "mm", "m"),
    (304.8, 1.1, "mm", "ft"),
    (39.37, 1.1, "in", "m"),
    (25.4, 1.1, "mm", "in"),
    (12.0, 1.1, "in", "ft"),
    (3.28, 1.1, "ft", "m"),
];
/// A ratio of extents above this one is no accident.
const NO_ACCIDENT: f64 = 20.0;

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

    /// Reads a mesh: all nodes; for `plane` the faces of its solids, its shells and their nodes.
    pub fn of_mesh(
        mesh: &Mesh,
        displacements: &[Vector],
        method: MapMethod,
        in_plane: bool,
    ) -> Self {
        let mut used: Vec<u32> = (0..mesh.points.len() as u32).collect();
        let mut all = Vec::new();
        if method == MapMethod::Plane {
            all = outer_facets(mesh, if in_plane { 1 } else { 2 });
            used = all.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
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
        let extents = [&self.points, wall].map(|of| Bounds::around(of).diagonal());
        let mut notes = vec![
            self.distances(&map, extents, on)
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

    /// Returns a note on the distance between points and nodes, whose extents are given; an error where they cannot match.
    fn distances(
        &self,
        map: &SurfaceMap,
        [extent, of_nodes]: [f64; 2],
        on: &OnMesh<'_>,
    ) -> Result<Note> {
        let distances = map.distances();
        let farthest = distances.iter().copied().fold(0.0, f64::max);
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let (body, n_points) = (&on.body.name, self.points.len());
        let all_far = nearest > of_nodes && nearest > REACH * extent;
        let units = units_off(extent, of_nodes);
        let unit_is_wrong = units.is_some() && extent > NO_ACCIDENT * of_nodes;
        if farthest > extent || all_far || unit_is_wrong && farthest > 0.5 * of_nodes {
            let hint = match units {
                Some((given, mesh)) => format!(
                    "the points may be in {given} and the mesh in {mesh}; give the unit of x, y and z in `units` of a table, or \
                     scale the file"
                ),
                None => "check the unit of their coordinates and their origin".to_owned(),
            };
            return Err(Error::input(format!(
                "nodes of body \"{body}\" are {} to {} from the {n_points} points, which extend over {}, the nodes over {}: {hint}",
                short(nearest),
                short(farthest),
                short(extent),
                short(of_nodes)
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

/// Returns the facets between the nodes of the outer faces of a mesh of this dimension: sides of solids, and shells on no solid.
fn outer_facets(mesh: &Mesh, dimension: u8) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    let mut add = |kind: CellKind, nodes: &[u32]| {
        let pieces = facets(kind, nodes.len()).into_iter();
        all.extend(pieces.map(|piece| piece.map(|i| nodes[i])));
    };
    let mut shells = |is_shell: &dyn Fn(usize) -> bool| {
        for run in mesh
            .cells
            .runs()
            .filter(|run| run.kind.dimension() == dimension)
        {
            for (at, nodes) in run.cells().enumerate() {
                if is_shell(run.first_cell + at) {
                    add(run.kind, nodes);
                }
            }
        }
    };
    if mesh.dimension() != dimension + 1 {
        shells(&|_| true);
        return all;
    }
    let faces = Faces::of(mesh);
    shells(&|cell| faces.dangling.binary_search(&(cell as u32)).is_ok());
    for face in &faces.outer {
        let cell = mesh.cells.get(face.cell as usize);
        if let Some((kind, nodes)) = side(&mesh.cells, &cell, face.face as usize) {
            add(kind, &nodes);
        }
    }
    all
}

/// Returns the units of points and mesh that the extents of the points and of the nodes suggest.
fn units_off(of_points: f64, of_nodes: f64) -> Option<(&'static str, &'static str)> {
    let ratio = of_points / of_nodes;
    UNITS
        .into_iter()
        .find_map(|(factor, within, small, large)| {
            let agrees = |of: f64| (1.0 / within..within).contains(&(ratio / of));
            let as_given = agrees(factor).then_some((small, large));
            as_given.or_else(|| agrees(1.0 / factor).then_some((large, small)))
        })
}
