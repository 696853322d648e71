//! Limits of double precision and their error messages: method `all`, large support radii, surfaces that nearly touch,
//! tolerances near round-off.

use super::{BaseOrigin, Part, Plan, StepEvaluator, check_tolerance, choose};
use crate::motion::Schedule;
use azimesh_core::error::{Error, ErrorKind};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::progress::Silent;
use azimesh_core::ranks::Ranks;
use azimesh_io::mesh::{CellKind, Mesh};
use std::path::Path;
use std::sync::Arc;

const PITCH: &str =
    "body = [ { name = \"a\", tags = [\"airfoil\"], cyclic = { pitch = [ { sin = 5.0 } ] } } ]";

fn airfoil() -> Mesh {
    Mesh::read("testdata/naca0012.vtu").expect("it is good")
}

type Planned = (Arc<Plan>, Arc<Part>);

fn planned(mesh: Mesh, schedule: Schedule) -> Result<Planned, Error> {
    let (plan, part) = Plan::new(mesh, schedule)?;
    Ok((Arc::new(plan), Arc::new(part)))
}

fn plan(mesh: Mesh, rbf: &str, selection: &str) -> Result<Planned, Error> {
    let text = format!(
        "azimuth.values = [0, 90]\nboundaries.others = \"fixed\"\nrbf = {{ {rbf} }}\nselection = {{ {selection} }}\n{PITCH}\n"
    );
    planned(mesh, Schedule::parse(&text, Path::new("s.toml"))?)
}

/// Builds the interval of both steps, after checking its tolerance.
fn interval((plan, part): &Planned) -> Result<StepEvaluator, Error> {
    let selections = choose(plan, &(0..2), &Ranks::alone(), &Silent)?;
    check_tolerance(plan, &selections, BaseOrigin::Chosen)?;
    StepEvaluator::new(plan, part, selections, &(0..2), &Silent)
}

#[test]
fn every_surface_node_with_smooth_kernels_is_solved_as_far_as_it_can_be_and_that_is_told() {
    for (kernel, takes_all) in [("c0", true), ("c2", true), ("c4", false), ("c6", false)] {
        let rbf = format!("kernel = \"wendland-{kernel}\", support_radius = 10.0");
        let planned = plan(airfoil(), &rbf, "method = \"all\"").expect("they fit");
        let (plan, part) = &planned;
        let interval = interval(&planned).unwrap_or_else(|error| panic!("{kernel}: {error}"));
        let mut points = part.mesh.points.clone();
        let step = &plan.motion.steps[1];
        interval.points_at(step, &mut points).expect("it deforms");
        assert_eq!(interval.surface_error(step, &points).0, 0.0, "{kernel}");
        let ratio = part.first_cells.smallest_ratio(&part.mesh, &points);
        assert!(
            ratio.expect("it has first cells") > 0.93,
            "{kernel}: {ratio:?}"
        );
        let n_surface = plan.surface.points.len();
        assert_eq!(interval.n_base == n_surface, takes_all, "{kernel}");
        let mut notes = interval.warnings.iter();
        let not_all = notes.find(|note| note.code == "not_all");
        if let Some(note) = not_all {
            let error = note.get("error").as_f64().expect("a number");
            assert!(error < 1e-6, "{kernel}: {error:e}");
        }
        let is_told = not_all.is_some_and(|note| {
            note.get("base_points") == interval.n_base && note.get("surface") == n_surface
        });
        assert_eq!(is_told, !takes_all, "{kernel}: {:?}", interval.warnings);
    }
}

