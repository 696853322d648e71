//! The surfaces of the bodies, and other boundaries, in space at every frame: the data of `scene.js`.

use super::html::{count, packed};
use super::slice::colour;
use crate::record::{BodyRecord, MotionRecord};
use azimesh_core::geometry::vector::{Vector, distance, sub};
use azimesh_core::geometry::{Bounds, curve};
use azimesh_io::mesh::Mesh;
use azimesh_io::mesh::facets::facets;
use meshopt::{SimplifyOptions, simplify_decoder, simplify_sloppy_decoder};
use serde_json::{Value, json};
use std::ops::Range;

/// Largest number of coordinates of all frames together.
const COORDINATES: usize = 12_000_000;
/// Largest number of triangles of a page.
const TRIANGLES: usize = 100_000;
/// Largest number of these for boundaries that belong to no body.
const OTHERS: usize = 20_000;
/// Other boundaries that are named; the rest of them are one.
const NAMED: usize = 12;
/// Steps between the ends of a box of coordinates.
const STEPS: f64 = 65535.0;
/// Number of landmarks.
const LANDMARKS: usize = 400;

/// Single-precision coordinates of some nodes.
pub type Pose = Vec<[f32; 3]>;

/// A node of the mesh by its place in a cell: meshes of steps have the cells of the reference mesh in their order, but
/// may have further nodes.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    cell: usize,
    place: usize,
}

impl Corner {
    /// The node at a place of a cell.
    pub fn new(cell: usize, place: usize) -> Self {
        Self { cell, place }
    }

    fn node(&self, mesh: &Mesh) -> usize {
        mesh.cells.get(self.cell).nodes[self.place] as usize
    }

    /// Returns its position in a mesh.
    pub fn position(&self, mesh: &Mesh) -> Vector {
        mesh.points[self.node(mesh)]
    }
}

/// A body or a boundary.
#[derive(Debug)]
struct Part {
    name: String,
    vertices: Range<usize>,
    n_triangles: usize,
}

/// Triangles over nodes of the mesh. Each part has its own vertices, in the order of a curve through space, and its own
/// triangles, both one part after another.
#[derive(Debug, Default)]
struct Surface {
    vertices: Vec<Corner>,
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    n_given: usize,
    parts: Vec<Part>,
}

/// Reduces the number of triangles to at most `target`. Corners of the result are corners of the given triangles.
fn simplified(points: &[Vector], corners: Vec<u32>, target: usize) -> Vec<u32> {
    let most = 3 * target;
    if corners.len() <= most {
        return corners;
    }
    let middle = Bounds::around(points).centre();
    let points: Pose = points.iter().map(|x| single(sub(*x, middle))).collect();
    // Parts that meet have vertices of their own at one place, which meshopt keeps together.
    let options = SimplifyOptions::RegularizeLight | SimplifyOptions::Prune;
    let few = simplify_decoder(&corners, &points, most, f32::MAX, options, None);
    if few.len() <= most {
        return few;
    }
    simplify_sloppy_decoder(&few, &points, most, f32::MAX, None)
}

