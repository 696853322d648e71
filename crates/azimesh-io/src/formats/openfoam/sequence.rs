//! A case with the points of many times: the case of a run, written step by step next to a mesh that all steps share,
//! and the case of a conversion, written as a whole.

use super::case::{CONSTANT, Case, CasePath, Place, mark_of, pieces_in};
use super::copy;
use super::output::CaseFiles;
use super::times::{TimeNames, WANTED, write_time};
use super::topology::hash_of_cells;
use super::write::check;
use crate::formats::inputs::{files_in, hash_of, hash_of_names};
use crate::formats::{
    Begin, Commit, Location, Notes, OutputSet, SequenceFile, Staged, WriteOptions,
};
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the point array that is the displacement of the nodes.
pub const DISPLACEMENT: &str = "Displacement";

/// The mesh that all steps share, as in the case.
pub struct Begun {
    /// Notes of the writer.
    pub notes: Notes,
    /// Hashes of its files but the points, by their paths from the case on.
    pub files: BTreeMap<String, blake3::Hash>,
    /// The files that are to be put in place.
    pub staged: Staged,
}

/// Format of sequences in a folder that holds more than meshes: a file for each step, next to what all steps share.
#[derive(Clone, Copy)]
pub struct CaseFormat;

impl CaseFormat {
    /// Checks if a folder is a case, with or without a mesh.
    pub fn is_case(&self, folder: &Path) -> bool {
        folder.join("system").join("controlDict").is_file() || folder.join(CONSTANT).is_dir()
    }

