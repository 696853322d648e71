//! Cases of OpenFOAM: meshes written to them, sequences beside what was copied, and what is refused.

use crate::support::{all_files, assert_says, azimesh, rewrite, succeed};
use azimesh::Mesh;
use azimesh_io::formats::{self, Begin, Commit, WriteOptions};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const CONTROL: &str = "FoamFile { class dictionary; }\ntimePrecision 4; // digits\n";
const SPHERE: &str = "azimuth.values = [0, 45, 90]\noutput.displacement = true\n\
    boundaries.fixed = [\"inlet\", \"outlet\", \"walls\"]\nrbf.support_radius = 3.0\n\
    [[body]]\nname = \"sphere\"\ntags = [\"sphere\"]\n\
    rigid = { translate = [0.1, 0.0, 0.0], ramp = true }\n";

/// A folder with the case `in` of a sphere in a box, and a schedule.
fn sphere() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Path::new("testdata/sphere_in_box_raw.vtu")
        .canonicalize()
        .unwrap();
    let case = folder.path().join("in");
    for inside in ["system", "0", "0.5", "constant"] {
        fs::create_dir_all(case.join(inside)).unwrap();
    }
    fs::write(case.join("system/controlDict"), CONTROL).unwrap();
    fs::write(case.join("0/U"), "a field").unwrap();
    fs::write(case.join("0.5/U"), "a later field").unwrap();
    fs::write(case.join("constant/transportProperties"), "nu 1e-5;").unwrap();
    succeed(
        folder.path(),
        [
            "-q",
            "convert",
            mesh.to_str().unwrap(),
            "in",
            "--patch-type",
            "sphere=wall",
        ],
    );
    fs::write(folder.path().join("s.toml"), SPHERE).unwrap();
    folder
}

/// Files without those that tell of the single run: seconds, and run.json.
fn meshes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = all_files(folder);
    files.retain(|name, _| !name.starts_with("azimesh/") && !name.ends_with(".foam"));
    files
}

