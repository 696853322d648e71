//! Writing UGRID in every layout: counts, nodes, boundary faces and their numbers, solid cells.

use super::super::WriteOptions;
use super::super::records::{push_integer, push_real, write_all, write_records};
use super::faces::{self, FaceNumbers};
use super::fortran::Record;
use super::layout::{Counts, KINDS, Layout, N_FACE_KINDS, in_order};
use super::mapbc;
use crate::formats::names::names_in;
use crate::formats::notes::{coordinates_rounded, quoted};
use crate::formats::portable::remedy;
use crate::formats::rounding::{flattened, loses_digits};
use crate::formats::{Notes, Out};
use crate::mesh::{CellKind, CellRun, MeshView, first_where};
use azimesh_core::error::{Error, Result};
use azimesh_core::note;

/// Writes the mesh; returns a note for each thing that is left out.
pub(super) fn write(
    mesh: &MeshView,
    out: &mut dyn Out,
    layout: &Layout,
    options: &WriteOptions,
) -> Result<Notes> {
    check(mesh)?;
    let counts = counts(mesh, layout)?;
    let tags = faces::tags(mesh);
    let numbers = FaceNumbers::of(mesh, &tags);
    let mut notes = Notes::default();
    notes.arrays_left_out("UGRID", mesh, faces::KEPT);
    let is_single = layout.is_some_and(|binary| binary.real == 4);
    if is_single {
        note_rounding(mesh, &mut notes)?;
    } else {
        notes.in_64_bits("UGRID", options);
    }
    note_dropped(mesh, &mut notes);
    notes.count(numbers.n_shared, |n| {
        note!(
            "face_tags_left_out",
            "UGRID holds one tag for each face; further tags of faces that have several are left out ({n})"
        )
    });
    notes.count(numbers.n_untagged, |n| {
        let (number, name) = (numbers.untagged, mapbc::untagged(&tags));
        note!(
            "untagged_numbered",
            "boundary faces without a tag ({n}) get number {number}, \"{name}\""
        )
    });
    mapbc::note_changes(mesh, &tags, &numbers, &mut notes);
    let mut head = Vec::new();
    push_integers(layout, counts.numbers(), &mut head);
    if let Some(binary) = layout.filter(|binary| binary.has_records) {
        let failed = |error: std::io::Error| Error::system(error.to_string());
        let mut record = Record::new(out, &binary, head.len() as u64).map_err(failed)?;
        write_all(&mut record, &head)?;
        let mut record = Record::new(out, &binary, binary.body(&counts) as u64).map_err(failed)?;
        write_body(mesh, &numbers, layout, &mut record)?;
    } else {
        write_all(out, &head)?;
        write_body(mesh, &numbers, layout, out)?;
    }
    Ok(notes)
}

/// Checks if other ranks can write the nodes of the cells of a mesh.
pub(super) fn takes_cells_apart(mesh: &MeshView, layout: &Layout) -> bool {
    let mut tags = mesh.boundary_tags();
    let needs_positions = tags.any(|tag| faces::has_number_by_positions(mesh, tag));
    check(mesh).is_ok() && counts(mesh, layout).is_ok() && !needs_positions
}

/// Refuses what UGRID cannot hold.
fn check(mesh: &MeshView) -> Result<()> {
    if mesh.dimension() != 3 {
        return Err(Error::input(format!(
            "UGRID holds meshes of dimension 3; this one has dimension {}",
            mesh.dimension()
        )));
    }
    let mut runs = mesh.cells.runs();
    let is_odd = |run: &CellRun| run.kind.dimension() >= 2 && !KINDS.contains(&run.kind);
    let Some(run) = runs.find(is_odd) else {
        return Ok(());
    };
    let remedy = remedy(run.kind);
    Err(Error::input(format!(
        "cell {} is a {}, which UGRID cannot hold{remedy}",
        run.first_cell,
        run.kind.name()
    )))
}

fn counts(mesh: &MeshView, layout: &Layout) -> Result<Counts> {
    let n_cells = KINDS.map(|kind| runs(mesh, kind).map(|run| run.n_cells()).sum());
    let counts = Counts {
        n_nodes: mesh.points.len(),
        n_cells,
    };
    let largest = counts.numbers().max().unwrap_or(0);
    let is_narrow = layout.is_some_and(|binary| binary.integer == 4);
    if is_narrow && largest > i32::MAX as u64 {
        return Err(Error::input(format!(
            "the count {largest} does not fit 32 bits; ugrid-b8l and ugrid-lb8l have 64"
        )));
    }
    Ok(counts)
}

