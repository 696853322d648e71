use super::*;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{add, distance};

fn flat_sliding(points: &[Vector], facets: &[[u32; 3]], tags: &[u32], slides: &[bool]) -> Sliding {
    let facets = SlidingFacets::flat(facets.to_vec(), tags.to_vec());
    Sliding::new(points, &facets, slides, &Images::default())
}

/// A surface put together from structured pieces whose points are shared where they coincide.
#[derive(Default)]
struct Made {
    points: Vec<Vector>,
    facets: Vec<[u32; 3]>,
    tags: Vec<u32>,
}

impl Made {
    fn point(&mut self, x: Vector) -> u32 {
        let same = self.points.iter().position(|p| distance(*p, x) < 1e-9);
        same.unwrap_or_else(|| {
            self.points.push(x);
            self.points.len() - 1
        }) as u32
    }

    /// `n` by `m` quadrilaterals over the unit square of parameters.
    fn piece(&mut self, n: usize, m: usize, tag: u32, at: impl Fn(f64, f64) -> Vector) {
        let mut corner =
            |i: usize, j: usize| self.point(at(i as f64 / n as f64, j as f64 / m as f64));
        let mut facets = Vec::new();
        for i in 0..n {
            for j in 0..m {
                let (a, b) = (corner(i, j), corner(i + 1, j));
                let (c, d) = (corner(i + 1, j + 1), corner(i, j + 1));
                facets.extend([[a, b, c], [a, c, d]]);
            }
        }
        facets.retain(|[a, b, c]| a != b && b != c && c != a);
        self.tags.resize(self.tags.len() + facets.len(), tag);
        self.facets.extend(facets);
    }

    fn sliding(&self) -> Sliding {
        let all = vec![true; self.points.len()];
        flat_sliding(&self.points, &self.facets, &self.tags, &all)
    }
}

fn cube(n: usize) -> Made {
    let mut made = Made::default();
    for side in [0.0, 1.0] {
        made.piece(n, n, 7, |u, v| [side, u, v]);
        made.piece(n, n, 7, |u, v| [u, side, v]);
        made.piece(n, n, 7, |u, v| [u, v, side]);
    }
    made
}

#[test]
fn a_box_of_one_tag_has_faces_edges_and_corners() {
    let made = cube(4);
    let sliding = made.sliding();
    assert_eq!(sliding.n_patches(), 6);
    assert!(!sliding.has_curved());
    for (i, x) in made.points.iter().enumerate() {
        let on_sides: Vec<usize> = (0..3).filter(|&k| x[k] == 0.0 || x[k] == 1.0).collect();
        let constraint = sliding.constraint(i);
        assert_eq!(constraint.rank(), on_sides.len(), "{x:?}");
        let turns = if on_sides.len() == 1 { 2 } else { 3 };
        assert_eq!(sliding.rotation_constraint(i).rank(), turns);
        let moved = [x[0] + 0.1, x[1] - 0.3, x[2] + 1.0 / 3.0];
        let placed = sliding.place(i, moved);
        for k in 0..3 {
            let expected = if on_sides.contains(&k) {
                x[k]
            } else {
                moved[k]
            };
            assert_eq!(placed[k].to_bits(), expected.to_bits());
        }
    }
}

#[test]
fn planes_that_are_not_along_axes_keep_their_points() {
    let turn = Transform::rotation([1.0, 2.0, -0.7], [0.3, 0.0, 5.0], 0.83);
    let mut made = cube(3);
    for x in &mut made.points {
        *x = turn.apply(*x);
    }
    let sliding = made.sliding();
    assert!(!sliding.has_curved());
    let back = turn.inverse();
    for (i, x) in made.points.iter().enumerate() {
        let original = back.apply(*x);
        let placed = back.apply(sliding.place(i, add(*x, [0.2, 0.1, -0.3])));
        for k in 0..3 {
            let on_side = original[k].abs() < 1e-9 || (original[k] - 1.0).abs() < 1e-9;
            assert!(!on_side || (placed[k] - original[k]).abs() < 1e-14);
        }
    }
}

