//! The files of a time: the points, and the displacement of the points that solvers interpolate between times.

use super::boundary::patches_of;
use super::points::{Header, is_binary, vectors};
use super::topology::Topology;
use super::write::{Place, points};
use crate::error::Result;
use crate::formats::case::DISPLACEMENT;
use crate::formats::records::write_all;
use crate::formats::{Notes, OutputSet, WriteOptions};
use crate::mesh::{MeshView, Values};

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
    out.place_in(&place.case, &[])?;
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
    let (class, object) = ("pointVectorField", WANTED);
    let header = Header {
        class,
        location,
        object,
        note: None,
    };
    let binary = is_binary(options);
    let patches = boundary_field(mesh)?;
    out.in_folder(&place.case, &path, |out| {
        write_all(out, header.text(binary).as_bytes())?;
        write_all(
            out,
            b"dimensions      [0 1 0 0 0 0 0];\n\ninternalField   nonuniform List<vector> \n",
        )?;
        vectors(out, values, binary)?;
        write_all(
            out,
            format!(";\n\nboundaryField\n{{\n{patches}}}\n").as_bytes(),
        )
    })
}

/// The entry of each patch. The patch of faces without a tag is there where such faces are.
fn boundary_field(mesh: &MeshView) -> Result<String> {
    let patches = patches_of(mesh, mesh.origin.get::<Topology>(), &mut Notes::default())?;
    let entry = |name: &str, kind: &str| {
        let of_field = CONSTRAINTS
            .iter()
            .find(|known| **known == kind)
            .unwrap_or(&"calculated");
        format!("    {name}\n    {{\n        type            {of_field};\n    }}\n")
    };
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
