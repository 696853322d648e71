//! Commands that look at a mesh and do not move it: they read its outline where a format has it piece by piece, and find the same.

use crate::support::sequence::testdata;
use crate::support::{azimesh, json, rewrite, succeed};

#[test]
fn an_outline_is_checked_and_selected_from_as_the_whole_mesh_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (mesh, schedule) in [
        ("hart_ii", "hart_ii"),
        ("rotor_sector", "rotor_sector_sliding"),
        ("body_in_duct", "body_in_duct"),
        ("wing_on_plane", "wing_on_plane"),
        ("naca0012", "naca0012"),
    ] {
        let from = testdata(&format!("{mesh}.vtu"));
        let schedule = testdata(&format!("{schedule}.toml"));
        let schedule = schedule.to_str().unwrap();
        let found = ["a.vtkhdf", "b.cgns", "c.vtu"].map(|file| {
            let compression = ["--compression", "zlib"];
            let more = match file {
                "c.vtu" => &compression[..],
                _ => &[],
            };
            let convert = ["-q", "convert", from.to_str().unwrap(), file, "--force"];
            succeed(path, &[&convert[..], more].concat());
            let mut checked = json(path, &["check", file, schedule]);
            checked.as_object_mut().unwrap().remove("mapped_bytes");
            let run = azimesh(
                path,
                &[
                    "-v",
                    "select",
                    file,
                    schedule,
                    "-o",
                    file_of(file),
                    "--force",
                ],
            );
            assert_eq!(run.code, 0, "{run:?}");
            let is_whole = file == "c.vtu" || mesh == "naca0012";
            assert_eq!(
                run.err.contains("read whole"),
                is_whole,
                "{mesh}, {file}: {}",
                run.err
            );
            let base = std::fs::read_to_string(path.join(file_of(file))).unwrap();
            let base: Vec<String> = base.lines().map(str::to_owned).collect();
            (checked, base, run.out.replace(file_of(file), ""))
        });
        assert_eq!(found[0], found[2], "{mesh}");
        assert_eq!(found[1], found[2], "{mesh}");
    }
}

fn file_of(mesh: &str) -> &'static str {
    match mesh {
        "a.vtkhdf" => "a.toml",
        "b.cgns" => "b.toml",
        _ => "c.toml",
    }
}

#[test]
fn zones_are_found_in_an_outline_and_cut_from_it_where_they_turn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = [
        "--layers",
        "4",
        "--first-cell",
        "0.01",
        "--surface-nodes",
        "1500",
    ];
    let sample = ["-q", "sample", "rotor", "-o", "r.vtkhdf"];
    succeed(path, &[&sample[..], &size].concat());
    succeed(
        path,
        &[
            "-q",
            "convert",
            "r.vtkhdf",
            "w.vtu",
            "--compression",
            "zlib",
        ],
    );
    let turns = [("frame = \"rotating\"", "frame = \"inertial\"")];
    rewrite(path, "r.toml", "t.toml", &turns);
    let checked = |schedule: &'static str| {
        ["r.vtkhdf", "w.vtu"].map(|file| {
            let run = azimesh(path, &["-v", "check", file, schedule]);
            assert_eq!(run.code, 0, "{run:?}");
            assert_eq!(
                run.err.contains("read whole"),
                file == "w.vtu",
                "{}",
                run.err
            );
            let lines = run.out.lines().filter(|line| !line.contains("memory"));
            lines.map(str::to_owned).collect::<Vec<_>>()
        })
    };
    for schedule in ["r.toml", "t.toml"] {
        let [by_outline, whole] = checked(schedule);
        assert_eq!(by_outline, whole, "{schedule}");
    }
}
