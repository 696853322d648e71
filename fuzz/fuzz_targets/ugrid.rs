//! Any bytes given to these readers. The first byte chooses the flavour.

#![no_main]

use azimesh_io::formats::{Format, ugrid};
use azimesh_fuzz::read_and_written;
use libfuzzer_sys::fuzz_target;

static FLAVOURS: &[&Format] = &[
    &ugrid::TEXT,
    &ugrid::B8,
    &ugrid::LB8,
    &ugrid::B4,
    &ugrid::LB4,
    &ugrid::R8,
    &ugrid::LR8,
    &ugrid::R4,
    &ugrid::LR4,
    &ugrid::B8L,
    &ugrid::LB8L,
];

fuzz_target!(|bytes: &[u8]| {
    if let Some((first, bytes)) = bytes.split_first() {
        read_and_written(FLAVOURS[usize::from(*first) % FLAVOURS.len()], bytes);
    }
});
