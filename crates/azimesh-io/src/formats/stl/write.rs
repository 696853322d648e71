//! Writing triangles: text with a solid for each tag, or binary.

use super::super::records::{push_real, write_all, write_records};
use super::super::{Encoding, Precision, WriteOptions};
use crate::formats::Notes;
use crate::formats::names::{Places, Rule};
use crate::formats::notes::{coordinates_rounded, quoted};
use crate::formats::rounding::loses_digits;
use crate::mesh::arrays::select_tuples;
use crate::mesh::{CellKind, Cells, Mesh, MeshView, facets::facets};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::vector::{Vector, cross, norm, scale, sub};
use azimesh_core::note;
use std::io::Write;

/// Names as the lines of text have them: some programs end one at a blank, others refuse letters beyond ASCII.
const RULE: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name.trim() {
        "" => "_".to_owned(),
        name => name.replace(|c: char| !c.is_ascii_graphic(), "_"),
    },
    why: "names of solids have characters of ASCII and no blanks",
};

/// Writes a mesh of triangles; returns a note for each thing that is left out.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Write, options: &WriteOptions) -> Result<Notes> {
    let mut notes = Notes::default();
    notes.arrays_left_out("STL", mesh, &[]);
    notes.conditions_left_out("STL", mesh);
    match options.encoding {
        Encoding::Ascii => text(mesh, out, &mut notes)?,
        _ => {
            let single = WriteOptions {
                precision: Precision::F32,
                ..options.clone()
            };
            notes.extend(single.check_coordinates(mesh)?);
            binary(mesh, out, &mut notes)?;
        }
    }
    Ok(notes)
}

fn corners(mesh: &MeshView, cell: usize) -> [Vector; 3] {
    let nodes = mesh.cells.get(cell).nodes;
    [0, 1, 2].map(|i| mesh.points[nodes[i] as usize])
}

/// The unit normal; zero for a triangle without area.
fn normal([a, b, c]: [Vector; 3]) -> Vector {
    let normal = cross(sub(b, a), sub(c, a));
    match norm(normal) {
        0.0 => [0.0; 3],
        length => scale(normal, 1.0 / length),
    }
}

/// The solids: name and triangles. A triangle in several tags is in the first; what is in none comes last, in a solid
/// without a name.
fn solids(mesh: &MeshView, notes: &mut Notes) -> Vec<(String, Vec<usize>)> {
    let groups = mesh.groups.iter().filter(|group| group.dimension == 2);
    notes.joined(groups.clone());
    let written = RULE.by_name(groups.clone().map(|group| group.name.as_str()));
    let mut is_free = vec![true; mesh.cells.len()];
    let mut n_again = 0;
    let mut solids: Vec<(String, Vec<usize>)> = Vec::new();
    let mut places = Places::default();
    for group in groups {
        let name = &written[group.name.as_str()];
        notes.extend(RULE.note("tag", &group.name, name));
        let own = group.cells.iter().filter(|cell| {
            n_again += usize::from(!is_free[*cell]);
            std::mem::take(&mut is_free[*cell])
        });
        let solid = places.entry(name, &mut solids, || (name.clone(), Vec::new()));
        solid.1.extend(own);
    }
    notes.count(n_again, |n| {
        note!(
            "one_solid",
            "a face is in one solid of STL; further tags of faces that have several are left out ({n})"
        )
    });
    let left: Vec<usize> = (0..is_free.len()).filter(|cell| is_free[*cell]).collect();
    if !left.is_empty() || solids.is_empty() {
        solids.push((String::new(), left));
    }
    solids
}

fn text(mesh: &MeshView, out: &mut dyn Write, notes: &mut Notes) -> Result<()> {
    let vector = |buffer: &mut Vec<u8>, before: &str, vector: Vector| {
        buffer.extend_from_slice(before.as_bytes());
        for x in vector {
            buffer.push(b' ');
            push_real(buffer, x);
        }
    };
    for (name, cells) in solids(mesh, notes) {
        let [begin, end] = ["solid", "endsolid"].map(|word| format!("{word} {name}"));
        write_all(out, format!("{}\n", begin.trim_end()).as_bytes())?;
        write_records(out, cells.len(), &|range, buffer| {
            for &cell in &cells[range] {
                let corners = corners(mesh, cell);
                vector(buffer, " facet normal", normal(corners));
                buffer.extend_from_slice(b"\n  outer loop\n");
                for corner in corners {
                    vector(buffer, "   vertex", corner);
                    buffer.push(b'\n');
                }
                buffer.extend_from_slice(b"  endloop\n endfacet\n");
            }
        })?;
        write_all(out, format!("{}\n", end.trim_end()).as_bytes())?;
    }
    Ok(())
}

fn binary(mesh: &MeshView, out: &mut dyn Write, notes: &mut Notes) -> Result<()> {
    let names = mesh.groups.iter().filter(|group| group.dimension == 2);
    let names: Vec<String> = names.map(|group| group.name.clone()).collect();
    notes.list(names, |names| {
        note!(
            "names_in_text",
            "binary STL has no tags; left out: {} ({} ascii writes a solid for each)",
            quoted(&names).join(", "),
            option("encoding")
        )
    });
    if loses_digits(mesh) {
        notes.push(coordinates_rounded());
    }
    let n = mesh.cells.len();
    let n = u32::try_from(n).map_err(|_| {
        let most = u32::MAX;
        Error::input(format!(
            "there are {n} triangles; binary STL counts up to {most}"
        ))
    })?;
    let mut head = [b' '; 80];
    let title = b"triangles written by azimesh";
    head[..title.len()].copy_from_slice(title);
    write_all(out, &head)?;
    write_all(out, &n.to_le_bytes())?;
    write_records(out, mesh.cells.len(), &|range, buffer| {
        for cell in range {
            let corners = corners(mesh, cell);
            for x in [normal(corners)].iter().chain(&corners).flatten() {
                buffer.extend_from_slice(&(*x as f32).to_le_bytes());
            }
            buffer.extend_from_slice(&[0, 0]);
        }
    })
}

/// The surface with its faces cut into triangles and without edges and vertices; groups and arrays follow.
pub(super) fn triangles(mut mesh: Mesh, notes: &mut Notes) -> Mesh {
    let is_triangle = |kind| kind == CellKind::Triangle;
    if mesh.cells.runs().all(|run| is_triangle(run.kind)) {
        return mesh;
    }
    let (mut cut, mut sources) = (Cells::new(), Vec::new());
    // Where the triangles of each cell begin.
    let mut starts = vec![0];
    let (mut n_cut, mut n_lower) = (0, 0);
    for cell in mesh.cells.iter() {
        if cell.kind.dimension() == 2 {
            n_cut += usize::from(!is_triangle(cell.kind));
            for corners in facets(cell.kind, cell.nodes.len()) {
                cut.push(CellKind::Triangle, &corners.map(|i| cell.nodes[i]));
                sources.push(cell.index);
            }
        } else {
            n_lower += 1;
        }
        starts.push(sources.len());
    }
    notes.lower_cells(n_lower);
    notes.count(n_cut, |n| {
        note!(
            "cut_into_triangles",
            "faces of four corners or more are cut into triangles ({n})"
        )
    });
    for group in &mut mesh.groups {
        let own = group.cells.iter();
        group.cells = own
            .flat_map(|cell| starts[cell]..starts[cell + 1])
            .collect();
    }
    mesh.groups.retain(|group| group.dimension == 2);
    select_tuples(&mut mesh.cell_arrays, &sources);
    mesh.cells = cut;
    mesh
}
