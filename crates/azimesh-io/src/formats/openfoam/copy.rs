//! Files of a case that are copied to the case of a sequence: `system`, `0` and `constant` of the case that the mesh was
//! read from, and the same folders of its pieces if these are written.

use super::case::{CONSTANT, MESH, Place};
use super::output::CaseFiles;
use super::topology::{StoredPieces, Topology};
use crate::formats::check_file;
use crate::formats::inputs::replaced;
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
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

/// Refuses to write a sequence into the case that its mesh was read from, or into a folder of that which is copied, and
/// a case with files that cannot be copied.
pub(super) fn check(case: &Path, mesh: &MeshView) -> Result<()> {
    let Some(origin) = mesh.origin.get::<Topology>() else {
        return Ok(());
    };
    let (from, to) = (resolved(&origin.path.root), resolved(case));
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
            "this is inside the folder {} of the case that the mesh is read from, which is copied; give a folder outside it",
            name.display()
        ))
        .file(case)),
        None => {
            // A file that cannot be read is refused before anything is written.
            let copying = Copying::of(origin, &Place::of(case, mesh, false))?;
            let mut files = copying.files.iter().map(|inside| copying.from.join(inside));
            files.try_for_each(|path| open(&path).map(|_| ()))
        }
    }
}

/// Refuses a case in which a link leads from a folder that the sequence writes to into the case that its mesh was read from.
/// `files` are the points of the steps.
pub(super) fn check_links(case: &Path, mesh: &MeshView, files: &[String]) -> Result<()> {
    let Some(origin) = mesh.origin.get::<Topology>() else {
        return Ok(());
    };
    let (from, to) = (resolved(&origin.path.root), resolved(case));
    let place = Place::of(case, mesh, false);
    let owned = place.owned().into_iter().map(PathBuf::from);
    let times = files.iter().filter_map(|file| Path::new(file).parent());
    let folders = times
        .map(Path::to_path_buf)
        .chain(owned)
        .chain(copied(place.pieces));
    for folder in folders.map(|folder| case.join(folder)) {
        let real = resolved(&folder);
        if real.starts_with(&from) && !real.starts_with(&to) {
            return Err(replaced(&folder, &real));
        }
    }
    Ok(())
}

/// A path without links, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    let full = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let known = full.ancestors().find_map(|above| {
        let found = fs::canonicalize(above).ok()?;
        let rest = full.strip_prefix(above).ok()?;
        Some(found.components().chain(rest.components()).collect())
    });
    known.unwrap_or(full)
}

/// Copies the files that belong to the case of the mesh. Files that are there already stay as they are.
pub(super) fn copy(mesh: &MeshView, files: &mut CaseFiles) -> Result<()> {
    let Some(origin) = mesh.origin.get::<Topology>() else {
        return Ok(());
    };
    let copying = Copying::of(origin, files.place)?;
    let case = &files.place.path.root;
    for inside in &copying.files {
        if !case.join(inside).exists() {
            let file = open(&copying.from.join(inside))?;
            files.copy(file, &inside.to_string_lossy(), &case.join(inside))?;
        }
    }
    for (inside, place) in &copying.links {
        if fs::symlink_metadata(case.join(inside)).is_err() {
            let to: PathBuf = inside.components().skip(1).map(|_| "..").collect();
            let name = inside.to_string_lossy();
            files.out.link_in_folder(&name, &to.join(place))?;
        }
    }
    Ok(())
}

/// The files of a case that are copied. A folder is copied once: a link that leads to it again becomes a link to the copy.
struct Copying<'a> {
    from: &'a Path,
    /// `from` without links.
    real: PathBuf,
    /// The folders that are copied.
    roots: Vec<PathBuf>,
    /// The folders of the mesh, whole and in pieces, which are written, not copied.
    own: Vec<PathBuf>,
    /// The folders so far, without links, and their places in the case.
    places: BTreeMap<PathBuf, PathBuf>,
    /// The files, by their places in the case.
    files: Vec<PathBuf>,
    /// The links and the places that they lead to.
    links: Vec<(PathBuf, PathBuf)>,
}

impl<'a> Copying<'a> {
    fn of(origin: &'a Topology, place: &Place) -> Result<Self> {
        let mut own: Vec<PathBuf> = place.folders(CONSTANT).iter().map(PathBuf::from).collect();
        own.push(PathBuf::from(place.path.folder(CONSTANT)));
        let real = resolved(&origin.path.root);
        let mut copying = Self {
            from: &origin.path.root,
            places: BTreeMap::from([(real.clone(), PathBuf::new())]),
            real,
            roots: copied(place.pieces),
            own,
            files: Vec::new(),
            links: Vec::new(),
        };
        for root in copying.roots.clone() {
            if copying.from.join(&root).is_dir() {
                copying.folder(&root)?;
            }
        }
        Ok(copying)
    }

    fn folder(&mut self, inside: &Path) -> Result<()> {
        let folder = self.from.join(inside);
        let real = resolved(&folder);
        if self.real.starts_with(&real) {
            return Err(Error::input(
                "this leads to a folder that holds the case itself, which cannot be copied; remove the link",
            )
            .file(&folder));
        }
        self.places.entry(real).or_insert_with(|| inside.into());
        let io = |error: io::Error| Error::io(&folder, &error);
        let entries = fs::read_dir(&folder)
            .map_err(io)?
            .collect::<io::Result<Vec<_>>>()
            .map_err(io)?;
        let mut names: Vec<_> = entries.iter().map(fs::DirEntry::file_name).collect();
        names.sort();
        // From the folder of the mesh only folders are copied, such as sets.
        let is_own = self.own.iter().any(|own| inside == own);
        for name in names {
            let inside = inside.join(name);
            let path = self.from.join(&inside);
            if !path.is_dir() {
                // A link that leads nowhere is left out.
                if !is_own && path.exists() {
                    self.files.push(inside);
                }
            } else if !is_first_mesh(&inside) {
                match self.copy_of(&path, &inside) {
                    Some(place) => self.links.push((inside, place)),
                    None => self.folder(&inside)?,
                }
            }
        }
        Ok(())
    }

    /// The place of a folder in the case, where a link leads to one that is copied anyway.
    fn copy_of(&self, path: &Path, inside: &Path) -> Option<PathBuf> {
        if !path.is_symlink() || self.own.iter().any(|own| inside == own) {
            return None;
        }
        let real = resolved(path);
        let in_case = real.strip_prefix(&self.real).ok();
        let in_root = in_case.filter(|place| self.roots.iter().any(|root| place.starts_with(root)));
        in_root
            .or(self.places.get(&real).map(PathBuf::as_path))
            .map(Path::to_path_buf)
    }
}

/// Checks if a folder holds the mesh at the first time, whose points are written.
fn is_first_mesh(inside: &Path) -> bool {
    inside.iter().any(|name| name == "0") && inside.file_name().is_some_and(|name| name == MESH)
}

fn open(path: &Path) -> Result<fs::File> {
    let opened = check_file(path).and_then(|()| fs::File::open(path));
    opened.map_err(|error| Error::io(path, &error))
}
