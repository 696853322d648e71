//! `convert` and `info` from outside: what is done to a mesh, folders of meshes, sequences.

use crate::support::sequence::{read, testdata};
use crate::support::{airfoil, assert_says, azimesh, json, names, succeed};
use serde_json::json as value;
use std::path::Path;

fn mesh_of_testdata(name: &str) -> String {
    testdata(name).to_str().unwrap().to_owned()
}

/// Two squares of two triangles, apart, without boundary elements; node 8 is no cell's.
const BARE: &str = "NDIME= 2\nNELEM= 4\n5 0 1 2 0\n5 0 2 3 1\n5 4 5 6 2\n5 4 6 7 3\nNPOIN= 9\n0 0 0\n\
1 0 1\n1 1 2\n0 1 3\n5 0 4\n6 0 5\n6 1 6\n5 1 7\n5 1 8\nNMARK= 0\n";

fn bare() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bare.su2"), BARE).unwrap();
    folder
}

#[test]
fn a_mesh_without_boundary_elements_gets_a_tag_for_each_connected_part() {
    let folder = bare();
    let before = json(folder.path(), "info bare.su2");
    assert_eq!(before["open_faces"], 8);
    let tag = [
        "convert",
        "bare.su2",
        "t.vtu",
        "--tag-boundary",
        "connected",
    ];
    let run = succeed(folder.path(), tag);
    assert_says(&run.err, &["2", "tags", "8", "faces"]);
    let found = json(folder.path(), "info t.vtu");
    let tags = found["boundary_tags"].as_array().unwrap();
    let told: Vec<_> = tags
        .iter()
        .map(|tag| (&tag["name"], &tag["faces"]))
        .collect();
    let [one, two] = [value!("boundary_1"), value!("boundary_2")];
    assert_eq!(told, [(&one, &value!(4)), (&two, &value!(4))]);
    assert_eq!(found["open_faces"], 0);
}

#[test]
fn info_tells_of_nodes_without_a_cell_and_at_one_place() {
    let folder = bare();
    let found = json(folder.path(), "info bare.su2");
    assert_eq!(
        (&found["orphan_nodes"], &found["repeated_nodes"]),
        (&value!(1), &value!(1))
    );
    let text = succeed(folder.path(), "info bare.su2").out;
    assert_says(&text, &["8 faces"]);
}

#[test]
fn a_turn_and_the_turn_back_leave_the_mesh_as_it_was() {
    let folder = airfoil();
    succeed(folder.path(), "convert n.vtu a.vtu --rotate z,90,1,0,0");
    assert_eq!(azimesh(folder.path(), "diff n.vtu a.vtu").code, 1);
    succeed(
        folder.path(),
        "convert a.vtu b.vtu --rotate 0,0,1,-90,1,0,0",
    );
    let near = "diff n.vtu b.vtu --tolerance 1e-15";
    succeed(folder.path(), near);
    let wrong = azimesh(folder.path(), "convert n.vtu c.vtu --rotate w,90");
    assert_eq!(wrong.code, 2);
}

#[test]
fn a_curved_mesh_becomes_linear_and_keeps_its_tags() {
    let folder = tempfile::tempdir().unwrap();
    let curved = mesh_of_testdata("curved_solids_complete_v22.msh");
    succeed(folder.path(), ["convert", &curved, "l.vtu", "--linearize"]);
    let found = json(folder.path(), "info l.vtu");
    assert_eq!(
        (&found["curved_cells"], &found["orphan_nodes"]),
        (&value!(0), &value!(0))
    );
    let before = json(folder.path(), ["info", &curved]);
    assert_eq!(found["cells"], before["cells"]);
    let faces = |info: &serde_json::Value| {
        let tags = info["boundary_tags"].as_array().unwrap();
        tags.iter()
            .map(|tag| tag["faces"].as_u64().unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(faces(&found), faces(&before));
}

#[test]
fn many_meshes_go_into_a_folder_under_their_names() {
    let folder = airfoil();
    let block = mesh_of_testdata("block.vtu");
    let into = ["convert", "n.vtu", &block, "-o", "out"];
    assert_eq!(azimesh(folder.path(), into).code, 2);
    let into = [&into[..], &["--format", "su2"]].concat();
    succeed(folder.path(), &into);
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["block.su2", "n.su2"]);
    succeed(folder.path(), "diff n.vtu out/n.su2");
    assert_eq!(azimesh(folder.path(), &into).code, 2);
    let twice = "convert n.vtu out/n.su2 -o o2 --format vtu";
    let run = azimesh(folder.path(), twice);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["o2/n.vtu", "n.vtu and out/n.su2"]);
}

