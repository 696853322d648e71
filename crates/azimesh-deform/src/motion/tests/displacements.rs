//! Displacements of nodes from other programs: surface files and mode shapes.

use super::tables::resolve;
use super::{two_cubes, two_squares};
use crate::motion::Motion;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, add, distance, scale};
use azimesh_io::formats::{WriteOptions, by_name};
use azimesh_io::mesh::{CellKind, DataArray, Mesh, Values};

pub(super) const SURFACE: &str = "surface = { file = \"s.csv\" }";

fn surface(plane: bool, head: &str, body: &str, file: &str) -> Result<Motion> {
    resolve(plane, head, body, &[("s.csv", file), ("s.dat", file)])
}

fn place(motion: &Motion, step: usize, node: u32) -> Vector {
    let x = if motion.rotors[0].axes.e_x[0] == 0.0 {
        two_squares().points[node as usize]
    } else {
        two_cubes().points[node as usize]
    };
    motion.pose(0, &motion.steps[step]).place(node, x)
}

#[track_caller]
fn assert_near(found: Vector, expected: Vector) {
    assert!(distance(found, expected) < 1e-15, "{found:?} {expected:?}");
}

pub(super) fn told(plane: bool, body: &str, file: &str) -> String {
    let found = surface(plane, "azimuth.values = [0, 30]", body, file);
    let error = found.expect_err("it is wrong").to_string();
    let at = ["s.csv", "s.dat", "hover.toml"]
        .iter()
        .find_map(|name| error.rfind(name));
    error[at.unwrap_or(0)..].to_owned()
}

/// Displacements of nodes 0 to 3, the face blade_1 of the cubes.
const BY_NODE: &str = "node,dx,dy,dz\n0,0,0,0\n1,0.1,0,0\n2,0,0.2,0\n3,0,0,0.3\n";
const MOVED: [Vector; 4] = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]];

#[test]
fn displacements_are_given_by_node_by_place_or_as_new_places() {
    let by_place = "x,y,z,dx,dy,dz\n0,1,0,0,0,0.3\n0,0,0,0,0,0\n1,0,1e-10,0.1,0,0\n1,1,0,0,0.2,0\n";
    let new = "node,x_new,y_new,z_new\n0,0,0,0\n1,1.1,0,0\n2,1,1.2,0\n3,0,1,0.3\n";
    for file in [BY_NODE, by_place, new] {
        let motion = surface(false, "azimuth.values = [0, 30]", SURFACE, file).expect("it is good");
        assert!(!motion.is_rigid(0));
        for step in 0..2 {
            for (node, moved) in (0..).zip(MOVED) {
                let x = two_cubes().points[node as usize];
                assert_near(place(&motion, step, node), add(x, moved));
            }
        }
        let half = motion.pose_part(0, &motion.steps[0], 0.5);
        assert_near(half.place(3, [0.0, 1.0, 0.0]), [0.0, 1.0, 0.15]);
    }
}

#[test]
fn surface_positions_of_su2_are_read() {
    let file = "% node x y z\n0 0 0 0\n1\t1.1e0 0 0\n\n2 1 1.2 0\n3 0 1 0.3\n";
    let body = "surface = { file = \"s.dat\" }";
    let motion = surface(false, "azimuth.values = [0]", body, file).expect("it is good");
    assert_near(place(&motion, 0, 1), [1.1, 0.0, 0.0]);
    assert_eq!(
        told(false, body, "0 0 0\n"),
        "s.dat:1: found \"0 0 0\"; a line of surface positions is a node and its new place: node x y z"
    );
    let plane =
        surface(true, "azimuth.values = [0]", body, "0 0.5 0\n1 1 0.5\n").expect("it is good");
    assert_near(place(&plane, 0, 0), [0.5, 0.0, 0.0]);
}

