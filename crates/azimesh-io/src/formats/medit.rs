//! Medit (.mesh): vertices, edges, faces and cells of first order, and P2 simplices, as text. Read only.
//!
//! The reference of a cell is its tag: a group that the reference names and numbers. References of vertices are the
//! array `medit:ref`.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! let mesh = Mesh::read("testdata/box_by_gmsh.mesh")?;
//! assert_eq!(mesh.dimension(), 3);
//! let tags: Vec<_> = mesh.tags().map(|tag| (tag.name.as_str(), tag.cells.len())).collect();
//! assert_eq!(tags[0], ("1", 4)); // Triangles with the reference 1.
//! # Ok(())
//! # }
//! ```

use super::tokens::{Tokens, shown, without_comments};
use super::{Format, Notes};
use crate::mesh::CellKind::{self, *};
use crate::mesh::{CellSet, Cells, DataArray, Group, Mesh, Values, too_many};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// Medit mesh (.mesh).
pub static MEDIT: Format = Format {
    name: "medit",
    title: "Medit mesh (.mesh)",
    extensions: &["mesh", "meshb"],
    detect: |source| recognizes(source.bytes()),
    read: |source, _, notes| read(source.bytes(), notes),
    ..Format::NEW
};

/// Array of the references of vertices.
const REFERENCES: &str = "medit:ref";

/// Sections of cells, and their kinds. Nodes are in VTK's order.
const KINDS: [(&[u8], CellKind); 10] = [
    (b"Edges", Line),
    (b"Triangles", Triangle),
    (b"Quadrilaterals", Quadrilateral),
    (b"Tetrahedra", Tetrahedron),
    (b"Hexahedra", Hexahedron),
    (b"Prisms", Wedge),
    (b"Pyramids", Pyramid),
    (b"EdgesP2", Line3),
    (b"TrianglesP2", Triangle6),
    (b"TetrahedraP2", Tetrahedron10),
];

/// Beginnings of the sections of other cells: of higher order, where programs differ in the order of nodes, and
/// polyhedra.
const REFUSED: &str = "EdgesP TrianglesP QuadrilateralsQ TetrahedraP HexahedraQ PrismsP PyramidsP Polyhedra Polygons \
    InnerPoly BoundaryPoly";

fn recognizes(head: &[u8]) -> bool {
    let mut words = Tokens::between(head, 0..head.len().min(4096));
    loop {
        match words.word() {
            Some(word) if word.starts_with(b"#") => {
                let rest = words.rest();
                let n = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
                words = Tokens::between(&rest[n..], 0..rest.len() - n);
            }
            word => return word == Some(b"MeshVersionFormatted"),
        }
    }
}

fn read(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    match without_comments(bytes) {
        None => read_plain(bytes, notes),
        Some(plain) => read_plain(&plain, notes),
    }
}

