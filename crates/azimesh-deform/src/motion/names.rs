//! Names and globs of tags and zones in the schedule, matched against a mesh.

use super::places::Places;
use azimesh_core::error::{Error, Position, Result, nearest_name};

/// Most names listed in a message; the rest is counted.
const LISTED: usize = 24;

/// A name, or a glob with `*` (any characters) and `?` (one character), and its position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pattern {
    /// As written.
    pub text: String,
    /// Position in the schedule.
    pub(super) place: Option<Position>,
}

impl Pattern {
    /// Creates a name given in memory, under a key of `places`.
    pub(super) fn new(text: String, places: &Places, key: &str) -> Self {
        let place = places.of(key);
        Self { text, place }
    }

    /// Creates several of them.
    pub(super) fn all(
        names: impl IntoIterator<Item = impl Into<String>>,
        places: &Places,
        key: &str,
    ) -> Vec<Self> {
        let names = names.into_iter().map(Into::into);
        names.map(|name| Self::new(name, places, key)).collect()
    }

    /// Returns whether `name` matches. An identical name always matches, even if it has a `*` or `?` in it.
    pub fn matches(&self, name: &str) -> bool {
        if self.text == name {
            return true;
        }
        let pattern: Vec<char> = self.text.chars().collect();
        let name: Vec<char> = name.chars().collect();
        glob(&pattern, &name)
    }

    /// Returns the positions in `names` of all matches; if there is none, an error lists the names. `what` is the kind
    /// of name: tag, zone.
    pub fn find(&self, what: &str, names: &[&str]) -> Result<Vec<usize>> {
        let found: Vec<usize> = (0..names.len())
            .filter(|&i| self.matches(names[i]))
            .collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let text = self.text.escape_debug();
        let hint = match nearest_name(&self.text, names.iter().copied()) {
            Some(near) if names.len() > LISTED => format!("; did you mean \"{near}\"?"),
            _ => String::new(),
        };
        let missing = if self.text.contains(['*', '?']) {
            format!("no {what} of the mesh matches \"{text}\"{hint}")
        } else {
            format!("{what} \"{text}\" is not in the mesh{hint}")
        };
        let has = match names {
            [] => format!("it has no {what}s"),
            names => format!("it has: {}", list(names.iter().copied())),
        };
        Err(Error::input(format!("{missing}; {has}")).at(self.place.clone()))
    }
}

/// Matches a glob with a single backtracking point: the last `*` takes one more character.
fn glob(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((at, taken)) = star else {
                    return false;
                };
                star = Some((at, taken + 1));
                p = at + 1;
                n = taken + 1;
            }
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Lists names in a sentence, separated by commas; many are cut short and counted.
pub(super) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut unique: Vec<&str> = Vec::new();
    for name in names {
        if !unique.contains(&name) {
            unique.push(name);
        }
    }
    let more = unique.len().saturating_sub(LISTED);
    unique.truncate(LISTED);
    let mut text = unique.join(", ");
    if more > 0 {
        text.push_str(&format!(" and {more} more"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(text: &str) -> Pattern {
        Pattern {
            text: text.into(),
            place: Some(Position::Line(7)),
        }
    }

    #[test]
    fn globs_match_whole_names() {
        for (glob, name, meant) in [
            ("blade", "blade", true),
            ("blade", "blade_1", false),
            ("blade_*", "blade_1", true),
            ("blade_*", "blade_", true),
            ("blade_?", "blade_", false),
            ("blade_?", "blade_é", true),
            ("*", "", true),
            ("*_tip", "blade_1_tip_tip", true),
            ("a*b*c", "aXbXbYc", true),
            ("a*b*c", "aXbXbY", false),
            ("wall*", "wall*", true),
            ("[a]", "[a]", true),
        ] {
            assert_eq!(pattern(glob).matches(name), meant, "{glob} {name}");
        }
    }

    #[test]
    fn a_missing_name_lists_those_that_are() {
        let error = pattern("blade1")
            .find("tag", &["blade_1", "hub"])
            .expect_err("missing");
        assert_eq!(
            error.to_string(),
            "line 7: tag \"blade1\" is not in the mesh; it has: blade_1, hub"
        );
        let error = pattern("b?").find("zone", &[]).expect_err("missing");
        assert_eq!(
            error.to_string(),
            "line 7: no zone of the mesh matches \"b?\"; it has no zones"
        );
        let names: Vec<String> = (0..99).map(|i| format!("patch_{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = pattern("patch42").find("tag", &names).expect_err("missing");
        assert!(
            error.to_string().contains("did you mean \"patch_42\"?"),
            "{error}"
        );
        assert!(error.to_string().ends_with("and 75 more"), "{error}");
    }
}