#[test]
fn a_folder_goes_into_several_formats_and_each_loss_names_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::create_dir(path.join("in")).unwrap();
    for name in [
        "block.vtu",
        "mixed_cells.su2",
        "curved_plate_complete_v41.msh",
    ] {
        std::fs::copy(testdata(name), path.join("in").join(name)).unwrap();
    }
    std::fs::write(path.join("in/notes.txt"), "no mesh").unwrap();
    std::fs::write(
        path.join("in/two.pvd"),
        "<VTKFile><Collection><DataSet timestep=\"0\" file=\"block.vtu\"/></Collection></VTKFile>",
    )
    .unwrap();
    let into = "convert in -o out --format cgns,ugrid";
    let refused = azimesh(path, into);
    assert_eq!(refused.code, 2, "{refused:?}");
    let lines: Vec<_> = refused
        .err
        .lines()
        .filter(|line| line.starts_with("error"))
        .collect();
    assert_eq!(lines.len(), 2, "{refused:?}");
    assert_says(lines[0], &["curved_plate_complete_v41.ugrid"]);
    assert_says(lines[1], &["two_0000.ugrid"]);
    assert!(!path.join("out").exists());

    let run = azimesh(path, format!("{into} --keep-going"));
    assert_eq!(run.code, 1, "{run:?}");
    let out = names(&path.join("out"));
    let written = [
        "curved_plate_complete_v41.cgns",
        "mixed_cells.cgns",
        "two.cgns",
    ];
    assert!(
        written.iter().all(|name| out.contains(&(*name).to_owned())),
        "{out:?}"
    );
    let row = |name: &str| run.out.lines().find(|line| line.contains(name)).unwrap();
    assert_says(row("two.ugrid.pvd"), &["not written"]);
    assert_says(row("mixed_cells.cgns"), &["nothing"]);
}

#[test]
fn losses_of_several_outputs_are_in_the_json_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let [ugrid, blade] = ["mixed_cells.ugrid", "hart_ii.vtu"].map(mesh_of_testdata);
    let into = format!("convert {ugrid} {blade} -o out --format su2,cgns");
    let found = json(path, &into);
    let outputs = found["outputs"].as_array().unwrap();
    let told = outputs.iter().map(|one| (&one["input"], &one["output"]));
    let [a, b] = [value!(ugrid), value!(blade)];
    let written = [
        "mixed_cells.su2",
        "mixed_cells.cgns",
        "hart_ii.su2",
        "hart_ii.cgns",
    ];
    let written = written.map(|name| value!(format!("out/{name}")));
    let wanted = [&a, &a, &b, &b].into_iter().zip(&written);
    assert!(told.eq(wanted), "{found}");
    assert_eq!(
        outputs[0]["lost"],
        value!(["arrays_left_out", "conditions_left_out"])
    );
    assert_eq!(outputs[2]["lost"], value!([]));
    let notes = outputs[0]["notes"].as_array().unwrap();
    assert_eq!(notes.len(), 2);
    assert!(notes.iter().all(|note| note["path"] == written[0]));
    assert_eq!(outputs[2]["notes"], value!([]));
    let two = azimesh(path, ["info", &ugrid, "--format", "su2,cgns"]);
    assert_eq!(two.code, 2, "{two:?}");
}