#[test]
fn every_step_has_a_set_of_its_own() {
    let file = "azimuth_deg,node,dx,dy\n0,0,0,0\n0,1,0,0\n30,1,0,0.5\n30,0,0.25,0\n";
    let head = "azimuth.values = [30, 0]";
    let motion = surface(true, head, SURFACE, file).expect("it is good");
    for (step, x) in [(0, [0.25, 0.0, 0.0]), (1, [0.0; 3])] {
        assert_near(place(&motion, step, 0), x);
    }
    let none = surface(true, "azimuth.values = [0, 15]", SURFACE, file).expect_err("15 is missing");
    assert!(none.to_string().ends_with("s.csv:3: there are no rows for azimuth 15 deg (step 1); every step needs rows of its own, and the file has them from azimuth 0 deg to azimuth 30 deg"), "{none}");
}

#[test]
fn sets_over_azimuth_repeat_themselves_and_are_shifted_as_tables_are() {
    let rows = |azimuths: &[f64]| {
        let rows = azimuths.iter().flat_map(|at| [0, 1].map(|node| (at, node)));
        let rows = rows.map(|(at, node)| format!("{at},{node},{},0\n", at.rem_euclid(360.0)));
        format!("azimuth_deg,node,dx,dy\n{}", rows.collect::<String>())
    };
    let ahead = format!("azimuth_offset = 90\n{SURFACE}");
    for round in [
        &[0.0, 90.0, 180.0, 270.0][..],
        &[0.0, 90.0, 180.0, 270.0, 360.0],
    ] {
        let head = "azimuth.values = [0, 270, 540]";
        let motion = surface(true, head, &ahead, &rows(round)).expect("it is good");
        for (step, x) in [(0, 90.0), (1, 0.0), (2, 270.0)] {
            assert_near(place(&motion, step, 0), [x, 0.0, 0.0]);
        }
        assert!(motion.notes().is_empty());
    }
    // A part of a revolution is of events, as a table of them is.
    let part = rows(&[0.0, 90.0, 180.0]);
    let motion = surface(true, "azimuth.values = [0, 90]", &ahead, &part).expect("it is good");
    assert_near(place(&motion, 1, 0), [90.0, 0.0, 0.0]);
    let note = motion.notes()[0].text.clone();
    assert!(note.starts_with("body \"blade\": the table does not repeat itself (its last row is neither at azimuth 360 deg nor one step before it), so it is taken at the azimuth of the rotor"), "{note}");
    let later = surface(true, "azimuth.values = [0, 450]", SURFACE, &part);
    let later = later.expect_err("nothing repeats").to_string();
    assert!(
        later.contains("there are no rows for azimuth 450 deg (step 1)"),
        "{later}"
    );
}

/// A plate below the face blade_1 of the cubes: places that are no nodes.
const PLATE: [[f64; 2]; 5] = [
    [-0.15, -0.2],
    [1.3, 0.0],
    [0.0, 1.1],
    [1.2, 1.4],
    [0.5, 0.4],
];

/// A table of the plate turned about z by each of some angles.
fn turned_plate(angles: &[f64]) -> String {
    let rows = angles.iter().enumerate().flat_map(|(second, angle)| {
        PLATE.map(|[x, y]| {
            let (sin, cos) = angle.sin_cos();
            let (new_x, new_y) = (cos * x - sin * y, sin * x + cos * y);
            format!("{second},{x},{y},-0.1,{new_x},{new_y},-0.1\n")
        })
    });
    "time_s,x,y,z,x_new,y_new,z_new\n".to_owned() + &rows.collect::<String>()
}

#[test]
fn displacements_of_other_points_are_carried_to_the_nodes() {
    let head = "time.values = [0, 1]";
    for method in ["rbf", "nearest"] {
        let body = format!("surface = {{ file = \"s.csv\", map = \"{method}\" }}");
        let motion = surface(false, head, &body, &turned_plate(&[0.0, 1.0])).expect("it is good");
        let (sin, cos) = 1.0f64.sin_cos();
        for (node, x) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            let expected = match method {
                "rbf" => [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], 0.0],
                _ => {
                    let [x_given, y_given] = PLATE[[0, 1, 3, 2][node]];
                    let moved = [
                        cos * x_given - sin * y_given - x_given,
                        sin * x_given + cos * y_given - y_given,
                    ];
                    [x[0] + moved[0], x[1] + moved[1], 0.0]
                }
            };
            let found = place(&motion, 1, node as u32);
            assert!(
                distance(found, expected) < 1e-14,
                "{method}: {found:?} {expected:?}"
            );
        }
        let note = &motion.notes()[0];
        assert_eq!(note.code, "surface_map");
        assert!(note.text.starts_with("body \"blade\": the displacements of 5 points are carried to 4 nodes, which are up to 0."), "{}", note.text);
    }
}

