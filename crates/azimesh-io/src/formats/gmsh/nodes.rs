//! `$Nodes`, `$ParametricNodes` and `$NOD` of every version.

use super::super::lexer::Fields;
use super::index::Index;
use super::stream::{Binary, Stream, Version};
use azimesh_core::diagnostic::point;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::for_blocks;
use std::ops::Range;

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
    /// Nodes whose tags count up from `first`, but for where they are.
    pub fn counting_up(first: i64, n: usize, n_parametric: usize) -> Self {
        let tags = || (0..n as i64).map(|i| first + i).collect();
        Self {
            points: Vec::new(),
            index: Index::Consecutive { first, n: n as u64 },
            numbers: (first != 1 && n > 0).then(tags),
            n_parametric,
        }
    }

    fn new(points: Vec<[f64; 3]>, tags: Vec<i64>, n_parametric: usize) -> Result<Self> {
        let index = Index::new(&tags, "node")?;
        let counts_up = matches!(index, Index::Consecutive { first: 1, .. }) || tags.is_empty();
        Ok(Self {
            points,
            index,
            numbers: (!counts_up).then_some(tags),
            n_parametric,
        })
    }
}

/// Reads the nodes of a section.
pub(super) fn read(stream: &mut Stream, version: Version, parametric: bool) -> Result<Nodes> {
    match (version, stream.binary) {
        (Version::V40 | Version::V41, _) => read_blocks(stream, version),
        (_, None) => read_list(stream, version, parametric),
        (Version::V3, Some(binary)) => read_with_entities(stream, binary, true),
        (_, Some(binary)) if parametric => read_with_entities(stream, binary, false),
        (_, Some(binary)) => read_binary_list(stream, binary),
    }
}

/// Nodes of version 4 come in blocks, one for each entity.
fn read_blocks(stream: &mut Stream, version: Version) -> Result<Nodes> {
    let (n_blocks, n_nodes) = block_counts(stream, version)?;
    let mut points = Vec::new();
    let mut tags = Vec::new();
    let mut n_parametric = 0;
    for _ in 0..n_blocks {
        let (n, n_parameters) = block_head(stream, version)?;
        match (stream.binary, version) {
            (Some(binary), Version::V41) => {
                let tag_bytes = stream.take(n, binary.size_bytes, "the node tags")?;
                let sizes = tag_bytes.chunks_exact(binary.size_bytes);
                tags.extend(sizes.map(|bytes| binary.size(bytes)));
                read_binary(stream, binary, n, [0, 8 * n_parameters], &mut points)?;
            }
            (Some(binary), _) => {
                let block = read_binary(stream, binary, n, [4, 8 * n_parameters], &mut points)?;
                let nodes = block.chunks_exact(28 + 8 * n_parameters);
                tags.extend(nodes.map(|node| i64::from(binary.int(&node[..4]))));
            }
            (None, Version::V41) => {
                read_tags(stream, n, &mut tags)?;
                read_coordinates(stream, n, n_parameters, &mut points)?;
            }
            (None, _) => read_lines(stream, n, n_parameters > 0, &mut tags, &mut points)?,
        }
        n_parametric += if n_parameters > 0 { n } else { 0 };
    }
    check_total(stream, points.len(), n_nodes)?;
    Nodes::new(points, tags, n_parametric).map_err(|error| at(stream, error))
}

/// Reads how many blocks and nodes there are.
pub(super) fn block_counts(stream: &mut Stream, version: Version) -> Result<(usize, usize)> {
    let n_blocks = stream.size("the number of node blocks")?;
    let n_nodes = stream.size("the number of nodes")?;
    if version == Version::V41 {
        stream.size("the lowest node tag")?;
        stream.size("the highest node tag")?;
    }
    Ok((n_blocks, n_nodes))
}

