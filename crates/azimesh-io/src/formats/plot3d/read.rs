//! A Plot3D file as a mesh: blocks, then their boundaries by a neutral map file of the same name or by their sides.

use super::super::source::{read_file, without_mark};
use super::super::{Notes, Source, case_name, names};
use super::blocks::{Block, Places};
use super::{Plot3d, blocks, layout, neutral, records, text};
use crate::formats::notes::{blanking, conditions_unused};
use crate::mesh::{Cells, Group, Mesh};
use azimesh_core::error::Result;
use std::io::ErrorKind;
use std::path::Path;

/// Returns whether a file begins as text, which no binary grid does: its counts have bytes that are zero.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let is_of_text = |byte: &u8| byte.is_ascii_whitespace() || byte.is_ascii_graphic();
    !bytes.is_empty() && bytes.iter().take(4096).all(is_of_text)
}

/// Reads a file in the one layout that fits it.
pub(super) fn read(source: &Source, stated: &Plot3d, notes: &mut Notes) -> Result<Mesh> {
    let bytes = source.bytes();
    let is_text = is_text(bytes);
    let (fits, why) = if is_text {
        text::fits(bytes)
    } else {
        let why =
            "the counts at the start fit the length of the file in no layout of a Plot3D grid";
        (records::fits(bytes), why.to_owned())
    };
    let fit = layout::one(fits, stated, why)?;
    let (points, is_blanked) = if is_text {
        text::points(bytes, &fit)?
    } else {
        fit.points(bytes)?
    };
    if is_text {
        notes.fortran(bytes);
    }
    if is_blanked {
        notes.push(blanking());
    }
    let mut mesh = Mesh::of_points(points);
    let blocks = blocks::append(&fit.blocks, &mut mesh.cells)?;
    if blocks.len() > 1 {
        for (i, block) in blocks.iter().enumerate() {
            let (dimension, name) = (block.grid.n_indices as u8, format!("block{}", i + 1));
            let cells = block.cells.clone().into();
            mesh.groups.push(Group::new(dimension, name, None, cells));
        }
    }
    if !by_neutral_map(source.path(), &blocks, &mut mesh, notes) {
        by_sides(&blocks, &mut mesh, notes);
    }
    Ok(mesh)
}

/// Tags by the neutral map file of the grid, if there is a complete one; otherwise a note says why not.
fn by_neutral_map(path: &Path, blocks: &[Block], mesh: &mut Mesh, notes: &mut Notes) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let path = path.with_file_name(format!("{}.nmf", case_name(&name)));
    let read = match read_file(&path) {
        Ok(bytes) => neutral::parse(without_mark(&bytes), blocks)
            .and_then(|entries| neutral::check_whole(&entries, blocks).map(|()| entries))
            .map_err(|error| error.file(&path).to_string()),
        Err(error) if error.kind() == ErrorKind::NotFound => return false,
        Err(error) => Err(format!("{}: {error}", path.display())),
    };
    let entries = match read {
        Ok(entries) => entries,
        Err(error) => {
            notes.push(conditions_unused(&error));
            return false;
        }
    };
    let n_interfaces = entries.iter().filter(|entry| entry.name.is_none()).count() / 2;
    let (mut tags, mut places) = (Vec::new(), names::Places::default());
    for entry in entries {
        if let Some(name) = entry.name {
            let tag = places.entry(name.clone(), &mut tags, || (name, Cells::new()));
            tag.1.append(&entry.faces);
        }
    }
    tags.into_iter()
        .for_each(|(name, faces)| add_tag(mesh, name, &faces));
    say_interfaces(n_interfaces, notes);
    true
}

fn add_tag(mesh: &mut Mesh, name: String, faces: &Cells) {
    let Some(face) = faces.runs().next() else {
        return;
    };
    let first = mesh.cells.len();
    mesh.cells.append(faces);
    let cells = (first..mesh.cells.len()).into();
    let dimension = face.kind.dimension();
    mesh.groups.push(Group::new(dimension, name, None, cells));
}

/// A tag for each side of a block that is nowhere on a side of a block.
fn by_sides(blocks: &[Block], mesh: &mut Mesh, notes: &mut Notes) {
    let mut places = Places::new(&mesh.points);
    for (_, faces) in blocks.iter().flat_map(Block::sides) {
        places.add(&faces);
    }
    let (mut tags, mut parts) = (Vec::new(), Vec::new());
    let mut n_interfaces = 0;
    for (i, block) in blocks.iter().enumerate() {
        for (side, faces) in block.sides() {
            let name = match blocks.len() {
                1 => side.to_owned(),
                _ => format!("block{}_{side}", i + 1),
            };
            match places.n_shared(&faces) {
                0 => tags.push((name, faces)),
                n if n == faces.len() => n_interfaces += 1,
                _ => parts.push(name),
            }
        }
    }
    for (name, faces) in tags {
        add_tag(mesh, name, &faces);
    }
    let what = "sides of blocks that partly coincide with others, without a complete .nmf file,";
    notes.names_not_kept(what, parts);
    say_interfaces(n_interfaces, notes);
}

fn say_interfaces(n: usize, notes: &mut Notes) {
    notes.not_kept("interfaces to other zones", n);
}
