//! `info`, `convert`, `quality` and `diff` from outside, on a mesh of two triangles.

use crate::support::sequence::{Sequence, testdata};
use crate::support::{Args, assert_says, json};
use std::path::Path;
use tempfile::TempDir;

const SQUARE: &str = "NDIME= 2\nNELEM= 2\n5 0 1 2 0\n5 0 2 3 1\nNPOIN= 4\n0 0 0\n1 0 1\n1 1 2\n\
0 1 3\nNMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= far\nMARKER_ELEMS= 3\n\
3 1 2\n3 2 3\n3 3 0\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("square.su2"), SQUARE).unwrap();
    let bent = SQUARE.replace("1 1 2\n", "-1 -0.5 2\n");
    std::fs::write(folder.path().join("bent.su2"), bent).unwrap();
    folder
}

/// Runs the program; gives exit code, stdout and stderr.
fn azimesh(folder: &Path, args: impl Args) -> (i32, String, String) {
    let run = crate::support::azimesh(folder, args);
    (run.code, run.out, run.err)
}

#[test]
fn info_tells_nodes_cells_and_tags() {
    let folder = folder();
    let found = json(folder.path(), "info square.su2");
    assert_eq!(found["version"], 1);
    assert_eq!((&found["nodes"], &found["cells"]), (&4.into(), &6.into()));
    assert_eq!(found["cells_by_kind"]["triangle"], 2);
    assert_eq!(found["boundary_tags"][1]["name"], "far");
    assert_eq!(found["boundary_tags"][1]["faces"], 3);
    assert_eq!(found["faces_without_tag"], 0);
    let (code, text, _) = azimesh(folder.path(), "info square.su2");
    assert_eq!(code, 0);
    assert!(text.contains("boundary tags  2"), "{text}");
}

#[test]
fn convert_scales_and_renames() {
    let folder = folder();
    let options = [
        "--scale",
        "10",
        "--rename-tag",
        "wall=far",
        "--rename-tag",
        "far=wall",
    ];
    let convert = ["convert", "square.su2", "big.su2"];
    assert_eq!(
        azimesh(folder.path(), [&convert[..], &options].concat()).0,
        0
    );
    let found = json(folder.path(), "info big.su2");
    assert_eq!(found["bounds"][1][0], 10.0);
    assert_eq!(found["boundary_tags"][0]["name"], "far");
    let wrong = "convert square.su2 x.su2 --rename-tag wal=w";
    let (code, _, error) = azimesh(folder.path(), wrong);
    assert_eq!(code, 2);
    assert_says(&error, &["wal", "\"wall\""]);
    assert!(!folder.path().join("x.su2").exists());
}

#[test]
fn a_factor_that_would_turn_cells_inside_out_is_refused() {
    let folder = folder();
    for factor in ["-1", "0", "nan", "inf"] {
        let convert = format!("convert square.su2 x.su2 --scale {factor}");
        let (code, _, error) = azimesh(folder.path(), &convert);
        assert_eq!(code, 2, "{error}");
        assert_says(&error, &["--scale", "0"]);
    }
}

/// A square of two triangles whose sides are two physical groups of one name.
const TWINS: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"wall\"\n1 2 \"wall\"\n\
$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n4\n\
1 1 2 1 1 1 2\n2 1 2 2 2 2 3\n3 2 2 7 1 1 2 3\n4 2 2 7 1 1 3 4\n$EndElements\n";

#[test]
fn tags_of_one_name_are_renamed_together_and_merged_with_a_note() {
    let folder = folder();
    std::fs::write(folder.path().join("twins.msh"), TWINS).unwrap();
    let convert = "convert twins.msh x.su2 --rename-tag wall=hub";
    let (code, _, notes) = azimesh(folder.path(), convert);
    assert_eq!(code, 0, "{notes}");
    assert_says(&notes, &["2 tags", "\"hub\""]);
    let found = json(folder.path(), "info x.su2");
    assert_eq!(found["boundary_tags"][0]["faces"], 2);
    let (_, text, _) = azimesh(folder.path(), "info twins.msh");
    let first = "format         Gmsh MSH, text (.msh), version 2.2";
    assert!(text.starts_with(first), "{text}");
    assert!(text.contains("wall         1 face\n"), "{text}");
}