#[test]
fn two_planes_of_a_narrow_wedge_are_two_patches() {
    let (sin, cos) = 5f64.to_radians().sin_cos();
    let mut made = Made::default();
    made.piece(4, 3, 0, |u, v| [u, 0.0, v]);
    made.piece(4, 3, 0, |u, v| [u * cos, u * sin, v]);
    let sliding = made.sliding();
    assert_eq!(sliding.n_patches(), 2);
    for (i, x) in made.points.iter().enumerate() {
        let constraint = sliding.constraint(i);
        let normal = constraint.columns()[0];
        assert_eq!(normal[2], 0.0);
        if x[0] == 0.0 {
            assert_eq!(constraint.rank(), 2);
            let placed = sliding.place(i, add(*x, [0.1, 0.2, 0.3]));
            assert!(placed[0].abs() < 1e-15 && placed[1] == 0.0);
            assert_eq!(placed[2], x[2] + 0.3);
        } else if x[1] == 0.0 {
            assert_eq!(constraint.columns(), [[0.0, 1.0, 0.0]]);
        } else {
            assert_eq!(constraint.rank(), 1);
            assert!((normal[0].abs() - sin).abs() < 1e-15);
        }
    }
}

/// The side and the two ends of a cylinder about x, 36 facets round.
fn cylinder() -> Made {
    let turn = |v: f64| std::f64::consts::TAU * v;
    let mut made = Made::default();
    made.piece(5, 36, 0, |u, v| {
        [0.1 + 0.6 * u, turn(v).cos(), turn(v).sin()]
    });
    for end in [0.1, 0.7] {
        made.piece(3, 36, 0, |u, v| [end, u * turn(v).cos(), u * turn(v).sin()]);
    }
    made
}

#[test]
fn a_cylinder_has_a_curved_side_two_planes_and_two_rims() {
    let made = cylinder();
    let sliding = made.sliding();
    assert_eq!(sliding.n_patches(), 3);
    assert!(sliding.has_curved());
    let apothem = (std::f64::consts::PI / 36.0).cos();
    for (i, x) in made.points.iter().enumerate() {
        let (constraint, radius) = (sliding.constraint(i), x[1].hypot(x[2]));
        let moved = add(*x, [0.1, 0.2, 0.1]);
        let placed = sliding.place(i, moved);
        let placed_radius = placed[1].hypot(placed[2]);
        let on_end = x[0] < 0.101 || x[0] > 0.699;
        if on_end {
            assert_eq!(placed[0].to_bits(), x[0].to_bits());
        }
        if radius > 0.999 {
            assert!((apothem - 1e-12..1.0 + 1e-12).contains(&placed_radius));
            assert!(distance(placed, moved) < 0.3);
            assert_eq!(constraint.rank(), if on_end { 2 } else { 1 });
            let radial = constraint.project([0.0, x[1], x[2]]);
            assert!(distance(radial, [0.0, x[1], x[2]]) < 2e-3, "{constraint:?}");
        } else {
            assert_eq!(constraint.columns(), [[1.0, 0.0, 0.0]]);
            assert_eq!(placed[1..], moved[1..]);
        }
        assert_eq!(sliding.place(i, *x), *x);
    }
}

#[test]
fn a_square_in_the_plane_slides_along_its_sides_and_stays_at_its_corners() {
    let mut made = Made::default();
    let n = 5;
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    for side in 0..4 {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        for i in 0..n {
            let at = |i: usize| {
                let t = i as f64 / n as f64;
                add(scale(a, 1.0 - t), scale(b, t))
            };
            let (p, q) = (made.point(at(i)), made.point(at(i + 1)));
            made.facets.push([p, q, q]);
            made.tags.push(0);
        }
    }
    let sliding = made.sliding();
    assert_eq!(sliding.n_patches(), 4);
    for (i, x) in made.points.iter().enumerate() {
        assert_eq!(sliding.rotation_constraint(i), Constraint::ALL);
        let moved = add(*x, [0.1, -0.2, 0.0]);
        let placed = sliding.place(i, moved);
        if i % n == 0 {
            assert_eq!(sliding.constraint(i), Constraint::ALL);
            assert_eq!(placed, *x);
        } else if x[1] == 0.0 || x[1] == 1.0 {
            assert_eq!(sliding.constraint(i).columns(), [[0.0, 1.0, 0.0]]);
            assert_eq!(placed, [moved[0], x[1], 0.0]);
        } else {
            assert_eq!(sliding.constraint(i).columns(), [[1.0, 0.0, 0.0]]);
        }
    }
}

