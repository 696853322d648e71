//! Notes of readers.

use super::{LISTED, more, quoted};
use crate::error::counted;
use std::fmt::{self, Display, Formatter};

/// An array of a file that is left out, or is not quite what it was.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum ArrayRead {
    /// It has more tuples than the mesh has nodes or cells.
    TooLong { what: &'static str, name: String },
    /// It is not of the same form in all pieces.
    NotAlike { what: &'static str, name: String },
    /// It has not one tuple a node or cell.
    Misfit {
        what: &'static str,
        name: String,
        n_tuples: usize,
        n_components: usize,
        n_items: usize,
    },
    /// It shared its name with others and has another one here.
    Renamed {
        what: &'static str,
        name: String,
        here: String,
    },
    /// The same of an array of a solution in a CGNS file.
    OfSolutionRenamed {
        solution: String,
        name: String,
        here: String,
    },
    /// It differs between pieces.
    OfFirstPiece { name: String },
    /// Its elements are not known.
    WithoutElements { name: String, error: String },
    /// Its sections differ in their components.
    ComponentsDiffer { name: String, what: &'static str },
    /// It has values for nodes or elements that are not there.
    ValuesElsewhere {
        name: String,
        what: &'static str,
        n: usize,
    },
    /// It lacks values.
    ValuesMissing {
        name: String,
        what: &'static str,
        n: usize,
        of: usize,
    },
}

impl Display for ArrayRead {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { what, name } => write!(
                f,
                "the {what} array \"{name}\" is left out: it has more tuples than there are {what}s"
            ),
            Self::NotAlike { what, name } => write!(
                f,
                "the {what} array \"{name}\" is left out: the pieces do not all have it alike"
            ),
            Self::Misfit {
                what,
                name,
                n_tuples,
                n_components,
                n_items,
            } => write!(
                f,
                "the {what} array \"{name}\" is left out: it has {n_tuples} tuples of {n_components} \
                 components for {n_items} {what}s"
            ),
            Self::Renamed { what, name, here } => write!(
                f,
                "several {what} arrays are called \"{name}\"; one of them is \"{here}\" here"
            ),
            Self::OfSolutionRenamed {
                solution,
                name,
                here,
            } => write!(
                f,
                "several arrays are called \"{name}\"; that of \"{solution}\" is \"{here}\" here"
            ),
            Self::OfFirstPiece { name } => write!(
                f,
                "the field array \"{name}\" is that of the first piece; others differ"
            ),
            Self::WithoutElements { name, error } => {
                write!(f, "data \"{name}\" of elements are not kept: {error}")
            }
            Self::ComponentsDiffer { name, what } => write!(
                f,
                "data \"{name}\" of {what} have different numbers of components and are not kept"
            ),
            Self::ValuesElsewhere { name, what, n } => {
                let values = counted(*n, "value");
                write!(
                    f,
                    "\"{name}\" has {values} for {what} that are not in the mesh"
                )
            }
            Self::ValuesMissing { name, what, n, of } => {
                write!(
                    f,
                    "\"{name}\" has no value at {n} of {of} {what}, where it is NaN"
                )
            }
        }
    }
}