/// Places the nodes of a body by a mesh in place of a table, with the array `d = (0, 0, x)`.
fn by_mesh(method: &str, mesh: &Mesh) -> Result<Motion> {
    let mut mesh = mesh.clone();
    let values = mesh.points.iter().flat_map(|x| [0.0, 0.0, x[0]]);
    let values = Values::F64(values.collect());
    mesh.point_arrays
        .push(DataArray::tuples("Displacement", 3, values));
    let mut bytes = Vec::new();
    let format = by_name("vtu").expect("it is known");
    let written = format.write_file(&mesh.view(), &mut bytes, &WriteOptions::default());
    written.expect("it can be written");
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "boundaries.others = \"fixed\"\nazimuth.values = [0]\n[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\n\
         surface = {{ file = \"m.vtu\", map = \"{method}\" }}\n"
    );
    std::fs::write(folder.path().join("s.toml"), text).expect("it can be written");
    std::fs::write(folder.path().join("m.vtu"), bytes).expect("it can be written");
    crate::motion::Schedule::read(folder.path().join("s.toml"))?.resolve_on(&two_cubes())
}

/// A box from -0.5 to 1.5 as eight hexahedra, or the sheet z = 0 of it.
fn structure(solid: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |i: usize| [-0.5, 0.45, 1.5][i];
    let heights = if solid { 3 } else { 1 };
    for k in 0..heights {
        let z = if solid { at(k) } else { 0.0 };
        mesh.points
            .extend((0..9).map(|n| [at(n % 3), at(n / 3), z]));
    }
    let square = |n: u32| [n, n + 1, n + 4, n + 3];
    for first in [0, 1, 3, 4] {
        for k in 0..heights as u32 - u32::from(solid) {
            let low = square(first + 9 * k);
            match solid {
                true => mesh
                    .cells
                    .push(CellKind::Hexahedron, &[low, low.map(|n| n + 9)].concat()),
                false => mesh.cells.push(CellKind::Quadrilateral, &low),
            }
        }
    }
    mesh
}

#[test]
fn points_of_a_structure_count_whatever_its_tags() {
    for solid in [true, false] {
        let bare = structure(solid);
        let mut tagged = bare.clone();
        // The root of the structure, or its outline there: one side of the box.
        let first = tagged.cells.len();
        match solid {
            true => tagged.cells.push(CellKind::Quadrilateral, &[0, 3, 12, 9]),
            false => tagged.cells.push(CellKind::Line, &[0, 3]),
        }
        tagged
            .add_tag("root", first..first + 1)
            .expect("it has a face");
        for method in ["rbf", "nearest", "plane"] {
            let moved = |mesh: &Mesh| {
                let motion = by_mesh(method, mesh).expect("it maps");
                (0..4)
                    .map(|node| place(&motion, 0, node)[2])
                    .collect::<Vec<_>>()
            };
            let found = moved(&tagged);
            assert_eq!(found, moved(&bare), "{method}");
            let xs = [0.0, 1.0, 1.0, 0.0];
            if method == "rbf" {
                let off = found.iter().zip(xs).map(|(z, x)| (z - x).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?}");
            }
            assert!(found[1] > found[0] + 0.3, "{method}: {found:?}");
        }
    }
}

