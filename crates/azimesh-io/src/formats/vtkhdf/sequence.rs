//! A file that takes one mesh after another: cells once, positions and arrays as they change.

use super::super::column::Data;
use super::super::growing::hasher_of_cells;
use super::super::hdf5::{Chunks, Element, Links, Payload, Rows, StepFile, Stored, Tree, size};
use super::super::portable::not_taken;
use super::super::vtk::arrays::VtkArrays;
use super::super::vtk::order;
use super::super::{Begin, SequenceFile, WriteOptions};
use super::blocks::{Block, Blocks, NAMES, shape};
use super::write::Grid;
use crate::formats::Notes;
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::path::Path;

/// A chunk of a dataset has less than 4 GB.
const MOST_CHUNK_BYTES: u64 = 1 << 31;
/// The first version of the format with sequences.
const VERSION: [i64; 2] = [2, 0];
/// The group of arrays of the mesh as a whole.
const FIELDS: &str = "FieldData";
/// The times of the steps; how many parts the mesh of each has.
const VALUES: &str = "Values";
const PARTS: &str = "NumberOfParts";
/// Datasets of `Steps` of one number per step, except for a series; then the datasets of polyhedra.
const COLUMNS: [&str; 8] = [
    VALUES,
    PARTS,
    "PartOffsets",
    "CellOffsets",
    "ConnectivityIdOffsets",
    "FaceConnectivityOffsets",
    "FaceOffsetsOffsets",
    "PolyhedronToFaceIdOffsets",
];
/// Zeros written at a time.
const ZEROS: [u8; 4096] = [0; 4096];

/// A sequence under work.
pub(super) struct Sequence {
    file: StepFile,
    /// Most bytes of a chunk.
    pub chunk_limit: u64,
    options: WriteOptions,
    notes: Notes,
    content: Content,
}