impl Surface {
    /// Collects the triangles of faces, which are cells with the index of their part.
    fn new(mesh: &Mesh, mut faces: Vec<(u32, usize)>, names: Vec<String>, target: usize) -> Self {
        faces.sort_unstable();
        let mut index = vec![u32::MAX; mesh.points.len()];
        let (mut vertices, mut labels, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        for faces in faces.chunk_by(|a, b| a.0 == b.0) {
            let first = vertices.len();
            for &(label, cell) in faces {
                let face = mesh.cells.get(cell);
                for piece in facets(face.kind, face.nodes.len()) {
                    let triangle = piece.map(|place| {
                        let vertex = &mut index[face.nodes[place] as usize];
                        if *vertex == u32::MAX || (*vertex as usize) < first {
                            *vertex = vertices.len() as u32;
                            vertices.push(Corner { cell, place });
                            labels.push(label);
                        }
                        *vertex
                    });
                    let [a, b, c] = triangle;
                    if a != b && b != c && c != a {
                        corners.extend(triangle);
                    }
                }
            }
        }
        let points: Vec<Vector> = vertices
            .iter()
            .map(|corner| corner.position(mesh))
            .collect();
        let n_given = corners.len() / 3;
        let corners = simplified(&points, corners, target);
        let mut place = vec![u32::MAX; points.len()];
        for &corner in &corners {
            place[corner as usize] = 0;
        }
        let mut order = curve::order(&points);
        order.retain(|&vertex| place[vertex as usize] == 0);
        order.sort_by_key(|&vertex| labels[vertex as usize]);
        for (at, &vertex) in (0..).zip(&order) {
            place[vertex as usize] = at;
        }
        let (triangles, _) = corners.as_chunks::<3>();
        let mut triangles: Vec<[u32; 3]> = triangles
            .iter()
            .map(|triangle| {
                let mut corners = triangle.map(|corner| place[corner as usize]);
                let least = (0..3).min_by_key(|&at| corners[at]).unwrap_or(0);
                corners.rotate_left(least);
                corners
            })
            .collect();
        triangles.sort_unstable();
        let label_of = |vertex: u32| labels[order[vertex as usize] as usize];
        let parts = (0..).zip(names).map(|(label, name)| Part {
            name,
            vertices: order.partition_point(|&vertex| labels[vertex as usize] < label)
                ..order.partition_point(|&vertex| labels[vertex as usize] <= label),
            n_triangles: triangles
                .iter()
                .filter(|triangle| label_of(triangle[0]) == label)
                .count(),
        });
        Self {
            parts: parts.collect(),
            n_given,
            vertices: order
                .iter()
                .map(|&vertex| vertices[vertex as usize])
                .collect(),
            points: order
                .iter()
                .map(|&vertex| points[vertex as usize])
                .collect(),
            triangles,
        }
    }

    fn is_decimated(&self) -> bool {
        self.triangles.len() < self.n_given
    }

    fn words(&self, what: &str) -> String {
        let (n, all) = (count(self.triangles.len()), count(self.n_given));
        if self.is_decimated() {
            format!("{n} triangles instead of the {all} of {what}")
        } else {
            format!("all {n} triangles of {what}")
        }
    }

    /// Writes the data of the script; `shown_and_turns` of each part.
    ///
    /// For each triangle: its lowest corner minus the previous triangle's, and its other corners minus the lowest. For each
    /// coordinate, in steps of the box of its part: the change since the previous frame, minus the previous vertex's change.
    fn data(&self, poses: &[Pose], shown_and_turns: &dyn Fn(usize) -> (bool, bool)) -> Value {
        let mut scales = Vec::with_capacity(self.vertices.len());
        let parts = self.parts.iter().enumerate().map(|(at, part)| {
            let points = poses.iter().flat_map(|pose| &pose[part.vertices.clone()]);
            let points: Vec<Vector> = points.map(|x| x.map(f64::from)).collect();
            let none = [[0.0; 3]];
            let Bounds { low, high } = Bounds::around(if points.is_empty() { &none[..] } else { &points });
            let step = sub(high, low).map(|extent| extent / STEPS);
            scales.resize(part.vertices.end, (low, step));
            let (shown, turns) = shown_and_turns(at);
            json!({
                "name": part.name, "from": part.vertices.start, "to": part.vertices.end, "triangles": part.n_triangles,
                "low": low, "step": step, "shown": shown, "turns": turns,
            })
        });
        let parts: Vec<Value> = parts.collect();
        let mut positions = Vec::new();
        let mut before = vec![[0u16; 3]; self.vertices.len()];
        for pose in poses {
            for axis in 0..3 {
                let mut last = 0u16;
                for ((x, (low, step)), before) in pose.iter().zip(&scales).zip(&mut before) {
                    let steps =
                        (f64::from(x[axis]) - low[axis]) / step[axis].max(f64::MIN_POSITIVE);
                    let now = steps.round() as u16;
                    let change = now.wrapping_sub(before[axis]);
                    positions.extend(change.wrapping_sub(last).to_le_bytes());
                    (last, before[axis]) = (change, now);
                }
            }
        }
        let mut triangles = Vec::new();
        let mut before = 0;
        for &[a, b, c] in &self.triangles {
            triangles.extend([a - before, b - a, c - a].map(u32::to_le_bytes).concat());
            before = a;
        }
        json!({
            "vertices": self.vertices.len(), "frames": poses.len(), "parts": parts,
            "triangles": packed(&triangles), "positions": packed(&positions),
        })
    }
}

/// Lists the faces of the bodies: body and cell, each cell once. Of a mesh of faces alone all belong to the first body.
fn faces_of(mesh: &Mesh, bodies: &[BodyRecord]) -> Vec<(u32, usize)> {
    if mesh.dimension() == 2 && !bodies.is_empty() {
        let cells = mesh
            .volume_runs()
            .flat_map(|run| run.first_cell..run.first_cell + run.n_cells());
        return cells.map(|cell| (0, cell)).collect();
    }
    let mut faces = Vec::new();
    for (label, body) in (0..).zip(bodies) {
        let tags = mesh
            .boundary_tags()
            .filter(|tag| body.tags.contains(&tag.name));
        faces.extend(
            tags.flat_map(|tag| tag.cells.iter())
                .map(|cell| (label, cell)),
        );
    }
    each_once(faces)
}

/// Sorts faces by their cells and keeps the first of each cell.
fn each_once(mut faces: Vec<(u32, usize)>) -> Vec<(u32, usize)> {
    faces.sort_unstable_by_key(|&(label, cell)| (cell, label));
    faces.dedup_by_key(|(_, cell)| *cell);
    faces
}

/// Lists the faces of boundaries that belong to no body, the largest boundary first, and the names of these.
fn other_faces(mesh: &Mesh, of_bodies: &[(u32, usize)]) -> (Vec<String>, Vec<(u32, usize)>) {
    let is_free = |cell: &usize| {
        of_bodies
            .binary_search_by_key(cell, |(_, cell)| *cell)
            .is_err()
    };
    let tags = mesh.boundary_tags().filter(|_| mesh.dimension() == 3);
    let tags = tags.map(|tag| {
        (
            &tag.name,
            tag.cells.iter().filter(is_free).collect::<Vec<_>>(),
        )
    });
    let mut tags: Vec<_> = tags.filter(|(_, cells)| !cells.is_empty()).collect();
    tags.sort_by_key(|(_, cells)| std::cmp::Reverse(cells.len()));
    let mut names: Vec<String> = tags
        .iter()
        .take(NAMED)
        .map(|(name, _)| (*name).clone())
        .collect();
    if tags.len() > NAMED {
        names.push(format!("{} other boundaries", tags.len() - NAMED));
    }
    let labelled = tags.into_iter().enumerate().flat_map(|(at, (_, cells))| {
        cells
            .into_iter()
            .map(move |cell| (at.min(NAMED) as u32, cell))
    });
    (names, each_once(labelled.collect()))
}

/// Picks corners spread over the faces of the bodies, or over all cells where these have none: enough to compare poses.
pub fn landmarks(mesh: &Mesh, bodies: &[BodyRecord]) -> Vec<Corner> {
    let mut cells: Vec<usize> = faces_of(mesh, bodies)
        .into_iter()
        .map(|(_, cell)| cell)
        .collect();
    if cells.is_empty() {
        cells = (0..mesh.cells.len()).collect();
    }
    let every = cells.len().div_ceil(LANDMARKS).max(1);
    let some = cells.into_iter().step_by(every);
    let with_nodes = some.filter(|&cell| !mesh.cells.get(cell).nodes.is_empty());
    with_nodes.map(|cell| Corner { cell, place: 0 }).collect()
}

/// The cells that have a vertex of the bodies.
#[derive(Debug)]
struct Wall {
    /// For each vertex, the index of its node among the nodes of all vertices.
    nodes: Vec<usize>,
    /// Cells, each with the index of a node.
    cells: Vec<(usize, usize)>,
}

impl Wall {
    fn new(mesh: &Mesh, vertices: &[Corner]) -> Self {
        let mut index = vec![usize::MAX; mesh.points.len()];
        let nodes: Vec<usize> = (0..)
            .zip(vertices)
            .map(|(at, vertex)| {
                let known = &mut index[vertex.node(mesh)];
                *known = at.min(*known);
                *known
            })
            .collect();
        let mut cells = Vec::new();
        for run in mesh.volume_runs() {
            for (cell, nodes) in (run.first_cell..).zip(run.cells()) {
                let known = nodes.iter().map(|&node| index[node as usize]);
                cells.extend(known.filter(|at| *at < usize::MAX).map(|at| (cell, at)));
            }
        }
        Self { nodes, cells }
    }

