//! The companion file `.mapbc` of a mesh: a count, then a line for each face number with the number of its
//! boundary condition and, mostly, its name. Conditions have FUN3D's numbers, and names of CGNS.

use super::super::Notes;
use super::super::names::{Rule, UniqueNames, in_cgns, text_of};
use super::super::source::{read_file, without_mark};
use super::super::tokens::Tokens;
use super::case;
use super::faces::{self, FaceNumbers, Tag, UNTAGGED};
use crate::formats::notes::{conditions_unused, quoted};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use azimesh_core::note;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A line of a `.mapbc`: a face number with its condition and name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Patch {
    pub number: i32,
    /// FUN3D's number of the boundary condition.
    pub condition: i32,
    pub name: Option<String>,
}

/// Numbers by their names. A name is written as its first number; the others say the same with less detail. 3, 4 and 5 are
/// the numbers of old grids.
const TABLE: &[(&str, &[i32])] = &[
    ("BCWallInviscid", &[3000, 5]),
    ("BCWallViscous", &[4000, 4, 4100, 4110]),
    ("BCFarfield", &[5000, 3, 5005, 5025, 5050]),
    ("BCExtrapolate", &[5026]),
    ("BCOutflow", &[5051, 5052, 7031]),
    ("BCSymmetryPlane", &[6662, 6021, 6022, 6023, 6661, 6663]),
    ("BCTunnelInflow", &[7011]),
    ("BCTunnelOutflow", &[7012]),
    ("BCInflow", &[7036]),
    ("BCInflowSupersonic", &[7100]),
];

/// Names of CGNS without a number in FUN3D, and the number of the most similar condition.
const NEAREST: &[(&str, &[i32])] = &[
    ("BCWall", &[4000]),
    ("BCWallViscousHeatFlux", &[4000]),
    ("BCWallViscousIsothermal", &[4000]),
    ("BCInflowSubsonic", &[7011]),
    ("BCOutflowSubsonic", &[7012]),
    ("BCOutflowSupersonic", &[5026]),
];

/// The name of symmetry planes; their number depends on the direction of the normal.
pub(super) const SYMMETRY: &str = "BCSymmetryPlane";

/// The condition with this number: a word where there is one, otherwise its digits. 0 is none.
pub(super) fn condition(number: i32) -> Option<String> {
    let mut words = TABLE.iter();
    let word = words.find(|(_, numbers)| numbers.contains(&number));
    let word = word.map(|(word, _)| (*word).to_owned());
    word.or_else(|| (number != 0).then(|| number.to_string()))
}

/// The number of a condition, where it has one; for a symmetry plane `normal` is the axis.
pub(super) fn number(condition: &str, normal: usize) -> Option<i32> {
    let condition = in_cgns(condition);
    if condition == SYMMETRY {
        return Some(6661 + normal as i32);
    }
    let mut known = TABLE.iter().chain(NEAREST);
    let known = known.find(|(word, _)| *word == condition);
    known.map_or_else(|| condition.parse().ok(), |(_, numbers)| Some(numbers[0]))
}

fn path(case: &Path) -> PathBuf {
    let mut name = case.as_os_str().to_owned();
    name.push(".mapbc");
    name.into()
}

/// The patches in the companion file of a mesh; none without the file. A file that cannot be
/// read gives a note only: the mesh is complete without it.
pub(super) fn companion(mesh: &Path, notes: &mut Notes) -> Result<Vec<Patch>> {
    let path = path(&case(mesh));
    let failed = match read_file(&path) {
        Ok(bytes) => match parse(without_mark(&bytes), notes) {
            Ok(patches) => return Ok(patches),
            Err(error) => error.file(&path).to_string(),
        },
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => format!("{}: {error}", path.display()),
    };
    notes.push(conditions_unused(&failed));
    Ok(Vec::new())
}

fn parse(bytes: &[u8], notes: &mut Notes) -> Result<Vec<Patch>> {
    let mut lexer = Tokens::with_comments(bytes);
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
        notes.push(note!(
            "patch_count",
            "the number of patches in the .mapbc is given as {n}, but there are {}; all are read",
            patches.len()
        ));
    }
    Ok(patches)
}

/// Returns true if a mesh needs the file: its face numbers do not say all.
fn is_needed(tags: &[Tag], numbers: &FaceNumbers) -> bool {
    let says_all =
        |tag: &Tag| tag.group.name == tag.number.to_string() && tag.group.condition.is_none();
    numbers.n_untagged > 0 || !tags.iter().all(says_all)
}

/// The file of a mesh that is written to a path, with its content, where it is needed.
pub(super) fn companions(mesh: &MeshView, to: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    if mesh.dimension() != 3 {
        return Vec::new();
    }
    let tags = faces::tags(mesh);
    let numbers = FaceNumbers::of(mesh, &tags);
    let file = path(&case(to));
    // A file that is there already would name the tags of this mesh.
    if !is_needed(&tags, &numbers) && !file.exists() {
        return Vec::new();
    }
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
    vec![(file, text.into_bytes())]
}

/// Notes on names and conditions that change in the file.
pub(super) fn note_changes(
    mesh: &MeshView,
    tags: &[Tag],
    numbers: &FaceNumbers,
    notes: &mut Notes,
) {
    let mut without = Vec::new();
    let names = written(tags);
    let renamed = names.iter();
    notes.extend(renamed.filter_map(|(name, written)| RULE.note("tag", name, written)));
    for tag in tags {
        let name = &tag.group.name;
        let number = faces::condition_number(mesh, tag.group);
        let back = number.and_then(condition);
        match (&tag.group.condition, number) {
            (None, _) => without.push(name.clone()),
            (Some(condition), None) => notes.push(note!(
                "condition_without_number",
                "condition {condition} of tag \"{name}\" has no number in FUN3D; 0 is written"
            )),
            (Some(condition), Some(number)) if back.as_ref() != Some(condition) => {
                notes.push(note!(
                    "condition_written_as",
                    "condition {condition} of tag \"{name}\" is written as FUN3D's {number}"
                ));
            }
            _ => {}
        }
    }
    if !without.is_empty() && is_needed(tags, numbers) {
        let tags = quoted(&without).join(", ");
        notes.push(note!(
            "condition_missing",
            "tags without a boundary condition have number 0 in the .mapbc: {tags}"
        ));
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

/// The name of faces that are in no tag; no tag has it.
pub(super) fn untagged(tags: &[Tag]) -> String {
    let names = written(tags);
    UniqueNames::with(names.values().map(String::as_str)).give(UNTAGGED, &RULE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

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
            assert_says(&error, expected);
        }
    }

    #[test]
    fn a_number_comes_back_as_one_of_the_same_meaning() {
        for (word, _) in TABLE {
            let back = number(word, 1).expect("it has a number");
            assert_eq!(condition(back).as_deref(), Some(*word));
        }
        assert_eq!(condition(6100).as_deref(), Some("6100"));
        assert_eq!(number("6100", 0), Some(6100));
        assert_eq!(
            [number("wall", 0), number("symmetry", 2)],
            [Some(4000), Some(6663)]
        );
        assert_eq!(number(SYMMETRY, 2), Some(6663));
        assert_eq!(condition(0), None);
        assert_eq!(number("UserDefined", 0), None);
    }
}
