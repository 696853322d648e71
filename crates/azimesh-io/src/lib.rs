//! Unstructured meshes, and the files that hold them: a meshio for Rust.
//!
//! Owns: one mesh in memory for every format, with nodes, cells in the order of the file, tags, zones and other
//! groups, and arrays; every file format, to read, to write and for sequences of meshes; comparison ([`diff`]),
//! splitting of polyhedra, extrusion, reordering and joining; the part of a mesh that a rank of a parallel
//! program holds.
//!
//! Leaves to others: quality (`azimesh-quality`), motion and deformation (`azimesh-deform`), command lines and
//! reports (the program `azimesh`), ranks and error types (`azimesh-core`).
//!
//! A reader recognizes a file by its content, not by its name. A written file is complete, or it is not there. A
//! note names each thing that a mesh or a format cannot hold; an error names the place in the file.
//!
//! ```
//! use azimesh_io::{DiffOptions, Mesh, ReadOptions, diff};
//!
//! fn main() -> azimesh_io::Result<()> {
//!     let loaded = Mesh::read_with("testdata/naca0012.vtu", &ReadOptions::default())?;
//!     for note in loaded.notes {
//!         println!("not in the mesh: {note}");
//!     }
//!     let mesh = loaded.mesh;
//!     println!("{} nodes, {} cells", mesh.points.len(), mesh.cells.len());
//!     for tag in mesh.tags() {
//!         println!("{}: {} boundary faces", tag.name, tag.cells.len());
//!     }
//!
//!     let path = "airfoil.cgns";
//! #   let folder = tempfile::tempdir().expect("a folder");
//! #   let path = folder.path().join(path);
//!     for note in mesh.write(&path)? {
//!         println!("not in the file: {note}");
//!     }
//!     let again = Mesh::read(&path)?;
//!     assert!(diff(&mesh, &again, &DiffOptions::default())?.is_same());
//!     Ok(())
//! }
//! ```
//!
//! # Types
//!
//! ```text
//! file or folder ─┬─> Mesh::read_with ──> Loaded ┬ mesh: Mesh
//! ReadOptions ────┘                              ├ notes: Notes
//!                                                └ format: &Format
//!
//! Mesh::view ──> MeshView ─┬─> write_with ─┬─> file or folder
//! other points, arrays ────┤               └─> Notes
//! WriteOptions ────────────┘
//!
//! Mesh
//! ├ points         [x, y, z] per node, 64 bits
//! ├ cells          Cells: runs of cells of one CellKind, in file order, nodes in VTK's order.
//! │                Boundary faces are cells too, one dimension below the mesh
//! ├ groups         Group: name, dimension, number, condition, cells.
//! │                tags(): boundary faces; zones(): cells of the mesh's own dimension
//! ├ point_arrays   DataArray per node: name, components, Values (8 to 64 bits, or text)
//! ├ cell_arrays    DataArray per cell
//! └ field_arrays   DataArray of the whole mesh
//! ```
//!
//! The fields of [`Mesh`], [`Group`], [`DataArray`] and [`MeshView`] are public; [`Cells`] keeps its runs compact.
//! Writing a [`MeshView`] with other points copies nothing. A [`Format`](formats::Format) lists the times of a
//! sequence; [`ReadOptions::step`] chooses one.
//!
//! # Formats
//!
//! | module | format | read | written | tags | sequences |
//! |---|---|---|---|---|---|
//! | [`vtu`](formats::vtu) | VTK XML: `.vtu`, `.vtp`; `.vts`, `.vtr`, `.vti` | yes | `.vtu`, `.vtp` | cell arrays, with names | |
//! | [`pvtu`](formats::pvtu) | VTK XML in pieces: `.pvtu` | yes | yes | as `.vtu` | |
//! | [`vtkhdf`](formats::vtkhdf) | VTKHDF: `.vtkhdf`, `.hdf` | yes | yes | as `.vtu` | read, written |
//! | [`legacy`](formats::legacy) | VTK legacy: `.vtk` | 1.0 to 5.1 | 4.2, 5.1 | as `.vtu` | |
//! | [`gmsh`](formats::gmsh) | Gmsh: `.msh` | 1 to 4.1 | 2.2, 4.1 | physical groups | read: data |
//! | [`su2`](formats::su2) | SU2: `.su2` | yes | yes | markers | |
//! | [`cgns`](formats::cgns) | CGNS: `.cgns` | HDF5, ADF | HDF5 | boundary conditions, families | read, written |
//! | [`ugrid`](formats::ugrid) | UGRID of AFLR3: `.ugrid`, `.b8.ugrid`, ... | yes | yes | numbers; names in `.mapbc` | |
//! | [`openfoam`](formats::openfoam) | OpenFOAM case | yes | yes | patches | read, written |
//! | [`exodus`](formats::exodus) | Exodus II: `.exo`, `.e`, `.g`, ... | yes | | side sets | read |
//! | [`medit`](formats::medit) | Medit: `.mesh` | text | | references | |
//! | [`abaqus`](formats::abaqus) | Abaqus: `.inp` | one part | | sets, surfaces | |
//! | [`fluent`](formats::fluent) | Fluent: `.msh`, `.cas`, `.msh.h5`, `.cas.h5` | yes | | zones of faces | |
//! | [`plot3d`](formats::plot3d) | Plot3D: `.xyz`, `.p3d`, `.x`, ... | yes | | sides of blocks, `.nmf` | |
//! | [`stl`](formats::stl) | STL: `.stl` | yes | yes | solids of text | |
//!
//! Files in gzip, xz and zstd are decompressed as they are read. Lists of files with times (`.pvd`, `.vtk.series`):
//! [`read_series`](formats::read_series).
//!
//! Programs in `examples/`: `convert`, `list_tags`, `read_step`.

pub mod formats;
pub mod mesh;

pub use azimesh_core::{Error, ErrorKind, Note, Result};
pub use formats::{Compression, Encoding, Loaded, Notes, Precision, ReadOptions, WriteOptions};
pub use mesh::{
    CellKind, Cells, DataArray, DiffOptions, Difference, Group, Mesh, MeshView, SplitCounts,
    Values, diff,
};

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod testing {
    /// Checks that an error, a note or a text has these words.
    #[track_caller]
    pub fn assert_says(text: &(impl ToString + ?Sized), words: &(impl AsRef<str> + ?Sized)) {
        let text = text.to_string();
        assert!(text.contains(words.as_ref()), "{text}");
    }
}
