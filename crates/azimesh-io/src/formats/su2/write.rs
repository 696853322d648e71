//! Writing SU2: for each zone its cells, nodes, markers, and text that only SU2 understands; and the file of surface
//! nodes that SU2 reads at each iteration of an unsteady run with `SURFACE_MOVEMENT= EXTERNAL`.

use super::super::WriteOptions;
use super::super::records::{push_integer, push_real, write_all, write_records};
use super::parts::{Marker, RULE, WrittenZones, of_markers};
use super::{Extra, OWN_NODES, holds};
use crate::formats::Notes;
use crate::formats::names::names_in;
use crate::formats::notes::quoted;
use crate::formats::portable::remedy;
use crate::mesh::{CellRun, Group, MeshView, n_walls};
use azimesh_core::error::{Error, Result};
use azimesh_core::{Note, note};
use std::io::Write;
use std::ops::Range;

/// Writes the mesh; returns a note for each thing that is left out.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Write, options: &WriteOptions) -> Result<Notes> {
    let dimension = usize::from(mesh.dimension());
    check(mesh, dimension)?;
    let parts = WrittenZones::of(mesh);
    let n_zones = parts.zones.len();
    let texts = Extra::ALL.into_iter();
    let texts = texts.filter(|extra| extra.texts(mesh, n_zones).is_some());
    let numbers = own_nodes(mesh, n_zones).map(|_| OWN_NODES);
    let kept: Vec<_> = texts.map(Extra::array).chain(numbers).collect();
    let mut notes = Notes::default();
    notes.arrays_left_out("SU2", mesh, &kept);
    notes.in_64_bits("SU2", options);
    if dimension == 2 {
        notes.extend(height(mesh)?);
    }
    notes.joined(of_markers(mesh));
    notes.extend(zone_names(mesh, &parts));
    if parts.is_reordered {
        notes.push(note!(
            "nodes_by_zone",
            "nodes are written zone by zone, so their order changes"
        ));
    }
    note_dropped(mesh, &mut notes);
    notes.count(n_walls(mesh), |n| {
        note!(
            "walls_share_nodes",
            "walls without thickness share the nodes of both sides ({n} faces), and SU2 lets the flow pass through them"
        )
    });
    let markers = parts.zones.iter().flat_map(|part| &part.markers);
    notes.extend(markers.filter_map(|marker| RULE.note("tag", &marker.name, &marker.written)));
    if n_zones > 1 {
        let text = format!("NDIME= {dimension}\nNZONE= {n_zones}\n");
        write_all(out, text.as_bytes())?;
    }
    for zone in 0..n_zones {
        if n_zones > 1 {
            write_all(out, format!("IZONE= {}\n", zone + 1).as_bytes())?;
        }
        write_zone(mesh, &parts, zone, out)?;
    }
    Ok(notes)
}

/// The second number of `NPOIN=` of each zone, where there is one for each of `n_zones`.
fn own_nodes(mesh: &MeshView, n_zones: usize) -> Option<Vec<i64>> {
    let numbers = mesh.field_array(OWN_NODES)?.values.to_integers()?;
    (numbers.len() == n_zones).then_some(numbers)
}

