//! A file that takes one mesh after another: cells once, positions and arrays as they change.

use super::super::column::Data;
use super::super::hdf5::{Element, Links, Rows, StepFile, Tree};
use super::super::portable::not_taken;
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::order;
use super::super::{Begin, SequenceFile, WriteOptions};
use super::blocks::{Block, Blocks, NAMES, shape};
use super::series::Series;
use super::write::{Grid, POLYHEDRA, SEQUENCE};
use crate::formats::Notes;
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::path::Path;

/// A chunk of a dataset has less than 4 GB.
const MOST_CHUNK_BYTES: u64 = 1 << 31;
/// The group of arrays of the mesh as a whole.
const FIELDS: &str = "FieldData";
/// The times of the steps; how many parts the mesh of each has.
const VALUES: &str = "Values";
const PARTS: &str = "NumberOfParts";
/// Zeros written at a time.
const ZEROS: [u8; 4096] = [0; 4096];

/// A sequence under work.
pub(super) struct Sequence {
    file: StepFile,
    /// Most bytes of a chunk.
    pub chunk_limit: u64,
    options: WriteOptions,
    notes: Notes,
    n_steps: usize,
    topology: Option<Topology>,
    /// Positions, then the arrays.
    series: Vec<Series>,
    /// The datasets of `Steps` that every file has.
    columns: Vec<(&'static str, Rows)>,
}

/// Datasets that all steps share.
struct Topology {
    hash: blake3::Hash,
    has_polyhedra: bool,
    has_wedges: bool,
    counts: Vec<(&'static str, u64)>,
    datasets: Links,
}

impl Sequence {
    /// A file, which takes its name with the first mesh unless it has it.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin, sync: bool) -> Result<Self> {
        Ok(Self {
            file: StepFile::create(path, begin, sync)?,
            chunk_limit: MOST_CHUNK_BYTES,
            options: options.clone(),
            notes: Notes::default(),
            n_steps: 0,
            topology: None,
            series: Vec::new(),
            columns: Vec::new(),
        })
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        let flattened = self.options.check_coordinates(mesh)?;
        let options = self.options.clone();
        let plan = VtkArrays::new(mesh, &options, &NAMES);
        let blocks = Blocks::new(mesh, &plan);
        self.fix(mesh, &blocks)?;
        let arrays = std::iter::once(&blocks.points).chain(&blocks.arrays);
        for block in arrays {
            self.append_block(block)?;
        }
        if self.n_steps == 0 {
            self.notes.clone_from(&blocks.notes);
            self.notes.extend(not_taken(mesh, "vtkhdf"));
        }
        self.notes.extend(flattened);
        self.n_steps += 1;
        self.check_complete()?;
        self.append_columns(time)?;
        let topology = self.topology.as_ref().expect("the first step has set it");
        let grid = tree(topology, &self.series, &self.columns, self.n_steps);
        self.file.finish_step(&grid.tree)
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

impl Sequence {
    /// Writes the cells, or makes sure that they are those of the first step.
    fn fix(&mut self, mesh: &MeshView, blocks: &Blocks) -> Result<()> {
        let hash = hash_of(mesh);
        if let Some(topology) = &self.topology {
            let same = topology.hash == hash && topology.counts == blocks.counts;
            return match same {
                true => Ok(()),
                false => Err(Error::input(format!(
                    "step {} has other nodes, cells or shared boundary faces than the first step; all steps in one VTKHDF file must have the same",
                    self.n_steps
                ))),
            };
        }
        let mut datasets = Links::default();
        for (name, n) in &blocks.counts {
            let tree = Tree::of_dataset(Element::I64, &[1], Data::owned(&[*n as i64]));
            datasets.add(name, self.file.store_object(&tree)?)?;
        }
        for block in &blocks.cells {
            let column = &block.column;
            let stored = self.file.store(&column.data)?;
            let shape = [column.n_tuples as u64];
            let tree = Tree::of_dataset(column.element.into(), &shape, stored);
            datasets.add(column.name, self.file.store_object(&tree)?)?;
        }
        self.file.store_links(&mut datasets)?;
        let has_polyhedra = mesh.cells.has_polyhedra();
        self.columns = columns(has_polyhedra);
        self.topology = Some(Topology {
            hash,
            has_polyhedra,
            has_wedges: order::has_wedges(mesh.cells),
            counts: blocks.counts.clone(),
            datasets,
        });
        Ok(())
    }

    fn append_block(&mut self, block: &Block) -> Result<()> {
        let step = self.n_steps;
        let column = &block.column;
        let is_same = |s: &&mut Series| (s.group, &*s.name) == (block.group, column.name);
        let known = self.series.iter_mut().find(is_same);
        let series = match known {
            Some(series) => series,
            None if step == 0 => {
                self.series.push(Series::new(block, self.chunk_limit));
                self.series.last_mut().expect("it was just added")
            }
            None => return Err(changed(step, block, "is not in the first step")),
        };
        let block_shape = (column.n_tuples as u64, column.n_components as u64);
        if series.element != column.element.into()
            || (series.n_rows, series.n_components) != block_shape
        {
            return Err(changed(
                step,
                block,
                "has another type or length than in the first step",
            ));
        }
        let hash = column.data.hash()?;
        if series.last != Some(hash) {
            let stored = self.file.store(&column.data)?;
            pad(&mut self.file, series.padding())?;
            series.add(stored);
            series.object = match series.n_pieces {
                1 => {
                    let shape = shape(series.n_rows, series.n_components);
                    let tree = Tree::of_dataset(series.element, &shape, stored);
                    Some(self.file.store_object(&tree)?)
                }
                _ => None,
            };
            series.last = Some(hash);
        }
        let first_row = (series.n_pieces - 1) * series.stride();
        series.offsets.push(&[first_row as i64]);
        let sizes = [series.n_components as i64, series.n_rows as i64];
        series.sizes.push(&sizes);
        Ok(())
    }

