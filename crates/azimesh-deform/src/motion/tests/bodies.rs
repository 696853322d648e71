//! Several bodies: parents and children, and the nodes that they share.

use super::{group, parse, two_squares};
use crate::motion::{Motion, Role};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_io::mesh::{Boundary, CellKind, Mesh};

/// Two squares side by side under two others: tags wing and flap at the bottom share node 1, top.
fn wing_and_flap() -> Mesh {
    let mut mesh = Mesh::default();
    for y in [0.0, 1.0] {
        for x in [0.0, 1.0, 2.0] {
            mesh.points.push([x, y, 0.0]);
        }
    }
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 4, 3]);
    mesh.cells.push(CellKind::Quadrilateral, &[1, 2, 5, 4]);
    for edge in [[0, 1], [1, 2], [3, 4], [4, 5]] {
        mesh.cells.push(CellKind::Line, &edge);
    }
    mesh.groups = vec![
        group(1, "wing", &[2]),
        group(1, "flap", &[3]),
        group(1, "top", &[4, 5]),
    ];
    mesh.validate().expect("a good mesh");
    mesh
}

const WING: &str = "[[body]]\nname = \"wing\"\ntags = [\"wing\"]\nrigid = { rotate = { axis = [0, 0, 1], origin = [0.25, 0, 0], angle = 90.0 }, translate = [0.5, 0, 0] }\n";

fn motion(flap: &str) -> Motion {
    let text = format!(
        "boundaries.fixed = [\"top\"]\ntime = {{ stop = 1.0, step = 0.5 }}\n{WING}[[body]]\nname = \"flap\"\ntags = [\"flap\"]\nparent = \"wing\"\n{flap}\n"
    );
    let schedule = parse(&text).expect("a good schedule");
    schedule
        .resolve_on(&wing_and_flap())
        .expect("it fits the mesh")
}

fn place(motion: &Motion, body: usize, x: Vector) -> Vector {
    motion.pose(body, &motion.steps[0]).apply(x)
}

#[track_caller]
fn assert_near(found: Vector, expected: Vector) {
    assert!(distance(found, expected) < 1e-14, "{found:?} {expected:?}");
}

#[test]
fn a_flap_turns_about_its_hinge_where_the_wing_has_taken_it() {
    let flap = "rigid = { rotate = { axis = [0, 0, 1], origin = [1, 0, 0], angle = -90.0 } }";
    let motion = motion(flap);
    // The wing turns by 90 degrees about [0.25, 0] and moves by 0.5: the hinge is at [0.75, 0.75].
    let hinge = [0.75, 0.75, 0.0];
    assert_near(place(&motion, 0, [1.0, 0.0, 0.0]), hinge);
    assert_near(place(&motion, 1, [1.0, 0.0, 0.0]), hinge);
    // The flap goes up with the wing and then comes down by 90 degrees: it points to x again.
    assert_near(place(&motion, 1, [2.0, 0.0, 0.0]), [1.75, 0.75, 0.0]);
    assert!(
        motion
            .shared_nodes(&Boundary::of(&wing_and_flap()))
            .is_empty()
    );
}

#[test]
fn moving_with_the_parent_and_then_about_the_moved_hinge_is_the_same() {
    let flap = "rigid = { rotate = { axis = [0, 0, 1], origin = [1.1, 0.2, 0], angle = 25.0 } }";
    let motion = motion(flap);
    let wing = motion.pose(0, &motion.steps[0]);
    let hinge = wing.apply([1.1, 0.2, 0.0]);
    let about = Transform::rotation([0.0, 0.0, 1.0], hinge, 25f64.to_radians());
    let x = [1.7, -0.3, 0.0];
    assert_near(place(&motion, 1, x), about.apply(wing.apply(x)));
}

#[test]
fn a_child_without_a_motion_of_its_own_moves_with_its_parent() {
    let motion = motion("");
    let step = &motion.steps[0];
    assert_eq!(motion.pose(1, step).rigid(), motion.pose(0, step).rigid());
    let theta = motion.rotation(1, step, 0.0, 1.0);
    assert!((theta[2].to_degrees() - 90.0).abs() < 1e-12);
}

