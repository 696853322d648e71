//! Makes docs/schema and the tables of docs/json.md from the types that commands print. They are written anew where
//! `AZIMESH_UPDATE` is set: `AZIMESH_UPDATE=1 cargo test --lib schema`.

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

/// Adds the keys of everything that is printed: the version is the first, notes and warnings are the last.
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

/// Removes what is of Rust alone, says that there are no other keys, and that a key that may be absent is never null: only
/// one with a default may be both.
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

/// The type of a value in words.
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

/// Rows of a table for the keys of a schema, but for those that the page describes once for all.
fn rows(schema: &Value, path: &str) -> String {
    let mut text = String::new();
    for (key, inside) in schema["properties"].as_object().into_iter().flatten() {
        if path.is_empty() && ["version", "diagnostics"].contains(&&**key) {
            continue;
        }
        let required = schema["required"].as_array();
        let is_required = required.is_some_and(|all| all.contains(&json!(key)));
        let presence = if is_required { "" } else { " (not always)" };
        let values = inside["enum"].as_array().map(|values| {
            let named = values.iter().filter_map(Value::as_str);
            named
                .map(|value| format!("`{value}`"))
                .collect::<Vec<_>>()
                .join(", ")
        });
        let description = inside["description"]
            .as_str()
            .expect("every field is documented");
        text += &format!(
            "| `{path}{key}`{presence} | {} | {description}{} |\n",
            type_name(inside.as_object().expect("a schema is an object"), false),
            values.map_or(String::new(), |values| format!(" One of {values}."))
        );
        if key != "diagnostics" {
            text += &rows(inside, &format!("{path}{key}."));
        }
    }
    let stem = path.trim_end_matches('.');
    text + &(schema.get("items")).map_or(String::new(), |items| rows(items, &format!("{stem}[].")))
        + &(schema.get("additionalProperties"))
            .map_or(String::new(), |all| rows(all, &format!("{stem}.*.")))
}

fn table(schema: &Value) -> String {
    format!("\n| key | type | |\n|---|---|---|\n{}", rows(schema, ""))
}

/// The part of the page about a schema.
fn section(name: &str, schema: &Value) -> String {
    let heading = if name == "run" { "run.json" } else { name };
    let text = |value: &Value| value["description"].as_str().unwrap_or_default().to_owned();
    let title = schema["title"].as_str().unwrap_or_default();
    let mut section = format!(
        "\n## {heading}\n\n`{title}` · [schema](schema/{name}.json)\n\n{}\n",
        text(schema)
    );
    match schema["anyOf"].as_array() {
        None => section += &table(schema),
        Some(forms) => {
            let first = rows(&forms[0], "");
            for form in forms {
                let (mut own, mut known) = (table(form), String::new());
                for key in form["properties"].as_object().into_iter().flatten() {
                    // Items of a list may have all keys of the first form.
                    let path = format!("{}[].", key.0);
                    let of_items = first.replace("| `", &format!("| `{path}"));
                    if own.contains(&of_items) {
                        own = own.replace(&of_items, "");
                        known = format!(" In `{path}` are all keys of the first form too.");
                    }
                }
                let about = text(form);
                let about = about.trim_end_matches('.');
                section += &format!("\n{about}.{known}\n{own}");
            }
        }
    }
    section
}

#[test]
fn docs_have_the_schemas_and_tables_of_the_types() {
    let page = fs::read_to_string("docs/json.md").expect("it is there");
    let (head, _) = page.split_once("\n## ").expect("it has sections");
    let schemas = schemas();
    let mut text = format!("{head}\n## diagnostics\n{}", table(&diagnostic()));
    let mut seen: Vec<(&str, &str)> = Vec::new();
    let sections: Vec<String> = schemas
        .iter()
        .map(|(name, schema)| section(name, schema))
        .collect();
    for ((name, _), section) in schemas.iter().zip(&sections) {
        // A table that is on the page already is not repeated.
        let (start, table) = section.split_once("\n| key").expect("it has a table");
        text += start;
        match seen.iter().find(|(_, known)| *known == table) {
            Some((as_of, _)) => text += &format!("\nThe keys of [{as_of}](#{as_of}).\n"),
            None => {
                text += &format!("\n| key{table}");
                seen.push((name, table));
            }
        }
    }
    let mut wanted = vec![("docs/json.md".to_owned(), text)];
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