/// A part of a file that a mesh does not hold.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum NotKept {
    /// A part with a name: a group, a lookup table.
    Named { what: &'static str, name: String },
    /// An entry of metadata, as it is shown.
    Information { shown: String },
    /// A keyword of SU2 and its lines.
    Keyword { name: String, n_lines: usize },
    /// Keywords beyond those that are named.
    Keywords { n: usize },
    /// So many items' further data: `what` of `n` times `item`.
    Of {
        what: &'static str,
        n: usize,
        item: &'static str,
    },
    /// Values at other times.
    Times { n: usize },
    /// Nodes of a CGNS file, by their label or in words.
    Nodes { what: String, n: usize },
    /// Nodes of a CGNS file, by their names.
    NamedNodes { what: String, names: Vec<String> },
    /// A section of a Gmsh file.
    Section { name: String },
    /// What stands behind the last cell of a UGRID file: bytes or numbers.
    Rest { n: usize, what: &'static str },
    /// Blanking of nodes.
    Blanking,
}

impl Display for NotKept {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named { what, name } => write!(f, "the {what} \"{name}\" is not kept"),
            Self::Information { shown } => write!(f, "the information {shown} is not kept"),
            Self::Keyword { name, n_lines } => {
                write!(f, "{name}= is not kept ({})", counted(*n_lines, "line"))
            }
            Self::Keywords { n } => write!(f, "{n} more keywords are not kept"),
            Self::Of { what, n, item } => {
                write!(f, "{what} of {} are not kept", counted(*n, item))
            }
            Self::Times { n } => {
                let times = counted(*n, "other time");
                write!(f, "values of {times} of the data are not kept")
            }
            Self::Nodes { what, n } => match (what.contains(' '), n) {
                (true, _) => write!(f, "{n} {what} are not kept"),
                (false, 1) => write!(f, "a node of type {what} is not kept"),
                (false, _) => write!(f, "{n} nodes of type {what} are not kept"),
            },
            Self::NamedNodes { what, names } => {
                let more = more(names.len(), LISTED);
                let names = names[..names.len().min(LISTED)].join(", ");
                write!(f, "{what} are not kept: {names}{more}")
            }
            Self::Section { name } => match name.as_str() {
                "Periodic" => {
                    f.write_str("periodic links between entities ($Periodic) are not kept")
                }
                "GhostElements" => {
                    f.write_str("ghost elements of partitions ($GhostElements) are not kept")
                }
                "ElementNodeData" => f.write_str(
                    "values at each element's own nodes ($ElementNodeData) are not kept",
                ),
                name => write!(f, "section ${name} is not kept"),
            },
            Self::Rest { n, what } => write!(
                f,
                "{n} {what} behind the last cell, such as volume numbers, are not kept"
            ),
            Self::Blanking => {
                f.write_str("blanking is not kept: cells at blanked nodes are like others")
            }
        }
    }
}

/// Something else that is to be known of a file that was read.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum Read {
    /// Texts that are not UTF-8 were read as Latin-1.
    Latin1 { texts: Vec<String> },
    /// So was an XML file.
    XmlLatin1,
    /// Groups share names: each with the number of groups.
    SharedNames {
        what: &'static str,
        names: Vec<(String, usize)>,
    },
    /// `NMARK=` is not the number of markers.
    MarkerCount { said: usize, found: usize },
    /// Markers of one name are one tag.
    MarkersJoined { name: String, n: usize },
    /// The file beside a UGRID file cannot be used.
    ConditionsUnused { error: String },
    /// It has not the number of patches that it says.
    PatchCount { said: usize, found: usize },
    /// Marks of Fortran's records are wrong.
    WrongRecordMarks,
    /// Elements of several partitions.
    SeveralPartitions { n: usize },
    /// Physical groups are named and no `$Entities` says what is in them.
    GroupsWithoutEntities { n: usize },
    /// A physical group has two names.
    SecondName {
        number: i32,
        dimension: u8,
        used: String,
        other: String,
    },
    /// Hexahedra of high order whose degrees are not known.
    OldOrder { n: usize },
    /// Cells were split into simpler ones.
    Split {
        from: &'static str,
        n: u64,
        into: &'static str,
        n_into: u64,
    },
    /// Cells without a shape.
    EmptyCells { n: u64, with_nodes: bool },
    /// Elements of which no cell has the nodes between the corners.
    OnlyCorners { element: &'static str, n: usize },
    /// A zone of a CGNS file has not the number of cells that it says.
    CellCount {
        zone: String,
        said: usize,
        dimension: u8,
        found: usize,
    },
}

