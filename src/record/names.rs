//! Names of the files of a sequence: of the whole sequence, of a part of its steps, of one step.

use std::ops::Range;
use std::path::{Path, PathBuf};

/// `run.json`, or `run_A-B.json` of the part with the steps A to B - 1.
pub fn file_name(stem: &str, part: Option<&Range<usize>>, extension: &str) -> String {
    match part {
        None => format!("{stem}.{extension}"),
        Some(Range { start, end }) => format!("{stem}_{start}-{end}.{extension}"),
    }
}

/// Returns the steps in the name of a file of a part; `None` for any other name, including a file of the whole sequence.
pub fn part_of(name: &str, stem: &str, extension: &str) -> Option<Range<usize>> {
    let (start, end) = inside(name, stem, extension)?.split_once('-')?;
    Some(start.parse().ok()?..end.parse().ok()?)
}

/// Formats `wing_0030.vtu`: the file of one step, with at least this many digits.
pub fn numbered(stem: &str, step: usize, digits: usize, extension: &str) -> String {
    format!("{stem}_{step:0digits$}.{extension}")
}

/// Returns the step in the name of a file of one step, which has at least four digits.
pub fn step_of(name: &str, stem: &str, extension: &str) -> Option<usize> {
    let digits = inside(name, stem, extension)?;
    let is_number = digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| digits.parse().ok())?
}

/// Returns the text between stem and extension.
fn inside<'a>(name: &'a str, stem: &str, extension: &str) -> Option<&'a str> {
    let rest = name.strip_prefix(stem)?.strip_prefix('_')?;
    rest.strip_suffix(extension)?.strip_suffix('.')
}

/// Returns the files of parts in a folder with their steps, in order.
///
/// # Errors
/// If the folder cannot be listed.
pub fn parts_in(
    folder: &Path,
    stem: &str,
    extension: &str,
) -> std::io::Result<Vec<(Range<usize>, PathBuf)>> {
    let part = |path: PathBuf| {
        let steps = part_of(path.file_name()?.to_str()?, stem, extension)?;
        Some((steps, path))
    };
    let mut found: Vec<_> = std::fs::read_dir(folder)?
        .filter_map(|entry| part(entry.ok()?.path()))
        .collect();
    found.sort_by_key(|(steps, _)| (steps.start, steps.end));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_known_by_the_names_of_its_files() {
        for part in [0..12, 30..1000] {
            let name = file_name("run", Some(&part), "json");
            assert_eq!(part_of(&name, "run", "json"), Some(part), "{name}");
        }
        for other in [
            "run.json",
            "run_0-12.csv",
            "steps_0-12.json",
            "run_a-b.json",
            "run_0-12.json.part",
        ] {
            assert_eq!(part_of(other, "run", "json"), None, "{other}");
        }
    }

    #[test]
    fn a_step_is_known_by_the_name_of_its_file() {
        assert_eq!(numbered("base", 30, 4, "toml"), "base_0030.toml");
        for (step, digits) in [(7, 4), (12_345, 4), (7, 6)] {
            let name = numbered("a_b", step, digits, "vtu");
            assert_eq!(step_of(&name, "a_b", "vtu"), Some(step), "{name}");
        }
        for other in ["a_b_7.vtu", "a_b_00x7.vtu", "a_0007.vtu", "a_b_0007.vtk"] {
            assert_eq!(step_of(other, "a_b", "vtu"), None, "{other}");
        }
    }
}
