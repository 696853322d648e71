//! Groups of a mesh: boundary tags as boundary conditions with their families, others as subregions
//! of the zone with theirs. All share the nodes of the one zone.

use super::super::{FIELD_ARRAYS, FULL_NAME};
use super::draft::Draft;
use super::plan::Numbering;
use super::{RULE, SIMULATION, TIMES, ZONE};
use crate::formats::Notes;
use crate::formats::hdf5::{Element, Id};
use crate::formats::names::{UniqueNames, in_cgns};
use crate::mesh::{CellSet, Group, MeshView};
use azimesh_core::note;
use std::collections::BTreeMap;

/// Types of boundary conditions that CGNS knows.
const CONDITIONS: &str = "UserDefined BCAxisymmetricWedge BCDegenerateLine BCDegeneratePoint \
    BCDirichlet BCExtrapolate BCFarfield BCGeneral BCInflow BCInflowSubsonic BCInflowSupersonic \
    BCNeumann BCOutflow BCOutflowSubsonic BCOutflowSupersonic BCSymmetryPlane BCSymmetryPolar \
    BCTunnelInflow BCTunnelOutflow BCWall BCWallInviscid BCWallViscous BCWallViscousHeatFlux \
    BCWallViscousIsothermal FamilySpecified";

/// Adds the groups of a mesh, families to the base, the rest to the zone.
pub(super) fn add(
    (draft, base, zone): (&mut Draft, Id, Id),
    mesh: &MeshView,
    names: &mut UniqueNames,
    numbering: (&Numbering, Element),
    notes: &mut Notes,
) {
    let dimension = mesh.dimension();
    let mut families = Families::new(base, mesh);
    let mut conditions = None;
    let tags = mesh.boundary_tags().filter(|tag| !tag.cells.is_empty());
    let tags: Vec<&str> = tags.map(|tag| tag.name.as_str()).collect();
    let mut condition_names = UniqueNames::default().give_all(&tags, &RULE).into_iter();
    notes.joined(mesh.groups);
    for group in mesh.groups {
        let family = families.family(draft, group, notes);
        if group.cells.is_empty() {
            let name = &group.name;
            notes.push(note!(
                "empty_group",
                "group \"{name}\" has no cells; only its family is written to CGNS"
            ));
            continue;
        }
        let node = if group.dimension + 1 == dimension {
            let parent =
                *conditions.get_or_insert_with(|| draft.group(zone, ("ZoneBC", "ZoneBC_t")));
            let name = condition_names.next().expect("each condition has one");
            let condition = known_condition(group).unwrap_or("FamilySpecified");
            draft.text(parent, (&name, "BC_t"), condition)
        } else {
            let name = names.give(&group.name, &RULE);
            add_region(draft, zone, &name, group.dimension, dimension)
        };
        add_points(draft, node, group, mesh, numbering);
        draft.text(node, ("FamilyName", "FamilyName_t"), &family);
    }
}

/// Cells are subregions. The CGNS library's own checker takes subregions of cells or of faces only, so that nodes, and
/// edges in space, are user-defined data.
fn add_region(draft: &mut Draft, zone: Id, name: &str, of: u8, mesh: u8) -> Id {
    if of + 1 < mesh {
        return draft.group(zone, (name, "UserDefinedData_t"));
    }
    let name = (name, "ZoneSubRegion_t");
    draft.integers(zone, name, (Element::Int32, &[1]), &[of.into()])
}

fn known_condition(group: &Group) -> Option<&str> {
    let condition = in_cgns(group.condition.as_deref()?);
    let mut known = CONDITIONS.split(' ');
    known.any(|known| known == condition).then_some(condition)
}

/// Adds the elements of a group, of one of nodes the nodes.
fn add_points(
    draft: &mut Draft,
    parent: Id,
    group: &Group,
    mesh: &MeshView,
    (numbering, integer): (&Numbering, Element),
) {
    let location = match group.dimension {
        0 => "Vertex",
        1 if mesh.dimension() > 1 => "EdgeCenter",
        2 if mesh.dimension() > 2 => "FaceCenter",
        _ => "CellCenter",
    };
    let numbers: CellSet = match group.dimension {
        0 => {
            let node = |cell| mesh.cells.get(cell).nodes[0] as usize;
            group.cells.iter().map(node).collect()
        }
        _ => numbering.elements(&group.cells),
    };
    let mut ranges = numbers.ranges();
    if let (Some(range), None) = (ranges.next(), ranges.next()) {
        let ends = [range.start as i64 + 1, range.end as i64];
        draft.integers(
            parent,
            ("PointRange", "IndexRange_t"),
            (integer, &[1, 2]),
            &ends,
        );
    } else {
        let list: Vec<i64> = numbers.iter().map(|cell| cell as i64 + 1).collect();
        let kind = (integer, &[1, list.len() as u64][..]);
        draft.integers(parent, ("PointList", "IndexArray_t"), kind, &list);
    }
    draft.text(parent, ("GridLocation", "GridLocation_t"), location);
}

/// Families of a base, one for each name of a group.
struct Families<'a> {
    base: Id,
    /// Name in the file of each.
    names: BTreeMap<&'a str, String>,
    /// Families in the file, and whether each has a condition.
    written: BTreeMap<String, (Id, bool)>,
}

impl<'a> Families<'a> {
    fn new(base: Id, mesh: &'a MeshView<'a>) -> Self {
        let names = mesh.groups.iter().map(|group| group.name.as_str());
        let taken = UniqueNames::with([ZONE.0, TIMES, SIMULATION, "DataClass", FIELD_ARRAYS]);
        Self {
            base,
            names: taken.by_name(names, &RULE),
            written: BTreeMap::new(),
        }
    }

    /// The name of the family of a group.
    fn family(&mut self, draft: &mut Draft, group: &Group, notes: &mut Notes) -> String {
        let (base, name) = (self.base, self.names[group.name.as_str()].clone());
        let new = || {
            let family = draft.group(base, (&name, "Family_t"));
            // VTK's reader complains of a family without children.
            draft.text(family, (FULL_NAME, "Descriptor_t"), &group.name);
            notes.extend(RULE.note("group", &group.name, &name));
            (family, false)
        };
        let (family, has_condition) = self.written.entry(name.clone()).or_insert_with(new);
        match (&group.condition, known_condition(group)) {
            (Some(_), Some(condition)) if !*has_condition => {
                draft.text(*family, ("FamilyBC", "FamilyBC_t"), condition);
                *has_condition = true;
            }
            (Some(condition), None) => notes.push(note!(
                "unknown_condition",
                "the condition \"{condition}\" of \"{}\" is not known to CGNS",
                group.name
            )),
            _ => {}
        }
        name
    }
}
