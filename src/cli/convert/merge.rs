//! Several inputs made one mesh.

use super::{Input, Run};
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use azimesh_core::numbers::short;
use azimesh_io::mesh::Mesh;
use std::collections::BTreeSet;

impl Run<'_> {
    /// The meshes of a step made one, in the order of the inputs; an input of one mesh is the same at every step.
    pub(super) fn merged(&self, parts: &[Input], step: Option<usize>) -> Result<Mesh> {
        let mut mesh = Mesh::default();
        let mut ends = Vec::new();
        let (mut shared, mut arrays) = (BTreeSet::new(), BTreeSet::new());
        let stems = stems(parts);
        for (i, part) in parts.iter().enumerate() {
            let step = step.filter(|_| part.times().is_some());
            let mut next = self.read_one(part, step)?;
            if self.args.prefix_tags {
                let stem = &stems[i];
                next.rename_groups(|group| format!("{stem}_{}", group.name));
                next.add_zone_of_rest(stem);
            }
            if i == 0 {
                mesh = next;
            } else {
                let merged = mesh
                    .append(&next)
                    .map_err(|error| error.file(part.path()))?;
                shared.extend(merged.shared);
                arrays.extend(merged.arrays);
            }
            ends.push(mesh.points.len() as u32);
        }
        let list = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(", ");
        let mut remarks = Vec::new();
        if !shared.is_empty() {
            let hint = match self.args.prefix_tags {
                true => "",
                false => "; --prefix-tags keeps them apart",
            };
            remarks.push(note!(
                "tags_shared",
                "--merge: tags and zones of several meshes that became one each: {}{hint}",
                list(&shared)
            ));
        }
        if !arrays.is_empty() {
            remarks.push(note!(
                "merged_arrays_left_out",
                "--merge: arrays that not all meshes have in one form are left out: {}",
                list(&arrays)
            ));
        }
        if self.args.changes.joins() {
            let distance = self.args.changes.join_distance(&mesh);
            let part = |node: u32| ends.partition_point(|end| *end <= node) as u32;
            let counts = mesh.join_parts(distance, part)?;
            if counts.n_faces == 0 {
                return Err(Error::input(format!(
                    "--join: no face of a mesh lies on a face of another within {}; --join D sets another distance",
                    short(distance)
                )));
            }
            remarks.push(self.args.changes.joined("--join", &counts));
        }
        let path = parts[0].path();
        remarks
            .into_iter()
            .for_each(|remark| self.tell(remark.file(path)));
        Ok(mesh)
    }
}

/// Returns the names of the inputs; those that several inputs have are numbered.
fn stems(parts: &[Input]) -> Vec<String> {
    let names: Vec<String> = parts.iter().map(Input::stem).collect();
    let number = |(i, name): (usize, &String)| {
        let is_same = |other: &&String| *other == name;
        match names.iter().filter(is_same).count() {
            1 => name.clone(),
            _ => format!("{name}_{}", names[..=i].iter().filter(is_same).count()),
        }
    };
    names.iter().enumerate().map(number).collect()
}
