//! Blocks of polygons (NSIDED) and of polyhedra (NFACED), whose faces are in blocks of their own.

use super::super::netcdf::{File, Variable};
use super::blocks::{check_number, indices};
use crate::mesh::{CellKind, Cells, check_listed, turn_outward};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Polygons: their nodes one after the other, and how many each has.
pub(super) fn polygons(
    file: &File,
    place: usize,
    nodes: &Variable,
    n_nodes: usize,
    cells: &mut Cells,
) -> Result<()> {
    let name = format!("ebepecnt{place}");
    let lists = Lists::read(file, &name, indices(nodes, n_nodes, "node")?)?;
    let space = cells.check_space(lists.len());
    space.map_err(|e| nodes.refuse(e.message))?;
    for polygon in 0..lists.len() {
        cells.push(CellKind::Polygon, lists.face(polygon, &name)?);
    }
    Ok(())
}

/// Polyhedra: the numbers of their faces one after the other, and how many each has. Two cells share a face as it
/// is, so that the file does not say which way it turns.
pub(super) fn polyhedra(
    file: &File,
    place: usize,
    numbers: &Variable,
    (blocks, points): (&FaceBlocks, &[[f64; 3]]),
    cells: &mut Cells,
) -> Result<()> {
    let n_faces = blocks.last().map_or(0, |(faces, ..)| faces.end);
    let of_cells = indices(numbers, n_faces, "face")?;
    let of_cells = Lists::read(file, &format!("ebepecnt{place}"), of_cells)?;
    let space = cells.check_space(of_cells.len());
    space.map_err(|e| numbers.refuse(e.message))?;
    let list_of = |face: u32| {
        let block = blocks.partition_point(|(faces, ..)| faces.end <= face as usize);
        let (range, lists, name) = &blocks[block];
        (face as usize - range.start, lists, name)
    };
    let length = |face: &u32| {
        let (at, lists, _) = list_of(*face);
        lists.get(at).len()
    };
    let n_nodes = blocks.iter().map(|(_, lists, _)| lists.entries.len()).sum();
    let uses = &of_cells.entries;
    let listed = check_listed(uses.iter().map(length).sum(), uses.len(), n_nodes);
    listed.map_err(|e| numbers.refuse(e.message))?;
    let (mut sides, mut stream) = (Vec::new(), Vec::new());
    for cell in 0..of_cells.len() {
        sides.clear();
        for &face in of_cells.get(cell) {
            let (at, lists, name) = list_of(face);
            let nodes = lists.face(at, name)?;
            sides.push(nodes.to_vec());
        }
        turn_outward(&mut sides, points);
        stream.clear();
        stream.push(sides.len() as u32);
        for side in &sides {
            stream.push(side.len() as u32);
            stream.extend_from_slice(side);
        }
        let added = cells.push_polyhedron(&stream);
        added
            .map_err(|error| numbers.refuse(format!("element {}: {}", cell + 1, error.message)))?;
    }
    Ok(())
}

/// Blocks of faces: which of all faces they have, these, and the name of the variable of their sizes.
pub(super) type FaceBlocks = Vec<(Range<usize>, Lists, String)>;

/// Reads the blocks of faces, which all blocks of polyhedra share.
pub(super) fn face_blocks(file: &File, n_nodes: usize) -> Result<FaceBlocks> {
    let n = file.length("num_fa_blk")?.unwrap_or(0);
    check_number(n, "num_fa_blk", file)?;
    let mut blocks: FaceBlocks = Vec::new();
    let mut first = 0;
    for place in 1..=n {
        if file.length(&format!("num_fa_in_blk{place}"))? == Some(0) {
            continue;
        }
        let variable = file.need(&format!("fbconn{place}"))?;
        let nodes = indices(&variable, n_nodes, "node")?;
        let name = format!("fbepecnt{place}");
        let lists = match *variable.shape() {
            [n_faces, per_face] => Lists::equal(n_faces, per_face, nodes),
            _ => Lists::read(file, &name, nodes)?,
        };
        let end = first + lists.len();
        blocks.push((first..end, lists, name));
        first = end;
    }
    Ok(blocks)
}

/// Lists of nodes or faces, one after the other.
pub(super) struct Lists {
    starts: Vec<usize>,
    entries: Vec<u32>,
}

impl Lists {
    /// Lists whose lengths are in this variable.
    fn read(file: &File, lengths: &str, entries: Vec<u32>) -> Result<Self> {
        let lengths = file.need(lengths)?;
        let mut starts = vec![0];
        let mut end = 0usize;
        for length in lengths.integers()? {
            let length = usize::try_from(length).ok();
            let next = length.and_then(|length| end.checked_add(length));
            end = next.filter(|end| *end <= entries.len()).ok_or_else(|| {
                lengths.refuse(format!(
                    "value {} is not a length that fits the {} entries of its block",
                    starts.len() - 1,
                    entries.len()
                ))
            })?;
            starts.push(end);
        }
        if end != entries.len() {
            return Err(lengths.refuse(format!(
                "its lengths add up to {end}, but the block has {} entries",
                entries.len()
            )));
        }
        Ok(Self { starts, entries })
    }

    /// Lists of one length.
    fn equal(n: usize, length: usize, entries: Vec<u32>) -> Self {
        let starts = (0..=n).map(|i| i * length).collect();
        Self { starts, entries }
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn get(&self, i: usize) -> &[u32] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    /// The nodes of a face, which must have three.
    fn face(&self, i: usize, lengths: &str) -> Result<&[u32]> {
        let nodes = self.get(i);
        if nodes.len() < 3 {
            return Err(Error::input(format!(
                "polygon {} has {} nodes; it must have at least 3",
                i + 1,
                nodes.len()
            ))
            .dataset(lengths));
        }
        Ok(nodes)
    }
}
