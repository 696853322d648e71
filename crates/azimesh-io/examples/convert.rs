//! Converts a mesh from any format to any other, prints the notes of both, and compares the two meshes.
//!
//! `cargo run --release -p azimesh-io --example convert -- testdata/naca0012.vtu airfoil.su2`

#![allow(clippy::print_stdout, clippy::print_stderr)] // an example prints what it does

use azimesh_io::{DiffOptions, Mesh, ReadOptions, diff};

fn main() -> azimesh_io::Result<()> {
    let mut paths = std::env::args().skip(1);
    let (Some(from), Some(to)) = (paths.next(), paths.next()) else {
        eprintln!("usage: convert INPUT OUTPUT");
        std::process::exit(2);
    };
    let read = Mesh::read_with(&from, &ReadOptions::default())?;
    for note in read.notes.iter() {
        println!("{from}: {note}");
    }
    for note in read.mesh.write(&to)? {
        println!("{to}: {note}");
    }
    let again = Mesh::read(&to)?;
    let difference = diff(&read.mesh, &again, &DiffOptions::default())?;
    println!(
        "{} nodes, {} cells, boundary tags {:?}; {}",
        again.points().len(),
        again.cells().len(),
        again.tags().map(|tag| &tag.name).collect::<Vec<_>>(),
        if difference.is_same() {
            "nothing was lost"
        } else {
            "the meshes differ"
        }
    );
    Ok(())
}