fn read(path: &Path) -> Mesh {
    Mesh::read(path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_mesh_written_read_and_written_again_is_the_same() {
    let folder = sphere();
    let folder = folder.path();
    let case = folder.join("in/constant/polyMesh");
    for encoding in ["raw", "ascii"] {
        let out = format!("again_{encoding}");
        succeed(
            folder,
            format!("-q convert in {out} --format openfoam --encoding {encoding}"),
        );
        succeed(folder, ["-q", "diff", "in", &out]);
        let again = folder.join(&out).join("constant/polyMesh");
        for file in ["faces", "owner", "neighbour", "boundary", "cellZones"] {
            assert_eq!(
                fs::read(case.join(file)).unwrap(),
                fs::read(again.join(file)).unwrap(),
                "{file}"
            );
        }
        let (a, b) = (read(&folder.join("in")), read(&folder.join(&out)));
        let bits = |mesh: &Mesh| {
            mesh.points
                .iter()
                .flatten()
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert!(bits(&a).len() > 1000 && bits(&a) == bits(&b));
    }
    // By way of another format its faces are found again, in the same order.
    succeed(folder, "-q convert in by.vtu");
    succeed(folder, "-q convert by.vtu by --format openfoam");
    let by = folder.join("by/constant/polyMesh");
    for file in ["owner", "neighbour"] {
        assert_eq!(
            fs::read(case.join(file)).unwrap(),
            fs::read(by.join(file)).unwrap(),
            "{file}"
        );
    }
}

#[test]
fn a_sequence_lies_in_a_case_beside_what_was_copied_and_the_input_stays() {
    let folder = sphere();
    let folder = folder.path();
    let before = all_files(&folder.join("in"));
    succeed(folder, "-q deform in s.toml -o out");
    let out = folder.join("out");
    let files = all_files(&out);
    for (name, content) in &before {
        let is_copied =
            !name.starts_with("0.5/") && !name.ends_with("points") && !name.ends_with(".foam");
        assert_eq!(
            files.get(name).filter(|_| is_copied),
            Some(content).filter(|_| is_copied),
            "{name}"
        );
    }
    for name in [
        "45/polyMesh/points",
        "90/wantedDisplacement",
        "0/wantedDisplacement",
        "out.foam",
        "azimesh/run.json",
    ] {
        assert!(files.contains_key(name), "{name}");
    }
    assert!(!files.contains_key("0.5/U") && !files.contains_key("0/polyMesh/points"));
    // The same positions as in a format of its own, bit for bit.
    succeed(folder, "-q deform in s.toml -o vtu --format vtu");
    for (time, step) in [("constant", 0), ("45", 1), ("90", 2)] {
        let own = read(&out.join(time));
        let other = read(&folder.join(format!("vtu/in_{step:04}.vtu")));
        assert!(
            own.points.iter().flatten().map(|x| x.to_bits()).eq(other
                .points
                .iter()
                .flatten()
                .map(|x| x.to_bits())),
            "{time}"
        );
    }
    assert_eq!(all_files(&folder.join("in")), before);
    let text = String::from_utf8_lossy(&files["90/wantedDisplacement"]).into_owned();
    assert_says(
        &text,
        &[
            "class       pointVectorField;",
            "dimensions      [0 1 0 0 0 0 0];",
            "sphere\n    {\n        type            calculated;",
        ],
    );
}

#[test]
fn a_run_in_a_case_is_resumed_and_joined_from_parts_to_the_same_files() {
    let folder = sphere();
    let folder = folder.path();
    succeed(folder, "-q deform in s.toml -o out");
    let wanted = meshes(&folder.join("out"));
    for steps in ["1..3", "0..1"] {
        succeed(
            folder,
            format!("-q deform in s.toml -o parts --steps {steps}"),
        );
    }
    succeed(folder, "-q finish parts");
    assert_eq!(meshes(&folder.join("parts")), wanted);
    type Damage = (&'static str, fn(&Path));
    let damages: [Damage; 5] = [
        ("90/polyMesh/points", |path| fs::remove_file(path).unwrap()),
        ("45/wantedDisplacement", |path| fs::write(path, "").unwrap()),
        ("constant/polyMesh/owner", |path| {
            fs::remove_file(path).unwrap()
        }),
        ("constant/polyMesh/points", |path| {
            fs::remove_file(path).unwrap()
        }),
        ("0/wantedDisplacement", |path| {
            fs::remove_file(path).unwrap()
        }),
    ];
    for (name, damage) in damages {
        damage(&folder.join("out").join(name));
        succeed(folder, "-q deform in s.toml -o out --resume");
        assert_eq!(meshes(&folder.join("out")), wanted, "{name}");
    }
    // Fields of a solver beside the meshes stay, with --force too.
    fs::write(folder.join("out/90/p"), "a pressure").unwrap();
    rewrite(folder, "s.toml", "s.toml", &[("[0, 45, 90]", "[0, 30]")]);
    succeed(folder, "-q deform in s.toml -o out --force");
    let left = meshes(&folder.join("out"));
    assert!(left.contains_key("30/polyMesh/points") && left.contains_key("90/p"));
    assert!(!left.contains_key("90/polyMesh/points") && !folder.join("out/45").exists());
}

#[test]
fn what_a_case_cannot_take_is_refused() {
    let folder = sphere();
    let folder = folder.path();
    let refused = |args: &str, parts: &[&str]| {
        let before = all_files(folder);
        let run = azimesh(folder, args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.err);
        assert_says(&run.err, parts);
        assert_eq!(all_files(folder), before, "{args:?}");
    };
    refused(
        "deform in s.toml -o in",
        &["this is the case that the mesh is read from"],
    );
    refused(
        "deform in s.toml -o in/constant/out",
        &["is inside the folder constant"],
    );
    refused(
        "convert in in --format openfoam",
        &["in: this is an input, which the output would replace"],
    );
    let plane = Path::new("testdata/naca0012.vtu").canonicalize().unwrap();
    refused(
        &format!("convert {} plane.foam", plane.display()),
        &["--extrude H makes one layer"],
    );
    refused(
        "convert in x.vtu --patch-type spere=wall",
        &["\"spere\" is not in the mesh", "sphere"],
    );
    refused(
        "convert in x.vtu --patch-type sphere=wal",
        &["did you mean wall?"],
    );
    refused(
        "convert in list.pvd --format openfoam",
        &["give its name instead"],
    );
    rewrite(
        folder,
        "s.toml",
        "close.toml",
        &[("[0, 45, 90]", "[0, 90, 90.00000000001]")],
    );
    refused(
        "deform in close.toml -o out",
        &[
            "two steps are at the times 90 and 90.00000000001",
            "would have one folder, 90",
        ],
    );
}

#[cfg(unix)]
#[test]
fn a_folder_is_copied_once_however_many_links_lead_to_it() {
    use std::os::unix::fs::symlink;
    let folder = sphere();
    let folder = folder.path();
    let case = folder.join("in");
    // Each of 40 folders outside what is copied has two links to the next: 2^40 ways through them.
    for i in 0..40 {
        let inside = case.join(format!("outside/{i}"));
        fs::create_dir_all(&inside).unwrap();
        fs::write(inside.join("file"), i.to_string()).unwrap();
        for name in ["a", "b"] {
            symlink(format!("../{}", (i + 1) % 40), inside.join(name)).unwrap();
        }
    }
    symlink("../outside/0", case.join("system/d")).unwrap();
    symlink(".", case.join("system/circle")).unwrap();
    symlink("../constant", case.join("system/constant")).unwrap();
    symlink("nowhere", case.join("system/nowhere")).unwrap();
    symlink("0", case.join("0.orig")).unwrap();
    succeed(folder, "-q deform in s.toml -o out");
    let system = folder.join("out/system");
    for (path, content) in [
        ("d/file", "0"),
        ("d/a/b/a/file", "3"),
        ("circle/circle/d/b/file", "1"),
        ("constant/transportProperties", "nu 1e-5;"),
        ("../0.orig/U", "a field"),
    ] {
        let found = fs::read_to_string(system.join(path));
        assert_eq!(found.ok().as_deref(), Some(content), "{path}");
    }
    let link = fs::read_link(system.join("constant")).unwrap();
    assert_eq!(link, Path::new("../constant"));
    assert!(!system.join("nowhere").is_symlink());
}

#[cfg(unix)]
#[test]
fn a_case_that_cannot_be_copied_is_refused_before_anything_is_written() {
    let folder = sphere();
    let folder = folder.path();
    let inside = folder.join("in/system/inside");
    for (make, parts) in [
        (
            "ln -s ../..",
            &["in/system/inside", "holds the case itself"][..],
        ),
        ("mkfifo", &["in/system/inside", "a pipe"]),
    ] {
        let make = format!("{make} {}", inside.display());
        let made = std::process::Command::new("sh")
            .args(["-c", &make])
            .status();
        assert!(made.unwrap().success());
        let run = azimesh(folder, "deform in s.toml -o out");
        assert_eq!(run.code, 2, "{}", run.err);
        assert_says(&run.err, parts);
        assert!(!folder.join("out").exists());
        fs::remove_file(&inside).unwrap();
    }
}

#[test]
fn what_is_copied_is_staged_until_all_of_it_is_there() {
    let folder = sphere();
    let (read_from, out) = (folder.path().join("in"), folder.path().join("out"));
    let mesh = read(&read_from);
    let case = formats::by_name("openfoam").unwrap().case.unwrap();
    let options = WriteOptions::default();
    let begin = || case.begin(&out, &mesh.view(), &options, Begin::Create, Commit::REPLACE);
    drop(begin().unwrap().staged);
    assert!(!out.exists());
    let files = begin().unwrap().staged;
    assert!(!out.exists());
    files.keep().unwrap();
    assert!(out.join("constant/transportProperties").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_is_truncated_while_it_is_read_ends_the_program_with_its_name() {
    let folder = sphere();
    let folder = folder.path();
    let select = "-q select in s.toml -o base.toml";
    succeed(folder, select);
    let base = fs::read(folder.join("base.toml")).unwrap();
    let pipe = folder.join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_azimesh"));
    let run = run.current_dir(folder);
    let run = run.args([
        "-q", "deform", "in", "s.toml", "-o", "out", "--base", "pipe",
    ]);
    let run = run.stderr(std::process::Stdio::piped()).spawn().unwrap();
    // The program opens the pipe after the mesh, whose files it copies to the new case later.
    let mut opened = fs::OpenOptions::new().write(true).open(&pipe).unwrap();
    let faces = folder.join("in/constant/polyMesh/faces");
    fs::File::options()
        .write(true)
        .open(faces)
        .unwrap()
        .set_len(0)
        .unwrap();
    std::io::Write::write_all(&mut opened, &base).unwrap();
    drop(opened);
    let ended = run.wait_with_output().unwrap();
    let told = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(3), "{told}");
    assert_says(&told, &["in/constant/polyMesh/faces", "became shorter"]);
    let files = all_files(&folder.join("out"));
    assert!(!files.keys().any(|name| name.ends_with(".part")));
}

/// A folder with the case `in` of one layer of an airfoil's cells, and a schedule.
fn layer() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Path::new("testdata/naca0012.vtu").canonicalize().unwrap();
    let args = [
        "-q",
        "convert",
        mesh.to_str().unwrap(),
        "in",
        "--format",
        "openfoam",
        "--extrude",
        "0.1",
    ];
    succeed(folder.path(), args);
    let schedule = fs::read_to_string("testdata/naca0012.toml").unwrap();
    fs::write(folder.path().join("s.toml"), schedule).unwrap();
    folder
}

#[test]
fn a_layer_between_empty_sides_moves_in_its_plane_as_the_plane_mesh_does() {
    let folder = layer();
    let folder = folder.path();
    succeed(folder, "-q deform in s.toml -o out --steps 3..6");
    let at_rest = read(&folder.join("in"));
    let n = at_rest.points.len() / 2;
    let mut moved = 0;
    for time in ["30", "40", "50"] {
        let points = read(&folder.join("out").join(time)).points;
        for (low, high) in (0..n).map(|i| (i, i + n)) {
            assert_eq!(points[low][0].to_bits(), points[high][0].to_bits());
            assert_eq!(points[low][1].to_bits(), points[high][1].to_bits());
            assert_eq!((points[low][2], points[high][2]), (0.0, 0.1));
            moved += usize::from(points[low] != at_rest.points[low]);
        }
    }
    assert!(moved > n, "{moved} of {n}");
}

#[test]
fn a_layer_is_not_moved_out_of_its_plane_nor_held_by_its_sides() {
    let folder = layer();
    let folder = folder.path();
    let schedule = |boundaries: &str, motion: &str| {
        let text = format!(
            "azimuth.values = [0, 90]\nboundaries = {{ {boundaries} }}\n[[body]]\nname = \"airfoil\"\ntags = [\"airfoil\"]\n{motion}\n"
        );
        fs::write(folder.join("w.toml"), text).unwrap();
        azimesh(folder, "deform in w.toml -o out")
    };
    let turn = "rigid = { rotate = { axis = [0, 0, 1], origin = [0, 0, 0], angle = 5.0 } }";
    assert_eq!(schedule("fixed = [\"farfield\"]", turn).code, 0);
    let held = schedule("fixed = [\"farfield\", \"front\"]", turn);
    assert_says(&held.err, &["tag \"front\" is of type empty"]);
    for (motion, says) in [
        ("rigid = { translate = [0.0, 0.1, 0.1] }", "plane"),
        (
            "rigid = { rotate = { axis = [0, 1, 0], origin = [0, 0, 0], angle = 5.0 } }",
            "plane",
        ),
    ] {
        let run = schedule("others = \"fixed\"", motion);
        assert_eq!(run.code, 2, "{motion}: {}", run.err);
        assert_says(&run.err, &["airfoil", says]);
    }
}

/// Files of the pieces that do not change while the mesh moves.
fn topology_of(files: &BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    let mut files = files.clone();
    files.retain(|name, _| name.contains("constant/polyMesh/") && !name.ends_with("/points"));
    files
}

fn same_bits(a: &Mesh, b: &Mesh) -> bool {
    let bits = |mesh: &Mesh| -> Vec<u64> {
        let all = mesh.points.iter().flatten();
        all.map(|x| x.to_bits()).collect()
    };
    bits(a) == bits(b)
}

#[test]
fn a_decomposed_case_is_written_in_its_pieces_and_whole_where_that_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["decomposed", "collated"] {
        let case = Path::new("testdata/openfoam").join(name).canonicalize();
        let case = case.unwrap();
        let input = case.to_str().unwrap();
        let (out, whole) = (folder.join(name), folder.join(format!("{name}_whole")));
        let to = |out: &Path| out.to_str().unwrap().to_owned();
        let args = ["-q", "convert", input, &to(&out), "--format", "openfoam"];
        succeed(folder, args);
        let (before, after) = (all_files(&case), all_files(&out));
        assert_eq!(topology_of(&before), topology_of(&after));
        assert!(!after.contains_key("constant/polyMesh/points"));
        assert!(same_bits(&read(&case), &read(&out)));
        succeed(folder, ["-q", "diff", input, &to(&out)]);
        succeed(
            folder,
            [&args[..3], &[&to(&whole)], &args[4..], &["--pieces", "1"]].concat(),
        );
        let files = all_files(&whole);
        assert!(files.contains_key("constant/polyMesh/points"));
        assert!(!files.keys().any(|name| name.starts_with("processor")));
        assert!(same_bits(&read(&case), &read(&whole)));
        // Other tags than those of the pieces: it is one mesh, and that is said.
        let renamed = format!("{name}_renamed");
        let run = azimesh(
            folder,
            format!("convert {input} {renamed} --format openfoam --rename-tag floor=ground"),
        );
        assert_eq!(run.code, 0, "{}", run.err);
        assert_says(&run.err, &["the mesh is written as one", "decomposePar"]);
        assert!(
            folder
                .join(renamed)
                .join("constant/polyMesh/faces")
                .exists()
        );
    }
    let case = Path::new("testdata/openfoam/decomposed")
        .canonicalize()
        .unwrap();
    let several = azimesh(
        folder,
        [
            "convert",
            case.to_str().unwrap(),
            "x",
            "--format",
            "openfoam",
            "--pieces",
            "3",
        ],
    );
    assert_eq!(several.code, 2);
    assert_says(&several.err, &["--pieces 3", "decomposePar cuts it"]);
}

#[test]
fn a_sequence_of_a_decomposed_case_lies_in_its_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let schedule = "time = { stop = 1.0, step = 0.5, frequency = 1.0 }\noutput.displacement = true\n\
        boundaries.others = \"free\"\nboundaries.fixed = [\"inlet\"]\n[[body]]\nname = \"floor\"\ntags = [\"floor\"]\n\
        rigid = { translate = [0.02, 0.0, 0.03], ramp = true }\n";
    fs::write(folder.join("s.toml"), schedule).unwrap();
    for name in ["decomposed", "collated"] {
        let case = folder.join(name);
        for (file, content) in all_files(&Path::new("testdata/openfoam").join(name)) {
            fs::create_dir_all(case.join(&file).parent().unwrap()).unwrap();
            fs::write(case.join(&file), content).unwrap();
        }
        let piece = match name {
            "decomposed" => "processor1",
            _ => "processors2",
        };
        fs::create_dir_all(case.join("system")).unwrap();
        fs::write(case.join("system/controlDict"), CONTROL).unwrap();
        fs::create_dir_all(case.join(piece).join("0")).unwrap();
        fs::write(case.join(piece).join("0/U"), "a field").unwrap();
        let before = all_files(&case);
        let out = format!("{name}_out");
        let deform = ["-q", "deform", name, "s.toml", "-o", &out];
        succeed(folder, deform);
        let files = all_files(&folder.join(&out));
        assert_eq!(topology_of(&before), topology_of(&files));
        for inside in ["0/U", "0.5/polyMesh/points", "1/wantedDisplacement"] {
            let inside = format!("{piece}/{inside}");
            assert!(files.contains_key(&inside), "{inside}");
        }
        let field =
            String::from_utf8_lossy(&files[&format!("{piece}/1/wantedDisplacement")]).into_owned();
        assert_says(
            &field,
            &["procBoundary1to0\n    {\n        type            processor;"],
        );
        // The positions are those of a run of the whole mesh, bit for bit.
        let vtu = format!("{name}_vtu");
        succeed(
            folder,
            format!("-q deform {name} s.toml -o {vtu} --format vtu"),
        );
        let last = folder.join(&vtu).join(format!("{name}_0002.vtu"));
        assert!(same_bits(&read(&folder.join(&out)), &read(&last)));
        assert!(!same_bits(&read(&folder.join(&out)), &read(&case)));
        succeed(folder, ["-q", "report", &out]);
        // A piece that lost a file is written again.
        let wanted = meshes(&folder.join(&out));
        for lost in [
            "0.5/polyMesh/points",
            "1/wantedDisplacement",
            "constant/polyMesh/points",
            "constant/polyMesh/owner",
        ] {
            fs::remove_file(folder.join(&out).join(piece).join(lost)).unwrap();
            succeed(folder, [&deform[..], &["--resume"]].concat());
            assert_eq!(meshes(&folder.join(&out)), wanted, "{lost}");
        }
        succeed(folder, [&deform[..], &["--force"]].concat());
        assert_eq!(meshes(&folder.join(&out)), wanted);
        assert_eq!(all_files(&case), before);
        // As a sequence of a conversion.
        let again = format!("{name}_again");
        succeed(
            folder,
            format!("-q convert {out} {again} --format openfoam"),
        );
        let own = all_files(&folder.join(&again));
        let points = format!("{piece}/0.5/polyMesh/points");
        assert_eq!(own[&points], files[&points]);
    }
}

#[test]
fn a_report_shows_the_steps_of_a_region_in_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let schedule = "time = { stop = 1.0, step = 0.5, frequency = 1.0 }\nboundaries.others = \"free\"\n\
        boundaries.fixed = [\"inlet\"]\n[[body]]\nname = \"floor\"\ntags = [\"floor\"]\n\
        rigid = { translate = [0.02, 0.0, 0.03], ramp = true }\n";
    fs::write(folder.join("s.toml"), schedule).unwrap();
    for name in ["decomposed", "collated"] {
        let case = folder.join(name);
        for (file, content) in all_files(&Path::new("testdata/openfoam").join(name)) {
            let file = case.join(file.replace("constant/", "constant/solid/"));
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, content).unwrap();
        }
        fs::create_dir_all(case.join("constant/solid")).unwrap();
        let region = format!("{name}/constant/solid");
        let out = format!("{name}_out");
        succeed(folder, ["-q", "deform", &region, "s.toml", "-o", &out]);
        succeed(folder, ["-q", "report", &out]);
        let page = fs::read_to_string(folder.join(&out).join("report.html")).unwrap();
        let n_steps = page.matches("<figcaption><button").count();
        assert!(n_steps > 1 && !page.contains("not shown:"), "{n_steps}");
    }
}

