//! The faces of all zones as one list, those between two cells first, and the cells that they bound.

use super::content::{Content, FaceList, FaceZone, NONE, OVERLAP, PARENT};
use super::numbers::TOO_MANY_NODES;
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::parallel::any;
use std::ops::Range;

/// Faces of all zones. In 3D each points out of its owner; in 2D its owner is to its left.
#[derive(Default)]
pub(super) struct Joined {
    /// Faces between two cells, then those on the boundary.
    pub faces: FaceList,
    pub n_inside: usize,
    /// For each zone of the file, its faces on the boundary, and between two cells.
    pub zones: Vec<[Range<usize>; 2]>,
    /// Number of faces that bound no cell.
    pub n_loose: usize,
    pub n_cells: usize,
    /// New numbers of cells if some were left out: [`NONE`] for these.
    pub numbers: Option<Vec<u32>>,
}

/// Joins the zones; `bytes` are the file's.
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
    let sides = content
        .faces
        .iter()
        .map(|zone| all_inside(&zone.list).filter(|_| is_whole));
    let sides: Vec<Option<bool>> = sides.collect();
    for inside in [true, false] {
        for (i, zone) in content.faces.iter_mut().enumerate() {
            let first = joined.faces.len();
            if zone.kind == PARENT || zone.kind >= OVERLAP {
                continue;
            }
            match sides[i] {
                None => joined.take_some(zone, &kept, inside),
                Some(all) if all == inside => joined.take(&mut zone.list, inside),
                Some(_) => {}
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

/// Faces that are left out, and the numbers of cells.
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

/// The same items in ascending disjoint ranges.
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
    let is_plane = dimension == 2;
    let is_wrong = |size: usize| if is_plane { size != 2 } else { size < 3 };
    if faces.size != 0 && !is_wrong(faces.size) {
        return Ok(());
    }
    let Some(face) = (0..faces.len()).find(|face| is_wrong(faces.range(*face).len())) else {
        return Ok(());
    };
    let wanted = if is_plane {
        "in a plane mesh it has 2"
    } else {
        "it must have at least 3"
    };
    Err(Error::input(format!(
        "a face of cell {} has {}; {wanted}",
        faces.cells[face].iter().min().map_or(0, |cell| cell + 1),
        counted(faces.range(face).len(), "node")
    )))
}

impl Joined {
    /// Takes over all faces of a zone.
    fn take(&mut self, list: &mut FaceList, inside: bool) {
        let mut list = std::mem::take(list);
        for face in 0..if inside { 0 } else { list.len() } {
            let range = list.range(face);
            turn(&mut list.nodes[range], &mut list.cells[face]);
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
            match n_cells(&cells) {
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
        if let Some(cells) = own.cells.last_mut().filter(|cells| cells[0] == NONE) {
            turn(&mut own.nodes[start..], cells);
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

/// Turns a face on the boundary so that its cell comes first: in 3D it points into it, in 2D it is on the left.
fn turn(nodes: &mut [u32], cells: &mut [u32; 2]) {
    if cells[0] == NONE {
        cells.swap(0, 1);
        nodes.reverse();
    }
}

fn n_cells(cells: &[u32; 2]) -> usize {
    cells.iter().filter(|cell| **cell != NONE).count()
}

/// True if all faces are between two cells, false if all are on the boundary; `None` if they are mixed.
fn all_inside(list: &FaceList) -> Option<bool> {
    let n = n_cells(list.cells.first()?);
    let is_mixed = n == 0 || any(list.len(), |face| n_cells(&list.cells[face]) != n);
    (!is_mixed).then_some(n == 2)
}

/// Checks that nodes and cells of faces are there.
fn check(content: &Content, bytes: &[u8]) -> Result<()> {
    let (n_points, n_cells) = (content.points.len() as u32, content.n_cells as u32);
    let total: usize = content.faces.iter().map(|zone| zone.list.nodes.len()).sum();
    if total > u32::MAX as usize {
        return Err(Error::input(TOO_MANY_NODES));
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
            let node = list.nodes[i].wrapping_add(1);
            let message =
                format!("has node {node}, but the mesh has {n_points} nodes, counted from 1");
            return Err(zone.error(bytes, face, i - list.range(face).start, &message));
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
            let message = if a == b {
                format!("has cell {a} on both sides")
            } else {
                format!("has cells {a} and {b}, but the mesh has {n_cells} cells, counted from 1")
            };
            return Err(zone.error(bytes, face, list.range(face).len(), &message));
        }
    }
    Ok(())
}

/// Refuses more cells than faces can bound.
pub(super) fn too_many_cells(n_cells: usize, n_faces: usize) -> Error {
    Error::input(format!(
        "the file says that it has {n_cells} cells, too many for its {n_faces} faces"
    ))
}

/// New numbers of cells where refined ones are left out.
fn numbers(content: &Content) -> Result<Option<Vec<u32>>> {
    let inactive = content.cells.iter().filter(|zone| !zone.is_active);
    let inactive = inactive.map(|zone| &zone.cells);
    let gone: Vec<_> = inactive.chain(&content.refined_cells).cloned().collect();
    if gone.is_empty() {
        return Ok(None);
    }
    let n_sides: usize = content.faces.iter().map(|zone| 2 * zone.list.len()).sum();
    if content.n_cells > n_sides {
        return Err(too_many_cells(content.n_cells, n_sides / 2));
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
