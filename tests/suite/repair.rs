//! Random meshes whose boundary has moved in a way that a valid mesh follows: every one becomes valid.
//!
//! `AZIMESH_REPAIR_MESHES=1000` tries so many of them instead of a few.

use azimesh::{CellKind, Mesh, Stop};
use azimesh_io::mesh::{Adjacency, Coincident};
use azimesh_quality::Reference;
use azimesh_quality::repair::{Freedom, Limits, Repaired, Task, untangle};
use azimesh_quality::validity::invalid;

type Vector = [f64; 3];

/// Numbers between 0 and 1, the same ones for the same seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Triangles,
    Quadrilaterals,
    Polygons,
    MixedPlane,
    Tetrahedra,
    Hexahedra,
    Wedges,
    Pyramids,
    Polyhedra,
    MixedSolid,
}

const KINDS: [Kind; 10] = [
    Kind::Triangles,
    Kind::Quadrilaterals,
    Kind::Polygons,
    Kind::MixedPlane,
    Kind::Tetrahedra,
    Kind::Hexahedra,
    Kind::Wedges,
    Kind::Pyramids,
    Kind::Polyhedra,
    Kind::MixedSolid,
];

impl Kind {
    fn is_solid(self) -> bool {
        KINDS.iter().position(|kind| *kind == self) >= Some(4)
    }
}

/// A lattice of unit extent, cut into cells of this kind.
fn lattice(kind: Kind, n: usize, random: &mut Random) -> Mesh {
    let mut mesh = Mesh::default();
    add_nodes(&mut mesh, kind, n, random);
    let node = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
    let ring = |i: usize, j: usize, k: usize| {
        [
            node(i, j, k),
            node(i + 1, j, k),
            node(i + 1, j + 1, k),
            node(i, j + 1, k),
        ]
    };
    for j in 0..n {
        for i in 0..n {
            if !kind.is_solid() {
                let next = (i + 1 < n).then(|| ring(i + 1, j, 0));
                add_plane(&mut mesh, kind, ring(i, j, 0), next, i, random);
                continue;
            }
            // A column is of wedges or not, so that triangles meet triangles.
            let wedges = kind == Kind::Wedges || (kind == Kind::MixedSolid && random.next() < 0.4);
            for k in 0..n {
                let (a, b) = (ring(i, j, k), ring(i, j, k + 1));
                add_solid(&mut mesh, kind, wedges, a, b, random);
            }
        }
    }
    mesh
}

/// Nodes of a lattice, those inside a little off their places.
fn add_nodes(mesh: &mut Mesh, kind: Kind, n: usize, random: &mut Random) {
    let h = 1.0 / n as f64;
    let shifted = |at: usize, random: &mut Random| {
        if at == 0 || at == n {
            at as f64 * h
        } else {
            (at as f64 + random.within(-0.15, 0.15)) * h
        }
    };
    let layers = if kind.is_solid() { n + 1 } else { 1 };
    for k in 0..layers {
        for j in 0..=n {
            for i in 0..=n {
                let z = if kind.is_solid() {
                    shifted(k, random)
                } else {
                    0.0
                };
                mesh.points
                    .push([shifted(i, random), shifted(j, random), z]);
            }
        }
    }
}

fn add_plane(
    mesh: &mut Mesh,
    kind: Kind,
    q: [u32; 4],
    next: Option<[u32; 4]>,
    i: usize,
    random: &mut Random,
) {
    let triangles = kind == Kind::Triangles || (kind == Kind::MixedPlane && random.next() < 0.5);
    match (kind, next) {
        // Two squares side by side as one polygon of six corners.
        (Kind::Polygons, Some(next)) if i.is_multiple_of(2) => {
            mesh.cells.push(
                CellKind::Polygon,
                &[q[0], q[1], next[1], next[2], q[2], q[3]],
            );
        }
        (Kind::Polygons, _) if i % 2 == 1 => {}
        (Kind::Polygons, _) => mesh.cells.push(CellKind::Polygon, &q),
        _ if triangles => {
            mesh.cells.push(CellKind::Triangle, &[q[0], q[1], q[2]]);
            mesh.cells.push(CellKind::Triangle, &[q[0], q[2], q[3]]);
        }
        _ => mesh.cells.push(CellKind::Quadrilateral, &q),
    }
}

