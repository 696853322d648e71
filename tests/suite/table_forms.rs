//! One motion in the forms that programs write: angles in three orders, rotation vectors, quaternions, Wiener-Milenkovic
//! parameters, the table of OpenFOAM and a file of OpenFAST put every node where the closed form has it.

use azimesh::{Deformation, Mesh, Schedule};
use std::fmt::Write as _;
use std::path::Path;

const ORIGIN: [f64; 3] = [0.1, -0.2, 0.05];
/// Axis (of any length), angle and translation at 0, 1, 2, 3 s; the angle goes past half a turn.
const MOTION: [([f64; 3], f64, [f64; 3]); 4] = [
    ([0.0, 0.0, 1.0], 0.0, [0.0, 0.0, 0.0]),
    ([1.0, -2.0, 0.5], 0.4, [0.02, 0.0, -0.01]),
    ([1.0, -2.0, 0.6], 2.0, [0.0, 0.03, 0.01]),
    ([1.1, -2.0, 0.6], 3.5, [-0.01, 0.0, 0.02]),
];
const LENGTHS: [&str; 4] = ["time_s", "dx", "dy", "dz"];

fn axis(row: usize) -> [f64; 3] {
    let [x, y, z] = MOTION[row].0;
    [x, y, z].map(|c| c / (x * x + y * y + z * z).sqrt())
}

/// Rodrigues' matrix.
fn matrix(row: usize) -> [[f64; 3]; 3] {
    let (u, (sin, cos)) = (axis(row), MOTION[row].1.sin_cos());
    let cross = [[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]];
    let part = |i: usize, j: usize| u[i] * u[j] * (1.0 - cos) + sin * cross[i][j];
    std::array::from_fn(|i| std::array::from_fn(|j| part(i, j) + if i == j { cos } else { 0.0 }))
}

/// The place of a node at a row.
fn place(row: usize, x: [f64; 3]) -> [f64; 3] {
    let (m, arm) = (matrix(row), [0, 1, 2].map(|i| x[i] - ORIGIN[i]));
    std::array::from_fn(|i| {
        let turned: f64 = (0..3).map(|j| m[i][j] * arm[j]).sum();
        ORIGIN[i] + turned + MOTION[row].2[i]
    })
}

/// Angles about x, y and z in degrees: `Rz Ry Rx`.
fn zyx(row: usize) -> Vec<f64> {
    let m = matrix(row);
    degrees([
        m[2][1].atan2(m[2][2]),
        -m[2][0].asin(),
        m[1][0].atan2(m[0][0]),
    ])
}

/// `Rx Ry Rz`.
fn xyz(row: usize) -> Vec<f64> {
    let m = matrix(row);
    degrees([
        (-m[1][2]).atan2(m[2][2]),
        m[0][2].asin(),
        (-m[0][1]).atan2(m[0][0]),
    ])
}

/// `Rz Rx Ry`.
fn zxy(row: usize) -> Vec<f64> {
    let m = matrix(row);
    degrees([
        m[2][1].asin(),
        (-m[2][0]).atan2(m[2][2]),
        (-m[0][1]).atan2(m[1][1]),
    ])
}

fn degrees(angles: [f64; 3]) -> Vec<f64> {
    angles.map(f64::to_degrees).to_vec()
}

/// The row of a table: time, translation, rotation.
fn row(row: usize, rotation: &[f64], between: &str) -> String {
    let lengths = [row as f64].into_iter().chain(MOTION[row].2);
    let numbers = lengths.chain(rotation.iter().copied());
    numbers
        .map(|x| format!("{x:?}"))
        .collect::<Vec<_>>()
        .join(between)
}

fn table(names: [&str; 4], more: &[&str], between: &str, of: impl Fn(usize) -> Vec<f64>) -> String {
    let mut text = [&names[..], more].concat().join(between) + "\n";
    for at in 0..MOTION.len() {
        writeln!(text, "{}", row(at, &of(at), between)).unwrap();
    }
    text
}

