//! Errors of wrong schedules and files: the place, what was found, what would be right. `errors.txt` has a case in each block,
//! with its error in the last line.

use super::{cases, displacements, naming, parse, rotors, surface, tables, two_cubes, two_squares};

const BODY: &str = "[[body]]\nname = \"a\"\ntags = [\"a\"]\nrigid.translate = [1, 0, 0]\n";

#[test]
fn every_error_has_its_line_and_says_what_would_be_right() {
    for (group, input, expected) in cases(include_str!("errors.txt")) {
        let found = told(group, input);
        let is_told = match expected.strip_suffix("...") {
            Some(start) => found.starts_with(start),
            None => found == expected,
        };
        assert!(is_told, "{group}\n{input}\n{expected}\nfound:\n{found}");
    }
    assert_eq!(with_line("none", ""), "no error");
}

/// The error of the input of a case, by its group.
fn told(group: &str, input: &str) -> String {
    let (plane, kind) = match group.strip_prefix("plane ") {
        Some(kind) => (true, kind),
        None => (false, group),
    };
    let resolved = |text: &str| {
        let mesh = if plane { two_squares() } else { two_cubes() };
        surface::resolve(&mesh, text).err().unwrap_or_default()
    };
    match kind {
        "text" => error_of(input),
        "steps" => error_of(&format!("{input}\n{BODY}")),
        "bodies" => error_of(&format!("azimuth.values = [0]\n{input}")),
        "mesh" if plane => resolved(&format!(
            "[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\n{input}\n[boundaries]\nothers = \"fixed\""
        )),
        "mesh" => resolved(input),
        "mesh boundaries" => resolved(&format!("{}[boundaries]\n{input}", surface::BLADE)),
        "rotors" => {
            let (old, new) = input.split_once("\n=>").expect("old => new");
            rotors::told(old, new.trim_start())
        }
        "table" => {
            let (body, table) = input.split_once("\n--\n").expect("body -- table");
            tables::told(plane, body, &format!("{table}\n"))
        }
        "azimuth table" => tables::told_at(
            plane,
            input,
            "rigid.translate = [0, 0, 1]",
            ("a.csv", "time_s,azimuth_deg\n0,0\n1,30\n"),
        ),
        "beam" => naming::told(input, naming::PLAIN),
        "surface" => displacements::told(plane, displacements::SURFACE, &format!("{input}\n")),
        section => with_line(section, input),
    }
}

fn error_of(text: &str) -> String {
    match parse(text) {
        Ok(_) => "no error".into(),
        Err(error) => error.to_string(),
    }
}

/// A good schedule with one line, `WRONG`, put in place of the marker of its section.
fn with_line(section: &str, wrong: &str) -> String {
    let mut text = String::new();
    for line in GOOD.lines() {
        let here = line.strip_prefix('#') == Some(section);
        text.push_str(if here { wrong } else { line });
        text.push('\n');
    }
    error_of(&text)
}

/// Lines are counted from 1; each `#marker` is where a test puts its line.
const GOOD: &str = "#top
[rotor]
#rotor
[[body]]
name = \"blade\"
tags = [\"blade\"]
#body
[body.cyclic]
#cyclic
[boundaries]
#boundaries
[rbf]
#rbf
[selection]
#selection
[output]
#output
[azimuth]
values = [0]
#azimuth
";
