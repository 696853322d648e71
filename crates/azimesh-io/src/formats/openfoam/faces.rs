//! Faces as lists of nodes: a `faceList` or a `faceCompactList`, binary or as text.

use super::ascii;
use super::file::FoamFile;
use super::lists::{Layout, Open, cut_off, ends, head, indices_at, needed, number, wrong_label};
use super::text::Text;
use crate::formats::by_faces::{Faces, Label, Labels, regular_size};
use azimesh_core::error::Result;
use azimesh_core::parallel::any;

/// The faces in a file: a `faceList`, or a `faceCompactList` (where each starts, then the nodes of all).
pub(super) fn faces(file: &FoamFile) -> Result<Faces> {
    let mut text = file.text();
    let layout = Layout::of(file);
    let faces = match file.header.class.as_str() {
        "faceCompactList" => compact_faces(&mut text, file, layout),
        _ if text.is_binary => binary_faces(&mut text, layout),
        _ => ascii_faces(&mut text),
    };
    file.checked(faces)
}

fn ascii_faces(text: &mut Text) -> Result<Faces> {
    let (n, open) = head(text)?;
    match open {
        Open::Nothing => Ok(Faces::default()),
        Open::Uniform => Err(text.error("all faces are the same; there must be a list of them")),
        Open::Values => ascii::faces(text, n),
    }
}

fn compact_faces(text: &mut Text, file: &FoamFile, layout: Layout) -> Result<Faces> {
    let place = text.at;
    // The second list settles the width of both.
    let mut whole = None;
    for width in layout.labels {
        let mut after = text.clone();
        let layout = Layout {
            labels: [width; 2],
            ..layout
        };
        let parsed = compact_lists(&mut after, file, layout);
        if parsed.is_ok() || whole.is_none() {
            let is_good = parsed.is_ok();
            whole = Some(parsed);
            if is_good {
                break;
            }
        }
        if !text.is_binary {
            break;
        }
    }
    let (starts, nodes) = whole.expect("there are two widths")?;
    let list = starts.view();
    let value = |label: Option<&Label>| label.map(|label| label.get());
    let fits = match (value(list.first()), value(list.last())) {
        (Some(0), Some(last)) => last as usize == nodes.len(),
        (None, _) => nodes.is_empty(),
        _ => false,
    };
    let size = regular_size(list);
    let falls = |i: usize| list[i].get() > list[i + 1].get();
    let is_ascending = size.is_some() || !any(list.len().saturating_sub(1), falls);
    if !is_ascending || !fits {
        return Err(text.error_at(
            place,
            format!(
                "the faces start at {} places, which do not ascend from 0 to {}, the number of nodes in the list",
                starts.len(),
                nodes.len()
            ),
        ));
    }
    Ok(Faces::of_size(size, starts, nodes))
}

fn compact_lists(text: &mut Text, file: &FoamFile, layout: Layout) -> Result<(Labels, Labels)> {
    let index = |label: i64| u32::try_from(label).ok();
    let starts = indices_at(text, file, layout, 0, &index)?;
    if starts.is_empty() && text.peek().is_none() {
        return Ok((starts, Labels::default()));
    }
    let nodes = indices_at(text, file, layout, 0, &index)?;
    Ok((starts, nodes))
}

/// A binary `faceList`: each face is its number of nodes and a binary list.
fn binary_faces(text: &mut Text, layout: Layout) -> Result<Faces> {
    let (n, open) = head(text)?;
    match open {
        Open::Nothing => return Ok(Faces::default()),
        Open::Uniform => {
            return Err(text.error("all faces are the same; there must be a list of them"));
        }
        Open::Values => {}
    }
    let n = needed(text, n)?;
    let mut first_error = None;
    for width in layout.labels {
        let mut after = text.clone();
        let layout = Layout {
            labels: [width; 2],
            ..layout
        };
        match binary_faces_of(&mut after, n, layout) {
            Ok(faces) => return Ok(faces),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    Err(first_error.expect("there are two widths"))
}

fn binary_faces_of(text: &mut Text, n: usize, layout: Layout) -> Result<Faces> {
    let index = |label: i64| u32::try_from(label).ok();
    let mut faces = Faces::default();
    let mut nodes = Vec::new();
    for _ in 0..n {
        let (count, open) = head(text)?;
        let count = needed(text, count)?;
        nodes.clear();
        if open == Open::Values {
            let width = layout.labels[0];
            if !ends(text, count, width) {
                return Err(cut_off(text, count, "label", layout.labels));
            }
            let values = text.at..text.at + count * width;
            text.at = values.end + 1;
            let one = |i: usize| {
                let at = values.start + i * width;
                let bytes = &text.bytes[at..at + width];
                let value = number(bytes, layout.is_big_endian);
                index(value).ok_or_else(|| wrong_label(text, values.start, i, value))
            };
            for i in 0..count {
                nodes.push(one(i)?);
            }
        }
        if faces.nodes.len() + nodes.len() > u32::MAX as usize {
            return Err(text.error(too_many_nodes()));
        }
        faces.push(nodes.iter().copied());
    }
    text.expect(b')', "after the last face")?;
    Ok(faces)
}

/// Refuses more nodes of faces than 32 bits tell apart.
pub(super) fn too_many_nodes() -> String {
    "the faces have more than 4294967295 nodes together, the most that are read".to_owned()
}
