//! Reads a mesh: from the files of the whole case, or from its pieces.

use super::case::{Case, ProcessorDirs};
use super::file::{FoamFile, path_of};
use super::topology::{self, Patch, StoredFile, StoredPieces, Topology};
use super::zones::{self, Zone};
use super::{decomposed, lists};
use crate::formats::by_faces::{self, Faces, Label, Labels, NONE};
use crate::formats::notes::{listed, quoted};
use crate::formats::{Location, Notes, ReadOptions};
use crate::mesh::{CellSet, Group, Mesh, Origin, too_many};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use azimesh_core::parallel::any;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files of the topology that a mesh must have.
const TOPOLOGY: [&str; 4] = ["faces", "owner", "neighbour", "boundary"];
/// Files that are kept for the writer without reading them.
const ONLY_STORED: [&str; 3] = ["faceZones", "pointZones", "boundaryProcAddressing"];

/// The files of a mesh by their names; of collated files a block of each.
pub(super) type Files = BTreeMap<&'static str, FoamFile>;

/// The lists of a mesh.
#[derive(Default)]
pub(super) struct Lists {
    pub points: Vec<[f64; 3]>,
    /// Faces between two cells, then faces of the patches.
    pub faces: Faces,
    /// The cell that each face points out of.
    pub owner: Labels,
    /// The other cell of the faces between two cells.
    pub neighbour: Labels,
    pub patches: Vec<Patch>,
    pub zones: Vec<Zone>,
}

/// Reads the mesh of a step.
pub(super) fn read(location: &Location, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let case = Case::at(location)?;
    let n = case.steps.len();
    let step = options.step.unwrap_or(n - 1);
    let step = case.steps.get(step).ok_or_else(|| {
        Error::input(format!("there is no step {step}: the case has {n}, from 0"))
            .file(location.path())
    })?;
    note_rest(&case, step.is_decomposed, notes);
    if step.is_decomposed {
        let (lists, pieces) = decomposed::read(&case, step, notes)?;
        return mesh(lists, Vec::new(), pieces, &case, notes);
    }
    let (mut meshes, stored) = read_lists(&case.folders(step, None), None, &[])?;
    let (lists, files) = meshes.swap_remove(0);
    for (name, key) in [("faceZones", "faceLabels"), ("pointZones", "pointLabels")] {
        let names = files
            .get(name)
            .map_or(Vec::new(), |file| zones::names(file, key));
        notes.list(names, |names| {
            let names = listed(&quoted(&names));
            note!(
                "zones_for_openfoam",
                "{name} are kept for OpenFOAM alone: {names}"
            )
        });
    }
    drop(files);
    mesh(lists, stored, Vec::new(), &case, notes)
}

/// Adds notes on parts of a case that are not read.
fn note_rest(case: &Case, is_decomposed: bool, notes: &mut Notes) {
    if case.path.region.is_none() && !case.regions.is_empty() {
        notes.push(note!(
            "regions",
            "the case has regions with meshes of their own: {}; constant/REGION is read alone",
            listed(&quoted(&case.regions))
        ));
    }
    if !is_decomposed && !case.pieces.is_empty() {
        notes.push(note!(
            "pieces_left",
            "the case is decomposed too, in {}; the whole mesh is read, and not its pieces: they are where constant/polyMesh is not there",
            counted(case.pieces.len(), "folder")
        ));
    }
    notes.count(case.n_times_with_fields(), |n| {
        note!(
            "fields_not_read",
            "the fields of {} are not read",
            counted(n, "time")
        )
    });
}

