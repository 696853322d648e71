//! Patches of a mesh that is written: one for each boundary tag, with its name and type, and one for the outer faces of
//! no tag. Owns the words of OpenFOAM for types of patches, and for types of other formats.

use super::faces::FaceList;
use super::topology::{Patch, Topology};
use crate::formats::Notes;
use crate::formats::names::{Rule, UniqueNames};
use crate::mesh::{Group, Mesh, MeshView, inner_faces};
use azimesh_core::error::{Error, Result, nearest_name, option};
use azimesh_core::{Note, note};
use std::collections::BTreeMap;

/// The patch of outer faces without a tag, as OpenFOAM's own programs call it.
const DEFAULT: &str = "defaultFaces";

/// Types that a tag can be given: those that need no further entries.
pub const GIVEN: &[&str] = &[
    "patch",
    "wall",
    "symmetry",
    "symmetryPlane",
    "empty",
    "wedge",
];

/// Types of CGNS and the most similar ones of OpenFOAM; other words of CGNS become `patch`.
const OF_CGNS: &[(&str, &str)] = &[("BCWall", "wall"), ("BCSymmetryPlane", "symmetry")];

/// Names of OpenFOAM: a word that cannot be read as a number or as punctuation.
const NAMES: Rule = Rule {
    longest: 200,
    fit: fit_name,
    why: "OpenFOAM's names are words without blanks, quotes, brackets, slashes and semicolons, and begin with a letter",
};

/// The patches of a mesh, in the order of its tags; the last one is for faces without a tag.
pub(super) struct Patches {
    pub list: Vec<Patch>,
    /// For each cell the patch of a boundary cell; `list.len() - 1` for cells without a tag.
    pub of_cell: Vec<u32>,
    /// Faces in more than one tag.
    n_several: usize,
    /// Faces of each tag between two cells, which are zones.
    pub inside: BTreeMap<usize, FaceList>,
}

impl Patches {
    /// The patches of the tags. `origin` is what the mesh was read from, whose entries are kept; a type that needs further
    /// entries is refused.
    pub fn of(mesh: &MeshView, origin: Option<&Topology>, notes: &mut Notes) -> Result<Self> {
        let tags: Vec<_> = mesh.boundary_tags().collect();
        let rest = tags.len() as u32;
        let mut of_cell = vec![rest; mesh.cells.len()];
        let mut n_several = 0;
        for (tag, patch) in tags.iter().zip(0..) {
            for range in tag.cells.ranges() {
                for own in &mut of_cell[range] {
                    if *own == rest {
                        *own = patch;
                    } else {
                        n_several += 1;
                    }
                }
            }
        }
        let list = patches_of(mesh, origin, notes)?;
        Ok(Self {
            list,
            of_cell,
            n_several,
            inside: BTreeMap::new(),
        })
    }

    /// Finds the faces of tags between two cells, where the patches, of these sizes, lack faces of their tags.
    pub fn find_inside(&mut self, mesh: &MeshView, sizes: &[usize]) {
        if self
            .wanted(sizes.len())
            .iter()
            .zip(sizes)
            .all(|(wanted, n)| wanted <= n)
        {
            return;
        }
        for face in inner_faces(mesh) {
            let patch = self.of_cell[face as usize] as usize;
            if patch + 1 < self.list.len() {
                let faces = self.inside.entry(patch).or_default();
                faces.push(mesh.cells.get(face as usize).nodes);
            }
        }
    }

    /// Number of boundary faces in each patch, as their tags say.
    fn wanted(&self, n: usize) -> Vec<usize> {
        let mut wanted = vec![0; n];
        for &patch in &self.of_cell {
            wanted[patch as usize] += 1;
        }
        if let Some(rest) = wanted.last_mut() {
            *rest = 0;
        }
        wanted
    }

