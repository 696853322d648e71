//! Morphs on plane, solid, sliding and periodic meshes: exactness, linearity, the transpose.

mod refusals;

use super::*;
use azimesh_core::geometry::vector::{distance, dot};
use azimesh_core::linear::{Matrix, svd};
use azimesh_io::mesh::CellKind;
use proptest::prelude::*;
use std::path::Path;

fn read(name: &str) -> Mesh {
    Mesh::read(Path::new("testdata").join(name)).expect("it is good")
}

fn options(moving: &str, fixed: &[&str], slide: &[&str]) -> MorphOptions {
    let tags = |tags: &[&str]| Nodes::Tags(tags.iter().map(|tag| (*tag).to_owned()).collect());
    MorphOptions {
        moving: moving.into(),
        fixed: tags(fixed),
        slide: tags(slide),
        max_points: 60,
        ..MorphOptions::default()
    }
}

fn sector(fixed: &[&str], slide: &[&str]) -> MorphOptions {
    MorphOptions {
        periodic: vec![["side_a".into(), "side_b".into()]],
        support_radius: Some(3.0),
        ..options("blade", fixed, slide)
    }
}

/// A morph in the plane, in space, on a sliding plane, between periodic sides, and both.
fn all() -> Vec<(&'static str, Morph)> {
    let walls = ["hub_wall", "outer", "bottom", "top"];
    let all = [
        ("naca0012.vtu", options("airfoil", &["farfield"], &[])),
        (
            "sphere_in_box_raw.vtu",
            options("sphere", &["inlet", "outlet"], &[]),
        ),
        (
            "wing_on_plane.vtu",
            options("wing", &["farfield"], &["symmetry"]),
        ),
        ("rotor_sector.vtu", sector(&walls, &[])),
        ("rotor_sector.vtu", sector(&walls[..2], &walls[2..])),
    ];
    all.into_iter()
        .map(|(name, options)| (name, Morph::new(read(name), options).expect(name)))
        .collect()
}

fn noise(seed: usize, n: usize) -> Vec<Vector> {
    let value = |i: usize| ((seed * 7919 + i) as f64 * 12.9898).sin();
    (0..n)
        .map(|i| std::array::from_fn(|k| value(3 * i + k)))
        .collect()
}

/// Displacements of the moving nodes, as rough as possible, in the plane of a plane mesh.
fn rough(morph: &Morph, seed: usize) -> Vec<Vector> {
    let noise = noise(seed, morph.moving().len()).into_iter();
    noise.map(|d| morph.surface.in_mesh(d)).collect()
}

fn inner(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum()
}

fn size(a: &[Vector]) -> f64 {
    inner(a, a).sqrt()
}

/// The condition number of the kernel matrix of the base points.
fn condition(morph: &Morph) -> f64 {
    let base = &morph.sources[..morph.base.len()];
    let phi = Matrix::from_fn(base.len(), base.len(), |i, j| {
        morph.basis.between(&base[i], &base[j])
    });
    let values = svd(&phi).expect("it converges").1;
    values[0] / values[base.len() - 1]
}

#[test]
fn moving_and_fixed_nodes_are_where_they_should_be_to_the_last_bit() {
    for (name, morph) in all() {
        let d = rough(&morph, 3);
        let points = morph.points(&d).expect(name);
        let at_rest = &morph.mesh().points;
        for (&node, d) in morph.moving().iter().zip(&d) {
            assert_eq!(
                points[node as usize],
                add(at_rest[node as usize], *d),
                "{name}"
            );
        }
        assert!(!morph.surface.fixed.is_empty(), "{name}");
        for &node in &morph.surface.fixed {
            assert_eq!(points[node as usize], at_rest[node as usize], "{name}");
        }
    }
}

