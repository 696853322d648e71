//! Zones: named lists of cells, faces or points in `cellZones`, `faceZones` and `pointZones`.

use super::file::FoamFile;
use super::lists::{Layout, labels_at};
use super::text::Text;
use crate::formats::names::{Places, decoded};
use azimesh_core::error::Result;

/// A named list.
pub(super) struct Zone {
    /// Its name.
    pub name: String,
    /// Cells, faces or points.
    pub labels: Vec<u32>,
}

/// The labels of the zone of this name, which may be new.
pub(super) fn of_name<'z>(
    name: &str,
    zones: &'z mut Vec<Zone>,
    places: &mut Places<String>,
) -> &'z mut Vec<u32> {
    let new = || Zone {
        name: name.to_owned(),
        labels: Vec::new(),
    };
    &mut places.entry(name.to_owned(), zones, new).labels
}

/// The zones in a file, with the labels under `key`: `cellLabels`.
pub(super) fn zones(file: &FoamFile, key: &str, most: usize) -> Result<Vec<Zone>> {
    file.checked(zones_in(file, key, most))
}

fn zones_in(file: &FoamFile, key: &str, most: usize) -> Result<Vec<Zone>> {
    let mut text = file.text();
    if text.peek().is_some_and(|byte| byte.is_ascii_digit()) {
        text.integer("the number of zones")?;
    }
    text.expect(b'(', "before the zones")?;
    let mut zones = Vec::new();
    while !text.take(b')') {
        let name = decoded(text.word("the name of a zone")?).into_owned();
        text.expect(b'{', &format!("after the name of zone \"{name}\""))?;
        let mut labels = Vec::new();
        while !text.take(b'}') {
            let found = entry(&mut text, file, key, most)?;
            labels = found.unwrap_or(labels);
        }
        zones.push(Zone { name, labels });
    }
    Ok(zones)
}

/// Passes an entry of a zone; gives its labels if it is the one that is wanted.
fn entry(text: &mut Text, file: &FoamFile, key: &str, most: usize) -> Result<Option<Vec<u32>>> {
    let index = |label: i64| u32::try_from(label).ok();
    let found = text.word("an entry of a zone")?;
    let is_list = text.rest().trim_ascii_start().starts_with(b"List<");
    if found == key.as_bytes() {
        let labels = labels_at(text, layout(text, file), most, &index)?;
        text.expect(b';', "after a list")?;
        return Ok(Some(labels));
    }
    match text.peek() {
        Some(b'{') => drop(text.braces()?),
        _ if is_list && text.is_binary => pass_list(text, file, most)?,
        _ => drop(text.value()?),
    }
    Ok(None)
}

/// Passes a binary list: of labels, or of `bool`, which are bytes.
fn pass_list(text: &mut Text, file: &FoamFile, most: usize) -> Result<()> {
    labels_at(text, layout(text, file), most, &Some)?;
    text.expect(b';', "after a list")
}

/// How the numbers of a list are stored: each `bool` is a byte.
fn layout(text: &Text, file: &FoamFile) -> Layout {
    let mut layout = Layout::of(file);
    if text.rest().trim_ascii_start().starts_with(b"List<bool>") {
        layout.labels = [1, 4];
    }
    layout
}

/// The names of the zones in a file, or how many there are where it cannot be read: these zones are no part of a mesh.
pub(super) fn names(file: &FoamFile, key: &str) -> Vec<String> {
    if let Ok(zones) = zones(file, key, u32::MAX as usize / 64) {
        return zones.into_iter().map(|zone| zone.name).collect();
    }
    let n = file.text().integer("the number of zones").unwrap_or(0);
    match n {
        0 => Vec::new(),
        n => vec![format!("{n} zones")],
    }
}