/// Reads how many nodes a block has, and how many parameters each of them.
pub(super) fn block_head(stream: &mut Stream, version: Version) -> Result<(usize, usize)> {
    let (dimension, _) = stream.entity(version)?;
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
    match found == said {
        true => Ok(()),
        false => Err(stream.error(format!(
            "the blocks hold {found} nodes, but $Nodes says {said}"
        ))),
    }
}

/// Reads a block of tags as text.
fn read_tags(stream: &mut Stream, n: usize, tags: &mut Vec<i64>) -> Result<()> {
    let what = "a node tag";
    if stream.has_long_line(1) {
        for _ in 0..n {
            tags.push(stream.word(what)?.integer(what)?);
        }
        return Ok(());
    }
    let lines = stream.lines(n, "the node tags")?;
    let known = tags.len();
    tags.resize(known + n, 0);
    lines.parse_into(&mut tags[known..], 1, |line, tag| {
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
            let mut point = [0.0; 3];
            for x in &mut point {
                *x = stream.real("a coordinate of a node")?;
            }
            for _ in 0..n_parameters {
                stream.real("a parameter of a node")?;
            }
            points.push(point);
        }
        return Ok(());
    }
    let lines = stream.lines(n, "the node coordinates")?;
    let known = points.len();
    points.resize(known + n, [0.0; 3]);
    lines.parse_into(&mut points[known..], 1, |line, point| {
        point[0] = coordinates_of(line)?;
        if n_parameters > 0 {
            return Ok(());
        }
        line.end("a node")
    })
}

/// Reads lines of a tag and three coordinates; parameters may follow where `more` is set.
fn read_lines(
    stream: &mut Stream,
    n: usize,
    more: bool,
    tags: &mut Vec<i64>,
    points: &mut Vec<[f64; 3]>,
) -> Result<()> {
    let lines = stream.lines(n, "the nodes")?;
    let mut nodes = vec![(0, [0.0; 3]); n];
    lines.parse_into(&mut nodes, 1, |line, node| {
        node[0].0 = line.integer("a node number")?;
        node[0].1 = coordinates_of(line)?;
        if more { Ok(()) } else { line.end("a node") }
    })?;
    tags.extend(nodes.iter().map(|node| node.0));
    points.extend(nodes.iter().map(|node| node.1));
    Ok(())
}

/// Nodes of versions 1 to 3 as text, one a line. Versions 1 and 3 and parametric nodes of version 2
/// may give the entity after the coordinates, by two numbers, and then parameters.
fn read_list(stream: &mut Stream, version: Version, parametric: bool) -> Result<Nodes> {
    let n = count(stream, "the number of nodes")?;
    let more = parametric || version != Version::V2;
    let (mut tags, mut points) = (Vec::new(), Vec::new());
    let start = stream.text.position();
    read_lines(stream, n, more, &mut tags, &mut points)?;
    let mut n_parametric = 0;
    if more {
        stream.text.set_position(start);
        let lines = stream.lines(n, "the nodes")?;
        let counts = lines.parse(|line, found: &mut usize| {
            let mut words = std::iter::from_fn(|| line.word());
            *found += usize::from(words.nth(6).is_some());
            Ok(())
        })?;
        n_parametric = counts.iter().sum();
    }
    Nodes::new(points, tags, n_parametric).map_err(|error| at(stream, error))
}

/// Binary nodes of version 2: a tag and three coordinates each.
fn read_binary_list(stream: &mut Stream, binary: Binary) -> Result<Nodes> {
    let n = count(stream, "the number of nodes")?;
    let mut points = Vec::new();
    let body = read_binary(stream, binary, n, [4, 0], &mut points)?;
    let tags = body.chunks_exact(28);
    let tags = tags.map(|node| i64::from(binary.int(&node[..4]))).collect();
    Nodes::new(points, tags, 0).map_err(|error| at(stream, error))
}