#[test]
fn the_transpose_is_exact() {
    for (name, morph) in all() {
        for seed in 1..4 {
            let d = rough(&morph, seed);
            let g = noise(100 + seed, morph.mesh().points.len());
            let moved = morph.displacements_of(&d).expect(name);
            let back = morph.pull_back(&g).expect(name);
            let off = (inner(&g, &moved) - inner(&back, &d)).abs();
            let relative = off / (size(&g) * size(&moved));
            let condition = condition(&morph);
            assert!(
                relative < 1e-20 * condition.max(1e8),
                "{name}: {relative:e}"
            );
        }
    }
}

#[test]
fn every_entry_of_the_transpose_is_that_of_the_matrix() {
    let morph = Morph::new(
        read("wing_on_plane.vtu"),
        options("wing", &["farfield"], &["symmetry"]),
    )
    .expect("it is good");
    let (n, m) = (morph.mesh().points.len(), morph.moving().len());
    let unit = |n: usize, at: usize| {
        let mut one = vec![0.0; 3 * n];
        one[at] = 1.0;
        one.as_chunks::<3>().0.to_vec()
    };
    for row in (0..3 * m).step_by(3 * m / 7) {
        let column = morph.displacements_of(&unit(m, row)).expect("it is good");
        for at in (0..3 * n).step_by(n / 5) {
            let back = morph.pull_back(&unit(n, at)).expect("it is good");
            let [entry, transposed] = [column.as_flattened()[at], back.as_flattened()[row]];
            assert!((entry - transposed).abs() < 1e-12, "{entry} {transposed}");
        }
    }
}

#[test]
fn displacements_are_linear_and_points_are_the_mesh_and_these() {
    for (name, morph) in all() {
        let (a, b) = (rough(&morph, 5), rough(&morph, 6));
        let sum: Vec<Vector> = a
            .iter()
            .zip(&b)
            .map(|(a, b)| add(scale(*a, 2.5), *b))
            .collect();
        let [of_a, of_b, of_sum] = [&a, &b, &sum].map(|d| morph.displacements_of(d).expect(name));
        let points = morph.points(&sum).expect(name);
        let largest = of_sum.iter().map(|d| norm(*d)).fold(1.0, f64::max);
        // Rough displacements have weights as large as the condition number allows.
        let limit = 1e-15 * condition(&morph).max(100.0) * largest;
        let at_rest = morph.points(&vec![[0.0; 3]; sum.len()]).expect(name);
        for node in 0..points.len() {
            let wanted = add(scale(of_a[node], 2.5), of_b[node]);
            assert!(distance(of_sum[node], wanted) < limit, "{name} {node}");
            let moved = sub(points[node], at_rest[node]);
            assert!(distance(moved, wanted) < limit, "{name} {node}");
            let off = distance(at_rest[node], morph.mesh().points[node]);
            assert!(
                off < 1e-15 * morph.surface.diagonal,
                "{name} {node}: {off:e}"
            );
        }
    }
}

#[test]
fn sliding_nodes_keep_to_their_plane_and_paired_ones_stay_pairs() {
    let mut slid = 0;
    for (name, morph) in all() {
        let points = morph.points(&rough(&morph, 8)).expect(name);
        let at_rest = &morph.mesh().points;
        for &(node, point) in &morph.surface.sliding {
            let (x, rest) = (points[node as usize], at_rest[node as usize]);
            for normal in morph.surface.constraint(point as usize).columns() {
                assert!(dot(*normal, sub(x, rest)).abs() < 1e-15, "{name} {node}");
            }
            slid += usize::from(x != rest);
        }
        let mut placed = points.clone();
        morph.pairs.place(at_rest, &mut placed);
        assert_eq!(points, placed, "{name}");
    }
    assert!(slid > 10);
}

