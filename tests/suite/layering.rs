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
    ("crates/azimesh-deform/src", &[&[OTHERS], &["motion"]]),
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

/// The modules named after `crate::` in a source file, each with its line. Types and functions of the root are no modules.
fn imports(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("//") {
            continue;
        }
        for rest in line.split("crate::").skip(1) {
            let name: String = rest
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            if rest[name.len()..].starts_with("::") {
                found.push((number + 1, name));
            }
        }
    }
    found
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
            for (line, other) in imports(&text) {
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
