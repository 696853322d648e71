//! The companion file `.mapbc` of a mesh: a count, then a line for each face number with the number of its
//! boundary condition and, mostly, its name.

use super::super::Notes;
use super::super::lexer::Lexer;
use super::super::names::{Given, Rule, text_of};
use super::super::source::{read_file, without_mark};
use super::conditions::Patch;
use super::faces::{self, FaceNumbers, Tag, UNTAGGED};
use crate::mesh::MeshView;
use azimesh_core::diagnostic::formats::{Condition, Read};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The file of a case.
pub(super) fn path(case: &Path) -> PathBuf {
    let mut name = case.as_os_str().to_owned();
    name.push(".mapbc");
    name.into()
}

/// The patches in the file of a case; none where there is no file. A file that cannot be
/// read gives a note only: the mesh is complete without it.
pub(super) fn companion(case: &Path, notes: &mut Notes) -> Result<Vec<Patch>> {
    let path = path(case);
    let failed = match read_file(&path) {
        Ok(bytes) => match parse(without_mark(&bytes), notes) {
            Ok(patches) => return Ok(patches),
            Err(error) => error.file(&path).to_string(),
        },
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => format!("{}: {error}", path.display()),
    };
    notes.push(Read::ConditionsUnused { error: failed });
    Ok(Vec::new())
}

/// The patches in a file.
fn parse(bytes: &[u8], notes: &mut Notes) -> Result<Vec<Patch>> {
    let mut lexer = Lexer::new(bytes, Some(b'#'));
    let mut first = lexer.line().ok_or_else(|| {
        lexer.error("the file is empty; it should start with the number of patches")
    })?;
    let n: usize = first.narrow("the number of patches")?;
    let mut patches: Vec<Patch> = Vec::new();
    let mut numbers = BTreeSet::new();
    while let Some(mut line) = lexer.line() {
        let number = line.narrow("a face number")?;
        let condition = line.narrow("the number of a boundary condition")?;
        let name = text_of(line.rest(), notes);
        if !numbers.insert(number) {
            return Err(line.error(format!("face number {number} appears twice")));
        }
        patches.push(Patch {
            number,
            condition,
            name: (!name.is_empty()).then_some(name),
        });
    }
    if patches.len() != n {
        notes.push(Read::PatchCount {
            said: n,
            found: patches.len(),
        });
    }
    Ok(patches)
}

/// Whether a mesh needs the file: not where the face numbers say all there is.
pub(super) fn is_needed(mesh: &MeshView) -> bool {
    let tags = faces::tags(mesh);
    let says_all =
        |tag: &Tag| tag.group.name == tag.number.to_string() && tag.group.condition.is_none();
    let says_all = tags.iter().all(says_all) && FaceNumbers::of(mesh, &tags).n_untagged == 0;
    mesh.dimension() == 3 && !says_all
}

/// The content of the file for a mesh.
pub(super) fn content(mesh: &MeshView) -> String {
    let tags = faces::tags(mesh);
    let numbers = FaceNumbers::of(mesh, &tags);
    let n = tags.len() + usize::from(numbers.n_untagged > 0);
    let names = written(&tags);
    let mut text = format!("{n}\n");
    for tag in &tags {
        let condition = faces::condition_number(mesh, tag.group).unwrap_or(0);
        let name = &names[tag.group.name.as_str()];
        writeln!(text, "{} {condition} {name}", tag.number).expect("a string takes all");
    }
    if numbers.n_untagged > 0 {
        let name = untagged(&tags);
        writeln!(text, "{} 0 {name}", numbers.untagged).expect("a string takes all");
    }
    text
}

/// Notes on names and conditions that change in the file.
pub(super) fn note_changes(mesh: &MeshView, tags: &[Tag], notes: &mut Notes) {
    let mut without = Vec::new();
    let names = written(tags);
    notes.extend(
        names
            .iter()
            .filter_map(|(name, written)| RULE.note("tag", name, written)),
    );
    for tag in tags {
        let name = &tag.group.name;
        let number = faces::condition_number(mesh, tag.group);
        let back = number.and_then(super::conditions::condition);
        match (&tag.group.condition, number) {
            (None, _) => without.push(name.clone()),
            (Some(condition), None) => notes.push(Condition::WithoutNumber {
                condition: condition.clone(),
                tag: name.clone(),
            }),
            (Some(condition), Some(number)) if back.as_ref() != Some(condition) => {
                notes.push(Condition::WrittenAs {
                    condition: condition.clone(),
                    tag: name.clone(),
                    number,
                });
            }
            _ => {}
        }
    }
    if !without.is_empty() && is_needed(mesh) {
        notes.push(Condition::Missing { tags: without });
    }
}

/// Names as a list-directed read can take them.
const RULE: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" => "_".to_owned(),
        name => name.replace(|c: char| c.is_whitespace() || c.is_control(), "_"),
    },
    why: "names in a .mapbc have no spaces",
};

/// The name of each tag in the file.
fn written<'a>(tags: &[Tag<'a>]) -> BTreeMap<&'a str, String> {
    RULE.by_name(tags.iter().map(|tag| tag.group.name.as_str()))
}

/// The name of faces that are in no tag, which is that of no tag.
pub(super) fn untagged(tags: &[Tag]) -> String {
    let names = written(tags);
    Given::with(names.values().map(String::as_str)).give(UNTAGGED, &RULE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_with_and_without_names_are_read() {
        let mut notes = Notes::default();
        let file = b"# by hand\n 3\n21   5050        farfield_front\n1 4000\n 2 4000 upper wing\n";
        let patches = parse(file, &mut notes).expect("a good file");
        let names: Vec<_> = patches.iter().map(|patch| patch.name.as_deref()).collect();
        assert_eq!(names, [Some("farfield_front"), None, Some("upper wing")]);
        assert_eq!((patches[0].number, patches[0].condition), (21, 5050));
        assert!(notes.is_empty());
        parse(b"3\n1 4000\n", &mut notes).expect("a good file");
        assert_eq!(notes.iter().count(), 1);
    }

    #[test]
    fn a_damaged_line_is_named() {
        for (file, expected) in [
            ("", "the file is empty"),
            (
                "wing\n",
                "line 1: expected an integer as the number of patches",
            ),
            (
                "1\n1 wall\n",
                "line 2: expected an integer as the number of a boundary",
            ),
            ("2\n1 4000\n1 5000\n", "line 3: face number 1 appears twice"),
        ] {
            let error = parse(file.as_bytes(), &mut Notes::default()).expect_err("it is damaged");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