    /// Finds the colour of the worst cell at each vertex.
    fn colours(&self, quality: &[f64]) -> Vec<u8> {
        let mut worst = vec![0; self.nodes.len()];
        for &(cell, at) in &self.cells {
            worst[at] = colour(quality[cell]).max(worst[at]);
        }
        self.nodes.iter().map(|&at| worst[at]).collect()
    }
}

/// Surfaces, and their state at each frame. The first frame is the reference mesh.
#[derive(Debug)]
pub struct Scene {
    bodies: Surface,
    others: Surface,
    motion: MotionRecord,
    wall: Wall,
    /// The bodies in the rotating frame.
    poses: Vec<Pose>,
    /// Colours of the quality at the vertices of the bodies, as changes since the frame before.
    colours: Vec<u8>,
    last_colours: Vec<u8>,
    azimuths_deg: Vec<f64>,
    /// Position of the worst cell.
    worst: Vec<Option<Vector>>,
    /// For each other part, its distance over the frames from its place if it stayed, and if it turned.
    strayed: Vec<[f64; 2]>,
}

impl Scene {
    /// Prepares a scene of so many frames; `None` where nothing moves in space.
    pub fn new(mesh: &Mesh, motion: Option<&MotionRecord>, n_frames: usize) -> Option<Self> {
        let motion = motion?.clone();
        let faces = faces_of(mesh, &motion.bodies);
        if mesh.space_dimension() != 3 || faces.is_empty() {
            return None;
        }
        let (names, other_faces) = other_faces(mesh, &faces);
        let others = Surface::new(mesh, other_faces, names, OTHERS);
        let names = motion.bodies.iter().map(|body| body.name.clone()).collect();
        let n_triangles = 2 * COORDINATES / (3 * n_frames.max(1));
        let n_triangles = n_triangles.min(TRIANGLES - others.triangles.len());
        let bodies = Surface::new(mesh, faces, names, n_triangles);
        (bodies.n_given > 0).then(|| Self {
            wall: Wall::new(mesh, &bodies.vertices),
            poses: Vec::new(),
            colours: Vec::new(),
            last_colours: vec![0; bodies.vertices.len()],
            azimuths_deg: Vec::new(),
            worst: Vec::new(),
            strayed: vec![[0.0; 2]; others.parts.len()],
            bodies,
            others,
            motion,
        })
    }

