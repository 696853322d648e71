//! The faces of all zones as one list, those between two cells first, and the cells that they bound.

use super::content::{Content, FaceList, FaceZone, NONE};
use super::kinds::{OVERLAP, PARENT};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::parallel::any;
use std::ops::Range;

/// Faces of all zones. In 3D each points out of its owner; in 2D its owner is to its left.
#[derive(Default)]
pub(super) struct Joined {
    /// Faces between two cells, then those on the boundary.
    pub faces: FaceList,
    /// Number of faces between two cells.
    pub n_inside: usize,
    /// For each zone of the file, its faces: those on the boundary, and those between two cells.
    pub zones: Vec<[Range<usize>; 2]>,
    /// Number of faces that bound no cell.
    pub n_loose: usize,
    /// Number of cells.
    pub n_cells: usize,
    /// New numbers of cells, where some were left out: [`NONE`] for these.
    pub numbers: Option<Vec<u32>>,
}

/// What the faces of a zone are.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    /// All are between two cells.
    Inside,
    /// All are on the boundary.
    Outside,
    /// Some are left out, or of the other kind.
    Mixed,
}

/// Joins the zones; `bytes` are those of the file.
pub(super) fn join(content: &mut Content, bytes: &[u8]) -> Result<Joined> {
    check(content, bytes)?;
    let numbers = numbers(content)?;
    let n_cells = numbers.as_ref().map_or(content.n_cells, |numbers| {
        numbers.iter().filter(|number| **number != NONE).count()
    });
    let mut joined = Joined {
        zones: vec![[0..0, 0..0]; content.faces.len()],
        n_cells,
        ..Joined::default()
    };
    let kept = Kept {
        numbers: numbers.as_deref(),
        refined: merged(content.refined_faces.clone()),
    };
    let is_whole = numbers.is_none() && kept.refined.is_empty();
    let sides = content.faces.iter().map(|zone| match is_whole {
        true => side(&zone.list),
        false => Side::Mixed,
    });
    let sides: Vec<Side> = sides.collect();
    for (inside, wanted) in [(true, Side::Inside), (false, Side::Outside)] {
        for (i, zone) in content.faces.iter_mut().enumerate() {
            let first = joined.faces.len();
            if zone.kind == PARENT || zone.kind >= OVERLAP {
                continue;
            }
            if sides[i] == wanted {
                joined.take(&mut zone.list, wanted);
            } else if sides[i] == Side::Mixed {
                joined.take_some(zone, &kept, inside);
            }
            joined.zones[i][usize::from(inside)] = first..joined.faces.len();
        }
        if inside {
            joined.n_inside = joined.faces.len();
        }
    }
    joined.numbers = numbers;
    check_sizes(&joined.faces, content.dimension)?;
    Ok(joined)
}

/// Which faces are left out, and the numbers of cells.
struct Kept<'a> {
    /// New numbers of cells.
    numbers: Option<&'a [u32]>,
    /// Faces that were refined, ascending.
    refined: Vec<Range<usize>>,
}

impl Kept<'_> {
    /// The cells of a face; `None` where it is left out.
    fn cells(&self, zone: &FaceZone, face: usize) -> Option<[u32; 2]> {
        let own = zone.first + face;
        let at = self.refined.partition_point(|faces| faces.end <= own);
        if self.refined.get(at).is_some_and(|faces| faces.start <= own) {
            return None;
        }
        let cells = zone.list.cells[face];
        let both = cells.map(|cell| match self.numbers {
            Some(numbers) if cell != NONE => numbers[cell as usize],
            _ => cell,
        });
        let is_gone = (0..2).any(|k| cells[k] != NONE && both[k] == NONE);
        (!is_gone).then_some(both)
    }
}

