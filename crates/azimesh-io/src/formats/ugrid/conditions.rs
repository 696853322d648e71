//! Boundary conditions: FUN3D's numbers, and their names in CGNS.

use crate::formats::names::in_cgns;

/// A line of a `.mapbc`: a face number with its condition and name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Patch {
    /// Number of the faces.
    pub number: i32,
    /// FUN3D's number of the boundary condition.
    pub condition: i32,
    /// Name, where there is one.
    pub name: Option<String>,
}

/// The name of each number. A name is written as its first number.
const TABLE: &[(i32, &str)] = &[
    (3000, "BCWallInviscid"),
    (4000, "BCWallViscous"),
    (5000, "BCFarfield"),
    (5026, "BCExtrapolate"),
    (5051, "BCOutflow"),
    (6662, "BCSymmetryPlane"),
    (7011, "BCTunnelInflow"),
    (7012, "BCTunnelOutflow"),
    (7036, "BCInflow"),
    (7100, "BCInflowSupersonic"),
    // Others that say the same with less detail. 3, 4 and 5 are the numbers of old grids.
    (3, "BCFarfield"),
    (4, "BCWallViscous"),
    (5, "BCWallInviscid"),
    (4100, "BCWallViscous"),
    (4110, "BCWallViscous"),
    (5005, "BCFarfield"),
    (5025, "BCFarfield"),
    (5050, "BCFarfield"),
    (5052, "BCOutflow"),
    (6021, "BCSymmetryPlane"),
    (6022, "BCSymmetryPlane"),
    (6023, "BCSymmetryPlane"),
    (6661, "BCSymmetryPlane"),
    (6663, "BCSymmetryPlane"),
    (7031, "BCOutflow"),
];

/// Names of CGNS without a number in FUN3D, and the number of the most similar condition.
const NEAREST: &[(&str, i32)] = &[
    ("BCWall", 4000),
    ("BCWallViscousHeatFlux", 4000),
    ("BCWallViscousIsothermal", 4000),
    ("BCInflowSubsonic", 7011),
    ("BCOutflowSubsonic", 7012),
    ("BCOutflowSupersonic", 5026),
];

/// The name of symmetry planes; their number depends on the direction of the normal.
pub(super) const SYMMETRY: &str = "BCSymmetryPlane";

/// The condition with this number: a word where there is one, otherwise its digits. 0 is none.
pub(super) fn condition(number: i32) -> Option<String> {
    let word = TABLE.iter().find(|(of, _)| *of == number);
    match word {
        Some((_, word)) => Some((*word).to_owned()),
        None => (number != 0).then(|| number.to_string()),
    }
}

/// The number of a condition, where it has one; for a symmetry plane `normal` is the axis.
pub(super) fn number(condition: &str, normal: usize) -> Option<i32> {
    let condition = in_cgns(condition);
    if condition == SYMMETRY {
        return Some(6661 + normal as i32);
    }
    let own = TABLE.iter().find(|(_, word)| *word == condition);
    let own = own.map(|(number, _)| *number);
    let nearest = NEAREST.iter().find(|(word, _)| *word == condition);
    own.or(nearest.map(|(_, number)| *number))
        .or_else(|| condition.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_comes_back_as_one_of_the_same_meaning() {
        for (of, word) in TABLE {
            let back = number(word, 1).expect("it has a number");
            assert_eq!(condition(back).as_deref(), Some(*word), "{of}");
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
