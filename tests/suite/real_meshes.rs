//! Meshes of other programs, deformed as a user would, from the folder that AZIMESH_TESTDATA names.
//! The motion is evaluated here once more, by plain trigonometry.

use assert_cmd::Command;
use azimesh_io::mesh::Mesh;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

type Vector = [f64; 3];

/// Rotations about fixed axes through a point, in the order of the list: axis (0, 1, 2) and degrees.
struct Turn {
    centre: Vector,
    rotations: Vec<(usize, f64)>,
}

impl Turn {
    fn apply(&self, x: Vector) -> Vector {
        let mut q: Vector = std::array::from_fn(|i| x[i] - self.centre[i]);
        for &(axis, degrees) in &self.rotations {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            (q[i], q[j]) = (cos * q[i] - sin * q[j], sin * q[i] + cos * q[j]);
        }
        std::array::from_fn(|i| q[i] + self.centre[i])
    }
}

/// A real mesh with the schedule of testdata/real that is for it.
struct Case {
    mesh: &'static str,
    schedule: &'static str,
    moving: &'static [&'static str],
    fixed: &'static [&'static str],
    n_steps: usize,
    /// Cells that the source mesh has folded or flat.
    inverted_reference: &'static str,
    /// The motion at an azimuth in degrees.
    turn: fn(f64) -> Turn,
}

/// A finished run.
struct Sequence {
    folder: TempDir,
    reference: Mesh,
    rows: Vec<Vec<String>>,
    header: Vec<String>,
}

/// `None` where the folder is not given, which is said loudly.
fn testdata() -> Option<PathBuf> {
    let folder = std::env::var_os("AZIMESH_TESTDATA");
    if folder.is_none() {
        eprintln!("AZIMESH_TESTDATA is not set: NO REAL MESH IS DEFORMED");
    }
    folder.map(PathBuf::from)
}

fn read(path: &Path) -> Mesh {
    Mesh::read(path).unwrap()
}

/// The nodes of boundary tags.
fn nodes_of(mesh: &Mesh, tags: &[&str]) -> BTreeSet<usize> {
    let groups = mesh.boundary_tags();
    let named: Vec<_> = groups
        .filter(|group| tags.contains(&group.name.as_str()))
        .collect();
    assert_eq!(named.len(), tags.len(), "the mesh has the tags {tags:?}");
    named
        .iter()
        .flat_map(|group| group.cells.iter())
        .flat_map(|cell| mesh.cells.get(cell).nodes)
        .map(|&node| node as usize)
        .collect()
}

impl Sequence {
    /// Runs the program, which must have nothing to complain about.
    fn of(testdata: &Path, case: &Case) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mesh = testdata.join(case.mesh);
        let schedules = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/real");
        let output = Command::cargo_bin("azimesh")
            .unwrap()
            .arg("deform")
            .args([&mesh, &schedules.join(case.schedule)])
            .arg("-o")
            .arg(folder.path().join("out"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{}: {said}", case.schedule);
        let table = std::fs::read_to_string(folder.path().join("out/steps.csv")).unwrap();
        let cut = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = table.lines().map(cut);
        Self {
            header: lines.next().unwrap(),
            rows: lines.collect(),
            reference: read(&mesh),
            folder,
        }
    }

    fn column<'a>(&'a self, name: &str) -> impl Iterator<Item = &'a str> {
        let at = self.header.iter().position(|column| column == name);
        let at = at.unwrap();
        self.rows.iter().map(move |row| row[at].as_str())
    }

    fn points(&self, file: &str) -> Vec<Vector> {
        read(&self.folder.path().join("out").join(file)).points
    }
}

/// Deforms a real mesh: no inverted cell, moving nodes where the motion puts them, fixed ones as
/// they were to the last bit, at every step.
fn deform(case: &Case) {
    let Some(testdata) = testdata() else { return };
    let sequence = Sequence::of(&testdata, case);
    assert_eq!(sequence.rows.len(), case.n_steps);
    assert!(sequence.column("inverted").all(|n| n == "0"));
    let folded_before = sequence.column("inverted_reference");
    assert!({ folded_before }.all(|n| n == case.inverted_reference));
    let surface_error = sequence.column("max_surface_error");
    assert!({ surface_error }.all(|error| error.parse() == Ok(0.0)));

    let reference = &sequence.reference;
    let moving = nodes_of(reference, case.moving);
    let mut fixed = nodes_of(reference, case.fixed);
    fixed.retain(|node| !moving.contains(node));
    let size = reference.points.iter().flatten();
    let size = size.fold(0.0, |size: f64, x| size.max(x.abs()));
    let mut largest: f64 = 0.0;
    for (file, azimuth) in sequence.column("file").zip(sequence.column("azimuth_deg")) {
        let points = sequence.points(file);
        assert_eq!(points.len(), reference.points.len());
        for &node in &fixed {
            let bits = |x: Vector| x.map(f64::to_bits);
            assert_eq!(bits(points[node]), bits(reference.points[node]), "{file}");
        }
        let turn = (case.turn)(azimuth.parse().unwrap());
        for &node in &moving {
            let exact = turn.apply(reference.points[node]);
            for axis in 0..3 {
                let off = (points[node][axis] - exact[axis]).abs();
                assert!(off <= 1e-12 * size.min(1.0), "{file}: node {node} {off:e}");
                largest = largest.max((exact[axis] - reference.points[node][axis]).abs());
            }
        }
    }
    assert!(largest > 0.01, "the body has moved, by {largest}");
}

