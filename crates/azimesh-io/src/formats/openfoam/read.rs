//! Reads a mesh: from the files of the whole case, or from its pieces.

use super::case::{Case, Instances};
use super::decomposed;
use super::dictionary;
use super::faces;
use super::file::FoamFile;
use super::folders::Step;
use super::lists;
use super::topology::{self, Patch, StoredFile, StoredPieces, Topology};
use super::zones::{self, Zone};
use crate::formats::by_faces::Faces;
use crate::formats::by_faces::{self, NONE};
use crate::formats::by_faces::{Label, Labels};
use crate::formats::{Location, Notes, ReadOptions};
use crate::mesh::{CellSet, Group, Mesh, Origin, too_many};
use azimesh_core::diagnostic::formats::Foam;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::any;
use std::collections::BTreeMap;

/// The lists of a mesh.
#[derive(Default)]
pub(super) struct Lists {
    /// Nodes.
    pub points: Vec<[f64; 3]>,
    /// Faces between two cells, then those of the patches.
    pub faces: Faces,
    /// The cell that each face points out of.
    pub owner: Labels,
    /// The other cell of the faces between two cells.
    pub neighbour: Labels,
    /// The patches.
    pub patches: Vec<Patch>,
    /// Zones of cells.
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
    let stored = match step.is_decomposed {
        true => {
            let (lists, pieces) = decomposed::read(&case, step, notes)?;
            Stored {
                lists,
                pieces,
                files: Vec::new(),
            }
        }
        false => whole(&case, step, notes)?,
    };
    mesh(stored, &case, notes)
}

/// The lists of a mesh and the files that they were read from, whole or in pieces.
struct Stored {
    lists: Lists,
    files: Vec<StoredFile>,
    pieces: Vec<StoredPieces>,
}

/// What of a case is not read.
fn note_rest(case: &Case, is_decomposed: bool, notes: &mut Notes) {
    if case.region.is_none() && !case.regions.is_empty() {
        notes.push(Foam::Regions {
            names: case.regions.clone(),
        });
    }
    if !is_decomposed && !case.pieces.is_empty() {
        notes.push(Foam::PiecesLeft {
            n: case.pieces.len(),
        });
    }
    match case.n_times_with_fields() {
        0 => {}
        n => notes.push(Foam::Fields { n }),
    }
}

/// The mesh of the case as a whole, and its files.
fn whole(case: &Case, step: &Step, notes: &mut Notes) -> Result<Stored> {
    let found = case.whole(step);
    let topology = found.since_faces();
    let read = LabelFiles::open(&topology)?;
    let mut lists = read.lists(&found.need("points")?)?;
    let mut files = read.into_files();
    if let Some(file) = topology.find("cellZones")? {
        lists.zones = zones::zones(&file, "cellLabels", lists.owner.len())?;
        files.push(StoredFile::of(&file));
    }
    for (name, key) in [("faceZones", "faceLabels"), ("pointZones", "pointLabels")] {
        let Some(file) = topology.find(name)? else {
            continue;
        };
        let names = zones::names(&file, key);
        if !names.is_empty() {
            notes.push(Foam::Zones { what: name, names });
        }
        files.push(StoredFile::of(&file));
    }
    Ok(Stored {
        lists,
        files,
        pieces: Vec::new(),
    })
}

/// The files of faces and patches.
pub(super) struct LabelFiles {
    pub faces: FoamFile,
    pub owner: FoamFile,
    pub neighbour: FoamFile,
    pub boundary: FoamFile,
}

impl LabelFiles {
    fn open(topology: &Instances) -> Result<Self> {
        if let Some(old) = topology.find("cells")?
            && topology.folder_of("owner").is_none()
        {
            let message = "the mesh has a file \"cells\" and no \"owner\": this is how OpenFOAM before 1.3 wrote it";
            return Err(old.refuse(Error::input(message)));
        }
        Ok(Self {
            faces: topology.need("faces")?,
            owner: topology.need("owner")?,
            neighbour: topology.need("neighbour")?,
            boundary: topology.need("boundary")?,
        })
    }

