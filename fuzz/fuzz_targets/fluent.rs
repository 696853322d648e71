//! Any bytes given to the reader of Fluent's files: sections, or HDF5.

#![no_main]

use azimesh_io::formats::fluent::FLUENT;
use azimesh_fuzz::read_and_written;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| read_and_written(&FLUENT, bytes));
