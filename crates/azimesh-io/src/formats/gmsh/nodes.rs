//! `$Nodes`, `$ParametricNodes` and `$NOD` of every version.

use super::super::tokens::Tokens;
use super::index::Index;
use super::stream::{Binary, Stream, Version};
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::point;
use azimesh_core::parallel::for_blocks;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Records that one task converts at a time.
pub(super) const CHUNK: usize = 1 << 16;

/// Nodes in the order of the file.
#[derive(Debug)]
pub(super) struct Nodes {
    pub points: Vec<[f64; 3]>,
    pub index: Index,
    /// Their tags, unless they are 1, 2, 3 and so on.
    pub numbers: Option<Vec<i64>>,
    /// Nodes with parametric coordinates.
    pub n_parametric: usize,
}

impl Nodes {
    /// Nodes whose tags count up from `first`, without their coordinates.
    pub fn counting_up(first: i64, n: usize, n_parametric: usize) -> Self {
        let tags = || (0..n as i64).map(|i| first + i).collect();
        Self {
            points: Vec::new(),
            index: Index::Consecutive { first, n: n as u64 },
            numbers: (first != 1 && n > 0).then(tags),
            n_parametric,
        }
    }
}

/// Reads the nodes of a section. Version 4 has a block for each entity, versions 1 and 2 have one
/// block in all, which is as a block of version 4.0.
pub(super) fn read(stream: &mut Stream, parametric: bool) -> Result<Nodes> {
    let is_list = stream.version < Version::V40;
    let (n_blocks, n_nodes) = if is_list {
        (1, stream.count("the number of nodes")?)
    } else {
        stream.block_counts("node")?
    };
    let (mut points, mut tags, mut n_parametric) = (Vec::new(), Vec::new(), 0);
    for _ in 0..n_blocks {
        let (n, n_parameters) = if is_list {
            (n_nodes, 0)
        } else {
            block_head(stream)?
        };
        n_parametric += if n_parameters > 0 { n } else { 0 };
        match (stream.binary, stream.version) {
            (Some(binary), _) if is_list && parametric => {
                for _ in 0..n {
                    Block::read(stream, binary, 1, 0)?.append_to(&mut tags, &mut points)?;
                    n_parametric += usize::from(pass_parameters(stream)?);
                }
            }
            (Some(binary), _) => {
                let block = Block::read(stream, binary, n, n_parameters)?;
                block.append_to(&mut tags, &mut points)?;
            }
            (None, Version::V41) => {
                read_tags(stream, n, &mut tags)?;
                read_coordinates(stream, n, n_parameters, &mut points)?;
            }
            (None, version) => {
                let more = parametric && is_list || version == Version::V1 || n_parameters > 0;
                let n_longer = read_lines(stream, n, more, &mut tags, &mut points)?;
                n_parametric += if is_list { n_longer } else { 0 };
            }
        }
    }
    check_total(stream, points.len(), n_nodes)?;
    let index = Index::new(&tags, "node").map_err(|error| stream.located(error))?;
    let counts_up = matches!(index, Index::Consecutive { first: 1, .. }) || tags.is_empty();
    Ok(Nodes {
        points,
        index,
        numbers: (!counts_up).then_some(tags),
        n_parametric,
    })
}

/// Reads how many nodes a block has, and how many parameters each of them.
pub(super) fn block_head(stream: &mut Stream) -> Result<(usize, usize)> {
    let (dimension, _) = stream.entity()?;
    let parametric = stream.int("whether nodes are parametric")? != 0;
    let n = stream.size("the number of nodes in a block")?;
    if !(0..=3).contains(&dimension) {
        return Err(stream.error(format!(
            "a block of nodes has dimension {dimension}; it must be 0 to 3"
        )));
    }
    Ok((n, if parametric { dimension as usize } else { 0 }))
}

/// Refuses blocks that do not have the nodes that their section says.
pub(super) fn check_total(stream: &Stream, found: usize, said: usize) -> Result<()> {
    if found == said {
        return Ok(());
    }
    Err(stream.error(format!(
        "the blocks hold {found} nodes, but $Nodes says {said}"
    )))
}

/// Reads a block of tags as text.
fn read_tags(stream: &mut Stream, n: usize, tags: &mut Vec<i64>) -> Result<()> {
    let what = "a node tag";
    let known = tags.len();
    if stream.has_long_line(1) {
        for _ in 0..n {
            tags.push(stream.word(what)?.integer(what)?);
        }
        return Ok(());
    }
    let lines = stream.text.take_lines(n, "the node tags")?;
    tags.resize(known + n, 0);
    lines.parse_into(&mut tags[known..], 1, |line, _, tag| {
        tag[0] = line.integer(what)?;
        line.end(what)
    })
}

