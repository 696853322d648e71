//! Files and patches that a mesh which was read from OpenFOAM keeps for its writer. A mesh has them in [`Mesh::origin`](crate::mesh::Mesh::origin).

use super::case::CasePath;
use super::file::FoamFile;
use super::text::Text;
use crate::formats::Source;
use crate::formats::names::decoded;
use crate::mesh::{Cells, Group, MeshView};
use azimesh_core::error::Result;
use azimesh_core::parallel::collect;

/// The files of a mesh that do not change while it moves.
pub(crate) struct Topology {
    pub path: CasePath,
    /// `faces`, `owner`, `neighbour`, `boundary` and, where there are some, `cellZones`, `faceZones`, `pointZones` and
    /// further files of the folder; none where the mesh was joined from the pieces of a decomposed case.
    pub files: Vec<StoredFile>,
    /// The pieces of a decomposed case, folder by folder.
    pub pieces: Vec<StoredPieces>,
    /// The patches, in the order of their faces.
    pub patches: Vec<Patch>,
    /// Number of faces between two cells; they come first.
    pub n_internal_faces: usize,
    /// Hash of the mesh that was read: of its files, points, cells, tags and zones.
    pub(super) content: blake3::Hash,
    /// Hash of the cells that the files give.
    pub(super) cells: blake3::Hash,
    /// Hash of the tags and zones that the files give.
    pub(super) groups: blake3::Hash,
}

/// A file as stored on the disk.
pub(crate) struct StoredFile {
    /// Name in the folder, with `.gz` where it is compressed.
    pub name: String,
    /// Its bytes, compressed where it is.
    pub stored: Source,
}

/// A folder of one piece of a decomposed case, or of several collated ones.
pub(crate) struct StoredPieces {
    /// Its name in the case: `processor0`, `processors4`.
    pub folder: String,
    /// True if each file has one block per piece.
    pub is_collated: bool,
    /// The files of the topology, and of the numbers in the whole.
    pub files: Vec<StoredFile>,
    pub pieces: Vec<StoredPiece>,
}

/// Data to write the points of a piece.
pub(crate) struct StoredPiece {
    /// The node of the whole that each of its points is.
    pub nodes: Vec<u32>,
    /// Its patches, in the order of their faces.
    pub patches: Vec<Patch>,
}

/// A patch: an entry of the file `boundary`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Patch {
    pub name: String,
    /// `patch`, `wall`, `cyclic` ...
    pub kind: String,
    pub n_faces: usize,
    pub start_face: usize,
    /// All entries as they are in the file, with `type`, `nFaces` and `startFace`: the key and the text between it and
    /// its semicolon, or a dictionary with its braces.
    pub entries: Vec<(String, String)>,
}

impl StoredFile {
    pub fn of(file: &FoamFile) -> Self {
        let name = file.path().file_name().unwrap_or_default();
        Self {
            name: name.to_string_lossy().into_owned(),
            stored: file.stored.clone(),
        }
    }
}

impl StoredPiece {
    /// Takes the values at its points from the values at the nodes of the whole.
    pub fn of(&self, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
        collect(self.nodes.len(), |i| values[self.nodes[i] as usize])
    }
}

impl Topology {
    /// Checks if the mesh has the nodes and cells that the files give, boundary faces too, in their order.
    pub fn has_cells_of(&self, mesh: &MeshView) -> bool {
        hash_of_cells(mesh.points.len(), mesh.cells) == self.cells
    }

    /// Checks if the mesh has the tags, with their types, and the zones that the files give.
    pub fn has_groups_of(&self, mesh: &MeshView) -> bool {
        hash_of_groups(mesh.groups) == self.groups
    }
}

impl Patch {
    /// The type that a tag has: none where it is the general one.
    pub fn condition(&self) -> Option<String> {
        (self.kind != "patch").then(|| self.kind.clone())
    }

    /// The text of an entry: of the last one with this key.
    pub fn entry(&self, key: &str) -> Option<&str> {
        let mut entries = self.entries.iter().rev();
        let (_, text) = entries.find(|(known, _)| known == key)?;
        Some(text)
    }
}

/// The patches in `boundary`, after its header.
pub(super) fn patches(text: &mut Text) -> Result<Vec<Patch>> {
    let n = match text.peek() {
        Some(byte) if byte.is_ascii_digit() => Some(text.integer("the number of patches")?),
        _ => None,
    };
    text.expect(b'(', "before the patches")?;
    let mut patches = Vec::new();
    while !text.take(b')') {
        patches.push(patch(text)?);
    }
    match n {
        Some(n) if usize::try_from(n) != Ok(patches.len()) => Err(text.error(format!(
            "the number of patches is given as {n}, but there are {}",
            patches.len()
        ))),
        _ => Ok(patches),
    }
}

