//! Names that CGNS takes: 1 to 32 characters of ASCII, no slash, unique among their siblings.

use crate::formats::names::{Given, Rule, cut};

/// Bytes of the longest name.
pub(super) const LONGEST: usize = 32;

/// The rule for names in CGNS.
pub(super) const RULE: Rule = Rule {
    longest: LONGEST,
    fit: fitting,
    why: "names in CGNS have at most 32 characters of ASCII and no slash",
};

/// Names given to children of one node.
#[derive(Default)]
pub(super) struct Names(Given);

impl Names {
    /// With names that CGNS, or azimesh, gives to other children.
    pub fn with<'a>(taken: impl IntoIterator<Item = &'a str>) -> Self {
        Self(Given::with(taken))
    }

    /// The names that CGNS itself gives to children of a zone.
    pub fn of_zone() -> Self {
        Self::with([
            "ZoneType",
            "GridCoordinates",
            "ZoneBC",
            "ZoneGridConnectivity",
            "ZoneIterativeData",
            "ArbitraryGridMotion",
            super::arrays::AT_NODES,
            super::arrays::AT_CELLS,
            super::super::CELL_ORDER,
        ])
    }

    /// The name itself or, where CGNS would not take it, one like it.
    pub fn give(&mut self, name: &str) -> String {
        self.0.give(name, &RULE)
    }

    /// Gives several names; those that need no change come first.
    pub fn give_all(&mut self, names: &[&str]) -> Vec<String> {
        self.0.give_all(names, &RULE)
    }
}

/// The start of a name, without what CGNS does not take.
fn fitting(name: &str, longest: usize) -> String {
    let is_allowed = |c: char| c != '/' && (c == ' ' || c.is_ascii_graphic());
    let fitting = name.trim().replace(|c| !is_allowed(c), "_");
    let fitting = cut(&fitting, longest);
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
        assert_eq!(names.give("Fläche é"), "Fl_che _");
        assert_eq!(names.give("Flüche è"), "Fl_che __2");
    }
}
