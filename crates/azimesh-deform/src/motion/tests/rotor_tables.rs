//! The azimuth from a table over time, and plane meshes that turn.

use super::tables::{assert_near, place, resolve, told_at};
use crate::motion::{Body, Motion, Others, Rotor, Schedule, Steps, Table, Translation};

fn azimuths(motion: &Motion) -> Vec<(f64, f64)> {
    let steps = motion.steps.iter();
    steps
        .map(|step| {
            let rate = step.azimuth_rate.expect("it is known");
            (step.azimuth_deg().expect("it is known"), rate.to_degrees())
        })
        .collect()
}

#[test]
fn a_rotor_speeds_up_by_a_table() {
    let files = [
        (
            "azimuth.csv",
            "time_s,azimuth_deg\n0,0\n1,30\n2,120\n3,270\n",
        ),
        ("m.csv", "azimuth_deg,dz\n0,0\n180,1\n360,0\n"),
    ];
    let head = "time.values = [0, 1.5, 3]\nrotor = { azimuth_table = \"azimuth.csv\", frame = \"inertial\" }";
    let body = "cyclic = { pitch = [ { sin = 5 } ] }\ntable.file = \"m.csv\"";
    let motion = resolve(false, head, body, &files).expect("it is good");
    let expected = [(0.0, 30.0), (75.0, 90.0), (270.0, 150.0)];
    for ((azimuth, rate), (expected, n)) in azimuths(&motion).into_iter().zip(expected) {
        assert!(azimuth == expected && (rate - n).abs() < 1e-12);
    }
    // As at the same azimuths without times.
    let same = resolve(false, "azimuth.values = [0, 75, 270]", body, &files).expect("it is good");
    for step in 0..3 {
        let x = [0.3, 0.4, 0.2];
        assert_near(place(&motion, step, x), place(&same, step, x));
    }
    let turn = motion
        .to_inertial(&motion.steps[1])
        .expect("it is inertial");
    let (sin, cos) = 75f64.to_radians().sin_cos();
    assert_near(
        turn.of_body(0).expect("it turns").apply([1.0, 0.0, 0.0]),
        [cos, sin, 0.0],
    );
    // 75 degrees at 90 degrees a second, at a radius of 2.
    let moving = motion
        .to_inertial_moving(&motion.steps[1])
        .expect("it is inertial");
    let speed = 2.0 * 90f64.to_radians();
    let found = moving
        .of_body(0)
        .expect("it turns")
        .velocity([2.0, 0.0, 0.0], [0.0; 3]);
    assert_near(found, [-speed * sin, speed * cos, 0.0]);
}

#[test]
fn a_cubic_table_of_the_azimuth_has_no_jumps_of_speed() {
    let rows = (0..5).map(|i| format!("{i},{}\n", 10 * i * i));
    let table = format!("time_s,azimuth_deg\n{}", rows.collect::<String>());
    let head = "time.values = [0, 1, 2.5]\nrotor = { azimuth_table = \"a.csv\", azimuth_interpolation = \"cubic\" }";
    let motion = resolve(
        false,
        head,
        "rigid.translate = [0, 0, 1]",
        &[("a.csv", &table)],
    );
    let found = azimuths(&motion.expect("it is good"));
    for ((azimuth, rate), (time, n)) in
        found
            .into_iter()
            .zip([(0.0, 0.0), (1.0, 10.0), (2.5, 62.5)])
    {
        assert!((azimuth - n).abs() < 1e-12 && (rate - 20.0 * time).abs() < 1e-11);
    }
}

#[test]
fn what_is_wrong_with_a_table_of_the_azimuth_is_said_in_one_sentence() {
    let head = "time.values = [0]\nrotor.azimuth_table = \"a.csv\"";
    let body = "rigid.translate = [0, 0, 1]";
    assert_eq!(
        told_at(false, head, body, ("a.csv", "time_s,psi\n0,0\n1,30\n")),
        "a.csv:1: the table has no column `azimuth_deg` or `azimuth_rad`"
    );
    let missing = resolve(
        false,
        "time.values = [0]\nrotor.azimuth_table = \"b.csv\"",
        "rigid.translate = [0, 0, 1]",
        &[],
    );
    let missing = missing.expect_err("there is none").to_string();
    assert!(
        missing.contains("hover.toml:3: there is no file") && missing.ends_with("b.csv"),
        "{missing}"
    );
}

