//! Names of arrays and groups: decoded from the bytes of a file, and changed to what a format allows. Makes names
//! unique where a format needs that, and names of arrays that several have.

use super::Notes;
use super::notes::{LISTED, not_alike};
use crate::mesh::{Group, Mesh, MeshView};
use azimesh_core::error::counted;
use azimesh_core::{Note, note};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Text of a file: UTF-8, or else Latin-1, which is noted.
pub fn text_of(bytes: &[u8], notes: &mut Notes) -> String {
    match decoded(bytes) {
        Cow::Borrowed(text) => text.to_owned(),
        Cow::Owned(text) => {
            notes.latin1(&text);
            text
        }
    }
}

/// Text of a file: UTF-8, borrowed, or else Latin-1, in which every byte is a character.
pub fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

/// The start of a name, of at most so many bytes.
pub fn cut(name: &str, longest: usize) -> String {
    let mut end = longest.min(name.len());
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    name[..end].to_owned()
}

/// The rule of a format for names.
pub struct Rule {
    /// Bytes that a name may have.
    pub longest: usize,
    /// The name as the format takes it, in so many bytes.
    pub fit: fn(&str, usize) -> String,
    /// The allowed names, as part of a sentence.
    pub why: &'static str,
}

/// Names that are given in one place of a file.
#[derive(Default)]
pub struct UniqueNames {
    names: BTreeSet<String>,
    /// The number that a name which is taken gets next.
    next: BTreeMap<String, usize>,
}

impl UniqueNames {
    /// With names that nothing else may have.
    pub fn with<'a>(taken: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            names: taken.into_iter().map(str::to_owned).collect(),
            next: BTreeMap::new(),
        }
    }

    /// The name as the rule has it or, where that is taken, with the first number behind it that makes
    /// it free.
    pub fn give(&mut self, name: &str, rule: &Rule) -> String {
        let first = (rule.fit)(name, rule.longest);
        if self.names.insert(first.clone()) {
            return first;
        }
        let next = self.next.entry(first).or_insert(2);
        loop {
            let end = format!("_{next}");
            let wanted = (rule.fit)(name, rule.longest - end.len()) + &end;
            *next += 1;
            if self.names.insert(wanted.clone()) {
                return wanted;
            }
        }
    }

    /// A name for each: first come those that can stay as they are.
    pub fn give_all(&mut self, names: &[&str], rule: &Rule) -> Vec<String> {
        let fits = |name: &str| (rule.fit)(name, rule.longest) == name;
        let stays = names.iter();
        let stays = stays.map(|name| fits(name) && self.names.insert((*name).to_owned()));
        let staying: Vec<bool> = stays.collect();
        let given = |(name, stays): (&&str, bool)| {
            if stays {
                (*name).to_owned()
            } else {
                self.give(name, rule)
            }
        };
        names.iter().zip(staying).map(given).collect()
    }

    /// Names by what they are written as, as [`Rule::by_name`].
    pub fn by_name<'a>(
        mut self,
        names: impl IntoIterator<Item = &'a str>,
        rule: &Rule,
    ) -> BTreeMap<&'a str, String> {
        let mut seen = BTreeSet::new();
        let new = names.into_iter().filter(|name| seen.insert(*name));
        let names: Vec<&str> = new.collect();
        let written = self.give_all(&names, rule);
        names.into_iter().zip(written).collect()
    }
}

impl Rule {
    /// Names by what they are written as: one for each name, however often it comes.
    pub fn by_name<'a>(
        &self,
        names: impl IntoIterator<Item = &'a str>,
    ) -> BTreeMap<&'a str, String> {
        UniqueNames::default().by_name(names, self)
    }

    /// A note for a name that is written as another.
    pub fn note(&self, what: &'static str, name: &str, written: &str) -> Option<Note> {
        (name != written).then(|| {
            let is_taken = (self.fit)(name, self.longest) != written;
            let note = note!(
                "renamed",
                "{what} {name:?} is written as \"{written}\": {}{}",
                self.why,
                if is_taken {
                    ", and that name is taken"
                } else {
                    ""
                }
            );
            note.with("name", name).with("written", written)
        })
    }
}

/// Index of the entry of each key in a list, such as of a name.
pub struct Places<K>(BTreeMap<K, usize>);

impl<K: Ord> Default for Places<K> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord> Places<K> {
    pub fn get(&self, key: &K) -> Option<usize> {
        self.0.get(key).copied()
    }

    /// The entry of a key; adds a new one to the end of the list where it has none.
    pub fn entry<'l, T>(
        &mut self,
        key: K,
        list: &'l mut Vec<T>,
        new: impl FnOnce() -> T,
    ) -> &'l mut T {
        let place = *self.0.entry(key).or_insert(list.len());
        if place == list.len() {
            list.push(new());
        }
        &mut list[place]
    }
}

/// Makes names of arrays unique by a number after them, from the second on; adds a note for each.
pub fn tell_apart<'n>(
    what: &'static str,
    names: impl IntoIterator<Item = &'n mut String>,
    notes: &mut Notes,
) {
    const AS_IT_IS: Rule = Rule {
        longest: usize::MAX,
        fit: |name, _| name.to_owned(),
        why: "",
    };
    let names: Vec<&mut String> = names.into_iter().collect();
    let before: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
    let unique = UniqueNames::default().give_all(&before, &AS_IT_IS);
    for (name, here) in names.into_iter().zip(unique) {
        if *name != here {
            let name = std::mem::replace(name, here.clone());
            notes.push(note!(
                "array_renamed",
                "several {what} arrays are called \"{name}\"; one of them is read as \"{here}\""
            ));
        }
    }
}