#[test]
fn a_circle_in_the_plane_is_one_curve() {
    let n = 40;
    let at = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        [cos, sin, 0.0]
    };
    let points: Vec<Vector> = (0..n).map(at).collect();
    let facets: Vec<[u32; 3]> = (0..n as u32)
        .map(|i| [i, (i + 1) % n as u32, (i + 1) % n as u32])
        .collect();
    let sliding = flat_sliding(&points, &facets, &vec![0; n], &vec![true; n]);
    assert!(sliding.has_curved());
    for (i, x) in points.iter().enumerate() {
        let normal = sliding.constraint(i).columns()[0];
        assert!((dot(normal, *x).abs() - 1.0).abs() < 1e-12);
        let placed = sliding.place(i, add(*x, [0.1, 0.1, 0.0]));
        assert!((norm(placed) - 1.0).abs() < 4e-3);
    }
}

#[test]
fn facets_without_area_change_nothing() {
    let sound = cube(3);
    let mut made = cube(3);
    // A sliver along an edge that two facets share, one with corners repeated, one facet twice.
    let [a, b, c] = made.facets[0];
    let middle = made.point(scale(
        add(made.points[a as usize], made.points[c as usize]),
        0.5,
    ));
    made.facets[0] = [a, b, middle];
    made.facets
        .extend([[middle, b, c], [a, middle, c], [a, a, b], made.facets[5]]);
    made.tags.resize(made.facets.len(), 7);
    let sliding = made.sliding();
    let expected = sound.sliding();
    assert_eq!(sliding.n_patches(), 6);
    for i in 0..sound.points.len() {
        assert_eq!(sliding.constraint(i), expected.constraint(i), "{i}");
    }
    let across = sliding.constraint(middle as usize);
    assert_eq!(across.columns(), [[1.0, 0.0, 0.0]]);
}

#[test]
fn only_points_that_slide_are_placed_and_those_without_facets_stay() {
    let mut made = cube(2);
    let alone = made.point([5.0, 5.0, 5.0]) as usize;
    let mut slides = vec![true; made.points.len()];
    slides[0] = false;
    let sliding = flat_sliding(&made.points, &made.facets, &made.tags, &slides);
    let away = [9.0, 8.0, 7.0];
    assert_eq!(sliding.constraint(0), Constraint::ALL);
    assert_eq!(sliding.place(0, away), away);
    assert_eq!(sliding.constraint(alone), Constraint::ALL);
    assert_eq!(sliding.place(alone, away), [5.0; 3]);
    let none = flat_sliding(&made.points, &[], &[], &slides);
    assert_eq!(none.place(1, away), made.points[1]);
}

#[test]
fn points_between_two_tags_of_one_plane_keep_to_their_seam() {
    let mut made = Made::default();
    made.piece(4, 4, 0, |u, v| [u, v, 0.25]);
    made.piece(4, 4, 1, |u, v| [1.0 + u, v, 0.25]);
    let sliding = made.sliding();
    assert!(!sliding.has_curved());
    for (i, x) in made.points.iter().enumerate() {
        let rank = sliding.constraint(i).rank();
        assert_eq!(rank, if x[0] == 1.0 { 2 } else { 1 });
        if x[0] == 1.0 {
            let placed = sliding.place(i, [1.3, 0.4, 0.9]);
            assert_eq!(placed, [1.0, 0.4, 0.25]);
        }
    }
}

#[test]
fn a_patch_that_meets_itself_at_a_sharp_edge_keeps_points_there() {
    // The side of a prism over a teardrop: a circle with a tail, one tag, one patch.
    let mut made = Made::default();
    made.piece(120, 4, 0, |u, v| {
        let t = std::f64::consts::TAU * u;
        [t.cos(), t.sin() * (0.5 * t).sin().powi(2), v]
    });
    let sliding = made.sliding();
    assert_eq!(sliding.n_patches(), 1);
    for (i, x) in made
        .points
        .iter()
        .enumerate()
        .filter(|(_, x)| x[0] > 0.999_9)
    {
        let constraint = sliding.constraint(i);
        assert_eq!(constraint.rank(), 2, "{x:?}");
        let placed = sliding.place(i, add(*x, [0.1, 0.1, 0.1]));
        assert!(distance(placed, [1.0, 0.0, placed[2]]) < 1e-12);
        assert!((placed[2] - f64::min(1.0, x[2] + 0.1)).abs() < 1e-12);
    }
}

/// All turns of a sector of a part of the circle about z.
fn turns(parts: usize) -> Vec<Transform> {
    let angle = |n: usize| std::f64::consts::TAU * n as f64 / parts as f64;
    let turn = |n| Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], angle(n));
    (1..parts).map(turn).collect()
}

