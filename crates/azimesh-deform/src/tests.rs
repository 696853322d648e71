//! Plans and deformations of the airfoil of testdata: tolerances, methods, refusals.

use super::{BaseOrigin, Part, Plan, StepEvaluator, check_tolerance, choose, missed_at_step};
use crate::motion::{Role, Schedule};
use azimesh_core::error::Error;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::progress::Silent;
use azimesh_core::ranks::Ranks;
use azimesh_io::formats::{self, Precision};
use azimesh_io::mesh::{CellSet, Mesh};
use std::path::Path;
use std::sync::Arc;

type Planned = (Arc<Plan>, Arc<Part>);

const WALLS: &str = "boundaries.fixed = [\"farfield\"]\n";

fn airfoil() -> Mesh {
    Mesh::read("testdata/naca0012.vtu").expect("it is good")
}

/// The airfoil, with a separate tag for its faces behind x = 0.45.
fn with_flap() -> Mesh {
    let mut mesh = airfoil();
    let at = mesh.groups.iter().position(|group| group.name == "airfoil");
    let mut wing = mesh.groups.remove(at.expect("it has the tag"));
    let mut flap = wing.clone();
    let behind = |cell: &usize| {
        let nodes = mesh.cells.get(*cell).nodes;
        nodes
            .iter()
            .all(|&node| mesh.points[node as usize][0] > 0.45)
    };
    flap.name = "flap".into();
    flap.number = None;
    flap.cells = wing.cells.iter().filter(behind).collect::<CellSet>();
    wing.cells = wing.cells.iter().filter(|cell| !behind(cell)).collect();
    mesh.groups.extend([wing, flap]);
    mesh
}

fn plan_on(mesh: Mesh, schedule: &str) -> Result<Planned, Error> {
    let (plan, part) = Plan::new(mesh, Schedule::parse(schedule, Path::new("s.toml"))?)?;
    Ok((Arc::new(plan), Arc::new(part)))
}

fn plan(schedule: &str) -> Planned {
    plan_on(airfoil(), schedule).expect("they fit")
}

fn told(schedule: &str) -> String {
    let plan = plan_on(airfoil(), schedule);
    plan.err().expect("it is refused").to_string()
}

/// Returns the error that each step reports and the error of its surface.
fn errors((plan, part): &Planned) -> Vec<(f64, f64)> {
    let all = 0..plan.motion.steps.len();
    let selections = choose(plan, &all, &Ranks::alone(), &Silent).expect("there are base points");
    check_tolerance(plan, &selections, BaseOrigin::Chosen).expect("the tolerance is met");
    let deformer =
        StepEvaluator::new(plan, part, selections, &all, &Silent).expect("it can be made");
    let mut points: Vec<Vector> = part.mesh.points.clone();
    let steps = plan.motion.steps.iter();
    let errors = steps.map(|step| {
        let reported = deformer.points_at(step, &mut points).expect("it deforms");
        (reported, deformer.surface_error(step, &points).0)
    });
    errors.collect()
}

#[test]
fn two_bodies_that_twist_about_different_centres_keep_the_tolerance() {
    let schedule = format!(
        "azimuth = {{ stop = 4, step = 1 }}\n{WALLS}rbf = {{ support_radius = 10, interpolate = \"twist\" }}\n\
         selection = {{ tolerance = 1e-4, correction = false }}\n\
         [[body]]\nname = \"wing\"\ntags = [\"airfoil\"]\n\
         rigid = {{ ramp = true, rotate = {{ axis = [0, 0, 1], angle = 40 }} }}\n\
         [[body]]\nname = \"flap\"\ntags = [\"flap\"]\nparent = \"wing\"\n\
         rigid = {{ ramp = true, rotate = {{ axis = [0, 0, 1], origin = [0.45, 0, 0], angle = 2 }} }}\n"
    );
    let plan = plan_on(with_flap(), &schedule).expect("they fit");
    for (reported, error) in errors(&plan) {
        assert!(error <= 1e-4, "{error:e}");
        assert!((reported - error).abs() <= 1e-9, "{reported:e} {error:e}");
    }
}

