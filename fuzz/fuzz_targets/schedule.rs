//! Any text given as a schedule: steps and bodies, or one sentence with a line.

#![no_main]

use azimesh_deform::motion::Schedule;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    match Schedule::parse(text, Path::new("schedule.toml")) {
        Ok(schedule) => assert!(schedule.steps().is_ok_and(|steps| !steps.is_empty())),
        Err(error) => assert!(!error.message.contains('\n'), "not one sentence: {error}"),
    }
});