#[test]
fn round_off_of_a_large_support_radius_is_told_or_refused_with_a_radius_that_works() {
    let mut mesh = airfoil();
    // Moves wall neighbours along their edges: first cells of 1e-6 that were 1e-4 or more.
    let (_, firsts) =
        plan(airfoil(), "support_radius = 10.0", "tolerance = 1e-4").expect("they fit");
    let height = firsts.first_cells.smallest().expect("it has first cells");
    let scale = 1e-6 / height;
    for edge in firsts.first_cells.edges() {
        let (on, off) = (mesh.points[edge.0 as usize], mesh.points[edge.1 as usize]);
        mesh.points[edge.1 as usize] = std::array::from_fn(|i| on[i] + scale * (off[i] - on[i]));
    }
    let of_radius = |radius: f64, selection: &str| {
        let rbf = format!("support_radius = {radius:?}");
        let planned = plan(mesh.clone(), &rbf, selection).expect("they fit");
        let (plan, part) = &planned;
        let interval = interval(&planned)?;
        let mut points = part.mesh.points.clone();
        interval.points_at(&plan.motion.steps[1], &mut points)?;
        let ratio = part.first_cells.smallest_ratio(&part.mesh, &points);
        let notes = interval.warnings.iter();
        let notes = notes.filter_map(|note| note.get("works").as_f64());
        Ok::<_, Error>((
            ratio.expect("it has first cells"),
            notes.collect::<Vec<_>>(),
        ))
    };
    let (exact, notes) = of_radius(10.0, "tolerance = 1e-4").expect("it is small");
    assert!(exact > 0.98 && notes.is_empty(), "{exact} {notes:?}");
    let (_, notes) = of_radius(1000.0, "tolerance = 1e-4").expect("it is told of");
    let (ratio, left) = of_radius(notes[0], "tolerance = 1e-4").expect("it was tried");
    assert!(
        (ratio - exact).abs() < 5e-3 && left.is_empty(),
        "{ratio} {exact} {left:?}"
    );
    let error = of_radius(1000.0, "method = \"all\"").expect_err("it is refused");
    assert_eq!(error.kind, ErrorKind::Check);
    assert!(
        error.message.starts_with("round-off moves nodes by about "),
        "{error}"
    );
}

/// A square with a slit along y = 0 whose upper side is `gap` above the lower.
fn with_slit(gap: f64) -> Mesh {
    const N: usize = 20;
    let at = |i: usize| -1.0 + 2.0 * i as f64 / N as f64;
    let mut points: Vec<Vector> = Vec::new();
    let grid = |i: usize, j: usize| (j * (N + 1) + i) as u32;
    for j in 0..=N {
        points.extend((0..=N).map(|i| [at(i), at(j), 0.0]));
    }
    let inside = 6..15;
    let upper = |i: usize, j: usize| {
        if j == N / 2 && inside.contains(&i) {
            ((N + 1) * (N + 1) + i - inside.start) as u32
        } else {
            grid(i, j)
        }
    };
    points.extend(inside.clone().map(|i| [at(i), gap, 0.0]));
    let mut mesh = Mesh {
        points,
        ..Mesh::default()
    };
    for j in 0..N {
        let node = |i: usize, j: usize, above: bool| if above { upper(i, j) } else { grid(i, j) };
        let above = j >= N / 2;
        for i in 0..N {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let nodes = corners.map(|(i, j)| node(i, j, above));
            mesh.cells.push(CellKind::Quadrilateral, &nodes);
        }
    }
    let mut tag = |name: &str, edges: &[[u32; 2]]| {
        let first = mesh.cells.len();
        edges
            .iter()
            .for_each(|edge| mesh.cells.push(CellKind::Line, edge));
        mesh.add_tag(name, first..mesh.cells.len())
            .expect("they are faces");
    };
    let lower: Vec<_> = (5..15)
        .map(|i| [grid(i, N / 2), grid(i + 1, N / 2)])
        .collect();
    tag("lower", &lower);
    let above: Vec<_> = (6..14)
        .map(|i| [upper(i, N / 2), upper(i + 1, N / 2)])
        .collect();
    tag("upper", &above);
    let sides = (0..N).flat_map(|i| {
        let ends = [
            (i, 0, i + 1, 0),
            (i, N, i + 1, N),
            (0, i, 0, i + 1),
            (N, i, N, i + 1),
        ];
        ends.map(|(i, j, k, l)| [grid(i, j), grid(k, l)])
    });
    tag("far", &sides.collect::<Vec<_>>());
    mesh
}