#[test]
fn the_field_between_periodic_sides_repeats() {
    let walls = ["hub_wall", "outer", "bottom", "top"];
    let morph = Morph::new(read("rotor_sector.vtu"), sector(&walls, &[])).expect("it is good");
    let d = noise(2, morph.moving().len());
    let n = morph.surface.points.points.len() as u32;
    let mut corners = morph.rows.iter().flat_map(|row| row.corners);
    assert!(
        corners.any(|corner| corner >= n),
        "the correction reaches from images"
    );
    // Without the last step, which makes pairs identical.
    let values = morph.surface.values(&d).expect("they are good");
    let mut found = vec![[0.0; 3]; morph.mesh().points.len()];
    let interpolant = morph.interpolant(&values);
    interpolant.add_at(&morph.mesh().points, found.as_flattened_mut());
    let mut followed = found.clone();
    morph.pairs.follow(&mut followed);
    assert!(morph.pairs.following().count() > 10);
    let largest = found.iter().map(|d| norm(*d)).fold(0.0, f64::max);
    for (found, followed) in found.iter().zip(&followed) {
        assert!(distance(*found, *followed) < 1e-10 * largest);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build();
        pool.expect("threads start").install(|| {
            let wing = options("wing", &["farfield"], &["symmetry"]);
            let morph = Morph::new(read("wing_on_plane.vtu"), wing).expect("it is good");
            let g = noise(1, morph.mesh().points.len());
            let points = morph.points(&rough(&morph, 1)).expect("it is good");
            (
                morph.base_points(),
                points,
                morph.pull_back(&g).expect("it is good"),
            )
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn base_points_from_samples_leave_the_tolerance_on_them_and_fewer_than_without() {
    let mesh = Arc::new(read("naca0012.vtu"));
    let nodes = mesh.tag_nodes("airfoil").expect("it is there");
    let bend = |node: &u32| [0.0, 40.0 * mesh.points[*node as usize][0].powi(2), 0.0];
    let sample: Vec<Vector> = nodes.iter().map(bend).collect();
    let options = MorphOptions {
        samples: vec![sample.clone()],
        tolerance: 1e-3,
        max_points: 1000,
        ..options("airfoil", &["farfield"], &[])
    };
    let morph = Morph::new(mesh.clone(), options.clone()).expect("it is good");
    let report = morph.report(&sample).expect("it is good");
    let largest = sample.iter().map(|d| norm(*d)).fold(0.0, f64::max);
    assert!(report.largest_residual <= 1e-3 * largest);
    let n_base = morph.base_points().len();
    assert!(n_base < 100, "{n_base}");
    let all = MorphOptions {
        samples: Vec::new(),
        tolerance: 1e-9,
        ..options
    };
    let all = Morph::new(mesh, all).expect("it is good");
    let n_all = all.base_points().len();
    assert!(n_all > 2 * n_base, "{n_all} {n_base}");
}

#[test]
fn the_report_names_nodes_where_the_correction_is_steep() {
    let few = MorphOptions {
        max_points: 6,
        ..options("airfoil", &["farfield"], &[])
    };
    let morph = Morph::new(read("naca0012.vtu"), few).expect("it is good");
    let n = morph.moving().len();
    let none = morph.report(&vec![[0.0; 3]; n]).expect("it is good");
    assert_eq!((none.largest_residual, none.steep_nodes.len()), (0.0, 0));
    let mut d = vec![[0.0; 3]; n];
    d[n / 2][1] = 0.5;
    let report = morph.report(&d).expect("it is good");
    assert_eq!(report.steepest_node, morph.moving()[n / 2]);
    assert!(report.steep_nodes.contains(&report.steepest_node));
    assert!(report.largest_slope > STEEP && report.largest_residual > 0.1);
}

/// Two triangles on a square of nodes; nodes 4 and 5 are at the positions of 1 and 2.
fn torn() -> Mesh {
    let mut mesh = Mesh {
        points: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Triangle, &[4, 3, 5]);
    mesh
}

#[test]
fn nodes_at_one_place_move_together() {
    let options = MorphOptions {
        moving: vec![4, 1].into(),
        fixed: vec![0].into(),
        ..MorphOptions::default()
    };
    let morph = Morph::new(torn(), options).expect("it is good");
    let points = morph.points(&[[0.1, 0.2, 0.0]; 2]).expect("they agree");
    assert_eq!((points[1], points[4]), ([1.1, 0.2, 0.0], [1.1, 0.2, 0.0]));
    assert_eq!(points[2], points[5]);
    let mut g = vec![[0.0; 3]; 6];
    (g[1], g[4]) = ([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]);
    assert_eq!(
        morph.pull_back(&g).expect("it is good"),
        [[0.0; 3], [3.0, 0.0, 0.0]]
    );
    let error = morph
        .points(&[[0.1, 0.2, 0.0], [0.0; 3]])
        .expect_err("they differ");
    assert!(
        error.message.contains("node 4 has the displacement"),
        "{error}"
    );
    assert!(error.message.contains("same place"), "{error}");
}

#[test]
fn faces_are_found_where_the_mesh_has_no_boundary_cells() {
    let tagged = read("naca0012.vtu");
    let nodes = |tag: &str| Nodes::from(tagged.tag_nodes(tag).expect("it is there"));
    let options = MorphOptions {
        moving: nodes("airfoil"),
        fixed: nodes("farfield"),
        max_points: 20,
        ..MorphOptions::default()
    };
    let keep = (0..tagged.cells.len()).filter(|&cell| tagged.cells.get(cell).kind.dimension() == 2);
    let bare = Mesh {
        cells: tagged.cells.select(keep),
        groups: Vec::new(),
        cell_arrays: Vec::new(),
        ..tagged.clone()
    };
    let [with, without] =
        [tagged, bare].map(|mesh| Morph::new(mesh, options.clone()).expect("good"));
    let d = rough(&with, 4);
    let [a, b] = [&with, &without].map(|morph| morph.points(&d).expect("it is good"));
    assert!(a.iter().zip(&b).all(|(a, b)| distance(*a, *b) < 1e-14));
}

/// A box of `n` by `n` by `n` hexahedra with slightly moved nodes.
fn shaken(n: u32, seed: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let shakes = noise(seed, (n as usize + 1).pow(3));
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                let shake = shakes[mesh.points.len()];
                let at = [i, j, k].map(f64::from);
                mesh.points.push(add(at, scale(shake, 0.15)));
            }
        }
    }
    let node = |i: u32, j: u32, k: u32| (k * (n + 1) + j) * (n + 1) + i;
    for (k, j, i) in (0..n).flat_map(|k| (0..n).flat_map(move |j| (0..n).map(move |i| (k, j, i)))) {
        let ring =
            |k: u32| [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| node(i, j, k));
        let corners = [ring(k), ring(k + 1)].concat();
        mesh.cells.push(CellKind::Hexahedron, &corners);
    }
    mesh
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_transpose_is_exact_whatever_moves_and_stays(
        n in 2u32..4,
        seed in 0usize..1000,
        every in 2usize..9,
        max_points in 1usize..30,
        radius in 0.8f64..8.0,
    ) {
        let mesh = shaken(n, seed);
        let chosen = |first: usize| -> Vec<u32> {
            (first as u32..mesh.points.len() as u32).step_by(every).collect()
        };
        let options = MorphOptions {
            moving: chosen(0).into(),
            fixed: chosen(1).into(),
            max_points,
            support_radius: Some(radius),
            ..MorphOptions::default()
        };
        let morph = Morph::new(mesh.clone(), options).expect("it is good");
        let d = noise(seed + 1, morph.moving().len());
        let g = noise(seed + 2, mesh.points.len());
        let moved = morph.displacements_of(&d).expect("it is good");
        let back = morph.pull_back(&g).expect("it is good");
        let off = (inner(&g, &moved) - inner(&back, &d)).abs();
        prop_assert!(off < 1e-12 * size(&g) * size(&moved));
        for (&node, d) in morph.moving().iter().zip(&d) {
            prop_assert_eq!(moved[node as usize], *d);
        }
    }
}