    /// Notes on faces that are in no patch, or in another than some of their tags say; `sizes` has the sizes
    /// of the patches.
    pub fn notes_on_faces(&self, mesh: &MeshView, sizes: &[usize]) -> Vec<Note> {
        let mut notes = Vec::new();
        if self.n_several > 0 {
            notes.push(note!(
                "one_patch",
                "a face is in one patch of OpenFOAM; further tags of faces that have several are left out ({})",
                self.n_several
            ));
        }
        let wanted = self.wanted(sizes.len());
        for (patch, (tag, (&wanted, &n))) in mesh
            .boundary_tags()
            .zip(wanted.iter().zip(sizes))
            .enumerate()
        {
            let n_inside = self.inside.get(&patch).map_or(0, FaceList::len);
            notes.extend((n_inside > 0).then(|| {
                note!(
                    "face_zone",
                    "faces of the tag \"{}\" between two cells are in a faceZone of its name ({n_inside})",
                    tag.name
                )
            }));
            let n = n + n_inside;
            if n < wanted {
                notes.push(note!(
                    "not_outside",
                    "faces of the tag \"{}\" that are not on the outside of the mesh are left out ({}); a patch of OpenFOAM has \
                     outer faces only",
                    tag.name,
                    wanted - n
                ));
            }
        }
        let rest = self.list.last().zip(sizes.last());
        notes.extend(rest.filter(|(_, n)| **n > 0).map(|(patch, &n)| {
            let name = &patch.name;
            note!(
                "untagged_patch",
                "outer faces without a tag ({n}) are in the patch {name}"
            )
        }));
        notes
    }

    /// The content of the file `boundary` behind its header. `sizes` has the sizes of the patches, `n_inner` is the number
    /// of faces before them.
    pub fn text(&self, n_inner: usize, sizes: &[usize]) -> String {
        let all = self.list.iter().zip(sizes).enumerate();
        let is_written = |(at, (_, n)): &(usize, (&Patch, &usize))| {
            **n > 0 || at + 1 < self.list.len() && !self.inside.contains_key(at)
        };
        let written: Vec<_> = all.filter(is_written).collect();
        let mut text = format!("{}\n(\n", written.len());
        let mut start = n_inner;
        for (_, (patch, &n_faces)) in written {
            push_text(&mut text, patch, n_faces, start);
            start += n_faces;
        }
        text.push_str(")\n");
        text
    }
}

/// The patches of the tags, and one for faces without a tag, without the faces.
pub(super) fn patches_of(
    mesh: &MeshView,
    origin: Option<&Topology>,
    notes: &mut Notes,
) -> Result<Vec<Patch>> {
    let tags: Vec<_> = mesh.boundary_tags().collect();
    let names: Vec<&str> = tags.iter().map(|tag| &*tag.name).collect();
    let written = UniqueNames::with([DEFAULT].into_iter().filter(|name| !names.contains(name)))
        .give_all(&names, &NAMES);
    let patches = origin.map_or(&[][..], |origin| &origin.patches);
    let known = patches.iter().map(|patch| (&*patch.name, patch));
    let known: BTreeMap<&str, &Patch> = known.collect();
    let mut list = Vec::with_capacity(tags.len() + 1);
    for (tag, name) in tags.iter().zip(written) {
        notes.extend(NAMES.note("boundary tag", &tag.name, &name));
        let known = known.get(&*tag.name).copied();
        let kind = kind_of(tag.condition.as_deref(), known, &tag.name, notes);
        let known = known.filter(|known| known.kind == kind);
        if known.is_none() && kind.to_ascii_lowercase().contains("cyclic") {
            return Err(Error::input(format!(
                "patch \"{name}\" is of type {kind}, which needs entries such as neighbourPatch that this mesh does not \
                 have; give it another type with --patch-type {name}=patch, and make it {kind} in the file boundary"
            )));
        }
        list.push(Patch {
            name,
            kind,
            entries: known.map_or(Vec::new(), |known| known.entries.clone()),
            ..Patch::default()
        });
    }
    list.push(Patch {
        name: UniqueNames::with(list.iter().map(|patch| &*patch.name)).give(DEFAULT, &NAMES),
        kind: "patch".to_owned(),
        ..Patch::default()
    });
    Ok(list)
}

/// Adds the entry of a patch with these faces.
fn push_text(text: &mut String, patch: &Patch, n_faces: usize, start: usize) {
    text.push_str(&format!("    {}\n    {{\n", patch.name));
    let mut line = |key: &str, value: &str| {
        text.push_str(&if value.starts_with('{') {
            format!("        {key}\n        {value}\n")
        } else {
            format!("        {key:<15} {value};\n")
        });
    };
    line("type", &patch.kind);
    for (key, value) in &patch.entries {
        if !["type", "nFaces", "startFace"].contains(&key.as_str()) {
            line(key, value);
        }
    }
    line("nFaces", &n_faces.to_string());
    line("startFace", &start.to_string());
    text.push_str("    }\n");
}

