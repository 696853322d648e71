//! The tables of docs/schedule.md and the JSON schema of the schedule, both made from the keys.

use crate::motion::body::Body;
use crate::motion::boundaries::Boundaries;
use crate::motion::keys::{Key, Keys};
use crate::motion::motions::{NamedColumns, Rigid};
use crate::motion::options::{RbfOptions, SelectionOptions};
use crate::motion::output::OutputOptions;
use crate::motion::ramp::Ramp;
use crate::motion::reader::{Lines, Section};
use crate::motion::steps::{Azimuths, Times};
use crate::motion::{
    AxisRotation, Beam, Cyclic, Modes, Rotor, Schedule, SurfaceMotion, TableMotion, Translation,
};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Debug;
use std::path::Path;
use toml::de::DeTable;

const TABLES: [(&str, &[Key]); 18] = [
    ("the schedule", Schedule::KEYS),
    ("`[azimuth]`", Azimuths::KEYS),
    ("`[time]`", Times::KEYS),
    ("`[rotor]`", Rotor::KEYS),
    ("`[[body]]`", Body::KEYS),
    ("`ramp`", Ramp::KEYS),
    ("`[body.cyclic]`", Cyclic::KEYS),
    ("`[body.rigid]`", Rigid::KEYS),
    ("`rotate`", AxisRotation::KEYS),
    ("`translate`", Translation::KEYS),
    ("`[body.table]`", TableMotion::KEYS),
    ("`[body.beam]`", Beam::KEYS),
    ("`[body.surface]`", SurfaceMotion::KEYS),
    ("`[body.modes]`", Modes::KEYS),
    ("`[boundaries]`", Boundaries::KEYS),
    ("`[rbf]`", RbfOptions::KEYS),
    ("`[selection]`", SelectionOptions::KEYS),
    ("`[output]`", OutputOptions::KEYS),
];

fn row(key: &Key) -> String {
    let schema = (key.schema)();
    let names = schema["enum"].as_array().into_iter().flatten();
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    let words = match key.words {
        "" => names.join(", "),
        words => words.to_owned(),
    };
    let default = match key.default {
        _ if key.example.is_some() => "required".to_owned(),
        Some(number) if number.parse::<f64>().is_ok() => number.to_owned(),
        Some(text) => format!("`{text}`"),
        None => key.otherwise.to_owned(),
    };
    format!(
        "| `{}` | {words} | {default} | {} |\n",
        key.name,
        key.doc.trim()
    )
}

/// The page with its tables made anew. `AZIMESH_WRITE_DOCS=1` writes it.
#[test]
fn the_tables_of_the_page_are_made_from_the_keys() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schedule.md");
    let page = std::fs::read_to_string(&path).expect("the page is there");
    let mut new = page.clone();
    assert_eq!(page.matches("\n| key").count(), TABLES.len());
    for (name, keys) in TABLES {
        let head = format!("| key of {name} | type | default | |\n|---|---|---|---|\n");
        let (before, rest) = new.split_once(&head).expect(name);
        let old = rest.lines().take_while(|line| line.starts_with('|'));
        let old: usize = old.map(|line| line.len() + 1).sum();
        let rows: String = keys.iter().map(row).collect();
        new = format!("{before}{head}{rows}{}", &rest[old..]);
    }
    if std::env::var_os("AZIMESH_WRITE_DOCS").is_some() {
        std::fs::write(&path, &new).expect("the page is written");
    }
    assert!(page == new, "run this test with AZIMESH_WRITE_DOCS=1");
}

/// Adds the keys of all tables in a schema.
fn collect(schema: &Value, keys: &mut BTreeSet<String>) {
    for (key, of) in schema["properties"].as_object().into_iter().flatten() {
        keys.insert(key.clone());
        collect(of, keys);
    }
    let branches = schema["anyOf"].as_array().into_iter().flatten();
    branches.for_each(|branch| collect(branch, keys));
    if schema["items"].is_object() {
        collect(&schema["items"], keys);
    }
}

#[test]
fn page_and_schema_have_the_same_keys() {
    let page = include_str!("../../../../../docs/schedule.md");
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let keys = rows.map(|row| row.split('`').next().unwrap_or(row).to_owned());
    let page: BTreeSet<String> = keys.collect();
    let mut schema = BTreeSet::new();
    collect(&Schedule::schema(), &mut schema);
    // Keys of harmonics, of pairs and of `columns` have no rows.
    let columns = [Beam::names(), Cyclic::names(), SurfaceMotion::names()].concat();
    schema.retain(|key| {
        !["sin", "cos", "pair"].contains(&key.as_str())
            && (key == "step" || !columns.contains(&key.as_str()))
    });
    assert_eq!(page, schema);
}

