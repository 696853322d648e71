//! Lists of the meshes of a sequence and their times: .pvd of ParaView, .vtk.series and .vtu.series.

use super::source::read_file;
use super::tokens;
use super::vtu::{escaped, is_xml};
use azimesh_core::error::{Error, Result};
use quick_xml::XmlVersion;
use quick_xml::events::Event;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Endings of such lists.
const ENDINGS: [&str; 2] = [".pvd", ".series"];

/// Checks if a file is, by its name, a list of meshes.
pub fn is_series(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_ascii_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// A mesh of a list.
#[derive(Debug, Clone, PartialEq)]
pub struct Listed {
    /// Time of the mesh.
    pub time: f64,
    /// File of the mesh.
    pub path: PathBuf,
    /// The line of the list that names it, where that is known.
    pub line: Option<u64>,
}

/// The meshes of a list, in its order. Files are relative to the list.
pub fn read_series(path: &Path) -> Result<Vec<Listed>> {
    let bytes = read_file(path).map_err(|error| Error::io(path, &error))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| Error::input("the list is not UTF-8 text").file(path))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let is_json = text.trim_start().starts_with('{');
    let entries = if is_json { of_json(text) } else { of_pvd(text) };
    let mut entries = entries.map_err(|error| error.file(path))?;
    if entries.is_empty() {
        return Err(Error::input("the list has no meshes").file(path));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    for entry in &mut entries {
        entry.path = folder.join(&entry.path);
    }
    Ok(entries)
}

fn of_json(text: &str) -> Result<Vec<Listed>> {
    let list: serde_json::Value =
        serde_json::from_str(text).map_err(|error| Error::input(error.to_string()))?;
    let files = list["files"]
        .as_array()
        .ok_or_else(|| Error::input("there is no list \"files\", so this is not a series"))?;
    let entry = |file: &serde_json::Value| {
        Some(Listed {
            time: file["time"].as_f64()?,
            path: file["name"].as_str()?.into(),
            line: None,
        })
    };
    let wrong = || Error::input("every entry of \"files\" must have a \"name\" and a \"time\"");
    files
        .iter()
        .map(|file| entry(file).ok_or_else(wrong))
        .collect()
}

/// Several files of one time are parts of one mesh, unless all say to be the same part: then each is a
/// mesh, as where a schedule comes back to an azimuth.
fn of_pvd(text: &str) -> Result<Vec<Listed>> {
    let mut reader = quick_xml::Reader::from_str(text);
    let mut entries: Vec<Listed> = Vec::new();
    let mut parts: BTreeMap<u64, [Option<String>; 3]> = BTreeMap::new();
    let (mut counted, mut n_lines) = (0, 1);
    loop {
        let start = reader.buffer_position() as usize;
        n_lines += tokens::line_of(&text.as_bytes()[counted..start], start - counted) - 1;
        counted = start;
        let wrong = |message: String| Error::input(message).line(n_lines);
        let event = reader.read_event();
        let event = event.map_err(|error| wrong(error.to_string()))?;
        let element = match event {
            Event::Eof => return Ok(entries),
            Event::Start(element) | Event::Empty(element) => element,
            _ => continue,
        };
        if element.name().as_ref() != "DataSet" {
            continue;
        }
        let value = |name: &str| -> Result<Option<String>> {
            let found = element.try_get_attribute(name);
            let found = found.map_err(|error| wrong(error.to_string()))?;
            let text = found.map(|attribute| attribute.normalized_value(XmlVersion::Implicit1_0));
            let text = text.transpose().map_err(|error| wrong(error.to_string()))?;
            Ok(text.map(|text| text.into_owned()))
        };
        let time = value("timestep")?.unwrap_or_else(|| entries.len().to_string());
        let number = time.trim().parse();
        let time: f64 =
            number.map_err(|_| wrong(format!("timestep=\"{time}\" is not a number")))?;
        let file = value("file")?.ok_or_else(|| wrong("a DataSet has no file".to_owned()))?;
        let part = [value("part")?, value("group")?, value("name")?];
        let is_part = part[0].is_none();
        // The two zeros are one time.
        let before = parts.insert((time + 0.0).to_bits(), part.clone());
        if before.is_some_and(|before| is_part || before != part) {
            return Err(wrong(format!(
                "several files have the time {time} as parts of one mesh; only lists with one file for each time are read"
            )));
        }
        entries.push(Listed {
            time,
            path: file.into(),
            line: Some(n_lines),
        });
    }
}

/// Refuses a file name that a list cannot hold: XML has no control characters except line ends.
pub fn check_listed(name: &str) -> Result<()> {
    match name.chars().find(|c| !is_xml(*c)) {
        None => Ok(()),
        Some(c) => Err(Error::input(format!(
            "the name \"{name}\" has the character {}, which an XML list of files cannot hold",
            c.escape_unicode()
        ))),
    }
}

/// Text of a .pvd over times and file names.
pub fn pvd<'a>(entries: impl IntoIterator<Item = (f64, &'a str)>) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    for (time, file) in entries {
        let file = escaped(file);
        text += &format!("    <DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>\n");
    }
    text + "  </Collection>\n</VTKFile>\n"
}