#[test]
fn points_in_another_unit_are_refused_with_both_extents() {
    let text = |factor: f64, shift: f64| {
        let rows =
            PLATE.map(|[x, y]| format!("0,{},{},0,0,0,0.1\n", factor * x + shift, factor * y));
        "time_s,x,y,z,dx,dy,dz\n".to_owned() + &rows.concat()
    };
    let body = "surface = { file = \"s.csv\", map = \"nearest\" }";
    let found = |factor, shift| surface(false, "time.values = [0]", body, &text(factor, shift));
    found(1.0, 0.0).expect("they match");
    for (factor, shift, expected) in [
        (1000.0, 0.0, "the points may be in mm and the mesh in m"),
        (1000.0, 500.0, "the points may be in mm and the mesh in m"),
        (0.001, 0.0, "the points may be in m and the mesh in mm"),
        (16.6, 30.0, "the points may be in mm and the mesh in in"),
        (
            5.0,
            20.0,
            "check the unit of their coordinates and their origin",
        ),
    ] {
        let error = found(factor, shift)
            .expect_err("they do not match")
            .to_string();
        assert!(error.contains(expected), "{factor} {shift}: {error}");
        assert!(
            error.contains("which extend over ") && error.contains(", the nodes over "),
            "{error}"
        );
    }
}

#[test]
fn maps_that_cannot_be_are_refused() {
    let told = |body: &str, file: &str| {
        let body = format!("surface = {{ file = \"s.csv\", {body} }}");
        let found = surface(false, "time.values = [0, 1]", &body, file);
        let error = found.expect_err("it is wrong").to_string();
        error[error
            .rfind("s.csv")
            .or(error.rfind("hover.toml"))
            .unwrap_or(0)..]
            .to_owned()
    };
    let rbf = "map = \"rbf\"";
    let twice = turned_plate(&[0.0, 1.0]) + "1,0.5,0.4,-0.1,9,9,9\n";
    let mut less = turned_plate(&[0.0, 1.0]);
    less.truncate(less.trim_end().rfind('\n').expect("rows") + 1);
    let far = turned_plate(&[0.0, 1.0]).replace("-0.1,", "-100,");
    for (body, file, expected) in [
        (rbf, BY_NODE, "s.csv:1: a `map` needs the places x, y, z"),
        (
            rbf,
            &twice,
            "s.csv:12: the point of this row is given another displacement in line 11",
        ),
        (
            rbf,
            &less,
            "s.csv:6: the point (0.5, 0.4, -0.1) of this row has no row at time 1 s",
        ),
        (
            rbf,
            &far,
            "s.csv: nodes of body \"blade\" are 100 to 100.001 from the 5 points",
        ),
        (
            rbf,
            "x,y,z,dx,dy,dz\n0,0,0,0,0,0\n1,1,1,0,0,0\n",
            "s.csv: the given points are on a line",
        ),
        (
            "map = \"plane\"",
            &turned_plate(&[0.0]),
            "s.csv: there are no faces in the file",
        ),
        ("map = \"spline\"", BY_NODE, "hover.toml:6: "),
        ("interpolation = \"linear\"", BY_NODE, "hover.toml:6: "),
    ] {
        let found = told(body, file);
        assert!(found.starts_with(expected), "{found}");
    }
}

#[test]
fn sets_are_interpolated_between_their_times() {
    let file = "time_s,node,dx,dy\n0,0,0,0\n0,1,0,0\n2,0,4,0\n2,1,0,8\n4,0,16,0\n4,1,0,0\n6,0,36,0\n6,1,0,0\n";
    let head = "time.values = [0, 1, 2, 5]";
    for (interpolation, places) in [
        ("linear", [0.0, 2.0, 4.0, 26.0]),
        ("cubic", [0.0, 1.0, 4.0, 25.0]),
    ] {
        let body = format!("surface = {{ file = \"s.csv\", interpolation = \"{interpolation}\" }}");
        let motion = surface(true, head, &body, file).expect("it is good");
        for (step, x) in places.into_iter().enumerate() {
            let found = place(&motion, step, 0);
            assert!(
                distance(found, [x, 0.0, 0.0]) < 1e-13,
                "{interpolation}: {found:?}"
            );
        }
    }
    // Over azimuth they repeat themselves, with the first set again at the end or one step before it.
    let rows = |azimuths: &[u32]| {
        let rows = azimuths
            .iter()
            .map(|at| format!("{at},0,{0},0\n{at},1,{0},0\n", at % 360));
        "azimuth_deg,node,dx,dy\n".to_owned() + &rows.collect::<String>()
    };
    for round in [&[0, 90, 180, 270][..], &[0, 90, 180, 270, 360]] {
        let body = "surface = { file = \"s.csv\", interpolation = \"linear\" }";
        let motion = surface(true, "azimuth.values = [45, 315, 720]", body, &rows(round))
            .expect("it is good");
        for (step, x) in [(0, 45.0), (1, 135.0), (2, 0.0)] {
            assert_near(place(&motion, step, 0), [x, 0.0, 0.0]);
        }
    }
}