#[test]
fn steps_that_the_sample_misses_meet_the_tolerance() {
    // At every sampled step of these 240 the airfoil is at rest, between them it pitches by 5 degrees.
    let schedule = format!(
        "time = {{ stop = 23.9, step = 0.1, frequency = 0.5 }}\n{WALLS}rbf.support_radius = 10.0\n\
         selection = {{ tolerance = 1e-4, correction = false }}\n\
         body = [ {{ name = \"a\", tags = [\"airfoil\"], cyclic = {{ pitch = [ {{ sin = 5.0 }} ] }} }} ]\n"
    );
    let errors = errors(&plan(&schedule));
    let largest = errors.iter().map(|errors| errors.1).fold(0.0, f64::max);
    assert!(largest > 1e-6 && largest <= 1e-4, "{largest:e}");
}

#[test]
fn the_third_harmonic_of_a_pitch_in_steps_of_ten_degrees_meets_the_tolerance() {
    let schedule = format!(
        "azimuth = {{ stop = 360, step = 10 }}\n{WALLS}rbf.support_radius = 10.0\n\
         selection = {{ tolerance = 1e-4, correction = false }}\n\
         body = [ {{ name = \"a\", tags = [\"airfoil\"], cyclic = {{ pitch = [ {{}}, {{}}, {{ sin = 10 }} ] }} }} ]\n"
    );
    assert!(
        errors(&plan(&schedule))
            .iter()
            .all(|errors| errors.1 <= 1e-4)
    );
}

#[test]
fn substeps_report_the_error_that_has_added_up() {
    let schedule = |correction: bool| {
        format!(
            "azimuth = {{ stop = 1, step = 1 }}\n{WALLS}rbf = {{ support_radius = 10.0, substeps = 4 }}\n\
             selection = {{ tolerance = 1e-2, correction = {correction} }}\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], rigid = {{ ramp = true, rotate = {{ axis = [0, 0, 1], \
             angle = 40 }} }} }} ]\n"
        )
    };
    let without = plan(&schedule(false));
    let (reported, error) = errors(&without)[1];
    assert!(error > 1e-4);
    assert!((reported - error).abs() <= 1e-14, "{reported:e} {error:e}");
    let (without, with) = (&without.0, plan(&schedule(true)));
    let step = &without.motion.steps[1];
    assert_eq!(
        missed_at_step(without, step, 9, false, 0.02).map(|found| found.1),
        Some(true)
    );
    assert_eq!(missed_at_step(without, step, 9, false, 0.009), None);
    assert_eq!(
        missed_at_step(&with.0, step, 9, false, 0.02).map(|found| found.1),
        Some(false)
    );
    assert_eq!(errors(&with)[1].1, 0.0);
}

#[test]
fn the_error_that_is_reported_has_what_dropped_modes_add() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("u.csv");
    let nodes = airfoil().tag_nodes("airfoil").expect("it has the tag");
    let mut rows = "step,node,dx,dy\n".to_owned();
    for step in 0..6 {
        for node in &nodes {
            // Noise below a hundredth of the smallest first cell.
            let noise = (12.9898 * f64::from(step) + 78.233 * f64::from(*node)).sin() * 43758.5453;
            let (dx, dy) = (0.02 * f64::from(step), 5e-8 * noise.fract());
            rows += &format!("{step},{node},{dx},{dy}\n");
        }
    }
    std::fs::write(&path, rows).expect("it can be written");
    for (substeps, correction) in [(1, false), (1, true), (3, false), (3, true)] {
        let plan = plan(&format!(
            "azimuth = {{ stop = 5, step = 1 }}\n{WALLS}rbf = {{ support_radius = 10.0, substeps = {substeps} }}\n\
             selection = {{ method = \"all\", tolerance = 0.5, correction = {correction} }}\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], surface.file = {path:?} }} ]\n"
        ));
        let truncation = plan.0.truncation();
        assert!(truncation > 1e-8, "{truncation:e}");
        let (reported, error) = errors(&plan)[5];
        let is_right = if correction {
            error == 0.0 && reported > 1e-9
        } else {
            error > 1e-8 && (reported - error).abs() < 1e-14
        };
        assert!(is_right, "{substeps} {correction}: {reported:e} {error:e}");
    }
}

