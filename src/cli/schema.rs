//! Generates docs/schema and the tables of docs/json.md from the types that commands print, if `AZIMESH_UPDATE` is set:
//! `AZIMESH_UPDATE=1 cargo test --lib schema`.

use super::*;
use crate::record::{Diagnostic, RunRecord};
use schemars::generate::{SchemaGenerator, SchemaSettings};
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value, json};
use std::fs;

/// Every schema with its name.
fn schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("info", schema::<info::Info>("azimesh info MESH... --json")),
        (
            "convert",
            schema::<convert::Outputs>("azimesh convert IN OUT --json"),
        ),
        (
            "quality",
            schema::<quality::QualityResult>("azimesh quality MESH --json"),
        ),
        (
            "repair",
            schema::<repair::RepairResult>("azimesh repair MESH -o OUT --json"),
        ),
        (
            "check",
            schema::<check::Checked>("azimesh check MESH SCHEDULE --json"),
        ),
        (
            "select",
            schema::<select::Selected>("azimesh select MESH SCHEDULE -o BASE --json"),
        ),
        (
            "deform",
            schema::<deform::Deformed>("azimesh deform MESH SCHEDULE -o DIR --json"),
        ),
        (
            "finish",
            schema::<deform::Deformed>("azimesh finish DIR --json"),
        ),
        (
            "diff",
            schema::<diff::Differences>("azimesh diff A B --json"),
        ),
        (
            "report",
            schema::<report::Written>("azimesh report DIR --json"),
        ),
        (
            "sample",
            schema::<sample::Sampled>("azimesh sample NAME -o MESH --json"),
        ),
        (
            "completions",
            schema::<completions::Completions>("azimesh completions SHELL --json"),
        ),
        ("man", schema::<man::Manual>("azimesh man --json")),
        (
            "error",
            schema::<context::FailedCommand>("azimesh ... --json, exit code 2 or 3"),
        ),
        ("run", schema::<RunRecord>("run.json, run_A-B.json")),
    ]
}

fn schema<T: JsonSchema>(title: &str) -> Value {
    let mut schema = SchemaGenerator::from(settings()).into_root_schema_for::<T>();
    schema.insert("title".to_owned(), title.into());
    let mut schema = schema.to_value();
    match schema.get_mut("anyOf").and_then(Value::as_array_mut) {
        Some(forms) => forms.iter_mut().for_each(add_common),
        None => add_common(&mut schema),
    }
    schema
}

/// The schema of a note.
fn diagnostic() -> Value {
    let mut schema = SchemaGenerator::from(settings()).into_root_schema_for::<Diagnostic>();
    schema.remove("$schema");
    schema.remove("title");
    schema.to_value()
}

fn settings() -> SchemaSettings {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut settings = settings.with_transform(RecursiveTransform(plain));
    settings.inline_subschemas = true;
    settings
}

/// Adds the common keys of everything that is printed: the version first, notes and warnings last.
fn add_common(form: &mut Value) {
    let version = json!({ "description": "Version of this layout.", "const": 1 });
    let properties = form["properties"].as_object_mut().expect("it is an object");
    properties.shift_insert(0, "version".to_owned(), version);
    let has_own = properties.contains_key("diagnostics");
    if !has_own {
        let about = "Notes and warnings.";
        let notes = json!({ "description": about, "type": "array", "items": diagnostic() });
        properties.insert("diagnostics".to_owned(), notes);
    }
    let required = form["required"]
        .as_array_mut()
        .expect("some keys are always there");
    required.retain(|key| key != "version");
    required.insert(0, "version".into());
    if !has_own {
        required.push("diagnostics".into());
    }
}

/// Removes keywords specific to Rust, forbids other keys, and makes a key that may be absent never null, unless it has a
/// default.
fn plain(schema: &mut Schema) {
    schema.remove("format");
    if let Some(text) = schema.get("description").and_then(Value::as_str) {
        let text = text.replace('\n', " ");
        schema.insert("description".to_owned(), text.into());
    }
    let required = schema.get("required").cloned().unwrap_or_default();
    let required = required.as_array().map_or(&[][..], Vec::as_slice);
    let Some(properties) = schema.get_mut("properties") else {
        return;
    };
    for (key, inside) in properties.as_object_mut().into_iter().flatten() {
        let inside = inside.as_object_mut().expect("a schema is an object");
        let is_nullable = inside.remove("default").is_some() || required.contains(&json!(key));
        if let Some(Value::Array(types)) = inside.get_mut("type")
            && !is_nullable
        {
            inside["type"] = types.swap_remove(0);
        }
    }
    schema.insert("additionalProperties".to_owned(), false.into());
}

/// Returns the type of a value in words.
fn type_name(schema: &Map<String, Value>, plural: bool) -> String {
    if let Some(value) = schema.get("const") {
        return value.to_string();
    }
    let types = &schema["type"];
    let or_null = if types.is_array() { " or null" } else { "" };
    let name = types
        .as_str()
        .or_else(|| types[0].as_str())
        .expect("a type has a name");
    let s = if plural { "s" } else { "" };
    let name = match (name, schema.get("items")) {
        ("array", Some(Value::Object(items))) => {
            let length = schema
                .get("minItems")
                .map_or(String::new(), |n| format!(" of {n}"));
            format!("list{s}{length} of {}", type_name(items, true))
        }
        ("string", _) => "text".to_owned(),
        ("boolean", _) => "true, false".to_owned(),
        _ => format!("{name}{s}"),
    };
    name + or_null
}

/// The rows of a table. Keys that an earlier table has are named, not repeated.
#[derive(Default)]
struct Rows<'a> {
    text: String,
    /// Objects that already have rows, with the words that refer to them.
    known: Vec<(String, &'a Map<String, Value>)>,
}

