//! A morph for programs that exchange files: displacements in, positions and gradients out, as raw
//! little-endian numbers of 64 bits, three a node.
//!
//! ```text
//! cargo run --release --example morph_by_files -- MESH FOLDER moving=wing fixed=farfield slide=symmetry
//!     periodic=side_a:side_b max_points=200 support_radius=3
//!
//! FOLDER/displacements.f64   one row for each moving node, these ascending
//! FOLDER/gradient.f64        one row for each node of the mesh
//! ```
//!
//! It writes `moved.f64` (displacements of all nodes), `points.f64`, `pulled_back.f64` (one row for each
//! moving node) and `base_points.u32` to FOLDER, and prints the support radius.

#![allow(clippy::print_stdout)] // an example prints what it does

use azimesh::{Error, Mesh, Morph, MorphOptions, Nodes, Result};
use std::fs;
use std::path::Path;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, folder, settings @ ..] = &arguments[..] else {
        return Err(Error::input("give MESH FOLDER moving=TAGS and so on"));
    };
    let folder = Path::new(folder);
    let morph = Morph::new(Mesh::read(mesh)?, options(settings)?)?;
    let displacements = read(&folder.join("displacements.f64"))?;
    let gradient = read(&folder.join("gradient.f64"))?;
    let write_rows = |name: &str, rows: &[[f64; 3]]| {
        let bytes = rows.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        write(&folder.join(name), bytes.collect())
    };
    write_rows("moved.f64", &morph.displacements_of(&displacements)?)?;
    write_rows("points.f64", &morph.points(&displacements)?)?;
    write_rows("pulled_back.f64", &morph.pull_back(&gradient)?)?;
    let base = morph.base_points();
    let base = base.iter().flat_map(|node| node.to_le_bytes());
    write(&folder.join("base_points.u32"), base.collect())?;
    println!("{}", morph.basis().radius);
    Ok(())
}

/// Options from words of the form `name=value`.
fn options(settings: &[String]) -> Result<MorphOptions> {
    let mut options = MorphOptions::default();
    for setting in settings {
        let wrong = || Error::input(format!("{setting:?} is not understood"));
        let (name, value) = setting.split_once('=').ok_or_else(wrong)?;
        let number = || value.parse::<f64>().map_err(|_| wrong());
        match name {
            "moving" => options.moving = tags(value),
            "fixed" => options.fixed = tags(value),
            "slide" => options.slide = tags(value),
            "periodic" => {
                let (a, b) = value.split_once(':').ok_or_else(wrong)?;
                options.periodic.push([tags(a), tags(b)]);
            }
            "max_points" => options.max_points = number()? as usize,
            "tolerance" => options.tolerance = number()?,
            "support_radius" => options.support_radius = Some(number()?),
            _ => return Err(wrong()),
        }
    }
    Ok(options)
}

fn tags(names: &str) -> Nodes {
    Nodes::Tags(names.split(',').map(str::to_owned).collect())
}

fn read(path: &Path) -> Result<Vec<[f64; 3]>> {
    let bytes = fs::read(path).map_err(|error| Error::io(path, &error))?;
    let (numbers, rest) = bytes.as_chunks::<8>();
    let numbers: Vec<f64> = numbers.iter().map(|x| f64::from_le_bytes(*x)).collect();
    match (numbers.as_chunks::<3>(), rest) {
        ((rows, []), []) => Ok(rows.to_vec()),
        _ => Err(Error::input("it must hold three numbers of 64 bits for each node").file(path)),
    }
}

fn write(path: &Path, bytes: Vec<u8>) -> Result<()> {
    fs::write(path, bytes).map_err(|error| Error::io(path, &error))
}
