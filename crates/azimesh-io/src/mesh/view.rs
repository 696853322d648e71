//! A borrowed view of a mesh for writers, with other node positions and arrays if needed.

use super::{
    Apart, CellRun, Cells, Coordinates, DataArray, Group, Mesh, NodesOfCells, Numbers,
    NumbersApart, Origin, groups, volume_dimension,
};

/// A mesh to write. Nothing of it is copied.
///
/// ```
/// # use azimesh_io::{CellKind, DataArray, Mesh, Values};
/// let mut mesh = Mesh { points: vec![[0.0; 3]; 3], ..Mesh::default() };
/// mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let heights = DataArray::scalar("Height", Values::F64(vec![0.0, 0.0, 1.0]));
/// let view = mesh.view().with_points(&points).with_point_array(&heights);
/// assert_eq!(view.points[1][0], 1.0);
/// assert_eq!(mesh.points[1][0], 0.0);
/// ```
#[derive(Debug, Clone)]
pub struct MeshView<'a> {
    /// Node coordinates.
    pub points: &'a [[f64; 3]],
    /// Cells of every dimension.
    pub cells: &'a Cells,
    /// Boundary tags, zones and groups of lower dimension.
    pub groups: &'a [Group],
    /// Arrays with one tuple a node.
    pub point_arrays: Vec<&'a DataArray>,
    /// Arrays with one tuple a cell.
    pub cell_arrays: Vec<&'a DataArray>,
    /// Arrays of the mesh as a whole.
    pub field_arrays: Vec<&'a DataArray>,
    /// See [`Mesh::space`].
    pub space: Option<u8>,
    /// See [`Mesh::origin`].
    pub origin: &'a Origin,
    /// The mesh itself, whatever positions and arrays it is viewed with.
    pub(crate) rest: &'a Mesh,
    /// The ranks that write coordinates, nodes of cells and some arrays, whose values are not here.
    #[doc(hidden)]
    pub by_ranks: Option<ByRanks<'a>>,
}

/// Values of nodes and cells that every rank writes.
#[derive(Debug, Clone, Copy)]
pub struct ByRanks<'a> {
    /// The ranks.
    pub by: &'a dyn Apart,
    /// The name of the array of displacements at the nodes, which ranks write too.
    pub displacement: Option<&'a str>,
    /// The name of the array of velocities at the nodes, which ranks write too.
    pub velocity: Option<&'a str>,
}

impl Mesh {
    /// A view of the unchanged mesh.
    pub fn view(&self) -> MeshView<'_> {
        MeshView {
            points: &self.points,
            cells: &self.cells,
            groups: &self.groups,
            point_arrays: self.point_arrays.iter().collect(),
            cell_arrays: self.cell_arrays.iter().collect(),
            field_arrays: self.field_arrays.iter().collect(),
            space: self.space,
            origin: &self.origin,
            rest: self,
            by_ranks: None,
        }
    }
}

impl<'a> MeshView<'a> {
    /// With the nodes at other positions.
    ///
    /// # Panics
    /// When there are not as many.
    #[must_use]
    pub fn with_points(self, points: &'a [[f64; 3]]) -> Self {
        assert_eq!(points.len(), self.points.len(), "one position a node");
        Self { points, ..self }
    }

    /// With values that ranks write: for formats that allow that
    /// ([`Format::takes_numbers_apart`](crate::formats::Format::takes_numbers_apart)).
    #[must_use]
    pub fn by_ranks(self, by: ByRanks<'a>) -> Self {
        Self {
            by_ranks: Some(by),
            ..self
        }
    }