#[test]
fn every_refusal_of_a_batch_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let inside = |name: &str| path.join("in").join(name);
    std::fs::create_dir(path.join("in")).unwrap();
    for (name, copy) in [
        ("block.vtu", "a.vtu"),
        ("mixed_cells_v22.msh", "a.msh"),
        ("block.vtu", "b.vtu"),
        ("moving_by_vtk.vtkhdf", "s.vtkhdf"),
        ("block.vtu", "s_0001.vtu"),
    ] {
        std::fs::copy(testdata(name), inside(copy)).unwrap();
    }
    std::fs::write(inside("d.msh"), "no mesh").unwrap();
    std::fs::create_dir(path.join("out")).unwrap();
    std::fs::write(path.join("out/b.vtu"), "mine").unwrap();
    let into = "convert in -o out --format vtu --json";
    let refused = azimesh(path, into);
    assert_eq!(refused.code, 2, "{refused:?}");
    let found: serde_json::Value = serde_json::from_str(&refused.out).unwrap();
    let errors = found["errors"].as_array().unwrap();
    let paths = errors.iter().map(|error| error["path"].as_str().unwrap());
    let wanted = ["in/d.msh", "out/a.vtu", "out/s_0001.vtu", "out/b.vtu"];
    assert!(paths.eq(wanted), "{found}");
    assert_eq!(errors[3], found["error"]);
    assert_eq!(names(&path.join("out")), ["b.vtu"]);

    let run = azimesh(path, format!("{into} --keep-going"));
    assert_eq!(run.code, 1, "{run:?}");
    let found: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(found["failed"], value!(errors));
    assert_eq!(found["outputs"].as_array().unwrap().len(), 4);
    assert_eq!(std::fs::read(path.join("out/b.vtu")).unwrap(), b"mine");
}

#[test]
fn a_mesh_along_a_curve_is_the_same_by_position_in_every_format() {
    let folder = airfoil();
    let path = folder.path();
    let run = succeed(path, "convert n.vtu r.vtu --reorder");
    assert_says(&run.err, &["--reorder", "space-filling curve"]);
    assert_eq!(azimesh(path, "diff n.vtu r.vtu").code, 1);
    succeed(path, "diff n.vtu r.vtu --match position");
    let quality = |mesh: &str| json(path, ["quality", mesh])["summary"]["cells"].clone();
    assert_eq!(quality("n.vtu"), quality("r.vtu"));
    succeed(path, "convert r.vtu again.vtu --reorder");
    assert!(
        std::fs::read(path.join("again.vtu")).unwrap()
            == std::fs::read(path.join("r.vtu")).unwrap()
    );
    for one in ["r.cgns", "r.vtkhdf", "r.su2", "r.msh", "r.vtk"] {
        succeed(path, ["convert", "n.vtu", one, "--reorder"]);
        succeed(path, ["diff", "r.vtu", one, "--match", "position"]);
    }
    let mixed = mesh_of_testdata("polyhedra_ascii.vtu");
    succeed(path, ["convert", &mixed, "p.vtu", "--reorder"]);
    succeed(path, ["diff", &mixed, "p.vtu", "--match", "position"]);
}

#[test]
fn all_steps_of_a_sequence_have_the_order_of_the_first() {
    let folder = airfoil();
    let path = folder.path();
    let turn = "--rotate z,40";
    succeed(path, format!("convert n.vtu turned.vtu {turn}"));
    succeed(path, "convert n.vtu r.vtu --reorder");
    succeed(path, format!("convert r.vtu expected.vtu {turn}"));
    succeed(path, "convert turned.vtu own.vtu --reorder");
    assert_eq!(azimesh(path, "diff own.vtu expected.vtu").code, 1);
    for one in ["all.vtkhdf", "all.cgns", "all.pvd"] {
        let run = succeed(path, ["convert", "n.vtu", "turned.vtu", one, "--reorder"]);
        assert_eq!(run.err.matches("--reorder").count(), 1, "{}", run.err);
        let step = format!("convert {one} one.vtu --step 1 --force");
        succeed(path, &step);
        succeed(path, "diff one.vtu expected.vtu --match position");
        let [found, expected] = ["one.vtu", "expected.vtu"].map(|name| read(&path.join(name)));
        assert!(found.points == expected.points, "{one}");
    }
    let into = "convert n.vtu turned.vtu -o out --format vtu --reorder";
    succeed(path, into);
    succeed(path, "diff out/turned.vtu own.vtu");
}

/// Three meshes of a sequence: `n.vtu` scaled by 1, 2 and 3.
fn parts(folder: &Path) {
    for step in ["1", "2", "3"] {
        let name = format!("p_{step}.vtu");
        succeed(folder, ["convert", "n.vtu", &name, "--scale", step]);
    }
}