#[test]
fn nodes_that_are_missing_are_an_error_or_stay() {
    let one = "node,dx,dy,dz\n1,0.1,0,0\n";
    assert_eq!(
        told(false, SURFACE, one),
        "s.csv:2: 3 of the 4 nodes of body \"blade\" are missing: 0, 2, 3; add them, or set missing = \"fixed\""
    );
    let fixed = "surface = { file = \"s.csv\", missing = \"fixed\" }";
    let motion = surface(false, "azimuth.values = [0]", fixed, one).expect("it is good");
    assert_near(place(&motion, 0, 1), [1.1, 0.0, 0.0]);
    assert_near(place(&motion, 0, 2), [1.0, 1.0, 0.0]);
}

#[test]
fn rows_for_other_nodes_are_told_of() {
    let file = format!("{BY_NODE}7,1,1,1\n8,1,1,1\n");
    let motion = surface(false, "azimuth.values = [0]", SURFACE, &file).expect("it is good");
    let notes = motion.notes();
    let path = notes[0].path.as_ref();
    assert!(
        path.is_some_and(|path| path.ends_with("s.csv")),
        "{notes:?}"
    );
    assert_eq!(notes[0].code, "other_nodes");
    assert!(notes[0].text.starts_with("ignored 2 rows "), "{notes:?}");
}

/// The cubes with vectors at their nodes, as VTU.
fn vtu(arrays: &[(&str, f64)]) -> Vec<u8> {
    let mut mesh: Mesh = two_cubes();
    for (name, factor) in arrays {
        let vectors: Vec<Vector> = mesh.points.iter().map(|x| scale(*x, *factor)).collect();
        let values = Values::F64(vectors.into_flattened());
        mesh.point_arrays.push(DataArray::tuples(*name, 3, values));
    }
    let mut bytes = Vec::new();
    let format = by_name("vtu").expect("it is known");
    format
        .write_file(&mesh.view(), &mut bytes, &WriteOptions::default())
        .expect("it can be written");
    bytes
}

/// A schedule of one body with a mesh `m.vtu` that has arrays.
fn beside_mesh(body: &str, arrays: &[(&str, f64)], csv: &str) -> Result<Motion> {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "boundaries.others = \"fixed\"\ntime = {{ values = [0, 1, 2] }}\n[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\n{body}\n"
    );
    for (name, bytes) in [
        ("hover.toml", text.as_bytes()),
        ("m.vtu", &vtu(arrays)),
        ("q.csv", csv.as_bytes()),
    ] {
        std::fs::write(folder.path().join(name), bytes).expect("it can be written");
    }
    crate::motion::Schedule::read(folder.path().join("hover.toml"))?.resolve_on(&two_cubes())
}

#[test]
fn a_mesh_with_displacements_moves_its_nodes() {
    let body = "surface = { file = \"m.vtu\" }";
    // The array that moves node 2 to 1.1.
    let (normals, moves, other) = (("Normals", 7.0), 0.1, 3.0);
    for arrays in [
        vec![normals, ("Displacement", moves)],
        vec![("anything", moves)],
        vec![("mesh_displacement", other), ("DISPLACEMENT", moves)],
        vec![normals, ("mesh_displacement", moves)],
    ] {
        let motion = beside_mesh(body, &arrays, "").expect("it is clear");
        assert_near(place(&motion, 0, 2), [1.1, 1.1, 0.0]);
    }
    for names in [
        ["Normals", "Speed"],
        ["displacement_1", "displacement_0"],
        ["v", "u"],
        ["v", "disp"],
    ] {
        let error = beside_mesh(body, &names.map(|name| (name, 0.1)), "").expect_err("which one?");
        let told = format!(
            "m.vtu: several of its arrays could be the displacements: {}; name one of them `Displacement`",
            names.join(", ")
        );
        assert!(error.to_string().ends_with(&told), "{error}");
    }
    let none = beside_mesh(body, &[], "").expect_err("there is none");
    assert!(
        none.to_string()
            .ends_with("the mesh has no point array of 3 components with the displacements"),
        "{none}"
    );
}

