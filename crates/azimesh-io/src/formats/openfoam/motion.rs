//! The files of a time: the points, and the displacement of the points that solvers interpolate between times.

use super::boundary::patches_of;
use super::pieces::{self, Named};
use super::place::Place;
use super::points::{is_binary, vectors};
use super::topology::{StoredPiece, Topology};
use super::write::points;
use crate::formats::case::DISPLACEMENT;
use crate::formats::records::write_all;
use crate::formats::{Notes, OutputSet, WriteOptions};
use crate::mesh::{MeshView, Values};
use azimesh_core::error::Result;

/// Name of the field that OpenFOAM's mover `interpolator` reads.
pub(super) const WANTED: &str = "wantedDisplacement";

/// Types of patches that fields at points have under the same name; on other patches they are `calculated`.
const CONSTRAINTS: &[&str] = &[
    "empty",
    "wedge",
    "symmetry",
    "symmetryPlane",
    "cyclic",
    "cyclicSlip",
    "cyclicAMI",
    "cyclicACMI",
    "nonConformalCyclic",
    "nonConformalError",
    "nonConformalProcessorCyclic",
    "nonuniformTransformCyclic",
    "processor",
    "processorCyclic",
];

/// Writes the points of a time and, where the mesh has it as an array, the displacement.
pub(super) fn write_time(
    mesh: &MeshView,
    folder: &str,
    field_folder: &str,
    place: &Place,
    out: &mut OutputSet,
    options: &WriteOptions,
) -> Result<()> {
    out.place_in(&place.case, &[] as &[&str])?;
    points(mesh.points, out, place, folder, options)?;
    let mut arrays = mesh.point_arrays.iter();
    let displacement = arrays.find(|array| array.name == DISPLACEMENT && array.n_components == 3);
    match displacement.map(|array| &array.values) {
        Some(Values::F64(values)) => field(
            mesh,
            values.as_chunks().0,
            field_folder,
            place,
            out,
            options,
        ),
        _ => Ok(()),
    }
}

/// Path of the displacement at a time, from the case on.
pub(super) fn field_path(place: &Place, folder: &str) -> String {
    match &place.region {
        Some(region) => format!("{folder}/{region}/{WANTED}"),
        None => format!("{folder}/{WANTED}"),
    }
}

fn field(
    mesh: &MeshView,
    values: &[[f64; 3]],
    folder: &str,
    place: &Place,
    out: &mut OutputSet,
    options: &WriteOptions,
) -> Result<()> {
    let path = field_path(place, folder);
    let location = path
        .strip_suffix(WANTED)
        .unwrap_or_default()
        .trim_end_matches('/');
    let named = Named {
        path: &path,
        class: "pointVectorField",
        location,
        object: WANTED,
    };
    let binary = is_binary(options);
    let of_whole = boundary_field(mesh)?;
    pieces::write(out, place, &named, options, &|out, piece| {
        write_all(
            out,
            b"dimensions      [0 1 0 0 0 0 0];\n\ninternalField   nonuniform List<vector> \n",
        )?;
        match piece {
            None => vectors(out, values, binary)?,
            Some(piece) => vectors(out, &piece.of(values), binary)?,
        }
        let patches = piece.map_or_else(|| of_whole.clone(), boundary_field_of);
        write_all(
            out,
            format!(";\n\nboundaryField\n{{\n{patches}}}\n").as_bytes(),
        )
    })
}

fn entry(name: &str, kind: &str) -> String {
    let mut known = CONSTRAINTS.iter();
    let of_field = known.find(|known| **known == kind).unwrap_or(&"calculated");
    format!("    {name}\n    {{\n        type            {of_field};\n    }}\n")
}

/// The entry of each patch of a piece.
fn boundary_field_of(piece: &StoredPiece) -> String {
    let patches = piece.patches.iter();
    patches
        .map(|patch| entry(&patch.name, &patch.kind))
        .collect()
}

/// The entry of each patch. The patch of faces without a tag is there where such faces are.
fn boundary_field(mesh: &MeshView) -> Result<String> {
    let patches = patches_of(mesh, mesh.origin.get::<Topology>(), &mut Notes::default())?;
    let (tagged, rest) = patches.split_at(patches.len() - 1);
    let mut text: String = tagged
        .iter()
        .map(|patch| entry(&patch.name, &patch.kind))
        .collect();
    for rest in rest {
        // A pattern for faces of no tag, which may not be there.
        text += &entry(&format!("\"{}.*\"", rest.name), &rest.kind);
    }
    Ok(text)
}
