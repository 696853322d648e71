//! A mesh from the contents of a file: cells from their faces, tags from the zones on the boundary, zones of cells.

use super::content::{Content, FaceZone, NONE, OVERLAP, PARENT};
use super::join::{Joined, join, too_many_cells};
use crate::formats::Notes;
use crate::formats::by_faces::{self, Faces, Labels};
use crate::formats::notes::{listed, quoted};
use crate::mesh::sides::flat;
use crate::mesh::{CellKind, CellSet, Cells, Group, Mesh};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use azimesh_core::parallel::{collect, map_blocks};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Bit of an edge of a cell: the cell is to its right.
const REVERSED: u32 = 1 << 31;
const CELLS_OF_TASK: usize = 1 << 12;
/// Edges of a cell that are searched without sorting.
const FEW: usize = 16;

/// Makes the mesh of a file of these bytes.
pub(super) fn mesh(mut content: Content, bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    if content.n_cells == 0 {
        return Err(Error::input(if content.faces.is_empty() {
            "the file has no faces and no cells, so there is no mesh"
        } else {
            "the file has faces, but no cells: it is a surface mesh, and a mesh with cells is needed"
        }));
    }
    note_left_out(&content, notes);
    let mut joined = join(&mut content, bytes)?;
    notes.count(joined.n_loose, |n| {
        note!(
            "loose_faces",
            "faces on no cell of {} are not kept",
            counted(n, "face")
        )
    });
    let n_faces = joined.faces.len();
    if joined.n_cells > 2 * n_faces || n_faces >= 1 << 31 {
        return Err(too_many_cells(joined.n_cells, n_faces));
    }
    let tags = tags(&content, &joined);
    let both = twice(&joined, &tags);
    let mut cells = match content.dimension {
        2 => plane(&joined)?,
        _ => solid(&mut joined)?,
    };
    for nodes in both {
        cells.push(flat(nodes.len()), &nodes);
    }
    let mut groups = groups(tags, &joined, n_faces, content.dimension);
    groups.extend(zones(&content, &joined));
    Ok(Mesh {
        points: content.points,
        cells,
        groups,
        ..Mesh::default()
    })
}

/// The groups of the tags: faces on the boundary follow the cells, and tagged faces between cells follow those.
fn groups(tags: Vec<Tag>, joined: &Joined, n_faces: usize, dimension: u8) -> Vec<Group> {
    let (n_cells, n_inside) = (joined.n_cells, joined.n_inside);
    let mut first_twice = n_cells + n_faces - n_inside;
    let group = |tag: Tag| {
        let mut set = CellSet::new();
        for range in &tag.outside {
            let shift = |face: usize| n_cells + face - n_inside;
            set.push_range(shift(range.start)..shift(range.end));
        }
        for range in &tag.inside {
            set.push_range(first_twice..first_twice + range.len());
            first_twice += range.len();
        }
        Group {
            dimension: dimension - 1,
            cells: set,
            ..tag.group
        }
    };
    tags.into_iter().map(group).collect()
}

/// Cells of a solid mesh, then the faces on its boundary.
fn solid(joined: &mut Joined) -> Result<Cells> {
    let mut list = std::mem::take(&mut joined.faces);
    let n_inside = joined.n_inside;
    // On the boundary a face points into its cell, and is turned to point out of it.
    for face in n_inside..list.len() {
        let range = list.range(face);
        list.nodes[range][1..].reverse();
    }
    let cells = std::mem::take(&mut list.cells);
    let owner = collect(cells.len(), |face| {
        cells[face][usize::from(face < n_inside)]
    });
    let neighbour = collect(n_inside, |face| cells[face][0]);
    drop(cells);
    let mut starts = std::mem::take(&mut list.ends);
    if list.size == 0 {
        starts.insert(0, 0);
    }
    let size = (list.size > 0).then_some(list.size);
    let faces = Faces::of_size(size, Labels::from(starts), Labels::from(list.nodes));
    by_faces::assemble(&faces, &owner.into(), &neighbour.into(), joined.n_cells, 1)
}

/// Cells of a plane mesh from their edges, then the edges on the boundary.
fn plane(joined: &Joined) -> Result<Cells> {
    let (starts, edges) = edges_of_cells(joined);
    let blocks = map_blocks(joined.n_cells, CELLS_OF_TASK, &|range| {
        let (mut part, mut own) = (Cells::new(), Vec::new());
        for cell in range {
            own.clear();
            let found = &edges[starts[cell] as usize..starts[cell + 1] as usize];
            own.extend(found.iter().map(|edge| {
                let nodes = joined.faces.nodes((edge & !REVERSED) as usize);
                match edge & REVERSED {
                    0 => [nodes[0], nodes[1]],
                    _ => [nodes[1], nodes[0]],
                }
            }));
            push(&mut part, &mut own)
                .map_err(|why| Error::input(format!("cell {} {why}", cell + 1)))?;
        }
        Ok(part)
    });
    let mut cells = Cells::new();
    for block in blocks {
        cells.append(&block?);
    }
    let outside = 2 * joined.n_inside;
    cells.push_run(CellKind::Line, 2, &joined.faces.nodes[outside..]);
    Ok(cells)
}

