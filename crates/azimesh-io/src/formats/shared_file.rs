//! Files that ranks read together: each reads its own slab, so that no rank has the whole mesh.

use super::slabs::{Refusal, Slabs};
use super::{Format, Loaded, Location, Notes, ReadOptions, Source, by_name, of};
use crate::mesh::Mesh;
use crate::mesh::from_slabs::MeshByRanges;
use azimesh_core::error::{Error, Result};
use azimesh_core::ranks::Ranks;
use serde::{Deserialize, Serialize};
use std::fs::Metadata;
use std::path::{Path, absolute};
use std::time::UNIX_EPOCH;

/// Error where a path leads to another file on another rank.
const DIFFERENT: &str = "ranks see different files";

/// A mesh in a file that each rank reads its part of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedFile {
    path: String,
    format: String,
    options: ReadOptions,
    stamp: Stamp,
}

/// A file that ranks can read by parts, or why it has to be read as a whole.
pub type Shared = std::result::Result<SharedFile, String>;

/// Size and time that distinguish a file from another of the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    n_bytes: u64,
    /// Nanoseconds since 1970.
    modified: i128,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        let nanoseconds = |time: std::time::SystemTime| match time.duration_since(UNIX_EPOCH) {
            Ok(after) => after.as_nanos() as i128,
            Err(before) => -(before.duration().as_nanos() as i128),
        };
        Self {
            n_bytes: metadata.len(),
            modified: metadata.modified().map_or(0, nanoseconds),
        }
    }
}

impl SharedFile {
    /// A file as the first rank sees it; without `format`, its content gives the format.
    ///
    /// # Errors
    /// Why it cannot be read by slabs, as far as that is found here.
    pub fn new(
        path: &Path,
        format: Option<&'static Format>,
        options: &ReadOptions,
    ) -> std::result::Result<Self, String> {
        let named = |error: Error| error.message;
        if path.as_os_str() == "-" {
            return Err("it is standard input".to_owned());
        }
        let path = absolute(path).map_err(|error| error.to_string())?;
        let text = path.to_str().ok_or("its path is not of UTF-8")?;
        let (location, stamp) = open(&path).map_err(named)?;
        let format = format.map_or_else(|| of(&location), Ok).map_err(named)?;
        Ok(Self {
            path: text.to_owned(),
            format: format.name.to_owned(),
            options: options.clone(),
            stamp,
        })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        Path::new(&self.path)
    }

    /// Opens the same file on any rank.
    fn open(&self) -> Result<(Location, &'static Format)> {
        let format = by_name(&self.format)?;
        let (location, stamp) = open(self.path())?;
        if stamp != self.stamp {
            return Err(Error::input(DIFFERENT));
        }
        if !format.recognizes(&location) {
            return Err(Error::input(format!("it is not like {}", format.title)));
        }
        Ok((location, format))
    }
}

/// Opens a file that the system maps and that is not compressed: only the parts that are read use memory.
fn open(path: &Path) -> Result<(Location, Stamp)> {
    let io = |error| Error::io(path, &error);
    super::check_file(path).map_err(io)?;
    let stamp = Stamp::of(&std::fs::metadata(path).map_err(io)?);
    let source = Source::stored(path)?;
    if source.is_compressed() {
        return Err(Error::input("it is compressed"));
    }
    if !source.is_mapped() {
        return Err(Error::input("the system does not map it"));
    }
    Ok((source.into(), stamp))
}

/// The part of each rank of the mesh in a file, which is what [`Mesh::shared`] makes of the mesh that [`read`](super::read)
/// gives, but without groups. All ranks call it with the same file.
///
/// # Errors
/// On all ranks, why the file has to be read as a whole: in words that complete "read whole by one rank: ...".
pub fn read_parts(file: &SharedFile, ranks: &Ranks) -> std::result::Result<Mesh, String> {
    let opened = ranks.all_ok(file.open()).map_err(reason)?;
    parts(opened, file, ranks).map_err(reason)
}

