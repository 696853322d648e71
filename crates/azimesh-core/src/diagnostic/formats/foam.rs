//! Notes on OpenFOAM cases.

use super::{LISTED, more, quoted};
use crate::diagnostic::notes::notes;
use crate::error::counted;

notes! {
/// What a user should know of an OpenFOAM case.
#[allow(missing_docs)] // the names of the fields say it
Foam {
    /// The case has regions besides its own mesh.
    Regions { names: Vec<String> } => (
        "the case has regions with meshes of their own: {}{}; constant/REGION is read alone",
        quoted(&names[..names.len().min(LISTED)]), more(names.len(), LISTED)
    )
    /// The folders of times have fields.
    Fields { n: usize } => ("the fields of {} are not read", counted(*n, "time"))
    /// Zones of faces or points.
    Zones { what: &'static str, names: Vec<String> } => (
        "{what} are kept for OpenFOAM alone: {}{}",
        quoted(&names[..names.len().min(LISTED)]), more(names.len(), LISTED)
    )
    /// A case has its mesh whole and in pieces.
    PiecesLeft { n: usize } => (
        "the case is decomposed too, in {}; the whole mesh is read, and not its pieces: they are where constant/polyMesh is not there",
        counted(*n, "folder")
    )
    /// Patches that belong together, with their type.
    Pairs { pairs: Vec<(String, [String; 2])> } => ("{}", listed_pairs(pairs))
    /// A case was joined from its pieces.
    Joined { n: usize, by: &'static str } => ("the mesh is joined from {} by {by}", counted(*n, "piece"))
}
}

fn listed_pairs(pairs: &[(String, [String; 2])]) -> String {
    let each = pairs.iter().take(LISTED);
    let each = each.map(|(kind, [one, other])| format!("\"{one}\" and \"{other}\" ({kind})"));
    let each: Vec<String> = each.collect();
    format!(
        "pairs of patches: {}{}",
        each.join(", "),
        more(pairs.len(), LISTED)
    )
}