#[test]
fn options_without_effect_are_noted() {
    let folder = folder();
    let packed = ["--encoding", "base64", "--compression", "zlib"];
    for (name, expected) in [("x.vtu", 0), ("x.vtk", 2), ("x.msh", 2), ("x.vtkhdf", 2)] {
        let convert = [&["convert", "square.su2", name][..], &packed].concat();
        let (code, _, notes) = azimesh(folder.path(), &convert);
        assert_eq!(code, 0, "{notes}");
        let n = notes.matches("has no effect on files of format").count();
        assert_eq!(n, expected, "{name}: {notes}");
    }
}

#[test]
fn quality_writes_to_standard_output_in_the_format_that_is_named() {
    let folder = folder();
    let piped = ["quality", "square.su2", "-o", "-", "--format", "vtu"];
    let piped = [&piped[..], &["--encoding", "ascii"]].concat();
    let (code, mesh, table) = azimesh(folder.path(), &piped);
    assert_eq!(code, 0, "{table}");
    assert!(
        mesh.starts_with("<?xml") && mesh.ends_with("</VTKFile>\n"),
        "{mesh}"
    );
    assert!(table.contains("min_scaled_jacobian"), "{table}");
    let named = "quality square.su2 -o x.dat --format vtu";
    assert_eq!(azimesh(folder.path(), named).0, 0);
    assert_eq!(json(folder.path(), "info x.dat")["nodes"], 4);
    let (code, _, error) = azimesh(folder.path(), "quality square.su2 -o -");
    assert_eq!(
        (code, error.contains("give --format")),
        (2, true),
        "{error}"
    );
}

#[test]
fn an_unknown_sample_is_answered_with_those_there_are() {
    let folder = folder();
    for (sample, told) in [
        (&["cylinder"][..], &["naca0012, blade, rotor, block"][..]),
        (
            &["naca0012", "-o", "x.vtu", "--first-cell", "-1"],
            &["1e-9", "0.02", "-1"],
        ),
        (
            &["rotor", "-o", "x.vtu", "--blades", "4", "--nodes", "900"],
            &["4 blades"],
        ),
    ] {
        let (code, _, error) = azimesh(folder.path(), [&["sample"], sample].concat());
        assert_eq!(code, 2, "{error}");
        assert_says(&error, told);
    }
}

#[test]
fn quality_names_inverted_cells_and_fails_on_request() {
    let folder = folder();
    let judge = ["quality", "bent.su2", "--reference", "square.su2"];
    let found = json(folder.path(), [&judge[..], &["--worst", "1"]].concat());
    assert_eq!(found["inverted"], 2);
    assert_eq!(found["inverted_cells"], serde_json::json!([0, 1]));
    assert_eq!(
        found["worst"][0]["tags"],
        serde_json::json!(["wall", "far"])
    );
    assert_eq!(azimesh(folder.path(), judge).0, 0);
    let failing = [&judge[..], &["--fail-on", "inverted>0"]].concat();
    assert_eq!(azimesh(folder.path(), &failing).0, 1);
    let unknown = "quality square.su2 --fail-on invertd>0";
    let (code, _, error) = azimesh(folder.path(), unknown);
    assert_eq!(code, 2);
    assert_says(
        &error,
        &["invertd", "inverted, inverted_reference, min_volume"],
    );
    // A column of a run alone is one, with the reason why a mesh does not have it.
    for (condition, why) in [
        ("max_surface_error>0", "measured against the motion"),
        ("min_first_cell_ratio<1", "which walls move"),
        ("base_points>0", "how the steps were computed"),
        ("time_s>0", "place of a step"),
    ] {
        let refused = format!("quality square.su2 --fail-on {condition}");
        let (code, _, error) = azimesh(folder.path(), &refused);
        assert_eq!(code, 2, "{condition}");
        assert_says(&error, &[condition, why, "steps.csv"]);
    }
}