fn patch(text: &mut Text) -> Result<Patch> {
    check_plain(text)?;
    let name = decoded(text.word("the name of a patch")?).into_owned();
    text.expect(b'{', &format!("after the name of patch \"{name}\""))?;
    let mut patch = Patch::default();
    while !text.take(b'}') {
        check_plain(text)?;
        let key = decoded(text.word("an entry of a patch")?).into_owned();
        check_plain(text)?;
        let value = decoded(text.value()?).into_owned();
        patch.entries.push((key, value));
    }
    let needed = |key: &str| {
        let value = patch.entry(key);
        value.ok_or_else(|| text.error(format!("patch \"{name}\" has no {key}")))
    };
    let number = |key: &str| {
        let value = needed(key)?;
        value.parse::<u32>().map(|n| n as usize).map_err(|_| {
            text.error(format!(
                "{key} of patch \"{name}\" is {value}; it must be a number of faces"
            ))
        })
    };
    Ok(Patch {
        kind: needed("type")?.to_owned(),
        n_faces: number("nFaces")?,
        start_face: number("startFace")?,
        entries: patch.entries.clone(),
        name,
    })
}

/// Refuses a directive or macro that comes next: its meaning depends on other text.
fn check_plain(text: &mut Text) -> Result<()> {
    let what = match text.peek() {
        Some(b'#') => "directive",
        Some(b'$') => "macro",
        _ => return Ok(()),
    };
    let name = decoded(text.clone().word("a name")?).into_owned();
    Err(text.error(format!(
        "the {what} {name} is not followed; write what it stands for in its place"
    )))
}

/// Hash of the cells of a mesh with so many nodes.
pub(super) fn hash_of_cells(n_nodes: usize, cells: &Cells) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let mut add = |number: usize| {
        hasher.update(&(number as u64).to_le_bytes());
    };
    add(n_nodes);
    for run in cells.runs() {
        add(run.kind as usize);
        add(run.n_nodes);
        add(run.n_cells());
    }
    update(&mut hasher, cells.connectivity());
    update(&mut hasher, cells.face_streams());
    hasher.finalize()
}

/// Hash of files, points and `further` hashes, of cells, tags and zones.
pub(super) fn hash_of_content<'f>(
    files: impl IntoIterator<Item = &'f StoredFile>,
    points: &[[f64; 3]],
    further: &[blake3::Hash],
) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let bytes = file.stored.bytes();
        for n in [file.name.len(), bytes.len()] {
            hasher.update(&(n as u64).to_le_bytes());
        }
        hasher.update(file.name.as_bytes());
        hasher.update_rayon(bytes);
        file.stored.release();
    }
    hasher.update_rayon(bytemuck::cast_slice(points));
    for hash in further {
        hasher.update(hash.as_bytes());
    }
    hasher.finalize()
}

fn update(hasher: &mut blake3::Hasher, numbers: &[u32]) {
    hasher.update(&(numbers.len() as u64).to_le_bytes());
    if cfg!(target_endian = "little") {
        hasher.update_rayon(bytemuck::cast_slice(numbers));
    } else {
        for number in numbers {
            hasher.update(&number.to_le_bytes());
        }
    }
}

/// Hash of tags and zones: names, types, cells.
pub(super) fn hash_of_groups(groups: &[Group]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let mut text = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    for group in groups {
        text(&group.name);
        text(group.condition.as_deref().unwrap_or_default());
        let ranges: Vec<String> = group.cells.ranges().map(|r| format!("{r:?}")).collect();
        text(&format!("{} {}", group.dimension, ranges.join(" ")));
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patches_in(text: &str) -> Result<Vec<Patch>> {
        patches(&mut Text::new(text.as_bytes(), 0))
    }

    #[test]
    fn patches_keep_their_entries_as_they_are() {
        let found = patches_in(
            "2\n(\n left { type cyclic; inGroups 1(cyclic); nFaces 4; startFace 10; neighbourPatch right; }\n\
             \"a b\" { type wall; extra { deep { x 1; } } nFaces 0; startFace 14; } )",
        );
        let found = found.expect("two patches");
        assert_eq!(found[0].kind, "cyclic");
        assert_eq!((found[0].n_faces, found[0].start_face), (4, 10));
        assert_eq!(found[0].entry("inGroups"), Some("1(cyclic)"));
        assert_eq!(found[0].entry("neighbourPatch"), Some("right"));
        assert_eq!(found[1].name, "a b");
        assert_eq!(found[1].entry("extra"), Some("{ deep { x 1; } }"));
        assert_eq!(found[1].n_faces, 0);
    }

    #[test]
    fn directives_and_macros_are_refused_by_name() {
        for (text, expected) in [
            (
                "(\n#include \"patches\"\n)",
                "line 2: the directive #include is not followed; write what it stands for in its place",
            ),
            (
                "(\na { type wall; nFaces $n; startFace 1; } )",
                "line 2: the macro $n is not followed; write what it stands for in its place",
            ),
            (
                "1 ( )",
                "line 1: the number of patches is given as 1, but there are 0",
            ),
            (
                "( a { type wall; nFaces 1; } )",
                "line 1: patch \"a\" has no startFace",
            ),
            (
                "( a { type wall; nFaces -1; startFace 0; } )",
                "line 1: nFaces of patch \"a\" is -1; it must be a number of faces",
            ),
        ] {
            let error = patches_in(text).expect_err("it is wrong").to_string();
            assert_eq!(error, expected);
        }
    }
}