/// Reads a text without comments.
fn read_plain(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    let mut words = Tokens::between(bytes, 0..bytes.len());
    let mut mesh = Mesh::default();
    let mut dimension = None;
    let mut references = None;
    let mut tags = BTreeMap::new();
    let mut left = BTreeSet::new();
    if bytes.trim_ascii_start().starts_with(b"MFEM") {
        let message = "this is a mesh of MFEM, which is not read; write it as VTU or Gmsh's MSH";
        return Err(words.error(message));
    }
    if words.clone().word() != Some(b"MeshVersionFormatted") {
        let message = "the file does not begin with MeshVersionFormatted; binary Medit (.meshb) is not read, which meshio converts";
        return Err(words.error(message));
    }
    while let Some(name) = words.word() {
        match (name, dimension) {
            (b"MeshVersionFormatted", _) => {
                words.integer("the version")?;
            }
            (b"Dimension", _) => match words.integer("the dimension")? {
                n @ (2 | 3) => dimension = Some(n as usize),
                n => return Err(words.error(format!("the dimension is {n}; it must be 2 or 3"))),
            },
            (b"End", _) => break,
            (b"Vertices", None) => return Err(words.error("Vertices come before Dimension")),
            (b"Vertices", Some(dimension)) => {
                if references.is_some() {
                    return Err(words.error("there is a second section of vertices"));
                }
                references = Some(vertices(&mut words, dimension, &mut mesh.points)?);
            }
            _ => {
                if let Some((_, kind)) = KINDS.iter().find(|(section, _)| *section == name) {
                    let Some(n_nodes) = references.as_ref().map(Vec::len) else {
                        let message = format!("{} come before Vertices", name.escape_ascii());
                        return Err(words.error(message));
                    };
                    read_cells(&mut words, *kind, n_nodes, &mut mesh.cells, &mut tags)?;
                } else if REFUSED
                    .split(' ')
                    .any(|refused| name.starts_with(refused.as_bytes()))
                    && !name.ends_with(b"Ordering")
                {
                    let message = "are not read; write the mesh in first order, or as MSH";
                    return Err(words.error(format!("{} {message}", name.escape_ascii())));
                } else if name.first().is_some_and(u8::is_ascii_alphabetic) {
                    left.insert(name.escape_ascii().to_string());
                    pass_numbers(&mut words);
                } else {
                    let found = shown(name);
                    return Err(words.error(format!(
                        "expected the name of a section, found {found}; cells before it may have more nodes than their kind"
                    )));
                }
            }
        }
    }
    let Some(references) = references else {
        return Err(words.error("the file has no Vertices"));
    };
    if references.iter().any(|reference| *reference != 0) {
        let array = DataArray::scalar(REFERENCES, Values::I32(references));
        mesh.point_arrays.push(array);
    }
    let group = |((dimension, number), cells): ((u8, i32), CellSet)| {
        Group::new(dimension, number.to_string(), Some(number), cells)
    };
    mesh.groups = tags.into_iter().map(group).collect();
    notes.names_not_kept("sections", left.into_iter().collect());
    Ok(mesh)
}

/// Moves to the next word that begins with a letter and is not in quotes.
fn pass_numbers(words: &mut Tokens) {
    let mut next = words.clone();
    let mut in_quotes = false;
    while let Some(word) = next.word() {
        if !in_quotes && word[0].is_ascii_alphabetic() {
            break;
        }
        in_quotes ^= word.iter().filter(|byte| **byte == b'"').count() % 2 == 1;
        *words = next.clone();
    }
}

/// Reads the vertices; gives their references.
fn vertices(words: &mut Tokens, dimension: usize, points: &mut Vec<[f64; 3]>) -> Result<Vec<i32>> {
    let n: usize = words.narrow("the number of vertices")?;
    if n >= u32::MAX as usize {
        return Err(words.error(too_many("nodes")));
    }
    let mut references = Vec::new();
    for _ in 0..n {
        let mut point = [0.0; 3];
        for x in &mut point[..dimension] {
            *x = words.real("a coordinate")?;
        }
        points.push(point);
        references.push(words.narrow("the reference of a vertex")?);
    }
    Ok(references)
}