/// Reads the meshes in some folders, the latest first: one or, from collated files, one of each block. Returns their files
/// too, and all files of the topology as they are.
#[allow(clippy::type_complexity)]
pub(super) fn read_lists(
    folders: &[PathBuf],
    pieces: Option<(&ProcessorDirs, &Path)>,
    further: &[&'static str],
) -> Result<(Vec<(Lists, Files)>, Vec<StoredFile>)> {
    let find = |folders: &[PathBuf], name: &str| -> Result<Option<FoamFile>> {
        let mut paths = folders.iter().filter_map(|folder| path_of(folder, name));
        paths.next().map(|path| FoamFile::open(&path)).transpose()
    };
    let need = |folders: &[PathBuf], name: &str| {
        find(folders, name)?.ok_or_else(|| {
            let last = folders.last().map_or(Path::new(""), PathBuf::as_path);
            let error = Error::input(format!("the mesh has no file \"{name}\""));
            error.file(pieces.map_or(last, |(_, folder)| folder))
        })
    };
    let points = need(folders, "points")?;
    // The other files belong to the latest `faces`.
    let last = folders
        .iter()
        .position(|folder| path_of(folder, "faces").is_some());
    let folders = last.map_or(folders, |last| &folders[..=last]);
    if let Some(old) = find(folders, "cells")?
        && find(folders, "owner")?.is_none()
    {
        let message = "the mesh has a file \"cells\" and no \"owner\": this is how OpenFOAM before 1.3 wrote it";
        return Err(old.refuse(Error::input(message)));
    }
    let mut files = vec![("points", points)];
    for name in TOPOLOGY {
        files.push((name, need(folders, name)?));
    }
    for name in ["cellZones", "faceZones", "pointZones"]
        .iter()
        .chain(further)
    {
        files.extend(find(folders, name)?.map(|file| (*name, file)));
    }
    let stored = files[1..].iter().map(|(_, file)| StoredFile::of(file));
    let stored = stored.collect();
    let is_collated = pieces.is_some_and(|(pieces, _)| pieces.is_collated);
    let mut meshes: Vec<Files> = Vec::new();
    for (name, file) in files {
        if is_collated && ONLY_STORED.contains(&name) {
            continue;
        }
        let blocks = if is_collated {
            file.blocks()?
        } else {
            vec![file.clone()]
        };
        if meshes.is_empty() {
            meshes.resize_with(blocks.len(), Files::new);
        }
        let n = meshes.len();
        if blocks.len() != n {
            let message = format!(
                "the file has {} blocks, but \"points\" has {n}",
                blocks.len()
            );
            return Err(file.refuse(Error::input(message).byte(0)));
        }
        for (mesh, block) in meshes.iter_mut().zip(blocks) {
            mesh.insert(name, block);
        }
    }
    let lists = meshes
        .into_iter()
        .map(|files| Ok((Lists::of(&files)?, files)));
    Ok((lists.collect::<Result<_>>()?, stored))
}

impl Lists {
    fn of(files: &Files) -> Result<Self> {
        let [points, faces, owner, neighbour, boundary] =
            ["points", "faces", "owner", "neighbour", "boundary"].map(|name| &files[name]);
        let mut lists = Self {
            faces: lists::faces(faces)?,
            ..Self::default()
        };
        let n_faces = lists.faces.len();
        let index = |label: i64| u32::try_from(label).ok().filter(|cell| *cell < NONE - 1);
        lists.owner = lists::indices(owner, n_faces, index)?;
        lists.neighbour = lists::indices(neighbour, n_faces, |label| match label {
            -1 => Some(NONE),
            label => index(label),
        })?;
        // Old files have -1 for each face on the boundary.
        lists.neighbour.trim_end(NONE);
        let mut text = boundary.text();
        text.is_binary = false;
        lists.patches = boundary.checked(topology::patches(&mut text))?;
        lists.points = lists::points(points)?;
        points.release();
        lists.check(files)?;
        if let Some(file) = files.get("cellZones") {
            lists.zones = zones::zones(file, "cellLabels", n_faces)?;
        }
        Ok(lists)
    }

    /// Checks that the lists fit each other.
    fn check(&self, files: &Files) -> Result<()> {
        let n_faces = self.faces.len();
        let wrong = |name: &'static str, message: String| {
            let file = &files[name];
            let name = file.path().file_name().unwrap_or_default();
            let error = Error::input(message).dataset(&name.to_string_lossy());
            Err(file.refuse(error))
        };
        if self.points.len() >= u32::MAX as usize {
            return wrong("faces", too_many("nodes"));
        }
        let faces = self.faces.view();
        if let Some(face) = faces.first_below(3) {
            let n = faces.get(face).len();
            let message = format!("face {face} has {n} nodes; it must have at least 3");
            return wrong("faces", message);
        }
        let n_points = self.points.len() as u32;
        let is_beyond = |node: &Label| node.get() >= n_points;
        let largest = self.faces.nodes.largest();
        if largest.is_some_and(|node| node >= n_points)
            && let Some(at) = faces.nodes.iter().position(is_beyond)
        {
            let face = faces.face_at(at);
            let node = faces.nodes[at].get();
            let message =
                format!("face {face} has node {node}, but the mesh has {n_points} nodes (from 0)");
            return wrong("faces", message);
        }
        let (owner, neighbour) = (self.owner.view(), self.neighbour.view());
        let count =
            |n: usize, what: &str| format!("{n} faces have {what}, but there are {n_faces}");
        if owner.len() != n_faces {
            return wrong("owner", count(owner.len(), "an owner"));
        }
        if neighbour.len() > n_faces {
            return wrong("neighbour", count(neighbour.len(), "a neighbour"));
        }
        let is_alone = |face: usize| [NONE, owner[face].get()].contains(&neighbour[face].get());
        if any(neighbour.len(), is_alone)
            && let Some(face) = (0..neighbour.len()).find(|face| is_alone(*face))
        {
            let message = match neighbour[face].get() {
                NONE => format!(
                    "face {face} has no neighbour, but face {} after it has one",
                    face + 1
                ),
                cell => format!("face {face} has cell {cell} on both sides"),
            };
            return wrong("neighbour", message);
        }
        self.check_patches()
            .or_else(|message| wrong("boundary", message))
    }

    fn check_patches(&self) -> std::result::Result<(), String> {
        let mut end = self.neighbour.len();
        for patch in self.patches.iter().filter(|patch| patch.n_faces > 0) {
            let (name, start) = (&patch.name, patch.start_face);
            if start < end {
                let place = if start < self.neighbour.len() {
                    "between two cells"
                } else {
                    "in a patch before it"
                };
                return Err(format!(
                    "patch \"{name}\" starts at face {start}, which is {place}"
                ));
            }
            end = start + patch.n_faces;
            if end > self.faces.len() {
                let n = self.faces.len();
                return Err(format!(
                    "patch \"{name}\" ends at face {end}, but there are {n}"
                ));
            }
        }
        Ok(())
    }

    pub fn n_cells(&self) -> usize {
        let last = self.owner.largest().max(self.neighbour.largest());
        last.map_or(0, |last| last as usize + 1)
    }
}