#[test]
fn zones_of_faces_and_points_are_kept_where_pieces_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let case = folder.join("in");
    for (file, content) in all_files(Path::new("testdata/openfoam/decomposed")) {
        fs::create_dir_all(case.join(&file).parent().unwrap()).unwrap();
        fs::write(case.join(&file), content).unwrap();
    }
    let zone = |piece: usize, object: &str, entries: &str| {
        let mesh = case.join(format!("processor{piece}/constant/polyMesh"));
        let head = format!("FoamFile {{ format ascii; class regIOobject; object {object}; }}\n");
        fs::write(
            mesh.join(object),
            format!("{head}1\n(\nzone\n{{ {entries} }}\n)\n"),
        )
        .unwrap();
    };
    // The first face between the pieces, as both have it, and one inside the first of them.
    let faces = |piece: usize| -> usize {
        let path = case.join(format!("processor{piece}/constant/polyMesh/boundary"));
        let text = fs::read_to_string(path).unwrap();
        let shared = text.find("procBoundary").unwrap();
        let start = text[shared..].find("startFace").unwrap() + shared + 9;
        text[start..]
            .trim_start()
            .split(';')
            .next()
            .unwrap()
            .parse()
            .unwrap()
    };
    let (first, second) = (faces(0), faces(1));
    zone(
        0,
        "faceZones",
        &format!("type faceZone; faceLabels List<label> 2(0 {first}); flipMap List<bool> 2(1 0);"),
    );
    zone(
        1,
        "faceZones",
        &format!("type faceZone; faceLabels List<label> 1({second}); flipMap List<bool> 1{{1}};"),
    );
    zone(
        0,
        "pointZones",
        "type pointZone; pointLabels List<label> 2(0 32);",
    );
    zone(
        1,
        "pointZones",
        "type pointZone; pointLabels List<label> 1(0);",
    );
    let args = "-q convert in whole --format openfoam --encoding ascii --pieces 1";
    succeed(folder, args);
    let text = |case: &str, name: &str| {
        fs::read_to_string(folder.join(case).join("constant/polyMesh").join(name)).unwrap()
    };
    let words = |case: &str, name: &str| -> Vec<String> {
        let text = text(case, name).replace(['(', ')', ';'], " ");
        text.split_whitespace().map(str::to_owned).collect()
    };
    let after = |words: &[String], key: &str| -> Vec<usize> {
        let at = words.iter().position(|word| word == key).unwrap() + 2;
        let n: usize = words[at].parse().unwrap();
        words[at + 1..][..n]
            .iter()
            .map(|word| word.parse().unwrap())
            .collect()
    };
    let zone = words("whole", "faceZones");
    let (labels, flips) = (after(&zone, "faceLabels"), after(&zone, "flipMap"));
    assert_eq!((labels.len(), flips.len()), (2, 2));
    // Each is the face of the piece that it was, and turns as the zone has it.
    let mesh = read(&folder.join("whole"));
    let list = words("whole", "faces");
    let start = list.iter().position(|word| word == "}").unwrap() + 2;
    let mut places = vec![start];
    while places.len() <= *labels.iter().max().unwrap() {
        let last = places[places.len() - 1];
        places.push(last + 1 + list[last].parse::<usize>().unwrap());
    }
    let normal = |face: usize| -> [f64; 3] {
        let at = places[face];
        let node = |i: usize| mesh.points[list[at + i].parse::<usize>().unwrap()];
        let [a, b, c] = [node(1), node(2), node(3)];
        let (u, v) = (
            [0, 1, 2].map(|i| b[i] - a[i]),
            [0, 1, 2].map(|i| c[i] - b[i]),
        );
        [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3])
    };
    let mut found: Vec<[f64; 3]> = labels
        .iter()
        .zip(&flips)
        .map(|(face, flip)| normal(*face).map(|x| if *flip == 1 { -x } else { x }))
        .map(|normal| {
            let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            normal.map(|x| (x / size).round())
        })
        .collect();
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let expected = expected_normals(&case, first);
    assert_eq!(found, expected);
    let points = after(&words("whole", "pointZones"), "pointLabels");
    assert_eq!(points, [0, 3, 34]);
}

