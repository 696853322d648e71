//! Boundary conditions and subregions of a zone: their nodes or elements, their names and conditions, by the families of
//! their base.

use super::builder::MeshBuilder;
use super::node::Node;
use super::zone::Zone;
use crate::mesh::NodeBits;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::ops::Range;

/// A part of a zone that has a name.
pub(super) struct Region<'a> {
    pub node: &'a Node,
    /// Names that users know it by.
    pub names: Vec<String>,
    /// Type of its boundary condition.
    pub condition: Option<String>,
    pub place: GridLocation,
    /// True if the file gives the grid location.
    pub says_place: bool,
    /// Dimension of its elements.
    pub dimension: u8,
    /// Numbers as they are in the file: one an entity in an unstructured zone, else one an index.
    pub numbers: Vec<i64>,
    /// True if the numbers are the two ends of a range.
    pub is_range: bool,
}

/// The items that the numbers of a region refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GridLocation {
    /// Nodes, by declaration or by default.
    Nodes,
    /// Elements, or faces of a structured zone.
    Elements,
    /// Cells of a structured zone.
    CellCenters,
    /// Faces of a structured zone across this index.
    FacesAcross(usize),
}

/// The regions of a zone, in the order of the file.
pub(super) fn regions<'a>(
    zone: &Zone<'a>,
    families: &Families,
    found: &mut MeshBuilder,
) -> Result<Vec<Region<'a>>> {
    let mut regions = Vec::new();
    for (node, dimension) in candidates(zone)? {
        match dimension {
            Some(dimension) => regions.extend(region(node, dimension, families, found)?),
            None => found.leave(node.label(), 1),
        }
    }
    Ok(regions)
}

/// Nodes of a zone that may be regions with the dimension of their elements; none for other data of users.
fn candidates<'a>(zone: &Zone<'a>) -> Result<Vec<(&'a Node, Option<u8>)>> {
    let mut found = Vec::new();
    for conditions in zone.node.labelled("ZoneBC_t")? {
        let boundary = Some(zone.cell_dimension - 1);
        found.extend(conditions.labelled("BC_t")?.map(|node| (node, boundary)));
    }
    for node in zone.node.labelled("ZoneSubRegion_t")? {
        let [dimension @ 0..=3] = node.integers()?[..] else {
            return Err(node.refuse("the dimension of a subregion must be 0 to 3"));
        };
        found.push((node, Some(dimension as u8)));
    }
    for node in zone.node.labelled("UserDefinedData_t")? {
        let has = |name| Ok::<_, Error>(node.child(name)?.is_some());
        if has("FamilyName")? && (has("PointRange")? || has("PointList")?) {
            let is_of_nodes = node.child_text("GridLocation")?.as_deref() == Some("Vertex");
            found.push((node, Some(if is_of_nodes { 0 } else { 1 })));
        } else if node.name() != super::CELL_ORDER {
            found.push((node, None));
        }
    }
    Ok(found)
}

/// Tests if nodes may give a region of a zone. Faces are then made if the file has none. O(regions).
pub(super) fn may_be_of_nodes(zone: &Zone) -> Result<bool> {
    for (node, dimension) in candidates(zone)? {
        if dimension == Some(zone.cell_dimension - 1)
            && given(node)?.is_some_and(|(_, place, _)| place == GridLocation::Nodes)
        {
            return Ok(true);
        }
    }
    Ok(false)
}

