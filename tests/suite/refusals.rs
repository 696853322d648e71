//! Bad input and failed checks from outside: one sentence with the place, the numbers and the names, the right exit
//! code, and no output file left behind.

use crate::support::{Args, airfoil, assert_says, azimesh, json, names, rewrite, succeed};
use azimesh_io::formats::{self, Commit, WriteOptions};
use azimesh_io::mesh::{CellKind, Group, Mesh};
use std::path::Path;

/// The run is refused with exit code 2 and one sentence that says all of `parts`; no file is left.
fn refused(folder: &Path, args: impl Args, parts: &[&str]) {
    let before = names(folder);
    let run = azimesh(folder, &args);
    assert_eq!(run.code, 2, "{args:?}: {run:?}");
    assert_eq!(run.out, "", "{args:?}");
    assert!(run.err.starts_with("error: "), "{}", run.err);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    assert_says(&run.err, parts);
    assert_eq!(names(folder), before, "{args:?}");
}

/// `deform` with the schedule's text `old` replaced is refused.
fn schedule_refused(folder: &Path, old: &str, new: &str, parts: &[&str]) {
    rewrite(folder, "n.toml", "s.toml", &[(old, new)]);
    for command in ["deform", "select"] {
        let args = format!("{command} n.vtu s.toml -q -o out");
        refused(folder, &args, parts);
    }
    refused(folder, "check n.vtu s.toml", parts);
}

#[test]
fn a_wrong_schedule_is_refused_at_its_line() {
    let folder = airfoil();
    let folder = folder.path();
    schedule_refused(
        folder,
        "tags = [\"airfoil\"]",
        "tags = [\"airfoi\"]",
        &["s.toml:14: ", "\"airfoi\"", "airfoil, farfield"],
    );
    schedule_refused(
        folder,
        "kernel =",
        "kernal =",
        &["s.toml:23: ", "`kernal`", "`kernel`"],
    );
    schedule_refused(
        folder,
        "wendland-c2",
        "wendlnd-c2",
        &["s.toml:23: ", "\"wendlnd-c2\"", "`wendland-c2`"],
    );
    schedule_refused(
        folder,
        "step = 10.0",
        "step = 0.0",
        &["s.toml:8: ", "`step`", "0"],
    );
    schedule_refused(folder, "[rbf]", "[rbf", &["s.toml:22: ", "TOML"]);
    schedule_refused(
        folder,
        "fixed = [\"farfield\"]",
        "",
        &["s.toml:", "farfield", "others"],
    );
}

#[test]
fn files_that_are_missing_empty_or_folders_are_refused_by_name() {
    let folder = airfoil();
    let folder = folder.path();
    std::fs::create_dir(folder.join("folder")).unwrap();
    std::fs::write(folder.join("empty.vtu"), "").unwrap();
    std::fs::write(folder.join("empty.xyz"), "").unwrap();
    std::fs::write(folder.join("note.dat"), "hello\n").unwrap();
    for (mesh, parts) in [
        ("no.vtu", ["no.vtu: ", "file"]),
        ("folder", ["folder: ", "mesh"]),
        ("empty.vtu", ["empty.vtu: ", "empty"]),
        ("empty.xyz", ["empty.xyz: ", "empty"]),
        ("note.dat", ["\"hello\\n\"", "SU2 mesh (.su2)"]),
    ] {
        refused(folder, ["deform", mesh, "n.toml", "-o", "out"], &parts);
        refused(folder, ["info", mesh], &parts);
        refused(folder, ["convert", mesh, "out.vtu"], &parts);
        refused(folder, ["quality", mesh], &parts);
        refused(folder, ["diff", "n.vtu", mesh], &parts);
    }
    let deform = |schedule| ["deform", "n.vtu", schedule, "-o", "out"];
    refused(folder, deform("no.toml"), &["no.toml: ", "file"]);
    refused(folder, deform("folder"), &["folder: ", "directory"]);
    refused(
        folder,
        "convert n.vtu out.zzz",
        &["out.zzz: ", ".pvtu, .vtp, .vtu, .vtkhdf, .vtk, .msh,"],
    );
    refused(folder, "info n.vtu --format vut", &["\"vut\"", "vtu, "]);
}

