//! Numbers that Fluent gives types of zones.

/// Faces between two cells.
pub(super) const INTERIOR: u32 = 2;
/// Faces that were refined: other faces stand in their place.
pub(super) const PARENT: u32 = 31;
/// Cells that were refined.
pub(super) const INACTIVE: u32 = 32;
/// From here on, faces are where two zones of an interface overlap; they lie on the faces of these.
pub(super) const OVERLAP: u32 = 1000;

/// The word for a type of zones of faces.
pub(super) fn of_faces(kind: u32) -> &'static str {
    match kind {
        INTERIOR => "interior",
        3 => "wall",
        4 => "pressure-inlet",
        5 => "pressure-outlet",
        7 => "symmetry",
        8 => "periodic-shadow",
        9 => "pressure-far-field",
        10 => "velocity-inlet",
        12 => "periodic",
        14 => "fan",
        20 => "mass-flow-inlet",
        24 => "interface",
        25 => "overset",
        PARENT => "parent",
        36 => "outflow",
        37 => "axis",
        _ => "boundary",
    }
}

/// The word for a type of zones of cells, as HDF5 files number them.
pub(super) fn of_cells(kind: u32) -> &'static str {
    match kind {
        17 => "solid",
        INACTIVE => "inactive",
        _ => "fluid",
    }
}