/// Binary nodes that say where they lie: tag, coordinates, dimension and tag of the entity, and its
/// parameters. Version 3 gives the tag first, and nothing after a tag of 0.
fn read_with_entities(stream: &mut Stream, binary: Binary, is_v3: bool) -> Result<Nodes> {
    let n = count(stream, "the number of nodes")?;
    let (mut tags, mut points) = (Vec::new(), Vec::new());
    let mut n_parametric = 0;
    for _ in 0..n {
        let node = read_binary(stream, binary, 1, [4, 0], &mut points)?;
        tags.push(i64::from(binary.int(&node[..4])));
        let first = stream.int("the entity of a node")?;
        if is_v3 && first == 0 {
            continue;
        }
        let second = stream.int("the entity of a node")?;
        let dimension = if is_v3 { second } else { first };
        let (n_parameters, each) = match dimension {
            1 => (1, 8),
            2 => (2, 8),
            // In a volume version 3 writes three zeros of 4 bytes.
            3 if is_v3 => (3, 4),
            _ => (0, 8),
        };
        stream.take(n_parameters, each, "the parameters of a node")?;
        n_parametric += usize::from(n_parameters > 0 && each == 8);
    }
    Nodes::new(points, tags, n_parametric).map_err(|error| at(stream, error))
}

/// The count that starts a section up to version 3, a line of text in binary files too.
pub(super) fn count(stream: &mut Stream, what: &str) -> Result<usize> {
    let line = stream.text.line();
    let mut line = line.ok_or_else(|| stream.error(format!("the file ends before {what}")))?;
    let n = line.narrow(what)?;
    line.end(what)?;
    Ok(n)
}

fn coordinates_of(line: &mut Fields) -> Result<[f64; 3]> {
    Ok([
        line.real("a node's x")?,
        line.real("a node's y")?,
        line.real("a node's z")?,
    ])
}

/// Reads `n` binary nodes with three coordinates each, and given numbers of bytes before and after
/// them; returns them all.
fn read_binary<'a>(
    stream: &mut Stream<'a>,
    binary: Binary,
    n: usize,
    [before, after]: [usize; 2],
    points: &mut Vec<[f64; 3]>,
) -> Result<&'a [u8]> {
    let each = before + 24 + after;
    let records = Records {
        binary,
        start: stream.text.position(),
        each,
        before,
        body: stream.take(n, each, "the nodes")?,
    };
    let known = points.len();
    points.resize(known + n, [0.0; 3]);
    records.points(0..n, &mut points[known..])?;
    Ok(records.body)
}

/// Binary nodes of one size.
pub(super) struct Records<'a> {
    pub binary: Binary,
    /// Offset in the file.
    pub start: usize,
    /// Bytes of a node.
    pub each: usize,
    /// Bytes of a node before its coordinates.
    pub before: usize,
    pub body: &'a [u8],
}

impl Records<'_> {
    /// The coordinates of some of the nodes, which must be finite.
    pub fn points(&self, nodes: Range<usize>, points: &mut [[f64; 3]]) -> Result<()> {
        let &Self {
            binary,
            each,
            before,
            ..
        } = self;
        for_blocks(points, CHUNK, &|first, points| {
            let records = self.body[(nodes.start + first) * each..].chunks_exact(each);
            for (point, node) in points.iter_mut().zip(records) {
                for (i, x) in point.iter_mut().enumerate() {
                    *x = binary.real(&node[before + 8 * i..before + 8 * i + 8]);
                }
            }
        });
        let finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
        match points.iter().position(|point| !finite(point)) {
            None => Ok(()),
            Some(i) => Err(Error::input(format!(
                "a node is at {}; coordinates must be finite",
                point(&points[i])
            ))
            .byte((self.start + (nodes.start + i) * each) as u64)),
        }
    }
}

/// An error about the section that was just read.
fn at(stream: &Stream, error: Error) -> Error {
    match stream.binary {
        Some(_) => error.byte(stream.text.position() as u64),
        None => error.line(super::super::lexer::line_of(
            stream.text.bytes(),
            stream.text.position(),
        )),
    }
}
