//! The report as a whole: sections of every kind of cell, pictures that stay small, tables and folders as
//! runs leave them.

use super::cut::{Cut, Flat, Plane, Window};
use super::folder::Sequence;
use super::table::Table;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, cross, dot, scale, unit};
use azimesh_io::formats::ReadOptions;
use azimesh_io::mesh::Mesh;
use azimesh_quality::{Reference, per_cell};
use std::path::Path;

fn mesh(name: &str) -> Mesh {
    let path = Path::new("testdata").join(name);
    Mesh::read(path).expect("it is good")
}

fn plane(normal: Vector, height: f64) -> Plane {
    let normal = unit(normal).expect("it has a length");
    let right = unit(cross([0.3, 1.0, -0.2], normal)).expect("they are not parallel");
    Plane {
        origin: scale(normal, height),
        normal,
        right,
        up: cross(normal, right),
    }
}

const EVERYTHING: Window = Window {
    centre: [0.0; 2],
    half: [1e9; 2],
};

fn area(corners: &[Flat]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let pairs = corners.iter().zip(next);
    0.5 * pairs
        .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
        .sum::<f64>()
        .abs()
}

/// Cavalieri's principle, cell by cell: the areas of many cuts add up to the volume.
#[test]
fn cuts_through_cells_of_every_kind_add_up_to_their_volumes() {
    const CUTS: usize = 400;
    for name in ["mixed_cells_base64.vtu", "polyhedra_ascii.vtu"] {
        let mesh = mesh(name);
        let volume = per_cell(&mesh, &mesh.points, &Reference::new(&mesh)).volume;
        for normal in [[1.0, 0.7, 0.3], [0.0, 0.0, 1.0]] {
            let along = plane(normal, 0.0).normal;
            let heights = mesh.points.iter().map(|x| dot(*x, along));
            let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            });
            let step = (high - low) / CUTS as f64;
            let mut swept = vec![0.0; mesh.cells.len()];
            for i in 0..CUTS {
                let plane = plane(normal, low + (i as f64 + 0.5) * step);
                for piece in Cut::new(&mesh, plane).pieces(&EVERYTHING) {
                    swept[piece.cell] += step * area(&piece.corners);
                }
            }
            let size = volume
                .iter()
                .copied()
                .filter(|v| !v.is_nan())
                .fold(0.0, f64::max);
            for (cell, (swept, volume)) in swept.iter().zip(&volume).enumerate() {
                let kind = mesh.cells.get(cell).kind.name();
                let expected = if volume.is_nan() { 0.0 } else { volume.abs() };
                assert!(
                    (swept - expected).abs() < 0.01 * size,
                    "{name}: {kind} {cell}: {swept}, {expected}"
                );
            }
        }
    }
}

#[test]
fn a_plane_through_nodes_cuts_no_cell_twice_and_leaves_no_gap() {
    let mesh = mesh("block.vtu");
    let flat = Cut::new(&mesh, plane([0.0, 0.0, 1.0], 0.0)).pieces(&EVERYTHING);
    assert_eq!(
        flat.len(),
        mesh.volume_runs().map(|run| run.n_cells()).sum::<usize>()
    );
    let mesh = self::mesh("mixed_cells_base64.vtu");
    let bounds = Bounds::around(&mesh.points);
    for part in [0.0, 0.25, 0.5, 1.0] {
        let height = bounds.low[2] + part * (bounds.high[2] - bounds.low[2]);
        let pieces = Cut::new(&mesh, plane([0.0, 0.0, 1.0], height)).pieces(&EVERYTHING);
        let mut cells: Vec<usize> = pieces.iter().map(|piece| piece.cell).collect();
        cells.dedup();
        assert_eq!(cells.len(), pieces.len(), "convex cells have one piece");
        let total: f64 = pieces.iter().map(|piece| area(&piece.corners)).sum();
        let near = Cut::new(&mesh, plane([0.0, 0.0, 1.0], height - 1e-9)).pieces(&EVERYTHING);
        let expected: f64 = near.iter().map(|piece| area(&piece.corners)).sum();
        assert!(
            (total - expected).abs() < 1e-6 || part == 0.0,
            "{part}: {total}, {expected}"
        );
    }
}

#[test]
fn the_outline_of_a_body_is_closed() {
    let mesh = mesh("wing_on_plane.vtu");
    let tags = vec!["wing".to_owned()];
    let outline = Cut::new(&mesh, plane([0.0, 0.0, 1.0], 0.4)).outline(&tags);
    assert!(outline.len() > 8, "{}", outline.len());
    let same = |a: Flat, b: Flat| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
    for end in outline.iter().flatten() {
        let here = outline.iter().flatten().filter(|other| same(**other, *end));
        assert_eq!(here.count(), 2);
    }
}

