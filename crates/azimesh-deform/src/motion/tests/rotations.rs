//! The forms of rotations in tables: angles in an order, rotation vectors, quaternions, Wiener-Milenkovic parameters.

use super::tables::*;
use crate::motion::Motion;
use azimesh_core::geometry::transform::Matrix;
use azimesh_core::geometry::vector::{Vector, distance, scale, unit};

const X: Vector = [0.3, 0.4, -0.2];
const AXIS: Vector = [1.0, -2.0, 0.5];

fn table(form: &str, head: &str, table: &str) -> Motion {
    let body = format!("table = {{ file = \"m.csv\", rotation = \"{form}\" }}");
    resolve(false, head, &body, &[("m.csv", table)]).expect("it is good")
}

/// `exp(angle axis) x` by the cosine and sine of the angle.
fn turned(angle: f64, x: Vector) -> Vector {
    let [a, b, c] = unit(AXIS).expect("a direction");
    let (sin, cos) = angle.sin_cos();
    let m: Matrix = [
        [
            cos + a * a * (1.0 - cos),
            a * b * (1.0 - cos) - c * sin,
            a * c * (1.0 - cos) + b * sin,
        ],
        [
            a * b * (1.0 - cos) + c * sin,
            cos + b * b * (1.0 - cos),
            b * c * (1.0 - cos) - a * sin,
        ],
        [
            a * c * (1.0 - cos) - b * sin,
            b * c * (1.0 - cos) + a * sin,
            cos + c * c * (1.0 - cos),
        ],
    ];
    times(m, x)
}

fn row(numbers: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = numbers.into_iter().map(|x| format!("{x:?}")).collect();
    words.join(",") + "\n"
}

/// The numbers of a turn about `AXIS` in a form, with the names of their columns.
fn form(name: &str, angle: f64) -> (&'static str, Vec<f64>) {
    let axis = unit(AXIS).expect("a direction");
    let (sin, cos) = (0.5 * angle).sin_cos();
    match name {
        "vector" => ("rot_x_rad,rot_y_rad,rot_z_rad", scale(axis, angle).to_vec()),
        "quaternion" => (
            "quat_w,quat_x,quat_y,quat_z",
            [&[cos][..], &scale(axis, sin)].concat(),
        ),
        _ => (
            "wm_x,wm_y,wm_z",
            scale(axis, 4.0 * (0.25 * angle).tan()).to_vec(),
        ),
    }
}

#[test]
fn three_angles_turn_in_the_order_of_their_name() {
    let head = "azimuth.values = [0]";
    let rows = "step,rot_x_deg,rot_y_deg,rot_z_deg\n0,20,-35,50\n";
    let [x, y, z] = [
        rx(20f64.to_radians()),
        ry(-35f64.to_radians()),
        rz(50f64.to_radians()),
    ];
    for (order, [a, b, c]) in [
        ("euler_xyz", [x, y, z]),
        ("euler_xzy", [x, z, y]),
        ("euler_yxz", [y, x, z]),
        ("euler_yzx", [y, z, x]),
        ("euler_zxy", [z, x, y]),
        ("euler_zyx", [z, y, x]),
    ] {
        let expected = times(a, times(b, times(c, X)));
        assert_near(place(&table(order, head, rows), 0, X), expected);
    }
}

#[test]
fn vectors_quaternions_and_parameters_turn_any_number_of_times_and_are_interpolated_as_vectors() {
    let head = "time.values = [0, 0.25, 0.5, 1, 2.75, 3]";
    let angles = [0.1, 2.5, 4.5, 7.0];
    for name in ["vector", "quaternion", "wiener_milenkovic"] {
        let (columns, _) = form(name, 0.0);
        let rows = (0..4).map(|at| {
            // The parameters of more than half a turn are those of the rest of the turn the other way.
            let angle = match (name, angles[at]) {
                ("wiener_milenkovic", angle) if angle > 3.0 => angle - std::f64::consts::TAU,
                (_, angle) => angle,
            };
            let sign = if name == "quaternion" && at == 1 {
                -1.0
            } else {
                1.0
            };
            let numbers = form(name, angle).1.into_iter().map(|x| sign * x);
            row([at as f64].into_iter().chain(numbers))
        });
        let text = format!("time_s,{columns}\n{}", rows.collect::<String>());
        let motion = table(name, head, &text);
        for (step, angle) in [0.1, 0.7, 1.3, 2.5, 6.375, 7.0].into_iter().enumerate() {
            let off = distance(place(&motion, step, X), turned(angle, X));
            assert!(off < 3e-15, "{name} {step}: {off:e}");
        }
        let half = motion.pose_part(0, &motion.steps[3], 0.5).apply(X);
        assert!(distance(half, turned(1.25, X)) < 1e-15, "{name}");
    }
}

