//! Zones: named lists of cells, faces or points in `cellZones`, `faceZones` and `pointZones`.
//!
//! A mesh does not hold zones of faces and of points. They are read again from the files that it was read from, so that
//! they can be written where faces have another order, or where pieces are joined.

use super::boundary::zone_names;
use super::faces::{CellNumbers, FaceList};
use super::file::FoamFile;
use super::lists::{self, labels_at};
use super::output::{CaseFiles, flags, labels};
use super::text::Text;
use super::topology::{StoredFile, StoredPiece, Topology};
use crate::formats::names::{Places, decoded};
use crate::formats::records::write_all;
use crate::mesh::{Group, MeshView};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// More labels than a zone of one value for all may have.
const MOST: usize = u32::MAX as usize / 64;

/// A named list.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Zone {
    /// Its name.
    pub name: String,
    /// Cells, faces or points.
    pub labels: Vec<u32>,
    /// Of faces that are written: whether the zone has a face turned round.
    flips: Option<Vec<bool>>,
}

/// The labels of the zone of this name, which may be new.
pub(super) fn of_name<'z>(
    name: &str,
    zones: &'z mut Vec<Zone>,
    places: &mut Places<String>,
) -> &'z mut Vec<u32> {
    let new = || Zone {
        name: name.to_owned(),
        ..Zone::default()
    };
    &mut places.entry(name.to_owned(), zones, new).labels
}

/// The zones in a file, with the labels under `key`: `cellLabels`.
pub(super) fn zones(file: &FoamFile, key: &str, most: usize) -> Result<Vec<Zone>> {
    file.checked(zones_in(file, key, most))
}

fn zones_in(file: &FoamFile, key: &str, most: usize) -> Result<Vec<Zone>> {
    let mut text = file.text();
    if text.peek().is_some_and(|byte| byte.is_ascii_digit()) {
        text.integer("the number of zones")?;
    }
    text.expect(b'(', "before the zones")?;
    let mut zones = Vec::new();
    while !text.take(b')') {
        let name = decoded(text.word("the name of a zone")?).into_owned();
        text.expect(b'{', &format!("after the name of zone \"{name}\""))?;
        let mut labels = Vec::new();
        while !text.take(b'}') {
            labels = entry(&mut text, file, key, most)?.unwrap_or(labels);
        }
        zones.push(Zone {
            name,
            labels,
            flips: None,
        });
    }
    Ok(zones)
}

/// Passes an entry of a zone; returns its labels if it is the one that is wanted.
fn entry(text: &mut Text, file: &FoamFile, key: &str, most: usize) -> Result<Option<Vec<u32>>> {
    let is_wanted = text.word("an entry of a zone")? == key.as_bytes();
    let rest = text.rest().trim_ascii_start();
    if is_wanted || text.is_binary && rest.starts_with(b"List<") {
        let mut layout = file.header.layout;
        if rest.starts_with(b"List<bool>") {
            layout.labels = [1, 4];
        }
        let other = (!is_wanted).then_some(0);
        let index = |label: i64| u32::try_from(label).ok().or(other);
        let labels = labels_at(text, layout, most, &index)?;
        text.expect(b';', "after a list")?;
        return Ok(is_wanted.then_some(labels));
    }
    text.value()?;
    Ok(None)
}

/// The names of the zones in a file, or how many there are where it cannot be read: these zones are no part of a mesh.
pub(super) fn names(file: &FoamFile, key: &str) -> Vec<String> {
    match (zones(file, key, MOST), file.text().integer("a number")) {
        (Ok(zones), _) => zones.into_iter().map(|zone| zone.name).collect(),
        (_, Ok(n)) if n != 0 => vec![format!("{n} zones")],
        _ => Vec::new(),
    }
}

/// Zones of faces and of points of a whole mesh.
#[derive(Default)]
pub(super) struct KeptZones {
    points: Vec<Zone>,
    /// Zones of faces: names, and the nodes of each face in the order that the zone has.
    faces: Vec<(String, FaceList)>,
}

impl KeptZones {
    /// The zones in the files of a mesh, whole or in pieces.
    pub fn of(origin: &Topology) -> Result<Self> {
        let mut kept = Self::default();
        // Of zones of points, and of faces.
        let mut places = Default::default();
        kept.add(&origin.files, false, &[None], &mut places)?;
        for folder in &origin.pieces {
            let pieces: Vec<_> = folder.pieces.iter().map(Some).collect();
            kept.add(&folder.files, folder.is_collated, &pieces, &mut places)?;
        }
        for zone in &mut kept.points {
            zone.labels.sort_unstable();
            zone.labels.dedup();
        }
        Ok(kept)
    }