#[test]
fn a_truncated_mesh_is_refused_at_its_place() {
    let folder = airfoil();
    let folder = folder.path();
    for (name, place) in [
        ("n.vtu", "connectivity"),
        ("n.msh", ": byte "),
        ("n.msh2", ": byte "),
        ("n.su2", "cut_n.su2:"),
    ] {
        if name != "n.vtu" {
            succeed(folder, ["convert", "n.vtu", name]);
        }
        let whole = std::fs::read(folder.join(name)).unwrap();
        let cut = format!("cut_{name}");
        std::fs::write(folder.join(&cut), &whole[..whole.len() / 2]).unwrap();
        let args = format!("deform {cut} n.toml -o out");
        refused(folder, &args, &[&cut, place]);
        refused(folder, ["convert", &cut, "out.vtu"], &[&cut, place]);
    }
}

#[test]
fn a_folder_of_an_earlier_run_is_kept_unless_forced() {
    let folder = airfoil();
    let folder = folder.path();
    let deform = "deform n.vtu n.toml -q -o out";
    succeed(folder, deform);
    std::fs::write(folder.join("out/notes.txt"), "mine").unwrap();
    refused(folder, deform, &["out: ", "--force"]);
    assert!(folder.join("out/n_0036.vtu").is_file());
    rewrite(
        folder,
        "n.toml",
        "n.toml",
        &[("stop = 360.0", "stop = 20.0")],
    );
    succeed(folder, format!("{deform} --force"));
    let expected = [
        "base.toml",
        "base.vtp",
        "n.pvd",
        "n_0000.vtu",
        "n_0001.vtu",
        "n_0002.vtu",
        "notes.txt",
        "run.json",
        "steps.csv",
    ];
    assert_eq!(names(&folder.join("out")), expected);
}

#[test]
fn outputs_are_kept_unless_forced() {
    let folder = airfoil();
    let folder = folder.path();
    succeed(folder, "select n.vtu n.toml -q -o b.toml");
    std::fs::copy(folder.join("n.vtu"), folder.join("other.vtu")).unwrap();
    for args in [
        "select n.vtu n.toml -o b.toml",
        "convert n.vtu other.vtu",
        "sample block -o n.vtu",
    ] {
        let output = args.rsplit(' ').next().unwrap();
        refused(folder, args, &[output, "--force"]);
        succeed(folder, format!("{args} --force"));
    }
}

/// Two tetrahedra as polyhedra, the faces of one tagged wall, of the other far.
fn polyhedra() -> Mesh {
    let mut mesh = Mesh::default();
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    for part in 0..2u32 {
        let shift = 5.0 * f64::from(part);
        mesh.points
            .extend(corners.map(|[x, y, z]| [x + shift, y, z]));
        let of_face = |face: [u32; 3]| [3, face[0], face[1], face[2]];
        let numbered = faces.map(|face| face.map(|node| node + 4 * part));
        let stream = [&[4][..], &numbered.map(of_face).concat()].concat();
        mesh.cells.push_polyhedron(&stream).unwrap();
    }
    for (part, name) in [(0, "airfoil"), (4, "farfield")] {
        let first = mesh.cells.len();
        for face in faces {
            let nodes = face.map(|node| node + part);
            mesh.cells.push(CellKind::Triangle, &nodes);
        }
        mesh.groups.push(Group {
            dimension: 2,
            name: name.into(),
            number: None,
            condition: None,
            cells: (first..first + 4).collect(),
        });
    }
    mesh
}

#[test]
fn a_format_that_cannot_hold_the_mesh_is_refused_before_work_starts() {
    let folder = airfoil();
    let folder = folder.path();
    let vtu = formats::by_name("vtu").unwrap();
    let path = folder.join("p.vtu");
    formats::save(
        &polyhedra().view(),
        &path,
        vtu,
        &WriteOptions::default(),
        Commit::REPLACE,
    )
    .unwrap();
    for output in ["out.su2", "out.msh", "out.msh2"] {
        let parts = [output, "polyhedr"];
        refused(folder, ["convert", "p.vtu", output], &parts);
    }
    let su2 = "fixed = [\"farfield\"]\n[output]\nformat = \"su2\"";
    let changes = [("fixed = [\"farfield\"]", su2), ("sin = 10.0", "sin = 1.0")];
    rewrite(folder, "n.toml", "s.toml", &changes);
    let args = "deform p.vtu s.toml -q -o out";
    refused(folder, args, &["s.toml", "\"su2\"", "polyhedr"]);
}

