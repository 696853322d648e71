//! HDF5 files: a small writer, and the only use of the crate that reads them. Owns groups, datasets and attributes;
//! their meaning is left to CGNS and VTKHDF.
//!
//! Writing a file whose content is known, front to back into any sink:
//!
//! ```text
//! let mut tree = Tree::new();
//! let group = tree.group(Tree::ROOT, "VTKHDF");
//! tree.text_attribute(group, "Type", "UnstructuredGrid");
//! tree.number_attribute(group, "Version", &[2_i64, 3], false);
//! let points = Data::slice(mesh.points.as_flattened());                 // not copied
//! tree.dataset(group, "Points", Element::Float64, &[n_points, 3], points);
//! tree.write(out)?;
//! ```
//!
//! A file that grows step by step and is valid after each:
//!
//! ```text
//! let mut file = StepFile::create(path, Begin::Create, true)?;         // staged until the first step is complete
//! let x = file.store(&Data::slice(&x))?;                               // keep `x` for later steps
//! let mut tree = ...;                                                  // all that is in the file now
//! tree.dataset(group, "CoordinateX", Element::Float64, &[n], x);
//! let hash = file.finish_step(&tree)?;
//! file.commit()?;                                                      // from here on it can be read
//! ```
//!
//! A dataset that gets longer with each step has one piece per step ([`Payload::Chunks`]), or has [`Rows`] of one number or
//! name. What later steps have too is an object in a list of [`Links`]: a step writes what is new in it, and the groups on
//! the way there.
//!
//! Reading:
//!
//! ```text
//! let file = File::open(source)?;
//! for group in file.root()?.groups()? { ... group.text("label")? ... group.dataset(" data")? ... }
//! let values: Values = dataset.values()?;
//! ```

mod decode;
mod header;
mod index;
mod messages;
mod read;
mod rows;
mod step_file;
mod tree;
mod whole;
mod write;

pub(super) use self::{
    header::size,
    index::Chunks,
    messages::Links,
    read::{Dataset, File, Group, MissingFiles},
    rows::Rows,
    step_file::StepFile,
    tree::{Id, Payload, Stored, Tree},
    whole::{SIGNATURE, cut_off, first_bytes, is_hdf5},
};
pub(super) use super::vtk::number::Element;

#[cfg(test)]
mod tests;
