//! The class `Mesh`: read-only views of a mesh of the library, and files.

use crate::arrays::{Views, frozen, indices, owned};
use crate::background::done;
use crate::error::{input, raised, warn};
use crate::make::{Parts, make};
use crate::{arguments, kinds};
use azimesh::{
    CellKind, Compression, DataArray, Encoding, Group, Mesh, Precision, ReadOptions, WriteOptions,
};
use azimesh_io::formats::{self, Commit, KeptInputs, openfoam};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyMappingProxy, PyTuple};
use std::path::PathBuf;
use std::sync::Arc;

/// An unstructured mesh: nodes, cells in file order, boundary tags, zones, arrays. It never changes.
///
/// ``Mesh(points, cells, *, tags, zones, point_data, cell_data, field_data)`` makes one: points (n, 3), cells as a dict or
/// as a list of (type, (m, nodes)) by meshio's names, in order; tags and zones as numbers of cells by name.
#[pyclass(frozen, weakref, module = "azimesh", name = "Mesh")]
pub struct PyMesh {
    pub mesh: Arc<Mesh>,
    /// Where it was read from, as it is there.
    pub path: Option<PathBuf>,
    /// Further files that were read for it: pieces, linked files, conditions of tags.
    pub files: Vec<PathBuf>,
    #[pyo3(get)]
    format: Option<&'static str>,
    cells: PyOnceLock<Py<PyMappingProxy>>,
    cell_index: PyOnceLock<Py<PyMappingProxy>>,
}

impl PyMesh {
    /// A mesh that was made in memory.
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Self {
        Self {
            mesh: mesh.into(),
            path: None,
            files: Vec::new(),
            format: None,
            cells: PyOnceLock::new(),
            cell_index: PyOnceLock::new(),
        }
    }

    /// The same mesh in a new value, to be given other arrays or positions.
    fn changed(&self, py: Python<'_>, change: impl FnOnce(&mut Mesh)) -> PyResult<Self> {
        let mut mesh = (*self.mesh).clone();
        change(&mut mesh);
        mesh.validate().map_err(|error| raised(py, &error))?;
        Ok(Self::new(mesh))
    }
}

#[pymethods]
impl PyMesh {
    #[new]
    #[pyo3(signature = (points, cells, *, tags=None, zones=None, point_data=None, cell_data=None, field_data=None))]
    fn from_arrays(
        points: &Bound<'_, PyAny>,
        cells: &Bound<'_, PyAny>,
        tags: Option<&Bound<'_, PyDict>>,
        zones: Option<&Bound<'_, PyDict>>,
        point_data: Option<&Bound<'_, PyDict>>,
        cell_data: Option<&Bound<'_, PyDict>>,
        field_data: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let parts = Parts {
            tags,
            zones,
            point_data,
            cell_data,
            field_data,
        };
        Ok(Self::new(make(points, cells, &parts)?))
    }

