//! `$Nodes` and `$ParametricNodes`, and the way from node tags to node indices.

use super::super::lexer::Fields;
use super::stream::{Binary, Stream};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// Records that one task converts at a time.
pub(super) const CHUNK: usize = 1 << 16;

/// Nodes in the order of the file.
#[derive(Debug)]
pub(super) struct Nodes {
    pub points: Vec<[f64; 3]>,
    pub index: NodeIndex,
}

/// Finds a node's index by its tag.
#[derive(Debug)]
pub(super) enum NodeIndex {
    /// Tags count up by one from `first`.
    Consecutive { first: i64, n: u64 },
    /// Tags with few gaps: the index of each from `first` on, `NONE` in a gap.
    Dense { first: i64, index: Vec<u32> },
    /// Tags far apart, ascending.
    Sparse(Vec<(i64, u32)>),
}

const NONE: u32 = u32::MAX;

impl NodeIndex {
    /// From the tags in order of index. Refuses a tag that is there twice. O(n), or O(n log n)
    /// where tags are far apart.
    pub fn new(tags: &[i64]) -> Result<Self> {
        let (Some(&first), Some(&lowest), Some(&highest)) =
            (tags.first(), tags.iter().min(), tags.iter().max())
        else {
            return Ok(Self::Consecutive { first: 0, n: 0 });
        };
        if tags.len() >= NONE as usize {
            return Err(Error::input(format!(
                "{} nodes, at most {} are possible",
                tags.len(),
                NONE - 1
            )));
        }
        let n = tags.len() as u64;
        if tags
            .windows(2)
            .all(|pair| pair[0].checked_add(1) == Some(pair[1]))
        {
            return Ok(Self::Consecutive { first, n });
        }
        let twice = |tag: i64| Error::input(format!("node {tag} is given twice"));
        let span = highest.wrapping_sub(lowest) as u64;
        if span <= 4 * n + 1024 {
            let mut index = vec![NONE; span as usize + 1];
            for (i, &tag) in tags.iter().enumerate() {
                let slot = &mut index[(tag - lowest) as usize];
                if *slot != NONE {
                    return Err(twice(tag));
                }
                *slot = i as u32;
            }
            return Ok(Self::Dense {
                first: lowest,
                index,
            });
        }
        let mut index: Vec<(i64, u32)> = tags.iter().copied().zip(0..).collect();
        index.sort_unstable();
        match index.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(twice(pair[0].0)),
            None => Ok(Self::Sparse(index)),
        }
    }

    /// The index of the node with this tag.
    #[inline]
    pub fn get(&self, tag: i64) -> Option<u32> {
        match self {
            Self::Consecutive { first, n } => {
                let i = tag.wrapping_sub(*first) as u64;
                (i < *n).then_some(i as u32)
            }
            Self::Dense { first, index } => {
                let i = tag.wrapping_sub(*first) as u64;
                index
                    .get(usize::try_from(i).ok()?)
                    .copied()
                    .filter(|i| *i != NONE)
            }
            Self::Sparse(index) => {
                let at = index.binary_search_by_key(&tag, |(tag, _)| *tag).ok()?;
                Some(index[at].1)
            }
        }
    }
}

/// Reads the nodes of version 4.1: blocks of tags, then coordinates.
pub(super) fn read41(stream: &mut Stream) -> Result<Nodes> {
    let n_blocks = stream.size("the number of node blocks")?;
    let n_nodes = stream.size("the number of nodes")?;
    stream.size("the lowest node tag")?;
    stream.size("the highest node tag")?;
    let mut points = Vec::new();
    let mut tags = Vec::new();
    for _ in 0..n_blocks {
        let dimension = stream.int("the dimension of an entity")?;
        stream.int("the tag of an entity")?;
        let parametric = stream.int("whether nodes are parametric")? != 0;
        let n = stream.size("the number of nodes in a block")?;
        if !(0..=3).contains(&dimension) {
            return Err(stream.error(format!(
                "a node block of dimension {dimension}; dimensions are 0 to 3"
            )));
        }
        let n_parameters = if parametric { dimension as usize } else { 0 };
        match stream.binary {
            Some(binary) => {
                let tag_bytes = stream.take(n, binary.size_bytes, "the node tags")?;
                let start = stream.text.position();
                let each = 8 * (3 + n_parameters);
                let coordinates = stream.take(n, each, "the node coordinates")?;
                let sizes = tag_bytes.chunks_exact(binary.size_bytes);
                tags.extend(sizes.map(|bytes| binary.size(bytes)));
                decode(binary, coordinates, each, start, &mut points)?;
            }
            None => {
                read_tags(stream, n, &mut tags)?;
                read_coordinates(stream, n, n_parameters, &mut points)?;
            }
        }
    }
    if points.len() != n_nodes {
        return Err(stream.error(format!(
            "the blocks hold {} nodes, but $Nodes promises {n_nodes}",
            points.len()
        )));
    }
    let index = NodeIndex::new(&tags).map_err(|error| at(stream, error))?;
    Ok(Nodes { points, index })
}