/// Puts the cells together, with their tags and zones.
fn mesh(
    mut lists: Lists,
    files: Vec<StoredFile>,
    pieces: Vec<StoredPieces>,
    case: &Case,
    notes: &mut Notes,
) -> Result<Mesh> {
    let n_cells = lists.n_cells();
    let n_internal = lists.neighbour.len();
    if n_cells > lists.owner.len() + n_internal {
        return Err(Error::input(format!(
            "the last cell is {}, but there are {} faces, too few for so many cells",
            n_cells - 1,
            lists.owner.len()
        ))
        .dataset("owner"));
    }
    let cells = by_faces::assemble(&lists.faces, &lists.owner, &lists.neighbour, n_cells, 0)
        .map_err(|error| error.dataset("faces"))?;
    // What follows takes memory of its own, and reads the files one by one.
    for labels in [&lists.faces.nodes, &lists.owner, &lists.neighbour] {
        labels.release();
    }
    (lists.faces, lists.owner, lists.neighbour) = Default::default();
    let mut groups = Vec::new();
    for patch in &lists.patches {
        let mut set = CellSet::new();
        if patch.n_faces > 0 {
            let first = n_cells + patch.start_face - n_internal;
            set.push_range(first..first + patch.n_faces);
        }
        groups.push(group(2, &patch.name, patch.condition(), set));
    }
    for zone in &lists.zones {
        if let Some(cell) = zone.labels.iter().find(|cell| **cell as usize >= n_cells) {
            return Err(Error::input(format!(
                "zone \"{}\" has cell {cell}, but the mesh has {n_cells} cells (from 0)",
                zone.name
            ))
            .dataset("cellZones"));
        }
        let set = zone.labels.iter().map(|cell| *cell as usize).collect();
        groups.push(group(3, &zone.name, None, set));
    }
    note_pairs(&lists.patches, notes);
    let own = [
        topology::hash_of_cells(lists.points.len(), &cells),
        topology::hash_of_groups(&groups),
    ];
    let topology = Topology {
        content: topology::hash_of_content(
            files
                .iter()
                .chain(pieces.iter().flat_map(|folder| &folder.files)),
            &lists.points,
            &own,
        ),
        cells: own[0],
        groups: own[1],
        path: case.path.clone(),
        files,
        pieces,
        patches: lists.patches,
        n_internal_faces: n_internal,
    };
    Ok(Mesh {
        points: lists.points,
        cells,
        groups,
        origin: Origin::new(topology),
        ..Mesh::default()
    })
}

fn group(dimension: u8, name: &str, condition: Option<String>, cells: CellSet) -> Group {
    Group {
        dimension,
        name: name.to_owned(),
        number: None,
        condition,
        cells,
    }
}

/// Names the pairs of patches that are one boundary.
fn note_pairs(patches: &[Patch], notes: &mut Notes) {
    let known: BTreeMap<&str, &Patch> = patches.iter().map(|known| (&*known.name, known)).collect();
    let pairs = patches.iter().filter_map(|patch| {
        let other = known.get(patch.entry("neighbourPatch")?)?;
        // Each pair once.
        let is_first = patch.name < other.name;
        is_first.then(|| format!("\"{}\" and \"{}\" ({})", patch.name, other.name, patch.kind))
    });
    notes.list(pairs.collect(), |pairs| {
        note!("patch_pairs", "pairs of patches: {}", listed(&pairs))
    });
}