const TABLE: &str = "step,azimuth_deg,file\n0,0,\"a,b.vtu\"\n1,10,c\"\"\"d,e\".vtu\r\n2,20,\n";

fn sequence(files: &[(&str, &str)]) -> Result<Sequence, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("it can be written");
    }
    Sequence::read(folder.path()).map_err(|error| error.to_string())
}

fn table(text: &str) -> Table {
    sequence(&[("steps.csv", text)]).expect("it is good").table
}

#[test]
fn a_table_is_read_with_its_quotes_and_without_a_row_that_was_cut_short() {
    let whole = table(TABLE);
    assert_eq!(whole.text(0, "file"), "a,b.vtu");
    assert_eq!(whole.text(1, "file"), "c\"d,e.vtu");
    assert_eq!(
        whole.numbers("azimuth_deg"),
        [Some(0.0), Some(10.0), Some(20.0)]
    );
    assert!(!whole.has("max_skew"));
    let half = format!("{TABLE}3,3");
    assert_eq!(table(&half).len(), 3);
    for (wrong, told) in [
        ("3,30\n", "steps.csv:5: a row of 2 values under 3 columns"),
        (
            "3,east,\n",
            "steps.csv:5: azimuth_deg is \"east\"; it should be a number",
        ),
    ] {
        let error = sequence(&[("steps.csv", &format!("{TABLE}{wrong}"))]).err();
        assert!(
            error.as_ref().is_some_and(|error| error.ends_with(told)),
            "{error:?}"
        );
    }
}

/// The page of a folder with these files, none of them a mesh.
fn page(steps: &str, record: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("steps.csv"), steps).expect("it can be written");
    std::fs::write(folder.path().join("run.json"), record).expect("it can be written");
    let page = super::page(folder.path(), &ReadOptions::default());
    page.expect("it can be made").html
}

#[test]
fn steps_passed_over_and_checks_that_failed_are_on_the_page() {
    let record = r#"{"outcome": "complete but for 1 steps", "steps": 3, "steps_written": 2, "dimension": 2,
        "skipped_steps": ["step 2 has 4 inverted cells; passed over"], "failures": [FAILURE],
        "options": {"kernel": "wendland-c2", "tag_array": null}, "seconds": {"total": 0.0074197},
        "motion": {"frame": "rotating", "bodies": [{"name": "blade_1", "pitch_deg": [0, 1, 2]}]}}"#;
    let steps = "step,azimuth_deg,inverted,min_volume\n0,0,0,0.5\n1,10,0,0.25\n";
    let failure = r#"{"code": "x", "message": "step 1: max_skew>0.1", "metric": null, "value": null, "limit": null, "step": 1}"#;
    let html = page(steps, &record.replace("FAILURE", failure));
    for told in [
        "complete but for 1 steps",
        "0 in the 2 written<",
        "1 step was skipped",
        "step 2 has 4 inverted cells; passed over",
        "1 check failed",
        "step 1: max_skew&gt;0.1",
        "Smallest area, mesh units²",
        ">blade_1: pitch, degrees<",
        ">0.007<",
    ] {
        assert!(html.contains(told), "{told}");
    }
    for wrong in ["tag array", "Blade_1", "smallest volume", "not evaluated"] {
        assert!(!html.contains(wrong), "{wrong}");
    }
    let html = page(
        "step,azimuth_deg,inverted\n0,0,\n",
        "{\"outcome\": \"complete\"}",
    );
    assert!(html.contains("<dd>not evaluated</dd>"));
}