/// The largest distance of a node of the sphere from its place at any row.
fn error(folder: &Path, name: &str, text: &str, keys: &str) -> f64 {
    std::fs::write(folder.join(name), text).unwrap();
    let schedule = format!(
        "time = {{ stop = 3, step = 1 }}\nboundaries.others = \"fixed\"\nselection.tolerance = 0.05\n\
         output.on_inverted = \"warn\"\n[[body]]\nname = \"ball\"\ntags = [\"sphere\"]\n\
         table = {{ file = \"{name}\", origin = {ORIGIN:?}{keys} }}\n"
    );
    std::fs::write(folder.join("s.toml"), schedule).unwrap();
    let mesh = Mesh::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/testdata/sphere_in_box_raw_zlib.vtu"
    ));
    let deformation = Deformation::new(
        mesh.unwrap(),
        Schedule::read(folder.join("s.toml")).unwrap(),
    );
    let deformation = deformation.unwrap();
    let nodes = deformation.mesh().tag_nodes("sphere").unwrap();
    let mut largest = 0.0f64;
    for step in deformation.steps() {
        let points = deformation.points_at(step).unwrap();
        for &node in &nodes {
            let expected = place(step.index(), deformation.mesh().points()[node as usize]);
            let off = (0..3).map(|i| (points[node as usize][i] - expected[i]).abs());
            largest = off.fold(largest, f64::max);
        }
    }
    largest
}

#[test]
fn one_motion_is_the_same_in_every_form_of_its_rotations() {
    let folder = tempfile::tempdir().unwrap();
    let angles = ["rot_x_deg", "rot_y_deg", "rot_z_deg"];
    let wm = |row: usize| {
        axis(row)
            .map(|c| 4.0 * (MOTION[row].1 / 4.0).tan() * c)
            .to_vec()
    };
    let vector = |row: usize| axis(row).map(|c| MOTION[row].1 * c).to_vec();
    // Row 2 has the negative, and row 3 is a thousandth too long at most.
    let quaternion = |row: usize| {
        let (sin, cos) = (MOTION[row].1 / 2.0).sin_cos();
        let scale = [1.0, 1.0, -1.0, 1.0009][row];
        let [x, y, z] = axis(row).map(|c| scale * sin * c);
        vec![scale * cos, x, y, z]
    };
    let foam = (0..4).map(|at| {
        let words = |numbers: &[f64]| {
            numbers
                .iter()
                .map(|x| format!("{x:?} "))
                .collect::<String>()
        };
        format!(
            "({at} (({}) ({})))\n",
            words(&MOTION[at].2),
            words(&xyz(at))
        )
    });
    let foam = format!("4\n(\n{})\n", foam.collect::<String>());
    let names = ["Time", "PtfmSurge", "PtfmSway", "PtfmHeave"];
    let fast = table(names, &["PtfmRoll", "PtfmPitch", "PtfmYaw"], " \t", zyx);
    let (first, rows) = fast.split_once('\n').unwrap();
    let fast = format!(
        "\nPredictions were generated on 28-Nov-2026 at 10:00:00 using OpenFAST, compiled as a 64-bit application\n\
         linked with NWTC Subroutine Library; ElastoDyn\n\nDescription from the FAST input file: 3 rows, no wind\n\n\n\n\
         {first}\n(s)  \t(m)  \t(m)  \t(m)  \t(deg)  \t(deg)  \t(deg)\n{rows}"
    );
    let fast_keys = ", columns = { time_s = \"Time\", dx = \"PtfmSurge\", dy = \"PtfmSway\", dz = \"PtfmHeave\", \
                     rot_x_deg = \"PtfmRoll\", rot_y_deg = \"PtfmPitch\", rot_z_deg = \"PtfmYaw\" }";
    let forms = [
        ("zyx.csv", table(LENGTHS, &angles, ",", zyx), ""),
        (
            "xyz.csv",
            table(LENGTHS, &angles, ";", xyz),
            ", rotation = \"euler_xyz\"",
        ),
        (
            "zxy.csv",
            table(LENGTHS, &angles, " ", zxy),
            ", rotation = \"euler_zxy\"",
        ),
        (
            "vector.csv",
            table(
                LENGTHS,
                &["rot_x_rad", "rot_y_rad", "rot_z_rad"],
                ",",
                vector,
            ),
            ", rotation = \"vector\"",
        ),
        (
            "quaternion.csv",
            table(
                LENGTHS,
                &["quat_w", "quat_x", "quat_y", "quat_z"],
                ",",
                quaternion,
            ),
            ", rotation = \"quaternion\"",
        ),
        (
            "wm.csv",
            table(LENGTHS, &["wm_x", "wm_y", "wm_z"], "\t", wm),
            ", rotation = \"wiener_milenkovic\"",
        ),
        ("tab6.dat", foam, ""),
        ("fast.out", fast, fast_keys),
    ];
    for (name, text, keys) in forms {
        let off = error(folder.path(), name, &text, keys);
        assert!(off < 1e-14, "{name}: {off:e}");
    }
}
