//! Faces evaluated per second on a block of cubes, each cut into five tetrahedra or whole, compared with
//! what is made once: the pairs of cells.
//!
//! Run with `cargo bench --bench faces`: a block of a million nodes, or `cargo bench --bench faces -- 8000000`
//! for one of eight million, 40 million tetrahedra and 80 million faces. Medians of five runs.
#![allow(clippy::print_stdout)]

use azimesh_io::mesh::{Adjacency, CellKind, Mesh};
use azimesh_quality::{Reference, assess, faces};
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 5;

/// Five tetrahedra of a cube by its corners in VTK's order, for cubes of even and of odd places, so that
/// neighbours share edges.
const CUTS: [[[usize; 4]; 5]; 2] = [
    [
        [0, 1, 2, 5],
        [0, 2, 3, 7],
        [0, 5, 7, 4],
        [2, 7, 5, 6],
        [0, 2, 7, 5],
    ],
    [
        [0, 1, 3, 4],
        [1, 2, 3, 6],
        [1, 6, 4, 5],
        [3, 4, 6, 7],
        [1, 3, 4, 6],
    ],
];

fn block(kind: CellKind, n: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let shaken = |i: usize, j: usize, k: usize| {
        let [x, y, z] = [i, j, k].map(|n| n as f64);
        let seed = x * 12.9898 + y * 78.233 + z * 37.719;
        [
            x + 0.1 * seed.sin(),
            y + 0.1 * (2.0 * seed).sin(),
            z + 0.1 * (3.0 * seed).sin(),
        ]
    };
    let grid = (0..n * n * n).map(|i| shaken(i % n, i / n % n, i / n / n));
    mesh.points = grid.collect();
    mesh.cells.reserve(20 * (n - 1).pow(3));
    for cube in 0..(n - 1).pow(3) {
        let (i, j, k) = (
            cube % (n - 1),
            cube / (n - 1) % (n - 1),
            cube / (n - 1) / (n - 1),
        );
        let a = ((k * n + j) * n + i) as u32;
        let (row, plane) = (n as u32, (n * n) as u32);
        let base = [a, a + 1, a + 1 + row, a + row];
        let corners: Vec<u32> = base
            .iter()
            .copied()
            .chain(base.map(|node| node + plane))
            .collect();
        if kind == CellKind::Hexahedron {
            mesh.cells.push(kind, &corners);
            continue;
        }
        for cut in CUTS[(i + j + k) % 2] {
            mesh.cells.push(kind, &cut.map(|corner| corners[corner]));
        }
    }
    mesh
}

fn seconds(mut run: impl FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn median(mut run: impl FnMut()) -> f64 {
    let mut all: Vec<f64> = (0..RUNS).map(|_| seconds(&mut run)).collect();
    all.sort_by(f64::total_cmp);
    all[RUNS / 2]
}

fn main() {
    let mut wanted = std::env::args().filter_map(|argument| argument.parse::<f64>().ok());
    let n = wanted.next_back().unwrap_or(1e6).cbrt().round() as usize;
    println!(
        "{} threads; s, and millions a second",
        rayon::current_num_threads()
    );
    println!(
        "                  nodes      cells      faces  pairing (bytes)       faces        cells"
    );
    for kind in [CellKind::Tetrahedron, CellKind::Hexahedron] {
        let mesh = block(kind, n);
        let (reference, sizes) = Reference::with_sizes(&mesh);
        let workspace = faces::Workspace::default();
        let mut adjacency = Adjacency::default();
        let pairing = seconds(|| adjacency = Adjacency::of(&mesh));
        let judged = median(|| {
            black_box(faces::assess(
                &mesh,
                &mesh.points,
                &reference,
                &adjacency,
                &workspace,
            ));
        });
        let cells = median(|| {
            black_box(assess(&mesh, &mesh.points, &reference, &sizes));
        });
        let n_faces = adjacency.n_inner() + adjacency.n_outer();
        let rate =
            |n: usize, seconds: f64| format!("{seconds:.3} {:>6.1}", n as f64 / seconds / 1e6);
        println!(
            "{:<12} {:>10} {:>10} {n_faces:>10}  {pairing:.2} ({} MB) {} {}",
            kind.name(),
            mesh.points.len(),
            mesh.cells.len(),
            adjacency.memory_bytes() / 1_000_000,
            rate(n_faces, judged),
            rate(mesh.cells.len(), cells),
        );
    }
}