/// Checks a value against the keywords that the schema uses; returns the first error with its path.
fn wrong(value: &Value, schema: &Value, path: &str) -> Option<String> {
    if let Some(branches) = schema["anyOf"].as_array() {
        let fits = |branch: &Value| wrong(value, branch, path).is_none();
        return (!branches.iter().any(fits)).then(|| format!("{path}: no branch"));
    }
    let names = schema["enum"].as_array();
    let is_typed = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.as_str().is_some_and(|text| !text.is_empty()),
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.is_i64(),
        Some("number") => value.is_number(),
        _ => names.is_some(),
    };
    let above = |key: &str| schema[key].as_f64().unwrap_or(f64::NEG_INFINITY);
    let number = value.as_f64().unwrap_or(f64::INFINITY);
    let n = value.as_array().map_or(0, Vec::len) as u64;
    let most = schema["maxItems"].as_u64().unwrap_or(u64::MAX);
    let fits = is_typed
        && names.is_none_or(|names| names.contains(value))
        && (number >= above("minimum") && number > above("exclusiveMinimum"))
        && schema["maximum"].as_f64().is_none_or(|most| number <= most)
        && (schema["minItems"].as_u64().unwrap_or(0)..=most).contains(&n);
    if !fits {
        return Some(format!("{path}: {value}"));
    }
    let items = value.as_array().into_iter().flatten();
    let mut items = items.map(|item| wrong(item, &schema["items"], &format!("{path}[]")));
    let required = schema["required"].as_array().into_iter().flatten();
    let mut missing = required.filter(|key| value.get(key.as_str().unwrap_or("")).is_none());
    let fields = value.as_object().into_iter().flatten();
    let mut fields = fields.map(|(key, value)| match schema["properties"].get(key) {
        Some(of) => wrong(value, of, &format!("{path}.{key}")),
        None => Some(format!("{path}: unknown {key}")),
    });
    let missing = missing.next().map(|key| format!("{path}: no {key}"));
    missing
        .or(fields.find_map(|wrong| wrong))
        .or(items.find_map(|wrong| wrong))
}

#[test]
fn schedules_fit_the_schema_as_the_reader_takes_them() {
    let schema = Schedule::schema();
    let told = |text: &str| wrong(&toml::from_str(text).expect("it is TOML"), &schema, "");
    let page = include_str!("../../../../../docs/schedule.md");
    let examples = page.split("```toml\n").skip(1);
    for example in examples.filter_map(|rest| rest.split("```").next()) {
        assert_eq!(told(example), None, "{example}");
    }
    let testdata = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata");
    let mut n = 0;
    for folder in ["", "real"] {
        let files = std::fs::read_dir(testdata.join(folder)).expect("a folder");
        let paths = files.map(|file| file.expect("a file").path());
        for path in paths.filter(|path| path.extension().is_some_and(|kind| kind == "toml")) {
            let text = std::fs::read_to_string(&path).expect("a text");
            assert_eq!(told(&text), None, "{}", path.display());
            n += 1;
        }
    }
    assert!(n > 10, "{n}");
    let body = "body = [ { name = 'a', tags = ['a'] } ]\n";
    for (text, expected) in [
        ("rbf.kernl = 'x'", ".rbf: unknown kernl"),
        ("rbf.kernel = 'x'", ".rbf.kernel: \"x\""),
        ("rbf.substeps = 1001", ".rbf.substeps: 1001"),
        ("rbf.support_radius = 0", ".rbf.support_radius: 0"),
        ("rotor.hub = [0, 0]", ".rotor: no branch"),
        ("output.title = ''", ".output.title: \"\""),
    ] {
        assert_eq!(told(&format!("{body}{text}")).as_deref(), Some(expected));
    }
    assert_eq!(
        told("body = [ { tags = ['a'] } ]").as_deref(),
        Some(".body[]: no \"name\"")
    );
}

/// Reads `T` from the examples of its required keys and `more`.
fn read<T: Keys + Debug>(more: &str) -> String {
    let needed = T::KEYS.iter().filter_map(|key| key.example);
    let text = needed.chain([more]).collect::<Vec<_>>().join("\n");
    let (lines, document) = (Lines::of(&text), DeTable::parse(&text).expect("it is TOML"));
    let mut new = T::empty();
    let section = Section::root(&lines, document.get_ref(), T::TITLE);
    new.set(&section).expect("a default is good");
    format!("{new:?}")
}

fn check_defaults<T: Keys + Debug>(more: &str) {
    for key in T::KEYS {
        if let Some(default) = key.default {
            let given = read::<T>(&format!("{more}\n{} = {default}", key.name));
            assert_eq!(given, read::<T>(more), "{}", key.name);
        }
    }
}

#[test]
fn a_default_that_is_given_changes_nothing() {
    check_defaults::<Rotor>("azimuth_table = 'a.csv'");
    check_defaults::<Cyclic>("table = 'a.csv'");
    check_defaults::<Rigid>("");
    check_defaults::<AxisRotation>("table = 'a.csv'");
    check_defaults::<Translation>("");
    check_defaults::<TableMotion>("");
    check_defaults::<Beam>("");
    check_defaults::<Modes>("");
    check_defaults::<SurfaceMotion>("");
    check_defaults::<RbfOptions>("");
    check_defaults::<SelectionOptions>("");
    check_defaults::<OutputOptions>("");
}
