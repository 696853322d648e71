//! A sequence of meshes in one file: coordinates and solutions of each step, what does not change
//! once; pointers of the zone to the nodes of each step, and times.

use super::super::{FIELD_POINTERS, FromAdf};
use super::arrays::{self, AT_CELLS, AT_NODES, OF_MESH};
use super::draft::Draft;
use super::faces::FaceTable;
use super::plan::{Numbering, sorted};
use super::series::{Series, names, padded, step_name};
use super::{BASE, BASE_DATA, SIMULATION, Static, TIMES, ZONE, add_coordinates};
use super::{cells_by_type, hdf5_for_adf};
use crate::formats::growing::hasher_of_cells;
use crate::formats::hdf5::{Element, Id, Links, Rows, StepFile, Tree};
use crate::formats::portable::not_taken;
use crate::formats::{Begin, Notes, SequenceFile, WriteOptions};
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::largest;
use std::path::Path;

/// Name of the node that describes how the nodes of a zone move.
const MOTION: &str = "ArbitraryGridMotion";

/// A sequence under work.
pub(in crate::formats::cgns) struct Sequence {
    file: StepFile,
    options: WriteOptions,
    notes: Notes,
    first: Option<First>,
    steps: Steps,
}

/// The nodes of each step.
struct Steps {
    n: usize,
    times: Rows,
    grids: Rows,
    motions: Rows,
    at_nodes: Series,
    at_cells: Series,
    fields: Series,
}

/// Children of the root, the base and the zone in the file, and what all steps share.
struct First {
    root: Links,
    base: Links,
    zone: Links,
    integer: Element,
    n_axes: usize,
    n_points: usize,
    cells: blake3::Hash,
}

impl Sequence {
    /// A file, which takes its name with the first mesh unless it has it.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin, sync: bool) -> Result<Self> {
        Ok(Self {
            file: StepFile::create(path, begin, sync)?,
            options: options.clone(),
            notes: Notes::default(),
            first: None,
            steps: Steps::new(),
        })
    }

    /// Writes what all steps share, or makes sure that a mesh has the nodes and cells of the first.
    fn fix(&mut self, mesh: &MeshView) -> Result<()> {
        let cells = hash_of(mesh);
        if let Some(first) = &self.first {
            if first.cells == cells && first.n_points == mesh.points.len() {
                return Ok(());
            }
            return Err(Error::input(format!(
                "step {} has other nodes or cells than the first step; all steps in one CGNS file must have the same; a list (OUT.pvd) has a file for each step",
                self.steps.n
            )));
        }
        let numbering = Numbering::of(mesh);
        let faces = FaceTable::of(mesh, &numbering);
        let mut fixed = Static::new(mesh, (&numbering, &faces), || is_flat(mesh))?;
        self.notes = fixed.notes;
        let (draft, base, zone) = (&mut fixed.draft, fixed.base, fixed.zone);
        draft.text(base, (SIMULATION, "SimulationType_t"), "TimeAccurate");
        draft.text(zone, (MOTION, "ArbitraryGridMotion_t"), "DeformingGrid");
        let mut store = |node, except| {
            let mut links = Links::default();
            let stored = self
                .file
                .store_children(&draft.tree, node, except, &mut links);
            stored.map(|()| links)
        };
        self.first = Some(First {
            root: store(Tree::ROOT, Some(base))?,
            base: store(base, Some(zone))?,
            zone: store(zone, None)?,
            integer: fixed.integer,
            n_axes: fixed.n_axes,
            n_points: mesh.points.len(),
            cells,
        });
        Ok(())
    }

    fn append_grid(&mut self, mesh: &MeshView) -> Result<()> {
        let first = self.first.as_mut().expect("the first step has set it");
        if first.n_axes == 2 && !is_flat(mesh) {
            return Err(Error::input(format!(
                "step {} is not in the plane z = 0 like the first step; the file holds x and y only",
                self.steps.n
            )));
        }
        let name = step_name("GridCoordinates", self.steps.n);
        let mut draft = Draft::part();
        let grid = draft.group(Tree::ROOT, (&name, "GridCoordinates_t"));
        add_coordinates(&mut draft, grid, mesh, &self.options, first.n_axes);
        let links = &mut first.zone;
        (self.file).store_children(&draft.tree, Tree::ROOT, None, links)?;
        self.steps.grids.push(&padded(&name));
        self.steps.motions.push(&padded(MOTION));
        Ok(())
    }
}

impl Steps {
    fn new() -> Self {
        Self {
            n: 0,
            times: Rows::new(Element::Float64, &[]),
            grids: names(),
            motions: names(),
            at_nodes: Series::new(AT_NODES),
            at_cells: Series::new(AT_CELLS),
            fields: Series::new(OF_MESH),
        }
    }