/// The type that a tag has in OpenFOAM.
fn kind_of(condition: Option<&str>, known: Option<&Patch>, tag: &str, notes: &mut Notes) -> String {
    let condition = condition.unwrap_or("patch");
    let is_of_openfoam = GIVEN.contains(&condition)
        || known.is_some_and(|known| known.kind == condition)
        || condition.starts_with("cyclic")
        || condition.starts_with("nonConformal");
    if is_of_openfoam {
        return condition.to_owned();
    }
    let similar = OF_CGNS.iter().find(|(word, _)| condition.starts_with(word));
    if similar.is_none() {
        notes.push(note!(
            "condition_as_patch",
            "condition {condition} of tag \"{tag}\" is written as the type patch of OpenFOAM"
        ));
    }
    similar.map_or("patch", |(_, kind)| *kind).to_owned()
}

fn fit_name(name: &str, longest: usize) -> String {
    let allowed = |c: char| c.is_alphanumeric() || "_-.:+@%&".contains(c);
    let mut fit: String = name
        .chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    if !fit.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        fit.insert_str(0, "patch");
    }
    crate::formats::names::cut(&fit, longest)
}

/// The names that zones have in a file.
pub(super) fn zone_names(zones: &[&Group]) -> Vec<String> {
    let names: Vec<&str> = zones.iter().map(|zone| &*zone.name).collect();
    UniqueNames::default().give_all(&names, &NAMES)
}