    /// Adds the zones in the files of a folder, which has the whole mesh (`None`) or pieces.
    fn add(
        &mut self,
        files: &[StoredFile],
        is_collated: bool,
        pieces: &[Option<&StoredPiece>],
        places: &mut [Places<String>; 2],
    ) -> Result<()> {
        let [faces, of_faces, of_points] =
            ["faces", "faceZones", "pointZones"].map(|name| found(files, name, is_collated));
        let (faces, of_faces, of_points) = (faces?, of_faces?, of_points?);
        for (i, piece) in pieces.iter().enumerate() {
            let whole = |node: u32| {
                let nodes = piece.map(|piece| piece.nodes.as_slice());
                let whole = nodes.and_then(|nodes| nodes.get(node as usize));
                whole.copied().unwrap_or(node)
            };
            if let Some(file) = of_points.get(i) {
                for zone in zones(file, "pointLabels", MOST)? {
                    let nodes = zone.labels.iter().map(|node| whole(*node));
                    of_name(&zone.name, &mut self.points, &mut places[0]).extend(nodes);
                }
            }
            if let (Some(file), Some(faces)) = (of_faces.get(i), faces.get(i)) {
                self.add_faces(file, faces, &whole, &mut places[1])?;
            }
        }
        Ok(())
    }

    /// Adds zones of faces of a piece, whose nodes in the whole `whole` gives.
    fn add_faces(
        &mut self,
        file: &FoamFile,
        faces: &FoamFile,
        whole: &dyn Fn(u32) -> u32,
        places: &mut Places<String>,
    ) -> Result<()> {
        let zones_of_faces = zones(file, "faceLabels", MOST)?;
        if zones_of_faces.is_empty() {
            return Ok(());
        }
        let flips = zones(file, "flipMap", MOST)?;
        let faces = lists::faces(faces)?;
        let faces = faces.view();
        for (zone, flips) in zones_of_faces.into_iter().zip(flips) {
            let new = || (zone.name.clone(), FaceList::default());
            let own = places.entry(zone.name.clone(), &mut self.faces, new);
            for (i, face) in zone.labels.iter().enumerate() {
                if *face as usize >= faces.len() {
                    continue;
                }
                let nodes = faces.get(*face as usize).iter();
                let mut nodes: Vec<u32> = nodes.map(|node| whole(node.get())).collect();
                if flips.labels.get(i) == Some(&1) {
                    nodes.reverse();
                }
                own.1.push(&nodes);
            }
        }
        Ok(())
    }

    /// Adds a zone of the faces of a tag.
    pub fn add_tag(&mut self, name: &str, faces: FaceList) {
        self.faces.push((name.to_owned(), faces));
    }

    /// Writes the zones, for faces in the order of a list.
    pub fn write(self, files: &mut CaseFiles, faces: &FaceList) -> Result<()> {
        write(files, "face", &self.numbered(faces))?;
        write(files, "point", &self.points)
    }

    /// The zones of faces, by the numbers that these have in a list.
    fn numbered(&self, list: &FaceList) -> Vec<Zone> {
        let mut places = BTreeMap::new();
        let all = self.faces.iter().flat_map(|(_, faces)| faces.iter());
        places.extend(all.map(|face| (sorted(face), u32::MAX)));
        let lowest: BTreeSet<u32> = places.keys().map(|face| face[0]).collect();
        let n = if places.is_empty() { 0 } else { list.len() };
        for face in 0..n {
            let nodes = list.get(face);
            let low = nodes.iter().min();
            if low.is_some_and(|node| lowest.contains(node))
                && let Some(place) = places.get_mut(&sorted(nodes))
            {
                *place = face as u32;
            }
        }
        let numbered = |(name, faces): &(String, FaceList)| {
            let found = faces.iter().filter_map(|face| {
                let place = *places.get(&sorted(face))?;
                (place != u32::MAX).then(|| (place, !is_same(face, list.get(place as usize))))
            });
            let mut found: Vec<(u32, bool)> = found.collect();
            found.sort_unstable();
            // Two pieces have the faces between them.
            found.dedup_by_key(|(face, _)| *face);
            let (labels, flips) = found.into_iter().unzip();
            Zone {
                name: name.clone(),
                labels,
                flips: Some(flips),
            }
        };
        self.faces.iter().map(numbered).collect()
    }
}