#[test]
fn f32_is_refused_where_it_would_change_a_first_cell() {
    let folder = airfoil();
    let folder = folder.path();
    let fine = [
        "-q",
        "sample",
        "naca0012",
        "--nodes",
        "1500",
        "--first-cell",
    ];
    succeed(folder, [&fine[..], &["2e-7", "-o", "fine.vtu"]].concat());
    let single = "[boundaries]\nfixed";
    let text = std::fs::read_to_string(folder.join("fine.toml")).unwrap();
    assert!(text.contains(single));
    std::fs::write(
        folder.join("s.toml"),
        text + "\n[output]\nprecision = \"f32\"\n",
    )
    .unwrap();
    let args = ["deform", "fine.vtu", "s.toml", "-q", "-o", "out"];
    refused(folder, args, &["\"f32\"", "first", "\"f64\""]);
    succeed(folder, "deform n.vtu s.toml -q -o coarse");
    // A format of 32 bits alone is no other way round it.
    let extrude = "-q convert --extrude 0.1 fine.vtu deep.vtu";
    succeed(folder, extrude);
    let tags = "[\"farfield\", \"front\", \"back\"]";
    let changes = [
        ("[\"farfield\"]", tags),
        ("precision = \"f32\"", "format = \"ugrid-b4\""),
    ];
    rewrite(folder, "s.toml", "b4.toml", &changes);
    let args = ["deform", "deep.vtu", "b4.toml", "-q", "-o", "out"];
    refused(folder, args, &["\"ugrid-b4\"", "first", "\"ugrid-b8\""]);
}

#[test]
fn an_unreachable_tolerance_saves_the_base_points_and_writes_no_mesh() {
    let folder = airfoil();
    let folder = folder.path();
    let few = ("tolerance = 1e-4", "max_points = 3\ntolerance = 1e-4");
    rewrite(folder, "n.toml", "s.toml", &[few]);
    let run = azimesh(folder, "deform n.vtu s.toml -q -o out");
    assert_eq!((run.code, run.out.as_str()), (1, ""), "{run:?}");
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    assert_says(&run.err, &["s.toml", "1e-4", "3 base points", "max_points"]);
    let left = ["base.toml", "base.vtp", "run.json"];
    assert_eq!(names(&folder.join("out")), left);
    let record = std::fs::read_to_string(folder.join("out/run.json")).unwrap();
    assert_says(&record, &["1e-4", "3 base points"]);
}

#[test]
fn inverted_cells_give_exit_code_1_and_stop_where_asked() {
    let folder = airfoil();
    let folder = folder.path();
    let warn = ("[rbf]", "[output]\non_inverted = \"warn\"\n[rbf]");
    rewrite(
        folder,
        "n.toml",
        "s.toml",
        &[("sin = 10.0", "sin = 170.0"), warn],
    );
    let run = azimesh(folder, "deform n.vtu s.toml -o out");
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["step 3", "30 degrees"]);
    assert_says(&run.err, &["-v"]);
    assert_says(&run.out, &["inverted cells"]);
    assert!(folder.join("out/n_0036.vtu").is_file());
    rewrite(folder, "s.toml", "s.toml", &[("\"warn\"", "\"stop\"")]);
    let run = azimesh(folder, "deform n.vtu s.toml -q -o stopped");
    assert_eq!((run.code, run.err.lines().count()), (1, 1), "{run:?}");
    assert_says(&run.err, &["step"]);
    let rows = std::fs::read_to_string(folder.join("stopped/steps.csv")).unwrap();
    let meshes = names(&folder.join("stopped"));
    let meshes = meshes.iter().filter(|name| name.ends_with(".vtu")).count();
    assert_eq!(rows.lines().count(), 1 + meshes);
    assert!(meshes < 37);
}