/// Text of a .vtk.series over times and file names.
pub fn vtk_series<'a>(entries: impl IntoIterator<Item = (f64, &'a str)>) -> String {
    let files: Vec<_> = entries
        .into_iter()
        .map(|(time, name)| serde_json::json!({ "name": name, "time": time }))
        .collect();
    let list = serde_json::json!({ "file-series-version": "1.0", "files": files });
    format!("{list:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_comes_back_with_its_times() {
        let folder = tempfile::tempdir().expect("a folder");
        let entries = [(0.0, "a & b_0.vtk"), (0.1, "a & b_1.vtk")];
        for (name, text) in [
            ("m.pvd", pvd(entries)),
            ("m.vtk.series", vtk_series(entries)),
        ] {
            let path = folder.path().join(name);
            assert!(is_series(&path));
            std::fs::write(&path, text).expect("it can be written");
            let found = read_series(&path).expect("it can be read");
            let found: Vec<_> = found
                .into_iter()
                .map(|entry| (entry.time, entry.path))
                .collect();
            let expected = entries.map(|(time, file)| (time, folder.path().join(file)));
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn files_of_one_time_are_steps_where_they_are_the_same_part() {
        let twice = pvd([(1.0, "a.vtu"), (2.0, "b.vtu"), (1.0, "c.vtu")]);
        let found = of_pvd(&twice).expect("three steps");
        let found: Vec<_> = found.iter().map(|entry| (entry.time, entry.line)).collect();
        assert_eq!(found, [(1.0, Some(4)), (2.0, Some(5)), (1.0, Some(6))]);
        let (part, again) = ("timestep=\"1\" part=\"0\" file=\"c.vtu\"", "file=\"c.vtu\"");
        for parts in [
            twice.replace(part, &part.replace("part=\"0\"", "part=\"1\"")),
            twice.replace("part=\"0\" ", ""),
            twice.replace(again, "file=\"c.vtu\" group=\"g\""),
        ] {
            let error = of_pvd(&parts).expect_err("two parts").to_string();
            assert!(
                error.starts_with("line 6: several files have the time 1"),
                "{error}"
            );
        }
        assert!(of_json("{}").is_err());
    }

    #[test]
    fn a_list_of_many_files_is_read_in_time_that_grows_with_it() {
        let seconds = |n: u32| {
            let text = pvd((0..n).map(|i| (f64::from(i), "m.vtu")));
            let start = std::time::Instant::now();
            let found = of_pvd(&text).expect("a good list");
            assert_eq!(found[n as usize - 1].line, Some(u64::from(n) + 3));
            start.elapsed().as_secs_f64()
        };
        let short = (0..3).map(|_| seconds(10_000)).fold(0.0, f64::max);
        let long = seconds(100_000);
        assert!(long < 60.0 * short, "{short} s, {long} s");
    }
}
