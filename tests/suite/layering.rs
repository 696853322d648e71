//! Imports point downward only; rooms on one floor do not import each other.

use std::fs;
use std::path::{Path, PathBuf};

/// The floors, top to bottom.
const FLOORS: &[&[&str]] = &[
    &["cli"],
    &["run", "report"],
    &["preflight"],
    &["deform"],
    &["repair"],
    &["motion", "rbf", "quality", "sample"],
    &["modes", "formats", "record"],
    &["mesh"],
    &["linear", "geometry", "ranks"],
    &["diagnostic", "parallel", "progress", "sparse"],
    &["error"],
];

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("src can be listed");
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("src can be listed").path();
        match path.is_dir() {
            true => found.extend(sources(&path)),
            false => found.push(path),
        }
    }
    found
}

/// The rooms named after `crate::` in a source file, each with its line.
fn imports(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("//") {
            continue;
        }
        for rest in line.split("crate::").skip(1) {
            let room: String = rest
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            found.push((number + 1, room));
        }
    }
    found
}

#[test]
fn no_import_points_up_or_sideways() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    let mut looked_at = 0;
    for path in sources(&src) {
        let inside = path.strip_prefix(&src).expect("it was listed there");
        let room = inside
            .components()
            .next()
            .map(|first| first.as_os_str().to_string_lossy().replace(".rs", ""))
            .expect("a file has a name");
        let Some(own) = floor(&room) else { continue };
        let text = fs::read_to_string(&path).expect("sources are text");
        for (line, other) in imports(&text) {
            let Some(below) = floor(&other) else { continue };
            looked_at += 1;
            if other != room && below <= own {
                wrong.push(format!("{}:{line}: {room} imports {other}", path.display()));
            }
        }
    }
    assert!(looked_at > 100, "the test sees the imports");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_room_has_a_floor() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for path in sources(&src) {
        let inside = path.strip_prefix(&src).expect("it was listed there");
        if inside.components().count() > 1 {
            let room = inside.components().next().expect("it has a folder");
            let room = room.as_os_str().to_string_lossy();
            assert!(floor(&room).is_some(), "{room} has no floor");
        }
    }
}