    /// Adds the mesh of a frame with the quality of its cells.
    pub fn add(&mut self, mesh: &Mesh, quality: &[f64], worst: Option<Vector>, azimuth_deg: f64) {
        let carry = self.motion.carry(azimuth_deg);
        let back = carry.inverse();
        let bodies = self.bodies.vertices.iter();
        let pose = bodies.map(|corner| single(back.apply(corner.position(mesh))));
        self.poses.push(pose.collect());
        let now = self.wall.colours(quality);
        let changes = now
            .iter()
            .zip(&self.last_colours)
            .map(|(now, last)| now.wrapping_sub(*last));
        self.colours.extend(changes);
        self.last_colours = now;
        self.azimuths_deg.push(azimuth_deg);
        self.worst.push(worst);
        for (part, [stays, turns]) in self.others.parts.iter().zip(&mut self.strayed) {
            for vertex in part.vertices.clone() {
                let (now, before) = (
                    self.others.vertices[vertex].position(mesh),
                    self.others.points[vertex],
                );
                *stays += distance(now, before);
                *turns += distance(now, carry.apply(before));
            }
        }
    }

    /// Decides whether another part is shown at first: not one around the bodies, or large compared with them.
    fn is_near(&self, part: &Part) -> bool {
        let bodies = Bounds::around(&self.bodies.points);
        let bounds = Bounds::around(&self.others.points[part.vertices.clone()]);
        let margin = sub(bodies.high, bodies.low).map(|extent| 0.1 * extent);
        let holds = (0..3).all(|axis| {
            bounds.low[axis] <= bodies.low[axis] + margin[axis]
                && bounds.high[axis] >= bodies.high[axis] - margin[axis]
        });
        !holds && bounds.diagonal() <= 2.5 * bodies.diagonal()
    }