#[test]
fn velocities_are_slopes_over_the_sets_of_the_file() {
    let rows = |key: &str, sets: &[(f64, f64)]| {
        let rows = sets
            .iter()
            .map(|(at, x)| format!("{at},0,{x},0\n{at},1,{x},0\n"));
        format!("{key},node,dx,dy\n{}", rows.collect::<String>())
    };
    // A triangle wave: 1 a second up to 0.2 s, then down.
    let wave = rows(
        "time_s",
        &[(0.0, 0.0), (0.1, 0.1), (0.2, 0.2), (0.3, 0.1), (0.4, 0.0)],
    );
    let by_step = rows("step", &[(0.0, 0.0), (1.0, 0.1), (2.0, 0.1)]);
    let round = rows(
        "azimuth_deg",
        &[(0.0, 0.0), (90.0, 1.0), (180.0, 0.0), (270.0, -1.0)],
    );
    let closed = format!("{round}360,0,0,0\n360,1,0,0\n");
    let in_a_row = "time.values = [0.4, 0.1, 0.3]";
    let (one, turning) = (
        "time.values = [0.1]",
        "time = { values = [0, 4], frequency = 0.25 }",
    );
    for (head, file, expected) in [
        (in_a_row, &wave, vec![-1.0, 1.0, -1.0]),
        (one, &wave, vec![1.0]),
        (in_a_row, &by_step, vec![-1.0, 0.0, -1.0 / 3.0]),
        // A degree is 1/90 s.
        (turning, &round, vec![1.0, 1.0]),
        (turning, &closed, vec![1.0, 1.0]),
    ] {
        let motion = surface(true, head, SURFACE, file).expect("it is good");
        for (step, rate) in motion.steps.iter().zip(expected) {
            let found = motion.velocities(step)[0].velocity(0, [0.0; 3]);
            assert!((found[0] - rate).abs() < 1e-12, "{head} {step:?} {found:?}");
        }
    }
}

#[test]
fn places_that_are_a_little_off_are_told_of_with_the_tolerance_that_takes_them() {
    for (off, expected) in [
        (
            "1e-8",
            "1 of the 4 nodes of body \"blade\" are missing: 3; the nearest positions in the file are up to 1.0e-8 away, which match_tolerance = 1e-7 would accept; add them, or set missing = \"fixed\"",
        ),
        (
            "0.5",
            "are missing: 3; add them, or set missing = \"fixed\"",
        ),
    ] {
        let file =
            format!("x,y,z,dx,dy,dz\n0,0,0,0,0,0\n1,0,0,0,0,0\n1,1,0,0,0,0\n0,1,{off},0,0,1\n");
        let error = told(false, SURFACE, &file);
        assert!(error.ends_with(expected), "{error}");
    }
    let both = told(false, SURFACE, "node,x,y,z,dx,dy,dz\n0,0,0,0,0,0,0\n");
    assert!(
        both.ends_with("columns `node` and `x` have the same meaning; keep one of them"),
        "{both}"
    );
}

const COORDINATES: &str = "time_s,q1,q2\n0,0,0\n1,1,0\n2,1,-3\n";