    /// Node coordinates (n, 3), float64, in mesh units: a read-only view without a copy.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        // SAFETY: the values are the mesh's own.
        unsafe { Views::of(py, &self.mesh)?.rows(self.mesh.points.as_flattened(), 3) }
    }

    /// Dimension of the volume cells: 2 or 3, 0 for a cloud of points.
    #[getter]
    fn dimension(&self) -> u8 {
        self.mesh.dimension()
    }

    /// Number of nodes n.
    #[getter]
    fn n_points(&self) -> usize {
        self.mesh.points.len()
    }

    /// Number of cells, boundary faces included.
    #[getter]
    fn n_cells(&self) -> usize {
        self.mesh.cells.len()
    }

    /// Smallest and largest coordinates, ([x, y, z], [x, y, z]); None without nodes.
    #[getter]
    fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        self.mesh.bounds()
    }

    /// The file it was read from; None for a mesh made in memory.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.path.clone()
    }

    /// Cells by meshio's names of their types: node numbers (m, nodes), uint32, in VTK's order.
    ///
    /// A read-only view without a copy where the cells of a type follow one another in the file. Polygons are
    /// ``(nodes, offsets)``, polyhedra ``(faces, offsets)``: those of cell i are ``values[offsets[i]:offsets[i + 1]]``, faces as
    /// VTK's stream of (number of faces, then for each its number of nodes and the nodes).
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyMappingProxy>> {
        let made = self.cells.get_or_try_init(py, || {
            let blocks = PyDict::new(py);
            let views = Views::of(py, &self.mesh)?;
            for (name, kind, n_nodes) in self.kinds() {
                blocks.set_item(name, self.block(py, &views, kind, n_nodes)?)?;
            }
            PyResult::Ok(PyMappingProxy::new(py, blocks.as_mapping()).unbind())
        })?;
        Ok(made.bind(py).clone())
    }

    /// Numbers (m,) of the cells of each type among all cells, in the order of `cells`.
    #[getter]
    fn cell_index<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyMappingProxy>> {
        let made = self.cell_index.get_or_try_init(py, || {
            let places = PyDict::new(py);
            for (name, kind, n_nodes) in self.kinds() {
                let runs = self.runs(kind, n_nodes);
                let cells = runs.flat_map(|run| run.first_cell..run.first_cell + run.n_cells());
                places.set_item(name, frozen(indices(py, cells))?)?;
            }
            PyResult::Ok(PyMappingProxy::new(py, places.as_mapping()).unbind())
        })?;
        Ok(made.bind(py).clone())
    }

    /// Boundary tags: numbers of their faces among all cells, ascending, by name.
    #[getter]
    fn tags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, self.mesh.tags())
    }

    /// Zones: numbers of their cells among all cells, ascending, by name.
    #[getter]
    fn zones<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, self.mesh.zones())
    }

    /// Type of the boundary condition of each tag where the file gives one, such as ``BCWallViscous``.
    #[getter]
    fn conditions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for tag in self.mesh.tags() {
            found.set_item(&tag.name, &tag.condition)?;
        }
        Ok(found)
    }

    /// Sorted numbers of the nodes of a boundary tag.
    ///
    /// Raises `Error` where there is no such tag, with those that there are.
    fn tag_nodes<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let nodes = self.mesh.tag_nodes(name);
        let nodes = nodes.map_err(|error| raised(py, &error))?;
        Ok(indices(py, nodes.into_iter().map(|node| node as usize)))
    }

    /// Faces of a boundary tag: node numbers (m, nodes) by type of face.
    fn tag_faces<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        self.mesh
            .tag_nodes(name)
            .map_err(|error| raised(py, &error))?;
        let mut blocks: Vec<(CellKind, usize, Vec<u32>)> = Vec::new();
        let tags = self.mesh.tags().filter(|tag| tag.name == name);
        for cell in tags.flat_map(|tag| tag.cells.iter()) {
            let cell = self.mesh.cells.get(cell);
            let n_nodes = cell.nodes.len();
            let known = blocks
                .iter_mut()
                .find(|(kind, n, _)| (*kind, *n) == (cell.kind, n_nodes));
            match known {
                Some((_, _, nodes)) => nodes.extend(cell.nodes),
                None => blocks.push((cell.kind, n_nodes, cell.nodes.to_vec())),
            }
        }
        let found = PyDict::new(py);
        for (kind, n_nodes, nodes) in blocks {
            let name = match kind.n_nodes() {
                Some(_) => kinds::name(kind).to_owned(),
                None => format!("{}{n_nodes}", kinds::name(kind)),
            };
            found.set_item(name, crate::arrays::owned_rows(py, nodes, n_nodes)?)?;
        }
        Ok(found)
    }

    /// Arrays at nodes, (n,) or (n, components): read-only views without a copy, in the type of the file; text as lists.
    #[getter]
    fn point_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays(py, &self.mesh.point_arrays)
    }

    /// Arrays at cells, (n_cells,) or (n_cells, components), in the order of the cells in the file.
    #[getter]
    fn cell_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays(py, &self.mesh.cell_arrays)
    }

    /// Arrays of the mesh as a whole.
    #[getter]
    fn field_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays(py, &self.mesh.field_arrays)
    }

    /// The same mesh with its nodes at `points` (n, 3), in mesh units.
    ///
    /// Raises `Error` where the shape is another one, or a coordinate is not finite.
    fn with_points(&self, py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = arguments::vectors(points, "points")?;
        if points.len() != self.mesh.points.len() {
            let (found, n) = (points.len(), self.mesh.points.len());
            return Err(input(
                py,
                format!(
                    "there are {found} points; the mesh has {n} nodes (where zones turn, nodes of their interface are there twice: \
                     use `deformation.mesh.with_points`)"
                ),
            ));
        }
        self.changed(py, |mesh| mesh.points = points)
    }

    /// The same mesh with further arrays, in the place of those of the same name.
    #[pyo3(signature = (*, point_data=None, cell_data=None))]
    fn with_data(
        &self,
        py: Python<'_>,
        point_data: Option<&Bound<'_, PyDict>>,
        cell_data: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let at_points = data_arrays(point_data)?;
        let at_cells = data_arrays(cell_data)?;
        self.changed(py, |mesh| {
            put_all(&mut mesh.point_arrays, at_points);
            put_all(&mut mesh.cell_arrays, at_cells);
        })
    }

    /// The mesh as `pyvista.UnstructuredGrid`, with tags and zones as the cell arrays ``BoundaryTag`` and ``Zone``.
    fn to_pyvista<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_module(slf, "azimesh._pyvista", "to_pyvista")
    }

    /// The mesh as `meshio.Mesh`, with tags and zones as its ``cell_sets``.
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_module(slf, "azimesh._meshio", "to_meshio")
    }

    /// Shows the mesh with pyvista; options are those of `pyvista.plot`.
    #[pyo3(signature = (**options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        Self::to_pyvista(slf)?.call_method("plot", (), options)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_module(slf, "azimesh._html", "table")
    }

    fn __repr__(&self) -> String {
        let tags: Vec<&str> = self.mesh.tags().map(|tag| tag.name.as_str()).collect();
        format!(
            "<azimesh.Mesh: {} points, {} cells, dimension {}, tags {}>",
            self.mesh.points.len(),
            self.mesh.cells.len(),
            self.mesh.dimension(),
            if tags.is_empty() {
                "none".to_owned()
            } else {
                tags.join(", ")
            },
        )
    }
}

