//! VTK's cells that a mesh does not have: collections are split, empty cells left out.
//!
//! A poly-vertex becomes vertices, a polyline lines, a triangle strip triangles; pixels and voxels
//! are quadrilaterals and hexahedra in another order.

use crate::formats::Notes;
use crate::mesh::CellKind;
use azimesh_core::note;
use azimesh_core::numbers::with_verb;

/// Consecutive cells of one VTK type and one number of nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TypeRun {
    /// VTK's cell type.
    pub vtk: u8,
    /// Nodes of each cell.
    pub n_nodes: u32,
    /// Number of cells.
    pub n_cells: u32,
}

const EMPTY: u8 = 0;
const POLY_VERTEX: u8 = 2;
const POLYLINE: u8 = 4;
const STRIP: u8 = 6;
/// VTK's type of a quadrilateral whose last two nodes are the other way round.
pub const PIXEL: u8 = 8;
/// VTK's type of a hexahedron made like two pixels.
pub const VOXEL: u8 = 11;

/// The kind of a VTK type that is one cell.
pub fn kind(vtk: u8) -> Option<CellKind> {
    match vtk {
        PIXEL => Some(CellKind::Quadrilateral),
        VOXEL => Some(CellKind::Hexahedron),
        _ => CellKind::from_vtk(vtk),
    }
}

/// The name of a type in messages.
pub fn type_name(vtk: u8) -> &'static str {
    match vtk {
        EMPTY => "empty cell",
        POLY_VERTEX => "poly-vertex",
        POLYLINE => "polyline",
        STRIP => "triangle strip",
        PIXEL => "pixel",
        VOXEL => "voxel",
        _ => CellKind::from_vtk(vtk).map_or("cell of another type", CellKind::name),
    }
}

/// Returns whether a cell of this type stands for any number of cells.
pub fn is_collection(vtk: u8) -> bool {
    matches!(vtk, EMPTY | POLY_VERTEX | POLYLINE | STRIP)
}

/// VTK's type of a cell in one of the lists of polygonal data: vertices, lines, polygons, strips.
pub fn polygonal(list: usize, n_nodes: usize) -> u8 {
    match (list, n_nodes) {
        (0, _) => POLY_VERTEX,
        (1, _) => POLYLINE,
        (2, 3) => CellKind::Triangle.vtk(),
        (2, 4) => CellKind::Quadrilateral.vtk(),
        (2, _) => CellKind::Polygon.vtk(),
        _ => STRIP,
    }
}

/// The kind of the cells in a collection, and nodes of the first that further ones share.
fn parts(vtk: u8) -> Option<(CellKind, u32)> {
    match vtk {
        POLY_VERTEX => Some((CellKind::Vertex, 0)),
        POLYLINE => Some((CellKind::Line, 1)),
        STRIP => Some((CellKind::Triangle, 2)),
        _ => None,
    }
}

/// Puts single cells in the place of collections; for each cell its index before, unless all stay.
pub fn split(
    connectivity: &mut Vec<u32>,
    runs: &mut Vec<TypeRun>,
    notes: &mut Notes,
) -> Option<Vec<usize>> {
    if !runs.iter().any(|run| is_collection(run.vtk)) {
        return None;
    }
    const COLLECTIONS: [u8; 3] = [POLY_VERTEX, POLYLINE, STRIP];
    // Collections of each type that are several cells, and those cells.
    let mut counts = [(0, 0); 3];
    let (mut n_empty, mut with_nodes) = (0, false);
    let mut new = Vec::with_capacity(connectivity.len());
    let mut new_runs: Vec<TypeRun> = Vec::with_capacity(runs.len());
    let mut origin = Vec::new();
    let mut rest = &connectivity[..];
    let mut cell = 0;
    for run in runs.iter() {
        let n_nodes = run.n_nodes as usize;
        let (entries, tail) = rest.split_at(n_nodes * run.n_cells as usize);
        rest = tail;
        let cells = cell..cell + run.n_cells as usize;
        cell = cells.end;
        if !is_collection(run.vtk) {
            new.extend_from_slice(entries);
            new_runs.push(*run);
            origin.extend(cells);
            continue;
        }
        let n = u64::from(run.n_cells);
        if let Some((kind, shared)) = parts(run.vtk) {
            let each = run.n_nodes.saturating_sub(shared);
            n_empty += if each == 0 { n } else { 0 };
            for (count, vtk) in counts.iter_mut().zip(COLLECTIONS) {
                if vtk == run.vtk && each > 1 {
                    *count = (count.0 + n, count.1 + n * u64::from(each));
                }
            }
            for (index, nodes) in cells.zip(entries.chunks(n_nodes.max(1))) {
                push_parts(kind, nodes, &mut new);
                origin.extend(std::iter::repeat_n(index, each as usize));
            }
            new_runs.push(TypeRun {
                vtk: kind.vtk(),
                n_nodes: shared + 1,
                n_cells: each * run.n_cells,
            });
        } else {
            n_empty += n;
            with_nodes |= run.n_nodes > 0;
        }
    }
    for (vtk, (n, n_into)) in COLLECTIONS.into_iter().zip(counts) {
        // The plural of a vertex is not regular.
        let plural = |kind: &str| kind.replace("vertex", "vertice") + "s";
        let into = plural(parts(vtk).map_or("", |(kind, _)| kind.name()));
        let from = match (type_name(vtk), n) {
            (_, 0) => continue,
            (from, 1) => format!("1 {from} is"),
            (from, n) => format!("{n} {} are", plural(from)),
        };
        notes.push(note!("split", "{from} split into {n_into} {into}"));
    }
    if n_empty > 0 {
        notes.push(note!(
            "empty_cells",
            "{} left out{}",
            with_verb(n_empty as usize, "empty cell", "is"),
            if with_nodes {
                ", with the nodes they list"
            } else {
                ""
            }
        ));
    }
    new_runs.retain(|run| run.n_cells > 0);
    *connectivity = new;
    *runs = new_runs;
    // Collections of one cell each change nothing.
    let same = origin.len() == cell && origin.iter().enumerate().all(|(i, at)| i == *at);
    (!same).then_some(origin)
}

fn push_parts(kind: CellKind, nodes: &[u32], out: &mut Vec<u32>) {
    match kind {
        CellKind::Vertex => out.extend_from_slice(nodes),
        CellKind::Line => nodes.windows(2).for_each(|line| out.extend(line)),
        _ => {
            for (i, triangle) in nodes.windows(3).enumerate() {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
                // Every other triangle of a strip runs the other way round.
                out.extend(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
    }
}
