//! Notes on files of Fluent.

use super::{LISTED, more, quoted};
use crate::diagnostic::notes::notes;
use crate::error::counted;

notes! {
/// What a user should know of a file of Fluent.
#[allow(missing_docs)] // the names of the fields say it
Fluent {
    /// Zones of faces between two cells, which somebody has named.
    Interior { names: Vec<String> } => (
        "zones of faces inside of the mesh are not kept: {}{}",
        quoted(&names[..names.len().min(LISTED)]), more(names.len(), LISTED)
    )
    /// Faces where two zones of an interface overlap.
    Overlaps { n: usize } => (
        "{} where the two sides of an interface overlap are left out: the faces of its sides are read", counted(*n, "face")
    )
    /// Cells with hanging nodes: those that were refined are left out.
    Refined { n: usize } => (
        "the mesh was refined with hanging nodes: {} and faces are left out, and the parts that stand for them are read; their \
         neighbours are polyhedra, or polygons", counted(*n, "refined cell")
    )
    /// Periodic zones and their shadows.
    Periodic { pairs: Vec<[String; 2]> } => ("pairs of periodic zones: {}", listed(pairs))
}
}

fn listed(pairs: &[[String; 2]]) -> String {
    let each = pairs.iter().take(LISTED);
    let each: Vec<String> = each
        .map(|[zone, shadow]| format!("\"{zone}\" and \"{shadow}\""))
        .collect();
    format!("{}{}", each.join(", "), more(pairs.len(), LISTED))
}