impl PyMesh {
    /// Kinds of cells in the order of their first cells, with their key and their number of nodes (0 where they
    /// differ).
    fn kinds(&self) -> Vec<(String, CellKind, usize)> {
        let mut found: Vec<(CellKind, usize)> = Vec::new();
        for run in self.mesh.cells.runs() {
            let ragged = matches!(run.kind, CellKind::Polygon | CellKind::Polyhedron);
            let n_nodes = if ragged { 0 } else { run.n_nodes };
            if !found.contains(&(run.kind, n_nodes)) {
                found.push((run.kind, n_nodes));
            }
        }
        let alike = |kind| found.iter().filter(|(other, _)| *other == kind).count();
        let key = |&(kind, n_nodes): &(CellKind, usize)| {
            let name = kinds::name(kind);
            let key = match alike(kind) {
                1 => name.to_owned(),
                _ => format!("{name}{n_nodes}"),
            };
            (key, kind, n_nodes)
        };
        found.iter().map(key).collect()
    }

    fn runs(
        &self,
        kind: CellKind,
        n_nodes: usize,
    ) -> impl Iterator<Item = azimesh_io::mesh::CellRun<'_>> + Clone {
        let runs = self.mesh.cells.runs();
        runs.filter(move |run| run.kind == kind && (n_nodes == 0 || run.n_nodes == n_nodes))
    }

    /// Cells of a kind: (m, nodes), a view where they follow one another; of polygons and polyhedra
    /// `(nodes or faces, offsets)`.
    fn block<'py>(
        &self,
        py: Python<'py>,
        views: &Views<'py>,
        kind: CellKind,
        n_nodes: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut runs = self.runs(kind, n_nodes);
        if n_nodes == 0 {
            return self.ragged(py, kind);
        }
        match (runs.next(), runs.next()) {
            // SAFETY: the connectivity is the mesh's own.
            (Some(only), None) => unsafe { views.rows(only.connectivity, n_nodes) },
            _ => {
                let runs = self.runs(kind, n_nodes);
                let nodes = runs.flat_map(|run| run.connectivity).copied().collect();
                frozen(crate::arrays::owned_rows(py, nodes, n_nodes)?)
            }
        }
    }

    fn ragged<'py>(&self, py: Python<'py>, kind: CellKind) -> PyResult<Bound<'py, PyAny>> {
        let (mut values, mut offsets) = (Vec::<u32>::new(), vec![0]);
        for cell in self.runs(kind, 0).flat_map(|run| run.cell_refs()) {
            match self.mesh.cells.face_stream(cell.index) {
                Some(stream) => values.extend(stream),
                None => values.extend(cell.nodes),
            }
            offsets.push(values.len());
        }
        let pair = [frozen(owned(py, values))?, frozen(indices(py, offsets))?];
        Ok(PyTuple::new(py, pair)?.into_any())
    }

    fn arrays<'py>(&self, py: Python<'py>, arrays: &[DataArray]) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let views = Views::of(py, &self.mesh)?;
        for array in arrays {
            // SAFETY: the values are the mesh's own.
            let values = unsafe { views.values(&array.values, array.n_components) }?;
            found.set_item(&array.name, values)?;
        }
        Ok(found)
    }
}

/// What a function of the package makes of a mesh.
fn by_module<'py>(
    mesh: &Bound<'py, PyMesh>,
    module: &str,
    function: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let module = mesh.py().import(module)?;
    module.call_method1(function, (mesh,))
}

