//! The disk space that a run needs.

use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::{amount, with_verb};
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use azimesh_deform::motion::{QualityOutput, Role, SurfaceOutput};
use azimesh_io::formats::{Compression, Format};
use azimesh_io::mesh::MeshView;
use std::path::{Path, PathBuf};

/// The cell arrays of `quality = "cells"`, fifteen of numbers and a flag, and their bytes per cell.
const QUALITY: (u64, u64) = (16, 15 * 8 + 4);
/// Largest size in bytes of the description of an array in a file of one mesh.
const DESCRIPTION: u64 = 600;
/// Numbers as text may be longer than in the counted mesh by this part.
const TEXT: u64 = 50;
/// Largest number of bytes per step in the lists of all steps in one file, and in the offsets of an array in it.
const LISTS: u64 = 16 << 10;
const PLACES: u64 = 3 << 10;

/// Bytes per node in a file of moving surfaces.
const SURFACE_LINE: u64 = 66;

/// The steps and bytes that a run will write.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Demand {
    /// Steps still to be written.
    pub n_steps: u64,
    /// Bytes of the first of them.
    pub first: u64,
    /// Bytes of each of the others.
    pub others: u64,
}

impl Demand {
    /// Computes the demand of `n_steps`, without the `n_kept` of an earlier run. One mesh takes `mesh_bytes` without the added
    /// arrays. If one file holds all steps, constant data are written once.
    pub fn of(
        plan: &Plan,
        mesh: &MeshView<'_>,
        format: &Format,
        (n_steps, n_kept): (usize, usize),
        mesh_bytes: u64,
    ) -> Self {
        let (n_vectors, at_cells) = arrays(plan, format);
        let n_nodes = plan.boundary.n_nodes as u64;
        let whole = mesh_bytes + (n_vectors + at_cells.0) * DESCRIPTION;
        let arrays = n_vectors * n_nodes * 24 + plan.boundary.n_cells as u64 * at_cells.1;
        let (first, others) = match (format.sequence, format.holds.arrays) {
            (Some(_), _) => {
                let n_still = (mesh.point_arrays.len() + mesh.cell_arrays.len()) as u64;
                let n_arrays = 1 + n_vectors + at_cells.0 + n_still;
                let added = arrays + LISTS + n_arrays * PLACES;
                let is_short = format.rounds(plan.schedule.output.precision);
                let coordinates = n_nodes * if is_short { 12 } else { 24 };
                (whole + added, coordinates + added)
            }
            (None, true) => (whole + arrays, whole + arrays),
            (None, false) => (whole + whole / TEXT, whole + whole / TEXT),
        };
        let surface = surface_bytes(plan);
        Self {
            n_steps: (n_steps - n_kept) as u64,
            first: surface + if n_kept == 0 { first } else { others },
            others: surface + others,
        }
    }

    /// Returns the bytes of all steps.
    pub fn bytes(&self) -> u64 {
        match self.n_steps.checked_sub(1) {
            None => 0,
            Some(others) => others
                .saturating_mul(self.others)
                .saturating_add(self.first),
        }
    }
}

/// Returns the bytes of the file of the moving surfaces of a step.
fn surface_bytes(plan: &Plan) -> u64 {
    if plan.schedule.output.surface == SurfaceOutput::None {
        return 0;
    }
    let roles = plan.motion.surface.nodes.roles.iter();
    let n_moving = roles.filter(|role| matches!(role, Role::Moving(_))).count();
    n_moving as u64 * SURFACE_LINE
}

/// Returns the numbers of node arrays of three components and of cell arrays that a run adds to each mesh, and the
/// bytes of the latter per cell.
fn arrays(plan: &Plan, format: &Format) -> (u64, (u64, u64)) {
    let output = &plan.schedule.output;
    let displacement = u64::from(output.displacement && format.holds.displacement);
    match (format.holds.arrays, output.quality) {
        (false, _) => (displacement, (0, 0)),
        (true, quality) => {
            let is_of_cells = quality == QualityOutput::Cells;
            let at_cells = if is_of_cells { QUALITY } else { (0, 0) };
            (displacement + u64::from(output.velocity), at_cells)
        }
    }
}

/// Refuses a run whose meshes do not fit on the disk, or warns if compression may make them fit. `freed` are the bytes of
/// files that it replaces, `taken` the bytes of arrays stored there during the run.
pub(crate) fn check_disk(
    plan: &Plan,
    folder: &Path,
    demand: &Demand,
    (freed, taken): (u64, u64),
) -> Result<Option<Note>> {
    let Ok(free) = fs4::available_space(existing_folder(folder)) else {
        return Ok(None);
    };
    let (needed, free) = (
        demand.bytes(),
        free.saturating_add(freed).saturating_sub(taken),
    );
    if needed <= free {
        return Ok(None);
    }
    let demand = format!(
        "{} {} ({} each), and {} are free",
        with_verb(demand.n_steps as usize, "step", "takes"),
        amount(needed),
        amount(demand.others),
        amount(free)
    );
    if plan.schedule.output.compression != Compression::None {
        let note = note!("little_space", "without compression {demand}");
        return Ok(Some(note.file(folder)));
    }
    Err(Error::system(format!(
        "{demand}; free some space, write fewer steps with --steps, or start anyway with --no-space-check"
    ))
    .file(folder))
}

/// Returns the folder, or its nearest existing parent.
pub fn existing_folder(folder: &Path) -> PathBuf {
    let here = PathBuf::from(".");
    let mut above = folder.ancestors().filter(|path| path.is_dir());
    above.next().map_or(here, Path::to_path_buf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_of_all_steps_takes_the_cells_once() {
        let of = |n_steps, others| Demand {
            n_steps,
            first: 100,
            others,
        };
        assert_eq!(of(0, 24).bytes(), 0);
        assert_eq!(of(1, 24).bytes(), 100);
        assert_eq!(of(10, 24).bytes(), 316);
        assert_eq!(of(10, 100).bytes(), 1000);
    }
}
