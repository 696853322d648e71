//! A file that takes one mesh after another: cells once, positions and arrays as they change.

use super::super::hdf5::{Data, Element, Growing, Id, Stored};
use super::super::vtk::plan::Plan;
use super::super::{Begin, SequenceFile, WriteOptions};
use super::blocks::{Block, Blocks, shape};
use super::write::Grid;
use crate::error::{Error, Result};
use crate::mesh::{Cells, Mesh};
use std::path::Path;

/// A chunk of a dataset has less than 4 GB.
const MOST_CHUNK_BYTES: u64 = 1 << 31;
/// Zeros written at a time.
const ZEROS: [u8; 4096] = [0; 4096];

/// A sequence under work.
pub(super) struct Sequence {
    file: Growing,
    /// Most bytes of a chunk.
    pub chunk_limit: u64,
    options: WriteOptions,
    notes: Vec<String>,
    times: Vec<f64>,
    topology: Option<Topology>,
    /// Positions, then the arrays.
    series: Vec<Series>,
}

/// What all steps share.
struct Topology {
    hash: blake3::Hash,
    has_polyhedra: bool,
    counts: Vec<(&'static str, u64)>,
    datasets: Vec<Fixed>,
}

/// A dataset that is written once.
struct Fixed {
    name: String,
    element: Element,
    n_rows: u64,
    stored: Stored,
}

/// A dataset to which a step adds rows, unless it has those of the step before.
struct Series {
    group: &'static str,
    name: String,
    element: Element,
    n_rows: u64,
    n_components: u64,
    /// Rows of a chunk, and chunks of a step.
    chunk_rows: u64,
    n_chunks: u64,
    pieces: Vec<Stored>,
    last: Option<blake3::Hash>,
    /// The piece of each step.
    of_steps: Vec<u64>,
}

impl Sequence {
    /// A file, which takes its name with the first mesh unless it has it.
    pub fn create(path: &Path, options: &WriteOptions, begin: Begin) -> Result<Self> {
        Ok(Self {
            file: Growing::create(path, begin)?,
            chunk_limit: MOST_CHUNK_BYTES,
            options: options.clone(),
            notes: Vec::new(),
            times: Vec::new(),
            topology: None,
            series: Vec::new(),
        })
    }
}

impl SequenceFile for Sequence {
    fn append(&mut self, time: f64, mesh: &Mesh) -> Result<blake3::Hash> {
        self.options.check_coordinates(mesh)?;
        let options = self.options.clone();
        let plan = Plan::new(mesh, &options);
        let blocks = Blocks::new(mesh, &plan);
        self.fix(mesh, &blocks)?;
        let arrays = std::iter::once(&blocks.points).chain(&blocks.arrays);
        for block in arrays {
            self.append_block(block)?;
        }
        if self.times.is_empty() {
            self.notes.clone_from(&blocks.notes);
        }
        self.times.push(time);
        self.check_complete()?;
        let topology = self.topology.as_ref().expect("the first step has set it");
        let grid = tree(topology, &self.series, &self.times);
        self.file.finish_step(&grid.tree)
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

impl Sequence {
    /// Writes the cells, or makes sure that they are those of the first step.
    fn fix(&mut self, mesh: &Mesh, blocks: &Blocks) -> Result<()> {
        let hash = hash_of(&mesh.cells);
        if let Some(topology) = &self.topology {
            let same = topology.hash == hash && topology.counts == blocks.counts;
            return match same {
                true => Ok(()),
                false => Err(Error::input(format!(
                    "step {} has other nodes, cells or shared boundary faces than the first; a \
                     sequence in one VTKHDF file has the same at every step",
                    self.times.len()
                ))),
            };
        }
        let mut datasets = Vec::new();
        for block in &blocks.cells {
            datasets.push(Fixed {
                name: block.name.clone(),
                element: block.element,
                n_rows: block.n_rows,
                stored: store(&mut self.file, block)?,
            });
        }
        self.topology = Some(Topology {
            hash,
            has_polyhedra: mesh.cells.has_polyhedra(),
            counts: blocks.counts.clone(),
            datasets,
        });
        Ok(())
    }

    fn append_block(&mut self, block: &Block) -> Result<()> {
        let step = self.times.len();
        let is_same = |s: &&mut Series| (s.group, &s.name) == (block.group, &block.name);
        let known = self.series.iter_mut().find(is_same);
        let series = match known {
            Some(series) => series,
            None if step == 0 => {
                self.series.push(Series::new(block, self.chunk_limit));
                self.series.last_mut().expect("it was just added")
            }
            None => return Err(changed(step, block, "is not in the first step")),
        };
        if (series.element, series.n_rows, series.n_components)
            != (block.element, block.n_rows, block.n_components)
        {
            return Err(changed(
                step,
                block,
                "has another type or length than in the first step",
            ));
        }
        let hash = hash_of_block(block)?;
        if series.last != Some(hash) {
            let stored = store(&mut self.file, block)?;
            pad(&mut self.file, series.padding())?;
            series.pieces.push(stored);
            series.last = Some(hash);
        }
        series.of_steps.push(series.pieces.len() as u64 - 1);
        Ok(())
    }

    fn check_complete(&self) -> Result<()> {
        let n = self.times.len();
        match self.series.iter().find(|series| series.of_steps.len() < n) {
            None => Ok(()),
            Some(series) => Err(Error::input(format!(
                "the array \"{}\" is missing in step {}; a sequence in one VTKHDF file has the \
                 arrays of its first step",
                series.name,
                n - 1
            ))),
        }
    }
}

fn changed(step: usize, block: &Block, how: &str) -> Error {
    let name = &block.name;
    Error::input(format!(
        "step {step}: the array \"{name}\" {how}; a sequence in one VTKHDF file has the same arrays at \
         every step"
    ))
}

impl Series {
    fn new(block: &Block, chunk_limit: u64) -> Self {
        let row = block.n_components * block.element.size();
        let n_chunks = (block.n_rows * row).div_ceil(chunk_limit).max(1);
        Self {
            group: block.group,
            name: block.name.clone(),
            element: block.element,
            n_rows: block.n_rows,
            n_components: block.n_components,
            chunk_rows: block.n_rows.div_ceil(n_chunks),
            n_chunks,
            pieces: Vec::new(),
            last: None,
            of_steps: Vec::new(),
        }
    }

    /// Rows from one piece to the next.
    fn stride(&self) -> u64 {
        self.chunk_rows * self.n_chunks
    }

    fn row(&self) -> u64 {
        self.n_components * self.element.size()
    }

    /// Bytes that fill up the last chunk of a piece.
    fn padding(&self) -> u64 {
        (self.stride() - self.n_rows) * self.row()
    }

    /// The first row of each step.
    fn offsets(&self) -> Vec<i64> {
        self.of_steps
            .iter()
            .map(|piece| (piece * self.stride()) as i64)
            .collect()
    }

    fn shape(&self) -> Vec<u64> {
        let n_rows = match self.pieces.len() {
            1 => self.n_rows,
            n => n as u64 * self.stride(),
        };
        shape(n_rows, self.n_components)
    }

    fn data(&self) -> Data<'static> {
        if let [piece] = self.pieces[..] {
            return Data::Stored(piece);
        }
        let chunk_bytes = self.chunk_rows * self.row();
        let chunks = |piece: &Stored| {
            let piece = *piece;
            (0..self.n_chunks).map(move |i| piece.past(i * chunk_bytes))
        };
        Data::Chunks {
            rows: self.chunk_rows,
            pieces: self.pieces.iter().flat_map(chunks).collect(),
        }
    }
}

/// The content of the file as it is now.
fn tree(topology: &Topology, series: &[Series], times: &[f64]) -> Grid<'static> {
    let mut grid = Grid::new(topology.has_polyhedra);
    for (name, n) in &topology.counts {
        grid.tree.numbers(grid.root, name, &[*n as i64]);
    }
    for fixed in &topology.datasets {
        let data = Data::Stored(fixed.stored);
        grid.tree
            .dataset(grid.root, &fixed.name, fixed.element, &[fixed.n_rows], data);
    }
    for series in series {
        let parent = grid.group(series.group);
        grid.tree.dataset(
            parent,
            &series.name,
            series.element,
            &series.shape(),
            series.data(),
        );
    }
    let steps = grid.group("Steps");
    add_steps(&mut grid, steps, topology, series, times);
    grid
}

fn add_steps(grid: &mut Grid, steps: Id, topology: &Topology, series: &[Series], times: &[f64]) {
    let tree = &mut grid.tree;
    tree.number_attribute(steps, "NSteps", &[times.len() as i64], true);
    tree.numbers(steps, "Values", times);
    let same = |n: i64| vec![n; times.len()];
    tree.numbers(steps, "NumberOfParts", &same(1));
    let mut zero = vec!["PartOffsets", "CellOffsets", "ConnectivityIdOffsets"];
    if topology.has_polyhedra {
        zero.extend([
            "FaceConnectivityOffsets",
            "FaceOffsetsOffsets",
            "PolyhedronToFaceIdOffsets",
        ]);
    }
    for name in zero {
        tree.numbers(steps, name, &same(0));
    }
    let groups = [
        ("PointData", "PointDataOffsets"),
        ("CellData", "CellDataOffsets"),
        ("FieldData", "FieldDataOffsets"),
    ];
    for (group, offsets) in groups {
        let offsets = tree.group(steps, offsets);
        for series in series.iter().filter(|series| series.group == group) {
            tree.numbers(offsets, &series.name, &series.offsets());
        }
    }
    let sizes = tree.group(steps, "FieldDataSizes");
    for series in series.iter().filter(|series| series.group == "FieldData") {
        let size = [series.n_components as i64, series.n_rows as i64];
        let bytes: Vec<u8> = bytemuck::cast_slice(&vec![size; times.len()]).to_vec();
        let data = Data::Bytes(bytes.into());
        tree.dataset(
            sizes,
            &series.name,
            Element::I64,
            &[times.len() as u64, 2],
            data,
        );
    }
    if let Some(points) = series.iter().find(|series| series.group.is_empty()) {
        tree.numbers(steps, "PointOffsets", &points.offsets());
    }
}

fn store(file: &mut Growing, block: &Block) -> Result<Stored> {
    match &block.data {
        Data::Strings(strings) => file.store_strings(strings),
        data => file.store(|sink| data.each(sink)),
    }
}

fn pad(file: &mut Growing, mut n_bytes: u64) -> Result<()> {
    while n_bytes > 0 {
        let n = n_bytes.min(ZEROS.len() as u64);
        file.continue_with(&ZEROS[..n as usize])?;
        n_bytes -= n;
    }
    Ok(())
}

fn hash_of_block(block: &Block) -> Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    match &block.data {
        Data::Strings(strings) => {
            for string in strings.iter() {
                hasher.update(&(string.len() as u64).to_le_bytes());
                hasher.update(string.as_bytes());
            }
        }
        data => data.each(&mut |bytes| {
            hasher.update_rayon(bytes);
            Ok(())
        })?,
    }
    Ok(hasher.finalize())
}

fn hash_of(cells: &Cells) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update_rayon(bytemuck::cast_slice(cells.connectivity()));
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
