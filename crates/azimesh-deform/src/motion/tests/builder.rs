//! Schedules built in memory: equal to schedules from a file, with the same checks.

use super::{parse, two_cubes, two_squares};
use crate::motion::{
    AxisRotation, Beam, Body, Cyclic, Interpolate, Modes, Motion, Others, Rotor, Schedule, Steps,
    SurfaceMotion, Table, TableMotion, Translation,
};

fn steps() -> Steps {
    Steps::azimuth_deg(0.0, 90.0, 30.0)
}

fn one(body: Body) -> Schedule {
    Schedule::new(steps()).body(body).others(Others::Fixed)
}

/// The same motion of the nodes of the cubes, bit for bit.
#[track_caller]
fn assert_same(made: &Schedule, text: &str) {
    let mesh = two_cubes();
    let read = parse(text).and_then(|schedule| schedule.resolve_on(&mesh));
    let (made, read) = (made.resolve_on(&mesh).expect("made"), read.expect("read"));
    let places = |motion: &Motion| -> Vec<[u64; 3]> {
        let poses = motion.steps.iter().flat_map(|step| motion.poses(step, 1.0));
        let places = poses.flat_map(|pose| {
            let nodes = (0..).zip(&mesh.points);
            nodes
                .map(|(node, x)| pose.place(node, *x))
                .collect::<Vec<_>>()
        });
        places.map(|x| x.map(f64::to_bits)).collect()
    };
    assert_eq!(places(&made), places(&read));
    assert_eq!(made.steps, read.steps);
    assert_eq!(made.surface, read.surface);
}

#[test]
fn every_motion_of_a_file_can_be_made_in_memory() {
    let cyclic = Cyclic::new()
        .collective_deg(10.04)
        .pitch_deg(1, -7.65, -0.96)
        .pitch_deg(2, 0.0, 1.0)
        .coning_deg(2.6)
        .flap_deg(1, 3.2, -0.4)
        .lag_deg(1, 0.1, 0.2)
        .phase_deg(5.0)
        .pitch_axis(0.1, 0.2)
        .flap_hinge(0.3);
    let about = AxisRotation::new([0.0, 2.0, 1.0])
        .origin([0.5, 0.0, 0.0])
        .angle_deg(12.0);
    let rotor = Rotor::new()
        .hub([0.1, 0.2, 0.3])
        .span_axis([2.0, 1.0, 0.0])
        .shaft_axis([0.0, 0.0, 3.0])
        .inertial()
        .rpm(395.0)
        .azimuth_sign(-1.0)
        .flap_sign(-1.0);
    let columns = ["azimuth_deg", "dx", "rot_z_deg"];
    let table = Table::from_rows(
        columns,
        [[0.0, 0.0, 1.0], [60.0, 0.5, 3.0], [270.0, 0.1, 2.0]],
    );
    let made = Schedule::new(steps())
        .rotor(rotor)
        .body(
            Body::new("blade", ["blade_*"])
                .azimuth_offset_deg(40.0)
                .table(TableMotion::new(table).origin([0.2, 0.0, 0.0]).cubic())
                .cyclic(cyclic)
                .rotate(about)
                .translate(Translation::new([0.0, 0.1, 0.2]))
                .ramp(),
        )
        .body(Body::new("hub", ["hub"]).parent("blade"))
        .fixed(["farfield"])
        .free(["side"])
        .zones(["rotor", "background"]);
    let text = "azimuth = { stop = 90, step = 30 }\nboundaries = { fixed = [\"farfield\"], others = \"free\", zones = [\"rotor\", \"background\"] }\n\
        rotor = { hub = [0.1, 0.2, 0.3], span_axis = [2, 1, 0], shaft_axis = [0, 0, 3], frame = \"inertial\", rpm = 395, azimuth_sign = -1, flap_sign = -1 }\n\
        [[body]]\nname = \"blade\"\ntags = [\"blade_*\"]\nazimuth_offset = 40\n\
        rigid = { rotate = { axis = [0, 2, 1], origin = [0.5, 0, 0], angle = 12 }, translate = [0, 0.1, 0.2], ramp = true }\n\
        table = { file = \"TABLE\", origin = [0.2, 0, 0], interpolation = \"cubic\" }\n\
        cyclic = { collective = 10.04, pitch = [ { sin = -7.65, cos = -0.96 }, { cos = 1 } ], coning = 2.6, flap = [ { sin = 3.2, cos = -0.4 } ], lag = [ { sin = 0.1, cos = 0.2 } ], phase = 5, pitch_axis = [0.1, 0.2], flap_hinge = 0.3 }\n\
        [[body]]\nname = \"hub\"\ntags = [\"hub\"]\nparent = \"blade\"\n";
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("t.csv");
    let rows = "azimuth_deg,dx,rot_z_deg\n0,0,1\n60,0.5,3\n270,0.1,2\n";
    std::fs::write(&file, rows).expect("it can be written");
    let file = file.to_str().expect("a plain path").replace('\\', "/");
    assert_same(&made, &text.replace("TABLE", &file));
}

