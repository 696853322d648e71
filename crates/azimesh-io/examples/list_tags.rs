//! Lists the zones and boundary tags of a mesh: name, dimension, number of cells.
//!
//! `cargo run --release -p azimesh-io --example list_tags -- testdata/gmsh/cylinder_v41.msh`

#![allow(clippy::print_stdout, clippy::print_stderr)] // an example prints what it does

use azimesh_io::{Group, Mesh, ReadOptions};

fn main() -> azimesh_io::Result<()> {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: list_tags MESH");
        std::process::exit(2);
    };
    let loaded = Mesh::read_with(&path, &ReadOptions::default())?;
    let mesh = &loaded.mesh;
    println!(
        "{path}: {}, {} dimensions, {} nodes, {} cells",
        loaded.format.name,
        mesh.dimension(),
        mesh.points().len(),
        mesh.cells().len()
    );
    mesh.zones().for_each(|zone| print("zone", zone));
    mesh.tags().for_each(|tag| print("tag", tag));
    Ok(())
}

fn print(what: &str, group: &Group) {
    println!(
        "{what:<4}  {:<20} dimension {}, {:>6} cells",
        group.name,
        group.dimension,
        group.cells.len()
    );
}
