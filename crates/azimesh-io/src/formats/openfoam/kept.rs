//! Zones of faces and of points, which a mesh does not hold: read again from the files that it was read from, so that they
//! can be written where faces have another order, or where pieces are joined.

use super::faces;
use super::file::FoamFile;
use super::order::FaceList;
use super::topology::{StoredFile, Topology};
use super::zones::{self, Zone};
use crate::formats::names::Places;
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// Zones of the whole mesh.
#[derive(Default)]
pub(super) struct KeptZones {
    /// Points by their numbers.
    pub points: Vec<Zone>,
    /// Faces by their nodes.
    faces: Vec<FaceZone>,
}

/// A named list of faces.
struct FaceZone {
    name: String,
    /// Turned as the zone has them.
    faces: FaceList,
}

/// A zone of faces, by their numbers.
#[derive(Debug, PartialEq)]
pub(super) struct NumberedFaces {
    /// Its name.
    pub name: String,
    /// The faces, ascending.
    pub labels: Vec<u32>,
    /// Whether the zone has a face turned round.
    pub flips: Vec<bool>,
}

impl KeptZones {
    /// The zones in the files of a mesh, whole or in pieces.
    ///
    /// # Errors
    /// Where the files of these zones are not as they should be.
    pub fn of(origin: &Topology) -> Result<Self> {
        let mut kept = Self::default();
        let whole = [
            found(&origin.files, "faces", false)?,
            found(&origin.files, "faceZones", false)?,
            found(&origin.files, "pointZones", false)?,
        ];
        // Of zones of points, and of faces.
        let mut places = Default::default();
        kept.add(&whole, 0, &|node| node, &mut places)?;
        for folder in &origin.pieces {
            let is_collated = folder.is_collated;
            let files = [
                found(&folder.files, "faces", is_collated)?,
                found(&folder.files, "faceZones", is_collated)?,
                found(&folder.files, "pointZones", is_collated)?,
            ];
            for (i, piece) in folder.pieces.iter().enumerate() {
                let whole = |node: u32| piece.nodes.get(node as usize).copied().unwrap_or(node);
                kept.add(&files, i, &whole, &mut places)?;
            }
        }
        for zone in &mut kept.points {
            zone.labels.sort_unstable();
            zone.labels.dedup();
        }
        Ok(kept)
    }

    /// Adds the zones of a piece, whose nodes in the whole `whole` gives.
    fn add(
        &mut self,
        [faces, of_faces, of_points]: &[Vec<FoamFile>; 3],
        piece: usize,
        whole: &dyn Fn(u32) -> u32,
        places: &mut [Places<String>; 2],
    ) -> Result<()> {
        if let Some(file) = of_points.get(piece) {
            for zone in zones::zones(file, "pointLabels", MOST)? {
                let labels = zone.labels.iter().map(|node| whole(*node));
                let labels = labels.collect::<Vec<_>>();
                zones::of_name(&zone.name, &mut self.points, &mut places[0]).extend(labels);
            }
        }
        let (Some(file), Some(faces)) = (of_faces.get(piece), faces.get(piece)) else {
            return Ok(());
        };
        let zones = zones::zones(file, "faceLabels", MOST)?;
        if zones.is_empty() {
            return Ok(());
        }
        let flips = zones::zones(file, "flipMap", MOST)?;
        let faces = faces::faces(faces)?;
        let faces = faces.view();
        for (zone, flips) in zones.into_iter().zip(flips) {
            let name = zone.name;
            let new = || FaceZone {
                name: name.clone(),
                faces: FaceList::default(),
            };
            let zones = &mut self.faces;
            let own = &mut places[1].entry(name.clone(), zones, new).faces;
            for (i, face) in zone.labels.iter().enumerate() {
                if *face as usize >= faces.len() {
                    continue;
                }
                let nodes = faces.get(*face as usize).iter();
                let mut nodes: Vec<u32> = nodes.map(|node| whole(node.get())).collect();
                if flips.labels.get(i) == Some(&1) {
                    nodes.reverse();
                }
                own.push(&nodes);
            }
        }
        Ok(())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.faces.is_empty()
    }

    /// The zones of faces, by the numbers that these have in a list.
    pub fn numbered(&self, list: &FaceList) -> Vec<NumberedFaces> {
        let mut places = BTreeMap::new();
        let all = self.faces.iter().flat_map(|zone| zone.faces.iter());
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
        let numbered = |zone: &FaceZone| {
            let found = zone.faces.iter().filter_map(|face| {
                let place = *places.get(&sorted(face))?;
                (place != u32::MAX).then(|| (place, !is_same(face, list.get(place as usize))))
            });
            let mut found: Vec<(u32, bool)> = found.collect();
            found.sort_unstable();
            // Two pieces have the faces between them.
            found.dedup_by_key(|(face, _)| *face);
            let (labels, flips) = found.into_iter().unzip();
            NumberedFaces {
                name: zone.name.clone(),
                labels,
                flips,
            }
        };
        self.faces.iter().map(numbered).collect()
    }
}

/// More labels than a zone of one value for all may have.
const MOST: usize = u32::MAX as usize / 64;

/// A file of this name, as the blocks of the pieces where it is collated; nothing where there is none.
fn found(files: &[StoredFile], name: &str, is_collated: bool) -> Result<Vec<FoamFile>> {
    let is_it = |file: &&StoredFile| file.name.strip_suffix(".gz").unwrap_or(&file.name) == name;
    let Some(file) = files.iter().find(is_it) else {
        return Ok(Vec::new());
    };
    let file = FoamFile::of(file.stored.clone())?;
    match is_collated {
        true => file.blocks(),
        false => Ok(vec![file]),
    }
}

fn sorted(face: &[u32]) -> Vec<u32> {
    let mut nodes = face.to_vec();
    nodes.sort_unstable();
    nodes
}

/// Whether two faces of the same nodes turn alike.
fn is_same(face: &[u32], other: &[u32]) -> bool {
    let n = face.len().min(other.len());
    let start = other.iter().position(|node| Some(node) == face.first());
    start.is_some_and(|start| n > 1 && other[(start + 1) % n] == face[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_a_zone_are_found_and_turned_as_it_has_them() {
        let mut faces = FaceList::default();
        for face in [&[4, 5, 6][..], &[2, 1, 0], &[6, 4, 5]] {
            faces.push(face);
        }
        let kept = KeptZones {
            faces: vec![FaceZone {
                name: "disk".to_owned(),
                faces,
            }],
            ..KeptZones::default()
        };
        let mut list = FaceList::default();
        for face in [&[7, 8, 9][..], &[0, 1, 2], &[5, 6, 4]] {
            list.push(face);
        }
        let expected = NumberedFaces {
            name: "disk".to_owned(),
            labels: vec![1, 2],
            flips: vec![true, false],
        };
        assert_eq!(kept.numbered(&list), [expected]);
    }
}
