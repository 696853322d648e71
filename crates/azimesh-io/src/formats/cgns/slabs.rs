//! Unstructured zones of a file in HDF5 by slabs: parts of their coordinates and of their sections, of one element type or
//! mixed.
//!
//! The reader of the whole file reads or refuses odd and damaged files.

use super::super::hdf5::{Dataset, is_hdf5};
use super::super::number::Chunk;
use super::super::slabs::{Refusal, Slabs, overlapping, points_of, whole};
use super::super::{Notes, ReadOptions, Source};
use super::builder::MeshBuilder;
use super::element::{ElementType, MIXED, type_name};
use super::node::{Data, Node};
use super::read::{self, bases, zones_of};
use super::regions::may_be_of_nodes;
use super::sections::{BLOCK, Rows, Section, append_mixed, append_rows, sections};
use super::time::Step;
use super::unstructured::order;
use super::zone::Zone;
use crate::mesh::{CellKind, Cells, Mesh, Values, too_many};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Bytes that a chunk of a dataset may have: as much is in memory with a slab.
const MOST_CHUNK: usize = 64 << 20;

type Found<T> = std::result::Result<T, Refusal>;

/// Coordinates and sections of all zones.
struct Zones<'a> {
    source: &'a Source,
    options: ReadOptions,
    /// True if a zone has arrays at cells.
    has_solutions_of_cells: bool,
    grids: Vec<Grid>,
    sections: Vec<Elements>,
}

/// The coordinates of a zone.
struct Grid {
    /// Its nodes in the mesh.
    nodes: Range<usize>,
    /// Arrays for x, y and z.
    axes: Vec<(usize, Array)>,
}

/// A section.
struct Elements {
    /// Its cells in the mesh.
    cells: Range<usize>,
    form: Form,
    /// Nodes in the mesh of its zone.
    nodes: Range<usize>,
    connectivity: Array,
}

/// The layout of the elements of a section.
enum Form {
    /// The nodes of elements of one type.
    Fixed(ElementType),
    /// The type of each element and its nodes.
    Mixed {
        /// The start of each element and the end of the last.
        starts: Array,
        /// CGNS version of the file.
        version: f64,
    },
}

/// A list of numbers.
struct Array {
    path: String,
    n: usize,
    /// Number of values read at a time.
    block: u64,
    data: Mutex<Box<Dataset>>,
}

/// Finds the zones of a file at one of its steps.
pub(super) fn open<'a>(source: &'a Source, options: &ReadOptions) -> Found<impl Slabs + use<'a>> {
    if !is_hdf5(source.bytes()) {
        return Err(whole("it is not in HDF5"));
    }
    let (root, _) = Node::root(source)?;
    let step = Step::choose(&root, options)?;
    let (bases, version) = bases(&root)?;
    let mut zones: Vec<Zone> = Vec::new();
    for base in bases {
        zones.extend(zones_of(base, &step, (zones.len(), version))?);
    }
    if zones.is_empty() {
        return Err(whole("it has no zone"));
    }
    let mut found = Zones {
        source,
        options: options.clone(),
        has_solutions_of_cells: false,
        grids: Vec::new(),
        sections: Vec::new(),
    };
    for zone in zones {
        found.add(zone, &step)?;
    }
    Ok(found)
}

impl Zones<'_> {
    fn add(&mut self, mut zone: Zone, step: &Step) -> Found<()> {
        if zone.is_structured {
            return Err(whole("it has structured zones"));
        }
        if may_be_of_nodes(&zone)? {
            return Err(whole("boundary conditions are given by their nodes"));
        }
        for arrays in ["FlowSolution_t", "DiscreteData_t"] {
            for solution in zone.node.labelled(arrays)? {
                let location = solution.child_text("GridLocation")?;
                self.has_solutions_of_cells |= location.as_deref() == Some("CellCenter");
            }
        }
        zone.first_node = self.n_nodes();
        self.grids.push(Grid::of(&zone, step)?);
        if self.n_nodes() + 1 >= u32::MAX as usize {
            return Err(Error::input(too_many("nodes")).into());
        }
        let sections = sections(&zone)?;
        for i in order(&zone, &sections)? {
            let elements = Elements::of(&sections[i], &zone, self.n_cells())?;
            if elements.cells.end >= u32::MAX as usize {
                return Err(Error::input(too_many("cells")).into());
            }
            self.sections.push(elements);
        }
        Ok(())
    }
}

impl Grid {
    fn of(zone: &Zone, step: &Step) -> Found<Self> {
        let (found, rind) = zone.axes(step)?;
        if rind.iter().any(|n| *n > 0) {
            return Err(whole("coordinates have rind planes"));
        }
        let n = zone.total_nodes()?;
        let mut axes = Vec::new();
        for (axis, node) in found.into_iter().enumerate() {
            if let Some(node) = node {
                let array = Array::open(node)?;
                if array.n != n {
                    return Err(whole("coordinates are not one for each node"));
                }
                axes.push((axis, array));
            }
        }
        let nodes = zone.nodes();
        Ok(Self { nodes, axes })
    }

    /// Sets the coordinates of some nodes, counted from the first of the zone.
    fn put(&self, nodes: Range<usize>, points: &mut [Vector]) -> Result<()> {
        for (axis, array) in &self.axes {
            let values = array.rows(nodes.start as u64..nodes.end as u64)?;
            let numbers = Chunk::of(&values);
            let numbers = numbers.ok_or_else(|| array.refuse("coordinates must be numbers"))?;
            if !numbers.axis(*axis, points) {
                return Err(array.refuse("coordinates must be finite"));
            }
        }
        Ok(())
    }
}