    /// The folder in the case that has the records of a run.
    pub fn records(&self) -> &'static str {
        "azimesh"
    }

    /// Refuses to write the sequence of a mesh to a case.
    pub fn check(&self, case: &Path, mesh: &MeshView) -> Result<()> {
        check(mesh)?;
        copy::check(case, mesh)
    }

    /// The folder of the mesh that all steps share, from the case on.
    pub fn shared(&self, mesh: &MeshView) -> String {
        let place = Place::of(Path::new(""), mesh, false);
        place.folders(CONSTANT).swap_remove(0)
    }

    /// The file of each step, as a path from the case on, for steps of these times.
    ///
    /// # Errors
    /// If two steps would have one file.
    pub fn step_files(&self, case: &Path, mesh: &MeshView, times: &[f64]) -> Result<Vec<String>> {
        let place = Place::of(case, mesh, false);
        let folders = TimeNames::of(&place.path.root, mesh)?.folders(times)?;
        let file = |folder: &String| format!("{}/points", place.folders(folder)[0]);
        let files: Vec<String> = folders.iter().map(file).collect();
        copy::check_links(case, mesh, &files)?;
        Ok(files)
    }

    /// Checks if the file of a step replaces the mesh that all steps share.
    pub fn is_shared(&self, file: &str) -> bool {
        time_in(file) == CONSTANT
    }

    /// Stages what all steps share, and copies what belongs to the case that the mesh was read from. What is there
    /// already is kept; an existing mesh is replaced with [`Begin::Create`]. With [`Begin::Resume`] it is kept where it is
    /// this one; where a file is missing or another, all but its points are written again.
    ///
    /// # Errors
    /// If the mesh that is there is another one.
    pub fn begin(
        &self,
        case: &Path,
        mesh: &MeshView,
        options: &WriteOptions,
        begin: Begin,
        commit: Commit,
    ) -> Result<Begun> {
        let place = Place::of(case, mesh, false);
        let root = &place.path.root;
        let owned = place.owned();
        let write = |out: &mut OutputSet| -> Result<Notes> {
            out.place_in(root, &owned)?;
            CaseFiles::new(out, &place, options).topology(mesh, options)
        };
        let is_there_already = owned.iter().any(|own| root.join(own).exists());
        let own = place.folders(CONSTANT);
        let points = || own.iter().map(|own| format!("{own}/points"));
        let mut has_points = false;
        if begin == Begin::Resume && is_there_already {
            let mut wanted = OutputSet::nowhere(root).hashed();
            let notes = write(&mut wanted)?;
            let files = wanted.finish().of_folder;
            has_points = points().all(|points| root.join(points).is_file());
            let is_there = |(name, hash): (&String, &blake3::Hash)| {
                hash_of(&root.join(name)).is_ok_and(|own| own == *hash)
            };
            if has_points && files.iter().all(is_there) {
                return Ok(Begun {
                    notes,
                    files,
                    staged: Staged::all(Vec::new()),
                });
            }
        }
        // Of several runs that find none, each a part of the sequence, one puts its mesh in place.
        let replace = is_there_already || begin != Begin::Resume;
        let mut out = OutputSet::new(root, Commit { replace, ..commit }).hashed();
        let mut notes = write(&mut out)?;
        let mut files = CaseFiles::new(&mut out, &place, options);
        if has_points {
            // They may be the points of a step. Their folder is replaced as a whole.
            for points in points() {
                let path = root.join(&points);
                let file = File::open(&path).map_err(|error| Error::io(&path, &error))?;
                files.copy(file, &points, &path)?;
            }
            notes.push(note!(
                "mesh_again",
                "{}: a file is missing or not as it was written; all files there but the points are written again",
                own.join(", ")
            ));
        } else {
            files.points(mesh.points, CONSTANT)?;
        }
        copy::copy(mesh, &mut files)?;
        files.mark(&mark_of(case))?;
        let written = out.finish();
        let mut files = written.of_folder;
        let is_own = |name: &str| owned.iter().any(|own| Path::new(name).starts_with(own));
        files.retain(|name, _| is_own(name) && !name.ends_with("/points"));
        Ok(Begun {
            notes,
            files,
            staged: written.files,
        })
    }

    /// Writes a step, whose displacement is the point array [`DISPLACEMENT`] where it has one.
    pub fn write_step(
        &self,
        mesh: &MeshView,
        file: &str,
        out: &mut OutputSet,
        options: &WriteOptions,
    ) -> Result<()> {
        let place = Place::of(out.path(), mesh, false);
        let folder = time_in(file);
        let of_field = match folder {
            CONSTANT => TimeNames::of(&place.path.root, mesh)?.name(0.0),
            folder => folder.to_owned(),
        };
        let mut files = CaseFiles::new(out, &place, options);
        write_time(&mut files, mesh, folder, &of_field)
    }

    /// Checks if a step that was written has this hash, as [`OutputSet`] gave it.
    pub fn has_hash(&self, path: &Path, hash: &str) -> io::Result<bool> {
        if hash_of(path)?.to_string() == hash {
            return Ok(true);
        }
        let (case, files) = files_in_case(path).unwrap_or_default();
        let hashes = files
            .into_iter()
            .map(|name| Ok((name.clone(), hash_of(&case.join(name))?)));
        let hashes: BTreeMap<_, _> = hashes.collect::<io::Result<_>>()?;
        Ok(hash_of_names(&hashes).to_string() == hash)
    }

    /// The case and the index in it of the step whose file this is, where the file has a part of the mesh only.
    pub fn step_at(&self, path: &Path) -> Option<(Location, usize)> {
        let path = CasePath::of_points(path)?;
        let (case, pieces) = whole_case(&path);
        let location = (!pieces.is_empty()).then(|| case.location())?;
        let mut steps = Case::at(&location).ok()?.steps.into_iter();
        let step = steps.position(|step| Some(step.name) == path.time)?;
        Some((location, step))
    }

    /// All files in the folders of the mesh at the time of a step, of a run or not; with `has_field` also the field that a step
    /// has next to them.
    pub fn files_at(&self, path: &Path, has_field: bool) -> Vec<PathBuf> {
        let Some(points) = CasePath::of_points(path) else {
            return Vec::new();
        };
        let time = points.time.clone().unwrap_or_default();
        let mut found = self.files_of(path);
        found.retain(|file| has_field || !file.ends_with(WANTED));
        let (case, pieces) = whole_case(&points);
        let roots = pieces.iter().map(|piece| case.root.join(piece));
        for root in roots.chain([case.root.clone()]) {
            let folder = root.join(case.folder(&time));
            let names = files_in(&folder).unwrap_or_default();
            found.extend(names.into_iter().map(|name| folder.join(name)));
        }
        found.sort();
        found.dedup();
        found
    }

    /// All files of a step that are there, as paths.
    pub fn files_of(&self, path: &Path) -> Vec<PathBuf> {
        let (case, files) = files_in_case(path).unwrap_or_default();
        files.iter().map(|name| case.join(name)).collect()
    }
}

