//! A file for each step, with the number of the step in its name: `surface_*.dat` for `surface_00000.dat`, `surface_00001.dat` and on.

use std::path::{Path, PathBuf};

/// Stands for the number.
const NUMBER: char = '*';

/// Returns whether a name in a schedule stands for several files.
pub(super) fn is_pattern(folder: &Path, file: &str) -> bool {
    file.contains(NUMBER) && !folder.join(file).exists()
}

/// Finds the files of a pattern with their numbers, in increasing order; an error message if there are none.
pub(super) fn files(folder: &Path, pattern: &str) -> Result<Vec<(u64, String)>, String> {
    let name_at = pattern.rfind(['/', '\\']).map_or(0, |at| at + 1);
    let (under, name) = pattern.split_at(name_at);
    let (before, after) = name.split_once(NUMBER).unwrap_or((name, ""));
    if under.contains(NUMBER) || after.contains(NUMBER) {
        return Err(format!(
            "{pattern} has more than the one `*` of a file's name, which stands for the number of the step"
        ));
    }
    // No folder is the working folder, which has no name.
    let parent = Path::new(".").join(folder).join(under);
    let mut files = Vec::new();
    for entry in parent.read_dir().into_iter().flatten().flatten() {
        let found = entry.file_name();
        let Some(found) = found.to_str() else {
            continue;
        };
        let digits = found
            .strip_prefix(before)
            .and_then(|rest| rest.strip_suffix(after));
        let digits = digits.filter(|digits| digits.bytes().all(|b| b.is_ascii_digit()));
        if let Some(number) = digits.and_then(|digits| digits.parse().ok()) {
            files.push((number, format!("{under}{found}")));
        }
    }
    files.sort();
    if let Some(pair) = files.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let message = "have the same number; keep one of them";
        return Err(format!("{} and {} {message}", pair[0].1, pair[1].1));
    }
    if files.is_empty() {
        return Err(format!(
            "there is no file {pattern} with the number of a step for `*`"
        ));
    }
    Ok(files)
}

/// Returns the path of a file in a schedule, or the paths of the files of a pattern.
pub(in crate::motion) fn paths(folder: &Path, file: &str) -> Vec<PathBuf> {
    match files(folder, file) {
        Ok(files) if is_pattern(folder, file) => files
            .into_iter()
            .map(|(_, file)| folder.join(file))
            .collect(),
        _ => vec![folder.join(file)],
    }
}
