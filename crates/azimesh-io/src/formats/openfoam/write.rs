//! Writes the files of a polyMesh: those that the mesh was read from, byte for byte, as far as they fit, others from its
//! cells, tags and zones.

use super::boundary::Patches;
use super::folders::CONSTANT;
use super::kept::KeptZones;
use super::order::{CellNumbers, OrderedFaces};
use super::pieces::{self, Named};
use super::place::{Place, foam_file};
use super::points::{Header, entries, flags, is_binary, labels, vectors};
use super::topology::{StoredFile, Topology};
use crate::formats::records::{left_out, push_integer, write_all};
use crate::formats::{Notes, Out, OutputSet, WriteOptions};
use crate::mesh::{Group, MeshView};
use azimesh_core::diagnostic::formats::{GroupWritten, Written};
use azimesh_core::error::{Error, Result, option};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

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
    let place = Place::with(out.path(), mesh, options);
    let foam = foam_file(out.path());
    out.place_in(&place.case, &place.owned())?;
    let notes = topology(mesh, out, &place, options)?;
    points(mesh.points, out, &place, CONSTANT, options)?;
    if !place.case.join(&foam).exists() {
        out.in_folder(&place.case, &foam, |_| Ok(()))?;
    }
    Ok(notes)
}

/// Writes the points of a time.
pub(super) fn points(
    points: &[[f64; 3]],
    out: &mut OutputSet,
    place: &Place,
    time: &str,
    options: &WriteOptions,
) -> Result<()> {
    let location = place.folder(time);
    let named = Named {
        path: &format!("{location}/points"),
        class: "vectorField",
        location: &location,
        object: "points",
    };
    let binary = is_binary(options);
    pieces::write(out, place, &named, options, &|out, piece| match piece {
        None => vectors(out, points, binary),
        Some(piece) => vectors(out, &piece.of(points), binary),
    })
}

/// Writes all but the points.
pub(super) fn topology(
    mesh: &MeshView,
    out: &mut OutputSet,
    place: &Place,
    options: &WriteOptions,
) -> Result<Notes> {
    let mut notes = Notes::default();
    notes.extend(left_out("OpenFOAM", mesh, options, &[]));
    let lower = mesh.groups.iter().filter(|group| group.dimension < 2);
    let names: Vec<String> = lower.map(|group| group.name.clone()).collect();
    if !names.is_empty() {
        notes.push(GroupWritten::LowerLeftOut {
            format: "OpenFOAM",
            names,
        });
    }
    let origin = mesh.origin.get::<Topology>();
    let mut files = Files {
        out,
        place,
        options,
    };
    if let (Some(origin), false) = (origin, place.pieces.is_empty()) {
        files.of_pieces(origin)?;
        return Ok(notes);
    }
    let is_kept = |origin: &&Topology| !origin.files.is_empty() && origin.has_cells_of(mesh);
    if let Some(origin) = origin.filter(is_kept)
        && files.of_origin(mesh, origin, &mut notes)?
    {
        return Ok(notes);
    }
    if origin.is_some_and(|origin| !origin.pieces.is_empty()) && options.pieces.is_none() {
        notes.push(Written::AsOne);
    }
    files.of_cells(mesh, origin, &mut notes)?;
    Ok(notes)
}

/// The files of one mesh.
struct Files<'a, 'b> {
    out: &'a mut OutputSet<'b>,
    place: &'a Place<'a>,
    options: &'a WriteOptions,
}

/// The zones of faces and points of the mesh that was read, where it has the same cells still and they can be read.
fn kept_zones(mesh: &MeshView, origin: Option<&Topology>) -> Option<KeptZones> {
    let origin = origin.filter(|origin| origin.has_cells_of(mesh))?;
    KeptZones::of(origin).ok()
}

/// Name of a file without the ending of compression.
fn plain(name: &str) -> &str {
    name.strip_suffix(".gz").unwrap_or(name)
}