/// The time of the file of a step, `time/polyMesh/points`, also in a piece.
fn time_in(file: &str) -> &str {
    let mut names = file
        .split('/')
        .skip_while(|name| name.starts_with("processor"));
    names.next().unwrap_or(file)
}

/// The case of a path, and the folders of its pieces if the path is in one of them.
fn whole_case(path: &CasePath) -> (CasePath, Vec<String>) {
    let root = path.root.parent().unwrap_or(Path::new("")).to_path_buf();
    let pieces = pieces_in(&root).into_iter().map(|pieces| pieces.name);
    let pieces: Vec<String> = pieces.collect();
    let own = path.root.file_name().unwrap_or_default();
    let mut case = path.clone();
    if !pieces.iter().any(|piece| **piece == *own) {
        return (case, Vec::new());
    }
    case.root = root;
    (case, pieces)
}

/// The case of the points of a step, and all files of the step that are there.
fn files_in_case(points: &Path) -> Option<(PathBuf, Vec<String>)> {
    let path = CasePath::of_points(points)?;
    let time = path.time.as_deref()?;
    let (case, pieces) = whole_case(&path);
    // The displacement at the mesh that a case begins with is in the folder of its first time.
    let field_time = match time {
        CONSTANT => TimeNames::of_case(&case.root).unwrap_or_default().name(0.0),
        time => time.to_owned(),
    };
    let name = points.file_name()?.to_string_lossy();
    let own = [
        format!("{}/{name}", path.folder(time)),
        format!("{}/{WANTED}", path.fields(&field_time)),
    ];
    let mut files = own.to_vec();
    if !pieces.is_empty() {
        let of_piece = |piece: &String| own.each_ref().map(|own| format!("{piece}/{own}"));
        files = pieces.iter().flat_map(of_piece).collect();
    }
    files.retain(|name| case.root.join(name).is_file());
    Some((case.root, files))
}

/// A case that takes one mesh after another, as a whole.
pub(super) struct Sequence {
    folder: PathBuf,
    options: WriteOptions,
    /// The folders of the steps so far, and their times.
    times: BTreeMap<String, f64>,
    /// Hash of the cells of the first mesh.
    first: Option<blake3::Hash>,
    n_bytes: u64,
    notes: Notes,
}

impl Sequence {
    /// In an empty folder.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin) -> Result<Self> {
        if begin != Begin::Fill {
            return Err(Error::input("a case is not resumed mesh by mesh").file(path));
        }
        Ok(Self {
            folder: path.to_path_buf(),
            options: options.clone(),
            times: BTreeMap::new(),
            first: None,
            n_bytes: 0,
            notes: Notes::default(),
        })
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        check(mesh)?;
        let cells = hash_of_cells(mesh.points.len(), mesh.cells);
        let is_first = self.first.is_none();
        if *self.first.get_or_insert(cells) != cells {
            return Err(Error::input(format!(
                "step {} has other nodes or cells than the first step; all times of an OpenFOAM case that is written \
                 have the same; a list (OUT.pvd) has a file for each step",
                self.times.len()
            )));
        }
        let folder = &TimeNames::default().new_folder(time, &mut self.times)?;
        let mut place = Place::of(&self.folder, mesh, self.options.pieces.is_some());
        place.path.root.clone_from(&self.folder);
        let commit = Commit {
            replace: true,
            sync: false,
        };
        let mut out = OutputSet::new(&self.folder, commit).hashed();
        out.place_in(&self.folder, &[])?;
        let mut files = CaseFiles::new(&mut out, &place, &self.options);
        if is_first {
            self.notes = files.topology(mesh, &self.options)?;
            files.points(mesh.points, CONSTANT)?;
        }
        if !is_first || folder != CONSTANT {
            files.points(mesh.points, folder)?;
        }
        let written = out.finish();
        self.n_bytes += written.n_bytes;
        let hash = written.hash.expect("it was asked for");
        written.files.keep()?;
        Ok(hash)
    }

    fn notes(&self) -> &Notes {
        &self.notes
    }

    fn n_bytes(&self) -> u64 {
        self.n_bytes
    }
}
