//! Builds meshes in memory, and gives the properties of a mesh that users need.

use super::{Cells, DataArray, Group, Mesh};
use azimesh_core::error::Result;

impl Mesh {
    /// A mesh of nodes and cells, without tags and arrays.
    ///
    /// ```
    /// use azimesh_io::{CellKind, Cells, Mesh};
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mut cells = Cells::new();
    /// cells.push(CellKind::Triangle, &[0, 1, 2]);
    /// cells.push(CellKind::Line, &[0, 1]);
    /// let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mut mesh = Mesh::new(points, cells)?;
    /// mesh.add_tag("wall", [1])?;
    /// assert_eq!(mesh.tag_nodes("wall")?, [0, 1]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If a coordinate is not finite, or a cell names a node that does not exist.
    pub fn new(points: Vec<[f64; 3]>, cells: Cells) -> Result<Self> {
        let mesh = Self {
            points,
            cells,
            ..Self::default()
        };
        mesh.validate()?;
        Ok(mesh)
    }

    /// A mesh of nodes alone.
    pub(crate) fn of_points(points: Vec<[f64; 3]>) -> Self {
        Self {
            points,
            ..Self::default()
        }
    }

    /// Node coordinates, in the mesh's own unit.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
    /// assert!(mesh.points().iter().all(|point| point[2] == 0.0));
    /// # Ok(())
    /// # }
    /// ```
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Cells of every dimension, in file order: boundary faces are cells too.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
    /// let kinds = mesh.cells().runs().map(|run| (run.kind.name(), run.n_cells()));
    /// kinds.for_each(|(name, n)| println!("{n} of {name}"));
    /// # Ok(())
    /// # }
    /// ```
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// The boundary tags, in file order.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
    /// assert!(mesh.tags().any(|tag| tag.name == "airfoil"));
    /// # Ok(())
    /// # }
    /// ```
    pub fn tags(&self) -> impl Iterator<Item = &Group> + Clone {
        self.boundary_tags()
    }

    /// All arrays: at nodes, at cells, of the mesh as a whole.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = azimesh_io::Mesh::read("testdata/sphere_in_box_raw_zlib.vtu")?;
    /// assert!(mesh.arrays().any(|array| array.name == "radius"));
    /// # Ok(())
    /// # }
    /// ```
    pub fn arrays(&self) -> impl Iterator<Item = &DataArray> + Clone {
        let of_parts = self.point_arrays.iter().chain(&self.cell_arrays);
        of_parts.chain(&self.field_arrays)
    }

    /// Makes these cells, one dimension below the mesh's, a boundary tag. A cell may be in several.
    ///
    /// ```
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mut mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
    /// let airfoil = mesh.tags().find(|tag| tag.name == "airfoil").expect("it has one");
    /// let first = airfoil.cells.iter().next().expect("it has faces");
    /// mesh.add_tag("leading edge", [first])?;
    /// assert_eq!(mesh.tag_nodes("leading edge")?.len(), 2);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If a cell is not there, or is no face of the boundary.
    pub fn add_tag(
        &mut self,
        name: impl Into<String>,
        cells: impl IntoIterator<Item = usize>,
    ) -> Result<()> {
        let mut cells: Vec<usize> = cells.into_iter().collect();
        cells.sort_unstable();
        self.groups.push(Group::new(
            self.dimension().saturating_sub(1),
            name,
            None,
            cells.into_iter().collect(),
        ));
        let checked = self.validate_groups();
        if checked.is_err() {
            self.groups.pop();
        }
        checked
    }
}