#[test]
fn part_files_go_into_one_file_and_back() {
    let folder = airfoil();
    let path = folder.path();
    parts(path);
    for one in ["all.vtkhdf", "all.cgns"] {
        succeed(path, ["convert", "p_1.vtu", "p_2.vtu", "p_3.vtu", one]);
        let times = &json(path, ["info", one])["times"];
        assert_eq!(*times, value!([0.0, 1.0, 2.0]), "{one}");
        let back = format!("{one}_back");
        succeed(path, ["convert", one, "-o", &back, "--format", "vtu"]);
        for (i, part) in ["p_1.vtu", "p_2.vtu", "p_3.vtu"].into_iter().enumerate() {
            let expected = read(&path.join(part)).points;
            let found = read(&path.join(&back).join(format!("all_000{i}.vtu"))).points;
            assert!(expected == found, "{one} step {i}");
        }
        assert!(names(&path.join(&back)).contains(&"all.pvd".to_owned()));
        succeed(path, ["convert", one, "two.vtu", "--step", "1", "--force"]);
        succeed(path, "diff p_2.vtu two.vtu");
    }
}

#[test]
fn a_list_of_meshes_is_a_sequence() {
    let folder = airfoil();
    let path = folder.path();
    parts(path);
    succeed(path, "convert p_1.vtu p_2.vtu p_3.vtu s.pvd");
    assert_eq!(json(path, "info s.pvd")["times"], value!([0.0, 1.0, 2.0]));
    succeed(path, "convert s.pvd s.vtkhdf");
    assert_eq!(
        json(path, "info s.vtkhdf")["times"],
        value!([0.0, 1.0, 2.0])
    );
    succeed(path, "convert s.pvd -o legacy --format vtk");
    let left = names(&path.join("legacy"));
    let expected = [
        "s.pvd",
        "s.vtk.series",
        "s_0000.vtk",
        "s_0001.vtk",
        "s_0002.vtk",
    ];
    assert_eq!(left, expected);
    let last = ["convert", "legacy/s.vtk.series", "last.vtu"];
    assert_says(&succeed(path, last).err, &["s.vtk.series", "last"]);
    succeed(path, "diff p_3.vtu last.vtu");
}

#[test]
fn what_an_output_cannot_hold_is_told_once_for_a_whole_sequence() {
    let folder = airfoil();
    let path = folder.path();
    succeed(path, "quality n.vtu -o q_0.vtu");
    std::fs::copy(path.join("q_0.vtu"), path.join("q_1.vtu")).unwrap();
    succeed(path, "convert q_0.vtu q_1.vtu q.pvd");
    let run = succeed(path, "convert q.pvd -o out --format su2");
    assert_eq!(run.err.matches("note: ").count(), 1, "{run:?}");
}

#[test]
fn pieces_are_read_back_as_the_mesh_they_were() {
    let folder = airfoil();
    let path = folder.path();
    let cut = |out| ["convert", "n.vtu", out, "--pieces", "3"];
    assert_eq!(azimesh(path, cut("p.vtu")).code, 2);
    succeed(path, cut("p.pvtu"));
    assert_eq!(names(&path.join("p")).len(), 3);
    succeed(path, "diff n.vtu p.pvtu");
}

#[test]
fn what_a_killed_conversion_left_goes_with_the_next_one() {
    let folder = bare();
    for left in [".azimesh_77-0.part", ".azimesh_78-12.part"] {
        std::fs::write(folder.path().join(left), "half").unwrap();
    }
    succeed(folder.path(), "convert bare.su2 out.vtu");
    assert_eq!(names(folder.path()), ["bare.su2", "out.vtu"]);
}

