//! Reads the meshes of a sequence: of its steps, and the reference mesh.

use super::folder::Sequence;
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::{self, ReadOptions, check_file, hash_of};
use azimesh_io::mesh::Mesh;
use std::path::Path;

/// The meshes of a sequence.
pub struct Meshes<'a> {
    sequence: &'a Sequence,
    options: &'a ReadOptions,
}

impl<'a> Meshes<'a> {
    /// Finds the meshes of the folder of a sequence.
    pub fn new(sequence: &'a Sequence, options: &'a ReadOptions) -> Self {
        Self { sequence, options }
    }

    /// The mesh of a row of steps.csv.
    pub fn at(&self, row: usize) -> Result<Mesh> {
        let table = &self.sequence.table;
        let name = table.text(row, "file");
        if name.is_empty() {
            return Err(Error::input("steps.csv names no file for it"));
        }
        // One file may hold many steps, in the order of the rows.
        let before = (0..row)
            .filter(|&other| table.text(other, "file") == name)
            .count();
        let is_alone =
            before == 0 && (row + 1..table.len()).all(|other| table.text(other, "file") != name);
        // Runs write boundary tags under their common name.
        let options = ReadOptions {
            step: (!is_alone).then_some(before),
            tag_array: None,
        };
        read(&self.sequence.folder.join(name), &options)
    }

    /// Returns the original mesh, if its file still exists and has not changed.
    pub fn reference(&self) -> Result<Mesh> {
        let input = self.sequence.record.inputs.first();
        let input = input.ok_or_else(|| Error::input("run.json does not name it"))?;
        let hash = input.blake3.as_ref();
        let hash = hash.ok_or_else(|| Error::input("it came from standard input"))?;
        let tag_array = self.sequence.record.options.tag_array.clone();
        let own = self.options.tag_array.clone();
        let options = ReadOptions {
            step: None,
            tag_array: own.or(tag_array),
        };
        let mut is_there = false;
        // Paths in run.json are relative to the folder in which it ran: this one, the folder of the run, or its parent.
        let folder = &self.sequence.folder;
        for place in [Path::new(""), folder, &folder.join("..")] {
            let path = place.join(&input.file);
            match mesh_of_hash(&path, hash, &options) {
                Ok(Some(mesh)) if self.has_linked(place) => return Ok(mesh),
                Ok(_) => is_there = true,
                Err(_) => {}
            }
        }
        let why = if is_there {
            "it has changed since the run"
        } else {
            "it is not there any more"
        };
        Err(Error::input(why).file(Path::new(&input.file)))
    }

    /// Checks if the files that the mesh reads besides its own have not changed; `place` is the folder in which the run ran.
    fn has_linked(&self, place: &Path) -> bool {
        let inputs = self.sequence.record.inputs.iter();
        let mut linked = inputs.filter(|input| input.what == "linked file");
        linked.all(|input| {
            let found = hash_of(&place.join(&input.file)).map(|own| own.to_string());
            found.ok() == input.blake3
        })
    }
}

/// Reads the mesh at a path, if it has this hash. A case is read before its hash is known.
fn mesh_of_hash(path: &Path, hash: &str, options: &ReadOptions) -> Result<Option<Mesh>> {
    let io = |error: std::io::Error| Error::io(path, &error);
    let is_case =
        path.is_dir() || formats::by_extension(path).is_ok_and(|format| format.case.is_some());
    if is_case {
        let mesh = read(path, options)?;
        let is_same = formats::hash_of_input(path, &mesh).map_err(io)?.to_string() == hash;
        return Ok(is_same.then_some(mesh));
    }
    let found = check_file(path).and_then(|()| hash_of(path));
    let found = found.map_err(io)?;
    let is_same = found.to_string() == hash;
    is_same.then(|| read(path, options)).transpose()
}

fn read(path: &Path, options: &ReadOptions) -> Result<Mesh> {
    if let Some((case, step)) = formats::step_in_case(path) {
        let options = ReadOptions {
            step: Some(step),
            ..options.clone()
        };
        return Ok(formats::read(&case, &options)?.mesh);
    }
    // A step in a case is a file in the folder of the mesh at its time.
    let folder = path
        .parent()
        .filter(|_| path.file_name().is_some_and(|name| name == "points"));
    let path = folder.unwrap_or(path);
    if !path.is_dir() {
        check_file(path).map_err(|error| Error::io(path, &error))?;
    }
    Ok(Mesh::read_with(path, options)?.mesh)
}