/// One zone, with the text that only SU2 understands.
fn write_zone(
    mesh: &MeshView,
    parts: &WrittenZones,
    zone: usize,
    out: &mut dyn Write,
) -> Result<()> {
    let n_zones = parts.zones.len();
    let text = |extra: Extra| extra.texts(mesh, n_zones).map_or("", |texts| &texts[zone]);
    let part = &parts.zones[zone];
    let dimension = usize::from(mesh.dimension());
    let n_cells: usize = part.cells.iter().map(|range| range.len()).sum();
    let offset = text(Extra::Offset);
    let head = format!("NDIME= {dimension}\n{offset}NELEM= {n_cells}\n");
    write_all(out, head.as_bytes())?;
    let mut index = 0;
    for run in runs_in(mesh, &part.cells) {
        write_cells(&run, parts, Some(index), out)?;
        index += run.n_cells();
    }
    let own = own_nodes(mesh, n_zones).map(|own| own[zone]);
    write_points(mesh, part.nodes.as_deref(), own, out)?;
    let exchange = text(Extra::Exchange);
    let n_exchanges = exchange.matches("MARKER_TAG=").count();
    let n_markers = part.markers.len() + n_exchanges;
    write_all(out, format!("NMARK= {n_markers}\n").as_bytes())?;
    for Marker { written, cells, .. } in &part.markers {
        let n: usize = cells.iter().map(|range| range.len()).sum();
        let head = format!("MARKER_TAG= {written}\nMARKER_ELEMS= {n}\n");
        write_all(out, head.as_bytes())?;
        for run in runs_in(mesh, cells) {
            write_cells(&run, parts, None, out)?;
        }
    }
    for text in [exchange, text(Extra::Periodic), text(Extra::Boxes)] {
        write_all(out, text.as_bytes())?;
    }
    Ok(())
}

fn runs_in<'a>(mesh: &MeshView<'a>, ranges: &[Range<usize>]) -> impl Iterator<Item = CellRun<'a>> {
    let cells = mesh.cells;
    ranges.iter().flat_map(|range| cells.runs_in(range.clone()))
}

/// Refuses what SU2 cannot hold.
fn check(mesh: &MeshView, dimension: usize) -> Result<()> {
    if !matches!(dimension, 2 | 3) {
        return Err(Error::input(format!(
            "SU2 holds meshes of dimension 2 or 3; this one has dimension {dimension}"
        )));
    }
    let boundary = mesh.boundary_tags().flat_map(|tag| tag.cells.ranges());
    let boundary = boundary.flat_map(|range| mesh.cells.runs_in(range));
    let mut runs = mesh.volume_runs().chain(boundary);
    if let Some(run) = runs.find(|run| !holds(run.kind)) {
        let (cell, name, remedy) = (run.first_cell, run.kind.name(), remedy(run.kind));
        return Err(Error::input(format!(
            "cell {cell} is a {name}, which SU2 cannot hold{remedy}"
        )));
    }
    Ok(())
}

/// Plane meshes are written without z: refuses one that is not plane, to round-off; a sentence
/// about the height of one that is.
fn height(mesh: &MeshView) -> Result<Option<Note>> {
    let Some([low, high]) = mesh.bounds() else {
        return Ok(None);
    };
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    if high[2] - low[2] > 1e-12 * size {
        let ([.., low], [.., high], turned) = (low, high, mesh.turned_flat());
        return Err(Error::input(format!(
            "z goes from {low} to {high}; SU2 holds meshes of dimension 2 only in a plane of constant z{turned}"
        )));
    }
    let lies_flat = low[2] == 0.0 && high[2] == 0.0;
    let z = high[2];
    let note = || {
        note!(
            "height_left_out",
            "SU2 holds no z coordinate for a plane mesh; z = {z} is left out"
        )
    };
    Ok((!lies_flat).then(note))
}

/// A note on zones that are left out or lose their names.
fn zone_names(mesh: &MeshView, parts: &WrittenZones) -> Option<Note> {
    let dimension = mesh.dimension();
    let names = names_in(mesh, dimension..dimension + 1);
    if names.is_empty() {
        return None;
    }
    let n = parts.zones.len();
    if n == 1 {
        let held = "SU2 holds zones only where two or more make up the mesh and share no nodes";
        let names = quoted(&names).join(", ");
        return Some(note!("zones_left_out", "{held}; left out: {names}"));
    }
    let is_numbered = |(i, name): (usize, &String)| *name == (i + 1).to_string();
    let keeps_names = names.iter().enumerate().all(is_numbered);
    (!keeps_names).then(|| {
        let names = quoted(&names).join(", ");
        note!(
            "zone_names",
            "zones are written as IZONE= 1 to {n}; names left out: {names}"
        )
    })
}