#[test]
fn of_conversions_to_one_new_name_at_once_one_succeeds() {
    let folder = bare();
    let convert = |scale: &str| {
        azimesh(
            folder.path(),
            format!("convert bare.su2 out.vtu --scale {scale}"),
        )
    };
    for _ in 0..10 {
        let runs = std::thread::scope(|scope| {
            let threads = ["2", "3", "4", "5"].map(|scale| (scale, scope.spawn(|| convert(scale))));
            threads.map(|(scale, thread)| (scale, thread.join().unwrap()))
        });
        let (won, lost): (Vec<_>, Vec<_>) = runs.iter().partition(|(_, run)| run.code == 0);
        assert_eq!(won.len(), 1, "{runs:?}");
        for (_, run) in lost {
            assert_eq!(run.code, 2, "{run:?}");
            assert_says(&run.err, &["out.vtu: "]);
        }
        let found = json(folder.path(), "info out.vtu");
        let scale: f64 = won[0].0.parse().unwrap();
        assert_eq!(
            found["bounds"][1][0].as_f64().unwrap(),
            6.0 * scale,
            "{found}"
        );
        std::fs::remove_file(folder.path().join("out.vtu")).unwrap();
    }
}

/// A row of squares of 0.1 m at the coordinates of a map, where 32 bits tell half a metre apart.
fn far_squares() -> String {
    let mut text = "NDIME= 2\nNELEM= 4\n".to_owned();
    for i in 0..4 {
        text += &format!("9 {i} {} {} {}\n", i + 1, i + 6, i + 5);
    }
    text += "NPOIN= 10\n";
    for i in 0..10 {
        text += &format!(
            "{} {}\n",
            0.1 * f64::from(i % 5),
            5_846_925.0 + 0.1 * f64::from(i / 5)
        );
    }
    text + "NMARK= 0\n"
}

#[test]
fn cells_that_become_flat_in_32_bits_are_counted_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("far.su2"), far_squares()).unwrap();
    let all = "4 of 4 (the first is cell 0)";
    for name in ["f.vtu", "f.vtk", "f.vtkhdf", "f.cgns", "f.pvd", "f.vtp"] {
        let run = succeed(folder, ["convert", "far.su2", name, "--precision", "f32"]);
        assert_says(&run.err, &["become flat", all]);
    }
    let pieces = "convert far.su2 f.pvtu --pieces 2 --precision f32";
    assert_says(&succeed(folder, pieces).err, &["become flat", all]);
    let run = succeed(folder, "convert far.su2 f.stl");
    assert_says(&run.err, &["become flat", "8 of 8"]);
    let run = succeed(folder, "convert --extrude 1 far.su2 f.b4.ugrid");
    assert_says(&run.err, &["become flat", all]);
    for (name, precision) in [("g.vtu", "f64"), ("g.su2", "f64"), ("g.msh", "f32")] {
        let run = succeed(
            folder,
            format!("convert far.su2 {name} --precision {precision}"),
        );
        assert!(!run.err.contains("become flat"), "{run:?}");
    }
}

#[test]
fn a_layer_becomes_plane_again_and_a_half_and_a_sector_whole_in_every_step() {
    let folder = airfoil();
    let path = folder.path();
    succeed(path, "convert n.vtu layer.vtu --extrude 0.1");
    let run = succeed(path, "convert layer.vtu flat.vtu --flatten");
    assert_says(&run.err, &["one layer along z", "back, front"]);
    succeed(path, "diff n.vtu flat.vtu");
    let sector = mesh_of_testdata("rotor_sector.vtu");
    for (step, by) in [("0", "1"), ("1", "2")] {
        let name = format!("s_{step}.vtu");
        succeed(path, ["convert", &sector, &name, "--scale", by]);
    }
    succeed(path, "convert s_0.vtu s_1.vtu s.vtkhdf");
    let whole = "--repeat 4 --axis z";
    succeed(path, format!("convert s.vtkhdf r.vtkhdf {whole}"));
    succeed(path, format!("convert s_1.vtu r_1.vtu {whole}"));
    let step = ["convert", "r.vtkhdf", "step.vtu", "--step", "1"];
    succeed(path, step);
    succeed(path, "diff step.vtu r_1.vtu");
    let volume = |mesh: &str| {
        json(path, ["quality", mesh])["total_volume"]
            .as_f64()
            .unwrap()
    };
    let (of_sector, of_rotor) = (volume("s_1.vtu"), volume("r_1.vtu"));
    assert!((of_rotor - 4.0 * of_sector).abs() < 1e-12 * of_rotor);
    for wrong in ["x", "z,91", "z,0"] {
        let run = azimesh(
            path,
            format!("convert s_0.vtu w.vtu --repeat 4 --axis {wrong}"),
        );
        assert_eq!(
            (run.code, path.join("w.vtu").exists()),
            (2, false),
            "{wrong}"
        );
    }
    let half = mesh_of_testdata("wing_on_plane.vtu");
    let run = succeed(
        path,
        format!("convert {half} wings.vtu --mirror z --mirror-suffix _left"),
    );
    assert_says(
        &run.err,
        &["221 nodes are joined", "tags that are gone: symmetry"],
    );
    let found = json(path, "info wings.vtu");
    let tags = found["boundary_tags"].as_array().unwrap().iter();
    let tags: Vec<_> = tags.map(|tag| tag["name"].as_str().unwrap()).collect();
    assert_eq!(tags, ["wing", "farfield", "wing_left", "farfield_left"]);
    let quality = json(path, "quality wings.vtu");
    assert_eq!(quality["inverted_reference"], 0);
}