fn add_solid(
    mesh: &mut Mesh,
    kind: Kind,
    wedges: bool,
    a: [u32; 4],
    b: [u32; 4],
    random: &mut Random,
) {
    let all = [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]];
    let faces = CellKind::Hexahedron.faces();
    let face = |i: usize| [0, 1, 2, 3].map(|k| all[usize::from(faces[i][k])]);
    match kind {
        Kind::Tetrahedra => {
            // Along the diagonal, in the order of the axes.
            for [p, q] in [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]] {
                mesh.cells
                    .push(CellKind::Tetrahedron, &[all[0], all[p], all[q], all[6]]);
            }
        }
        _ if wedges => {
            mesh.cells
                .push(CellKind::Wedge, &[a[0], a[1], a[2], b[0], b[1], b[2]]);
            mesh.cells
                .push(CellKind::Wedge, &[a[0], a[2], a[3], b[0], b[2], b[3]]);
        }
        Kind::Polyhedra => {
            let mut stream = vec![6];
            for i in 0..6 {
                stream.push(4);
                stream.extend(face(i));
            }
            mesh.cells.push_polyhedron(&stream).unwrap();
        }
        _ if kind == Kind::Pyramids || (kind == Kind::MixedSolid && random.next() < 0.5) => {
            let mut middle = [0.0; 3];
            for node in all {
                for axis in 0..3 {
                    middle[axis] += mesh.points[node as usize][axis] / 8.0;
                }
            }
            let apex = mesh.points.len() as u32;
            mesh.points.push(middle);
            for i in 0..6 {
                // Faces look outward, a pyramid's base inward.
                let [p, q, r, s] = face(i);
                mesh.cells.push(CellKind::Pyramid, &[p, s, r, q, apex]);
            }
        }
        _ => mesh.cells.push(CellKind::Hexahedron, &all),
    }
}

/// A map of space without folds: a rotation that grows along an axis, and two waves.
struct Motion {
    twist: f64,
    waves: [f64; 2],
    phase: f64,
}

impl Motion {
    fn of(&self, solid: bool, [x, y, z]: Vector) -> Vector {
        let radius = ((x - 0.5).powi(2) + (y - 0.5).powi(2)).sqrt();
        let angle = self.twist * if solid { z } else { radius };
        let (s, c) = angle.sin_cos();
        let (u, v) = (c * (x - 0.5) - s * (y - 0.5), s * (x - 0.5) + c * (y - 0.5));
        let u = u + self.waves[0] * (6.0 * v + self.phase).sin();
        let v = v + self.waves[1] * (6.0 * u).sin();
        [
            u,
            v,
            if solid {
                z + self.waves[0] * (5.0 * u).cos()
            } else {
                z
            },
        ]
    }
}

/// Repairs a random mesh; `None` where the random motion folds cells itself.
fn repaired(seed: u64) -> Option<(Kind, usize, Repaired)> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
    let kind = KINDS[(seed % 10) as usize];
    let solid = kind.is_solid();
    let n = if solid {
        3 + (random.next() * 3.0) as usize
    } else {
        5 + (random.next() * 8.0) as usize
    };
    let mesh = lattice(kind, n, &mut random);
    let motion = Motion {
        twist: random.within(-1.5, 1.5),
        waves: [random.within(0.0, 0.12), random.within(0.0, 0.12)],
        phase: random.within(0.0, 6.0),
    };
    let reference = Reference::new(&mesh);
    assert_eq!(reference.n_inverted(), 0);
    let goal: Vec<Vector> = mesh.points.iter().map(|x| motion.of(solid, *x)).collect();
    if !invalid(&mesh, &goal, &reference).is_empty() {
        return None;
    }
    let freedom = Freedom::inner(&mesh, &Adjacency::of(&mesh), &Coincident::default());
    let (share, noise) = (random.next(), random.within(0.0, 0.4) / n as f64);
    let start = (0..mesh.points.len()).map(|i| {
        if freedom.is_fixed(i as u32) {
            goal[i]
        } else {
            let mut x =
                [0, 1, 2].map(|k| mesh.points[i][k] + share * (goal[i][k] - mesh.points[i][k]));
            for k in 0..if solid { 3 } else { 2 } {
                x[k] += noise * random.within(-1.0, 1.0);
            }
            x
        }
    });
    let mut points: Vec<Vector> = start.collect();
    let n_before = invalid(&mesh, &points, &reference).len();
    let task = Task {
        mesh: &mesh,
        reference: &reference,
        freedom: &freedom,
    };
    let found = untangle(task, &mut points, Limits::default(), &Stop::default()).unwrap();
    assert_eq!(
        invalid(&mesh, &points, &reference).len(),
        found.unrepaired.len()
    );
    for node in 0..points.len() {
        assert!(!freedom.is_fixed(node as u32) || points[node] == goal[node]);
    }
    Some((kind, n_before, found))
}

#[test]
fn random_meshes_of_every_kind_become_valid() {
    let wanted = std::env::var("AZIMESH_REPAIR_MESHES").ok();
    let wanted: usize = wanted.map_or(60, |n| n.parse().unwrap());
    let (mut n_folded, mut n_tried, mut failures) = (0, 0, Vec::new());
    let mut of_kind = std::collections::BTreeMap::new();
    for seed in 0.. {
        if n_folded >= wanted {
            break;
        }
        let Some((kind, n_before, found)) = repaired(seed) else {
            continue;
        };
        n_tried += 1;
        if n_before == 0 {
            continue;
        }
        n_folded += 1;
        *of_kind.entry(format!("{kind:?}")).or_insert(0) += 1;
        if !found.unrepaired.is_empty() {
            failures.push(format!(
                "seed {seed}: {kind:?}, {n_before} before, {:?}",
                found.unrepaired
            ));
        }
    }
    eprintln!(
        "{n_folded} of {n_tried} meshes were folded, {} stay so; {of_kind:?}",
        failures.len()
    );
    assert_eq!(of_kind.len(), KINDS.len(), "{of_kind:?}");
    assert!(failures.len() * 1000 <= n_folded, "{}", failures.join("\n"));
}