/// Reads a block of tags as text.
fn read_tags(stream: &mut Stream, n: usize, tags: &mut Vec<i64>) -> Result<()> {
    let what = "a node tag";
    if stream.crowded(1) {
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
    if stream.crowded(3 + n_parameters) {
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

/// Reads the nodes of version 2: a tag and three coordinates each; parametric ones have more after
/// them.
pub(super) fn read2(stream: &mut Stream, parametric: bool) -> Result<Nodes> {
    let n = count(stream, "the number of nodes")?;
    let mut points = Vec::new();
    let tags: Vec<i64> = match stream.binary {
        Some(binary) if parametric => read2_parametric(stream, binary, n, &mut points)?,
        Some(binary) => {
            let start = stream.text.position();
            let body = stream.take(n, 28, "the nodes")?;
            decode(binary, body, 28, start, &mut points)?;
            let tags = body.chunks_exact(28);
            tags.map(|node| i64::from(binary.int(&node[..4]))).collect()
        }
        None => {
            let lines = stream.lines(n, "$Nodes")?;
            let mut nodes = vec![(0, [0.0; 3]); n];
            lines.parse_into(&mut nodes, 1, |line, node| {
                node[0].0 = line.integer("a node number")?;
                node[0].1 = coordinates_of(line)?;
                if parametric {
                    Ok(())
                } else {
                    line.end("a node")
                }
            })?;
            points = nodes.iter().map(|node| node.1).collect();
            nodes.iter().map(|node| node.0).collect()
        }
    };
    let index = NodeIndex::new(&tags).map_err(|error| at(stream, error))?;
    Ok(Nodes { points, index })
}

/// Binary parametric nodes: tag, coordinates, dimension and tag of the entity, then as many
/// parameters as the entity has where it is a curve or a surface.
fn read2_parametric(
    stream: &mut Stream,
    binary: Binary,
    n: usize,
    points: &mut Vec<[f64; 3]>,
) -> Result<Vec<i64>> {
    let mut tags = Vec::new();
    for _ in 0..n {
        let start = stream.text.position();
        let node = stream.take(1, 36, "the parametric nodes")?;
        tags.push(i64::from(binary.int(&node[..4])));
        decode(binary, &node[..28], 28, start, points)?;
        let n_parameters = match binary.int(&node[28..32]) {
            1 => 1,
            2 => 2,
            _ => 0,
        };
        stream.take(n_parameters, 8, "the parameters of a node")?;
    }
    Ok(tags)
}

/// The count that starts a section of version 2, a line of text in binary files too.
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

/// Appends the coordinates of nodes of `each` bytes: three doubles that end at byte 28 where a tag
/// comes first, at byte 24 otherwise. `start` is the offset of `body` in the file.
fn decode(
    binary: Binary,
    body: &[u8],
    each: usize,
    start: usize,
    points: &mut Vec<[f64; 3]>,
) -> Result<()> {
    let skip = if each == 28 { 4 } else { 0 };
    let known = points.len();
    points.resize(known + body.len() / each, [0.0; 3]);
    points[known..]
        .par_chunks_mut(CHUNK)
        .zip(body.par_chunks(CHUNK * each))
        .for_each(|(points, body)| {
            for (point, node) in points.iter_mut().zip(body.chunks_exact(each)) {
                for (i, x) in point.iter_mut().enumerate() {
                    *x = binary.real(&node[skip + 8 * i..skip + 8 * i + 8]);
                }
            }
        });
    let finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
    match points[known..].iter().position(|point| !finite(point)) {
        None => Ok(()),
        Some(i) => Err(Error::input(format!(
            "a node at {:?}; coordinates must be finite numbers",
            points[known + i]
        ))
        .byte((start + i * each) as u64)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_found_whatever_their_order_and_gaps() {
        for tags in [vec![5, 6, 7], vec![9, 2, 4], vec![1, 1 << 40, -7], vec![]] {
            let index = NodeIndex::new(&tags).expect("no tag is there twice");
            for (i, tag) in tags.iter().enumerate() {
                assert_eq!(index.get(*tag), Some(i as u32));
            }
            for missing in [0, 3, 8, i64::MAX, i64::MIN] {
                assert_eq!(index.get(missing), None, "{missing} in {tags:?}");
            }
        }
    }

    #[test]
    fn a_tag_given_twice_is_refused() {
        assert!(NodeIndex::new(&[3, 1, 3]).is_err());
        assert!(NodeIndex::new(&[1 << 50, 1, 1 << 50]).is_err());
        assert!(NodeIndex::new(&[i64::MAX, i64::MIN]).is_ok());
    }
}