#[test]
fn modes_add_up_with_their_coordinates() {
    let body = "modes = { shapes = \"m.vtu\", coordinates = \"q.csv\" }";
    let motion =
        beside_mesh(body, &[("shape_1", 0.1), ("shape_2", 0.01)], COORDINATES).expect("it is good");
    for (step, factor) in [(0, 1.0), (1, 1.1), (2, 1.07)] {
        assert_near(place(&motion, step, 2), [factor, factor, 0.0]);
    }
    // From 0 s on the first mode grows by 1 a second, from 1 s on the second falls by 3.
    for (step, rate) in [(0, 0.1), (1, -0.03)] {
        let pace = &motion.velocities(&motion.steps[step])[0];
        assert_near(pace.velocity(2, [1.0, 1.0, 0.0]), [rate, rate, 0.0]);
    }
    let two = beside_mesh(body, &[("shape_1", 0.1)], COORDINATES).expect_err("one is missing");
    assert!(two.to_string().ends_with("mode 2 needs one point array of 3 components whose name ends in 2, as in mode2; found: shape_1"), "{two}");
}

#[test]
fn modes_by_node_are_a_table() {
    let body =
        "modes = { shapes = \"s.csv\", coordinates = \"q.csv\" }\nrigid.translate = [0, 0, 1]";
    let q = "azimuth_deg,q1\n0,2\n90,4\n180,2\n270,0\n";
    let read = |shapes: &str| {
        resolve(
            false,
            "azimuth.values = [45]",
            body,
            &[("s.csv", shapes), ("q.csv", q)],
        )
    };
    let shapes = "node,mode,dx,dy,dz\n0,1,0,0,0\n1,1,0,0,0.1\n2,1,0,0,0.2\n3,1,0,0,0\n";
    let motion = read(shapes).expect("it is good");
    assert_near(place(&motion, 0, 2), [1.0, 1.0, 1.6]);
    let wrong = read("node,mode,dx,dy,dz\n0,2,0,0,0\n").expect_err("there is one mode");
    assert!(wrong.to_string().ends_with("s.csv:2: column `mode` has 2; the table of coordinates has q1 to q1, so it must be from 1 to 1"), "{wrong}");
}

#[test]
fn a_child_of_a_body_of_nodes_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "boundaries.others = \"fixed\"\nazimuth.values = [0]\n[[body]]\nname = \"wing\"\ntags = [\"blade_1\"]\nsurface = { file = \"s.csv\" }\n[[body]]\nname = \"flap\"\ntags = [\"hub\"]\nparent = \"wing\"\n";
    std::fs::write(folder.path().join("hover.toml"), text).expect("it can be written");
    std::fs::write(folder.path().join("s.csv"), BY_NODE).expect("it can be written");
    let schedule =
        crate::motion::Schedule::read(folder.path().join("hover.toml")).expect("it is good");
    let error = schedule
        .resolve_on(&two_cubes())
        .expect_err("it is refused")
        .to_string();
    assert!(error.ends_with("hover.toml:8: body \"flap\" cannot move with \"wing\", whose `surface` or `modes` are known only at its own nodes; give the child a motion of its own"), "{error}");
}

#[test]
fn the_nearest_set_is_taken_however_close_they_are() {
    let file = "time_s,node,dx,dy\n0,0,0,0\n0,1,0,0\n5e-7,0,0.25,0\n5e-7,1,0,0\n1e-6,0,0.5,0\n1e-6,1,0,0\n";
    let head = "time = { stop = 1e-6, step = 5e-7 }";
    let motion = surface(true, head, SURFACE, file).expect("it is good");
    for (step, x) in [(0, 0.0), (1, 0.25), (2, 0.5)] {
        assert_near(place(&motion, step, 0), [x, 0.0, 0.0]);
    }
    let between = "time.values = [0, 4e-7]";
    let none = surface(true, between, SURFACE, file).expect_err("4e-7 is missing");
    assert!(
        none.to_string()
            .contains("there are no rows for time 4e-7 s"),
        "{none}"
    );
}

#[test]
fn a_set_may_be_off_its_step_by_rounding_and_a_turn_away() {
    let file = "azimuth_deg,node,dx,dy\n0,0,0,0\n0,1,0,0\n33.3333,0,0.25,0\n33.3333,1,0,0\n360,0,0,0\n360,1,0,0\n";
    let head = "azimuth.values = [33.333333333, 393.333333333, -360]";
    let motion = surface(true, head, SURFACE, file).expect("it is good");
    for (step, x) in [(0, 0.25), (1, 0.25), (2, 0.0)] {
        assert_near(place(&motion, step, 0), [x, 0.0, 0.0]);
    }
}

