//! Deviations of real files from the standard: they cost no more than themselves, and give a note.

use super::*;

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
    for text in [
        "links lead to files that are not there, and what they stand for is left out: nowhere.cgns",
        "/Base/Zone: ZoneType \"U\" is read as Unstructured",
        "/Base/Flat: 1 polygon is left out, since it has fewer than 3 nodes",
    ] {
        assert!(notes.says(text), "{text}: {notes:?}");
    }
}
