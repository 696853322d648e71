//! HDF5 files: our own small writer, and the one home of the crate that reads them.
//!
//! Knows groups, datasets and attributes; what they mean is for CGNS and VTKHDF to know.
//!
//! Writing a file whose content is known, front to back into any sink:
//!
//! ```text
//! let mut tree = Tree::new();
//! let group = tree.group(Tree::ROOT, "VTKHDF");
//! tree.text_attribute(group, "Type", "UnstructuredGrid");
//! tree.number_attribute(group, "Version", &[2_i64, 3], false);
//! let bytes = Data::Bytes(bytemuck::cast_slice(&mesh.points).into());   // not copied
//! tree.dataset(group, "Points", Element::F64, &[n_points, 3], bytes);
//! tree.write(out)?;
//! ```
//!
//! Values that are not in memory as they shall be in the file are a [`Data::Stream`], a closure
//! that hands over bytes. A file that grows step by step and is whole after each:
//!
//! ```text
//! let mut file = StepFile::create(path, Begin::Create, true)?;             // hidden until the first step is whole
//! let x = file.store(|sink| sink(bytemuck::cast_slice(&x)))?;           // keep `x` for later steps
//! let mut tree = ...;                                                   // all that is in the file now
//! tree.dataset(group, "CoordinateX", Element::F64, &[n], Data::Stored(x));
//! let hash = file.finish_step(&tree)?;
//! file.commit()?;                                                       // from here on it can be read
//! ```
//!
//! A dataset that gets longer with each step has one [`Data::Chunks`] piece a step, or is a [`Column`]
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

mod checksum;
mod column;
mod element;
mod header;
mod index;
mod links;
mod read;
mod step_file;
mod tree;
mod write;

pub(super) use self::{
    column::{Column, column_bytes},
    element::Element,
    index::{Chunks, index_bytes},
    links::Links,
    read::{Dataset, File, Group},
    step_file::{StepFile, Stored},
    tree::{Data, Id, Sink, Tree},
};

/// Whether these are the bytes of an HDF5 file, also behind a block of another program's.
pub(super) fn is_hdf5(bytes: &[u8]) -> bool {
    let doubling = std::iter::successors(Some(512_usize), |at| at.checked_mul(2));
    std::iter::once(0)
        .chain(doubling)
        .take_while(|at| *at < bytes.len())
        .any(|at| bytes[at..].starts_with(b"\x89HDF\r\n\x1a\n"))
}

#[cfg(test)]
mod tests;
