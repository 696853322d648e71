//! The motions of a body, one file each: [`BodyMotion`] as declared, [`ResolvedMotion`] on a mesh.
//!
//! ```text
//! schedule.toml ── keys of Body ────┐
//!                                  ├─> dyn BodyMotion ── resolve ──> dyn ResolvedMotion ── link ──> Link
//! Body::new(..).cyclic(..) ────────┘    keys, files, checks           what its files hold            map, velocity,
//!                                                                                                    rotations at a step
//! ```
//!
//! A new motion is a file here with both traits and its keys, and a line in the keys of a body.

mod axis_rotation;
mod beam;
mod clock;
mod cyclic;
mod function;
mod link;
mod modes;
mod naming;
mod nodes;
mod oscillation;
mod rigid;
mod series;
mod sets;
mod step_files;
mod surface;
mod surface_map;
mod table;

pub use axis_rotation::AxisRotation;
pub use beam::{Beam, CentreLine};
pub(super) use clock::Clock;
pub use cyclic::Cyclic;
pub(super) use function::Displacements;
pub use link::Rotation;
pub(super) use link::{Link, RigidLink};
pub use modes::Modes;
#[cfg(test)]
pub(super) use naming::NamedColumns;
pub(super) use rigid::Rigid;
pub use rigid::Translation;
#[cfg(test)]
pub(super) use series::{Harmonic, Series};
pub(super) use step_files::paths;
pub use surface::SurfaceMotion;
pub use surface_map::MapMethod;
pub use table::TableMotion;

use super::body::Body;
use super::rotor::RotorAxes;
use super::steps::Step;
use super::surface::{Role, SurfaceFaces, SurfaceNodes};
use super::table::Table;
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::Boundary;
use nodes::BodyNodes;
use std::any::{Any, TypeId};
use std::cell::{OnceCell, RefCell};
use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The declaration of a motion.
pub(super) trait BodyMotion: Any + Debug + Send + Sync {
    /// The tables and files it names.
    fn files(&self) -> Vec<&TableSource> {
        Vec::new()
    }

    /// Returns whether it needs the azimuth of a step: harmonics do; tables have it as a column.
    fn has_harmonics(&self) -> bool {
        false
    }

    /// Refuses invalid numbers.
    fn check(&self, _body: &Body) -> Result<()> {
        Ok(())
    }

    /// Refuses motion out of the plane of a 2D mesh, if that is known without files. The shaft of a 2D mesh is in the
    /// plane, unless `upright`.
    fn check_plane(&self, _body: &Body, _upright: bool) -> Result<()> {
        Ok(())
    }

    /// Resolves it on a mesh: reads its files and checks them against nodes and steps.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>>;
}

/// Returns the place of a motion in the order in which the motions of a body act.
pub(super) fn order(motion: &dyn BodyMotion) -> Option<usize> {
    let kinds = [
        TypeId::of::<Modes>(),
        TypeId::of::<SurfaceMotion>(),
        TypeId::of::<Displacements>(),
        TypeId::of::<Rigid>(),
        TypeId::of::<TableMotion>(),
        TypeId::of::<Cyclic>(),
        TypeId::of::<Beam>(),
    ];
    let own = (motion as &dyn Any).type_id();
    kinds.iter().position(|kind| *kind == own)
}

/// Set of points of a body that share a map of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MapScope {
    /// One rigid map for every point.
    Body,
    /// A rigid map for each section.
    Sections,
    /// A displacement for each node, and no rotation.
    Nodes,
}

/// A motion on a mesh.
pub(super) trait ResolvedMotion: Debug + Send + Sync {
    /// Returns its map at a part of a step; `None` if another motion includes it.
    fn link(&self, at: &At<'_>) -> Option<Link<'_>>;

    /// Returns the set of points that share a map.
    fn map_scope(&self) -> MapScope {
        MapScope::Body
    }

    /// Returns its centre of rotation, if it has one.
    fn centre(&self) -> Option<Vector> {
        None
    }

    /// Returns whether it is the motion of a blade along the rotor's span.
    fn is_of_blade(&self) -> bool {
        false
    }

    /// Returns pitch, flap and lag at a step, in radians, without the signs of the rotor.
    fn cyclic_angles(&self, _step: &Step) -> Option<[f64; 3]> {
        None
    }

    /// Returns the angle about its given axis at a part of a step, in radians.
    fn axis_angle(&self, _at: &At<'_>) -> Option<f64> {
        None
    }

    /// Returns the line about which its sections turn, within the span of some points.
    fn centre_line(&self, _points: &[Vector]) -> Option<CentreLine> {
        None
    }

    /// Returns the size in bytes of the displacements that it stores for the nodes of its body.
    fn memory_bytes(&self) -> usize {
        0
    }

    /// Notes on its files.
    fn notes(&self) -> &[Note] {
        &[]
    }
}

/// The step of a link, and the part of it.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub step: &'a Step,
    /// The part of the motion, from 0 to 1.
    pub part: f64,
    pub clock: Clock<'a>,
    /// True if rates of nodes are needed; other links always have theirs.
    pub rates: bool,
}