    /// Puts a row of the step into each dataset of `Steps`.
    fn append_columns(&mut self, time: f64) -> Result<()> {
        for (name, column) in &mut self.columns {
            match *name {
                VALUES => column.push(&[time]),
                PARTS => column.push(&[1_i64]),
                _ => column.push(&[0_i64]),
            }
            self.file.store_rows(column)?;
        }
        for series in &mut self.series {
            self.file.store_rows(&mut series.offsets)?;
            if series.group == FIELDS {
                self.file.store_rows(&mut series.sizes)?;
            }
            if series.object.is_none() {
                self.file.store_index(&mut series.chunks)?;
            }
        }
        Ok(())
    }

    fn check_complete(&self) -> Result<()> {
        let n = self.n_steps;
        let is_short = |series: &&Series| series.offsets.n_rows() < n;
        match self.series.iter().find(is_short) {
            None => Ok(()),
            Some(series) => Err(Error::input(format!(
                "step {1} has no array \"{0}\"; all steps in one VTKHDF file must have the arrays of the first step",
                series.name,
                n - 1
            ))),
        }
    }
}

fn changed(step: usize, block: &Block, how: &str) -> Error {
    let name = block.column.name;
    Error::input(format!(
        "step {step}: the array \"{name}\" {how}; all steps in one VTKHDF file must have the same arrays"
    ))
}

/// The datasets of `Steps` of one number a step, but for those that belong to a series.
fn columns(has_polyhedra: bool) -> Vec<(&'static str, Rows)> {
    let mut names = vec![
        VALUES,
        PARTS,
        "PartOffsets",
        "CellOffsets",
        "ConnectivityIdOffsets",
    ];
    if has_polyhedra {
        names.extend([
            "FaceConnectivityOffsets",
            "FaceOffsetsOffsets",
            "PolyhedronToFaceIdOffsets",
        ]);
    }
    let element = |name| match name {
        VALUES => Element::F64,
        _ => Element::I64,
    };
    let column = |name| (name, Rows::new(element(name), &[]));
    names.into_iter().map(column).collect()
}

/// The content of the file as it is now.
fn tree<'a>(
    topology: &'a Topology,
    series: &'a [Series],
    columns: &'a [(&'static str, Rows)],
    n_steps: usize,
) -> Grid<'a> {
    let version = match topology.has_polyhedra {
        true => POLYHEDRA,
        false => SEQUENCE,
    };
    let mut grid = Grid::new(version, topology.has_wedges);
    grid.tree.links(grid.root, &topology.datasets);
    for series in series {
        series.add_to(&mut grid);
    }
    let steps = grid.group("Steps");
    let tree = &mut grid.tree;
    tree.number_attribute(steps, "NSteps", &[n_steps as i64], true);
    for (name, column) in columns {
        tree.rows(steps, name, column);
    }
    let groups = [
        ("PointData", "PointDataOffsets"),
        ("CellData", "CellDataOffsets"),
        (FIELDS, "FieldDataOffsets"),
    ];
    for (group, offsets) in groups {
        let offsets = tree.group(steps, offsets);
        for series in series.iter().filter(|series| series.group == group) {
            tree.rows(offsets, &series.name, &series.offsets);
        }
    }
    let sizes = tree.group(steps, "FieldDataSizes");
    for series in series.iter().filter(|series| series.group == FIELDS) {
        tree.rows(sizes, &series.name, &series.sizes);
    }
    if let Some(points) = series.iter().find(|series| series.group.is_empty()) {
        tree.rows(steps, "PointOffsets", &points.offsets);
    }
    grid
}

fn pad(file: &mut StepFile, mut n_bytes: u64) -> Result<()> {
    while n_bytes > 0 {
        let n = n_bytes.min(ZEROS.len() as u64);
        file.continue_with(&ZEROS[..n as usize])?;
        n_bytes -= n;
    }
    Ok(())
}

fn hash_of(mesh: &MeshView) -> blake3::Hash {
    let cells = mesh.cells;
    let mut hasher = blake3::Hasher::new();
    // What lies with several ranks is the same mesh at every step.
    if mesh.by_ranks.is_none() {
        hasher.update_rayon(bytemuck::cast_slice(cells.connectivity()));
    }
    for run in cells.runs() {
        let run_of = [
            u64::from(run.kind.vtk()),
            run.n_nodes as u64,
            run.n_cells() as u64,
        ];
        hasher.update(bytemuck::cast_slice(&run_of));
        if run.kind == crate::mesh::CellKind::Polyhedron {
            for cell in run.first_cell..run.first_cell + run.n_cells() {
                hasher.update(bytemuck::cast_slice(cells.face_stream(cell).unwrap_or(&[])));
            }
        }
    }
    hasher.finalize()
}