/// Reads cells of one kind and their references; 0 means no tag.
fn read_cells(
    words: &mut Tokens,
    kind: CellKind,
    n_nodes: usize,
    cells: &mut Cells,
    tags: &mut BTreeMap<(u8, i32), CellSet>,
) -> Result<()> {
    let n: usize = words.narrow("the number of cells")?;
    if n >= u32::MAX as usize - cells.len() {
        return Err(words.error(too_many("cells")));
    }
    let mut nodes = vec![0; kind.n_nodes().unwrap_or(0)];
    for _ in 0..n {
        for node in &mut nodes {
            let number: usize = words.narrow("a node of a cell")?;
            if !(1..=n_nodes).contains(&number) {
                let (name, most) = (kind.name(), n_nodes);
                return Err(words.error(format!(
                    "a {name} has node {number}; there are nodes 1 to {most}"
                )));
            }
            *node = number as u32 - 1;
        }
        let reference: i32 = words.narrow("the reference of a cell")?;
        if reference != 0 {
            let tag = tags.entry((kind.dimension(), reference)).or_default();
            tag.push_range(cells.len()..cells.len() + 1);
        }
        cells.push(kind, &nodes);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    fn mesh_of(text: &str) -> (Result<Mesh>, Notes) {
        let mut notes = Notes::default();
        (read(text.as_bytes(), &mut notes), notes)
    }

    const SQUARE: &str = "# by hand\nMeshVersionFormatted 1\nDimension\n2\nVertices 4\n0 0 0\n1 0 0\n1 1 7\n0 1 0\n\
        Edges\n2\n1 2 5\n3 4 0\nTriangles 2\n1 2 3 9 # upper\n1 3 4 8\nCorners 2 1 2\nEnd\n";

    #[test]
    fn a_plane_mesh_has_references_as_tags_and_notes_on_the_rest() {
        let (mesh, notes) = mesh_of(SQUARE);
        let mesh = mesh.expect("a mesh");
        assert!(recognizes(SQUARE.as_bytes()));
        assert_eq!(mesh.points[2], [1.0, 1.0, 0.0]);
        assert_eq!(mesh.cells.len(), 4);
        let groups: Vec<_> = mesh
            .groups
            .iter()
            .map(|g| (g.dimension, &*g.name))
            .collect();
        assert_eq!(groups, [(1, "5"), (2, "8"), (2, "9")]);
        assert_eq!(mesh.groups[1].cells.iter().collect::<Vec<_>>(), [3]);
        assert_eq!(
            mesh.point_arrays[0].values.to_integers(),
            Some(vec![0, 0, 7, 0])
        );
        assert_eq!(notes.len(), 1);
    }

    #[test]
    fn text_in_quotes_has_no_keywords() {
        for text in ["a End b", "Triangles 2", "Dimension 3", "Date: 1", "one"] {
            let section = format!("Identifier \"{text}\"\nDimension\n");
            let (mesh, notes) = mesh_of(&SQUARE.replacen("Dimension\n", &section, 1));
            let mesh = mesh.expect(text);
            assert_eq!((mesh.dimension(), mesh.cells.len()), (2, 4), "{text}");
            let note = notes.iter().next().expect("a note").to_string();
            assert!(!note.contains("Date"), "{note}");
        }
    }

    #[test]
    fn a_mesh_of_mfem_is_refused_by_its_name() {
        let error = mesh_of("MFEM mesh v1.0\n\ndimension\n2\n").0;
        assert_says(&error.expect_err("MFEM").to_string(), "MFEM");
    }

    #[test]
    fn damage_is_refused_with_its_line() {
        for (before, after, line, word) in [
            ("Dimension\n2", "Dimension\n4", 4, "2 or 3"),
            ("1 3 4 8", "1 3 5 8", 16, "node 5"),
            ("Vertices 4", "Vertices 99999999999", 5, "more than"),
            ("Edges", "HexahedraQ2", 10, "first order"),
            ("Corners", "TrianglesP3", 17, "first order"),
            ("Corners", "EdgesP3", 17, "first order"),
            ("Corners", "Polyhedra", 17, "first order"),
            ("Corners", "InnerPolygonHeaders", 17, "first order"),
            ("Corners", "BoundaryPolygonVertices", 17, "first order"),
            ("1 1 7", "1 x 7", 8, "a coordinate"),
            ("1 3 4 8", "1 3 4 8 9", 16, "more nodes"),
            ("Dimension\n2\n", "", 3, "before Dimension"),
        ] {
            let error = mesh_of(&SQUARE.replacen(before, after, 1)).0;
            let error = error.expect_err(after).to_string();
            assert_says(&error, word);
            assert!(error.starts_with(&format!("line {line}:")), "{error}");
        }
        for end in 0..SQUARE.len() {
            let _ = mesh_of(&SQUARE[..end]);
        }
    }
}
