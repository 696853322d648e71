//! The files of the moving surfaces of a run: their nodes, writing them next to the mesh of a step, and checking them against
//! the mesh. Knows nothing of the file format.

use super::names::Names;
use super::outputs::foreign_file;
use crate::record::Row;
use azimesh_core::error::Result;
use azimesh_deform::Plan;
use azimesh_deform::motion::{Role, SurfaceOutput};
use azimesh_io::formats::{
    Format, Location, OutputSet, ReadOptions, Staged, read_as, read_file, write_su2_surface,
};
use azimesh_io::mesh::MeshView;

/// The nodes of the moving surfaces.
pub(super) struct SurfaceFiles {
    /// Nodes of all tags that move with a body, ascending.
    nodes: Vec<u32>,
}

impl SurfaceFiles {
    /// The files that the schedule asks for; `None` if it asks for none.
    pub fn of(plan: &Plan) -> Result<Option<Self>> {
        if plan.schedule.output.surface == SurfaceOutput::None {
            return Ok(None);
        }
        let tags = plan.boundary.boundary_tags().zip(&plan.motion.surface.tags);
        let moving = tags.filter(|(_, tag)| matches!(tag.role, Some(Role::Moving(_))));
        let mut nodes: Vec<u32> = moving
            .flat_map(|(tag, _)| plan.boundary.nodes_of(tag))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(Some(Self { nodes }))
    }

    /// The file of a step, staged.
    pub fn stage(&self, mesh: &MeshView, names: &Names, step: usize) -> Result<Staged> {
        let path = names.path(&names.surface(step));
        let mut out = OutputSet::new(&path, names.commit);
        out.main(|out| write_su2_surface(mesh, &self.nodes, out))?;
        Ok(out.finish().files)
    }

    /// Refuses to replace a file with the name of the file of a step, and other content.
    pub fn check_own(&self, mesh: &MeshView, names: &Names, step: usize) -> Result<()> {
        let path = names.path(&names.surface(step));
        let Ok(found) = read_file(&path) else {
            return Ok(());
        };
        let mut text = Vec::new();
        write_su2_surface(mesh, &self.nodes, &mut text)?;
        if found == text {
            return Ok(());
        }
        Err(foreign_file(&path))
    }

    /// Checks if the file of a step agrees with the mesh of the step, which is whole.
    pub fn is_there(&self, names: &Names, format: &'static Format, row: &Row) -> bool {
        let text = || {
            let location = Location::open(&names.path(&row.file)).ok()?;
            let loaded = read_as(format, &location, &ReadOptions::default()).ok()?;
            let mesh = loaded.mesh;
            let last = self.nodes.last().map_or(0, |last| *last as usize);
            let mut text = Vec::new();
            let written = (last < mesh.points.len())
                .then(|| write_su2_surface(&mesh.view(), &self.nodes, &mut text))?;
            written.ok().map(|()| text)
        };
        let found = read_file(&names.path(&names.surface(row.step)));
        found.is_ok_and(|found| text() == Some(found))
    }
}