#[test]
fn surfaces_that_nearly_touch_and_move_apart_miss_the_tolerance_with_any_method() {
    let schedule = |method: &str, body: &str| {
        format!(
            "azimuth.values = [0, 90]\nboundaries.others = \"fixed\"\nrbf.support_radius = 2.0\n\
             selection = {{ method = \"{method}\", tolerance = 1e-4 }}\n\
             body = [ {{ name = \"a\", tags = [{body}], rigid.translate = [0, 0.05, 0] }} ]\n"
        )
    };
    let run = |gap: f64, method: &str, body: &str| {
        let schedule = Schedule::parse(&schedule(method, body), Path::new("s.toml"))?;
        interval(&planned(with_slit(gap), schedule)?).map(|_| ())
    };
    for method in ["all", "sequence"] {
        for gap in [1e-15, 1e-9] {
            let error = run(gap, method, "\"upper\"").expect_err("it cannot be met");
            let told = error.to_string();
            assert_eq!(error.kind, ErrorKind::Check, "{told}");
            let apart = format!("are {gap:.1e} apart and move 0.05 apart");
            assert!(
                told.contains(&apart) && told.contains("with one body"),
                "{told}"
            );
            // Follows the advice of the message.
            assert!(run(gap, method, "\"upper\", \"lower\"").is_ok(), "{method}");
        }
        assert!(run(1e-3, method, "\"upper\"").is_ok(), "{method}");
    }
}

#[test]
fn a_missed_tolerance_is_told_with_what_would_meet_it() {
    let missed = |rbf: &str, selection: &str| {
        let plan = plan(airfoil(), rbf, selection).expect("they fit");
        interval(&plan).err().map(|error| error.message)
    };
    let few = missed("support_radius = 10.0", "tolerance = 1e-5, max_points = 10");
    let few = few.expect("10 points are too few");
    assert!(
        few.ends_with(
            "max_points = 10 is reached; set a larger `max_points` or a larger `tolerance`"
        ),
        "{few}"
    );
    assert_eq!(
        missed(
            "support_radius = 10.0",
            "tolerance = 1e-5, max_points = 200"
        ),
        None
    );
    let rbf = |kernel: &str, radius: f64| {
        format!("kernel = \"wendland-{kernel}\", support_radius = {radius:?}")
    };
    let smooth =
        missed(&rbf("c2", 100.0), "tolerance = 1e-8").expect("double precision ends there");
    let remedy = "set a smaller `support_radius`, a kernel of lower order or a larger `tolerance`";
    assert!(smooth.ends_with(remedy), "{smooth}");
    for (kernel, radius, tolerance) in [("c2", 5.0, 1e-8), ("c0", 100.0, 1e-8), ("c2", 100.0, 1e-4)]
    {
        let tolerance = format!("tolerance = {tolerance:e}");
        assert_eq!(missed(&rbf(kernel, radius), &tolerance), None);
    }
}

#[test]
fn given_base_points_that_miss_the_tolerance_are_told_to_be_chosen_anew() {
    let (plan, _) = plan(airfoil(), "support_radius = 10.0", "tolerance = 1e-5").expect("they fit");
    let base = super::BasePoints::from(plan.surface.nodes[..5].to_vec());
    let given = super::from_nodes(&plan, &(0..2), &base).expect("they are surface nodes");
    let error = check_tolerance(&plan, &given, BaseOrigin::Given).expect_err("5 are too few");
    assert!(error.message.contains("leave out `base`"), "{error}");
    assert!(!error.message.contains("max_points"), "{error}");
}

#[test]
fn a_tolerance_near_round_off_is_not_blamed_on_the_place_of_the_mesh() {
    let tight = plan(airfoil(), "support_radius = 10.0", "tolerance = 1e-16");
    let told = tight.err().expect("it is too small").message;
    assert!(
        told.contains("set a larger `tolerance`, or leave it out") && !told.contains("origin"),
        "{told}"
    );
    let away = |by: f64, selection: &str| {
        let mut mesh = airfoil();
        mesh.points.iter_mut().for_each(|x| x[0] += by);
        let text = format!(
            "azimuth.values = [0, 90]\nboundaries.others = \"fixed\"\nrbf.support_radius = 10.0\nselection = {{ {selection} }}\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], rigid.rotate = {{ axis = [0, 0, 1], origin = [{by:?}, 0, 0], \
             angle = 5 }} }} ]\n"
        );
        let schedule = Schedule::parse(&text, Path::new("s.toml")).expect("it is good");
        Plan::new(mesh, schedule).err().map(|error| error.message)
    };
    let told = away(1e9, "tolerance = 1e-6").expect("it is too far away");
    assert!(
        told.contains("move the mesh near the origin, from which it is "),
        "{told}"
    );
    assert_eq!(away(0.0, "tolerance = 1e-6"), None);
    assert_eq!(away(0.0, ""), None);
}