#[test]
fn fail_on_gives_exit_code_1_where_it_holds_and_knows_its_columns() {
    let folder = airfoil();
    let folder = folder.path();
    let deform = ["deform", "n.vtu", "n.toml", "-q", "--fail-on"];
    let unknown = [&deform[..], &["invertd>0", "-o", "out"]].concat();
    refused(folder, &unknown, &["\"invertd\"", "inverted"]);
    let none = ("[rbf]", "[output]\nquality = \"none\"\n[rbf]");
    rewrite(folder, "n.toml", "none.toml", &[none]);
    let body = "[[body]]\nname = \"a\"\ntags = [\"airfoil\"]\nrigid.translate = [0.1, 0.0, 0.0]\n";
    let times =
        format!("time = {{ stop = 0.2, step = 0.1 }}\nboundaries.others = \"fixed\"\n{body}");
    std::fs::write(folder.join("times.toml"), times).unwrap();
    for (schedule, condition, reason) in [
        ("n.toml", "time_s>0", "rotor.rpm"),
        ("times.toml", "azimuth_deg>0", "times alone"),
        ("none.toml", "inverted>0", "output.quality = \"none\""),
        (
            "none.toml",
            "max_normal_change_deg>1",
            "output.quality = \"none\"",
        ),
    ] {
        let args = [
            "deform",
            "n.vtu",
            schedule,
            "-q",
            "-o",
            "out",
            "--fail-on",
            condition,
        ];
        refused(folder, args, &[&condition[..condition.len() - 2], reason]);
    }
    let met = [&deform[..], &["min_scaled_jacobian<0.9", "-o", "met"]].concat();
    assert_eq!(azimesh(folder, &met).code, 1);
    let not_met = [&deform[..], &["inverted>0", "-o", "not"]].concat();
    succeed(folder, &not_met);
    let args = [&met[..], &["--force"]].concat();
    let found = json(folder, &args)["failures"].clone();
    let record = std::fs::read_to_string(folder.join("met/run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["failures"], found);
    assert_eq!(
        record["arguments"],
        serde_json::json!([&args[..], &["--json"]].concat())
    );
    // What quality measures on meshes, deform measures at its steps.
    let of_faces = [&deform[..], &["min_face_weight<0.5", "-o", "faces"]].concat();
    assert_eq!(azimesh(folder, &of_faces).code, 1);
    let quality = "quality faces --fail-on min_face_weight<0.5";
    assert_eq!(azimesh(folder, quality).code, 1);
    // The warnings of both are the same, but for the mesh before it deforms.
    let warnings = |args: &[&str]| azimesh(folder, args).err;
    let aloud: Vec<&str> = of_faces.into_iter().filter(|arg| *arg != "-q").collect();
    let told = warnings(&[&aloud[..], &["--force"]].concat());
    let at_rest =
        "warning: min_face_weight<0.5 holds for the mesh before it deforms: min_face_weight is ";
    assert_eq!(told.matches(at_rest).count(), 1, "{told}");
    assert!(
        told.ends_with(&azimesh(folder, format!("{quality} -q")).err),
        "{told}"
    );
    let loose = ["deform", "n.vtu", "n.toml", "-o", "loose", "--fail-on"];
    let told = warnings(&[&loose[..], &["min_scaled_jacobian<0.01"]].concat());
    assert!(!told.contains("before it deforms"), "{told}");
    let failures = found;
    assert_eq!(failures.as_array().unwrap().len(), 37);
    let first = &failures[0]; // the worst
    assert_eq!(
        (&first["metric"], &first["limit"], &first["step"]),
        (&"min_scaled_jacobian".into(), &0.9.into(), &9.into())
    );
    assert!(first["value"].as_f64().unwrap() < 0.9 && first["message"].is_string());
}

#[test]
fn what_is_no_file_of_base_points_is_refused_with_what_it_should_be() {
    let folder = airfoil();
    let folder = folder.path();
    for file in ["n.vtu", "n.toml"] {
        let args = format!("deform n.vtu n.toml -q -o out --base {file}");
        refused(folder, &args, &[file, "base points"]);
    }
}

#[test]
fn an_output_folder_that_cannot_be_is_refused_in_a_sentence() {
    let folder = airfoil();
    let folder = folder.path();
    let deform = |out| ["deform", "n.vtu", "n.toml", "-q", "-o", out];
    refused(folder, deform("n.vtu"), &["n.vtu: ", "folder"]);
    refused(folder, deform("n.vtu/out"), &["n.vtu/out: "]);
    refused(folder, "convert n.vtu n.vtu/o.vtu", &["o.vtu: "]);
    refused(folder, "convert n.vtu no/o.vtu", &["no/o.vtu: "]);
}

#[test]
fn a_body_that_leaves_the_mesh_is_refused_unless_it_is_allowed_and_warned_of_before_the_work() {
    let folder = airfoil();
    let path = folder.path();
    let schedule = "azimuth.values = [0, 90]\nboundaries.others = \"fixed\"\noutput.on_inverted = \"stop\"\n\
                    body = [ { name = \"a\", tags = [\"airfoil\"], rigid = { translate = [300, 0, 0], ramp = true } } ]\n";
    std::fs::write(path.join("far.toml"), schedule).unwrap();
    let args = ["-q", "deform", "n.vtu", "far.toml", "-o", "out"];
    let parts = [
        "far.toml:4: body \"a\" leaves the bounding box of the mesh at 1 of the 2 steps",
        "moves by up to 300",
        "--allow-outside",
    ];
    refused(path, args, &parts);
    let run = azimesh(path, [&args[1..], &["--allow-outside"]].concat());
    assert_eq!(run.code, 1, "{run:?}");
    // The inverted cells of the first step that moves end the run.
    let at = |part: &str| {
        run.err
            .find(part)
            .unwrap_or_else(|| panic!("{part}: {run:?}"))
    };
    assert!(at("leaves the bounding box") < at("error: "), "{run:?}");
    assert_eq!(run.err.matches("leaves the bounding box").count(), 1);
    // What was allowed once is not asked for again.
    let again = azimesh(path, [&args[..], &["--resume"]].concat());
    assert_eq!(again.code, 1, "{again:?}");
}

#[test]
fn a_body_may_leave_the_place_of_a_boundary_that_moves_along() {
    let folder = airfoil();
    let path = folder.path();
    let body = |name: &str| {
        format!("[[body]]\nname = \"{name}\"\ntags = [\"{name}\"]\nrigid.translate = [300, 0, 0]\n")
    };
    let schedule = format!(
        "azimuth.values = [0, 90]\n{}{}",
        body("airfoil"),
        body("farfield")
    );
    std::fs::write(path.join("far.toml"), schedule).unwrap();
    succeed(path, "deform n.vtu far.toml -o out");
}

#[test]
fn a_name_that_is_too_long_for_files_of_steps_is_refused_before_the_work() {
    let folder = airfoil();
    let path = folder.path();
    let mesh = format!("{}.vtu", "x".repeat(251));
    std::fs::rename(path.join("n.vtu"), path.join(&mesh)).unwrap();
    for format in ["vtu", "vtkhdf", "cgns", "vtk"] {
        let args = format!("-q deform {mesh} n.toml -o out --format {format}");
        refused(
            path,
            &args,
            &["name is longer than this file system allows"],
        );
    }
}

#[test]
fn swapped_arguments_and_meshes_without_tags_get_the_remedy() {
    let folder = airfoil();
    let folder = folder.path();
    let order = "the first argument is the mesh, the second the schedule (TOML)";
    for command in ["check", "select -o b.toml", "deform -o out"] {
        let args = format!("{command} n.toml n.vtu");
        let parts = [
            "n.vtu: the schedule is a mesh, VTK XML unstructured grid",
            order,
        ];
        refused(folder, &args, &parts);
    }
    let parts = ["n.toml: this is a TOML file, such as a motion schedule; a mesh belongs here"];
    refused(folder, "check n.toml n.toml", &parts);
    refused(folder, "info n.toml", &parts);
    let mesh = "NDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0 0 0\n1 0 1\n0 1 2\nNMARK= 0\n";
    std::fs::write(folder.join("bare.su2"), mesh).unwrap();
    let parts = ["no boundary tags", "--tag-boundary connected"];
    refused(folder, "check bare.su2 n.toml", &parts);
}
