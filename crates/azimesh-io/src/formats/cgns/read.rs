//! A CGNS file as a mesh: all zones of all bases one after another.

use super::super::adf::is_adf;
use super::super::{Notes, ReadOptions, Source};
use super::FromAdf;
use super::builder::MeshBuilder;
use super::families::Families;
use super::node::Node;
use super::time::Step;
use super::zone::Zone;
use super::{solution, structured, unstructured};
use crate::mesh::{BoundedCells, Cells, Mesh, Origin, first_where};
use azimesh_core::diagnostic::formats::Read;
use azimesh_core::error::{Error, Result};
use std::ops::Range;
use std::rc::Rc;

/// Reads a file at one of its steps.
pub(super) fn read(source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let (root, missing) = Node::root(source)?;
    let read = read_bases(&root, options, None, notes);
    let files = missing.names();
    match read {
        Ok(mut mesh) => {
            if is_adf(source.bytes()) {
                mesh.origin = Origin::new(FromAdf);
            }
            notes.list(files, |files| Read::BrokenLinks { files });
            Ok(mesh)
        }
        Err(error) if files.iter().all(|file| error.message.contains(file)) => Err(error),
        Err(error) => Err(Error {
            message: format!(
                "{}; links lead to files that are not there: {}",
                error.message,
                files.join(", ")
            ),
            ..error
        }),
    }
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
    let files = missing.names();
    notes.list(files, |files| Read::BrokenLinks { files });
    mesh.cells = read.cells;
    mesh.groups = read.groups;
    mesh.point_arrays = read.point_arrays;
    mesh.field_arrays = read.field_arrays;
    Ok(())
}