fn region<'a>(
    node: &'a Node,
    dimension: u8,
    families: &Families,
    found: &mut MeshBuilder,
) -> Result<Option<Region<'a>>> {
    let mut names = Vec::new();
    let mut condition = None;
    if node.label() == "BC_t" {
        condition = condition_of(&node.text_or_none()?);
    }
    let mut full_name = None;
    for child in node.children()? {
        match (child.label(), child.name()) {
            ("FamilyName_t" | "AdditionalFamilyName_t", _) => {
                let family = child.text_or_none()?;
                condition = condition.or_else(|| families.condition(&family).map(str::to_owned));
                names.extend(families.names(&family));
            }
            ("IndexRange_t" | "IndexArray_t", name) if GIVEN_BY.contains(&name) => {}
            ("Descriptor_t", super::FULL_NAME) => full_name = Some(child.own_text()?),
            ("GridLocation_t" | "Ordinal_t", _) | (_, "InwardNormalList") => {}
            (label, _) => found.leave(label, 1),
        }
    }
    if names.is_empty() {
        names.push(full_name.unwrap_or_else(|| node.name().to_owned()));
    }
    names.dedup();
    let Some((points, place, says_place)) = given(node)? else {
        found.leave_named(&format!("{} without points", noun(node)), node.name());
        return Ok(None);
    };
    Ok(Some(Region {
        node,
        names,
        condition,
        place,
        says_place,
        dimension,
        numbers: points.integers()?,
        is_range: points.name().ends_with("Range"),
    }))
}

/// Names of the lists of nodes or elements, and then of the lists of elements only.
const GIVEN_BY: [&str; 4] = ["PointRange", "PointList", "ElementRange", "ElementList"];

/// Finds the numbers of a region, the items that they refer to, and whether the file says so.
fn given(node: &Node) -> Result<Option<(&Node, GridLocation, bool)>> {
    let is_list = |child: &&Node| {
        ["IndexRange_t", "IndexArray_t"].contains(&child.label())
            && GIVEN_BY.contains(&child.name())
    };
    let Some(points) = node.children()?.iter().rfind(is_list) else {
        return Ok(None);
    };
    let said = node
        .child("GridLocation")?
        .map(place)
        .transpose()?
        .flatten();
    let place = if points.name().starts_with("Element") {
        GridLocation::Elements
    } else {
        said.unwrap_or(GridLocation::Nodes)
    };
    Ok(Some((points, place, said.is_some())))
}

/// The grid location of a GridLocation_t; `None` where there is none.
fn place(location: &Node) -> Result<Option<GridLocation>> {
    Ok(Some(match location.text_or_none()?.as_str() {
        "" | "Null" | "UserDefined" | "GridLocationNull" | "GridLocationUserDefined" => {
            return Ok(None);
        }
        "Vertex" => GridLocation::Nodes,
        "CellCenter" => GridLocation::CellCenters,
        "FaceCenter" | "EdgeCenter" => GridLocation::Elements,
        "IFaceCenter" => GridLocation::FacesAcross(0),
        "JFaceCenter" => GridLocation::FacesAcross(1),
        "KFaceCenter" => GridLocation::FacesAcross(2),
        other => {
            return Err(location.refuse(format!(
                "the location \"{other}\" is not known; CGNS has Vertex, CellCenter, FaceCenter, IFaceCenter, JFaceCenter, \
                 KFaceCenter and EdgeCenter"
            )));
        }
    }))
}

/// The name of such regions in notes.
fn noun(node: &Node) -> &'static str {
    if node.label() == "BC_t" {
        "boundary conditions"
    } else {
        "groups"
    }
}

impl Region<'_> {
    /// Makes its cells groups; notes a region without cells.
    pub fn tag(&self, cells: &[Range<usize>], zone: &Zone, found: &mut MeshBuilder) {
        if cells.iter().all(Range::is_empty) {
            let what = format!("{} for which no cells were found", noun(self.node));
            found.leave_named(&what, self.node.name());
        }
        for name in &self.names {
            tag(name, self.condition.as_deref(), cells, zone, found);
        }
    }

    /// Its nodes in an unstructured zone; `None` for a region of elements, or where the numbers are too large for nodes.
    pub fn nodes(&self, zone: &Zone) -> Option<NodeBits> {
        let nodes = zone.nodes();
        let ranges = self.ranges();
        let fits = |range: &Range<i64>| range.start >= 1 && range.end <= nodes.len() as i64 + 1;
        if self.place != GridLocation::Nodes || !ranges.iter().all(fits) {
            return None;
        }
        let bits = NodeBits::new(&nodes);
        let index = |number: i64| nodes.start + number as usize - 1;
        for range in ranges {
            bits.add_all(&(index(range.start)..index(range.end)));
        }
        Some(bits)
    }

    /// The numbers of an unstructured zone as ranges, in the order of the file.
    pub fn ranges(&self) -> Vec<Range<i64>> {
        if let (true, &[a, b]) = (self.is_range, &self.numbers[..]) {
            return std::iter::once(a.min(b)..a.max(b).saturating_add(1)).collect();
        }
        let follows = |a: &i64, b: &i64| a.checked_add(1) == Some(*b);
        let stretches = self.numbers.chunk_by(follows);
        let range = |s: &[i64]| s[0]..s[s.len() - 1].saturating_add(1);
        stretches.map(range).collect()
    }
}