/// Numbers of cells by the names of groups; groups of one name are one.
fn by_name<'a, 'py>(
    py: Python<'py>,
    groups: impl Iterator<Item = &'a Group> + Clone,
) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    for group in groups.clone() {
        let alike = groups.clone().filter(|other| other.name == group.name);
        let mut cells: Vec<usize> = alike.flat_map(|group| group.cells.iter()).collect();
        cells.sort_unstable();
        cells.dedup();
        found.set_item(&group.name, indices(py, cells))?;
    }
    Ok(found)
}

/// Arrays by their names, as the library's.
pub fn data_arrays(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<DataArray>> {
    let mut arrays = Vec::new();
    for (name, values) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let (values, n) = arguments::values(&values, &format!("array \"{name}\""))?;
        arrays.push(DataArray::tuples(name, n, values));
    }
    Ok(arrays)
}

fn put_all(arrays: &mut Vec<DataArray>, new: Vec<DataArray>) {
    for array in new {
        match arrays.iter_mut().find(|known| known.name == array.name) {
            Some(known) => *known = array,
            None => arrays.push(array),
        }
    }
}

/// Reads a mesh of any format that azimesh knows, by its content; `step` of a sequence, the last unless given.
///
/// `tag_array` names the cell array that holds the boundary tags, where it has no known name. What the mesh does not hold
/// of the file is told by warnings of class `Note`. Raises `Error` with the place in the file.
#[pyfunction]
#[pyo3(signature = (path, *, step=None, tag_array=None))]
pub fn read(
    py: Python<'_>,
    path: PathBuf,
    step: Option<usize>,
    tag_array: Option<String>,
) -> PyResult<PyMesh> {
    let options = ReadOptions { tag_array, step };
    let from = path.clone();
    let (loaded, mut files) = done(py, None, move || {
        let _kept = KeptInputs::begin();
        let loaded = Mesh::read_with(from, &options)?;
        // A case counts as one file.
        let is_case = !openfoam::files_of_origin(&loaded.mesh).is_empty();
        let files = (!is_case).then(formats::opened_inputs);
        Ok((loaded, files.unwrap_or_default()))
    })?;
    files.retain(|file| *file != path);
    warn(py, loaded.notes.iter())?;
    Ok(PyMesh {
        path: (path.as_os_str() != "-").then_some(path),
        files,
        format: Some(loaded.format.name),
        ..PyMesh::new(loaded.mesh)
    })
}

/// Writes a mesh in the format of the path's ending, or in `format`; completely or not at all. A file is replaced.
///
/// What the format cannot hold is told by warnings of class `Note`.
#[pyfunction]
#[pyo3(signature = (mesh, path, *, format=None, encoding="raw", compression="none", precision="f64", tag_names=true))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn write(
    py: Python<'_>,
    mesh: &PyMesh,
    path: PathBuf,
    format: Option<&str>,
    encoding: &str,
    compression: &str,
    precision: &str,
    tag_names: bool,
) -> PyResult<()> {
    let format = match format {
        Some(name) => formats::by_name(name),
        None => formats::by_extension(&path),
    };
    let format = format.map_err(|error| raised(py, &error))?;
    let options = WriteOptions {
        encoding: choice(py, "encoding", encoding, &ENCODINGS)?,
        compression: choice(py, "compression", compression, &COMPRESSIONS)?,
        precision: choice(py, "precision", precision, &PRECISIONS)?,
        tag_names,
        ..WriteOptions::default()
    };
    let mesh = Arc::clone(&mesh.mesh);
    let notes = done(py, None, move || {
        formats::save(&mesh.view(), &path, format, &options, Commit::REPLACE)
    })?;
    warn(py, notes.iter())
}

const ENCODINGS: [(&str, Encoding); 3] = [
    ("raw", Encoding::Raw),
    ("base64", Encoding::Base64),
    ("ascii", Encoding::Ascii),
];

const COMPRESSIONS: [(&str, Compression); 4] = [
    ("none", Compression::None),
    ("zlib", Compression::Zlib),
    ("lz4", Compression::Lz4),
    ("lzma", Compression::Lzma),
];

const PRECISIONS: [(&str, Precision); 2] = [("f64", Precision::F64), ("f32", Precision::F32)];

/// The value of a word.
pub fn choice<T: Copy>(
    py: Python<'_>,
    option: &str,
    word: &str,
    known: &[(&str, T)],
) -> PyResult<T> {
    let found = known.iter().find(|(name, _)| *name == word);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        let names = names.join(", ");
        input(
            py,
            format!("{option} is \"{word}\"; it must be one of {names}"),
        )
    })
}
