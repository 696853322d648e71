//! Numbers of a binary body: coordinates, and faces, in the byte order of the file.

use super::content::FaceList;
use super::scan::Scanner;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{for_blocks, map_items};

/// Faces, or nodes, that one task decodes.
const BLOCK: usize = 1 << 15;

/// How numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Storage {
    /// Whether the first byte of a number is its largest one.
    pub is_big_endian: bool,
    /// Whether coordinates have 64 bits.
    pub is_double: bool,
}

impl Storage {
    fn integer(self, bytes: [u8; 4]) -> u32 {
        match self.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        }
    }
}

/// Takes the next `n` records of `size` bytes.
fn take<'a>(scanner: &mut Scanner<'a>, n: usize, size: usize, what: &str) -> Result<&'a [u8]> {
    let rest = scanner.rest();
    let wanted = n.checked_mul(size).filter(|wanted| *wanted <= rest.len());
    let Some(wanted) = wanted else {
        return Err(scanner.error(format!(
            "the section says that it has {n} {what}s, but the file ends after {} bytes",
            rest.len()
        )));
    };
    scanner.at += wanted;
    Ok(&rest[..wanted])
}

/// The coordinates of `n` nodes.
pub(super) fn points(
    scanner: &mut Scanner,
    n: usize,
    dimension: usize,
    storage: Storage,
) -> Result<Vec<[f64; 3]>> {
    let width = if storage.is_double { 8 } else { 4 };
    let start = scanner.at;
    let bytes = take(scanner, n, dimension * width, "node")?;
    let mut points = vec![[0.0; 3]; n];
    for_blocks(&mut points, BLOCK, &|first, points| {
        let bytes = &bytes[first * dimension * width..];
        for (point, bytes) in points.iter_mut().zip(bytes.chunks_exact(dimension * width)) {
            for (x, bytes) in point.iter_mut().zip(bytes.chunks_exact(width)) {
                *x = real(bytes, storage);
            }
        }
    });
    let is_wrong = |point: &[f64; 3]| point.iter().any(|x| !x.is_finite());
    if azimesh_core::parallel::any(n, |i| is_wrong(&points[i]))
        && let Some(i) = points.iter().position(is_wrong)
    {
        let at = start + i * dimension * width;
        let message = format!("a coordinate is {:?}, which is no number", points[i]);
        return Err(Error::input(message).byte(at as u64));
    }
    Ok(points)
}

#[inline]
fn real(bytes: &[u8], storage: Storage) -> f64 {
    if let Ok(bytes) = bytes.try_into() {
        match storage.is_big_endian {
            true => f64::from_be_bytes(bytes),
            false => f64::from_le_bytes(bytes),
        }
    } else {
        let bytes = bytes.try_into().expect("numbers have four or eight bytes");
        f64::from(f32::from_bits(storage.integer(bytes)))
    }
}

/// `n` faces of `size` nodes each, or of several sizes, each with its size before it.
pub(super) fn faces(
    scanner: &mut Scanner,
    n: usize,
    size: usize,
    storage: Storage,
) -> Result<FaceList> {
    if size == 0 {
        return faces_of_any_size(scanner, n, storage);
    }
    let bytes = take(scanner, n, 4 * (size + 2), "face")?;
    let records = bytes.as_chunks::<4>().0;
    let mut list = FaceList {
        size,
        ends: Vec::new(),
        nodes: vec![0; n * size],
        cells: vec![[0; 2]; n],
    };
    let parts = list.nodes.chunks_mut(BLOCK * size);
    let parts = parts.zip(list.cells.chunks_mut(BLOCK));
    map_items(parts, &|i, (nodes, cells)| {
        let records = records[i * BLOCK * (size + 2)..].chunks_exact(size + 2);
        let faces = nodes.chunks_exact_mut(size).zip(cells);
        for (record, (nodes, cells)) in records.zip(faces) {
            decode(record, nodes, cells, storage);
        }
    });
    Ok(list)
}

/// A face from its nodes and two cells.
#[inline]
fn decode(record: &[[u8; 4]], nodes: &mut [u32], cells: &mut [u32; 2], storage: Storage) {
    let index = |bytes: [u8; 4]| storage.integer(bytes).wrapping_sub(1);
    let (of_nodes, of_cells) = record.split_at(nodes.len());
    for (node, bytes) in nodes.iter_mut().zip(of_nodes) {
        *node = index(*bytes);
    }
    *cells = [index(of_cells[0]), index(of_cells[1])];
}

/// Where the nodes of each of `n` faces end among all nodes, and how many words the faces have. Where a face ends tells where
/// the next one starts.
///
/// # Errors
/// The word where it fails, and why.
fn ends_of(
    words: &[[u8; 4]],
    n: usize,
    storage: Storage,
) -> std::result::Result<(Vec<u32>, usize), (usize, String)> {
    let mut ends = Vec::with_capacity(n);
    let (mut at, mut end) = (0_usize, 0_u32);
    for face in 0..n {
        let Some(count) = words.get(at).map(|bytes| storage.integer(*bytes)) else {
            return Err((at, format!("the file ends after {face} of {n} faces")));
        };
        let next = at.checked_add(count as usize + 3);
        let Some(next) = next.filter(|next| *next <= words.len()) else {
            let message = format!(
                "face {} of {n} has {count} nodes, beyond the end of the file",
                face + 1
            );
            return Err((at, message));
        };
        // There are fewer nodes than words, but of these there may be more than 32 bits count.
        let Some(next_end) = end.checked_add(count) else {
            let message =
                "the faces have more than 4294967295 nodes together, the most that are read";
            return Err((at, message.to_owned()));
        };
        end = next_end;
        ends.push(end);
        at = next;
    }
    Ok((ends, at))
}