fn parts(
    (location, format): (Location, &'static Format),
    file: &SharedFile,
    ranks: &Ranks,
) -> Result<Mesh> {
    let source = location.file()?;
    let slabs = ranks.all_ok(by_slabs(format, source, &file.options))?;
    let (n_nodes, n_cells, space) = (slabs.n_nodes(), slabs.n_cells(), slabs.space());
    let counts = ranks.allgather((n_nodes, n_cells, space));
    if counts.windows(2).any(|pair| pair[0] != pair[1]) {
        return Err(Error::input(DIFFERENT));
    }
    let slabs = MeshByRanges {
        n_nodes,
        n_cells,
        space,
        points: &|nodes| released(source, slabs.points(nodes)),
        cells: &|cells| released(source, slabs.cells(cells)),
    };
    Mesh::from_slabs(&slabs, format.lists_faces_again, ranks)
}

/// A mesh that all ranks read, and write, together.
pub struct SharedMesh {
    /// The part of this rank.
    pub part: Mesh,
    /// On the first rank the kinds of all cells, the groups and the arrays, with the notes of the reader.
    pub layout: Option<Loaded>,
}

/// The parts of all ranks as [`read_parts`] gives them, with groups, where `allows` accepts the layout of the mesh on the first
/// rank. All ranks call it with the same file.
///
/// # Errors
/// On all ranks, why the mesh has to be read as a whole, as for [`read_parts`].
pub fn read_together(
    file: &SharedFile,
    ranks: &Ranks,
    allows: impl FnOnce(&Mesh) -> std::result::Result<(), String>,
) -> std::result::Result<SharedMesh, String> {
    let mut part = read_parts(file, ranks)?;
    let layout = Mesh::layout_of(&part).map(|layout| {
        let loaded = file.complete(layout)?;
        allows(&loaded.mesh)?;
        Ok::<_, String>(loaded)
    });
    let of_first = layout.as_ref().map(|layout| match layout {
        Ok(loaded) => Ok(loaded.mesh.groups.clone()),
        Err(reason) => Err(reason.clone()),
    });
    part.set_whole_groups(ranks.broadcast(of_first)?);
    let layout = layout.transpose()?;
    Ok(SharedMesh { part, layout })
}

impl SharedFile {
    /// Gives the layout of the mesh its groups and arrays, with the notes of its reader.
    ///
    /// # Errors
    /// Why the file has to be read as a whole, as for [`read_parts`].
    fn complete(&self, mut layout: Mesh) -> std::result::Result<Loaded, String> {
        let (location, format) = self.open().map_err(reason)?;
        let source = location.file().map_err(reason)?;
        let slabs = by_slabs(format, source, &self.options).map_err(reason)?;
        // A part takes the dimension of the whole mesh from here; the whole mesh takes it from its cells.
        layout.space = slabs.space();
        let mut notes = Notes::default();
        super::note_steps(format, &location, &self.options, &mut notes);
        let completed = slabs.complete(&mut layout, &mut notes);
        completed.map_err(|refusal| match refusal {
            Refusal::Whole(why) => why,
            Refusal::Damaged(error) => reason(error),
        })?;
        layout.validate_arrays().map_err(reason)?;
        layout.validate_groups().map_err(reason)?;
        super::names::check(&mut layout, &mut notes);
        notes.close();
        Ok(Loaded {
            mesh: layout,
            notes,
            format,
        })
    }

    /// Checks if the file has not changed.
    pub fn is_unchanged(&self) -> bool {
        self.open().is_ok()
    }

    /// Reads the whole mesh, which was found readable by slabs before.
    pub fn read_whole(&self) -> Result<Mesh> {
        let named = |error: Error| error.file(self.path());
        if !self.is_unchanged() {
            let message = "it has changed since it was read first, and more of it is needed";
            return Err(named(Error::system(message)));
        }
        let (location, format) = self.open().map_err(named)?;
        let read = super::read_as(format, &location, &self.options);
        Ok(read.map_err(named)?.mesh)
    }
}

/// An error as a reason, without the path that is known.
pub(crate) fn reason(error: Error) -> String {
    Error {
        path: None,
        ..error
    }
    .to_string()
}

fn by_slabs<'a>(
    format: &Format,
    source: &'a Source,
    options: &ReadOptions,
) -> Result<Box<dyn Slabs + 'a>> {
    format.slabs(source, options)?.map_err(Error::input)
}

/// Gives back the value that was read, and releases the memory that holds the mapped file.
fn released<T>(source: &Source, read: T) -> T {
    source.release();
    read
}
