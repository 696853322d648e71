//! Any bytes given to this reader.

#![no_main]

use azimesh_io::formats::medit::MEDIT;
use azimesh_fuzz::read_and_written;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| read_and_written(&MEDIT, bytes));