#[test]
fn every_step_has_the_file_of_its_number() {
    let positions = |by: f64| {
        let rows = (0..4).map(|node| {
            let [x, y, z] = two_cubes().points[node];
            format!("{node} {x} {y} {:?}\n", z + by)
        });
        rows.collect::<String>()
    };
    let [first, second, third] = [0.0, 0.1, 0.4].map(positions);
    let files = [
        ("s_00000.dat", first.as_str()),
        ("s_1.dat", &second),
        ("s_00003.dat", &third),
        ("s_x.dat", "not a number"),
    ];
    let at = |head: &str, more: &str, files: &[(&str, &str)]| {
        let body = format!("surface = {{ file = \"s_*.dat\"{more} }}");
        resolve(false, head, &body, files)
    };
    let motion = at("azimuth.values = [0, 30]", "", &files).expect("it is good");
    for (step, by) in [0.0, 0.1].into_iter().enumerate() {
        assert_near(place(&motion, step, 1), [1.0, 0.0, by]);
    }
    let between = at("steps = 3", ", interpolation = \"linear\"", &files).expect("it is good");
    assert_near(place(&between, 2, 1), [1.0, 0.0, 0.25]);
    let told = |head: &str, more: &str, files: &[(&str, &str)]| {
        let error = at(head, more, files).expect_err("it is wrong").to_string();
        let at = error.rfind("hover.toml").or_else(|| error.rfind("s_"));
        error[at.expect("a file")..].to_owned()
    };
    assert_eq!(
        told("steps = 3", "", &files),
        "hover.toml:6: no file s_*.dat has the number 2; every step needs the file of its number, the first that of 0, or \
         `interpolation`"
    );
    assert_eq!(
        told("steps = 4", ", interpolation = \"linear\"", &files),
        "s_00003.dat:1: the motion needs step 4, but the table goes from step 0 to step 3; add the missing rows"
    );
    assert_eq!(
        told("steps = 1", "", &[]),
        "hover.toml:6: there is no file s_*.dat with the number of a step for `*`"
    );
    let twice = [files[1], ("s_01.dat", second.as_str())];
    assert_eq!(
        told("steps = 1", "", &twice),
        "hover.toml:6: s_01.dat and s_1.dat have the same number; keep one of them"
    );
    assert_eq!(
        told("steps = 1", ", columns = { dx = \"u\" }", &files)
            .split(" is for")
            .next(),
        Some("hover.toml:6: `columns`")
    );
}

#[test]
fn exports_of_other_programs_have_names_and_units_of_their_own() {
    let rows = "0;0;0;0;0;0;0\n1000,0;0;0;0;100;0;0\n1000;1000;0;1;0;200;0\n0;1000;0;1;0;0;300\n";
    let table = format!("PosX;PosY;PosZ;Rank;DisplacementX;DisplacementY;DisplacementZ\n{rows}");
    let names = "x = \"PosX\", y = \"PosY\", z = \"PosZ\", dx = \"DisplacementX\", dy = \"DisplacementY\", dz = \"DisplacementZ\"";
    let units = "x = 0.001, y = \"mm\", z = \"mm\", dx = \"mm\", dy = \"mm\", dz = \"mm\"";
    let body =
        format!("surface = {{ file = \"s.csv\", columns = {{ {names} }}, units = {{ {units} }} }}");
    let motion = surface(false, "azimuth.values = [0]", &body, &table).expect("it is good");
    for (node, moved) in (0..).zip(MOVED) {
        let x = two_cubes().points[node as usize];
        assert_near(place(&motion, 0, node), add(x, moved));
    }
    assert!(
        motion
            .notes()
            .iter()
            .any(|note| note.text.ends_with(": Rank"))
    );
    assert_eq!(
        told(false, SURFACE, &table),
        "s.csv:1: the table has no column `node`; found: PosX, PosY, PosZ, Rank, DisplacementX, DisplacementY, DisplacementZ"
    );
}