/// Arrays that all parts of a mesh have alike by a key, each with one array of every part; notes the others.
pub fn alike<'p, A, K: Ord>(
    parts: &[&'p Vec<A>],
    what: &'static str,
    (name, key): (impl Fn(&A) -> &str, impl Fn(&'p A) -> K),
    notes: &mut Notes,
) -> Vec<Vec<&'p A>> {
    let mut found: BTreeMap<K, Vec<&A>> = BTreeMap::new();
    for array in parts.iter().flat_map(|part| part.iter()) {
        found.entry(key(array)).or_default().push(array);
    }
    let is_everywhere = |array: &'p A| {
        found
            .get(&key(array))
            .filter(|all| all.len() == parts.len())
    };
    let first = parts.first().into_iter().flat_map(|part| part.iter());
    let alike: Vec<_> = first.filter_map(is_everywhere).cloned().collect();
    let known: BTreeSet<&str> = alike.iter().map(|all| name(all[0])).collect();
    let others = parts.iter().flat_map(|part| part.iter()).map(&name);
    let others = others.filter(|name| !known.contains(name));
    notes.extend(others.map(|name| not_alike(what, name)));
    alike
}

/// Makes names of arrays unique; notes groups that share a name, which then stands for all of them.
pub fn check(mesh: &mut Mesh, notes: &mut Notes) {
    for (what, arrays) in [
        ("point", &mut mesh.point_arrays),
        ("cell", &mut mesh.cell_arrays),
        ("field", &mut mesh.field_arrays),
    ] {
        tell_apart(what, arrays.iter_mut().map(|array| &mut array.name), notes);
    }
    let dimension = mesh.dimension();
    let repeated = repeated(&mesh.groups);
    let kinds: [(&str, &dyn Fn(u8) -> bool); 3] = [
        ("zones", &|d| d == dimension),
        ("boundary tags", &|d| d + 1 == dimension),
        ("groups", &|d| d + 1 < dimension),
    ];
    for (what, is_of) in kinds {
        let here = repeated.iter().filter(|((d, _), _)| is_of(*d));
        let named = here.map(|((_, name), n)| format!("{n} are called \"{name}\""));
        notes.list(named.collect(), |mut named| {
            if named.len() > LISTED {
                let n = counted(named.len() - LISTED, "name");
                named.truncate(LISTED);
                named.push(format!("and {n} more are shared"));
            }
            let named = named.join(", ");
            note!(
                "shared_names",
                "of the {what}, {named}; the name stands for all of them"
            )
        });
    }
}

/// Names of the groups of some dimensions.
pub fn names_in(mesh: &MeshView, dimensions: Range<u8>) -> Vec<String> {
    let groups = mesh.groups.iter();
    let groups = groups.filter(|group| dimensions.contains(&group.dimension));
    groups.map(|group| group.name.clone()).collect()
}

/// Dimension and name that several groups share, with their number.
pub fn repeated<'a>(groups: impl IntoIterator<Item = &'a Group>) -> BTreeMap<(u8, &'a str), usize> {
    let mut counts: BTreeMap<(u8, &str), usize> = BTreeMap::new();
    for group in groups {
        *counts.entry((group.dimension, &group.name)).or_default() += 1;
    }
    counts.retain(|_, n| *n > 1);
    counts
}

/// The word of CGNS for a condition of OpenFOAM; other conditions as they are.
pub fn in_cgns(condition: &str) -> &str {
    match condition {
        "wall" => "BCWall",
        "symmetry" | "symmetryPlane" => "BCSymmetryPlane",
        condition => condition,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: Rule = Rule {
        longest: 8,
        fit: |name, longest| cut(&name.replace(' ', "_"), longest),
        why: "no spaces",
    };

    fn written(names: &[&str]) -> Vec<String> {
        UniqueNames::with(["taken"]).give_all(names, &RULE)
    }

    #[test]
    fn names_that_become_the_same_are_numbered_and_good_ones_stay() {
        assert_eq!(written(&["a b", "a_b", "a_b_2"]), ["a_b_3", "a_b", "a_b_2"]);
        assert_eq!(written(&["a b", "a\u{20}b"]), ["a_b", "a_b_2"]);
        assert_eq!(written(&["taken", "x"]), ["taken_2", "x"]);
        assert_eq!(
            written(&["a long one", "a long two"]),
            ["a_long_o", "a_long_t"]
        );
        assert_eq!(
            written(&["a longer 1", "a longer 2"]),
            ["a_longer", "a_long_2"]
        );
        assert_eq!(written(&["ééééé", "éééééé"]), ["éééé", "ééé_2"]);
    }

    #[test]
    fn a_name_that_changes_is_told() {
        assert_eq!(RULE.note("tag", "a", "a"), None);
        for (written, is_taken) in [("a_b", false), ("a_b_2", true)] {
            let taken = if is_taken {
                ", and that name is taken"
            } else {
                ""
            };
            let note = RULE.note("tag", "a b", written).expect("it is another");
            assert_eq!(
                note.text,
                format!("tag \"a b\" is written as \"{written}\": no spaces{taken}")
            );
        }
    }

    #[test]
    fn bytes_that_are_not_utf8_are_latin1() {
        let mut notes = Notes::default();
        assert_eq!(text_of("é".as_bytes(), &mut notes), "é");
        notes.close();
        assert!(notes.is_empty());
        assert_eq!(text_of(b"Fl\xfcgel", &mut notes), "Flügel");
        assert_eq!(text_of(b"H\xe4user", &mut notes), "Häuser");
        notes.close();
        let text = "texts that are not UTF-8 are read as Latin-1: \"Flügel\", \"Häuser\"";
        assert!(notes.says(text), "{notes:?}");
    }
}