/// Context in which a motion is resolved: the boundary of the mesh, the steps, the blade.
pub(super) struct OnMesh<'a> {
    /// The boundary of the mesh.
    pub boundary: &'a Boundary,
    /// Faces with a role.
    pub faces: &'a SurfaceFaces,
    /// Nodes with a role.
    pub surface_nodes: &'a SurfaceNodes,
    /// The role of the body's nodes.
    pub role: Role,
    /// Axes of the blade at its azimuth offset.
    pub blade: RotorAxes,
    /// The azimuth offset in radians.
    pub offset: f64,
    pub clock: Clock<'a>,
    /// Name of the mesh unit, if the schedule gives it.
    pub length_unit: Option<&'a str>,
    pub body: &'a Body,
    /// Folder that files are relative to.
    pub folder: PathBuf,
    /// The nodes of the body, found on first use.
    pub nodes: OnceCell<Arc<BodyNodes>>,
    /// Warnings about the input, without duplicates.
    pub warnings: RefCell<Vec<Note>>,
}

impl OnMesh<'_> {
    /// Returns whether the mesh is plane.
    pub fn in_plane(&self) -> bool {
        self.blade.in_plane && self.boundary.dimension() < 3
    }

    /// The nodes of the body.
    pub fn nodes(&self) -> Arc<BodyNodes> {
        let nodes = self.nodes.get_or_init(|| Arc::new(BodyNodes::of(self)));
        Arc::clone(nodes)
    }

    /// Adds a warning that the input is probably wrong.
    pub fn warn(&self, note: Note) {
        let mut warnings = self.warnings.borrow_mut();
        if !warnings.contains(&note) {
            warnings.push(note);
        }
    }

    /// Returns an error at the position of a key of the body.
    pub fn error(&self, key: &str, message: impl Into<String>) -> Error {
        self.body.places.error(key, message)
    }

    /// Returns the path of a file that a motion names; a missing file is an error at its key.
    pub fn file(&self, file: &str, key: &str) -> Result<PathBuf> {
        file_in(&self.folder, file, |message| self.error(key, message))
    }
}

/// Returns the path of a file that a schedule names, relative to a folder; `error` converts a message to an error.
fn file_in(folder: &Path, file: &str, error: impl Fn(String) -> Error) -> Result<PathBuf> {
    let path = folder.join(file);
    let message = match path.metadata() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            format!("there is no file {}", path.display())
        }
        Ok(found) if found.is_dir() => {
            format!("{} is a folder; a file belongs here", path.display())
        }
        _ => return Ok(path),
    };
    Err(error(message))
}

/// A table: a file to be read, or one in memory.
#[derive(Debug, Clone)]
pub enum TableSource {
    /// A path relative to the schedule's file, or to the working folder.
    File(String),
    /// A table that was read or built before.
    Table(Arc<Table>),
}

impl From<Table> for TableSource {
    fn from(table: Table) -> Self {
        Self::Table(Arc::new(table))
    }
}

impl From<&str> for TableSource {
    fn from(path: &str) -> Self {
        Self::File(path.to_owned())
    }
}

impl TableSource {
    /// Returns the path of the file, if it is one.
    pub(super) fn file(&self) -> Option<&str> {
        match self {
            Self::File(path) => Some(path),
            Self::Table(_) => None,
        }
    }

    /// Returns the path of a mesh file, recognised by its ending.
    fn mesh_file(&self) -> Option<&str> {
        let path = self.file()?;
        let kind = Path::new(path).extension()?;
        let is_table = ["csv", "tsv"]
            .iter()
            .any(|table| kind.eq_ignore_ascii_case(table));
        (!is_table).then_some(path)
    }

    /// Reads the table; a missing file is an error at the key of its motion.
    fn read(&self, on: &OnMesh<'_>, key: &str) -> Result<Arc<Table>> {
        self.read_in(&on.folder, |message| on.error(key, message))
    }

    /// Reads the table, with files relative to a folder; `error` converts a message about the path to an error.
    pub(super) fn read_in(
        &self,
        folder: &Path,
        error: impl Fn(String) -> Error,
    ) -> Result<Arc<Table>> {
        match self {
            Self::File(file) => Ok(Arc::new(Table::read(file_in(folder, file, error)?)?)),
            Self::Table(table) => table.check().map(|()| Arc::clone(table)),
        }
    }
}