fn runs<'a>(mesh: &MeshView<'a>, kind: CellKind) -> impl Iterator<Item = CellRun<'a>> {
    mesh.cells.runs().filter(move |run| run.kind == kind)
}

/// Notes on coordinates that lose digits; refuses those that do not fit 32 bits.
fn note_rounding(mesh: &MeshView, notes: &mut Notes) -> Result<()> {
    let values = mesh.points.as_flattened();
    let too_large = |x: &f64| !(*x as f32).is_finite();
    if let Some(at) = first_where(values, too_large) {
        let x = values[at];
        return Err(Error::input(format!(
            "the coordinate {x} does not fit 32 bits; ugrid-b8 and ugrid-lb8 have 64"
        )));
    }
    if loses_digits(mesh) {
        notes.push(coordinates_rounded());
    }
    notes.extend(flattened(mesh));
    Ok(())
}

/// Notes on cells and groups that are not written.
fn note_dropped(mesh: &MeshView, notes: &mut Notes) {
    notes.list(names_in(mesh, 3..4), |names| {
        let names = quoted(&names).join(", ");
        note!("zones_left_out", "UGRID holds no zones; left out: {names}")
    });
    notes.lower_groups("UGRID", names_in(mesh, 0..2));
    let lower = mesh.cells.runs().filter(|run| run.kind.dimension() < 2);
    let n_lower: usize = lower.map(|run| run.n_cells()).sum();
    notes.lower_cells(n_lower);
}

fn write_body(
    mesh: &MeshView,
    numbers: &FaceNumbers,
    layout: &Layout,
    out: &mut dyn Out,
) -> Result<()> {
    let coordinates = layout.map(|binary| binary.coordinates());
    if let Some(apart) = coordinates.and_then(|numbers| mesh.coordinates_apart(numbers)) {
        out.apart(&apart, 0)?;
    } else {
        write_records(out, mesh.points.len(), &|range, buffer| {
            let points = &mesh.points[range];
            match coordinates {
                Some(coordinates) => coordinates.append(points, buffer),
                None => points.iter().for_each(|p| push_line(*p, push_real, buffer)),
            }
        })?;
    }
    for kind in &KINDS[..N_FACE_KINDS] {
        write_cells(mesh, *kind, layout, out)?;
    }
    for kind in &KINDS[..N_FACE_KINDS] {
        for run in runs(mesh, *kind) {
            let numbers = numbers.of_run(&run);
            write_records(out, numbers.len(), &|range, buffer| {
                for number in &numbers[range] {
                    push_integers(layout, [*number as u64], buffer);
                }
            })?;
        }
    }
    for kind in &KINDS[N_FACE_KINDS..] {
        write_cells(mesh, *kind, layout, out)?;
    }
    Ok(())
}

fn write_cells(mesh: &MeshView, kind: CellKind, layout: &Layout, out: &mut dyn Out) -> Result<()> {
    let listed = layout.map(|binary| binary.nodes_of(kind, mesh.cells.len()));
    if let Some(apart) = listed.and_then(|numbers| mesh.nodes_apart(numbers)) {
        if apart.n_bytes > 0 {
            out.apart(&apart, 0)?;
        }
        return Ok(());
    }
    for run in runs(mesh, kind) {
        let n = run.n_nodes;
        write_records(out, run.n_cells(), &|range, buffer| {
            let nodes = &run.connectivity[range.start * n..range.end * n];
            for cell in in_order(kind, nodes).chunks_exact(n) {
                push_integers(layout, cell.iter().map(|node| u64::from(*node) + 1), buffer);
            }
        })?;
    }
    Ok(())
}

/// Appends integers; as text, a line of them.
fn push_integers(layout: &Layout, values: impl IntoIterator<Item = u64>, buffer: &mut Vec<u8>) {
    let Some(binary) = layout else {
        return push_line(values, push_integer, buffer);
    };
    for value in values {
        match (binary.is_big_endian, binary.integer) {
            (true, 4) => buffer.extend((value as u32).to_be_bytes()),
            (false, 4) => buffer.extend((value as u32).to_le_bytes()),
            (true, _) => buffer.extend(value.to_be_bytes()),
            (false, _) => buffer.extend(value.to_le_bytes()),
        }
    }
}

/// Appends a line of at least one number.
fn push_line<T>(
    values: impl IntoIterator<Item = T>,
    push: impl Fn(&mut Vec<u8>, T),
    buffer: &mut Vec<u8>,
) {
    for value in values {
        push(buffer, value);
        buffer.push(b' ');
    }
    buffer.pop();
    buffer.push(b'\n');
}