impl Files<'_, '_> {
    /// The files that the mesh was read from; patches and zones anew where those of the mesh are others. Writes nothing
    /// where the faces would need another order, which it tells.
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
        for file in &origin.files {
            let is_group = ["boundary", "cellZones"].contains(&plain(&file.name));
            if new.is_none() || !is_group {
                self.file(&file.name, |out| write_stored(out, file))?;
            }
        }
        let folder = self.place.folder(CONSTANT);
        self.further(&origin.case.join(&folder), &origin.files, &folder)?;
        if let Some(boundary) = new {
            self.boundary(&boundary)?;
            self.zones(mesh)?;
        }
        Ok(true)
    }

    /// The files of the pieces that the mesh was read from.
    fn of_pieces(&mut self, origin: &Topology) -> Result<()> {
        for (pieces, folder) in self.place.pieces.iter().zip(self.place.folders(CONSTANT)) {
            for file in &pieces.files {
                let path = format!("{folder}/{}", file.name);
                let write = |out: &mut dyn Out| write_stored(out, file);
                self.out.in_folder(&self.place.case, &path, write)?;
            }
            self.further(&origin.case.join(&folder), &pieces.files, &folder)?;
        }
        Ok(())
    }

    /// Copies the files of a folder that are none of the mesh, such as levels of refinement, to a folder in the case.
    fn further(&mut self, from: &Path, own: &[StoredFile], to: &str) -> Result<()> {
        for (name, path) in further_files(from, own) {
            let io = |error: io::Error| Error::io(&path, &error);
            let mut file = File::open(&path).map_err(io)?;
            let copy = |out: &mut dyn Out| io::copy(&mut file, out).map(|_| ()).map_err(io);
            let path = format!("{to}/{name}");
            self.out.in_folder(&self.place.case, &path, copy)?;
        }
        Ok(())
    }

    /// Files from cells, tags and zones.
    fn of_cells(
        &mut self,
        mesh: &MeshView,
        origin: Option<&Topology>,
        notes: &mut Notes,
    ) -> Result<()> {
        let patches = Patches::of(mesh, origin, notes)?;
        let sets = origin
            .into_iter()
            .flat_map(|origin| &origin.files)
            .map(|file| plain(&file.name));
        let kept = kept_zones(mesh, origin);
        let is_kept = |name: &&str| kept.is_some() && ZONES.contains(name);
        let sets: Vec<String> = sets
            .filter(|name| !WRITTEN.contains(name) && !is_kept(name))
            .map(str::to_owned)
            .collect();
        if !sets.is_empty() {
            notes.push(Written::FilesLeftOut { names: sets });
        }
        let n_patches = patches.list.len() - 1;
        let ordered = OrderedFaces::of(mesh, &patches.of_cell, n_patches)?;
        notes.extend(patches.notes_on_faces(mesh, &ordered.patch_sizes));
        if ordered.n_reversed > 0 {
            let n = ordered.n_reversed;
            notes.push(Written::TurnedRound { n });
        }
        let counts = format!(
            "nPoints:{}  nCells:{}  nFaces:{}  nInternalFaces:{}",
            mesh.points.len(),
            ordered.n_cells,
            ordered.faces.len(),
            ordered.neighbour.len()
        );
        self.faces(&ordered)?;
        self.labels("owner", &ordered.owner, &counts)?;
        self.labels("neighbour", &ordered.neighbour, &counts)?;
        self.boundary(&patches.text(ordered.neighbour.len(), &ordered.patch_sizes))?;
        self.zones(mesh)?;
        match kept {
            Some(kept) if !kept.is_empty() => self.kept_zones(&kept, &ordered),
            _ => Ok(()),
        }
    }

    /// Zones of faces and points.
    fn kept_zones(&mut self, kept: &KeptZones, ordered: &OrderedFaces) -> Result<()> {
        let binary = is_binary(self.options);
        let faces = kept.numbered(&ordered.faces);
        let list = |out: &mut dyn Write, key: &str, values: &[u32]| {
            write_all(out, format!("    {key:<15} List<label> ").as_bytes())?;
            labels(out, values, binary)?;
            write_all(out, b";\n")
        };
        if !faces.is_empty() {
            self.with_header("faceZones", "regIOobject", binary, None, |out| {
                write_all(out, format!("{}\n(\n", faces.len()).as_bytes())?;
                for zone in &faces {
                    let head = format!("{}\n{{\n    type            faceZone;\n", zone.name);
                    write_all(out, head.as_bytes())?;
                    list(out, "faceLabels", &zone.labels)?;
                    write_all(out, b"    flipMap         List<bool> ")?;
                    flags(out, &zone.flips, binary)?;
                    write_all(out, b";\n}\n")?;
                }
                write_all(out, b")\n")
            })?;
        }
        if !kept.points.is_empty() {
            self.with_header("pointZones", "regIOobject", binary, None, |out| {
                write_all(out, format!("{}\n(\n", kept.points.len()).as_bytes())?;
                for zone in &kept.points {
                    let head = format!("{}\n{{\n    type            pointZone;\n", zone.name);
                    write_all(out, head.as_bytes())?;
                    list(out, "pointLabels", &zone.labels)?;
                    write_all(out, b"}\n")?;
                }
                write_all(out, b")\n")
            })?;
        }
        Ok(())
    }

    fn faces(&mut self, ordered: &OrderedFaces) -> Result<()> {
        let faces = &ordered.faces;
        if is_binary(self.options) {
            return self.with_header("faces", "faceCompactList", true, None, |out| {
                labels(out, &faces.starts, true)?;
                labels(out, &faces.nodes, true)
            });
        }
        self.with_header("faces", "faceList", false, None, |out| {
            entries(out, faces.len(), &|face, buffer| {
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

    fn labels(&mut self, name: &str, values: &[u32], note: &str) -> Result<()> {
        let binary = is_binary(self.options);
        self.with_header(name, "labelList", binary, Some(note), |out| {
            labels(out, values, binary)
        })
    }

    fn boundary(&mut self, text: &str) -> Result<()> {
        self.with_header("boundary", "polyBoundaryMesh", false, None, |out| {
            write_all(out, text.as_bytes())
        })
    }

    /// Zones of cells. A case without any has no such file.
    fn zones(&mut self, mesh: &MeshView) -> Result<()> {
        let zones: Vec<&Group> = mesh.zones().filter(|zone| !zone.cells.is_empty()).collect();
        if zones.is_empty() {
            return Ok(());
        }
        let numbers = CellNumbers::of(mesh);
        let names = super::boundary::zone_names(&zones);
        let binary = is_binary(self.options);
        self.with_header("cellZones", "regIOobject", binary, None, |out| {
            write_all(out, format!("{}\n(\n", zones.len()).as_bytes())?;
            for (zone, name) in zones.iter().zip(&names) {
                let text = format!(
                    "{name}\n{{\n    type            cellZone;\n    cellLabels      List<label> "
                );
                write_all(out, text.as_bytes())?;
                let cells: Vec<u32> = zone
                    .cells
                    .iter()
                    .map(|cell| numbers.get(cell as u32))
                    .collect();
                labels(out, &cells, binary)?;
                write_all(out, b";\n}\n")?;
            }
            write_all(out, b")\n")
        })
    }

    fn with_header(
        &mut self,
        name: &str,
        class: &str,
        binary: bool,
        note: Option<&str>,
        write: impl FnOnce(&mut dyn Write) -> Result<()>,
    ) -> Result<()> {
        let location = self.place.folder(CONSTANT);
        let note = note.map(str::to_owned);
        let header = Header {
            class,
            location: &location,
            object: name,
            note,
        }
        .text(binary);
        self.file(name, |out| {
            write_all(out, header.as_bytes())?;
            write(out)
        })
    }

    fn file(&mut self, name: &str, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
        let path = format!("{}/{name}", self.place.folder(CONSTANT));
        self.out
            .in_folder(&self.place.case, &path, |out| write(out))
    }
}

/// Writes the bytes of a file that was read. The system refuses to write those of a mapped file beyond its end.
fn write_stored(out: &mut dyn Write, file: &StoredFile) -> Result<()> {
    let written = write_all(out, file.stored.bytes());
    written.map_err(|error| file.stored.check_whole().err().unwrap_or(error))
}

/// Files in the folder of a mesh that are neither points nor these of its own: their names and paths.
fn further_files(folder: &Path, own: &[StoredFile]) -> Vec<(String, PathBuf)> {
    let own = |name: &str| {
        let mut files = own.iter();
        plain(name) == "points" || files.any(|file| plain(&file.name) == plain(name))
    };
    let entries = fs::read_dir(folder).into_iter().flatten();
    let files = entries.flatten().filter(|entry| entry.path().is_file());
    let named =
        files.filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path())));
    let mut found: Vec<_> = named
        .filter(|(name, _)| !name.starts_with('.') && !own(name))
        .collect();
    found.sort();
    found
}

/// Sizes of the patches where the faces keep their order; `None` where those of a tag do not follow one another.
fn sizes_of(mesh: &MeshView, patches: &Patches) -> Option<Vec<usize>> {
    let of_faces = &patches.of_cell[CellNumbers::of(mesh).len()..];
    let mut sizes = vec![0; patches.list.len()];
    of_faces
        .iter()
        .for_each(|&patch| sizes[patch as usize] += 1);
    of_faces.is_sorted().then_some(sizes)
}