#[test]
fn a_tolerance_that_is_missed_without_the_correction_fails_the_run() {
    let missed = |selection: &str, n_base: usize| {
        let schedule = moved("rigid.translate = [0.1, 0, 0]", selection);
        let (plan, _) = plan(&schedule);
        let found = missed_at_step(&plan, &plan.motion.steps[1], n_base, false, 0.02);
        found.map(|found| found.1)
    };
    for (method, without, with) in [
        ("constant", Some(true), None),
        ("real", Some(true), None),
        ("sequence", Some(true), Some(true)),
    ] {
        for (correction, expected) in [(false, without), (true, with)] {
            let selection = format!(
                "selection = {{ tolerance = 1e-3, method = \"{method}\", correction = {correction}, max_points = 12 }}"
            );
            assert_eq!(missed(&selection, 9), expected, "{selection}");
        }
    }
    // A step whose folded cells made it one of several substeps has its own error, which the correction removes.
    for (correction, expected) in [(true, false), (false, true)] {
        let selection = format!("selection = {{ tolerance = 1e-3, correction = {correction} }}");
        let (plan, _) = plan(&moved("rigid.translate = [0.1, 0, 0]", &selection));
        let found = missed_at_step(&plan, &plan.motion.steps[1], 9, true, 0.02);
        assert_eq!(found.map(|found| found.1), Some(expected), "{selection}");
    }
    // Not an error if it ends at max_points.
    let constant = "selection = { tolerance = 1e-3, method = \"constant\", correction = false, max_points = 12 }";
    assert_eq!(missed(constant, 12), Some(false));
}

#[test]
fn sliding_nodes_stay_on_a_curved_boundary_without_the_correction() {
    for substeps in [1, 4] {
        let schedule = format!(
            "azimuth = {{ stop = 1, step = 1 }}\nboundaries.slide = [\"farfield\"]\n\
             rbf = {{ support_radius = 10.0, substeps = {substeps} }}\n\
             selection = {{ tolerance = 1e-3, correction = false }}\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], rigid = {{ ramp = true, translate = [0.8, 0.3, 0] }} }} ]\n"
        );
        let (plan, part) = plan(&schedule);
        let all = 0..2;
        let selections =
            choose(&plan, &all, &Ranks::alone(), &Silent).expect("there are base points");
        let deformer =
            StepEvaluator::new(&plan, &part, selections, &all, &Silent).expect("it can be made");
        let mut points = part.mesh.points.clone();
        let step = &plan.motion.steps[1];
        deformer.points_at(step, &mut points).expect("it deforms");
        let roles = plan.motion.surface.nodes.roles.iter();
        let sliding = roles.zip(&plan.motion.surface.nodes.nodes);
        let sliding = sliding.filter(|(role, _)| **role == Role::Sliding);
        let off = sliding.map(|(_, &node)| {
            let at = plan.motion.surface.nodes.nodes.binary_search(&node);
            let point = plan.surface.point_of[at.expect("it is on the surface")] as usize;
            let sliding = plan.surface.sliding.as_ref().expect("nodes slide");
            super::fields::sliding::off_boundary(sliding, point, None, points[node as usize])
        });
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-12, "{substeps}: {off:e}");
    }
}

#[test]
fn a_body_without_a_node_of_its_own_has_a_twist() {
    let mut mesh = airfoil();
    let own = mesh.groups.iter().find(|group| group.name == "airfoil");
    let mut again = own.expect("it has the tag").clone();
    again.name = "again".into();
    again.number = None;
    mesh.groups.push(again);
    let schedule = format!(
        "azimuth = {{ stop = 1, step = 1 }}\n{WALLS}rbf = {{ support_radius = 10, interpolate = \"twist\" }}\n\
         selection = {{ tolerance = 1e-3, correction = false }}\n\
         [[body]]\nname = \"a\"\ntags = [\"airfoil\"]\n\
         rigid = {{ ramp = true, rotate = {{ axis = [0, 0, 1], angle = 10 }} }}\n\
         [[body]]\nname = \"b\"\ntags = [\"again\"]\nparent = \"a\"\nrigid.translate = [0, 0, 0]\n"
    );
    match plan_on(mesh, &schedule) {
        Ok(plan) => assert!(errors(&plan).iter().all(|errors| errors.1 <= 1e-3)),
        // Two tags on the same faces may be refused, but with a message about the schedule.
        Err(error) => assert!(error.to_string().starts_with("s.toml:"), "{error}"),
    }
}

fn moved(motion: &str, more: &str) -> String {
    format!(
        "azimuth = {{ stop = 1, step = 1 }}\n{WALLS}{more}\n\
         body = [ {{ name = \"a\", tags = [\"airfoil\"], {motion} }} ]\n"
    )
}

