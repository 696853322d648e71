//! What belongs to a case beside its mesh: `system`, `0` and `constant`, and those of its pieces where these are written,
//! copied where the mesh was read from a case.

use super::folders::{CONSTANT, MESH};
use super::place::Place;
use super::topology::{StoredPieces, Topology};
use crate::error::{Error, Result};
use crate::formats::{OutputSet, check_file};
use crate::mesh::MeshView;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folders of a case that are copied, and of each piece.
const COPIED: [&str; 4] = ["system", CONSTANT, "0", "0.orig"];

/// The folders that are copied, from the case on.
fn copied(pieces: &[StoredPieces]) -> Vec<PathBuf> {
    let roots = pieces.iter().map(|pieces| Path::new(&pieces.folder));
    let roots = [Path::new("")].into_iter().chain(roots);
    roots
        .flat_map(|root| COPIED.map(|name| root.join(name)))
        .collect()
}

/// Folders inside one another, at the most: links may lead in circles.
const DEPTH: usize = 32;

/// Refuses to write a sequence into the case that its mesh was read from, or into a folder of that which is copied.
pub(super) fn check(case: &Path, mesh: &MeshView) -> Result<()> {
    let Some(origin) = mesh.origin.get::<Topology>() else {
        return Ok(());
    };
    let (from, to) = (resolved(&origin.case), resolved(case));
    if from == to {
        return Err(Error::input(
            "this is the case that the mesh is read from; give another folder, to which its system, 0 and constant are \
             copied",
        )
        .file(case));
    }
    let copied = copied(&origin.pieces);
    match copied.iter().find(|name| to.starts_with(from.join(name))) {
        Some(name) => Err(Error::input(format!(
            "this lies in the folder {} of the case that the mesh is read from, which is copied; give a folder outside it",
            name.display()
        ))
        .file(case)),
        None => Ok(()),
    }
}

/// A path without links, as far as it is there.
fn resolved(path: &Path) -> PathBuf {
    let full = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let known = full
        .ancestors()
        .find_map(|above| Some((above, fs::canonicalize(above).ok()?)));
    match known {
        Some((above, found)) => match full.strip_prefix(above) {
            Ok(rest) if !rest.as_os_str().is_empty() => found.join(rest),
            _ => found,
        },
        None => full,
    }
}

/// Copies what belongs to the case of the mesh. What is there already stays as it is.
pub(super) fn copy(mesh: &MeshView, place: &Place, out: &mut OutputSet) -> Result<()> {
    let Some(origin) = mesh.origin.get::<Topology>() else {
        return Ok(());
    };
    let mut own: Vec<PathBuf> = place.folders(CONSTANT).iter().map(PathBuf::from).collect();
    own.push(PathBuf::from(place.folder(CONSTANT)));
    let mut copying = Copying {
        from: &origin.case,
        place,
        own,
        out,
    };
    for name in copied(place.pieces) {
        if origin.case.join(&name).is_dir() {
            copying.folder(&name, 0)?;
        }
    }
    Ok(())
}

struct Copying<'a, 'b> {
    from: &'a Path,
    place: &'a Place<'a>,
    /// The folders of the mesh, whole and in pieces, which are written, not copied.
    own: Vec<PathBuf>,
    out: &'a mut OutputSet<'b>,
}

impl Copying<'_, '_> {
    fn folder(&mut self, inside: &Path, depth: usize) -> Result<()> {
        let folder = self.from.join(inside);
        // Points of the first time are those of the mesh that is written.
        let is_first = inside.iter().any(|name| name == "0");
        let is_mesh = is_first && inside.file_name().is_some_and(|name| name == MESH);
        if is_mesh {
            return Ok(());
        }
        // Of the folder of the mesh only what lies in folders, such as sets.
        let is_own = self.own.iter().any(|own| inside == own);
        if depth > DEPTH {
            return Err(
                Error::input(format!("has more than {DEPTH} folders inside one another"))
                    .file(&folder),
            );
        }
        let io = |error: io::Error| Error::io(&folder, &error);
        let entries = fs::read_dir(&folder)
            .map_err(io)?
            .collect::<io::Result<Vec<_>>>()
            .map_err(io)?;
        let mut names: Vec<_> = entries.iter().map(fs::DirEntry::file_name).collect();
        names.sort();
        for name in names {
            let inside = inside.join(name);
            match self.from.join(&inside).is_dir() {
                true => self.folder(&inside, depth + 1)?,
                false if is_own => {}
                false => self.file(&inside)?,
            }
        }
        Ok(())
    }

    fn file(&mut self, inside: &Path) -> Result<()> {
        let (from, to) = (self.from.join(inside), self.place.case.join(inside));
        // A link that leads nowhere is left out.
        if to.exists() || !from.exists() {
            return Ok(());
        }
        let io = |error: io::Error| Error::io(&from, &error);
        check_file(&from).map_err(io)?;
        let mut file = fs::File::open(&from).map_err(io)?;
        let name = inside.to_string_lossy();
        self.out.in_folder(&self.place.case, &name, |out| {
            io::copy(&mut file, out)
                .map(|_| ())
                .map_err(|error| Error::io(&to, &error))
        })
    }
}