/// Sets the types of boundary tags, as `(tag, type)`.
///
/// # Errors
/// For a tag that the mesh does not have, and for a type that is not known or needs more than its name.
pub fn set_patch_types(mesh: &mut Mesh, types: &[(String, String)]) -> Result<()> {
    let given: BTreeMap<&str, &str> = types.iter().map(|(tag, kind)| (&**tag, &**kind)).collect();
    let dimension = mesh.dimension();
    for (tag, kind) in given {
        if !GIVEN.contains(&kind) {
            let hint = nearest_name(kind, GIVEN.iter().copied())
                .map_or(String::new(), |name| format!(" (did you mean {name}?)"));
            return Err(Error::input(format!(
                "{} {tag}={kind}: the type is not one of {}{hint}",
                option("patch-type"),
                GIVEN.join(", ")
            )));
        }
        let mut own = mesh
            .groups
            .iter_mut()
            .filter(|group| group.dimension + 1 == dimension && group.name == tag)
            .peekable();
        if own.peek().is_none() {
            let names: Vec<&str> = mesh.boundary_tags().map(|tag| &*tag.name).collect();
            return Err(Error::input(format!(
                "{}: tag \"{tag}\" is not in the mesh; it has: {}",
                option("patch-type"),
                names.join(", ")
            )));
        }
        own.for_each(|group| group.condition = (kind != "patch").then(|| kind.to_owned()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// A tetrahedron with a tag for each of these conditions, on its faces in turn.
    fn tagged(tags: &[(&str, Option<&str>)]) -> Mesh {
        let mut mesh = Mesh::of_points(vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        for face in [[0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            mesh.cells.push(CellKind::Triangle, &face);
        }
        for (i, (name, condition)) in tags.iter().enumerate() {
            mesh.add_tag(*name, [1 + i % 3])
                .expect("it is a boundary face");
            mesh.groups[i].condition = condition.map(str::to_owned);
        }
        mesh
    }

    fn written(mesh: &Mesh) -> (Vec<(String, String)>, Notes) {
        let mut notes = Notes::default();
        let list = patches_of(&mesh.view(), None, &mut notes).expect("they can be written");
        (
            list.into_iter()
                .map(|patch| (patch.name, patch.kind))
                .collect(),
            notes,
        )
    }

    #[test]
    fn types_come_from_the_words_of_openfoam_and_cgns() {
        let mesh = tagged(&[
            ("a", None),
            ("b", Some("wall")),
            ("c", Some("BCWallViscousHeatFlux")),
            ("d", Some("BCSymmetryPlane")),
            ("e", Some("symmetryPlane")),
            ("f", Some("BCFarfield")),
        ]);
        let (patches, notes) = written(&mesh);
        let kinds: Vec<&str> = patches.iter().map(|(_, kind)| &**kind).collect();
        assert_eq!(
            kinds,
            [
                "patch",
                "wall",
                "wall",
                "symmetry",
                "symmetryPlane",
                "patch",
                "patch"
            ]
        );
        assert_eq!(notes, ["condition_as_patch"]);
        let note = "condition BCFarfield of tag \"f\" is written as the type patch of OpenFOAM";
        assert!(notes.says(note), "{notes:?}");
    }

    #[test]
    fn names_become_words_of_openfoam_each_once() {
        let mesh = tagged(&[
            ("upper wall", None),
            ("upper_wall", None),
            ("7", None),
            ("a{b;c}", None),
            ("defaultFaces", None),
        ]);
        let (patches, notes) = written(&mesh);
        let names: Vec<&str> = patches.iter().map(|(name, _)| &**name).collect();
        assert_eq!(
            names,
            [
                "upper_wall_2",
                "upper_wall",
                "patch7",
                "a_b_c_",
                "defaultFaces",
                "defaultFaces_2"
            ]
        );
        assert_eq!(notes.len(), 3);
    }

    #[test]
    fn a_cyclic_patch_keeps_its_entries_or_is_refused() {
        let mesh = tagged(&[("side", Some("cyclic"))]);
        let refused =
            patches_of(&mesh.view(), None, &mut Notes::default()).expect_err("it has no neighbour");
        assert!(
            refused.message.contains("\"side\"") && refused.message.contains("neighbourPatch"),
            "{refused}"
        );
        let known = Patch {
            name: "side".into(),
            kind: "cyclic".into(),
            n_faces: 7,
            start_face: 70,
            entries: [
                ("type", "cyclic"),
                ("nFaces", "7"),
                ("startFace", "70"),
                ("neighbourPatch", "other"),
                ("coeffs", "{ a 1; }"),
            ]
            .map(|(key, text)| (key.to_owned(), text.to_owned()))
            .to_vec(),
        };
        let mut text = String::new();
        push_text(&mut text, &known, 3, 20);
        let words: Vec<&str> = text.split_whitespace().collect();
        assert_eq!(
            words.join(" "),
            "side { type cyclic; neighbourPatch other; coeffs { a 1; } nFaces 3; startFace 20; }"
        );
    }

    #[test]
    fn faces_in_no_patch_are_told_and_the_last_patch_is_written_only_with_faces() {
        let mesh = tagged(&[("a", None), ("b", None), ("c", None), ("again", None)]);
        let patches =
            Patches::of(&mesh.view(), None, &mut Notes::default()).expect("it can be written");
        assert_eq!(patches.of_cell, [4, 0, 1, 2]);
        let notes = patches.notes_on_faces(&mesh.view(), &[1, 1, 0, 0, 2]);
        let told: Vec<String> = notes.iter().map(ToString::to_string).collect();
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(
            told[1].contains("\"c\"") && told[2].contains("defaultFaces"),
            "{told:?}"
        );
        assert!(patches.text(0, &[1, 1, 1, 0, 1]).contains("defaultFaces"));
        let without = patches.text(10, &[1, 1, 1, 0, 0]);
        assert!(
            !without.contains("defaultFaces") && without.starts_with("4\n(\n"),
            "{without}"
        );
    }

    #[test]
    fn types_are_given_to_tags_that_are_there() {
        let mut mesh = tagged(&[("a", None), ("b", Some("wall"))]);
        let types = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs
                .iter()
                .map(|(tag, kind)| ((*tag).to_owned(), (*kind).to_owned()))
                .collect()
        };
        set_patch_types(&mut mesh, &types(&[("a", "symmetryPlane"), ("b", "patch")]))
            .expect("both are there");
        let conditions: Vec<_> = mesh
            .groups
            .iter()
            .map(|tag| tag.condition.as_deref())
            .collect();
        assert_eq!(conditions, [Some("symmetryPlane"), None]);
        for wrong in [("c", "wall"), ("a", "cyclic")] {
            assert!(
                set_patch_types(&mut mesh, &types(&[wrong])).is_err(),
                "{wrong:?}"
            );
        }
    }
}