impl Elements {
    /// The elements of a section that begins with this cell.
    fn of(section: &Section, zone: &Zone, first: usize) -> Found<Self> {
        let connectivity = Array::open(section.node.need("ElementConnectivity")?)?;
        let form = match section.element_type {
            MIXED => mixed(section, zone.version, connectivity.n)?,
            _ => fixed(section, zone.version, connectivity.n)?,
        };
        Ok(Self {
            cells: first..first + section.n_elements,
            form,
            nodes: zone.nodes(),
            connectivity,
        })
    }

    /// Appends some of the elements, counted from the first of the section.
    fn append(&self, elements: Range<usize>, found: &mut MeshBuilder) -> Result<()> {
        let (array, cells) = (&self.connectivity, elements.clone());
        let read = |rows| array.rows(rows);
        let mut append = || match &self.form {
            Form::Fixed(element) => {
                let n = element.n_nodes as u64;
                let rows = cells.start as u64 * n..cells.end as u64 * n;
                let sizes = (1, array.block.next_multiple_of(n));
                append_rows(*element, Rows::new(rows, sizes, &read), &self.nodes, found)
            }
            Form::Mixed { starts, version } => {
                let rows = starts.number(cells.start)?..starts.number(cells.end)?;
                if rows.start > rows.end || rows.end > array.n as u64 {
                    return Err(Error::input("its elements do not follow one another"));
                }
                let mut entries = Rows::new(rows, (1, array.block), &read);
                let of_section = (cells.clone(), self.cells.len());
                append_mixed(of_section, &mut entries, *version, &self.nodes, found)?;
                if entries.n_left() > 0 {
                    return Err(Error::input("an element does not begin where it should"));
                }
                Ok(())
            }
        };
        append().map_err(|error| array.refuse(error.message))
    }
}

/// The form of a section of one element type, with so many entries.
fn fixed(section: &Section, version: f64, n_entries: usize) -> Found<Form> {
    let number = section.element_type;
    let element = ElementType::in_version(number, version);
    match element.filter(|element| element.kind != CellKind::Polygon) {
        None => Err(whole(format!(
            "it has a section of type {}",
            type_name(number)
        ))),
        Some(element) if section.n_elements.checked_mul(element.n_nodes) != Some(n_entries) => {
            Err(whole("a section is not as long as its elements need"))
        }
        Some(element) => Ok(Form::Fixed(element)),
    }
}

/// The form of a MIXED section with so many entries.
fn mixed(section: &Section, version: f64, n_entries: usize) -> Found<Form> {
    let Some(node) = section.node.child("ElementStartOffset")? else {
        return Err(whole(
            "a MIXED section does not store where elements begin (ElementStartOffset)",
        ));
    };
    // The reader of the whole file does not look at them.
    let misfit = || whole("the ElementStartOffset of a section does not fit it");
    let starts = Array::open(node).map_err(|_| misfit())?;
    let n = section.n_elements;
    let is_at = |at, entry: usize| starts.number(at).is_ok_and(|found| found == entry as u64);
    if starts.n != n + 1 || !is_at(0, 0) || !is_at(n, n_entries) {
        return Err(misfit());
    }
    Ok(Form::Mixed { starts, version })
}

impl Array {
    /// The data of a node, which must be a list.
    fn open(node: &Node) -> Found<Self> {
        let Data::Hdf5(data) = node.data()? else {
            return Err(whole("it is not in HDF5"));
        };
        let &[n] = data.shape() else {
            return Err(whole(format!("{} is not a list", node.path())));
        };
        data.check_rows(&(0..n))?;
        let chunk = usize::try_from(data.whole_chunks(1)).unwrap_or(usize::MAX);
        if chunk.saturating_mul(data.value_size()) > MOST_CHUNK {
            return Err(whole("its arrays are stored in chunks that are too large"));
        }
        Ok(Self {
            path: node.path().to_owned(),
            n: usize::try_from(n).map_err(|_| whole("an array is too long"))?,
            block: data.whole_chunks(BLOCK),
            data: Mutex::new(data),
        })
    }

    /// One of the numbers, which must be an integer and not negative.
    fn number(&self, at: usize) -> Result<u64> {
        let numbers = self.rows(at as u64..at as u64 + 1)?.to_integers();
        let number = numbers.and_then(|numbers| u64::try_from(*numbers.first()?).ok());
        number.ok_or_else(|| self.refuse("it must have integers, none of them negative"))
    }

    fn rows(&self, rows: Range<u64>) -> Result<Values> {
        let data = self.data.lock().unwrap_or_else(PoisonError::into_inner);
        data.rows(rows).map_err(|error| self.refuse(error.message))
    }

    /// An error with its place.
    fn refuse(&self, message: impl Into<String>) -> Error {
        Error::input(message).dataset(&self.path)
    }
}

impl Slabs for Zones<'_> {
    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        if self.has_solutions_of_cells {
            // Boundary faces have the values of the cells that they bound.
            return Err(whole("it has arrays at cells"));
        }
        Ok(read::complete(self.source, &self.options, mesh, notes)?)
    }

    fn n_nodes(&self) -> usize {
        self.grids.last().map_or(0, |last| last.nodes.end)
    }

    fn n_cells(&self) -> usize {
        self.sections.last().map_or(0, |last| last.cells.end)
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        points_of(&self.grids, |grid| grid.nodes.clone(), nodes, Grid::put)
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let mut found = MeshBuilder::default();
        for (section, own) in overlapping(&self.sections, |s| s.cells.clone(), cells) {
            section.append(own, &mut found)?;
        }
        if !found.incomplete.is_empty() {
            return Err(Error::input("of some elements only the corners are kept"));
        }
        Ok(found.cells)
    }
}
