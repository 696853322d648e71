//! The files of moving surfaces: one per mesh, written again if lost, and refused if SU2 would misread them.

use crate::run::{Finished, Request, finish};
use azimesh_core::error::Result;
use azimesh_core::progress::Silent;
use azimesh_deform::Deformation;
use azimesh_deform::motion::Schedule;
use azimesh_io::mesh::Mesh;
use std::ops::Range;
use std::path::Path;

const MESH: &str = "testdata/airfoil_hybrid.su2";
const STEPS: &str = "time = { stop = 0.03, step = 0.01, frequency = 10.0 }\n";
const REST: &str = "output.surface = \"su2\"\noutput.quality = \"none\"\nboundaries.others = \"fixed\"\n\
    rbf.support_radius = 3.0\n[[body]]\nname = \"airfoil\"\ntags = [\"airfoil\"]\n\
    rigid = { translate = [0.0, 0.01, 0.0], ramp = true }\n";

fn deform(
    folder: &Path,
    schedule: &str,
    steps: Option<Range<usize>>,
    resume: bool,
) -> Result<Finished> {
    let request = Request {
        steps,
        resume,
        ..Request::default()
    };
    super::deform(folder, MESH, schedule, request)
}

/// Checks that the file of the surface of a step has the nodes of the moving tag, at their positions in the mesh.
fn check_surface(folder: &Path, step: usize) {
    let out = folder.join("out");
    let mesh = Mesh::read(out.join(format!("airfoil_hybrid_{step:04}.vtu"))).expect("it is there");
    let name = format!("airfoil_hybrid_surface_{step:05}.dat");
    let text = std::fs::read_to_string(out.join(name)).expect("it is there");
    let lines = text.lines().map(|line| {
        let numbers = line.split(' ').map(|x| x.parse().expect("a number"));
        numbers.collect::<Vec<f64>>()
    });
    let nodes = mesh.tag_nodes("airfoil").expect("it is a tag");
    assert!(nodes.len() > 10);
    let wanted = nodes.iter().map(|&node| {
        let [x, y, _] = mesh.points[node as usize];
        vec![f64::from(node), x, y]
    });
    assert_eq!(lines.collect::<Vec<_>>(), wanted.collect::<Vec<_>>());
}

#[test]
fn each_step_has_the_places_of_the_moving_nodes_in_a_file_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    deform(folder.path(), &format!("{STEPS}{REST}"), None, false).expect("it runs");
    (0..4).for_each(|step| check_surface(folder.path(), step));
    // The node numbers refer to the SU2 mesh that was read.
    let first = Mesh::read(folder.path().join("out/airfoil_hybrid_0000.vtu")).expect("it is there");
    let mesh = Mesh::read(Path::new(MESH)).expect("it is there");
    assert_eq!(first.points, mesh.points);
}

#[test]
fn a_step_whose_surface_file_is_lost_or_another_is_written_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let schedule = format!("{STEPS}{REST}");
    deform(folder.path(), &schedule, None, false).expect("it runs");
    let out = folder.path().join("out");
    std::fs::remove_file(out.join("airfoil_hybrid_surface_00001.dat")).expect("it is there");
    let third = out.join("airfoil_hybrid_surface_00003.dat");
    let text = std::fs::read_to_string(&third).expect("it is there");
    std::fs::write(&third, &text[..text.len() / 2]).expect("it can be written");
    let done = deform(folder.path(), &schedule, None, true).expect("it runs");
    assert_eq!((done.n_kept, done.n_steps), (2, 4));
    (0..4).for_each(|step| check_surface(folder.path(), step));
    assert_eq!(std::fs::read_to_string(&third).expect("it is there"), text);
}

#[test]
fn parts_leave_their_surface_files_and_finish_misses_one_that_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let schedule = format!("{STEPS}{REST}");
    for part in [0..2, 2..4] {
        deform(folder.path(), &schedule, Some(part), false).expect("it runs");
    }
    let out = folder.path().join("out");
    let third = out.join("airfoil_hybrid_surface_00003.dat");
    let kept = std::fs::read(&third).expect("it is there");
    std::fs::remove_file(&third).expect("it is there");
    let error = finish(&out, false, &Silent)
        .expect_err("a file is lost")
        .to_string();
    assert!(error.contains("step 3 is damaged"), "{error}");
    std::fs::write(&third, kept).expect("it can be written");
    finish(&out, false, &Silent).expect("all is there");
    (0..4).for_each(|step| check_surface(folder.path(), step));
}

#[test]
fn steps_that_are_no_iterations_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let schedule = format!("time = {{ values = [0.0, 0.01, 0.03], frequency = 10.0 }}\n{REST}");
    let error = deform(folder.path(), &schedule, None, false).expect_err("it is refused");
    let message = error.to_string();
    assert!(
        message.contains("step 2 is not as far from the last one"),
        "{message}"
    );
    assert!(!folder.path().join("out").exists());
}

#[test]
fn node_numbers_that_are_not_those_of_su2_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.toml");
    let text = format!("{STEPS}{REST}");
    let schedule = Schedule::parse(&text, &path).expect("it is good");
    let mesh = Mesh::read(Path::new(MESH)).expect("it is there");
    let deformation = Deformation::builder(mesh, schedule)
        .plan()
        .expect("they fit");
    let check = |mesh: &str| {
        let view = deformation.mesh().view();
        crate::preflight::check_surface_files(deformation.plan(), &view, Path::new(mesh))
    };
    for mesh in ["a/wing.su2", "wing.SU2.gz"] {
        check(mesh).expect("it is an SU2 file");
    }
    let error = check("wing.vtu").expect_err("it is none").to_string();
    assert!(
        error.contains("the nodes of wing.vtu have numbers"),
        "{error}"
    );
}
