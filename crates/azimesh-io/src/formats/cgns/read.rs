//! A CGNS file as a mesh: all zones of all bases one after another.

use super::super::adf::is_adf;
use super::super::{Notes, ReadOptions, Source};
use super::FromAdf;
use super::builder::MeshBuilder;
use super::node::Node;
use super::regions::Families;
use super::time::Step;
use super::zone::Zone;
use super::{solution, structured, unstructured};
use crate::mesh::{BoundedCells, Cells, Mesh, Origin, first_where};
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use std::ops::Range;
use std::rc::Rc;

/// Reads a file at one of its steps.
pub(super) fn read(source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let (root, missing) = Node::root(source)?;
    let read = read_bases(&root, options, None, notes);
    let files = missing.names();
    let mut mesh = read.map_err(|error| {
        if files.iter().all(|file| error.message.contains(file)) {
            return error;
        }
        let (why, files) = (&error.message, files.join(", "));
        let message = format!("{why}; links lead to files that are not there: {files}");
        Error { message, ..error }
    })?;
    if is_adf(source.bytes()) {
        mesh.origin = Origin::new(FromAdf);
    }
    note_links(files, notes);
    Ok(mesh)
}

/// Notes files that links lead to and that are not there.
fn note_links(files: Vec<String>, notes: &mut Notes) {
    notes.list(files, |files| {
        note!(
            "broken_links",
            "links lead to files that are not there, and what they stand for is left out: {}",
            files.join(", ")
        )
    });
}

/// Gives the mesh of a mesh of unstructured zones in HDF5, without arrays at cells, its groups and arrays.
pub(super) fn complete(
    source: &Source,
    options: &ReadOptions,
    mesh: &mut Mesh,
    notes: &mut Notes,
) -> Result<()> {
    let (root, missing) = Node::root(source)?;
    let cells = std::mem::take(&mut mesh.cells);
    let read = read_bases(&root, options, Some(cells), notes)?;
    note_links(missing.names(), notes);
    mesh.cells = read.cells;
    mesh.groups = read.groups;
    mesh.point_arrays = read.point_arrays;
    mesh.field_arrays = read.field_arrays;
    Ok(())
}

/// Reads all bases, all but nodes and cells where the cells are known.
fn read_bases(
    root: &Node,
    options: &ReadOptions,
    cells: Option<Cells>,
    notes: &mut Notes,
) -> Result<Mesh> {
    let step = Step::choose(root, options)?;
    let (bases, version) = bases(root)?;
    let mut found = MeshBuilder::default();
    let mut zones: Vec<(Zone, Rc<Families>)> = Vec::new();
    for base in &bases {
        let families = Rc::new(Families::read(base)?);
        let of_base = zones_of(base, &step, (zones.len(), version))?;
        zones.extend(of_base.into_iter().map(|zone| (zone, families.clone())));
        leave_others(base, OF_BASE, &mut found)?;
        let arrays = solution::field_arrays(base, &step)?;
        found.field_arrays.extend(arrays);
    }
    if zones.is_empty() {
        return Err(bases[0].refuse("it has no zone (Zone_t), so there is no mesh"));
    }
    let several = zones.len() > 1;
    // The numbers of nodes and cells before a zone, where these are known.
    let mut known = cells.is_some().then_some((0, 0));
    found.cells = cells.unwrap_or_default();
    for (zone, families) in zones {
        read_zone(zone, &families, (&step, several), &mut known, &mut found)?;
    }
    found.say(notes);
    root.note_latin1(notes);
    let n_cells = found.cells.len();
    let n_nodes = known.map_or(found.points.len(), |(n_nodes, _)| n_nodes);
    let mut mesh = Mesh {
        point_arrays: found.point_arrays.into_data_arrays(n_nodes),
        cell_arrays: found.cell_arrays.into_data_arrays(n_cells),
        points: found.points,
        cells: found.cells,
        groups: found.tags.into_groups(),
        field_arrays: found.field_arrays,
        ..Mesh::default()
    };
    give_to_faces(&mut mesh);
    Ok(mesh)
}

/// Solutions have values of cells only: a boundary face gets the values of the cell that it bounds.
fn give_to_faces(mesh: &mut Mesh) {
    let n_points = mesh.points.len();
    let outside = |node: &u32| *node as usize >= n_points;
    if mesh.cell_arrays.is_empty() || first_where(mesh.cells.connectivity(), outside).is_some() {
        // Nodes that are not there are refused when all is read.
        return;
    }
    let bounded = BoundedCells::of(mesh);
    for array in &mut mesh.cell_arrays {
        bounded.give_values(array);
    }
}

/// The bases of a file, and its CGNS version.
pub(super) fn bases(root: &Node) -> Result<(Vec<&Node>, f64)> {
    let version = root.child("CGNSLibraryVersion")?.map(Node::numbers);
    let version = version.transpose()?.and_then(|v| v.first().copied());
    let bases: Vec<&Node> = root.labelled("CGNSBase_t")?.collect();
    if bases.is_empty() {
        let message = "this is not a CGNS file: it has no CGNSBase_t";
        return Err(Error::input(message).dataset("/"));
    }
    Ok((bases, version.unwrap_or(4.0)))
}