    /// Coordinates that ranks write; `None` where they are here.
    pub(crate) fn coordinates_apart(&self, numbers: Coordinates) -> Option<NumbersApart<'a>> {
        self.of_nodes_apart(numbers, Numbers::Coordinates)
    }

    /// Values of an array of this view that ranks write, of a component or of all; `None` where they are here.
    pub(crate) fn values_apart(
        &self,
        array: &DataArray,
        component: Option<usize>,
    ) -> Option<NumbersApart<'a>> {
        let apart = self.by_ranks?;
        let of: fn(Coordinates) -> Numbers = match Some(&*array.name) {
            name if name == apart.displacement => Numbers::Displacements,
            name if name == apart.velocity => Numbers::Velocities,
            _ => return None,
        };
        let mut of_nodes = self.point_arrays.iter();
        let is_one = of_nodes.any(|of_nodes| std::ptr::eq(*of_nodes, array));
        let numbers = Coordinates::new(component, false);
        is_one.then(|| self.of_nodes_apart(numbers, of))?
    }

    fn of_nodes_apart(
        &self,
        numbers: Coordinates,
        of: fn(Coordinates) -> Numbers,
    ) -> Option<NumbersApart<'a>> {
        Some(NumbersApart {
            by: self.by_ranks?.by,
            n_bytes: (self.points.len() * numbers.size()) as u64,
            numbers: of(numbers),
        })
    }

    /// The nodes of cells that ranks write; `None` where they are here.
    pub(crate) fn nodes_apart(&self, numbers: NodesOfCells) -> Option<NumbersApart<'a>> {
        let by = self.by_ranks?.by;
        let n_numbers = numbers.n_numbers(self.cells, numbers.cells.clone());
        Some(NumbersApart {
            by,
            n_bytes: (n_numbers * numbers.size()) as u64,
            numbers: Numbers::Nodes(numbers),
        })
    }

    /// Replaces the node array of this name, or appends it.
    ///
    /// # Panics
    /// When it does not have one tuple per node.
    #[must_use]
    pub fn with_point_array(mut self, array: &'a DataArray) -> Self {
        assert_eq!(array.n_tuples(), self.points.len(), "one tuple a node");
        put(&mut self.point_arrays, array);
        self
    }

    /// Replaces the cell array of this name, or appends it.
    ///
    /// # Panics
    /// When it does not have one tuple per cell.
    #[must_use]
    pub fn with_cell_array(mut self, array: &'a DataArray) -> Self {
        assert_eq!(array.n_tuples(), self.cells.len(), "one tuple a cell");
        put(&mut self.cell_arrays, array);
        self
    }

    /// See [`Mesh::dimension`].
    pub fn dimension(&self) -> u8 {
        volume_dimension(self.cells, self.space)
    }

    /// The boundary tags, in file order.
    pub fn boundary_tags(&self) -> impl Iterator<Item = &'a Group> + Clone + use<'a> {
        groups::boundary_tags(self.groups, self.dimension())
    }

    /// The zones, in file order.
    pub fn zones(&self) -> impl Iterator<Item = &'a Group> + Clone + use<'a> {
        groups::zones(self.groups, self.dimension())
    }

    /// Runs of the cells with the mesh's own dimension.
    pub fn volume_runs(&self) -> impl Iterator<Item = CellRun<'a>> + Clone + use<'a> {
        let (cells, dimension) = (self.cells, self.dimension());
        let runs = cells.runs();
        runs.filter(move |run| run.kind.dimension() == dimension)
    }

    /// Smallest and largest coordinates; `None` without nodes.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        super::bounds(self.points)
    }

    /// All arrays: at nodes, at cells, of the mesh as a whole.
    pub fn arrays(&self) -> impl Iterator<Item = &'a DataArray> + Clone {
        let of_parts = self.point_arrays.iter().chain(&self.cell_arrays);
        of_parts.chain(&self.field_arrays).copied()
    }

    /// The field array of this name.
    pub fn field_array(&self, name: &str) -> Option<&'a DataArray> {
        let mut arrays = self.field_arrays.iter().copied();
        arrays.find(|array| array.name == name)
    }
}

fn put<'a>(arrays: &mut Vec<&'a DataArray>, array: &'a DataArray) {
    match arrays.iter_mut().find(|old| old.name == array.name) {
        Some(old) => *old = array,
        None => arrays.push(array),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Values;
    use super::*;

    #[test]
    fn an_array_takes_the_place_of_that_of_its_name_or_comes_last() {
        let array = |name: &str, x: f64| DataArray::scalar(name, Values::F64(vec![x]));
        let mesh = Mesh {
            points: vec![[0.0; 3]],
            point_arrays: vec![array("a", 1.0), array("b", 2.0)],
            ..Mesh::default()
        };
        let (points, a, c) = ([[1.0; 3]], array("a", 3.0), array("c", 4.0));
        let view = mesh.view().with_points(&points);
        let view = view.with_point_array(&a).with_point_array(&c);
        assert_eq!(view.points, points);
        assert_eq!(view.point_arrays, [&a, &mesh.point_arrays[1], &c]);
        assert_eq!(mesh.points, [[0.0; 3]]);
    }
}
