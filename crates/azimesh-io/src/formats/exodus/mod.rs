//! Exodus II (.exo, .e, .ex2, .exii, .gen, .g): finite element meshes and results of SEACAS, Cubit, MOOSE and others, in
//! netCDF. Read only.
//!
//! Element blocks are zones, side sets are boundary tags. A file with results at several times is a sequence: the
//! variables of a step are arrays. Displacements do not move the nodes.
//!
//! ```
//! use azimesh_io::formats::{Location, of, read};
//! use azimesh_io::ReadOptions;
//! # fn main() -> azimesh_io::Result<()> {
//! let location = Location::open("testdata/exodus_cdf5.exo".as_ref())?;
//! assert_eq!(of(&location)?.steps(&location)?, [0.25, 0.5]);
//!
//! // Without a step in the options, the last one is read.
//! let mesh = read(&location, &ReadOptions::default())?.mesh;
//! // Blocks and sets without a name have their number as their name.
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert_eq!(zones, ["air", "20", "cells"]);
//! let tags: Vec<_> = mesh.tags().map(|tag| tag.name.as_str()).collect();
//! assert_eq!(tags, ["skin", "upper wall", "8"]);
//! let results: Vec<_> = mesh.point_arrays.iter().map(|array| array.name.as_str()).collect();
//! assert_eq!(results, ["GlobalNodeId", "displ", "p"]);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! read       order of the work; which of the times is read
//! element    types of elements: kinds of cells, order of nodes, numbers of sides
//! blocks     element blocks -> cells and zones, names of blocks and sets; polyhedra: blocks of polygons and polyhedra
//! sides      side sets -> boundary faces and tags
//! node_sets  node sets -> groups of nodes, or tags
//! variables  results at a step -> arrays
//! ```
//!
//! Format: "Exodus II: A Finite Element Data Model", SAND92-2137, with the names of variables of SEACAS's library.

mod blocks;
mod element;
mod node_sets;
mod polyhedra;
mod read;
mod sides;
mod variables;

use super::netcdf::{self, File};
use super::{Format, hdf5};

/// Exodus II.
pub static EXODUS: Format = Format {
    name: "exodus",
    title: "Exodus II (.exo)",
    extensions: &["exo", "e", "ex2", "exii", "gen", "g"],
    // netCDF files hold anything: Exodus files have dimensions with known names.
    detect: |source| {
        let bytes = source.bytes();
        (netcdf::is_classic(bytes) || hdf5::is_hdf5(bytes))
            && File::open(source).is_ok_and(|file| read::is_exodus(&file))
    },
    read: read::read,
    steps: |source| {
        let times = File::open(source).and_then(|file| read::times(&file));
        times.map_err(|error| error.file(source.path()))
    },
    ..Format::NEW
};
