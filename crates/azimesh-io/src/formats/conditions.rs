//! Types of boundary conditions in the words of CGNS, for formats that know these.

/// Types of patches of OpenFOAM and what they are in CGNS.
const OF_OPENFOAM: &[(&str, &str)] = &[
    ("wall", "BCWall"),
    ("symmetry", "BCSymmetryPlane"),
    ("symmetryPlane", "BCSymmetryPlane"),
];

/// A condition in CGNS's word, where there is one for it; else as it is.
pub fn in_cgns(condition: &str) -> &str {
    let known = OF_OPENFOAM.iter().find(|(word, _)| *word == condition);
    known.map_or(condition, |(_, in_cgns)| in_cgns)
}