impl<'a> Rows<'a> {
    /// Adds the keys of a schema. `place` names the table for later ones.
    fn add(&mut self, schema: &'a Value, path: &str, place: &str) {
        if let Some(keys) = schema["properties"].as_object() {
            let mut new: Vec<_> = keys.iter().collect();
            // The page describes these keys once for all.
            new.retain(|(key, _)| {
                !path.is_empty() || !["version", "diagnostics"].contains(&&***key)
            });
            while let Some((words, known)) = self.most_alike(&new) {
                let is_known = |key: &&(&String, &Value)| known.get(key.0) == Some(key.1);
                let repeated: Vec<&String> = new.iter().filter(is_known).map(|key| key.0).collect();
                self.text += &format!("| {} | | As in {words}. |\n", list(path, &repeated, known));
                new.retain(|key| !is_known(&key));
            }
            let stem = path.trim_end_matches('.');
            let at = if path.is_empty() {
                String::new()
            } else {
                format!("`{stem}` of ")
            };
            self.known.push((at + place, keys));
            for (key, inside) in new {
                let required = schema["required"].as_array();
                let is_required = required.is_some_and(|all| all.contains(&json!(key)));
                self.text += &row(&format!("{path}{key}"), inside, is_required);
                self.add(inside, &format!("{path}{key}."), place);
            }
        }
        let stem = path.trim_end_matches('.');
        for (kind, suffix) in [("items", "[]."), ("additionalProperties", ".*.")] {
            if let Some(inside) = schema.get(kind) {
                self.add(inside, &format!("{stem}{suffix}"), place);
            }
        }
    }

    /// Finds the known object that shares most of some keys: at least three.
    fn most_alike(&self, keys: &[(&String, &Value)]) -> Option<(String, &'a Map<String, Value>)> {
        let count = |known: &Map<String, Value>| {
            let shared = keys.iter().filter(|key| known.get(key.0) == Some(key.1));
            shared.count()
        };
        let alike = self.known.iter().filter(|(_, known)| count(known) > 2);
        alike.rev().max_by_key(|(_, known)| count(known)).cloned()
    }
}

/// Lists keys in words: the first and the last of a run in a known object, or all.
fn list(path: &str, keys: &[&String], known: &Map<String, Value>) -> String {
    let place = |key: &String| known.keys().position(|other| other == key);
    let is_run = keys
        .windows(2)
        .all(|two| place(two[0]).map(|n| n + 1) == place(two[1]));
    match keys {
        [first, .., last] if is_run => format!("`{path}{first}` to `{path}{last}`"),
        _ => {
            let all: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
            let stem = path.trim_end_matches('.');
            let of = if stem.is_empty() {
                String::new()
            } else {
                format!(" of `{stem}`")
            };
            all.join(", ") + &of
        }
    }
}

/// The row of a key.
fn row(name: &str, schema: &Value, is_required: bool) -> String {
    let presence = if is_required { "" } else { "?" };
    let values = schema["enum"].as_array().map_or(String::new(), |values| {
        let named = values.iter().filter_map(Value::as_str);
        let named: Vec<String> = named.map(|value| format!("`{value}`")).collect();
        format!(" One of {}.", named.join(", "))
    });
    let description = schema["description"]
        .as_str()
        .expect("every field is documented");
    let kind = type_name(schema.as_object().expect("a schema is an object"), false);
    format!("| `{name}`{presence} | {kind} | {description}{values} |\n")
}

/// Adds the part of the page about a schema.
fn section<'a>(rows: &mut Rows<'a>, name: &str, schema: &'a Value) {
    let heading = if name == "run" { "run.json" } else { name };
    let text = |value: &Value| value["description"].as_str().unwrap_or_default().to_owned();
    let title = schema["title"].as_str().unwrap_or_default();
    rows.text += &format!(
        "\n## {heading}\n\n`{title}` · [schema](schema/{name}.json)\n\n{}\n",
        text(schema)
    );
    let heading = format!("[{heading}](#{})", heading.replace('.', ""));
    let mut table = |schema: &'a Value, label: &str, place: &str| {
        rows.text += &format!("{label}\n| key | type | |\n|---|---|---|\n");
        rows.add(schema, "", place);
    };
    match schema["anyOf"].as_array() {
        None => table(schema, "", &heading),
        Some(forms) => {
            for form in forms {
                let of = text(form);
                let of = of.trim_end_matches('.');
                let place = format!("{heading}, {}", of.to_lowercase());
                table(form, &format!("\n{of}:\n"), &place);
            }
        }
    }
}

#[test]
fn docs_have_the_schemas_and_tables_of_the_types() {
    let page = fs::read_to_string("docs/json.md").expect("it is there");
    let (head, _) = page.split_once("\n## ").expect("it has sections");
    let schemas = schemas();
    let diagnostic = diagnostic();
    let mut rows = Rows::default();
    rows.text += "\n## diagnostics\n\n| key | type | |\n|---|---|---|\n";
    rows.add(&diagnostic, "", "[diagnostics](#diagnostics)");
    for (name, schema) in &schemas {
        section(&mut rows, name, schema);
    }
    let mut wanted = vec![("docs/json.md".to_owned(), head.to_owned() + &rows.text)];
    for (name, schema) in &schemas {
        wanted.push((format!("docs/schema/{name}.json"), format!("{schema:#}\n")));
    }
    let is_update = std::env::var_os("AZIMESH_UPDATE").is_some();
    for (path, text) in wanted {
        if is_update {
            fs::write(&path, &text).expect("docs can be written");
        }
        let found = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == text,
            "{path} is stale: AZIMESH_UPDATE=1 cargo test --lib schema"
        );
    }
}