    /// Writes the data of the script. Turns begin with the first step.
    pub fn data(&self) -> Value {
        let at_rest: Pose = self.others.points.iter().map(|x| single(*x)).collect();
        let is_inertial = self.motion.frame == "inertial";
        let turns = self.azimuths_deg.iter().skip(1);
        json!({
            "axis": self.motion.turn_axis,
            "hub": self.motion.hub,
            "turns_deg": turns.map(|turn| if is_inertial { *turn } else { 0.0 }).collect::<Vec<_>>(),
            "worst": self.worst,
            "bodies": self.bodies.data(&self.poses, &|_| (true, true)),
            "quality": packed(&self.colours),
            "others": self.others.data(&[at_rest], &|part| {
                let [stays, turns] = self.strayed[part];
                (self.is_near(&self.others.parts[part]), turns < 0.5 * stays)
            }),
        })
    }

    /// Counts the triangles in a sentence.
    pub fn sentence(&self) -> String {
        let plural = if self.motion.bodies.len() == 1 {
            "the body"
        } else {
            "the bodies"
        };
        let mut words = format!("Shown: {}", self.bodies.words(plural));
        if self.others.n_given > 0 {
            let others = self
                .others
                .words("other boundaries, where they are in the reference mesh");
            words += &format!(", {others}");
        }
        if self.bodies.is_decimated() || self.others.is_decimated() {
            words += ". Edges were collapsed for this picture only; every corner that is left is a node of the mesh";
        }
        words + "."
    }
}

fn single(x: Vector) -> [f32; 3] {
    x.map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::vector::{cross, dot};
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;
    use std::path::Path;

    fn motion(tag: &str) -> MotionRecord {
        let body = BodyRecord {
            name: format!("the {tag}"),
            tags: vec![tag.to_owned()],
            ..BodyRecord::default()
        };
        MotionRecord {
            bodies: vec![body],
            turn_axis: [0.0, 0.0, 1.0],
            ..MotionRecord::default()
        }
    }

    fn bytes_of(text: &Value) -> Vec<u8> {
        let packed = base64_simd::STANDARD.decode_to_vec(text.as_str().expect("a text"));
        let mut bytes = Vec::new();
        let packed = packed.expect("it is base64");
        let mut reader = flate2::read::ZlibDecoder::new(&packed[..]);
        std::io::Read::read_to_end(&mut reader, &mut bytes).expect("it is zlib");
        bytes
    }

    /// As `scene.js` does it.
    #[test]
    fn a_wing_is_shown_with_every_triangle_and_comes_back_to_half_a_step() {
        let mesh = Mesh::read(Path::new("testdata/wing_on_plane.vtu")).expect("it is good");
        let mut scene = Scene::new(&mesh, Some(&motion("wing")), 3).expect("it has a wing");
        let mut moved = mesh.clone();
        for frame in 0..3 {
            let quality = vec![0.5 - f64::from(frame) * 0.25; mesh.cells.len()];
            scene.add(&moved, &quality, None, 0.0);
            moved
                .points
                .iter_mut()
                .for_each(|x| x[1] += 0.1 * x[2] * x[2]);
        }
        let data = scene.data();
        let bodies = &data["bodies"];
        let n = scene.bodies.vertices.len();
        assert_eq!(
            (
                bodies["parts"][0]["triangles"].as_u64(),
                scene.bodies.n_given
            ),
            (Some(494), 494)
        );
        assert_eq!(scene.others.n_given, 396 + 348);
        let shown: Vec<_> = data["others"]["parts"]
            .as_array()
            .expect("parts")
            .iter()
            .map(|part| &part["shown"])
            .collect();
        assert_eq!(shown, [false, false]);
        let bytes = bytes_of(&bodies["positions"]);
        let mut changes = bytes
            .as_chunks::<2>()
            .0
            .iter()
            .map(|bytes| u16::from_le_bytes(*bytes));
        let mut now = vec![[0u16; 3]; n];
        let of = |key: &str, axis: usize| bodies["parts"][0][key][axis].as_f64().expect("a number");
        for pose in &scene.poses {
            for axis in 0..3 {
                let mut change = 0u16;
                for (now, x) in now.iter_mut().zip(pose) {
                    change = change.wrapping_add(changes.next().expect("a change"));
                    now[axis] = now[axis].wrapping_add(change);
                    let found = of("low", axis) + of("step", axis) * f64::from(now[axis]);
                    assert!((found - f64::from(x[axis])).abs() <= 0.501 * of("step", axis));
                }
            }
        }
        let bytes = bytes_of(&bodies["triangles"]);
        let steps: Vec<u32> = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| u32::from_le_bytes(*bytes))
            .collect();
        let mut lowest = 0;
        for (steps, triangle) in steps.as_chunks::<3>().0.iter().zip(&scene.bodies.triangles) {
            lowest += steps[0];
            assert_eq!([lowest, lowest + steps[1], lowest + steps[2]], *triangle);
        }
        let colours = bytes_of(&data["quality"]);
        assert_eq!([0, n, 2 * n].map(|at| colours[at]), [colour(0.5), 4, 5]);
    }