#[test]
fn the_table_of_the_azimuth_is_a_file_of_the_schedule() {
    let text = "time.values = [0]\nrotor.azimuth_table = \"a.csv\"\n[[body]]\nname = \"a\"\ntags = [\"a\"]\ntable.file = \"m.csv\"\n";
    let schedule = super::parse(text).expect("it is good");
    let files: Vec<_> = schedule.files();
    assert_eq!(files, ["a.csv", "m.csv"].map(std::path::PathBuf::from));
}

#[test]
fn a_table_of_the_azimuth_in_memory_is_that_of_a_file() {
    let table = Table::from_rows(["time_s", "azimuth_rad"], [[0.0, 0.0], [1.0, 3.0]]);
    let schedule = Schedule::new(Steps::times_s([0.0, 0.5]))
        .rotor(Rotor::new().azimuth_table(table))
        .body(Body::new("blade", ["blade_1"]).translate(Translation::new([0.0, 0.0, 1.0])))
        .others(Others::Fixed);
    let steps = schedule.steps().expect("it is good");
    assert_eq!(
        (steps[1].azimuth, steps[1].azimuth_deg()),
        (1.5, Some(1.5f64.to_degrees()))
    );
}

#[test]
fn a_plane_mesh_turns_about_a_shaft_along_z() {
    let head = |rotor: &str| {
        format!("azimuth.values = [0, 90]\nrotor = {{ frame = \"inertial\", {rotor} }}")
    };
    let swing = "rigid.rotate = { axis = [0, 0, 1], harmonics = [ { sin = 90 } ] }";
    for (rotor, sign) in [
        ("hub = [1, 0, 0]", 1.0),
        ("hub = [1, 0, 0], shaft_axis = [0, 0, -2]", -1.0),
    ] {
        let motion = resolve(true, &head(rotor), swing, &[]).expect("it is good");
        let turn = motion
            .to_inertial(&motion.steps[1])
            .expect("it is inertial");
        assert_near(
            turn.of_body(0).expect("it turns").apply([2.0, 0.0, 0.0]),
            [1.0, sign, 0.0],
        );
        assert_near(place(&motion, 1, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    }
    // The second blade is a quarter of a turn ahead; it lags about its hinge.
    let lag = "azimuth_offset = 90\ncyclic = { flap_hinge = 1, lag = [ { cos = 90 } ] }";
    let motion = resolve(
        true,
        "azimuth.values = [270]\nrotor.shaft_axis = [0, 0, 1]",
        lag,
        &[],
    );
    assert_near(
        place(&motion.expect("it is good"), 0, [0.0, 2.0, 0.0]),
        [-1.0, 1.0, 0.0],
    );
}

#[test]
fn free_tags_are_named() {
    let text = |free: &str| {
        format!(
            "azimuth.values = [0]\n[[body]]\nname = \"a\"\ntags = [\"blade_1\"]\nrigid.translate = [0, 0, 1]\n[boundaries]\nfixed = [\"farfield\"]\nfree = {free}\n"
        )
    };
    let mesh = super::two_cubes();
    let resolve = |free: &str| super::parse(&text(free))?.resolve_on(&mesh);
    let motion = resolve("[\"hub\", \"si*\"]").expect("it is good");
    let free = motion.surface.tags.iter().filter(|tag| tag.role.is_none());
    assert_eq!(
        free.map(|tag| tag.tag.as_str()).collect::<Vec<_>>(),
        ["hub", "side"]
    );
    let two = resolve("[\"hub\", \"side\", \"farfield\"]")
        .expect_err("two roles")
        .to_string();
    assert_eq!(
        two,
        "hover.toml:8: tag \"farfield\" has two roles, fixed and free; give it one"
    );
    let mut bound = mesh.clone();
    bound.groups[4].condition = Some("symmetry".to_owned());
    let error =
        super::parse(&text("[\"hub\", \"side\"]")).and_then(|schedule| schedule.resolve_on(&bound));
    let error = error.expect_err("it would not be a plane").to_string();
    assert!(error.starts_with("hover.toml:8: tag \"side\" is of type symmetry, which it would not be any more with free nodes"), "{error}");
}
