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

/// `SciPy 1.17.1: Rotation.from_euler("ZXZ", [20, -35, 50], degrees=True).apply([0.3, -0.7, 1.1])`, and so on.
const SCIPY: [(&str, Vector); 6] = [
    (
        "euler_xyx",
        [
            0.14775853338211742,
            -1.3213616083450037,
            -0.14889901210105602,
        ],
    ),
    (
        "euler_xzx",
        [
            -0.4956594112073066,
            -1.2151052409142216,
            -0.26046305224430116,
        ],
    ),
    (
        "euler_yxy",
        [1.244070372975184, -0.2996653343894321, 0.3904991606273387],
    ),
    (
        "euler_yzy",
        [0.5830061524083276, -1.1673363248984534, 0.29568518871700367],
    ),
    (
        "euler_zxz",
        [0.5309823760386702, 0.6727883636351601, 1.027333214732908],
    ),
    (
        "euler_zyz",
        [0.04360797967993271, -0.2183939533471839, 1.3192431259057682],
    ),
];

#[test]
fn angles_about_two_axes_turn_as_scipy_does() {
    let head = "azimuth.values = [0]";
    let rows = "step,rot_1_deg,rot_2_rad,rot_3_deg\n0,20,-0.6108652381980153,50\n";
    let x = [0.3, -0.7, 1.1];
    for (order, expected) in SCIPY {
        assert_near(place(&table(order, head, rows), 0, x), expected);
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
