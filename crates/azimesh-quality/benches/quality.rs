//! Cells evaluated per second and core, for each kind of cell, on about a million cells.
//!
//! Run with `cargo bench --bench quality`; medians of seven runs.
#![allow(clippy::print_stdout)]

use azimesh_io::mesh::{CellKind, Mesh};
use azimesh_quality::{Reference, assess, per_cell};
use std::hint::black_box;
use std::time::Instant;

/// Cubes along an edge of the block from which solid cells are cut, and along an edge of the plane.
const N_CUBES: usize = 64;
const N_SQUARES: usize = 1000;
const RUNS: usize = 7;

/// A cube by its corners in VTK's order, cut into cells of a kind; 8 is its centre.
const CUTS: [(CellKind, &[&[usize]]); 4] = [
    (CellKind::Hexahedron, &[&[0, 1, 2, 3, 4, 5, 6, 7]]),
    (CellKind::Wedge, &[&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]]),
    (
        CellKind::Tetrahedron,
        &[
            &[0, 1, 2, 6],
            &[0, 2, 3, 6],
            &[0, 3, 7, 6],
            &[0, 7, 4, 6],
            &[0, 4, 5, 6],
            &[0, 5, 1, 6],
        ],
    ),
    (
        CellKind::Pyramid,
        &[
            &[0, 1, 2, 3, 8],
            &[4, 7, 6, 5, 8],
            &[0, 4, 5, 1, 8],
            &[1, 5, 6, 2, 8],
            &[2, 6, 7, 3, 8],
            &[3, 7, 4, 0, 8],
        ],
    ),
];

fn shaken(i: usize, j: usize, k: usize) -> [f64; 3] {
    let [x, y, z] = [i, j, k].map(|n| n as f64);
    let seed = x * 12.9898 + y * 78.233 + z * 37.719;
    [
        x + 0.1 * seed.sin(),
        y + 0.1 * (2.0 * seed).sin(),
        z + 0.1 * (3.0 * seed).sin(),
    ]
}

fn block(kind: CellKind, cut: &[&[usize]]) -> Mesh {
    // About a million cells of each kind.
    let layers = N_CUBES * 4 / cut.len().min(4);
    let n = N_CUBES + 1;
    let mut mesh = Mesh::default();
    for k in 0..=layers {
        for j in 0..n {
            for i in 0..n {
                mesh.points.push(shaken(i, j, k));
            }
        }
    }
    let at = |i: usize, j: usize, k: usize| ((k * n + j) * n + i) as u32;
    for k in 0..layers {
        for j in 0..N_CUBES {
            for i in 0..N_CUBES {
                let centre = mesh.points.len() as u32;
                let [a, b] = [k, k + 1].map(|k| {
                    [
                        at(i, j, k),
                        at(i + 1, j, k),
                        at(i + 1, j + 1, k),
                        at(i, j + 1, k),
                    ]
                });
                let corners = [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], centre];
                if kind == CellKind::Pyramid {
                    mesh.points.push([i, j, k].map(|x| x as f64 + 0.5));
                }
                for cell in cut {
                    let nodes: Vec<u32> = cell.iter().map(|&c| corners[c]).collect();
                    mesh.cells.push(kind, &nodes);
                }
            }
        }
    }
    mesh
}

fn plane(kind: CellKind) -> Mesh {
    let n = N_SQUARES + 1;
    let mut mesh = Mesh::default();
    for j in 0..n {
        for i in 0..n {
            let [x, y, _] = shaken(i, j, 0);
            mesh.points.push([x, y, 0.0]);
        }
    }
    for j in 0..N_SQUARES {
        for i in 0..N_SQUARES {
            let a = (j * n + i) as u32;
            let [b, c, d] = [a + 1, a + 1 + n as u32, a + n as u32];
            if kind == CellKind::Triangle {
                mesh.cells.push(kind, &[a, b, c]);
                mesh.cells.push(kind, &[a, c, d]);
            } else {
                mesh.cells.push(kind, &[a, b, c, d]);
            }
        }
    }
    mesh
}

fn median_seconds(mut run: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[RUNS / 2]
}

fn main() {
    let threads = rayon::current_num_threads() as f64;
    println!("M cells/s/core         cells  Reference   assess  per_cell");
    let solids = CUTS.map(|(kind, cut)| (kind, block(kind, cut)));
    let planes = [CellKind::Quadrilateral, CellKind::Triangle].map(|kind| (kind, plane(kind)));
    for (kind, mesh) in solids.into_iter().chain(planes) {
        let (reference, sizes) = Reference::with_sizes(&mesh);
        let rate = |seconds: f64| mesh.cells.len() as f64 / seconds / threads / 1e6;
        let judged = rate(median_seconds(|| {
            black_box(Reference::new(&mesh));
        }));
        let summed = rate(median_seconds(|| {
            black_box(assess(&mesh, &mesh.points, &reference, &sizes));
        }));
        let each = rate(median_seconds(|| {
            black_box(per_cell(&mesh, &mesh.points, &reference));
        }));
        let (name, n) = (kind.name(), mesh.cells.len());
        println!("{name:<16} {n:>11} {judged:>10.2} {summed:>8.2} {each:>9.2}");
    }
}