/// A file of this name, as the blocks of the pieces where it is collated; nothing where there is none.
fn found(files: &[StoredFile], name: &str, is_collated: bool) -> Result<Vec<FoamFile>> {
    let is_it = |file: &&StoredFile| file.name.strip_suffix(".gz").unwrap_or(&file.name) == name;
    let Some(file) = files.iter().find(is_it) else {
        return Ok(Vec::new());
    };
    let file = FoamFile::of(file.stored.clone())?;
    if is_collated {
        file.blocks()
    } else {
        Ok(vec![file])
    }
}

fn sorted(face: &[u32]) -> Vec<u32> {
    let mut nodes = face.to_vec();
    nodes.sort_unstable();
    nodes
}

/// Checks if two faces of the same nodes have one orientation.
fn is_same(face: &[u32], other: &[u32]) -> bool {
    let n = face.len().min(other.len());
    let start = other.iter().position(|node| Some(node) == face.first());
    start.is_some_and(|start| n > 1 && other[(start + 1) % n] == face[1])
}

/// Writes the zones of cells of a mesh.
pub(super) fn write_cell_zones(mesh: &MeshView, files: &mut CaseFiles) -> Result<()> {
    let zones: Vec<&Group> = mesh.zones().filter(|zone| !zone.cells.is_empty()).collect();
    let numbers = CellNumbers::of(mesh);
    let zones = zones.iter().zip(zone_names(&zones)).map(|(zone, name)| {
        let cells = zone.cells.iter().map(|cell| numbers.get(cell as u32));
        Zone {
            name,
            labels: cells.collect(),
            flips: None,
        }
    });
    write(files, "cell", &zones.collect::<Vec<_>>())
}

/// Writes zones of a kind: `cell`, `face` or `point`. A case without any has no such file.
fn write(files: &mut CaseFiles, kind: &str, zones: &[Zone]) -> Result<()> {
    if zones.is_empty() {
        return Ok(());
    }
    let is_binary = files.is_binary;
    files.constant(&format!("{kind}Zones"), "regIOobject", "", &|out| {
        write_all(out, format!("{}\n(\n", zones.len()).as_bytes())?;
        for zone in zones {
            let key = format!("{kind}Labels");
            let before = format!(
                "{}\n{{\n    type            {kind}Zone;\n    {key:<15} List<label> ",
                zone.name
            );
            write_all(out, before.as_bytes())?;
            labels(out, &zone.labels, is_binary)?;
            if let Some(flips) = &zone.flips {
                write_all(out, b";\n    flipMap         List<bool> ")?;
                flags(out, flips, is_binary)?;
            }
            write_all(out, b";\n}\n")?;
        }
        write_all(out, b")\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Source;
    use std::path::Path;

    #[test]
    fn flips_of_a_binary_zone_are_bytes() {
        let head = "FoamFile { format binary; class regIOobject; arch \"LSB;label=32;scalar=64\"; }\n1\n(\ndisk\n{\ntype faceZone;\n";
        let mut bytes = format!("{head}faceLabels List<label> 9\n(").into_bytes();
        bytes.extend((0..9_u32).flat_map(u32::to_le_bytes));
        bytes.extend(b");\nflipMap List<bool> 9\n(\0\x01\x01\0\0\0\x01\0\x01);\n}\n)\n");
        let file = Source::from_bytes(Path::new("faceZones"), bytes);
        let file = FoamFile::of(file).expect("a good file");
        let labels = |key: &str| zones(&file, key, MOST).expect("a zone")[0].labels.clone();
        assert_eq!(labels("faceLabels"), (0..9).collect::<Vec<_>>());
        assert_eq!(labels("flipMap"), [0, 1, 1, 0, 0, 0, 1, 0, 1]);
    }

    #[test]
    fn faces_of_a_zone_are_found_and_turned_as_it_has_them() {
        let mut faces = FaceList::default();
        for face in [&[4, 5, 6][..], &[2, 1, 0], &[6, 4, 5]] {
            faces.push(face);
        }
        let kept = KeptZones {
            faces: vec![("disk".to_owned(), faces)],
            ..KeptZones::default()
        };
        let mut list = FaceList::default();
        for face in [&[7, 8, 9][..], &[0, 1, 2], &[5, 6, 4]] {
            list.push(face);
        }
        let expected = Zone {
            name: "disk".to_owned(),
            labels: vec![1, 2],
            flips: Some(vec![true, false]),
        };
        assert_eq!(kept.numbered(&list), [expected]);
    }
}