/// Starts of the edges of each cell, and these edges.
fn edges_of_cells(joined: &Joined) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; joined.n_cells + 2];
    let sides = |edge: usize| {
        let [left, right] = joined.faces.cells[edge];
        let right = (edge < joined.n_inside).then_some((right, edge as u32 | REVERSED));
        std::iter::once((left, edge as u32)).chain(right)
    };
    let n = joined.faces.len();
    (0..n)
        .flat_map(sides)
        .for_each(|(cell, _)| starts[cell as usize + 2] += 1);
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut edges = vec![0; starts.last().map_or(0, |n| *n as usize)];
    for (cell, edge) in (0..n).flat_map(sides) {
        let end = &mut starts[cell as usize + 1];
        edges[*end as usize] = edge;
        *end += 1;
    }
    (starts, edges)
}

/// Appends the cell around which these edges go.
fn push(cells: &mut Cells, edges: &mut [[u32; 2]]) -> std::result::Result<(), String> {
    let n = edges.len();
    if n < 3 {
        return Err(format!(
            "has {}; it must have at least 3",
            counted(n, "edge")
        ));
    }
    let open = "has edges that do not go round it one after another";
    if n > FEW {
        edges[1..].sort_unstable();
    }
    let first = edges[0][0];
    let mut nodes = Vec::with_capacity(n);
    let mut at = edges[0];
    loop {
        nodes.push(at[0]);
        if at[1] == first {
            break;
        }
        let next = if n > FEW {
            let found = edges[1..].binary_search_by_key(&at[1], |edge| edge[0]);
            found.ok().map(|i| i + 1)
        } else {
            edges.iter().position(|edge| edge[0] == at[1])
        };
        match next {
            Some(next) if nodes.len() < n => at = edges[next],
            _ => return Err(open.to_owned()),
        }
    }
    if nodes.len() != n {
        return Err(open.to_owned());
    }
    cells.push(flat(n), &nodes);
    Ok(())
}

/// A tag with its faces.
struct Tag {
    group: Group,
    /// Faces on the boundary.
    outside: Vec<Range<usize>>,
    /// Faces between two cells.
    inside: Vec<Range<usize>>,
}

/// The tags, in the order of the file: zones with faces on the boundary, and zones between cells that are not interior.
fn tags(content: &Content, joined: &Joined) -> Vec<Tag> {
    let mut tags: Vec<Tag> = Vec::new();
    let mut places = BTreeMap::new();
    for (zone, [outside, inside]) in content.faces.iter().zip(&joined.zones) {
        let is_tagged = !inside.is_empty() && !content.is_interior(zone);
        if outside.is_empty() && !is_tagged {
            continue;
        }
        let at = *places.entry(zone.zone).or_insert_with(|| {
            tags.push(new_tag(content, zone));
            tags.len() - 1
        });
        let tag = &mut tags[at];
        tag.outside
            .extend((!outside.is_empty()).then(|| outside.clone()));
        tag.inside.extend(is_tagged.then(|| inside.clone()));
    }
    tags
}

fn new_tag(content: &Content, zone: &FaceZone) -> Tag {
    let kind = content.kind(zone);
    Tag {
        group: Group {
            dimension: 2,
            name: content.name(zone.zone, kind),
            number: Some(zone.zone as i32),
            condition: Some(kind.to_owned()),
            cells: CellSet::new(),
        },
        outside: Vec::new(),
        inside: Vec::new(),
    }
}

/// The nodes of tagged faces between two cells, in the order of the tags.
fn twice(joined: &Joined, tags: &[Tag]) -> Vec<Vec<u32>> {
    let faces = tags.iter().flat_map(|tag| &tag.inside).cloned().flatten();
    faces
        .map(|face| joined.faces.nodes(face).to_vec())
        .collect()
}

/// The zones of cells, in the order of the file.
fn zones(content: &Content, joined: &Joined) -> Vec<Group> {
    let mut ranges: BTreeMap<u32, Vec<Range<usize>>> = BTreeMap::new();
    let mut order = Vec::new();
    for zone in content.cells.iter().filter(|zone| zone.is_active) {
        let own = ranges.entry(zone.zone).or_insert_with(|| {
            order.push(zone.zone);
            Vec::new()
        });
        own.push(zone.cells.clone());
    }
    let group = |number: u32| {
        let mut own = ranges.remove(&number).unwrap_or_default();
        own.sort_by_key(|range| range.start);
        let kind = content.names.get(&number);
        let kind = kind.map_or("fluid", |named| &named.kind);
        Group {
            dimension: content.dimension,
            name: content.name(number, "fluid"),
            number: Some(number as i32),
            condition: (kind != "fluid").then(|| kind.to_owned()),
            cells: cells_of(own, joined),
        }
    };
    order.into_iter().map(group).collect()
}