#[test]
fn a_motion_that_overflows_is_told_with_its_place() {
    for motion in [
        "rigid = { translate = [1e308, 0, 0] }",
        "rigid = { rotate = { axis = [0, 0, 1], origin = [1e200, 0, 0], angle = 10 } }",
        "rigid = { rotate = { axis = [0, 0, 1], origin = [1e308, -1e308, 0], angle = 100 } }",
    ] {
        assert_eq!(
            told(&moved(motion, "")),
            "s.toml:4: body \"a\" has displacements at step 0 that are not finite or far too large",
        );
    }
    let fast = format!(
        "time = {{ stop = 1, step = 1, frequency = 1e308 }}\n{WALLS}\
         body = [ {{ name = \"a\", tags = [\"airfoil\"], cyclic = {{ pitch = [ {{ sin = 5 }} ] }} }} ]\n"
    );
    assert_eq!(
        told(&fast),
        "s.toml:1: `frequency` is so large that the azimuth of step 0 is not finite"
    );
    let mut mesh = airfoil();
    mesh.points
        .iter_mut()
        .for_each(|x| *x = x.map(|x| 1e200 * x));
    let schedule = moved("rigid = { translate = [1, 0, 0] }", "");
    let error = plan_on(mesh, &schedule).err().expect("it is refused");
    assert!(
        error.path.is_none() && error.message.contains("overflow"),
        "{error}"
    );
}

#[test]
fn a_support_radius_far_below_the_mesh_is_refused() {
    for kernel in ["wendland-c2", "wendland-c4", "wendland-c6"] {
        let rbf = format!("rbf = {{ kernel = \"{kernel}\", support_radius = 1e-200 }}");
        let told = told(&moved("rigid = { translate = [0.1, 0, 0] }", &rbf));
        assert!(
            told.starts_with("s.toml: rbf.support_radius = 1e-200 is smaller than the distance"),
            "{told}"
        );
    }
}

#[test]
fn a_constant_below_the_tolerance_is_refused() {
    let selection =
        "selection = { tolerance = 1e-3, method = \"constant\", constant = [0, 0, 1e-5] }";
    let told = told(&moved("rigid = { translate = [0.1, 0, 0] }", selection));
    assert!(
        told.starts_with("s.toml: selection.constant has the length 1e-5, which is not larger than the tolerance 0.001"),
        "{told}"
    );
}

#[test]
fn keys_without_effect_on_method_all_are_told() {
    let selection =
        "selection = { tolerance = 1e-3, method = \"all\", max_points = 5, criterion = \"mean\" }";
    let (plan, _) = plan(&moved("rigid = { translate = [0.1, 0, 0] }", selection));
    for key in ["max_points", "criterion"] {
        let mut notes = plan.choices.iter();
        let is_told = notes.any(|note| note.code == "unused_key" && note.get("key") == key);
        assert!(is_told, "{:?}", plan.choices);
    }
}

#[test]
fn coordinates_are_rounded_where_the_format_writes_32_bits() {
    let rounds = |name: &str, asked| {
        let format = formats::by_name(name).expect("there is one");
        format.rounds(asked)
    };
    for name in ["vtu", "vtkhdf", "cgns", "ugrid-b4"] {
        assert!(rounds(name, Precision::F32), "{name}");
    }
    for name in ["su2", "msh", "ugrid", "ugrid-b8"] {
        assert!(!rounds(name, Precision::F32), "{name}");
    }
    assert!(!rounds("vtu", Precision::F64) && rounds("ugrid-b4", Precision::F64));
}

#[test]
fn a_plane_mesh_keeps_its_plane_to_the_last_bit() {
    let cyclic = "cyclic = { collective = 3.0, pitch = [ { sin = 5.0 } ] }";
    for z in [0.0, 0.1] {
        let mut mesh = airfoil();
        mesh.points.iter_mut().for_each(|x| x[2] = z);
        let schedule = format!(
            "azimuth = {{ start = 0.0, stop = 90.0, step = 15.0 }}\nrotor.hub = [0.1, 0.2, {z}]\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], {cyclic} }} ]\n{WALLS}"
        );
        let (plan, part) = plan_on(mesh, &schedule).expect("they fit");
        let all = 0..plan.motion.steps.len();
        let selections =
            choose(&plan, &all, &Ranks::alone(), &Silent).expect("there are base points");
        let deformer =
            StepEvaluator::new(&plan, &part, selections, &all, &Silent).expect("it can be made");
        let mut points = part.mesh.points.clone();
        for step in &plan.motion.steps {
            deformer.points_at(step, &mut points).expect("it deforms");
            let moved = |(x, at_rest): (&Vector, &Vector)| x[..2] != at_rest[..2];
            assert!(points.iter().zip(&part.mesh.points).any(moved));
            assert!(points.iter().all(|x| x[2] == z), "step {}", step.index);
        }
    }
}
