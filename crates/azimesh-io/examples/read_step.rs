//! Lists the times of a sequence, reads one of its steps, and prints the bounds of the nodes of this step.
//!
//! `cargo run --release -p azimesh-io --example read_step -- testdata/cgns/sequence.cgns 1`

#![allow(clippy::print_stdout, clippy::print_stderr)] // an example prints what it does

use azimesh_io::ReadOptions;
use azimesh_io::formats::{self, Location};

fn main() -> azimesh_io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next();
    let step = arguments.next().and_then(|step| step.parse().ok());
    let (Some(path), Some(step)) = (path, step) else {
        eprintln!("usage: read_step SEQUENCE STEP");
        std::process::exit(2);
    };
    let location = Location::open(path.as_ref())?;
    let format = formats::of(&location)?;
    for (i, time) in format.steps(&location)?.iter().enumerate() {
        println!("step {i}: time {time}");
    }
    let options = ReadOptions {
        step: Some(step),
        ..ReadOptions::default()
    };
    let mesh = formats::read_as(format, &location, &options)?.mesh;
    if let Some([low, high]) = mesh.bounds() {
        println!("nodes of step {step}: from {low:?} to {high:?}");
    }
    Ok(())
}