/// The zones of a base that exist at this step.
pub(super) fn zones_of<'a>(
    base: &'a Node,
    step: &Step,
    (n_before, version): (usize, f64),
) -> Result<Vec<Zone<'a>>> {
    let dimension = match base.integers()?.first() {
        Some(&dimension @ 1..=3) => dimension as u8,
        Some(other) => {
            return Err(base.refuse(format!(
                "its cells have dimension {other}; it must be 1, 2 or 3"
            )));
        }
        None => return Err(base.refuse("it does not give the dimension of its cells")),
    };
    let present = step.zones(base)?;
    let is_present = |zone: &&Node| match &present {
        Some(names) => names.iter().any(|name| name == zone.name()),
        None => true,
    };
    let nodes = base.labelled("Zone_t")?.filter(is_present);
    nodes
        .zip(n_before..)
        .map(|(node, number)| Zone::open(node, base.name(), number, (dimension, version)))
        .collect()
}

fn read_zone(
    mut zone: Zone,
    families: &Families,
    (step, is_group): (&Step, bool),
    known: &mut Option<(usize, usize)>,
    found: &mut MeshBuilder,
) -> Result<()> {
    if let Some((said, meant)) = &zone.odd_kind {
        let path = zone.node.path();
        found.remarks.push(note!(
            "zone_kind",
            "{path}: ZoneType \"{said}\" is read as {meant}"
        ));
    }
    let cells = if let Some((n_nodes, n_cells)) = known {
        zone.first_node = *n_nodes;
        *n_nodes += zone.total_nodes()?;
        let first = *n_cells;
        *n_cells = unstructured::read_groups(&zone, families, first, found)?;
        first..*n_cells
    } else {
        let first = found.cells.len();
        zone.read_points(step, &mut found.points)?;
        if zone.is_structured {
            structured::read(&zone, families, found)?;
        } else {
            unstructured::read(&zone, families, found)?;
        }
        first..found.cells.len()
    };
    let (name, base, dimension) = (zone.node.name(), zone.base, zone.cell_dimension);
    let runs = found.cells.runs_in(cells);
    let runs = runs.filter(|run| run.kind.dimension() == dimension);
    let solid: Vec<Range<usize>> = runs.map(|run| run.range()).collect();
    solution::read(&zone, &solid, step, found)?;
    if is_group {
        found.tags.add_new(name, base, dimension, &solid);
    }
    for family in zone.node.labelled("FamilyName_t")? {
        for family in families.names(&family.text_or_none()?) {
            if !is_group || family != name {
                (found.tags).add(&family, base, dimension, None, solid.clone());
            }
        }
    }
    leave_others(zone.node, OF_ZONE, found)?;
    leave_coordinates(&zone, step, found)?;
    for connectivity in zone.node.labelled("ZoneGridConnectivity_t")? {
        for interface in connectivity.children()? {
            match interface.label() {
                label if label.starts_with("GridConnectivity") => {
                    found.leave("interfaces to other zones", 1);
                }
                "Descriptor_t" | "UserDefinedData_t" => {}
                label => found.leave(label, 1),
            }
        }
    }
    Ok(())
}

/// Labels of children of a base that are read, or say nothing of the mesh.
const OF_BASE: &str = "Zone_t Family_t BaseIterativeData_t SimulationType_t DataClass_t Ordinal_t \
    Descriptor_t";

/// Such labels of children of a zone.
const OF_ZONE: &str = "ZoneType_t UserDefinedData_t GridCoordinates_t Elements_t ZoneBC_t \
    ZoneSubRegion_t FlowSolution_t DiscreteData_t FamilyName_t ZoneIterativeData_t \
    ArbitraryGridMotion_t DataClass_t DimensionalUnits_t Ordinal_t Descriptor_t \
    ZoneGridConnectivity_t";

/// Counts the coordinates of a zone that are not read, and the units of the coordinates that are.
fn leave_coordinates(zone: &Zone, step: &Step, found: &mut MeshBuilder) -> Result<()> {
    let read = zone.coordinates(step)?;
    if step
        .pointer(zone.node, "GridCoordinatesPointers")?
        .is_none()
    {
        let all = zone.node.labelled("GridCoordinates_t")?;
        let others = all.filter(|node| node.path() != read.path()).count();
        if others > 0 {
            found.leave("GridCoordinates_t", others);
        }
    }
    for node in read.children()?.iter().chain([read]) {
        let units = node.labelled("DimensionalUnits_t")?.count();
        if units > 0 {
            found.leave("DimensionalUnits_t", units);
        }
    }
    Ok(())
}

/// Counts children that are not read.
fn leave_others(node: &Node, kept: &str, found: &mut MeshBuilder) -> Result<()> {
    for child in node.children()? {
        let is_kept = kept.split(' ').any(|label| label == child.label());
        if !is_kept && !child.name().starts_with(super::FIELD_ARRAYS) {
            found.leave(child.label(), 1);
        }
    }
    Ok(())
}
