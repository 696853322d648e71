//! Boundary conditions and subregions of a zone: their names, and what they are given by.

use super::builder::MeshBuilder;
use super::families::{self, Families};
use super::node::Node;
use super::zone::Zone;
use azimesh_core::error::Result;
use std::ops::Range;

/// A part of a zone that has a name.
pub(super) struct Region<'a> {
    pub node: &'a Node,
    /// Names that users know it by.
    pub names: Vec<String>,
    /// Type of its boundary condition.
    pub condition: Option<String>,
    pub place: GridLocation,
    /// Whether the file gives the grid location.
    pub says_place: bool,
    /// Dimension of its elements.
    pub dimension: u8,
    /// Numbers as they are in the file: one an entity in an unstructured zone, else one an index.
    pub numbers: Vec<i64>,
    /// Whether the numbers are the two ends of a range.
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
    for conditions in zone.node.labelled("ZoneBC_t")? {
        for node in conditions.labelled("BC_t")? {
            let text = node.text_or_none()?;
            let known = families::condition(&text);
            let boundary = zone.cell_dimension - 1;
            regions.extend(region(node, boundary, known, families, found)?);
        }
    }
    for node in zone.node.labelled("ZoneSubRegion_t")? {
        regions.extend(region(node, dimension_of(node)?, None, families, found)?);
    }
    for node in zone.node.labelled("UserDefinedData_t")? {
        if node.name() == super::CELL_ORDER {
            continue;
        }
        if is_group(node)? {
            regions.extend(region(node, own_dimension(node)?, None, families, found)?);
        } else {
            found.leave("UserDefinedData_t", 1);
        }
    }
    Ok(regions)
}

fn region<'a>(
    node: &'a Node,
    dimension: u8,
    mut condition: Option<String>,
    families: &Families,
    found: &mut MeshBuilder,
) -> Result<Option<Region<'a>>> {
    let mut names = Vec::new();
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

/// Names of the lists of nodes or elements, and then of those of elements only.
const GIVEN_BY: [&str; 4] = ["PointRange", "PointList", "ElementRange", "ElementList"];

/// What a region is given by: the numbers, what they refer to, and whether the file says so.
fn given(node: &Node) -> Result<Option<(&Node, GridLocation, bool)>> {
    let is_list = |child: &&Node| {
        ["IndexRange_t", "IndexArray_t"].contains(&child.label())
            && GIVEN_BY.contains(&child.name())
    };
    let Some(points) = node.children()?.iter().rfind(is_list) else {
        return Ok(None);
    };
    let said = match node.child("GridLocation")? {
        Some(location) => place(location)?,
        None => None,
    };
    let place = match said {
        _ if points.name().starts_with("Element") => GridLocation::Elements,
        said => said.unwrap_or(GridLocation::Nodes),
    };
    Ok(Some((points, place, said.is_some())))
}

/// Whether a region of a zone may be given by nodes, for which faces are made where the file has none. O(regions).
pub(super) fn may_be_of_nodes(zone: &Zone) -> Result<bool> {
    let boundary = zone.cell_dimension - 1;
    let mut nodes: Vec<&Node> = Vec::new();
    for conditions in zone.node.labelled("ZoneBC_t")? {
        nodes.extend(conditions.labelled("BC_t")?);
    }
    for node in zone.node.labelled("ZoneSubRegion_t")? {
        if dimension_of(node)? == boundary {
            nodes.push(node);
        }
    }
    for node in zone.node.labelled("UserDefinedData_t")? {
        if is_group(node)? && own_dimension(node)? == boundary {
            nodes.push(node);
        }
    }
    for node in nodes {
        if given(node)?.is_some_and(|(_, place, _)| place == GridLocation::Nodes) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The dimension of a subregion.
fn dimension_of(subregion: &Node) -> Result<u8> {
    match subregion.integers()?[..] {
        [dimension @ 0..=3] => Ok(dimension as u8),
        _ => Err(subregion.refuse("the dimension of a subregion must be 0 to 3")),
    }
}

/// Whether data of users are a group.
fn is_group(node: &Node) -> Result<bool> {
    let has = |name| Ok::<_, azimesh_core::error::Error>(node.child(name)?.is_some());
    Ok(has("FamilyName")? && (has("PointRange")? || has("PointList")?))
}

/// The dimension of a group that is in data of users.
fn own_dimension(group: &Node) -> Result<u8> {
    let is_of_nodes = group.child_text("GridLocation")?.as_deref() == Some("Vertex");
    Ok(if is_of_nodes { 0 } else { 1 })
}

/// The grid location of a GridLocation_t; `None` where there is none.
fn place(location: &Node) -> Result<Option<GridLocation>> {
    let place = match location.text_or_none()?.as_str() {
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
    };
    Ok(Some(place))
}

/// The name of such regions in notes.
fn noun(node: &Node) -> &'static str {
    match node.label() {
        "BC_t" => "boundary conditions",
        _ => "groups",
    }
}

impl Region<'_> {
    /// Counts it among what is left behind, since it has no cells.
    pub fn leave(&self, found: &mut MeshBuilder) {
        let what = format!("{} for which no cells were found", noun(self.node));
        found.leave_named(&what, self.node.name());
    }

    /// The numbers of an unstructured zone as ranges, in the order of the file.
    pub fn ranges(&self) -> Vec<Range<i64>> {
        if let (true, &[a, b]) = (self.is_range, &self.numbers[..]) {
            let range = a.min(b)..a.max(b).saturating_add(1);
            return std::iter::once(range).collect();
        }
        let follows = |a: &i64, b: &i64| a.checked_add(1) == Some(*b);
        let stretches = self.numbers.chunk_by(follows);
        let range = |s: &[i64]| s[0]..s[s.len() - 1].saturating_add(1);
        stretches.map(range).collect()
    }
}
