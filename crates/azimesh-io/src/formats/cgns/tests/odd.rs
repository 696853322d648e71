//! What real files have and the standard has not: it costs no more than itself, and is told.

use super::*;
use azimesh_core::diagnostic::formats::Read;

#[test]
fn odd_parts_cost_no_more_than_themselves_and_are_told() {
    let (mesh, notes) = load("odd_parts.cgns", None);
    let solids: Vec<usize> = (0..mesh.cells.len())
        .filter(|&cell| mesh.cells.get(cell).kind == CellKind::Hexahedron)
        .collect();
    assert_eq!(solids.len(), 2);
    let tags = faces(&mesh);
    assert_eq!(tags["low"], [set(&[0, 3, 6, 9])].into());
    assert!(
        !tags.contains_key("Air") && !tags.contains_key("ORPHAN"),
        "{tags:?}"
    );
    let air = mesh
        .zones()
        .find(|zone| zone.name == "Air")
        .expect("the section has that name");
    assert_eq!(air.cells.iter().collect::<Vec<_>>(), solids);
    let polygons = mesh
        .cells
        .iter()
        .filter(|cell| cell.kind == CellKind::Polygon);
    assert_eq!(polygons.count(), 1);
    let notes: Vec<Diagnostic> = notes.iter().cloned().collect();
    for note in [
        Read::BrokenLinks {
            files: vec!["nowhere.cgns".to_owned()],
        },
        Read::ZoneKind {
            zone: "/Base/Zone".to_owned(),
            found: "U".to_owned(),
            meant: "Unstructured",
        },
        Read::DegeneratePolygons {
            zone: "/Base/Flat".to_owned(),
            n: 1,
        },
    ] {
        assert!(notes.contains(&note.clone().into()), "{note:?}: {notes:?}");
    }
}