fn faces_of_any_size(scanner: &mut Scanner, n: usize, storage: Storage) -> Result<FaceList> {
    let words = scanner.rest().as_chunks::<4>().0;
    if n.saturating_mul(3) > words.len() {
        // Tells how many bytes there are.
        take(scanner, n, 12, "face")?;
    }
    let (ends, n_words) = match ends_of(words, n, storage) {
        Ok(found) => found,
        Err((word, message)) => {
            scanner.at += 4 * word;
            return Err(scanner.error(message));
        }
    };
    scanner.at += 4 * n_words;
    let end = ends.last().copied().unwrap_or(0);
    let mut nodes = vec![0; end as usize];
    let mut cells = vec![[0; 2]; n];
    let mut rest = &mut nodes[..];
    let mut tasks = Vec::with_capacity(n.div_ceil(BLOCK));
    let mut before = 0;
    for (ends, cells) in ends.chunks(BLOCK).zip(cells.chunks_mut(BLOCK)) {
        let last = ends.last().copied().unwrap_or(before);
        let (own, tail) = rest.split_at_mut((last - before) as usize);
        tasks.push((before, ends, own, cells));
        (rest, before) = (tail, last);
    }
    map_items(tasks, &|i, (first, ends, nodes, cells)| {
        // Before each face are its nodes, its size and two cells.
        let mut at = first as usize + 3 * i * BLOCK;
        let mut start = first;
        for (end, cells) in ends.iter().zip(cells) {
            let own = (start - first) as usize..(end - first) as usize;
            let record = &words[at + 1..at + 3 + own.len()];
            at += own.len() + 3;
            decode(record, &mut nodes[own], cells, storage);
            start = *end;
        }
    });
    Ok(FaceList {
        size: 0,
        ends,
        nodes,
        cells,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LITTLE: Storage = Storage {
        is_big_endian: false,
        is_double: true,
    };

    fn bytes(numbers: &[u32]) -> Vec<u8> {
        numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
    }

    #[test]
    fn faces_of_several_sizes_are_those_of_one_size_each() {
        let n = BLOCK + 7;
        let (mut mixed, mut expected) = (Vec::new(), FaceList::default());
        for face in 0..n as u32 {
            let nodes: Vec<u32> = (0..3 + face % 3).map(|i| 1 + face + i).collect();
            mixed.push(nodes.len() as u32);
            mixed.extend(&nodes);
            mixed.extend([face, face + 1]);
            expected.nodes.extend(nodes.iter().map(|node| node - 1));
            expected.ends.push(expected.nodes.len() as u32);
            expected.cells.push([face.wrapping_sub(1), face]);
        }
        let mixed = bytes(&mixed);
        let mut scanner = Scanner::new(&mixed);
        let list = faces(&mut scanner, n, 0, LITTLE).expect("they are whole");
        assert_eq!((list, scanner.at), (expected, mixed.len()));
        let error = faces(&mut Scanner::new(&mixed[..400]), n, 0, LITTLE).expect_err("cut off");
        assert!(error.to_string().contains("says that it has"), "{error}");
        let error = faces(
            &mut Scanner::new(&bytes(&[3, 1, 2, 3, 1, 0, 9, 1, 1, 1, 1])),
            2,
            0,
            LITTLE,
        );
        let error = error.expect_err("cut off").to_string();
        assert!(error.contains("face 2 of 2 has 9 nodes"), "{error}");
    }

    #[test]
    fn either_byte_order_and_width_gives_the_same_numbers() {
        let big = Storage {
            is_big_endian: true,
            is_double: false,
        };
        let coordinates = [0.5_f32, -2.0, 3.25, 8.0];
        let stored: Vec<u8> = coordinates.iter().flat_map(|x| x.to_be_bytes()).collect();
        let read = points(&mut Scanner::new(&stored), 2, 2, big).expect("two nodes");
        assert_eq!(read, [[0.5, -2.0, 0.0], [3.25, 8.0, 0.0]]);
        let stored: Vec<u8> = [1_u32, 2, 3, 7, 0]
            .iter()
            .flat_map(|n| n.to_be_bytes())
            .collect();
        let list = faces(&mut Scanner::new(&stored), 1, 3, big).expect("a face");
        assert_eq!(
            (list.nodes, list.cells),
            (vec![0, 1, 2], vec![[6, u32::MAX]])
        );
        let wrong: Vec<u8> = [1.0, f64::NAN]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let error = points(&mut Scanner::new(&wrong), 1, 2, LITTLE).expect_err("no number");
        assert!(error.to_string().contains("which is no number"), "{error}");
    }
}