#[test]
fn every_metric_of_a_step_is_what_quality_says_of_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, schedule) = (testdata("naca0012.vtu"), testdata("naca0012.toml"));
    let run = Sequence::of(folder.path(), &mesh, &schedule, "out");
    let written = folder.path().join("out/naca0012_0009.vtu");
    let args = [
        "quality",
        written.to_str().unwrap(),
        "--reference",
        mesh.to_str().unwrap(),
    ];
    let found = json(folder.path(), args);
    for column in [
        "inverted",
        "inverted_reference",
        "min_volume",
        "min_scaled_jacobian",
        "mean_scaled_jacobian",
        "p01_scaled_jacobian",
        "max_edge_ratio",
        "max_skew",
        "max_non_orthogonality",
        "min_size_skew",
        "mean_size_skew",
        "unproven",
    ] {
        assert_eq!(
            Some(run.numbers(column)[9]),
            found[column].as_f64(),
            "{column}"
        );
    }
}

/// A wedge of positive volume, and the same with its nodes in the other orientation.
const WEDGES: [&str; 2] = ["13 0 1 2 3 4 5 0", "13 0 2 1 3 5 4 0"];

fn wedge(nodes: &str) -> String {
    format!(
        "NDIME= 3\nNELEM= 1\n{nodes}\nNPOIN= 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 1\n0 1 1\nNMARK= 0\n"
    )
}

#[test]
fn openfoam_turns_wedges_of_negative_volume_and_no_others() {
    let folder = folder();
    let folder = folder.path();
    for (nodes, is_turned) in WEDGES.into_iter().zip([false, true]) {
        std::fs::write(folder.join("w.su2"), wedge(nodes)).unwrap();
        let arguments = "convert w.su2 case --format openfoam --force";
        let (code, _, error) = azimesh(folder, arguments);
        assert_eq!(code, 0, "{error}");
        assert_eq!(error.contains("turned round"), is_turned, "{error}");
    }
}

#[test]
fn quality_says_that_a_mesh_is_folded_in_itself() {
    let folder = folder();
    let crossed =
        "NDIME= 2\nNELEM= 1\n9 0 1 2 3 0\nNPOIN= 4\n0 0 0\n1 0 1\n0 1 2\n1 1 3\nNMARK= 0\n";
    std::fs::write(folder.path().join("crossed.su2"), crossed).unwrap();
    let (code, _, error) = azimesh(folder.path(), "quality crossed.su2");
    assert_eq!(code, 0);
    assert_says(&error, &["1 cell is", "inverted_reference", "--reference"]);
}

#[test]
fn cells_in_the_other_orientation_are_named_alike_by_all_commands() {
    let folder = folder();
    let folder = folder.path();
    // The second hexahedron stands on the first; both have their nodes in reverse order.
    let reversed = "NDIME= 3\nNELEM= 2\n12 4 5 6 7 0 1 2 3 0\n12 8 9 10 11 4 5 6 7 1\nNPOIN= 12\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
                    0 0 1\n1 0 1\n1 1 1\n0 1 1\n0 0 2\n1 0 2\n1 1 2\n0 1 2\nNMARK= 0\n";
    std::fs::write(folder.join("r.su2"), reversed).unwrap();
    let (_, told, _) = azimesh(folder, "info r.su2");
    assert_says(
        &told,
        &[
            "2 cells of negative volume",
            "reversed",
            "in the other orientation",
        ],
    );
    let (code, _, error) = azimesh(folder, "quality r.su2");
    assert_eq!(code, 0);
    assert_says(&error, &["2 cells are listed in the other orientation"]);
    assert!(!error.contains("not valid"), "{error}");
    let (code, _, error) = azimesh(folder, "repair r.su2 -o repaired.su2");
    assert_eq!(code, 0);
    assert_says(&error, &["2 cells are listed in the other orientation"]);
    let (code, _, error) = azimesh(folder, "convert r.su2 case --format openfoam");
    assert_eq!(code, 0);
    assert_says(
        &error,
        &[
            "cells are listed in the other orientation",
            "(2)",
            "turned round",
        ],
    );
    let (_, told, _) = azimesh(folder, "info case");
    assert!(!told.contains("negative"), "{told}");
    let (_, _, error) = azimesh(folder, "convert case again --format openfoam");
    assert!(!error.contains("orientation"), "{error}");
}

