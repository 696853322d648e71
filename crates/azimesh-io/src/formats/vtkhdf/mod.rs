//! VTKHDF (.vtkhdf): VTK's unstructured grids in HDF5, one mesh or a sequence of them.
//!
//! Tags, zones, cells and what is written of a mesh are as in every file of VTK (`vtk`); bytes and
//! groups are HDF5's (`hdf5`). Format: VTKHDF 2.0, with polyhedra 2.5.
//!
//! ```
//! use azimesh_io::formats::vtkhdf::VTKHDF;
//! use azimesh_io::formats::{Begin, Format, Location, read};
//! use azimesh_io::{Mesh, ReadOptions, WriteOptions};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("rising.vtkhdf");
//!
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let create = VTKHDF.sequence.expect("VTKHDF holds sequences");
//! let mut file = create(&path, &WriteOptions::default(), Begin::Create, false)?;
//! for time in [0.0, 0.5, 1.0] {
//!     let points: Vec<_> = mesh.points.iter().map(|[x, y, z]| [*x, y + time, *z]).collect();
//!     file.push(time, &mesh.view().with_points(&points))?;
//! }
//!
//! let location = Location::open(&path)?;
//! assert_eq!(VTKHDF.steps(&location)?, [0.0, 0.5, 1.0]);
//! let options = ReadOptions { step: Some(1), ..ReadOptions::default() };
//! let step = read(&location, &options)?.mesh;
//! assert_eq!(step.points[7][1], mesh.points[7][1] + 0.5);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! extent    rows of each dataset that belong to a step
//! read      all or some of those rows -> mesh; cells: its cells
//! blocks    mesh -> datasets
//! write     datasets -> a file of one mesh
//! sequence  datasets -> a file that grows, with what does not change written once
//! ```

mod blocks;
mod cells;
mod extent;
mod read;
mod sequence;
mod write;

use super::hdf5::{self, File, Group};
use super::slabs::opened;
use super::vtk::tags;
use super::{Encoding, Format, Holds, Precision, ReadOptions, Source};
use azimesh_core::error::{Error, Result};
use read::Reader;

/// Name of the group that holds everything.
const ROOT: &str = "VTKHDF";

/// VTK's unstructured grids in HDF5 (.vtkhdf).
pub static VTKHDF: Format = Format {
    name: "vtkhdf",
    title: "VTKHDF unstructured grid (.vtkhdf)",
    extensions: &["vtkhdf", "hdf"],
    holds: Holds::NAMED_ARRAYS,
    encodings: &[Encoding::Raw],
    precisions: &[Precision::F64, Precision::F32],
    detect: |source| hdf5::is_hdf5(source.bytes()) && matches!(grid(source), Ok(Some(_))),
    read: |source, options, notes| {
        placed(reader(source, options).and_then(|reader| reader.read(notes)))
    },
    steps: |source| placed(unstructured(source).and_then(|grid| extent::times(&grid))),
    slabs: Some(|source, options| {
        let reader = placed(reader(source, options))?;
        placed(opened(reader.check_slabs().map(|()| reader)))
    }),
    write: Some(write::write),
    sequence: Some(|path, options, begin, sync| {
        let file = sequence::Sequence::create(path, options, begin, sync)?;
        Ok(Box::new(file))
    }),
    takes_numbers_apart: |_| true,
    takes_cells_apart: |mesh| !tags::has_repeated(mesh),
    ..Format::NEW
};

/// The group that makes an HDF5 file one of VTK's.
fn grid(source: &Source) -> Result<Option<Group>> {
    File::open(source)?.root()?.group(ROOT)
}

/// The group of [`grid`], which must hold an unstructured grid of a version that is read.
fn unstructured(source: &Source) -> Result<Group> {
    let group = grid(source)?;
    let group = group.ok_or_else(|| {
        Error::input(format!(
            "this HDF5 file has no group {ROOT}, so it is not a VTKHDF file"
        ))
    })?;
    let version = group.attribute("Version")?.and_then(|v| v.to_integers());
    let newest = version.and_then(|version| version.first().copied());
    if let Some(newest) = newest.filter(|newest| *newest > 2) {
        let message = format!("it has VTKHDF version {newest}; versions 1 and 2 are read");
        return Err(Error::input(message));
    }
    match group.text("Type")? {
        Some(found) if found == "UnstructuredGrid" => Ok(group),
        Some(found) => Err(Error::input(format!(
            "it has VTK data of type {found}; only UnstructuredGrid is read"
        ))),
        None => Err(Error::input("the group has no attribute Type")),
    }
}

fn reader(source: &Source, options: &ReadOptions) -> Result<Reader> {
    Reader::new(unstructured(source)?, options)
}

/// Errors without a dataset refer to the group.
fn placed<T>(result: Result<T>) -> Result<T> {
    result.map_err(|error| error.dataset(ROOT))
}

#[cfg(test)]
mod damaged;
#[cfg(test)]
mod tests;