/// The cells of a zone, by their new numbers.
fn cells_of(ranges: Vec<Range<usize>>, joined: &Joined) -> CellSet {
    let mut set = CellSet::new();
    let Some(numbers) = &joined.numbers else {
        ranges.into_iter().for_each(|range| set.push_range(range));
        return set;
    };
    let kept = ranges.into_iter().flatten().map(|cell| numbers[cell]);
    kept.filter(|cell| *cell != NONE)
        .for_each(|cell| set.push(cell as usize));
    set
}

/// Tests if a user named a zone between cells: Fluent has "interior" in such names, and writers of its files
/// call them "internal-3" by their numbers.
fn is_given(name: &str) -> bool {
    let number = name.strip_prefix("internal-").unwrap_or(name);
    !name.contains("interior") && !number.bytes().all(|byte| byte.is_ascii_digit())
}

/// Notes parts of the file that the mesh does not hold.
fn note_left_out(content: &Content, notes: &mut Notes) {
    let mut names = BTreeSet::new();
    let mut n_overlaps = 0;
    for zone in &content.faces {
        if zone.kind >= OVERLAP {
            n_overlaps += zone.list.len();
        } else if zone.kind != PARENT && content.is_interior(zone) {
            names.insert(content.name(zone.zone, "interior"));
        }
    }
    let named: Vec<String> = names.into_iter().filter(|name| is_given(name)).collect();
    notes.list(named, |names| {
        let names = listed(&quoted(&names));
        note!(
            "interior",
            "zones of faces inside of the mesh are not kept: {names}"
        )
    });
    if n_overlaps > 0 {
        notes.push(note!(
            "overlaps",
            "{} where the two sides of an interface overlap are left out: the faces of its sides are read",
            counted(n_overlaps, "face")
        ));
    }
    let refined = content.refined_cells.iter().map(Range::len);
    let inactive = content.cells.iter().filter(|zone| !zone.is_active);
    let n = usize::max(refined.sum(), inactive.map(|zone| zone.cells.len()).sum());
    if n > 0 || !content.refined_faces.is_empty() {
        notes.push(note!(
            "refined",
            "the mesh was refined with hanging nodes: {} and faces are left out, and the parts that stand for them are read; their \
             neighbours are polyhedra, or polygons",
            counted(n, "refined cell")
        ));
    }
    let of_mesh = content.faces.iter().filter(|zone| zone.kind < OVERLAP);
    let of_mesh: BTreeSet<u32> = of_mesh.map(|zone| zone.zone).collect();
    let pairs = content.shadows.iter();
    let pairs = pairs.filter(|pair| pair.iter().all(|zone| of_mesh.contains(zone)));
    let names = |[zone, shadow]: &[u32; 2]| {
        let zone = content.name(*zone, "periodic");
        format!(
            "\"{zone}\" and \"{}\"",
            content.name(*shadow, "periodic-shadow")
        )
    };
    notes.list(pairs.map(names).collect(), |pairs| {
        note!("periodic", "pairs of periodic zones: {}", listed(&pairs))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(edges: &[[u32; 2]]) -> std::result::Result<(CellKind, Vec<u32>), String> {
        let mut cells = Cells::new();
        push(&mut cells, &mut edges.to_vec())?;
        Ok((cells.get(0).kind, cells.get(0).nodes.to_vec()))
    }

    #[test]
    fn edges_in_any_order_make_a_cell() {
        assert_eq!(
            cell(&[[4, 7], [2, 4], [7, 2]]),
            Ok((CellKind::Triangle, vec![4, 7, 2]))
        );
        assert_eq!(
            cell(&[[1, 2], [5, 1], [2, 9], [9, 5]]),
            Ok((CellKind::Quadrilateral, vec![1, 2, 9, 5]))
        );
        let n = 40;
        let edges: Vec<[u32; 2]> = (0..n).map(|i| [i * 7 % n, (i * 7 + 1) % n]).collect();
        assert_eq!(cell(&edges), Ok((CellKind::Polygon, (0..n).collect())));
    }

    #[test]
    fn edges_that_close_no_cell_are_refused() {
        assert!(cell(&[[0, 1], [1, 0]]).is_err_and(|why| why.contains("2 edges")));
        for edges in [
            vec![[0, 1], [1, 2], [2, 3]],
            vec![[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]],
            vec![[0, 1], [2, 1], [2, 0]],
            vec![[0, 1], [1, 2], [2, 1]],
            (0..40).map(|i| [i, i + 1]).collect(),
        ] {
            assert!(
                cell(&edges).is_err_and(|why| why.contains("round")),
                "{edges:?}"
            );
        }
    }
}
