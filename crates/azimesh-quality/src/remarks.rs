//! Remarks on a mesh that its metrics do not cover.

use crate::validity::CurvedMaps;
use azimesh_core::error::counted;
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_io::mesh::Mesh;
use std::ops::Range;

/// Extents of a mesh for which sixth powers of the edges of its cells are in the range of double precision.
const EXTENTS: Range<f64> = 1e-35..1e50;

/// Notes on cells of higher order, and on lengths whose products overflow. All ranks that share a mesh call it, and get the
/// notes of the whole mesh.
pub fn remarks(mesh: &Mesh) -> Vec<Note> {
    let mut remarks = Vec::new();
    let curved = mesh.volume_runs_in(mesh.own_cells());
    let maps = CurvedMaps::new(mesh);
    let is_checked = |kind, n_nodes| maps.of(kind, n_nodes).is_some();
    let curved = curved.filter(|run| run.kind.is_curved() && !is_checked(run.kind, run.n_nodes));
    let n_own: usize = curved.map(|run| run.n_cells()).sum();
    let own = (n_own, mesh.bounds());
    let nothing = (0, None::<[[f64; 3]; 2]>);
    let (cells, bounds) = mesh.ranks().ordered_fold(nothing, own, |all, own| {
        all.0 += own.0;
        all.1 = match (all.1, own.1) {
            (Some([low, high]), Some(own)) => Some([
                std::array::from_fn(|i| f64::min(low[i], own[0][i])),
                std::array::from_fn(|i| f64::max(high[i], own[1][i])),
            ]),
            (all, own) => all.or(own),
        };
    });
    if cells > 0 {
        let cells = counted(cells, "cell");
        remarks.push(note!(
            "corners_alone",
            "{cells} of a curved kind without a proof of validity: checked at the corners only, with straight edges"
        ));
    }
    let [low, high] = bounds.unwrap_or_default();
    let extent = (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(0.0, f64::max);
    if extent > 0.0 && !EXTENTS.contains(&extent) {
        remarks.push(note!(
            "out_of_range",
            "the mesh has an extent of {}: products of lengths leave the range of double precision, and metrics are wrong; use \
             another unit (convert --scale)",
            short(extent)
        ));
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::CellKind;

    #[test]
    fn cells_of_higher_order_and_lengths_out_of_range_are_remarked_on() {
        let mesh = |kind: CellKind, n: u32, scale: f64| {
            let mut mesh = Mesh {
                points: (0..n).map(|i| [scale * f64::from(i), 0.0, 0.0]).collect(),
                ..Mesh::default()
            };
            let nodes: Vec<u32> = (0..n).collect();
            mesh.cells.push(kind, &nodes);
            mesh
        };
        let remarked = |mesh: &Mesh| {
            remarks(mesh)
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
        };
        assert!(remarked(&mesh(CellKind::Triangle, 3, 1e9)).is_empty());
        let curved = remarked(&mesh(CellKind::Pyramid19, 19, 1.0));
        assert!(
            curved.len() == 1 && curved[0].starts_with("1 cell of a curved kind"),
            "{curved:?}"
        );
        assert!(remarked(&mesh(CellKind::Triangle6, 6, 1.0)).is_empty());
        for scale in [2f64.powi(300), 2f64.powi(-300)] {
            let found = remarked(&mesh(CellKind::Triangle, 3, scale));
            assert!(
                found.len() == 1 && found[0].contains("leave the range"),
                "{found:?}"
            );
        }
    }
}