#[test]
fn beams_modes_and_surfaces_are_made_of_tables_in_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("it can be written");
        path.to_str().expect("a plain path").replace('\\', "/")
    };
    let text = |motion: String| {
        format!(
            "azimuth = {{ stop = 90, step = 30 }}\nboundaries.others = \"fixed\"\n[[body]]\nname = \"b\"\ntags = [\"blade_1\"]\n{motion}\n"
        )
    };
    let head = "station,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg";
    let file = write(
        "b.csv",
        &format!("{head}\n0,0,0,0,0,0,0\n1,0,0,0.4,5,0,0\n"),
    );
    let rows = [[0.0; 7], [1.0, 0.0, 0.0, 0.4, 5.0, 0.0, 0.0]];
    let beam = Beam::new(Table::from_rows(head.split(','), rows));
    let body = Body::new("b", ["blade_1"]);
    assert_same(
        &one(body.clone().beam(beam)),
        &text(format!("beam.table = \"{file}\"")),
    );
    let nodes = [
        [0.0, 0.0, 0.0, 0.1],
        [1.0, 0.1, 0.0, 0.0],
        [2.0, 0.0, 0.2, 0.0],
        [3.0; 4],
    ];
    let file = write(
        "s.csv",
        "node,dx,dy,dz\n0,0,0,0.1\n1,0.1,0,0\n2,0,0.2,0\n3,3,3,3\n",
    );
    let surface = Table::from_rows(["node", "dx", "dy", "dz"], nodes);
    assert_same(
        &one(body.clone().surface(SurfaceMotion::new(surface))),
        &text(format!("surface.file = \"{file}\"")),
    );
    let shapes = nodes.map(|[node, x, y, z]| [node, 1.0, x, y, z]);
    let shapes = Table::from_rows(["node", "mode", "dx", "dy", "dz"], shapes);
    let q = Table::from_rows(
        ["azimuth_deg", "q1"],
        [[0.0, 0.0], [180.0, 2.0], [360.0, 0.0]],
    );
    let shapes_file = write(
        "m.csv",
        "node,mode,dx,dy,dz\n0,1,0,0,0.1\n1,1,0.1,0,0\n2,1,0,0.2,0\n3,1,3,3,3\n",
    );
    let q_file = write("q.csv", "azimuth_deg,q1\n0,0\n180,2\n360,0\n");
    assert_same(
        &one(body.modes(Modes::new(shapes, q))),
        &text(format!(
            "modes = {{ shapes = \"{shapes_file}\", coordinates = \"{q_file}\" }}"
        )),
    );
}