/// All bases; where the cells of all are known without nodes.
fn read_bases(
    root: &Node,
    options: &ReadOptions,
    cells: Option<Cells>,
    notes: &mut Notes,
) -> Result<Mesh> {
    let step = Step::choose(root, options.step)?;
    let version = version(root)?;
    let mut found = MeshBuilder::default();
    let bases = bases(root)?;
    let mut zones: Vec<(Zone, Rc<Families>)> = Vec::new();
    for base in &bases {
        let families = Rc::new(Families::read(base)?);
        let of_base = zones_of(base, &step, (zones.len(), version))?;
        zones.extend(of_base.into_iter().map(|zone| (zone, families.clone())));
        read_others(base, &step, &mut found)?;
    }
    if zones.is_empty() {
        return Err(bases[0].refuse("it has no zone (Zone_t), so there is no mesh"));
    }
    let several = zones.len() > 1;
    let mut known = cells.is_some().then(Known::default);
    found.cells = cells.unwrap_or_default();
    for (zone, families) in zones {
        read_zone(zone, &families, (&step, several), &mut known, &mut found)?;
    }
    found.say(notes);
    root.note_latin1(notes);
    let n_cells = found.cells.len();
    let n_nodes = known.map_or(found.points.len(), |known| known.n_nodes);
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

/// How many nodes and cells the zones before one have, where cells are not read here.
#[derive(Default)]
struct Known {
    n_nodes: usize,
    n_cells: usize,
}

/// Solutions have values of cells alone: a boundary face gets those of the cell that it bounds.
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

/// The bases of a file.
pub(super) fn bases(root: &Node) -> Result<Vec<&Node>> {
    let bases: Vec<&Node> = root.labelled("CGNSBase_t")?.collect();
    match bases.is_empty() {
        true => Err(Error::input("this is not a CGNS file: it has no CGNSBase_t").dataset("/")),
        false => Ok(bases),
    }
}

/// The CGNS version of a file.
pub(super) fn version(root: &Node) -> Result<f64> {
    let version = root.child("CGNSLibraryVersion")?.map(Node::numbers);
    let version = version.transpose()?;
    Ok(version.and_then(|v| v.first().copied()).unwrap_or(4.0))
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
    let is_present = |zone: &&Node| {
        let listed = |names: &Vec<String>| names.iter().any(|name| name == zone.name());
        present.as_ref().is_none_or(listed)
    };
    let mut zones = Vec::new();
    for node in base.labelled("Zone_t")?.filter(is_present) {
        let mut zone = Zone::open(node, base.name(), n_before + zones.len(), dimension)?;
        zone.version = version;
        zones.push(zone);
    }
    Ok(zones)
}

/// Reads the arrays of a base, and counts what it has that is not read.
fn read_others(base: &Node, step: &Step, found: &mut MeshBuilder) -> Result<()> {
    const KEPT: [&str; 7] = [
        "Zone_t",
        "Family_t",
        "BaseIterativeData_t",
        "SimulationType_t",
        "DataClass_t",
        "Ordinal_t",
        "Descriptor_t",
    ];
    for child in base.children()? {
        if !KEPT.contains(&child.label()) && !child.name().starts_with(super::FIELD_ARRAYS) {
            found.leave(child.label(), 1);
        }
    }
    found
        .field_arrays
        .extend(solution::field_arrays(base, step)?);
    Ok(())
}

fn read_zone(
    mut zone: Zone,
    families: &Families,
    (step, is_group): (&Step, bool),
    known: &mut Option<Known>,
    found: &mut MeshBuilder,
) -> Result<()> {
    if let Some((said, meant)) = &zone.odd_kind {
        let note = Read::ZoneKind {
            zone: zone.node.path().to_owned(),
            found: said.clone(),
            meant,
        };
        found.remarks.push(note.into());
    }
    let first_cell = (known.as_ref()).map_or(found.cells.len(), |known| known.n_cells);
    let end = match known {
        Some(known) => {
            zone.first_node = known.n_nodes;
            known.n_nodes += zone.total_nodes()?;
            known.n_cells = unstructured::read_groups(&zone, families, first_cell, found)?;
            known.n_cells
        }
        None => {
            let mut points = std::mem::take(&mut found.points);
            let read = zone.read_points(step, &mut points);
            found.points = points;
            read?;
            match zone.is_structured {
                true => structured::read(&zone, families, found)?,
                false => unstructured::read(&zone, families, found)?,
            }
            found.cells.len()
        }
    };
    let dimension = zone.cell_dimension;
    let runs = found.cells.runs_in(first_cell..end);
    let solid: Vec<Range<usize>> = runs
        .filter(|run| run.kind.dimension() == dimension)
        .map(|run| run.first_cell..run.first_cell + run.n_cells())
        .collect();
    solution::read(&zone, &solid, step, found)?;
    if is_group {
        found
            .tags
            .add_new(zone.node.name(), zone.base, dimension, &solid);
    }
    for family in zone.node.labelled("FamilyName_t")? {
        for name in families.names(&family.text_or_none()?) {
            if !(is_group && name == zone.node.name()) {
                found
                    .tags
                    .add(&name, zone.base, dimension, None, solid.clone());
            }
        }
    }
    leave_others(&zone, found)
}

/// Counts what a zone has that is not read.
fn leave_others(zone: &Zone, found: &mut MeshBuilder) -> Result<()> {
    const KEPT: [&str; 16] = [
        "ZoneType_t",
        "UserDefinedData_t",
        "GridCoordinates_t",
        "Elements_t",
        "ZoneBC_t",
        "ZoneSubRegion_t",
        "FlowSolution_t",
        "DiscreteData_t",
        "FamilyName_t",
        "ZoneIterativeData_t",
        "ArbitraryGridMotion_t",
        "DataClass_t",
        "DimensionalUnits_t",
        "Ordinal_t",
        "Descriptor_t",
        "ZoneGridConnectivity_t",
    ];
    for child in zone.node.children()? {
        if !KEPT.contains(&child.label()) {
            found.leave(child.label(), 1);
        }
    }
    for connectivity in zone.node.labelled("ZoneGridConnectivity_t")? {
        for interface in connectivity.children()? {
            if interface.label().starts_with("GridConnectivity") {
                found.leave("interfaces to other zones", 1);
            }
        }
    }
    Ok(())
}
