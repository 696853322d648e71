//! Writes the files of a polyMesh: those that the mesh was read from, byte for byte, as far as they fit, others from its
//! cells, tags and zones.

use super::boundary::Patches;
use super::case::{CONSTANT, Place, mark_of};
use super::faces::{CellNumbers, FaceList, OrderedFaces};
use super::output::{CaseFiles, labels, list};
use super::topology::{StoredFile, Topology};
use super::zones::{KeptZones, write_cell_zones};
use crate::formats::names::names_in;
use crate::formats::records::{push_integer, write_all};
use crate::formats::{Notes, OutputSet, WriteOptions};
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result, option};
use azimesh_core::note;
use std::fs::{self, File};
use std::io::Write;

/// The files that are written from cells, tags and zones.
const WRITTEN: [&str; 5] = ["faces", "owner", "neighbour", "boundary", "cellZones"];

/// The files of zones that a mesh does not hold.
const ZONES: [&str; 2] = ["faceZones", "pointZones"];

/// Refuses meshes that OpenFOAM has no cells for.
pub(super) fn check(mesh: &MeshView) -> Result<()> {
    if mesh.dimension() != 3 {
        let advice = match mesh.dimension() {
            2 => format!("; {} makes one layer of cells of it", option("extrude H")),
            _ => String::new(),
        };
        return Err(Error::input(format!(
            "OpenFOAM has meshes of solid cells only, and this one has dimension {}{advice}",
            mesh.dimension()
        )));
    }
    let mut runs = mesh.volume_runs();
    if mesh.volume_runs().next().is_none() {
        return Err(Error::input(
            "OpenFOAM has meshes of solid cells only, and this one has none",
        ));
    }
    match runs.find(|run| run.kind.is_curved()) {
        Some(run) => Err(Error::input(format!(
            "cell {} is a {}, and OpenFOAM has cells with straight edges only; {} keeps their corners",
            run.first_cell,
            run.kind.name(),
            option("linearize")
        ))),
        None => Ok(()),
    }
}

/// Writes a mesh to the case of the output.
pub(super) fn write(mesh: &MeshView, out: &mut OutputSet, options: &WriteOptions) -> Result<Notes> {
    check(mesh)?;
    let place = Place::of(out.path(), mesh, options.pieces.is_some());
    let mark = mark_of(out.path());
    out.place_in(&place.path.root, &place.owned())?;
    let mut files = CaseFiles::new(out, &place, options);
    let notes = files.topology(mesh, options)?;
    files.points(mesh.points, CONSTANT)?;
    files.mark(&mark)?;
    Ok(notes)
}

/// Name of a file without the ending of compression.
fn plain(name: &str) -> &str {
    name.strip_suffix(".gz").unwrap_or(name)
}

impl CaseFiles<'_, '_> {
    /// Writes all but the points.
    pub fn topology(&mut self, mesh: &MeshView, options: &WriteOptions) -> Result<Notes> {
        let mut notes = Notes::default();
        let format = "OpenFOAM";
        notes.arrays_left_out(format, mesh, &[]);
        notes.in_64_bits(format, options);
        notes.lower_groups(format, names_in(mesh, 0..2));
        let origin = mesh.origin.get::<Topology>();
        if let (Some(origin), false) = (origin, self.place.pieces.is_empty()) {
            let folders = self.place.folders(CONSTANT);
            for (pieces, folder) in self.place.pieces.iter().zip(folders) {
                for file in &pieces.files {
                    self.stored(&folder, file)?;
                }
                self.further(origin, &pieces.files, &folder)?;
            }
            return Ok(notes);
        }
        let fits = |origin: &&Topology| origin.has_cells_of(mesh);
        if let Some(origin) = origin
            .filter(|origin| !origin.files.is_empty())
            .filter(fits)
            && self.of_origin(mesh, origin, &mut notes)?
        {
            return Ok(notes);
        }
        if origin.is_some_and(|origin| !origin.pieces.is_empty()) && options.pieces.is_none() {
            notes.push(note!(
                "as_one",
                "the mesh is written as one: its cells or tags differ from the pieces that it was read from; decomposePar cuts it again"
            ));
        }
        self.of_cells(mesh, origin, &mut notes)?;
        Ok(notes)
    }

    /// Writes the files that the mesh was read from; patches and zones anew if the mesh has others. Returns
    /// `false`, and writes nothing, where the faces would need another order.
    fn of_origin(&mut self, mesh: &MeshView, origin: &Topology, notes: &mut Notes) -> Result<bool> {
        let mut new = None;
        if !origin.has_groups_of(mesh) {
            let mut remarks = Notes::default();
            let patches = Patches::of(mesh, Some(origin), &mut remarks)?;
            let Some(sizes) = sizes_of(mesh, &patches) else {
                return Ok(false);
            };
            notes.extend(remarks);
            notes.extend(patches.notes_on_faces(mesh, &sizes));
            new = Some(patches.text(origin.n_internal_faces, &sizes));
        }
        let folder = self.place.path.folder(CONSTANT);
        for file in &origin.files {
            let is_group = ["boundary", "cellZones"].contains(&plain(&file.name));
            if new.is_none() || !is_group {
                self.stored(&folder, file)?;
            }
        }
        self.further(origin, &origin.files, &folder)?;
        if let Some(boundary) = new {
            self.groups(mesh, &boundary)?;
        }
        Ok(true)
    }

