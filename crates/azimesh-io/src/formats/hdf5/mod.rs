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
//! tree.dataset(group, "Points", Element::F64, &[n_points, 3], points);
//! tree.write(out)?;
//! ```
//!
//! Values that are not in memory in the form that they have in the file are a [`Data::Made`], a closure
//! that hands over bytes. A file that grows step by step and is valid after each:
//!
//! ```text
//! let mut file = StepFile::create(path, Begin::Create, true)?;             // staged until the first step is complete
//! let x = file.store(&Data::slice(&x))?;                               // keep `x` for later steps
//! let mut tree = ...;                                                   // all that is in the file now
//! tree.dataset(group, "CoordinateX", Element::F64, &[n], x);
//! let hash = file.finish_step(&tree)?;
//! file.commit()?;                                                       // from here on it can be read
//! ```
//!
//! A dataset that gets longer with each step has one [`Payload::Chunks`] piece a step, or has [`Rows`]
//! where that is a number or a name. What later steps have too is an object in a list of [`Links`]:
//! so a step writes what is new in it, and the groups on the way there:
//!
//! ```text
//! let grid = file.store_object(&tree)?;
//! links.add("GridCoordinates#0007", grid)?;
//! file.store_links(&mut links)?;
//! tree.links(zone, &links);                                             // of the tree of the step
//! ```
//!
//! Reading:
//!
//! ```text
//! let file = File::open(source)?;
//! for group in file.root()?.groups()? { ... group.text("label")? ... group.dataset(" data")? ... }
//! let values: Values = dataset.values()?;
//! ```

mod address;
mod bits;
mod checksum;
mod element;
mod header;
mod index;
mod links;
mod messages;
mod read;
mod rows;
mod short_chunks;
mod step_file;
mod tree;
mod whole;
mod write;

pub(super) use self::{
    address::Stored,
    element::Element,
    index::Chunks,
    links::Links,
    read::{Dataset, File, Group, MissingFiles},
    rows::Rows,
    step_file::StepFile,
    tree::{Id, Payload, Tree},
    whole::{SIGNATURE, cut_off, first_bytes, is_hdf5},
};

#[cfg(test)]
mod tests;
