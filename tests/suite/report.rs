//! `azimesh report` from outside: what is on the page, and what is said when something is missing.

use crate::support::{Args, airfoil, assert_says, azimesh, json, rewrite, succeed};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder with `n.vtu`, and its sequence of seven steps in `out`.
fn sequence() -> TempDir {
    let folder = airfoil();
    let steps = [("step = 10", "step = 60")];
    rewrite(folder.path(), "n.toml", "s.toml", &steps);
    succeed(folder.path(), "-q deform n.vtu s.toml -o out");
    folder
}

fn page(folder: &Path, args: impl Args) -> String {
    let report = ["-q", "report", "out", "-o", "-"];
    succeed(folder, [&report[..], &args.words()].concat()).out
}

/// The data of the cuts.
fn cuts(html: &str) -> &str {
    let (_, text) = html.split_once("id=\"cut-data\">").expect("it has cuts");
    text.split("</script>").next().unwrap_or_default()
}

/// Captions of the still pictures.
fn stills(html: &str) -> Vec<&str> {
    let captions = html
        .split("<div class=\"figures cuts\">")
        .nth(1)
        .unwrap_or_default();
    let captions = captions.split("</section>").next().unwrap_or_default();
    let captions = captions.split("<figcaption>").skip(1);
    captions
        .map(|rest| {
            let inside = rest.split("</figcaption>").next().unwrap_or_default();
            let inside = inside.split("</button>").next().unwrap_or_default();
            inside.rsplit('>').next().unwrap_or_default()
        })
        .collect()
}

#[test]
fn a_page_needs_nothing_else_and_is_the_same_on_any_number_of_threads() {
    let folder = sequence();
    let one = page(folder.path(), "--threads 1");
    assert!(one == page(folder.path(), "--threads 3"));
    let own = one.replace(
        include_str!("../../src/report/vendor/uPlot.iife.min.js"),
        "",
    );
    assert!(own.len() < one.len(), "the library is in the page as it is");
    for outside in ["http:", "https:", "url(", "@import", "src=", "href="] {
        assert!(!own.contains(outside), "{outside}");
    }
    assert!(own.contains("default-src 'none'"));
    assert!(one.len() < 300_000, "{}", one.len());
    for part in [
        "Motion",
        "Pitch",
        "Base points",
        "Errors at the surface",
        "Choice of base points",
        "Scaled Jacobian of the cells",
        "A cut through the mesh",
        "Still pictures",
        "Reference mesh",
        "the worst",
        "Seconds for each step",
        "BLAKE3",
        "support radius",
        "<code id=\"command\">azimesh -q deform n.vtu s.toml -o out</code>",
    ] {
        assert!(one.contains(part), "{part}");
    }
    // The airfoil is in the same place at 0, 180 and 360 degrees, and at 60 and 120, and at 240 and 300.
    assert_eq!(
        stills(&one),
        ["Reference mesh", "Step 1, 60°", "Step 5, 300°, the worst"]
    );
    assert!(
        !one.contains("id=\"scene\""),
        "a plane mesh is seen in the cut alone"
    );
    assert!(!one.contains("class=\"notes\""), "nothing is missing");
}

#[test]
fn a_page_is_replaced_only_with_force() {
    let folder = sequence();
    let said = succeed(folder.path(), "report out");
    assert_says(&said.out, &["out/report.html: ", "7 steps"]);
    let again = azimesh(folder.path(), "report out");
    assert_eq!(again.code, 2);
    assert_says(&again.err, &["out/report.html: ", "--force"]);
    let told = json(folder.path(), "report out --force");
    assert_eq!(
        (told["version"].clone(), told["steps"].clone()),
        (1.into(), 7.into())
    );
    let bytes = fs::metadata(folder.path().join("out/report.html"))
        .unwrap()
        .len();
    assert_eq!(told["bytes"], bytes);
    assert_eq!(told["file"], "out/report.html");
}

#[test]
fn what_is_missing_is_noted_and_nothing_more() {
    let folder = sequence();
    fs::remove_file(folder.path().join("out/n_0003.vtu")).unwrap();
    fs::remove_file(folder.path().join("n.vtu")).unwrap();
    let told = json(folder.path(), "report out");
    let notes = &told["diagnostics"];
    assert_eq!(notes.as_array().unwrap().len(), 2, "{notes:?}");
    let codes = [&notes[0]["code"], &notes[1]["code"]];
    assert_eq!(codes, ["no_reference_shown", "mesh_not_shown"]);
    let text = notes[1]["text"].as_str().unwrap();
    assert_says(text, &["step 3", "out/n_0003.vtu: "]);
    let html = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert_eq!(stills(&html).len(), 3);
}

