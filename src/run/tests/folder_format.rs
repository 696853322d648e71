//! A run in a format that is a folder: it fits without a word of it in this room.

use crate::deform::Deformation;
use crate::formats::ReadOptions;
use crate::mesh::Mesh;
use crate::motion::Schedule;
use crate::run::{Request, run};
use std::path::Path;

const SCHEDULE: &str = "azimuth.values = [0, 45, 90]\noutput.format = \"toy\"\noutput.quality = \"none\"\n\
    boundaries.fixed = [\"inlet\", \"outlet\", \"walls\"]\nrbf.support_radius = 3.0\n\
    [[body]]\nname = \"sphere\"\ntags = [\"sphere\"]\n\
    rigid = { translate = [0.1, 0.0, 0.0], ramp = true }\n";

fn deform(folder: &Path, steps: Option<std::ops::Range<usize>>, resume: bool) -> usize {
    let mesh = Path::new("testdata/sphere_in_box_raw.vtu");
    let path = folder.join("s.toml");
    std::fs::write(&path, SCHEDULE).expect("it can be written");
    let schedule = Schedule::parse(SCHEDULE, &path).expect("it is good");
    let read = Mesh::read(mesh).expect("it is there");
    let deformation = Deformation::builder(read, schedule)
        .plan()
        .expect("they fit");
    let request = Request {
        mesh: mesh.to_path_buf(),
        folder: folder.join("out"),
        steps,
        resume,
        no_sync: true,
        ..Request::default()
    };
    let done = run(&deformation, &request);
    done.unwrap_or_else(|error| panic!("{error}")).n_kept
}

#[test]
fn a_sequence_is_written_into_a_folder_and_gone_on_with() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(deform(folder.path(), None, false), 0);
    let path = folder.path().join("out/sphere_in_box_raw.toy");
    let at = |step| {
        let options = ReadOptions {
            step: Some(step),
            ..ReadOptions::default()
        };
        let read = Mesh::read_with(&path, &options).expect("it can be read");
        assert_eq!(read.format.name(), "toy");
        read.mesh
    };
    let meshes = [0, 1, 2].map(at);
    assert!(meshes[0].points != meshes[1].points && meshes[1].points != meshes[2].points);
    std::fs::remove_dir_all(path.join("90")).expect("the last step");
    assert_eq!(deform(folder.path(), None, true), 3);
    assert_eq!([0, 1, 2].map(at), meshes);
}