#[test]
fn sections_of_a_beam_turn_in_every_form_after_their_pitch() {
    let head = "azimuth.values = [0]\nrotor = { span_axis = [0, 1, 0], shaft_axis = [1, 0, 0] }";
    // The span is y, e_y is z, e_z is x.
    let in_blade = |[x, y, z]: Vector| [y, z, x];
    let in_mesh = |[x, y, z]: Vector| [z, x, y];
    for name in ["vector", "quaternion", "wiener_milenkovic"] {
        let (columns, numbers) = form(name, 0.8);
        let still = form(name, 0.0).1;
        let rows: String = [(0.0, &numbers), (1.0, &numbers)]
            .map(|(station, numbers)| row([station].into_iter().chain(numbers.iter().copied())))
            .concat();
        let body = format!(
            "cyclic.collective = 10\nbeam = {{ table = \"m.csv\", lifting_line = \"l.csv\", rotation = \"{name}\" }}"
        );
        let files = [
            ("m.csv", format!("station,{columns}\n{rows}")),
            ("l.csv", "station,x,y,z\n0,0,0,0\n1,1,0,0\n".to_owned()),
        ];
        let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
        let motion = resolve(false, head, &body, &files).expect("it is good");
        let arm = in_blade([X[0], 0.0, X[2]]);
        let moved = turned(0.8, times(rx(10f64.to_radians()), arm));
        let expected = in_mesh(std::array::from_fn(|i| {
            moved[i] + in_blade([0.0, X[1], 0.0])[i]
        }));
        let found = place(&motion, 0, X);
        assert!(
            distance(found, expected) < 2e-15,
            "{name}: {found:?} {expected:?}"
        );
        let map = motion.pose(0, &motion.steps[0]).map(X).apply(X);
        assert!(distance(map, expected) < 2e-15, "{name}: {map:?}");
        assert_eq!(still.len(), numbers.len());
    }
}

#[test]
fn wrong_rotations_are_told_what_would_be_right() {
    let of = |keys: &str| format!("table = {{ file = \"m.csv\"{keys} }}");
    let quaternions = of(", rotation = \"quaternion\"");
    let head = "azimuth_deg,quat_w,quat_x,quat_y,quat_z\n";
    for (body, table, expected) in [
        (
            &quaternions,
            format!("{head}0,1,0,0,0\n90,0,0,0,0\n"),
            "m.csv:3: the quaternion has the length 0; it must be 1, to 0.001: no rotation is 1, 0, 0, 0",
        ),
        (
            &quaternions,
            format!("{head}0,1,0.1,0,0\n90,1,0,0,0\n"),
            "m.csv:2: the quaternion has the length 1.00499; it must be 1, to 0.001: divide its components by their length",
        ),
        (
            &quaternions,
            "azimuth_deg,quat_w,quat_x,quat_y\n0,1,0,0\n".to_owned(),
            "m.csv:1: the table has no column `quat_z`; found: azimuth_deg, quat_w, quat_x, quat_y",
        ),
        (
            &of(""),
            format!("{head}0,1,0,0,0\n"),
            "m.csv:1: unknown column `quat_w`; it needs rotation = \"quaternion\"; known columns: azimuth_deg, azimuth_rad, time_s, step, dx, dy, dz, rot_x_deg, rot_x_rad, rot_y_deg, rot_y_rad, rot_z_deg, rot_z_rad",
        ),
        (
            &of(", columns = { wm_x = \"RDxr\" }"),
            "azimuth_deg,RDxr\n0,0\n".to_owned(),
            "hover.toml:6: `wm_x` needs rotation = \"wiener_milenkovic\"",
        ),
        (
            &of(", rotation = \"quaternion\", units = { rot_x_deg = \"rad\" }"),
            format!("{head}0,1,0,0,0\n"),
            "hover.toml:6: `rot_x_deg` needs rotation = \"vector\", or an order of angles such as \"euler_zyx\"",
        ),
        (
            &of(", rotation = \"euler_zxz\""),
            "azimuth_deg,dx\n0,0\n".to_owned(),
            "hover.toml:6: unknown rotation \"euler_zxz\"; did you mean `euler_zyx`? known: euler_xyz, euler_xzy, euler_yxz, euler_yzx, euler_zxy, euler_zyx, vector, quaternion, wiener_milenkovic",
        ),
        (
            &of(", rotation = \"vector\""),
            "((0 ((0 0 0) (0 0 0))))".to_owned(),
            "hover.toml:6: the angles of OpenFOAM's table are \"euler_xyz\"; leave `rotation` out",
        ),
        (
            &of(", rotation = \"wiener_milenkovic\""),
            "azimuth_deg\n0\n".to_owned(),
            "m.csv:1: the table has none of the columns dx, dy, dz, wm_x, wm_y, wm_z",
        ),
    ] {
        assert_eq!(told(false, body, &table), expected);
    }
    let leaving = told(
        true,
        &quaternions,
        &format!("{head}0,1,0,0,0\n30,0.6,0.8,0,0\n"),
    );
    assert_eq!(
        leaving,
        "m.csv:3: `quat_x` is not 0, so body \"blade\" would leave the plane of the 2D mesh; use only dx, dy and rotations about z"
    );
}