#[test]
fn title_and_unit_are_those_of_the_schedule_and_the_summary_comes_before_hashes() {
    let record = r#"{"outcome": "complete", "title": "M427 <hover>", "length_unit": "mm", "dimension": 3,
        "inputs": [{"what": "mesh", "file": "m427.cgns", "blake3": "00ff"}], "options": {"tolerance": 0.01},
        "motion": {"frame": "rotating", "bodies": [{"name": "b1", "pitch_deg": [0, 7.5], "max_displacement": [0, 12.3456]},
            {"name": "b2", "pitch_deg": [0, 7.5], "max_displacement": [0, 12.3456]}]}}"#;
    let steps = "step,azimuth_deg,base_points,max_surface_error,min_volume,min_scaled_jacobian,inverted\n\
                 0,0,9,0,0.5,0.5,0\n1,10,9,0.001,0.25,0.25,0\n";
    let html = page(steps, record);
    let order = [
        "<h1>M427 &lt;hover&gt;</h1>",
        "m427, a mesh in motion",
        "<li>2 steps, azimuth 0 to 10°.</li>",
        "<li>b1, b2: moved by up to 12.3 mm, pitch 0° to 7.5°.</li>",
        "within 0.001 mm of where the motion puts them (tolerance 0.01); 9 base points",
        "smallest scaled Jacobian is 0.25, at step 1",
        "No cell is inverted",
        "<dl class=\"tiles\">",
        "id=\"step\"",
        "Smallest volume",
        "<summary>Every value in steps.csv</summary>",
        "Smallest volume, mm³",
        "BLAKE3 00ff",
        "<footer>",
    ];
    let mut from = 0;
    for told in order {
        let at = html[from..].find(told);
        from += at.unwrap_or_else(|| panic!("{told} is missing or in the wrong place"));
    }
    assert!(!html.contains("mesh units"));
    assert!(!html.contains("id=\"scene\""), "there is no mesh to show");
}

#[test]
fn parts_of_a_sequence_are_put_in_order() {
    let part = |from: usize| {
        format!(
            "step,azimuth_deg\n{from},{from}0\n{},{}0\n",
            from + 1,
            from + 1
        )
    };
    let one = r#"{"code": "one", "level": "warning", "text": "a", "path": null, "line": null, "data": {}}"#;
    let two = one.replace("one", "two");
    let record = r#"{"outcome": "complete", "steps": 12, "steps_written": 2, "diagnostics": [ONE], "seconds": {"total": 1.5}}"#;
    let both = record.replace("ONE", "ONE, TWO").replace("1.5", "2.0");
    let running = r#"{"outcome": "running", "steps": 12}"#;
    let files = [
        ("steps_10-12.csv", part(10)),
        ("steps_9-11.csv", part(9)),
        ("steps_0-2.csv", part(0)),
        ("run_0-2.json", record.replace("ONE", one)),
        (
            "run_9-11.json",
            both.replace("ONE", one).replace("TWO", &two),
        ),
        ("run_10-12.json", running.to_owned()),
    ];
    let files: Vec<(&str, &str)> = files
        .iter()
        .map(|(name, text)| (*name, text.as_str()))
        .collect();
    let read = sequence(&files).expect("they fit");
    let steps: Vec<usize> = (0..read.table.len())
        .map(|row| read.table.step(row))
        .collect();
    assert_eq!(steps, [0, 1, 9, 10, 11]);
    let codes: Vec<String> = read
        .end()
        .diagnostics
        .into_iter()
        .map(|note| note.code)
        .collect();
    assert_eq!(codes, ["one", "two"]);
    assert_eq!(read.state(), "not finished");
    assert_eq!(read.record.seconds.map(|seconds| seconds.total), Some(3.5));
    assert!(
        read.notes
            .iter()
            .any(|note| note.text.starts_with("Finished steps: 5 of the 12")),
        "{:?}",
        read.notes
    );
}

#[test]
fn a_folder_without_a_sequence_is_refused() {
    let told = sequence(&[("mesh.vtu", "")]).err().expect("it is empty");
    assert!(
        told.contains("holds neither steps.csv nor run.json"),
        "{told}"
    );
    let told = sequence(&[("run.json", "{\n\"steps\": \"all\"}")])
        .err()
        .expect("it is wrong");
    assert!(
        told.contains("run.json:2: this is not the record of a run"),
        "{told}"
    );
    let file = Sequence::read(Path::new("testdata/block.vtu"))
        .err()
        .expect("it is a file");
    assert!(
        file.to_string().contains("this is a file; give the folder"),
        "{file}"
    );
}

#[test]
fn a_sequence_without_meshes_has_a_page_that_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = "step,azimuth_deg,file,min_scaled_jacobian\n0,0,a.vtu,0.5\n1,10,b.vtu,0.25\n";
    std::fs::write(folder.path().join("steps.csv"), steps).expect("it can be written");
    let page = super::page(folder.path(), &ReadOptions::default()).expect("it can be made");
    assert_eq!(page.n_steps, 2);
    assert!(
        page.notes
            .iter()
            .any(|note| note.text.starts_with("No mesh is shown:")),
        "{:?}",
        page.notes
    );
    assert!(page.html.contains("There is no run.json"));
}
