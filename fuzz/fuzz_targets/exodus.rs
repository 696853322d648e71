//! Any bytes given to the reader of Exodus, in netCDF's classic formats and in HDF5.

#![no_main]

use azimesh_io::formats::exodus::EXODUS;
use azimesh_fuzz::read_and_written;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| read_and_written(&EXODUS, bytes));
