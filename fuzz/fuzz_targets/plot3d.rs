//! Any bytes given to the reader of Plot3D grids. The first byte chooses what is stated of the file.

#![no_main]

use azimesh_io::formats::{Format, plot3d};
use azimesh_fuzz::read_and_written;
use libfuzzer_sys::fuzz_target;

static STATED: &[&Format] = &[
    &plot3d::ANY,
    &plot3d::SINGLE,
    &plot3d::MULTI,
    &plot3d::PLANE,
    &plot3d::SOLID,
    &plot3d::BLANKED,
    &plot3d::PLAIN,
    &plot3d::F32,
    &plot3d::F64,
];

fuzz_target!(|bytes: &[u8]| {
    if let Some((first, bytes)) = bytes.split_first() {
        read_and_written(STATED[usize::from(*first) % STATED.len()], bytes);
    }
});