/// All that is in the file so far.
#[derive(Default)]
struct Content {
    n_steps: usize,
    topology: Option<Topology>,
    /// Positions, then the arrays.
    series: Vec<Series>,
    /// The datasets of [`COLUMNS`].
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

/// A dataset to which a step adds rows, unless they equal the rows of the step before.
struct Series {
    group: &'static str,
    name: String,
    element: Element,
    n_rows: u64,
    n_components: u64,
    /// Rows of a chunk, and chunks of a step.
    chunk_rows: u64,
    n_chunks: u64,
    n_pieces: u64,
    chunks: Chunks,
    last: Option<blake3::Hash>,
    /// The whole dataset as long as all steps have the rows of the first.
    object: Option<Stored>,
    /// The first row of each step.
    offsets: Rows,
    /// Of an array of the mesh as a whole, its components and rows at each step.
    sizes: Rows,
}

impl Sequence {
    /// A file, which takes its name with the first mesh unless it has it.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin, sync: bool) -> Result<Self> {
        Ok(Self {
            file: StepFile::create(path, begin, sync)?,
            chunk_limit: MOST_CHUNK_BYTES,
            options: options.clone(),
            notes: Notes::default(),
            content: Content::default(),
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
        for block in &blocks.arrays {
            self.append_block(block)?;
        }
        if self.content.n_steps == 0 {
            self.notes.clone_from(&blocks.notes);
            self.notes.extend(not_taken(mesh, "vtkhdf"));
        }
        self.notes.extend(flattened);
        self.content.n_steps += 1;
        self.append_columns(time)?;
        self.file.finish_step(&self.content.grid().tree)
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
    /// Writes the cells, or verifies that they equal the cells of the first step.
    fn fix(&mut self, mesh: &MeshView, blocks: &Blocks) -> Result<()> {
        let hash = hasher_of_cells(mesh).finalize();
        if let Some(topology) = &self.content.topology {
            if topology.hash == hash && topology.counts == blocks.counts {
                return Ok(());
            }
            return Err(Error::input(format!(
                "step {} has other nodes, cells or shared boundary faces than the first step; all steps in one VTKHDF file must have the same; a list (OUT.pvd) has a file for each step",
                self.content.n_steps
            )));
        }
        let mut datasets = Links::default();
        for (name, n) in &blocks.counts {
            let tree = Tree::of_dataset(Element::Int64, &[1], Data::owned(&[*n as i64]));
            datasets.add(name, self.file.store_object(&tree)?)?;
        }
        for Block { column, .. } in &blocks.cells {
            let stored = self.file.store(&column.data)?;
            let shape = [column.n_tuples as u64];
            let tree = Tree::of_dataset(column.element, &shape, stored);
            datasets.add(column.name, self.file.store_object(&tree)?)?;
        }
        self.file.store_links(&mut datasets)?;
        let has_polyhedra = mesh.cells.has_polyhedra();
        let names = &COLUMNS[..if has_polyhedra { 8 } else { 5 }];
        let columns = names.iter().map(|&name| match name {
            VALUES => (name, Rows::new(Element::Float64, &[])),
            _ => (name, Rows::new(Element::Int64, &[])),
        });
        self.content.columns = columns.collect();
        self.content.topology = Some(Topology {
            hash,
            has_polyhedra,
            has_wedges: order::has_wedges(mesh.cells),
            counts: blocks.counts.clone(),
            datasets,
        });
        Ok(())
    }

    fn append_block(&mut self, block: &Block) -> Result<()> {
        let (column, step) = (&block.column, self.content.n_steps);
        let changed = |how: &str| {
            Err(Error::input(format!(
                "step {step}: the array \"{}\" {how}; all steps in one VTKHDF file must have the same arrays",
                column.name
            )))
        };
        let all = &mut self.content.series;
        let is_same = |s: &Series| (s.group, &*s.name) == (block.group, column.name);
        let at = all.iter().position(is_same).unwrap_or(all.len());
        if at == all.len() {
            if step > 0 {
                return changed("is not in the first step");
            }
            all.push(Series::new(block, self.chunk_limit));
        }
        let series = &mut all[at];
        let shape = (column.n_tuples as u64, column.n_components as u64);
        if (series.element, (series.n_rows, series.n_components)) != (column.element, shape) {
            return changed("has another type or length than in the first step");
        }
        let hash = column.data.hash()?;
        if series.last != Some(hash) {
            let stored = self.file.store(&column.data)?;
            let mut n_zeros = (series.stride() - series.n_rows) * series.row();
            while n_zeros > 0 {
                let n = n_zeros.min(ZEROS.len() as u64);
                self.file.continue_with(&ZEROS[..n as usize])?;
                n_zeros -= n;
            }
            series.add(stored, &mut self.file)?;
            series.last = Some(hash);
        }
        let first_row = (series.n_pieces - 1) * series.stride();
        series.offsets.push(&[first_row as i64]);
        let sizes = [series.n_components as i64, series.n_rows as i64];
        series.sizes.push(&sizes);
        Ok(())
    }

    /// Puts a row of the step into each dataset of `Steps`. All arrays of the first step must have one.
    fn append_columns(&mut self, time: f64) -> Result<()> {
        let (content, file) = (&mut self.content, &mut self.file);
        let n = content.n_steps;
        let is_short = |series: &&Series| series.offsets.n_rows() < n;
        if let Some(series) = content.series.iter().find(is_short) {
            return Err(Error::input(format!(
                "step {1} has no array \"{0}\"; all steps in one VTKHDF file must have the arrays of the first step",
                series.name,
                n - 1
            )));
        }
        for (name, column) in &mut content.columns {
            match *name {
                VALUES => column.push(&[time]),
                PARTS => column.push(&[1_i64]),
                _ => column.push(&[0_i64]),
            }
            file.store_rows(column)?;
        }
        for series in &mut content.series {
            file.store_rows(&mut series.offsets)?;
            if series.group == FIELDS {
                file.store_rows(&mut series.sizes)?;
            }
            if series.object.is_none() {
                file.store_index(&mut series.chunks)?;
            }
        }
        Ok(())
    }
}

impl Content {
    /// The current content of the file.
    fn grid(&self) -> Grid<'_> {
        let topology = self.topology.as_ref().expect("the first step has set it");
        let mut grid = Grid::new(VERSION, topology.has_polyhedra, topology.has_wedges);
        grid.tree.links(grid.root, &topology.datasets);
        for series in &self.series {
            series.add_to(&mut grid);
        }
        let steps = grid.group("Steps");
        let tree = &mut grid.tree;
        tree.number_attribute(steps, "NSteps", &[self.n_steps as i64], true);
        for (name, column) in &self.columns {
            tree.rows(steps, name, column);
        }
        let of_group = |group| self.series.iter().filter(move |s| s.group == group);
        for (group, offsets) in [
            ("PointData", "PointDataOffsets"),
            ("CellData", "CellDataOffsets"),
            (FIELDS, "FieldDataOffsets"),
        ] {
            let offsets = tree.group(steps, offsets);
            for series in of_group(group) {
                tree.rows(offsets, &series.name, &series.offsets);
            }
        }
        let sizes = tree.group(steps, "FieldDataSizes");
        for series in of_group(FIELDS) {
            tree.rows(sizes, &series.name, &series.sizes);
        }
        for points in of_group("") {
            tree.rows(steps, "PointOffsets", &points.offsets);
        }
        grid
    }
}

impl Series {
    fn new(block: &Block, chunk_limit: u64) -> Self {
        let column = &block.column;
        let (n_rows, n_components) = (column.n_tuples as u64, column.n_components as u64);
        let element = column.element;
        let n_chunks = (n_rows * n_components * size(element)).div_ceil(chunk_limit);
        let n_chunks = n_chunks.max(1);
        Self {
            group: block.group,
            name: column.name.to_owned(),
            element,
            n_rows,
            n_components,
            chunk_rows: n_rows.div_ceil(n_chunks),
            n_chunks,
            n_pieces: 0,
            chunks: Chunks::new(shape(1, n_components).len()),
            last: None,
            object: None,
            offsets: Rows::new(Element::Int64, &[]),
            sizes: Rows::new(Element::Int64, &[2]),
        }
    }

    /// Rows from one piece to the next.
    fn stride(&self) -> u64 {
        self.chunk_rows * self.n_chunks
    }

    /// Bytes of a row.
    fn row(&self) -> u64 {
        self.n_components * size(self.element)
    }

    /// Adds the rows of a step.
    fn add(&mut self, stored: Stored, file: &mut StepFile) -> Result<()> {
        let chunk_bytes = self.chunk_rows * self.row();
        for i in 0..self.n_chunks {
            self.chunks.push(stored.past(i * chunk_bytes));
        }
        self.n_pieces += 1;
        self.object = None;
        if self.n_pieces == 1 {
            let shape = shape(self.n_rows, self.n_components);
            let tree = Tree::of_dataset(self.element, &shape, stored);
            self.object = Some(file.store_object(&tree)?);
        }
        Ok(())
    }

    /// Adds the dataset to the current file.
    fn add_to<'a>(&'a self, grid: &mut Grid<'a>) {
        let parent = grid.group(self.group);
        if let Some(object) = self.object {
            grid.tree.object(parent, &self.name, object);
            return;
        }
        let shape = shape(self.n_pieces * self.stride(), self.n_components);
        let (rows, chunks) = (self.chunk_rows, &self.chunks);
        let data = Payload::Chunks { rows, chunks };
        grid.tree
            .dataset(parent, &self.name, self.element, &shape, data);
    }
}