#[test]
fn meshes_are_merged_with_their_names_and_joined_within_a_distance_on_request() {
    let folder = bare();
    let path = folder.path();
    let tagged = BARE.replace(
        "NMARK= 0",
        "NMARK= 1\nMARKER_TAG= edge\nMARKER_ELEMS= 2\n3 1 2\n3 0 3",
    );
    std::fs::write(path.join("a.su2"), &tagged).unwrap();
    succeed(path, "convert a.su2 b.su2 --translate 1.0001,0,0");
    let run = succeed(path, "convert --merge a.su2 b.su2 -o m.su2");
    assert_says(&run.err, &["that became one each: edge"]);
    let found = json(path, "info m.su2");
    assert_eq!(
        (&found["nodes"], &found["boundary_tags"][0]["faces"]),
        (&value!(18), &value!(4))
    );
    let apart = azimesh(path, "convert --merge a.su2 b.su2 j.su2 --join");
    assert_eq!(apart.code, 2);
    assert_says(&apart.err, &["no face of a mesh lies on a face of another"]);
    let merge = [
        "convert",
        "--merge",
        "a.su2",
        "b.su2",
        "j.su2",
        "--prefix-tags",
    ];
    let run = succeed(path, [&merge[..], &["--join", "1e-3"]].concat());
    assert_says(
        &run.err,
        &["nodes are joined", "tags with fewer faces: a_edge, b_edge"],
    );
    let found = json(path, "info j.su2");
    assert_eq!(found["nodes"], 14);
    let found = json(path, "info j.su2");
    let tags = found["boundary_tags"].as_array().unwrap().len();
    assert_eq!(tags, 2);
    for wrong in [
        &["convert", "--merge", "a.su2", "-o", "w.su2"][..],
        &["convert", "a.su2", "w.su2", "--prefix-tags"],
        &["convert", "a.su2", "w.su2", "--translate", "1,2"],
        &["convert", "a.su2", "w.su2", "--mirror", "w"],
    ] {
        assert_eq!(azimesh(path, wrong).code, 2, "{wrong:?}");
    }
}

#[test]
fn node_numbers_that_su2_exchanges_go_where_nodes_are_renumbered() {
    let folder = bare();
    let path = folder.path();
    let exchange = "NMARK= 1\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_TO= 1\n1 0 1";
    let text = BARE.replace("NPOIN= 9", "NPOIN= 9 8");
    std::fs::write(path.join("e.su2"), text.replace("NMARK= 0", exchange)).unwrap();
    for (changes, is_kept) in [
        (&["--translate", "1,0,0"][..], true),
        (&["--reorder"], false),
        (&["--mirror", "x"], false),
    ] {
        let run = succeed(
            path,
            [&["convert", "--force", "e.su2", "f.su2"], changes].concat(),
        );
        let text = std::fs::read_to_string(path.join("f.su2")).unwrap();
        let kept = text.contains("SEND_RECEIVE") && text.contains("NPOIN= 9 8");
        let said = run.err.contains("su2:SEND_RECEIVE, su2:NPOIN");
        assert_eq!((kept, said), (is_kept, !is_kept), "{changes:?}: {run:?}");
    }
}