    /// Copies the files of a folder that are neither points nor `own`, such as levels of refinement.
    fn further(&mut self, origin: &Topology, own: &[StoredFile], folder: &str) -> Result<()> {
        let entries = fs::read_dir(origin.path.root.join(folder)).into_iter();
        let paths = entries.flatten().flatten().map(|entry| entry.path());
        let mut paths: Vec<_> = paths.filter(|path| path.is_file()).collect();
        paths.sort();
        for path in paths {
            let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
                continue;
            };
            let mut own = own.iter().map(|file| plain(&file.name)).chain(["points"]);
            if !name.starts_with('.') && !own.any(|own| own == plain(name)) {
                let file = File::open(&path).map_err(|error| Error::io(&path, &error))?;
                self.copy(file, &format!("{folder}/{name}"), &path)?;
            }
        }
        Ok(())
    }

    /// Writes files from cells, tags and zones.
    fn of_cells(
        &mut self,
        mesh: &MeshView,
        origin: Option<&Topology>,
        notes: &mut Notes,
    ) -> Result<()> {
        let mut patches = Patches::of(mesh, origin, notes)?;
        // Zones of faces and points are kept where the mesh has the same cells still and they can be read.
        let kept = origin.filter(|origin| origin.has_cells_of(mesh));
        let kept = kept.and_then(|origin| KeptZones::of(origin).ok());
        let is_lost =
            |name: &&str| !WRITTEN.contains(name) && (kept.is_none() || !ZONES.contains(name));
        let files = origin.into_iter().flat_map(|origin| &origin.files);
        let lost = files.map(|file| plain(&file.name)).filter(is_lost);
        notes.list(lost.collect(), |names: Vec<&str>| {
            let names = names.join(", ");
            note!(
                "files_left_out",
                "left out, since faces have another order now: {names}"
            )
        });
        let n_patches = patches.list.len() - 1;
        let ordered = OrderedFaces::of(mesh, &patches.of_cell, n_patches)?;
        patches.find_inside(mesh, &ordered.patch_sizes);
        notes.extend(patches.notes_on_faces(mesh, &ordered.patch_sizes));
        notes.count(ordered.n_reversed, |n| {
            note!(
                "turned_round",
                "cells are listed in the other orientation, with a negative volume ({n}); they are turned round, for faces of OpenFOAM \
                 point out of their cells"
            )
        });
        let counts = format!(
            "nPoints:{}  nCells:{}  nFaces:{}  nInternalFaces:{}",
            mesh.points.len(),
            ordered.n_cells,
            ordered.faces.len(),
            ordered.neighbour.len()
        );
        self.faces(&ordered.faces)?;
        let is_binary = self.is_binary;
        for (name, cells) in [("owner", &ordered.owner), ("neighbour", &ordered.neighbour)] {
            self.constant(name, "labelList", &counts, &|out| {
                labels(out, cells, is_binary)
            })?;
        }
        let boundary = patches.text(ordered.neighbour.len(), &ordered.patch_sizes);
        self.groups(mesh, &boundary)?;
        let mut zones = kept.unwrap_or_default();
        for (patch, faces) in patches.inside {
            zones.add_tag(&patches.list[patch].name, faces);
        }
        zones.write(self, &ordered.faces)
    }

    fn faces(&mut self, faces: &FaceList) -> Result<()> {
        if self.is_binary {
            return self.constant("faces", "faceCompactList", "", &|out| {
                labels(out, &faces.starts, true)?;
                labels(out, &faces.nodes, true)
            });
        }
        self.constant("faces", "faceList", "", &|out| {
            list(out, faces.len(), None, |face, buffer| {
                let nodes = faces.get(face);
                push_integer(buffer, nodes.len() as u64);
                let mut before = b'(';
                for node in nodes {
                    buffer.push(before);
                    push_integer(buffer, u64::from(*node));
                    before = b' ';
                }
                buffer.extend_from_slice(b")\n");
            })
        })
    }

    /// Writes patches, whose text is `boundary`, and zones of cells.
    fn groups(&mut self, mesh: &MeshView, boundary: &str) -> Result<()> {
        self.constant("boundary", "polyBoundaryMesh", "", &|out| {
            write_all(out, boundary.as_bytes())
        })?;
        write_cell_zones(mesh, self)
    }

    /// Writes a file of the mesh that all times share.
    pub fn constant(
        &mut self,
        name: &str,
        class: &str,
        note: &str,
        write: &dyn Fn(&mut dyn Write) -> Result<()>,
    ) -> Result<()> {
        let path = format!("{}/{name}", self.place.path.folder(CONSTANT));
        self.write(&path, class, note, &|out, _| write(out))
    }
}

/// Sizes of the patches where the faces keep their order; `None` if the faces of a tag do not follow one another.
fn sizes_of(mesh: &MeshView, patches: &Patches) -> Option<Vec<usize>> {
    let of_faces = &patches.of_cell[CellNumbers::of(mesh).len()..];
    let mut sizes = vec![0; patches.list.len()];
    of_faces
        .iter()
        .for_each(|&patch| sizes[patch as usize] += 1);
    of_faces.is_sorted().then_some(sizes)
}