impl Display for Read {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latin1 { texts } => {
                let listed = quoted(&texts[..texts.len().min(LISTED)]);
                let more = more(texts.len(), LISTED);
                write!(f, "not UTF-8; read as Latin-1: {listed}{more}")
            }
            Self::XmlLatin1 => f.write_str("the XML is not UTF-8; read as Latin-1"),
            Self::SharedNames { what, names } => fmt_shared(what, names, f),
            Self::MarkerCount { said, found } => {
                write!(
                    f,
                    "NMARK= {said}, but there are {found} markers; all are read"
                )
            }
            Self::MarkersJoined { name, n } => {
                write!(f, "{n} markers are called \"{name}\"; they become one tag")
            }
            Self::ConditionsUnused { error } => {
                write!(f, "names and conditions of tags are not used: {error}")
            }
            Self::PatchCount { said, found } => {
                write!(
                    f,
                    "the .mapbc promises {said} patches and has {found}; all are read"
                )
            }
            Self::WrongRecordMarks => {
                f.write_str("the marks of Fortran's records are wrong; the length fits")
            }
            Self::SeveralPartitions { n } => {
                write!(
                    f,
                    "{n} elements are in several partitions; the first of them is kept"
                )
            }
            Self::GroupsWithoutEntities { n } => {
                let groups = counted(*n, "physical group");
                write!(
                    f,
                    "{groups} without elements: there is no $Entities, which says what is in them"
                )
            }
            Self::SecondName {
                number,
                dimension,
                used,
                other,
            } => write!(
                f,
                "physical group {number} of dimension {dimension} has two names; \"{used}\" is used, not \
                 \"{other}\""
            ),
            Self::OldOrder { n } => write!(
                f,
                "{n} hexahedra of high order are left in the order of nodes before VTK 9: their degrees are \
                 not given"
            ),
            Self::Split {
                from,
                n,
                into,
                n_into,
            } => fmt_split((from, *n), (into, *n_into), f),
            Self::EmptyCells { n, with_nodes } => fmt_empty(*n, *with_nodes, f),
            Self::OnlyCorners { element, n } => write!(
                f,
                "of {n} elements of type {element} only the corner nodes are kept: no cell has their others"
            ),
            Self::CellCount {
                zone,
                said,
                dimension,
                found,
            } => write!(
                f,
                "{zone}: it should have {said} cells of dimension {dimension}; its sections have {found}"
            ),
        }
    }
}

fn fmt_shared(what: &str, names: &[(String, usize)], f: &mut Formatter<'_>) -> fmt::Result {
    let listed = names.iter().take(LISTED);
    let each: Vec<String> = listed
        .map(|(name, n)| format!("{n} are called \"{name}\""))
        .collect();
    let more = match names.len().saturating_sub(LISTED) {
        0 => String::new(),
        n => format!(", and {} more are shared", counted(n, "name")),
    };
    let each = each.join(", ");
    write!(
        f,
        "of the {what}, {each}{more}; by its name all of them are meant"
    )
}

fn fmt_split(
    (from, n): (&str, u64),
    (into, n_into): (&str, u64),
    f: &mut Formatter<'_>,
) -> fmt::Result {
    let into = into.replace("vertex", "vertice");
    match n {
        1 => write!(f, "1 {from} is split into {n_into} {into}s"),
        n => {
            let from = from.replace("vertex", "vertice");
            write!(f, "{n} {from}s are split into {n_into} {into}s")
        }
    }
}

fn fmt_empty(n: u64, with_nodes: bool, f: &mut Formatter<'_>) -> fmt::Result {
    match n {
        1 => f.write_str("1 empty cell is left out")?,
        n => write!(f, "{n} empty cells are left out")?,
    }
    f.write_str(if with_nodes {
        ", with the nodes they list"
    } else {
        ""
    })
}

/// How the pieces of a mesh were joined.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum Pieces {
    /// Nodes of one global number lie apart.
    NumbersUnused,
    /// Cells share no nodes within a piece.
    NotJoined,
    /// Places at which a piece has several nodes.
    KeptApart { n: usize },
    /// Pieces are joined at nodes of one number or one place.
    Joined {
        n: usize,
        n_nodes: usize,
        by: &'static str,
    },
    /// Copies of a neighbour's cells.
    GhostsLeftOut,
    /// Cells are marked as hidden.
    Hidden,
}

impl Display for Pieces {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NumbersUnused => f.write_str(
                "global numbers of nodes are not used: they join nodes at different places",
            ),
            Self::NotJoined => {
                f.write_str("the pieces are not joined: their cells have nodes of their own")
            }
            Self::KeptApart { n } => write!(
                f,
                "nodes at {n} places are kept apart: a piece has several of them there"
            ),
            Self::Joined { n, n_nodes, by } => {
                write!(
                    f,
                    "{n} pieces are joined at {n_nodes} nodes that have the same {by}"
                )
            }
            Self::GhostsLeftOut => f.write_str("ghost cells of the pieces are left out"),
            Self::Hidden => f.write_str("cells marked as hidden are like others"),
        }
    }
}