/// Pitch in the plane of x and y: a nose at -x rises, so the turn is clockwise.
fn pitch(centre: Vector, degrees: f64) -> Turn {
    Turn {
        centre,
        rotations: vec![(2, -degrees)],
    }
}

#[test]
fn the_airfoil_of_openfoam_pitches_by_20_degrees() {
    deform(&Case {
        mesh: "gen_openfoam1912/naca0012_adjoint/naca0012_tagged.vtu",
        schedule: "naca0012_openfoam.toml",
        moving: &["3", "4"],
        fixed: &["2"],
        n_steps: 13,
        inverted_reference: "0",
        turn: |azimuth| pitch([0.25, 0.0, 0.0], 20.0 * azimuth.to_radians().sin()),
    });
}

#[test]
fn the_wing_of_openfoam_turns_by_20_degrees() {
    deform(&Case {
        mesh: "gen_openfoam1912/wingMotion2D/wingMotion2D_tagged.vtu",
        schedule: "wing_motion_2d.toml",
        moving: &["4"],
        fixed: &["1", "2", "3"],
        n_steps: 11,
        inverted_reference: "21",
        turn: |azimuth| pitch([0.4974612746, -0.01671895744, 0.125], -azimuth),
    });
}

#[test]
fn the_viscous_sphere_of_su2_pitches_flaps_and_lags() {
    deform(&Case {
        mesh: "su2code__TestCases/hom_navierstokes/SphereViscous/nPoly1/SphereViscous_Linear.su2.gz",
        schedule: "sphere_su2.toml",
        moving: &["Sphere"],
        fixed: &["Farfield"],
        n_steps: 13,
        inverted_reference: "0",
        turn: |azimuth| {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            Turn {
                centre: [-1.0, 0.0, 0.0],
                rotations: vec![(0, 20.0 * sin), (1, -10.0 * cos), (2, 5.0 * sin)],
            }
        },
    });
}

#[test]
fn the_wing_and_fuselage_of_gmsh_turn_by_20_degrees() {
    deform(&Case {
        mesh: "gen_gmsh4.15/wing_fuselage_12k_v41_bin.msh",
        schedule: "wing_fuselage_gmsh.toml",
        moving: &["Fuselage"],
        fixed: &["Infinity"],
        n_steps: 11,
        inverted_reference: "0",
        turn: |azimuth| Turn {
            centre: [0.0; 3],
            rotations: vec![(1, azimuth)],
        },
    });
}

#[test]
fn the_hybrid_airfoil_mesh_of_su2_pitches_by_20_degrees() {
    deform(&Case {
        mesh: "su2code__TestCases/navierstokes/naca0012/mesh_NACA0012_lam_hybrid_v1.su2",
        schedule: "naca0012_su2_hybrid.toml",
        moving: &["airfoil"],
        fixed: &["farfield"],
        n_steps: 13,
        inverted_reference: "0",
        turn: |azimuth| pitch([0.25, 0.0, 0.0], 20.0 * azimuth.to_radians().sin()),
    });
}

const PITCHING: &str = "su2code__TestCases/disc_adj_euler/naca0012_pitching_def";

/// Node positions that SU2 has published for a step.
fn published(testdata: &Path, step: usize) -> Vec<[f64; 2]> {
    let name = format!("naca0012_pitching_def_solution_flow_{step:05}_xy.csv");
    let text = std::fs::read_to_string(testdata.join(PITCHING).join(name)).unwrap();
    let row = |line: &str| {
        let (x, y) = line.split_once(',').unwrap();
        [x.parse().unwrap(), y.trim().parse().unwrap()]
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn the_pitching_airfoil_is_where_su2_published_it() {
    deform(&PITCHING_AIRFOIL);
    let Some(testdata) = testdata() else { return };
    let sequence = Sequence::of(&testdata, &PITCHING_AIRFOIL);
    let surface = nodes_of(&sequence.reference, &["airfoil", "farfield"]);
    for (step, file) in sequence.column("file").enumerate() {
        let points = sequence.points(file);
        let published = published(&testdata, step);
        assert_eq!(points.len(), published.len());
        for &node in &surface {
            let off = (0..2).map(|axis| (points[node][axis] - published[node][axis]).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < 1e-9, "step {step}, node {node}: {off:e}");
        }
    }
}

/// theta = -1.01 sin(azimuth) degrees counter-clockwise.
const PITCHING_AIRFOIL: Case = Case {
    mesh: "su2code__TestCases/disc_adj_euler/naca0012_pitching_def/mesh_NACA0012_inv_FFD.su2",
    schedule: "naca0012_pitching.toml",
    moving: &["airfoil"],
    fixed: &["farfield"],
    n_steps: 5,
    inverted_reference: "0",
    turn: |azimuth| pitch([0.248, 0.0, 0.0], 1.01 * azimuth.to_radians().sin()),
};
