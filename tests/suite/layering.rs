//! Modules of a crate import from layers below their own, never from their own layer or from above. Crates import as
//! their Cargo.toml allows.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules that are not listed.
const OTHERS: &str = "*";

/// The source of each crate, with its layers from top to bottom. `OTHERS` may import each other.
const CRATES: &[(&str, &[&[&str]])] = &[
    (
        "src",
        &[
            &["cli"],
            &["run", "report"],
            &["preflight"],
            &["record", "sample", "alloc"],
        ],
    ),
    (
        "crates/azimesh-deform/src",
        &[
            &["deformation", "morph"],
            &["step"],
            &["base"],
            &[OTHERS],
            &["motion"],
        ],
    ),
    ("crates/azimesh-quality/src", &[&["repair"], &[OTHERS]]),
    ("crates/azimesh-rbf/src", &[&[OTHERS], &["modes"]]),
    ("crates/azimesh-io/src", &[&["formats"], &["mesh"]]),
    (
        "crates/azimesh-core/src",
        &[
            &["linear", "geometry", "ranks"],
            &["note", "numbers", "parallel", "progress", "sparse"],
            &["error"],
        ],
    ),
];

fn layer(layers: &[&[&str]], module: &str) -> Option<usize> {
    let of = |name: &str| layers.iter().position(|modules| modules.contains(&name));
    of(module).or_else(|| of(OTHERS))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder can be listed");
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}

/// The modules of the root that a source file names, each with its line: after `crate::`, alone or in braces, and after as
/// many `super::` as the file has modules above it. Types and functions of the root are not modules.
fn imports(text: &str, depth: usize) -> Vec<(usize, String)> {
    let roots = ["crate::".to_owned(), "super::".repeat(depth)];
    let mut found = Vec::new();
    for root in roots.iter().filter(|root| !root.is_empty()) {
        for (at, _) in text.match_indices(root.as_str()) {
            let line = text[..at].matches('\n').count() + 1;
            let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
            let before = text[start..at].trim_start();
            if before.starts_with("//") || before.ends_with("super::") {
                continue;
            }
            let rest = &text[at + root.len()..];
            let names = match rest.strip_prefix('{') {
                Some(group) => members(group),
                None => vec![rest],
            };
            found.extend(names.iter().filter_map(|name| {
                let end = name.find(|c: char| !c.is_alphanumeric() && c != '_')?;
                let is_module = name[end..].starts_with("::");
                is_module.then(|| (line, name[..end].to_owned()))
            }));
        }
    }
    found
}

/// The members of a group of imports, which starts behind its brace.
fn members(group: &str) -> Vec<&str> {
    let mut depth = 0;
    let mut found = vec![group.trim_start()];
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => found.push(group[at + 1..].trim_start()),
            _ => {}
        }
    }
    found
}

/// Modules from the root to the module of a file.
fn depth(inside: &Path) -> usize {
    let is_folder = inside.ends_with("mod.rs");
    inside.components().count() - usize::from(is_folder)
}

#[test]
fn imports_are_found_in_groups_and_behind_super() {
    let text = "use crate::{a::X, b::{Y, Z}};\nuse super::super::c::X;\nuse super::d::X;\n// crate::e::X\nuse crate::F;\n";
    let names: Vec<(usize, String)> = imports(text, 2);
    let wanted = [(1, "a"), (1, "b"), (2, "c")].map(|(line, name)| (line, name.to_owned()));
    assert_eq!(names, wanted);
}

#[test]
fn no_import_points_up_or_sideways() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wrong = Vec::new();
    let mut looked_at = 0;
    for (folder, layers) in CRATES {
        let src = root.join(folder);
        for path in sources(&src) {
            let inside = path.strip_prefix(&src).expect("it was listed there");
            let module = inside.components().next().expect("a file has a name");
            let module = module.as_os_str().to_string_lossy().replace(".rs", "");
            let Some(own) = layer(layers, &module) else {
                continue;
            };
            let are_others = layers[own].contains(&OTHERS);
            let text = fs::read_to_string(&path).expect("sources are text");
            for (line, other) in imports(&text, depth(inside)) {
                let Some(below) = layer(layers, &other) else {
                    continue;
                };
                looked_at += 1;
                let is_peer = below == own && !are_others;
                if other != module && (below < own || is_peer) {
                    wrong.push(format!(
                        "{}:{line}: {module} imports {other}",
                        path.display()
                    ));
                }
            }
        }
    }
    assert!(looked_at > 100, "the test sees the imports");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_of_the_program_has_a_layer() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (folder, layers) in CRATES {
        for entry in fs::read_dir(root.join(folder)).expect("the folder can be listed") {
            let path = entry.expect("the folder can be listed").path();
            let name = path.file_name().expect("it has a name").to_string_lossy();
            assert!(
                !path.is_dir() || layer(layers, &name).is_some(),
                "{name} of {folder} has no layer"
            );
        }
    }
}