    #[test]
    fn nothing_is_shown_in_space_of_a_plane_mesh_or_of_a_body_without_a_surface() {
        let plane = Mesh::read(Path::new("testdata/naca0012.vtu")).expect("it is good");
        let airfoil = motion("airfoil");
        assert!(Scene::new(&plane, Some(&airfoil), 10).is_none());
        let wing = Mesh::read(Path::new("testdata/wing_on_plane.vtu")).expect("it is good");
        assert!(Scene::new(&wing, Some(&motion("flap")), 10).is_none());
        assert!(!landmarks(&plane, &airfoil.bodies).is_empty());
    }

    /// A closed cylinder of radius 1 and length 3, its lids with vertices of their own.
    #[test]
    fn a_surface_with_fewer_triangles_keeps_its_shape_and_stays_closed() {
        let (n, m) = (96u32, 120u32);
        let ring = |height: f64| {
            let angles = (0..n).map(move |i| TAU * f64::from(i) / f64::from(n));
            angles.map(move |angle| [angle.cos(), angle.sin(), height])
        };
        let mut points: Vec<Vector> = (0..=m)
            .flat_map(|j| ring(3.0 * f64::from(j) / f64::from(m)))
            .collect();
        let mut corners = Vec::new();
        for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let [a, b] = [j * n + i, j * n + (i + 1) % n];
            corners.extend([a, b, b + n, a, b + n, a + n]);
        }
        for height in [0.0, 3.0] {
            let first = points.len() as u32;
            points.extend(ring(height).chain([[0.0, 0.0, height]]));
            for i in 0..n {
                let (a, b) = if height > 0.0 {
                    (i, (i + 1) % n)
                } else {
                    ((i + 1) % n, i)
                };
                corners.extend([first + a, first + b, first + n]);
            }
        }
        let few = simplified(&points, corners, 1500);
        assert!(few.len() <= 4500 && few.len() > 4000, "{}", few.len());
        let at = |corner: u32| points[corner as usize].map(f64::to_bits);
        let mut edges: BTreeMap<_, i32> = BTreeMap::new();
        let mut volume = 0.0;
        for &[a, b, c] in few.as_chunks::<3>().0 {
            for (a, b) in [(at(a), at(b)), (at(b), at(c)), (at(c), at(a))] {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
            let [a, b, c] = [a, b, c].map(|corner| points[corner as usize]);
            volume += dot(a, cross(b, c)) / 6.0;
        }
        assert!(edges.values().all(|times| *times == 0), "there is a hole");
        assert!((volume / (1.5 * TAU) - 1.0).abs() < 0.01, "{volume}");
    }

    #[test]
    fn there_are_never_more_triangles_than_asked_for() {
        let points: Vec<Vector> = (0..1500u32)
            .map(|i| [f64::from(i / 3), f64::from(i % 3 % 2), f64::from(i % 3 / 2)])
            .collect();
        assert!(simplified(&points, (0..1500).collect(), 100).len() <= 300);
        assert_eq!(simplified(&points, (0..1500).collect(), 500).len(), 1500);
    }
}
