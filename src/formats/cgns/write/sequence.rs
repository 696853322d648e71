//! A sequence of meshes in one file: coordinates and solutions of each step, what does not change
//! once; pointers of the zone to those of each step, and times.

use super::super::super::hdf5::{Growing, Stored};
use super::super::super::{Begin, SequenceFile, WriteOptions};
use super::super::FULL_NAME;
use super::arrays::{AT_CELLS, AT_NODES, Scalar, scalars, volume_cells};
use super::draft::{Draft, Kind, Make, Place};
use super::faces::FaceTable;
use super::{SIMULATION, SORTED, Static, TIMES};
use super::{add_length_exponents, coordinates, plan};
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Mesh};
use std::path::Path;
use std::slice::from_ref;

/// A sequence under work.
pub(in crate::formats::cgns) struct Sequence {
    file: Growing,
    options: WriteOptions,
    notes: Vec<String>,
    first: Option<First>,
    times: Vec<f64>,
    grids: Vec<Vec<Array>>,
    at_nodes: Series,
    at_cells: Series,
}

/// What all steps share.
struct First {
    draft: Draft<'static>,
    base: Place,
    zone: Place,
    n_axes: usize,
    n_points: usize,
    cells: blake3::Hash,
}

/// An array in the file.
#[derive(Clone, PartialEq)]
struct Array {
    name: String,
    full_name: Option<String>,
    kind: Kind,
    n: usize,
    stored: Stored,
    hash: Option<blake3::Hash>,
}

/// Solutions at one kind of place.
struct Series {
    location: &'static str,
    /// The solutions there are, by name.
    solutions: Vec<(String, Vec<Array>)>,
    /// The solution of each step.
    of_steps: Vec<usize>,
}

impl Sequence {
    /// A file, which takes its name with the first mesh unless it has it.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin) -> Result<Self> {
        let series = |location| Series {
            location,
            solutions: Vec::new(),
            of_steps: Vec::new(),
        };
        Ok(Self {
            file: Growing::create(path, begin)?,
            options: options.clone(),
            notes: Vec::new(),
            first: None,
            times: Vec::new(),
            grids: Vec::new(),
            at_nodes: series("Vertex"),
            at_cells: series("CellCenter"),
        })
    }

    /// Writes what all steps share, or makes sure that a mesh has the nodes and cells of the first.
    fn fix(&mut self, mesh: &Mesh) -> Result<()> {
        let cells = hash_of(mesh);
        if let Some(first) = &self.first {
            return match first.cells == cells && first.n_points == mesh.points.len() {
                true => Ok(()),
                false => Err(Error::input(format!(
                    "step {} has other nodes or cells than the first; a sequence in one CGNS file has the \
                     same at every step",
                    self.times.len()
                ))),
            };
        }
        let faces = FaceTable::of(mesh);
        let parts = Static::new(mesh, &faces)?;
        self.notes = parts.notes;
        self.first = Some(First {
            base: parts.base,
            zone: parts.zone,
            n_axes: parts.n_axes,
            n_points: mesh.points.len(),
            cells,
            draft: parts.draft.store(&mut self.file)?,
        });
        Ok(())
    }

    fn append_grid(&mut self, mesh: &Mesh, n_axes: usize) -> Result<()> {
        let is_flat = n_axes == 3 || mesh.points.iter().all(|point| point[2] == 0.0);
        if !is_flat {
            return Err(Error::input(format!(
                "step {} leaves the plane z = 0, in which the first step lies; the file has x and y only",
                self.times.len()
            )));
        }
        let mut grid = Vec::new();
        for (name, kind, make) in coordinates(mesh, &self.options, n_axes) {
            grid.push(Array {
                name: name.to_owned(),
                full_name: None,
                kind,
                n: mesh.points.len(),
                stored: self.file.store(|sink| make(sink))?,
                hash: None,
            });
        }
        self.grids.push(grid);
        Ok(())
    }

    /// All that is in the file: what the steps share, and what each has of its own.
    fn steps(&self, first: &First) -> Draft<'static> {
        let mut draft = Draft::after(&first.draft);
        let n = self.times.len();
        let (base, zone) = (first.base, first.zone);
        let label = "BaseIterativeData_t";
        let times = draft.integers(base, (TIMES, label), Kind::I4, &[1], &[n as i64]);
        draft.reals(times, ("TimeValues", "DataArray_t"), &self.times);
        draft.text(base, SIMULATION, "SimulationType_t", "TimeAccurate");
        let mut grid_names = Vec::new();
        for (step, grid) in self.grids.iter().enumerate() {
            let name = step_name("GridCoordinates", step);
            let node = draft.group(zone, &name, "GridCoordinates_t");
            for array in grid {
                let array = array.add(&mut draft, node);
                add_length_exponents(&mut draft, array);
            }
            grid_names.push(name);
        }
        let motion = "ArbitraryGridMotion";
        draft.text(zone, motion, "ArbitraryGridMotion_t", "DeformingGrid");
        for series in [&self.at_nodes, &self.at_cells] {
            series.add(&mut draft, zone);
        }
        let iterative = draft.group(zone, "ZoneIterativeData", "ZoneIterativeData_t");
        draft.names(iterative, "GridCoordinatesPointers", &grid_names);
        let motions = vec![motion.to_owned(); n];
        draft.names(iterative, "ArbitraryGridMotionPointers", &motions);
        let mut lists = ["FlowSolutionPointers", "FlowSolutionCellPointers"].into_iter();
        for series in [&self.at_nodes, &self.at_cells] {
            if let (false, Some(list)) = (series.solutions.is_empty(), lists.next()) {
                let names = series.of_steps.iter();
                let names: Vec<String> = names.map(|&i| series.solutions[i].0.clone()).collect();
                draft.names(iterative, list, &names);
            }
        }
        draft
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &Mesh) -> Result<blake3::Hash> {
        self.options.check_coordinates(mesh)?;
        let sorted = plan::sorted(mesh)?;
        let mesh = sorted.as_ref().unwrap_or(mesh);
        self.fix(mesh)?;
        let n_axes = self.first.as_ref().map_or(3, |first| first.n_axes);
        self.append_grid(mesh, n_axes)?;
        let step = self.times.len();
        let everywhere = 0..mesh.points.len();
        let mut notes: Vec<String> = sorted.iter().map(|_| SORTED.to_owned()).collect();
        let at_nodes = scalars(&mesh.point_arrays, from_ref(&everywhere), &mut notes);
        self.at_nodes
            .append(AT_NODES, step, &at_nodes, &mut self.file)?;
        let at_cells = scalars(&mesh.cell_arrays, &volume_cells(mesh), &mut notes);
        self.at_cells
            .append(AT_CELLS, step, &at_cells, &mut self.file)?;
        if step == 0 {
            self.notes.append(&mut notes);
        }
        self.times.push(time);
        let first = self.first.as_ref().expect("the first step has set it");
        let steps = self.steps(first);
        self.file.finish_step(&first.draft.tree(Some(&steps)))
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn n_bytes(&self) -> u64 {
        self.file.n_bytes()
    }

    fn is_retracing(&self) -> bool {
        self.file.is_retracing()
    }
}