#[test]
fn a_child_has_the_azimuth_offset_of_its_parent() {
    let of = |own: &str| {
        let text = format!(
            "azimuth.values = [0]\nboundaries.others = \"fixed\"\n{WING}azimuth_offset = 90.0\n[[body]]\nname = \"flap\"\ntags = [\"flap\"]\nparent = \"wing\"\n{own}\n"
        );
        let schedule = parse(&text).expect("a good schedule");
        let motion = schedule
            .resolve_on(&wing_and_flap())
            .expect("it fits the mesh");
        motion.bodies[1].azimuth_offset.to_degrees()
    };
    assert_eq!((of(""), of("azimuth_offset = 0.0")), (90.0, 0.0));
}

#[test]
fn a_shared_node_moves_with_the_body_named_first_and_a_gap_is_told() {
    let motion = motion(
        "rigid = { rotate = { axis = [0, 0, 1], origin = [1, 0, 0], angle = -90.0 }, translate = [0, 0.01, 0] }",
    );
    let at = |node: u32| {
        let nodes = &motion.surface.nodes;
        nodes.roles[nodes.nodes.binary_search(&node).expect("it is there")]
    };
    assert_eq!((at(1), at(2)), (Role::Moving(0), Role::Moving(1)));
    assert_eq!(motion.surface.shared, [(1, 1)]);
    let told = motion.shared_nodes(&Boundary::of(&wing_and_flap()));
    assert_eq!((told.len(), &*told[0].code), (1, "shared_nodes"));
    assert_eq!(
        told[0].text,
        "1 node is on tags of both body \"wing\" and body \"flap\"; they move with the first, up to 0.01 from \
         where the second would put them (step 0)"
    );
}

#[test]
fn a_parent_stands_before_its_child() {
    let text = "time = { stop = 1, step = 1 }\n[[body]]\nname = \"flap\"\ntags = [\"flap\"]\nparent = \"wing\"\n";
    let told = |text: &str| parse(text).expect_err("it is wrong").to_string();
    assert_eq!(
        told(text),
        "hover.toml:5: `parent` = \"wing\" is not a body that is defined before its child; no body is defined before it"
    );
    let after = format!(
        "time = {{ stop = 1, step = 1 }}\n{WING}[[body]]\nname = \"flap\"\ntags = [\"flap\"]\nparent = \"flap\"\n"
    );
    assert_eq!(
        told(&after),
        "hover.toml:9: `parent` = \"flap\" is not a body that is defined before its child; defined before it: wing"
    );
}

#[test]
fn times_need_a_frequency_only_where_the_azimuth_matters() {
    let text = |body: &str, time: &str| {
        format!(
            "boundaries.others = \"fixed\"\ntime = {{ {time} }}\nbody = [ {{ name = \"a\", tags = [\"blade_1\"], {body} }} ]\n"
        )
    };
    let cyclic = "cyclic = { pitch = [ { sin = 10 } ] }";
    let told = parse(&text(cyclic, "stop = 1, step = 0.5")).expect_err("it needs one");
    assert_eq!(
        told.to_string(),
        "hover.toml:2: `time` has no `frequency`, and the harmonics of body \"a\" need the azimuth; add for example  frequency = 2.0, or `azimuth_table` in [rotor]"
    );
    let listed = parse(&text(cyclic, "values = [0, 0.125, 1], frequency = 2")).expect("it is good");
    let motion = listed.resolve_on(&two_squares()).expect("it fits the mesh");
    let azimuths: Vec<f64> = motion.steps.iter().map(|step| step.azimuth_deg).collect();
    assert_eq!(azimuths, [0.0, 90.0, 720.0]);
    let (sin, cos) = 10f64.to_radians().sin_cos();
    let nose = motion.pose(0, &motion.steps[1]).apply([-1.0, 0.0, 0.0]);
    assert_near(nose, [-cos, sin, 0.0]);
    let ramp = "rigid = { translate = [0, 1, 0], ramp = true }";
    let ramp = parse(&text(ramp, "stop = 1, step = 0.25")).expect("no azimuth is needed");
    let steps = ramp.steps().expect("steps");
    assert_eq!((steps[1].time_s, steps[1].azimuth), (Some(0.25), 0.0));
}
