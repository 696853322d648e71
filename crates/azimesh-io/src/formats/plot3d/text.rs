//! Files of text: numbers between white space, wherever lines end.

use super::super::tokens::Tokens;
use super::layout::{Fit, HEADERS, Layout, blocks_of, header, n_nodes};
use azimesh_core::error::{Error, Result};

/// The layouts whose counts fit the number of words of a text, and a sentence on why there may be none.
pub(super) fn fits(bytes: &[u8]) -> (Vec<Fit>, String) {
    let mut found = Vec::new();
    let mut needs = Vec::new();
    let n_words = Tokens::new(bytes).words().len();
    for (is_multi, n_axes) in HEADERS {
        let header = header((is_multi, n_axes), |at, n| counts(bytes, at, n));
        let Some((blocks, start)) = header else {
            continue;
        };
        let n_counts = blocks.len() * n_axes + usize::from(is_multi);
        let Some(n) = n_nodes(&blocks, n_words) else {
            let kind = blocks_of(is_multi);
            needs.push(format!("{kind}, {n_axes}D: more than the file has"));
            continue;
        };
        for has_blanking in [false, true] {
            let needed = n_counts + n * (n_axes + usize::from(has_blanking));
            let layout = Layout {
                binary: None,
                is_multi,
                n_axes,
                has_blanking,
            };
            if needed == n_words {
                let blocks = blocks.clone();
                found.push(Fit {
                    layout,
                    blocks,
                    start,
                });
            } else {
                needs.push(format!("{layout}: {needed}"));
            }
        }
    }
    let why = if found.is_empty() && memchr::memchr(b'*', bytes).is_some() {
        "numbers that stand for several, such as 3*0.0, are not read; write each of them".into()
    } else if needs.is_empty() {
        "this is no Plot3D grid: it does not begin with numbers of blocks and nodes".into()
    } else {
        let needs = needs.join("; ");
        format!(
            "the file has {n_words} numbers, which fits no layout of a Plot3D grid; needed are, {needs}"
        )
    };
    (found, why)
}

/// The next `n` words from a place on as counts, and the place after them.
fn counts(bytes: &[u8], at: usize, n: usize) -> Option<(Vec<i64>, usize)> {
    let mut words = Tokens::between(bytes, at..bytes.len());
    let next = |_| words.next_word()?.integer("a count").ok();
    let counts = (0..n).map(next).collect::<Option<Vec<i64>>>()?;
    Some((counts, words.position()))
}

/// The coordinates of all blocks, and whether nodes are blanked.
pub(super) fn points(bytes: &[u8], fit: &Fit) -> Result<(Vec<[f64; 3]>, bool)> {
    let tokens = Tokens::between(bytes, fit.start..bytes.len());
    let words = tokens.words();
    let mut numbers = vec![0.0; words.len()];
    words.parse_into(&mut numbers, "a coordinate", &mut [(); 0], |_, _, _| Ok(()))?;
    let n_axes = fit.layout.n_axes;
    let mut points = Vec::new();
    let mut is_blanked = false;
    let mut rest = &numbers[..];
    for block in &fit.blocks {
        let n: usize = block.iter().product();
        let n_all = n * (n_axes + usize::from(fit.layout.has_blanking));
        let (own, tail) = rest.split_at_checked(n_all).ok_or_else(|| {
            tokens.error_at_end(format!(
                "the file ends in a block that needs {n_all} numbers"
            ))
        })?;
        rest = tail;
        let axis = |axis: usize, i: usize| {
            if axis < n_axes {
                own[axis * n + i]
            } else {
                0.0
            }
        };
        points.extend((0..n).map(|i| [0, 1, 2].map(|k| axis(k, i))));
        is_blanked |= own[n_axes * n..].contains(&0.0);
    }
    if points.len() >= u32::MAX as usize {
        return Err(Error::input(crate::mesh::too_many("nodes")).line(1));
    }
    Ok((points, is_blanked))
}
