//! Names that CGNS takes: 1 to 32 bytes, no slash, unique among their siblings.

use std::collections::{BTreeMap, BTreeSet};

/// Bytes of the longest name.
pub(super) const LONGEST: usize = 32;

/// Names given to children of one node.
#[derive(Default)]
pub(super) struct Names {
    given: BTreeSet<String>,
    /// The number that a name which is taken gets next.
    next: BTreeMap<String, usize>,
}

impl Names {
    /// The names that CGNS itself gives to children of a zone.
    pub fn of_zone() -> Self {
        let given = [
            "ZoneType",
            "GridCoordinates",
            "ZoneBC",
            "ZoneGridConnectivity",
            "ZoneIterativeData",
            "ArbitraryGridMotion",
            super::arrays::AT_NODES,
            super::arrays::AT_CELLS,
        ];
        Self {
            given: given.map(str::to_owned).into(),
            next: BTreeMap::new(),
        }
    }

    /// The name itself or, where CGNS would not take it, one like it.
    pub fn give(&mut self, name: &str) -> String {
        let first = fitting(name, LONGEST);
        if self.given.insert(first.clone()) {
            return first;
        }
        let next = self.next.entry(first).or_insert(2);
        loop {
            let end = format!("_{next}");
            let wanted = fitting(name, LONGEST - end.len()) + &end;
            *next += 1;
            if self.given.insert(wanted.clone()) {
                return wanted;
            }
        }
    }
}

/// The start of a name, without what CGNS does not take.
fn fitting(name: &str, longest: usize) -> String {
    let allowed = |c: char| if c == '/' || c.is_control() { '_' } else { c };
    let mut fitting: String = name.trim().chars().map(allowed).collect();
    while fitting.len() > longest {
        fitting.pop();
    }
    let fitting = fitting.trim_end();
    match fitting {
        "" => "unnamed".to_owned(),
        "." | ".." => "_".to_owned(),
        fitting => fitting.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_stay_unique() {
        let mut names = Names::default();
        let long = "a boundary with a name of more than 32 bytes";
        assert_eq!(names.give("hub"), "hub");
        assert_eq!(names.give(long), "a boundary with a name of more t");
        assert_eq!(names.give(long), "a boundary with a name of more_2");
        assert_eq!(names.give("a/b"), "a_b");
        assert_eq!(names.give("a_b"), "a_b_2");
        assert_eq!(names.give("a_b_3"), "a_b_3");
        assert_eq!(names.give("a_b"), "a_b_4");
        assert_eq!(names.give("  "), "unnamed");
        let accents = "éééééééééééééééééééé";
        assert_eq!(names.give(accents).len(), 32);
    }
}