#[test]
fn a_mesh_that_has_changed_is_no_reference() {
    let folder = sequence();
    fs::copy(
        folder.path().join("out/n_0001.vtu"),
        folder.path().join("n.vtu"),
    )
    .unwrap();
    let html = page(folder.path(), []);
    let notes = html
        .split_once("class=\"notes\"")
        .expect("something is missing")
        .1;
    assert_says(notes, &["reference mesh", "n.vtu: ", "changed"]);
}

#[test]
fn a_mesh_in_pieces_is_the_reference_until_one_has_changed() {
    let folder = sequence();
    let path = folder.path();
    succeed(path, "-q convert n.vtu p.pvtu --pieces 2");
    let deform = ["-q", "deform", "p.pvtu", "s.toml", "-o", "out", "--force"];
    succeed(path, deform);
    assert!(!page(path, ["--force"]).contains("class=\"notes\""));
    let piece = path.join("p/p_1.vtu");
    let mut bytes = fs::read(&piece).unwrap();
    let last = bytes.len() - 300;
    bytes[last] ^= 1;
    fs::write(&piece, bytes).unwrap();
    let html = page(path, "--force");
    assert!(html.contains("class=\"notes\""), "another reference");
    let run = azimesh(path, "deform p.pvtu s.toml -o out --resume");
    assert_eq!(run.code, 2, "{run:?}");
}

#[test]
fn a_sequence_in_one_file_and_one_in_parts_show_the_same_cuts() {
    let folder = sequence();
    let page_of_whole = page(folder.path(), []);
    let whole = cuts(&page_of_whole);
    for format in ["vtkhdf", "cgns"] {
        for parts in [vec![], vec!["0..4", "4..7"]] {
            fs::remove_dir_all(folder.path().join("out")).unwrap();
            let deform = format!("-q deform n.vtu s.toml -o out --format {format}");
            if parts.is_empty() {
                drop(succeed(folder.path(), &deform))
            } else {
                parts.iter().for_each(|part| {
                    succeed(folder.path(), format!("{deform} --steps {part}"));
                })
            }
            assert!(
                cuts(&page(folder.path(), [])) == whole,
                "{format} {parts:?}"
            );
        }
    }
}

#[test]
fn a_blade_is_cut_across_its_span_in_either_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeed(folder, "-q sample blade --nodes 8000 -o b.vtu");
    let steps = [("step = 10", "step = 120")];
    rewrite(folder, "b.toml", "rotating.toml", &steps);
    rewrite(
        folder,
        "b.toml",
        "inertial.toml",
        &[steps[0], ("frame = \"rotating\"", "frame = \"inertial\"")],
    );
    let mut pictures = Vec::new();
    for frame in ["rotating", "inertial"] {
        let schedule = format!("{frame}.toml");
        let args = format!("-q deform b.vtu {schedule} -o out --force");
        succeed(folder, &args);
        let html = page(folder, []);
        assert!(html.contains("The plane x = "), "{frame}");
        let scene = html
            .split_once("id=\"scene-data\">")
            .expect("it has a scene")
            .1;
        let scene = scene.split("</script>").next().unwrap();
        let scene: serde_json::Value = serde_json::from_str(scene).unwrap();
        assert_eq!(scene["bodies"]["frames"], 5, "the reference and four steps");
        let turns: Vec<f64> = serde_json::from_value(scene["turns_deg"].clone()).unwrap();
        let inertial = frame == "inertial";
        assert_eq!(
            turns,
            [0.0, 120.0, 240.0, 360.0].map(|turn| if inertial { turn } else { 0.0 })
        );
        let outer = &scene["others"]["parts"][0];
        assert_eq!(
            (
                outer["name"].as_str(),
                outer["shown"].as_bool(),
                outer["turns"].as_bool()
            ),
            (Some("outer"), Some(false), Some(inertial))
        );
        assert!(
            html == page(folder, "--threads 1"),
            "{frame}: the same bytes"
        );

        assert!(
            html.contains("Flap") && html.contains("Displacement of the tip of blade"),
            "{frame}"
        );
        let (_, cells) = html.split_once("Shown are all ").expect("a sentence");
        let cells = cells
            .split_once(" cells that the plane cuts")
            .expect("a number");
        pictures.push(cells.0.parse::<u32>().expect("a number"));
    }
    assert!(pictures[0] > 20, "{pictures:?}");
    assert_eq!(
        pictures[0], pictures[1],
        "carried round, the cut is the same"
    );
}

#[test]
fn a_folder_that_holds_no_sequence_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    let said = azimesh(folder.path(), "report empty");
    assert_eq!(said.code, 2);
    assert_says(&said.err, &["empty: ", "steps.csv", "run.json"]);
    assert_eq!(azimesh(folder.path(), "report nowhere").code, 2);
}
