//! Writes a mesh as a .vtu file: `vtk::arrays` decides on the arrays, `file` writes the XML.

use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::order;
use super::super::{Encoding, WriteOptions};
use super::encode::failed;
use super::file::{File, NAMES};
use crate::formats::{Notes, Out};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::io::{BufWriter, Write};

/// Smaller pieces are gathered before they are written; larger ones are written as they are.
const BUFFER: usize = 1 << 20;

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let flattened = options.check_coordinates(mesh)?;
    let mut plan = VtkArrays::new(mesh, options, &NAMES);
    let mut notes = std::mem::take(&mut plan.notes);
    notes.extend(flattened);
    let file = File {
        sections: plan.sections(),
        n_points: mesh.points.len(),
        n_cells: plan.n_cells(),
        lists: None,
        version: version(mesh),
        has_wedges: order::has_wedges(mesh.cells),
        options,
    };
    write_file(&file, out)?;
    Ok(notes)
}

/// Writes a file in the encoding of its options.
pub(super) fn write_file(file: &File<'_>, out: &mut dyn Out) -> Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, out);
    match file.options.encoding {
        Encoding::Raw => file.appended(&mut out)?,
        Encoding::Base64 | Encoding::Ascii => file.inline(&mut out)?,
    }
    out.flush().map_err(failed)
}

/// Files of version 2.1 have the nodes of Lagrange and Bezier hexahedra in VTK's present order;
/// every reader takes 1.0.
fn version(mesh: &MeshView) -> &'static str {
    match mesh.cells.runs().any(|run| order::concerns(run.kind)) {
        true => "2.1",
        false => "1.0",
    }
}