    /// Reads them all, and the points.
    pub fn lists(&self, points: &FoamFile) -> Result<Lists> {
        let faces = faces::faces(&self.faces)?;
        release(&self.faces, &faces.nodes);
        let n_faces = faces.len();
        let index = |label: i64| u32::try_from(label).ok().filter(|cell| *cell < NONE - 1);
        let owner = lists::indices(&self.owner, n_faces, index)?;
        release(&self.owner, &owner);
        let mut neighbour = lists::indices(&self.neighbour, n_faces, |label| match label {
            -1 => Some(NONE),
            label => index(label),
        })?;
        release(&self.neighbour, &neighbour);
        // Old files have -1 for each face on the boundary.
        neighbour.trim_end(NONE);
        let mut text = self.boundary.text();
        text.is_binary = false;
        let patches = self.boundary.checked(dictionary::patches(&mut text))?;
        let read = lists::points(points, faces.nodes.len().max(1))?;
        points.release();
        let lists = Lists {
            points: read,
            faces,
            owner,
            neighbour,
            patches,
            zones: Vec::new(),
        };
        lists.check(self)?;
        Ok(lists)
    }

    fn into_files(self) -> Vec<StoredFile> {
        let files = [self.faces, self.owner, self.neighbour, self.boundary];
        files.iter().map(StoredFile::of).collect()
    }
}

/// Lets go of the memory of a file whose labels were copied out of it.
fn release(file: &FoamFile, labels: &Labels) {
    if !labels.is_stored() {
        file.release();
    }
}

impl StoredFile {
    pub fn of(file: &FoamFile) -> Self {
        let name = file.path().file_name().unwrap_or_default();
        Self {
            name: name.to_string_lossy().into_owned(),
            stored: file.stored.clone(),
        }
    }
}

impl Lists {
    /// Checks that the lists fit each other.
    fn check(&self, files: &LabelFiles) -> Result<()> {
        let n_faces = self.faces.len();
        let wrong = |file: &FoamFile, message: String| {
            let name = file.path().file_name().unwrap_or_default();
            let error = Error::input(message).dataset(&name.to_string_lossy());
            Err(file.refuse(error))
        };
        if self.points.len() >= u32::MAX as usize {
            return wrong(&files.faces, too_many("nodes"));
        }
        let faces = self.faces.view();
        if let Some(face) = faces.first_below(3) {
            let n = faces.get(face).len();
            return wrong(
                &files.faces,
                format!("face {face} has {n} nodes; it must have at least 3"),
            );
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
            return wrong(&files.faces, message);
        }
        if self.owner.len() != n_faces {
            let message = format!(
                "{} faces have an owner, but there are {n_faces}",
                self.owner.len()
            );
            return wrong(&files.owner, message);
        }
        if self.neighbour.len() > n_faces {
            let message = format!(
                "{} faces have a neighbour, but there are {n_faces}",
                self.neighbour.len()
            );
            return wrong(&files.neighbour, message);
        }
        let (owner, neighbour) = (self.owner.view(), self.neighbour.view());
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
            return wrong(&files.neighbour, message);
        }
        self.check_patches()
            .or_else(|message| wrong(&files.boundary, message))
    }

    fn check_patches(&self) -> std::result::Result<(), String> {
        let mut end = self.neighbour.len();
        for patch in self.patches.iter().filter(|patch| patch.n_faces > 0) {
            let (name, start) = (&patch.name, patch.start_face);
            if start < end {
                return Err(format!(
                    "patch \"{name}\" starts at face {start}, which is {}",
                    match start < self.neighbour.len() {
                        true => "between two cells",
                        false => "in a patch before it",
                    }
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

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        let last = self.owner.largest().max(self.neighbour.largest());
        last.map_or(0, |last| last as usize + 1)
    }
}

/// Puts the cells together, with their tags and zones.
fn mesh(stored: Stored, case: &Case, notes: &mut Notes) -> Result<Mesh> {
    let Stored {
        mut lists,
        files,
        pieces,
    } = stored;
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
        content: topology::hash_of_content(all_files(&files, &pieces), &lists.points, &own),
        cells: own[0],
        groups: own[1],
        case: case.root.clone(),
        region: case.region.clone(),
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

/// The files of the whole and of its pieces.
fn all_files<'f>(
    whole: &'f [StoredFile],
    pieces: &'f [StoredPieces],
) -> impl Iterator<Item = &'f StoredFile> {
    let of_pieces = pieces.iter().flat_map(|folder| &folder.files);
    whole.iter().chain(of_pieces)
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
        is_first.then(|| (patch.kind.clone(), [patch.name.clone(), other.name.clone()]))
    });
    let pairs: Vec<_> = pairs.collect();
    if !pairs.is_empty() {
        notes.push(Foam::Pairs { pairs });
    }
}
