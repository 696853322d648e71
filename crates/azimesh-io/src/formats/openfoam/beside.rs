//! What belongs to a case beside its mesh: `system`, `0` and `constant`, and those of its pieces where these are written,
//! copied where the mesh was read from a case.

use super::folders::{CONSTANT, MESH};
use super::place::Place;
use super::topology::{StoredPieces, Topology};
use crate::formats::{OutputSet, check_file};
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
        None => Copying::of(origin, &Place::of(case, mesh))?.check(),
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
    match mesh.origin.get::<Topology>() {
        Some(origin) => Copying::of(origin, place)?.copy(&place.case, out),
        None => Ok(()),
    }
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
        own.push(PathBuf::from(place.folder(CONSTANT)));
        let real = resolved(&origin.case);
        let mut copying = Self {
            from: &origin.case,
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
        // Of the folder of the mesh only what lies in folders, such as sets.
        let is_own = self.own.iter().any(|own| inside == own);
        for name in names {
            let inside = inside.join(name);
            let path = self.from.join(&inside);
            match path.is_dir() {
                true if is_first_mesh(&inside) => {}
                true => match self.copy_of(&path, &inside) {
                    Some(place) => self.links.push((inside, place)),
                    None => self.folder(&inside)?,
                },
                // A link that leads nowhere is left out.
                false if is_own || !path.exists() => {}
                false => self.files.push(inside),
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

    /// Opens each file, so that one that cannot be read is refused before anything is written.
    fn check(&self) -> Result<()> {
        let mut files = self.files.iter().map(|inside| self.from.join(inside));
        files.try_for_each(|path| open(&path).map(|_| ()))
    }

    fn copy(&self, case: &Path, out: &mut OutputSet) -> Result<()> {
        for inside in self
            .files
            .iter()
            .filter(|inside| !case.join(inside).exists())
        {
            let mut file = open(&self.from.join(inside))?;
            out.in_folder(case, &inside.to_string_lossy(), |out| {
                io::copy(&mut file, out)
                    .map(|_| ())
                    .map_err(|error| Error::io(&case.join(inside), &error))
            })?;
        }
        for (inside, place) in &self.links {
            if fs::symlink_metadata(case.join(inside)).is_err() {
                let above = inside.components().skip(1).map(|_| "..");
                let to: PathBuf = above.collect();
                out.link_in_folder(&inside.to_string_lossy(), &to.join(place))?;
            }
        }
        Ok(())
    }
}

/// Whether a folder holds the mesh at the first time: points there are those of the mesh that is written.
fn is_first_mesh(inside: &Path) -> bool {
    inside.iter().any(|name| name == "0") && inside.file_name().is_some_and(|name| name == MESH)
}

fn open(path: &Path) -> Result<fs::File> {
    let opened = check_file(path).and_then(|()| fs::File::open(path));
    opened.map_err(|error| Error::io(path, &error))
}