impl Made {
    /// The sliding points with the images of a sector, whose points on the second side follow those on the first.
    fn of_sector(&self, parts: usize) -> Sliding {
        let maps = turns(parts);
        let leader = |x: &Vector| {
            let back = maps[0].inverse().apply(*x);
            self.points.iter().position(|p| distance(*p, back) < 1e-9)
        };
        let points = self.points.iter().zip(0..);
        let leaders = points.map(|(x, at)| leader(x).map_or(at, |leader| leader as u32));
        let images = Images {
            leaders: leaders.collect(),
            maps: std::sync::Arc::new(maps.clone()),
        };
        let facets = SlidingFacets::flat(self.facets.clone(), self.tags.clone());
        Sliding::new(
            &self.points,
            &facets,
            &vec![true; self.points.len()],
            &images,
        )
    }
}

/// The angle of a point about z, and its distance from a regular polygon of as many sides, whose corners have the radius 1.
fn on_polygon(x: Vector, sides: f64) -> (f64, f64) {
    let (angle, side) = (x[1].atan2(x[0]), std::f64::consts::TAU / sides);
    let from_middle = angle.rem_euclid(side) - 0.5 * side;
    (
        angle,
        x[0].hypot(x[1]) * from_middle.cos() - (0.5 * side).cos(),
    )
}

#[test]
fn a_curved_wall_continues_through_periodic_sides() {
    // 60 degrees of a cylinder in 6 facets, with a plane end.
    let at = |v: f64| (std::f64::consts::FRAC_PI_3 * v).sin_cos();
    let mut made = Made::default();
    made.piece(6, 3, 0, |v, z| [at(v).1, at(v).0, z]);
    made.piece(6, 2, 1, |v, r| {
        [(1.0 + r) * at(v).1, (1.0 + r) * at(v).0, 0.0]
    });
    let sliding = made.of_sector(6);
    for (i, x) in made.points.iter().enumerate() {
        let (angle, radius) = (x[1].atan2(x[0]), x[0].hypot(x[1]));
        let constraint = sliding.constraint(i);
        if radius > 1.001 {
            assert_eq!(constraint.columns(), [[0.0, 0.0, 1.0]]);
            continue;
        }
        assert_eq!(constraint.rank(), if x[2] == 0.0 { 2 } else { 1 });
        let radial = [x[0], x[1], 0.0];
        // Normals of the facets around a point, by area: within a third of the angle between facets.
        assert!(distance(constraint.project(radial), radial) < 0.04, "{x:?}");
        for by in [-0.4f64, 0.3] {
            let moved = Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], by).apply(*x);
            let placed = sliding.place(i, moved.map(|c| 1.02 * c));
            let (found, off) = on_polygon(placed, 36.0);
            assert!(off.abs() < 1e-12, "{x:?} {by}: {off:e}");
            assert!((found - angle - by).abs() < 4e-3, "{x:?} {by}: {found}");
        }
        let ends = [0.0, std::f64::consts::FRAC_PI_3];
        if ends.iter().any(|end| (angle - end).abs() < 1e-9) {
            let across = constraint.project([-x[1], x[0], 0.0]);
            assert!(norm(across) < 0.04, "the tangent at a side is free");
        }
    }
}

#[test]
fn partners_slide_to_places_that_are_images_of_each_other() {
    let height = |x: f64| 0.1 * (std::f64::consts::TAU * x).sin();
    let mut made = Made::default();
    made.piece(12, 5, 0, |u, v| [u, v, height(u)]);
    let maps = [1.0, -1.0].map(|n| Transform::translation([n, 0.0, 0.0]));
    let leader = |(at, x): (usize, &Vector)| match x[0] {
        1.0 => made
            .points
            .iter()
            .position(|p| *p == [0.0, x[1], height(0.0)]),
        _ => Some(at),
    };
    let leaders = made.points.iter().enumerate().map(leader);
    let images = Images {
        leaders: leaders
            .map(|at| at.expect("it has a partner") as u32)
            .collect(),
        maps: std::sync::Arc::new(maps.to_vec()),
    };
    let facets = SlidingFacets::flat(made.facets.clone(), made.tags.clone());
    let sliding = Sliding::new(
        &made.points,
        &facets,
        &vec![true; made.points.len()],
        &images,
    );
    let followers = images.leaders.iter().enumerate();
    for (follower, &leader) in followers.filter(|(at, leader)| *at != **leader as usize) {
        let leader = leader as usize;
        let [a, b] = [leader, follower].map(|at| sliding.constraint(at));
        assert!(distance(a.columns()[0], b.columns()[0]) < 1e-12);
        for way in [[0.2, 0.1, 0.0], [-0.2, 0.1, 0.05]] {
            let [a, b] = [leader, follower].map(|at| sliding.place(at, add(made.points[at], way)));
            assert!(distance(add(a, [1.0, 0.0, 0.0]), b) < 1e-12);
            assert!((a[0] - way[0]).abs() < 0.1, "{a:?}");
        }
    }
}