    /// Adds the arrays of a mesh; adds a note for each that is left out.
    fn append_arrays(
        &mut self,
        mesh: &MeshView,
        (file, first): (&mut StepFile, &mut First),
        notes: &mut Notes,
    ) -> Result<()> {
        let [of_mesh, at_nodes, at_cells] = arrays::all(mesh, notes);
        (self.fields).append(self.n, of_mesh, file, &mut first.base)?;
        for (series, arrays) in [
            (&mut self.at_nodes, at_nodes),
            (&mut self.at_cells, at_cells),
        ] {
            series.check_names(self.n, &arrays)?;
            series.append(self.n, arrays, file, &mut first.zone)?;
        }
        Ok(())
    }

    /// Puts into the file what grows with the steps.
    fn store(&mut self, file: &mut StepFile) -> Result<()> {
        for rows in [&mut self.times, &mut self.grids, &mut self.motions] {
            file.store_rows(rows)?;
        }
        for series in [&mut self.at_nodes, &mut self.at_cells, &mut self.fields] {
            if series.is_used() {
                file.store_rows(&mut series.pointers)?;
            }
        }
        Ok(())
    }

    /// Adds the node of the base that lists all steps.
    fn add_times<'a>(&'a self, draft: &mut Draft<'a>, base: Id) {
        let name = (TIMES, "BaseIterativeData_t");
        let times = draft.integers(base, name, (Element::Int32, &[1]), &[self.n as i64]);
        draft.rows(times, "TimeValues", Element::Float64, &self.times);
        if self.fields.is_used() {
            draft.rows(times, FIELD_POINTERS, Element::Int8, &self.fields.pointers);
        }
    }

    /// Adds the node of the zone that lists all steps.
    fn add_pointers<'a>(&'a self, draft: &mut Draft<'a>, zone: Id) {
        let data = draft.group(zone, ("ZoneIterativeData", "ZoneIterativeData_t"));
        let mut add = |name, rows| draft.rows(data, name, Element::Int8, rows);
        add("GridCoordinatesPointers", &self.grids);
        add("ArbitraryGridMotionPointers", &self.motions);
        let used = [&self.at_nodes, &self.at_cells].into_iter();
        let used = used.filter(|series| series.is_used());
        for (list, series) in ["FlowSolutionPointers", "FlowSolutionCellPointers"]
            .into_iter()
            .zip(used)
        {
            add(list, &series.pointers);
        }
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        let flattened = self.options.check_coordinates(mesh)?;
        let mut notes = Notes::default();
        notes.extend(mesh.origin.get::<FromAdf>().map(|_| hdf5_for_adf()));
        let sorted = sorted(mesh)?;
        let sorted_view = sorted.as_ref().map(|sorted| sorted.view());
        let mesh = sorted_view.as_ref().unwrap_or(mesh);
        self.fix(mesh)?;
        self.append_grid(mesh)?;
        notes.extend(sorted.iter().map(|_| cells_by_type()));
        let (file, steps) = (&mut self.file, &mut self.steps);
        let first = self.first.as_mut().expect("the first step has set it");
        steps.append_arrays(mesh, (file, first), &mut notes)?;
        if steps.n == 0 {
            self.notes.extend(notes);
            self.notes.extend(not_taken(mesh, "cgns"));
        }
        self.notes.extend(flattened);
        steps.n += 1;
        steps.times.push(&[time]);
        steps.store(file)?;
        for links in [&mut first.root, &mut first.base, &mut first.zone] {
            file.store_links(links)?;
        }
        let mut draft = Draft::root();
        draft.tree.links(Tree::ROOT, &first.root);
        let base = draft.stored(Tree::ROOT, BASE, BASE_DATA, &first.base);
        steps.add_times(&mut draft, base);
        let zone = draft.stored(base, ZONE, first.integer, &first.zone);
        steps.add_pointers(&mut draft, zone);
        file.finish_step(&draft.tree)
    }

    fn commit(&mut self) -> Result<()> {
        self.file.commit()
    }

    fn notes(&self) -> &Notes {
        &self.notes
    }

    fn n_bytes(&self) -> u64 {
        self.file.n_bytes()
    }

    fn end(&mut self) -> Result<bool> {
        self.file.end()
    }

    fn is_resuming(&self) -> bool {
        self.file.is_resuming()
    }
}

/// Tests if all nodes are in the plane z = 0, except for round-off of a rotation.
fn is_flat(mesh: &MeshView) -> bool {
    const ROUND_OFF: f64 = 1e-14;
    let points = mesh.points;
    let size = |axis: usize| largest(points.len(), |node| points[node][axis].abs());
    size(2) <= ROUND_OFF * size(0).max(size(1))
}

/// A hash of what must be the same at every step: cells and groups.
fn hash_of(mesh: &MeshView) -> blake3::Hash {
    let mut hasher = hasher_of_cells(mesh);
    for group in mesh.groups {
        hasher.update(group.name.as_bytes());
        hasher.update(&[group.dimension]);
        for range in group.cells.ranges() {
            hasher.update(bytemuck::cast_slice(&[range.start, range.end]));
        }
    }
    hasher.finalize()
}