impl Series {
    /// Takes over the arrays of a step; those that are as in the step before are not written again.
    fn append(
        &mut self,
        name: &str,
        step: usize,
        scalars: &[Scalar],
        file: &mut Growing,
    ) -> Result<()> {
        if scalars.is_empty() && self.solutions.is_empty() {
            return Ok(());
        }
        let before = self.solutions.last().map(|(_, arrays)| &arrays[..]);
        let before = before.unwrap_or(&[]);
        let names = |arrays: &[Array]| arrays.iter().map(|a| a.name.clone()).collect::<Vec<_>>();
        let given: Vec<String> = scalars.iter().map(|scalar| scalar.name.clone()).collect();
        if step > 0 && names(before) != given {
            return Err(Error::input(format!(
                "step {step} has the arrays {}, the first step {}; a sequence in one CGNS file has the \
                 same at every step",
                given.join(", "),
                names(before).join(", ")
            )));
        }
        let mut arrays = Vec::new();
        for scalar in scalars {
            let hash = hash_of_bytes(&scalar.make())?;
            let same = before
                .iter()
                .find(|a| a.name == scalar.name && a.hash == Some(hash));
            let stored = match same {
                Some(array) => array.stored,
                None => {
                    let make = scalar.make();
                    file.store(|sink| make(sink))?
                }
            };
            arrays.push(Array {
                name: scalar.name.clone(),
                full_name: scalar.full_name.clone(),
                kind: scalar.kind,
                n: scalar.n,
                stored,
                hash: Some(hash),
            });
        }
        if before != arrays {
            self.solutions.push((step_name(name, step), arrays));
        }
        self.of_steps.push(self.solutions.len() - 1);
        Ok(())
    }

    fn add(&self, draft: &mut Draft, zone: Place) {
        for (name, arrays) in &self.solutions {
            let solution = draft.group(zone, name, "FlowSolution_t");
            draft.text(solution, "GridLocation", "GridLocation_t", self.location);
            for array in arrays {
                array.add(draft, solution);
            }
        }
    }
}

impl Array {
    fn add(&self, draft: &mut Draft, parent: Place) -> Place {
        let node = draft.stored(parent, &self.name, self.kind, self.n, self.stored);
        if let Some(full_name) = &self.full_name {
            draft.text(node, FULL_NAME, "Descriptor_t", full_name);
        }
        node
    }
}

/// The first step has the name that programs look for which know of no steps.
fn step_name(name: &str, step: usize) -> String {
    match step {
        0 => name.to_owned(),
        _ => format!("{name}#{step:04}"),
    }
}

fn hash_of_bytes(make: &Make) -> Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    make(&mut |bytes| {
        hasher.update(bytes);
        Ok(())
    })?;
    Ok(hasher.finalize())
}

/// What must be the same at every step: cells and groups.
fn hash_of(mesh: &Mesh) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for run in mesh.cells.runs() {
        hasher.update(&[run.kind.vtk()]);
        hasher.update(&(run.n_nodes as u64).to_le_bytes());
        hasher.update(&(run.n_cells() as u64).to_le_bytes());
    }
    hasher.update_rayon(bytemuck::cast_slice(mesh.cells.connectivity()));
    let polyhedra = mesh
        .cells
        .runs()
        .filter(|run| run.kind == CellKind::Polyhedron);
    for cell in polyhedra.flat_map(|run| run.first_cell..run.first_cell + run.n_cells()) {
        let stream = mesh.cells.face_stream(cell).unwrap_or(&[]);
        hasher.update(bytemuck::cast_slice(stream));
    }
    for group in &mesh.groups {
        hasher.update(group.name.as_bytes());
        hasher.update(&[group.dimension]);
        for range in group.cells.ranges() {
            hasher.update(&(range.start as u64).to_le_bytes());
            hasher.update(&(range.end as u64).to_le_bytes());
        }
    }
    hasher.finalize()
}