#[test]
fn quality_writes_cell_arrays() {
    let folder = folder();
    let write = "quality square.su2 -o judged.vtu";
    assert_eq!(azimesh(folder.path(), write).0, 0);
    let found = json(folder.path(), "info judged.vtu");
    let arrays = found["arrays"].as_array().unwrap();
    for name in [
        "ScaledJacobian",
        "Inverted",
        "Condition",
        "MinAngle",
        "Skew",
    ] {
        assert!(arrays.iter().any(|array| array["name"] == name), "{name}");
    }
    assert_eq!(azimesh(folder.path(), write).0, 2);
}

#[test]
fn quality_tells_the_smallest_mean_and_largest_of_every_metric() {
    let folder = folder();
    let found = json(folder.path(), "quality square.su2");
    let metrics = found["metrics"].as_object().unwrap();
    assert_eq!(metrics.len(), 11);
    assert_eq!(metrics["min_angle"]["min"], 45.0);
    assert_eq!(metrics["volume"]["mean"], 0.5);
    let (_, text, _) = azimesh(folder.path(), "quality square.su2");
    assert!(text.contains("\nmin_angle "), "{text}");
    // No triangle has it.
    assert!(!text.contains("\nskew "), "{text}");
}

#[test]
fn quality_of_a_sequence_has_a_row_a_step_and_names_the_step_of_the_worst_cells() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("run")).unwrap();
    let join = "convert square.su2 bent.su2 square.su2 run/all.pvd --format vtu";
    let join: Vec<&str> = join.split(' ').collect();
    assert_eq!(azimesh(folder.path(), &join).0, 0);
    let judge = "quality run --worst 3 --fail-on inverted>0";
    let found = json(folder.path(), judge);
    let steps = found["steps"].as_array().unwrap().iter();
    let inverted: Vec<_> = steps.map(|step| &step["inverted"]).collect();
    assert_eq!(inverted, [0, 2, 0]);
    assert_eq!(found["failed_steps"]["inverted>0"], serde_json::json!([1]));
    let worst = found["worst"].as_array().unwrap();
    let steps: Vec<_> = worst.iter().map(|cell| &cell["step"]).collect();
    assert_eq!(steps, [1, 1, 0]);
    assert_eq!(worst[0]["nearest_tag"], "far");
    let (code, text, error) = azimesh(folder.path(), judge);
    assert_eq!((code, text.lines().count()), (1, 1 + 3 + 1 + 3));
    assert_says(&text, &["worst: step 1 (time 1), ", "nearest tag far"]);
    assert_eq!(found["worst_step"], worst[0]);
    assert_says(&error, &["inverted>0", "step 1"]);
    let (code, _, error) = azimesh(folder.path(), "quality run -o x.vtu");
    assert_eq!(code, 2);
    assert_says(&error, &["-o"]);
}

#[test]
fn quality_of_a_long_sequence_prints_the_worst_steps_first() {
    let folder = folder();
    let path = folder.path();
    std::fs::create_dir(path.join("run")).unwrap();
    let mut join = vec!["convert"];
    join.extend(["square.su2"; 12]);
    join[5] = "bent.su2";
    join.extend(["run/all.pvd", "--format", "vtu"]);
    assert_eq!(azimesh(path, &join).0, 0);
    let (code, text, _) = azimesh(path, "quality run");
    assert_eq!(code, 0);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[1].starts_with("4 "), "{text}");
    assert_says(lines[11], &["10 worst of 12 steps", "--all"]);
    assert!(lines[12].starts_with("worst: step 4 (time 4), "), "{text}");
    let (_, text, _) = azimesh(path, "quality run --all");
    assert_eq!(text.lines().count(), 1 + 12 + 1);
}

#[test]
fn quality_of_a_folder_without_a_sequence_says_what_is_missing() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let (code, _, error) = azimesh(folder.path(), "quality empty");
    assert_eq!(code, 2);
    assert_says(&error, &["empty: ", ".pvd"]);
}