#[test]
fn what_is_wrong_is_told_by_the_name_of_its_place() {
    let pitching =
        || Body::new("airfoil", ["blade_1"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0));
    let good = || one(pitching());
    let new = |steps| Schedule::new(steps).body(pitching()).others(Others::Fixed);
    for (schedule, expected) in [
        (
            Schedule::new(steps()),
            "the schedule has no [[body]], so nothing would move; add one with name, tags and a motion",
        ),
        (
            new(Steps::azimuths_deg([0.0, f64::NAN])),
            "azimuth: `values` is [NaN]; it must be finite",
        ),
        (
            new(Steps::time_s(0.0, 1.0, 0.1).frequency_hz(-1.0)),
            "time: `frequency` is -1; it must be a number greater than 0",
        ),
        (
            good().body(pitching()),
            "body \"airfoil\": there are two bodies \"airfoil\"; each needs a name of its own",
        ),
        (
            good().body(Body::new("flap", ["hub"]).parent("wing")),
            "body \"flap\": `parent` = \"wing\" is not a body that is defined before its child; defined before it: airfoil",
        ),
        (
            good().body(Body::new("flap", [""; 0]).parent("airfoil")),
            "body \"flap\" has no `tags`; add for example  tags = [\"blade\"], or `zones` that move rigidly",
        ),
        (
            one(Body::new("a", ["blade_1"]).rotate(AxisRotation::new([0.0; 3]))),
            "body \"a\": `axis` has length zero; it must be a direction such as [0.0, 0.0, 1.0]",
        ),
        (
            one(Body::new("a", ["blade_1"]).translate(Translation::new([0.0, f64::INFINITY, 0.0]))),
            "body \"a\": `translate` is [0.0, inf, 0.0]; it must be finite",
        ),
        (
            one(Body::new("a", ["blade_1"]).ramp()),
            "body \"a\": [body.rigid] has neither `rotate` nor `translate`; give one of them",
        ),
        (
            one(Body::new("a", ["blade_1"]).cyclic(Cyclic::new().flap_deg(0, 1.0, 0.0))),
            "body \"a\": the flap has a harmonic 0; harmonics go from 1 to 1000",
        ),
        (
            one(Body::new("a", ["blade"]).cyclic(Cyclic::new())),
            "body \"a\": tag \"blade\" is not in the mesh; it has: blade_1, hub, side, farfield",
        ),
        (
            one(Body::new("a", ["blade_1"])
                .table(Table::from_rows(["step", "dx"], [[0.0, 1.0], [0.0, 2.0]]))),
            "table in memory:2: step 0 repeats step 0 of line 1; `step` must increase from row to row",
        ),
        (
            one(Body::new("a", ["blade_1"]).table(Table::from_rows(["step", "dx"], [[0.0]]))),
            "table in memory:1: [0.0] is not a row of 2 finite numbers, one for each column",
        ),
        (
            good().velocity(),
            "output: `velocity` = true needs the time of every step; give the schedule [time], or `rpm` in [rotor]",
        ),
        (
            good().substeps(0),
            "rbf: `substeps` is 0; at most 1000 are possible",
        ),
        (
            good().tolerance(f64::NAN),
            "selection: `tolerance` is NaN; it must be a number greater than 0",
        ),
        (
            good().rotor(Rotor::new().pitch_sign(2.0)),
            "rotor: `pitch_sign` is 2; it must be 1 or -1",
        ),
        (
            good().rotor(Rotor::new().shaft_axis([1.0, 0.0, 0.0])),
            "rotor: span axis and shaft axis are parallel; they must be perpendicular",
        ),
        (
            good().fixed(["nowhere"]),
            "boundaries: tag \"nowhere\" is not in the mesh; it has: blade_1, hub, side, farfield",
        ),
    ] {
        let error = schedule.resolve_on(&two_cubes()).expect_err(expected);
        assert_eq!(error.to_string(), expected);
    }
    assert!(
        good()
            .interpolate(Interpolate::Twist)
            .rotation_radius(1.0)
            .resolve_on(&two_cubes())
            .is_ok()
    );
}

#[test]
fn a_body_that_leaves_the_plane_is_told_by_its_name() {
    let body = Body::new("a", ["blade_1"]).cyclic(Cyclic::new().coning_deg(1.0));
    let error = one(body)
        .resolve_on(&two_squares())
        .expect_err("it flaps")
        .to_string();
    assert_eq!(
        error,
        "body \"a\" flaps or lags, which needs a 3D mesh; in 2D a cyclic motion is pitch alone"
    );
}

#[test]
fn a_step_says_which_one_it_is() {
    let shown = |steps: Steps| {
        let schedule = Schedule::new(steps);
        let last = *schedule
            .steps()
            .expect("steps")
            .last()
            .expect("one at least");
        (
            last.index(),
            last.azimuth_deg(),
            last.time_s(),
            last.to_string(),
        )
    };
    assert_eq!(
        shown(steps()),
        (3, Some(90.0), None, "step 3 (azimuth 90 degrees)".into())
    );
    let timed = Steps::time_s(0.0, 0.5, 0.25);
    assert_eq!(
        shown(timed.clone()),
        (2, None, Some(0.5), "step 2 (0.5 s)".into())
    );
    let turning = (
        2,
        Some(90.0),
        Some(0.5),
        "step 2 (azimuth 90 degrees)".into(),
    );
    assert_eq!(shown(timed.frequency_hz(0.5)), turning);
}

#[test]
fn a_schedule_can_go_to_other_threads() {
    fn is_shared<T: Send + Sync + Clone + std::fmt::Debug + 'static>() {}
    is_shared::<Schedule>();
    is_shared::<Motion>();
}