/// The same items in ranges that ascend and are apart.
fn merged(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_by_key(|range| range.start);
    let mut merged: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match merged.last_mut() {
            Some(last) if last.end >= range.start => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
}

/// Checks that faces have enough nodes, and edges two.
fn check_sizes(faces: &FaceList, dimension: u8) -> Result<()> {
    let is_wrong = |size: usize| match dimension {
        2 => size != 2,
        _ => size < 3,
    };
    if faces.size != 0 && !is_wrong(faces.size) {
        return Ok(());
    }
    let Some(face) = (0..faces.len()).find(|face| is_wrong(faces.range(*face).len())) else {
        return Ok(());
    };
    let wanted = match dimension {
        2 => "in a plane mesh it has 2",
        _ => "it must have at least 3",
    };
    Err(Error::input(format!(
        "a face of cell {} has {}; {wanted}",
        faces.cells[face].iter().min().map_or(0, |cell| cell + 1),
        counted(faces.range(face).len(), "node")
    )))
}

impl Joined {
    /// Takes over all faces of a zone.
    fn take(&mut self, list: &mut FaceList, side: Side) {
        let mut list = std::mem::take(list);
        if side == Side::Outside {
            turn_out(&mut list);
        }
        let own = &mut self.faces;
        if own.cells.is_empty() {
            *own = list;
            return;
        }
        own.make_ends_unless(list.size);
        let before = own.nodes.len() as u32;
        if own.size == 0 {
            let ends = (0..list.len()).map(|face| before + list.range(face).end as u32);
            own.ends.extend(ends);
        }
        own.nodes.append(&mut list.nodes);
        own.cells.append(&mut list.cells);
    }

    /// Appends the faces of a zone that are between two cells, or those on the boundary.
    fn take_some(&mut self, zone: &FaceZone, kept: &Kept, inside: bool) {
        for face in 0..zone.list.len() {
            let Some(cells) = kept.cells(zone, face) else {
                continue;
            };
            match cells.iter().filter(|cell| **cell != NONE).count() {
                0 if inside => self.n_loose += 1,
                2 if inside => self.push(zone.list.nodes(face), cells),
                1 if !inside => self.push(zone.list.nodes(face), cells),
                _ => {}
            }
        }
    }

    /// Appends a face.
    fn push(&mut self, nodes: &[u32], cells: [u32; 2]) {
        let own = &mut self.faces;
        if own.cells.is_empty() {
            own.size = nodes.len();
        }
        own.make_ends_unless(nodes.len());
        let start = own.nodes.len();
        own.nodes.extend_from_slice(nodes);
        own.cells.push(cells);
        if own.size == 0 {
            own.ends.push(own.nodes.len() as u32);
        }
        if cells[0] == NONE || cells[1] == NONE {
            turn(
                &mut own.nodes[start..],
                own.cells.last_mut().expect("it was pushed"),
            );
        }
    }
}

impl FaceList {
    /// Lists the ends of faces, unless all have this size.
    fn make_ends_unless(&mut self, size: usize) {
        if self.size != 0 && self.size != size {
            self.ends = (1..=self.len())
                .map(|face| (face * self.size) as u32)
                .collect();
            self.size = 0;
        }
    }
}

/// Turns faces on the boundary so that their cell comes first: in 3D they point into it, in 2D it is on the left.
fn turn_out(list: &mut FaceList) {
    for face in 0..list.len() {
        let range = list.range(face);
        turn(&mut list.nodes[range], &mut list.cells[face]);
    }
}

fn turn(nodes: &mut [u32], cells: &mut [u32; 2]) {
    if cells[0] == NONE {
        cells.swap(0, 1);
        nodes.reverse();
    }
}

/// Which side all faces are of.
fn side(list: &FaceList) -> Side {
    let n_of = |face: usize| {
        list.cells[face]
            .iter()
            .filter(|cell| **cell != NONE)
            .count()
    };
    let is_all = |n: usize| list.len() > 0 && !any(list.len(), |face| n_of(face) != n);
    match list.len().checked_sub(1).map(n_of) {
        Some(2) if is_all(2) => Side::Inside,
        Some(1) if is_all(1) => Side::Outside,
        _ => Side::Mixed,
    }
}

/// Checks that nodes and cells of faces are there.
fn check(content: &Content, bytes: &[u8]) -> Result<()> {
    let (n_points, n_cells) = (content.points.len() as u32, content.n_cells as u32);
    let total: usize = content.faces.iter().map(|zone| zone.list.nodes.len()).sum();
    if total > u32::MAX as usize {
        return Err(Error::input(
            "the faces have more than 4294967295 nodes together, the most that are read",
        ));
    }
    if content.points.len() >= NONE as usize {
        return Err(Error::input(crate::mesh::too_many("nodes")));
    }
    for zone in &content.faces {
        let list = &zone.list;
        let is_wrong = |i: usize| list.nodes[i] >= n_points;
        if any(list.nodes.len(), is_wrong)
            && let Some(i) = (0..list.nodes.len()).find(|i| is_wrong(*i))
        {
            let face = (0..list.len()).find(|face| list.range(*face).contains(&i));
            let face = face.unwrap_or(0);
            let place = zone.place_of(bytes, face, i - list.range(face).start);
            return Err(place.error(format!(
                "face {} has node {}, but the mesh has {n_points} nodes, counted from 1",
                zone.first + face + 1,
                list.nodes[i].wrapping_add(1)
            )));
        }
        let is_wrong = |face: usize| {
            let [a, b] = list.cells[face];
            let is_beyond = |cell: u32| cell != NONE && cell >= n_cells;
            is_beyond(a) || is_beyond(b) || (a == b && a != NONE)
        };
        if any(list.len(), is_wrong)
            && let Some(face) = (0..list.len()).find(|face| is_wrong(*face))
        {
            let [a, b] = list.cells[face].map(|cell| cell.wrapping_add(1));
            let message = match a == b {
                true => format!("has cell {a} on both sides"),
                false => format!(
                    "has cells {a} and {b}, but the mesh has {n_cells} cells, counted from 1"
                ),
            };
            let place = zone.place_of(bytes, face, list.range(face).len());
            return Err(place.error(format!("face {} {message}", zone.first + face + 1)));
        }
    }
    Ok(())
}

/// New numbers of cells where refined ones are left out.
fn numbers(content: &Content) -> Result<Option<Vec<u32>>> {
    let inactive = content.cells.iter().filter(|zone| !zone.is_active);
    let inactive = inactive.map(|zone| zone.cells.clone());
    let gone: Vec<_> = inactive
        .chain(content.refined_cells.iter().cloned())
        .collect();
    if gone.is_empty() {
        return Ok(None);
    }
    let n_sides: usize = content.faces.iter().map(|zone| 2 * zone.list.len()).sum();
    if content.n_cells > n_sides {
        return Err(super::assemble::too_many_cells(
            content.n_cells,
            n_sides / 2,
        ));
    }
    let mut numbers = vec![0; content.n_cells];
    for cells in merged(gone) {
        let n = numbers.len();
        numbers[cells.start.min(n)..cells.end.min(n)].fill(NONE);
    }
    let active = numbers.iter_mut().filter(|number| **number != NONE);
    for (next, number) in (0..).zip(active) {
        *number = next;
    }
    Ok(Some(numbers))
}