/// Adds cells to groups of this name, one for each dimension that they have.
pub(super) fn tag(
    name: &str,
    condition: Option<&str>,
    cells: &[Range<usize>],
    zone: &Zone,
    found: &mut MeshBuilder,
) {
    for dimension in 0..=3 {
        let runs = found
            .cells_in(cells)
            .filter(|run| run.kind.dimension() == dimension);
        let of_dimension: Vec<Range<usize>> = runs.map(|run| run.range()).collect();
        if !of_dimension.is_empty() {
            let place = zone.node.name();
            (found.tags).add(name, place, dimension, condition, of_dimension);
        }
    }
}

/// The families of a base by name.
#[derive(Default)]
pub(super) struct Families {
    by_name: BTreeMap<String, Family>,
    base: String,
}

#[derive(Default)]
struct Family {
    /// Full name, where that is too long for CGNS.
    full_name: Option<String>,
    condition: Option<String>,
    /// Families that it belongs to.
    within: Vec<String>,
}

/// Names that programs give to what belongs to no family.
const NONE: [&str; 4] = ["", "Unspecified", "ORPHAN", "Null"];

impl Families {
    /// Reads the families of a base, also those inside one another.
    pub fn read(base: &Node) -> Result<Self> {
        let mut families = Self {
            base: base.name().to_owned(),
            ..Self::default()
        };
        for node in base.labelled("Family_t")? {
            families.add(node, "", 0)?;
        }
        Ok(families)
    }

    fn add(&mut self, node: &Node, above: &str, depth: usize) -> Result<()> {
        let name = format!("{above}{}", node.name());
        let mut family = Family::default();
        for child in node.children()? {
            match child.label() {
                "FamilyBC_t" => family.condition = condition_of(&child.text_or_none()?),
                "FamilyName_t" => family.within.push(child.text_or_none()?),
                "Descriptor_t" if child.name() == super::FULL_NAME => {
                    family.full_name = Some(child.own_text()?);
                }
                "Family_t" if depth < 8 => self.add(child, &format!("{name}/"), depth + 1)?,
                _ => {}
            }
        }
        family.within.retain(|name| !name.is_empty());
        self.by_name.insert(name, family);
        Ok(())
    }

    /// Gives the user's names of a family: its parent families, or its own name; none if there is no such family.
    pub fn names(&self, family: &str) -> Vec<String> {
        let key = self.key(family);
        if NONE.contains(&key) {
            return Vec::new();
        }
        let family = self.by_name.get(key);
        match family.filter(|family| !family.within.is_empty()) {
            Some(family) => family.within.clone(),
            None => {
                let full_name = family.and_then(|family| family.full_name.as_deref());
                vec![full_name.unwrap_or(key).to_owned()]
            }
        }
    }

    /// The type of a family's boundary condition.
    pub fn condition(&self, family: &str) -> Option<&str> {
        self.by_name.get(self.key(family))?.condition.as_deref()
    }

    /// A family may be named by its path from the root.
    fn key<'a>(&self, family: &'a str) -> &'a str {
        let rest = family.strip_prefix('/').unwrap_or(family);
        let below = rest.strip_prefix(&self.base);
        let below = below.and_then(|rest| rest.strip_prefix('/'));
        below.unwrap_or(family)
    }
}

/// A type of boundary condition; `None` for words that say nothing.
fn condition_of(text: &str) -> Option<String> {
    let says_nothing = ["", "Null", "BCTypeNull", "FamilySpecified"].contains(&text);
    (!says_nothing).then(|| text.to_owned())
}