#[test]
fn a_channel_whose_flat_wall_folds_at_periodic_sides_keeps_planes_and_corners() {
    let mut made = Made::default();
    let (cos, sin) = (0.5, 0.75f64.sqrt());
    made.piece(4, 3, 0, |u, z| [1.0 + (cos - 1.0) * u, sin * u, z]);
    let sliding = made.of_sector(6);
    assert!(!sliding.has_curved());
    for (i, x) in made.points.iter().enumerate() {
        let at_side = (norm([x[0], x[1], 0.0]) - 1.0).abs() < 1e-9;
        assert_eq!(sliding.constraint(i).rank(), if at_side { 2 } else { 1 });
    }
}

/// The map of triangles with six nodes: corners, then middles of the sides.
fn triangle_of_six() -> FaceMap {
    let rows = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-3.0, -1.0, 0.0, 4.0, 0.0, 0.0],
        [-3.0, 0.0, -1.0, 0.0, 0.0, 4.0],
        [2.0, 2.0, 0.0, -4.0, 0.0, 0.0],
        [4.0, 0.0, 0.0, -4.0, 4.0, -4.0],
        [2.0, 0.0, 2.0, 0.0, 0.0, -4.0],
    ];
    FaceMap {
        places: vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [0.5, 0.0],
            [0.5, 0.5],
            [0.0, 0.5],
        ],
        exponents: vec![[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]],
        shares: rows.concat(),
    }
}

#[test]
fn points_on_curved_faces_slide_on_their_polynomials() {
    // A paraboloid in triangles of six nodes, each four facets: their map is exact.
    let height = |x: f64, y: f64| 0.15 * x * x - 0.1 * x * y + 0.2 * y * y;
    let n = 4;
    let mut made = Made::default();
    let at = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| k as f64 / (2 * n) as f64);
        [x, y, height(x, y)]
    };
    let map = std::sync::Arc::new(triangle_of_six());
    let mut facets = SlidingFacets::default();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (2 * i, 2 * j))) {
        let lower = [[0, 0], [2, 0], [2, 2], [1, 0], [2, 1], [1, 1]];
        let upper = [[0, 0], [2, 2], [0, 2], [1, 1], [1, 2], [0, 1]];
        for six in [lower, upper] {
            let nodes = six.map(|[di, dj]| made.point(at(i + di, j + dj)));
            let pieces = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
            facets
                .corners
                .extend(pieces.map(|piece| piece.map(|k: usize| nodes[k])));
            facets.faces.extend([facets.curved.len() as u32; 4]);
            facets.tags.extend([0; 4]);
            facets.curved.push(CurvedFace {
                nodes: nodes.to_vec(),
                map: map.clone(),
            });
        }
    }
    let all = vec![true; made.points.len()];
    let sliding = Sliding::new(&made.points, &facets, &all, &Images::default());
    for (i, x) in made.points.iter().enumerate() {
        let moved = add(*x, [0.07 - 0.05 * x[0], 0.03 * x[1], 0.02]);
        let placed = sliding.place(i, moved);
        let [x, y, z] = placed;
        assert!((z - height(x, y)).abs() < 1e-14, "{placed:?}");
        let inside = [x, y].iter().all(|c| (1e-9..1.0 - 1e-9).contains(c));
        let normal = [-0.3 * x + 0.1 * y, 0.1 * x - 0.4 * y, 1.0];
        let away = cross(sub(moved, placed), normal);
        assert!(
            !inside || norm(away) < 1e-7 * norm(sub(moved, placed)),
            "{placed:?} {away:?}"
        );
        assert!(distance(sliding.place(i, placed), placed) < 1e-14);
    }
}