/// Reads a block of coordinates as text, each followed by its parameters.
fn read_coordinates(
    stream: &mut Stream,
    n: usize,
    n_parameters: usize,
    points: &mut Vec<[f64; 3]>,
) -> Result<()> {
    if stream.has_long_line(3 + n_parameters) {
        for _ in 0..n {
            let mut next = || stream.real("a coordinate of a node");
            points.push([next()?, next()?, next()?]);
            for _ in 0..n_parameters {
                stream.real("a parameter of a node")?;
            }
        }
        return Ok(());
    }
    let lines = stream.text.take_lines(n, "the node coordinates")?;
    let known = points.len();
    points.resize(known + n, [0.0; 3]);
    lines.parse_into(&mut points[known..], 1, |line, _, point| {
        point[0] = coordinates_of(line)?;
        if n_parameters > 0 {
            return Ok(());
        }
        line.end("a node")
    })
}

/// Reads lines of a tag and three coordinates. With `more`, the entity by two numbers and then
/// parameters may follow: returns how many nodes have parameters.
fn read_lines(
    stream: &mut Stream,
    n: usize,
    more: bool,
    tags: &mut Vec<i64>,
    points: &mut Vec<[f64; 3]>,
) -> Result<usize> {
    let lines = stream.text.take_lines(n, "the nodes")?;
    let mut nodes = vec![(0, [0.0; 3]); n];
    let n_parametric = AtomicUsize::new(0);
    lines.parse_into(&mut nodes, 1, |line, _, node| {
        node[0] = (line.integer("a node number")?, coordinates_of(line)?);
        if !more {
            return line.end("a node");
        }
        if std::iter::from_fn(|| line.word()).nth(2).is_some() {
            n_parametric.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    })?;
    tags.extend(nodes.iter().map(|node| node.0));
    points.extend(nodes.iter().map(|node| node.1));
    Ok(n_parametric.into_inner())
}

fn coordinates_of(line: &mut Tokens) -> Result<[f64; 3]> {
    Ok([
        line.real("a node's x")?,
        line.real("a node's y")?,
        line.real("a node's z")?,
    ])
}

/// Passes the entity of a binary node of version 2 and the node's parameters; whether it has any.
fn pass_parameters(stream: &mut Stream) -> Result<bool> {
    let dimension = stream.int("the entity of a node")?;
    stream.int("the entity of a node")?;
    let n = if matches!(dimension, 1 | 2) {
        dimension as usize
    } else {
        0
    };
    stream.take(n, 8, "the parameters of a node")?;
    Ok(n > 0)
}

/// Binary nodes, as records of one size with three coordinates each.
pub(super) struct Block<'a> {
    binary: Binary,
    pub n: usize,
    /// Offset of the records in the file.
    start: usize,
    records: &'a [u8],
    record_bytes: usize,
    /// Bytes of a record before its coordinates.
    before: usize,
    /// The tags, each at the start of so many bytes: in version 4.1 on their own, else in the records.
    tags: (&'a [u8], usize),
    tag_bytes: usize,
}

impl<'a> Block<'a> {
    /// Finds the records and their tags.
    pub fn read(
        stream: &mut Stream<'a>,
        binary: Binary,
        n: usize,
        n_parameters: usize,
    ) -> Result<Self> {
        let (mut own_tags, mut tag_bytes, mut before) = (None, 4, 4);
        if stream.version == Version::V41 {
            (tag_bytes, before) = (binary.size_bytes, 0);
            own_tags = Some(stream.take(n, tag_bytes, "the node tags")?);
        }
        let record_bytes = before + 24 + 8 * n_parameters;
        let start = stream.text.position();
        let records = stream.take(n, record_bytes, "the nodes")?;
        Ok(Self {
            binary,
            n,
            start,
            records,
            record_bytes,
            before,
            tags: own_tags.map_or((records, record_bytes), |tags| (tags, tag_bytes)),
            tag_bytes,
        })
    }

    pub fn tag(&self, i: usize) -> i64 {
        let (tags, each) = self.tags;
        self.binary.size(&tags[i * each..][..self.tag_bytes])
    }

    fn append_to(&self, tags: &mut Vec<i64>, points: &mut Vec<[f64; 3]>) -> Result<()> {
        let known = points.len();
        points.resize(known + self.n, [0.0; 3]);
        self.points(0..self.n, &mut points[known..])?;
        tags.extend((0..self.n).map(|i| self.tag(i)));
        Ok(())
    }

    /// The coordinates of some of the nodes, which must be finite.
    pub fn points(&self, nodes: Range<usize>, points: &mut [[f64; 3]]) -> Result<()> {
        let (binary, record_bytes) = (self.binary, self.record_bytes);
        for_blocks(points, CHUNK, &|first, points| {
            let start = (nodes.start + first) * record_bytes;
            let records = self.records[start..].chunks_exact(record_bytes);
            for (point, node) in points.iter_mut().zip(records) {
                for (x, bytes) in point.iter_mut().zip(node[self.before..].chunks_exact(8)) {
                    *x = binary.real(bytes);
                }
            }
        });
        let is_odd = |point: &[f64; 3]| point.iter().any(|x| !x.is_finite());
        let Some(i) = points.iter().position(is_odd) else {
            return Ok(());
        };
        let at = point(&points[i]);
        let message = format!("a node is at {at}; coordinates must be finite");
        let place = self.start + (nodes.start + i) * record_bytes;
        Err(Error::input(message).byte(place as u64))
    }
}