/// Directions of face 0, turned round, and of this face, of the first piece.
fn expected_normals(case: &Path, face: usize) -> Vec<[f64; 3]> {
    let piece = read(&case.join("processor0"));
    let text = fs::read_to_string(case.join("processor0/constant/polyMesh/faces")).unwrap();
    let body = &text[text.find("\n(\n").unwrap() + 3..];
    let faces: Vec<&str> = body.lines().collect();
    let normal = |face: usize, sign: f64| {
        let nodes = faces[face].split_once('(').unwrap().1.trim_end_matches(')');
        let nodes: Vec<usize> = nodes
            .split_whitespace()
            .map(|node| node.parse().unwrap())
            .collect();
        let [a, b, c] = [0, 1, 2].map(|i| piece.points[nodes[i]]);
        let (u, v) = (
            [0, 1, 2].map(|i| b[i] - a[i]),
            [0, 1, 2].map(|i| c[i] - b[i]),
        );
        let n =
            [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
        let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        n.map(|x| (sign * x / size).round())
    };
    let mut both = vec![normal(0, -1.0), normal(face, 1.0)];
    both.sort_by(|a, b| a.partial_cmp(b).unwrap());
    both
}

#[test]
fn a_change_of_other_tags_keeps_a_wall_without_thickness() {
    let folder = tempfile::tempdir().unwrap();
    let point = |i: u32| [f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6)];
    let mut mesh = Mesh {
        points: (0..12).map(point).collect(),
        ..Mesh::default()
    };
    for cube in [[0, 1, 4, 3, 6, 7, 10, 9], [1, 2, 5, 4, 7, 8, 11, 10]] {
        mesh.cells.push(azimesh::CellKind::Hexahedron, &cube);
    }
    let faces = [
        ("left", [1, 4, 10, 7]),
        ("right", [1, 7, 10, 4]),
        ("in", [0, 6, 9, 3]),
        ("out", [2, 5, 11, 8]),
    ];
    for (at, (name, face)) in faces.into_iter().enumerate() {
        mesh.cells.push(azimesh::CellKind::Quadrilateral, &face);
        mesh.add_tag(name, [at + 2]).unwrap();
    }
    mesh.write(folder.path().join("m.vtu")).unwrap();
    for (from, to, option) in [
        ("m.vtu", "a", &["--patch-type", "left=wall"][..]),
        ("a", "b", &["--merge-tags", "ends=in,out"]),
        ("a", "c", &["--merge-tags", "plate=left,right"]),
        ("c", "cut.pvtu", &["--pieces", "2"]),
        ("cut.pvtu", "d", &[]),
        ("a", "e", &["--drop-tag", "in"]),
    ] {
        let arguments = [&["-q", "convert", from, to], option].concat();
        let format: &[&str] = if to.len() == 1 {
            &["--format", "openfoam"]
        } else {
            &[]
        };
        succeed(folder.path(), [&arguments[..], format].concat());
        let quality = azimesh(folder.path(), ["quality", "--json", to]);
        let json: serde_json::Value = serde_json::from_str(&quality.out).unwrap();
        assert_eq!(json["inner_faces"], 0, "{to}: {json}");
    }
    let boundary = |case: &str| {
        let path = folder.path().join(case).join("constant/polyMesh/boundary");
        let text = fs::read_to_string(path).unwrap();
        let sizes = text.split("nFaces").skip(1).map(|rest| {
            let number = rest.split(';').next().unwrap().trim();
            number.parse().unwrap()
        });
        sizes.collect::<Vec<usize>>()
    };
    assert_eq!(boundary("a"), [1, 1, 1, 1, 8]);
    assert_eq!(boundary("b"), [1, 1, 2, 8]);
    assert_eq!(boundary("c"), [2, 1, 1, 8]);
    assert_eq!(boundary("d"), [2, 1, 1, 8]);
}