/// Notes on cells and groups of lower dimension that are not written.
fn note_dropped(mesh: &MeshView, notes: &mut Notes) {
    let dimension = mesh.dimension();
    let format = "SU2";
    notes.lower_groups(format, names_in(mesh, 1..dimension.saturating_sub(1)));
    let mut is_tagged = vec![false; mesh.cells.len()];
    let is_point = |group: &&Group| group.dimension == 0 && dimension > 1;
    let points = mesh.groups.iter().filter(is_point);
    let tags = mesh.boundary_tags().chain(points);
    for cell in tags.flat_map(|tag| tag.cells.iter()) {
        is_tagged[cell] = true;
    }
    let (mut n_faces, mut n_lower) = (0, 0);
    for run in mesh.cells.runs() {
        let of = run.kind.dimension();
        let cells = &is_tagged[run.range()];
        let n_untagged = || cells.iter().filter(|tagged| !**tagged).count();
        if of + 1 == dimension {
            n_faces += n_untagged();
        } else if of < dimension {
            n_lower += n_untagged();
        }
    }
    notes.count(n_faces, |n| {
        note!(
            "untagged_left_out",
            "boundary elements without a tag are left out ({n})"
        )
    });
    notes.lower_cells(n_lower);
    notes.conditions_left_out(format, mesh);
}

/// Type and nodes of each cell, and its index where `first_index` is given.
fn write_cells(
    run: &CellRun,
    parts: &WrittenZones,
    first_index: Option<usize>,
    out: &mut dyn Write,
) -> Result<()> {
    let kind = u64::from(run.kind.vtk());
    write_records(out, run.n_cells(), &|range, buffer| {
        for i in range {
            push_integer(buffer, kind);
            for node in &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes] {
                buffer.push(b' ');
                push_integer(buffer, parts.local(*node).into());
            }
            if let Some(first) = first_index {
                buffer.push(b' ');
                push_integer(buffer, (first + i) as u64);
            }
            buffer.push(b'\n');
        }
    })
}

/// All nodes, or the nodes of a zone; `own` of them are no copies, where that is known.
fn write_points(
    mesh: &MeshView,
    nodes: Option<&[u32]>,
    own: Option<i64>,
    out: &mut dyn Write,
) -> Result<()> {
    let dimension = usize::from(mesh.dimension());
    let n = nodes.map_or(mesh.points.len(), <[u32]>::len);
    let own = own.filter(|own| *own >= 0);
    let own = own.map_or_else(String::new, |own| format!(" {own}"));
    write_all(out, format!("NPOIN= {n}{own}\n").as_bytes())?;
    write_records(out, n, &|range, buffer| {
        for i in range {
            let node = nodes.map_or(i, |nodes| nodes[i] as usize);
            for x in &mesh.points[node][..dimension] {
                push_real(buffer, *x);
                buffer.push(b' ');
            }
            push_integer(buffer, i as u64);
            buffer.push(b'\n');
        }
    })
}

/// Writes the positions of some nodes: index, x, y and, in space, z. SU2 takes a line that is no node for node 0, so
/// that there is no header, and moves a node of a moving marker that is not in the file to the origin.
///
/// # Errors
/// If they cannot be written.
pub fn write_surface(mesh: &MeshView, nodes: &[u32], out: &mut dyn Write) -> Result<()> {
    let dimension = usize::from(mesh.dimension().clamp(2, 3));
    write_records(out, nodes.len(), &|range, buffer| {
        for &node in &nodes[range] {
            push_integer(buffer, node.into());
            for x in &mesh.points[node as usize][..dimension] {
                buffer.push(b' ');
                push_real(buffer, *x);
            }
            buffer.push(b'\n');
        }
    })
}

/// The number of SU2 zones that a mesh is written in; each numbers its nodes from 0.
pub fn n_zones(mesh: &MeshView) -> usize {
    match mesh.zones().next() {
        None => 1,
        Some(_) => WrittenZones::of(mesh).zones.len(),
    }
}
