//! Notes of writers.

use super::quoted;
use std::fmt::{self, Display, Formatter};

/// An array that is not in a file as it was.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum ArrayWritten {
    /// The format has no such arrays.
    LeftOut {
        format: &'static str,
        what: &'static str,
        names: Vec<String>,
    },
    /// The format has no text there.
    TextLeftOut { format: &'static str, name: String },
    /// Its name stands for tags, or no text is wanted.
    NotWritten { name: String },
    /// It has no values.
    WithoutValues { name: String },
    /// It has more components than the format allows.
    TooManyComponents { name: String, n: usize, most: usize },
    /// It becomes an array a component.
    ComponentsApart { name: String, n: usize },
    /// Its components lose their names.
    ComponentNames { name: String },
    /// It has integers above the largest of the format.
    IntegersTooLarge { name: String },
    /// It has integers that reals do not hold.
    IntegersRounded { name: String },
    /// Its text has zeros.
    ZerosInText { name: String },
    /// Its values on faces are left out.
    FaceValues { name: String },
    /// Its name is that of global numbers.
    ReplacedByNumbers { name: String },
}

impl Display for ArrayWritten {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeftOut {
                format,
                what,
                names,
            } => {
                let names = quoted(names);
                write!(f, "{format} holds no {what} arrays; left out: {names}")
            }
            Self::TextLeftOut { format, name } => match *format {
                "CGNS" => write!(f, "array \"{name}\" of text is not written"),
                "VTKHDF" => write!(
                    f,
                    "the array \"{name}\" is left out: VTK reads no text at nodes or cells"
                ),
                format => write!(f, "{format} holds no text; array \"{name}\" is left out"),
            },
            Self::NotWritten { name } => write!(f, "the array \"{name}\" is not written"),
            Self::WithoutValues { name } => {
                write!(f, "field array \"{name}\" is not written: it has no values")
            }
            Self::TooManyComponents { name, n, most } => write!(
                f,
                "array \"{name}\" is left out: it has {n} components, and MSH holds fields of {most} at most"
            ),
            Self::ComponentsApart { name, n } => {
                write!(
                    f,
                    "array \"{name}\" of {n} components is written as so many arrays"
                )
            }
            Self::ComponentNames { name } => {
                write!(f, "names of the components of \"{name}\" are not written")
            }
            Self::IntegersTooLarge { name } => write!(
                f,
                "array \"{name}\" is not written: it has integers above {}, the largest of CGNS",
                i64::MAX
            ),
            Self::IntegersRounded { name } => write!(
                f,
                "array \"{name}\" has integers above 2^53, which MSH holds as the nearest 64-bit real"
            ),
            Self::ZerosInText { name } => {
                write!(
                    f,
                    "bytes of zero in the text of \"{name}\" are written as \"_\""
                )
            }
            Self::FaceValues { name } => write!(
                f,
                "values of the array \"{name}\" on faces are not kept: CGNS has values of cells"
            ),
            Self::ReplacedByNumbers { name } => {
                write!(
                    f,
                    "the array \"{name}\" is replaced by numbers that count through"
                )
            }
        }
    }
}

/// A group that is not in a file as it was, or a name.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum GroupWritten {
    /// A name, of an array too, is written as another: the format allows no such name, or `is_taken` the
    /// one that it would allow.
    Renamed {
        what: &'static str,
        name: String,
        written: String,
        why: &'static str,
        is_taken: bool,
    },
    /// Its number is another.
    Renumbered { name: String, number: i32, own: i32 },
    /// Tags of one name become one.
    Joined { name: String, n: usize },
    /// It has no cells.
    Empty { name: String },
    /// Zones, in a format that has none or none such.
    ZonesLeftOut {
        format: &'static str,
        names: Vec<String>,
    },
    /// Zones are numbered.
    ZoneNames { n: usize, names: Vec<String> },
    /// Groups of lower dimension than boundary tags.
    LowerLeftOut {
        format: &'static str,
        names: Vec<String>,
    },
    /// Tags of faces beyond one a face.
    FaceTagsLeftOut { n: usize },
    /// Groups of cells in several, of which an array holds the first.
    OfSeveral {
        n: usize,
        array: &'static str,
        cell: usize,
    },
    /// Boundary faces in no tag are left out.
    UntaggedLeftOut { n: usize },
    /// Boundary faces in no tag have a number of their own.
    UntaggedNumbered { n: usize, number: i32, name: String },
    /// Names of tags were not wanted.
    NamesNotWritten,
}

impl Display for GroupWritten {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Renamed {
                what,
                name,
                written,
                why,
                is_taken,
            } => {
                write!(f, "{what} {name:?} is written as \"{written}\": {why}")?;
                f.write_str(if *is_taken {
                    ", and that name is taken"
                } else {
                    ""
                })
            }
            Self::Renumbered { name, number, own } => write!(
                f,
                "group \"{name}\" has number {number} instead of {own}, which is taken or none of MSH"
            ),
            Self::Joined { name, n } => {
                write!(f, "{n} tags are called \"{name}\" and become one")
            }
            Self::Empty { name } => {
                write!(
                    f,
                    "group \"{name}\" has no cells; CGNS keeps its family alone"
                )
            }
            Self::ZonesLeftOut { format, names } => {
                let when = match *format {
                    "SU2" => "zones only where they are all of the mesh and share no nodes",
                    _ => "no zones",
                };
                write!(f, "{format} holds {when}; left out: {}", quoted(names))
            }
            Self::ZoneNames { n, names } => {
                let names = quoted(names);
                write!(
                    f,
                    "zones are written as IZONE= 1 to {n}; names left out: {names}"
                )
            }
            Self::LowerLeftOut { format, names } => {
                let names = quoted(names);
                write!(
                    f,
                    "{format} holds boundary tags only; groups left out: {names}"
                )
            }
            Self::FaceTagsLeftOut { n } => write!(
                f,
                "UGRID holds one number for a face; {n} more tags of faces in several are left out"
            ),
            Self::OfSeveral { n, array, cell } => write!(
                f,
                "{n} cells are in more than one group; the array {array} holds the first (cell {cell})"
            ),
            Self::UntaggedLeftOut { n } => {
                write!(f, "{n} boundary elements without a tag are left out")
            }
            Self::UntaggedNumbered { n, number, name } => {
                write!(
                    f,
                    "{n} boundary faces without a tag have number {number}, \"{name}\""
                )
            }
            Self::NamesNotWritten => f.write_str("names of tags are not written, as was asked"),
        }
    }
}

/// The type of a boundary condition that a file does not hold as it was.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum Condition {
    /// Those of so many groups: the format has none.
    NotWritten { format: &'static str, n: usize },
    /// It has no number.
    WithoutNumber { condition: String, tag: String },
    /// It is written as the number of another.
    WrittenAs {
        condition: String,
        tag: String,
        number: i32,
    },
    /// Tags have none.
    Missing { tags: Vec<String> },
    /// CGNS does not know it.
    Unknown { condition: String, group: String },
}

impl Display for Condition {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotWritten { format, n } => match *format {
                "SU2" => f.write_str(
                    "types of boundary conditions are not written: SU2 has them in its configuration",
                ),
                "MSH" => write!(
                    f,
                    "MSH holds no types of boundary conditions; those of {n} tags are left out"
                ),
                _ => f.write_str("types of boundary conditions are not written"),
            },
            Self::WithoutNumber { condition, tag } => write!(
                f,
                "condition {condition} of tag \"{tag}\" has no number in FUN3D; 0 is written"
            ),
            Self::WrittenAs {
                condition,
                tag,
                number,
            } => write!(
                f,
                "condition {condition} of tag \"{tag}\" is written as FUN3D's {number}"
            ),
            Self::Missing { tags } => write!(
                f,
                "tags without a boundary condition have number 0 in the .mapbc: {}",
                quoted(tags)
            ),
            Self::Unknown { condition, group } => {
                write!(f, "the condition \"{condition}\" of \"{group}\" is none of CGNS")
            }
        }
    }
}

/// Something else that is not in a file as it was.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of the fields say it
pub enum Written {
    /// Coordinates were asked for in 32 bits, which the format does not have.
    CoordinatesIn64 { format: &'static str },
    /// Coordinates lose digits.
    CoordinatesRounded,
    /// The height of a plane mesh.
    HeightLeftOut { z: f64 },
    /// Cells of lower dimension.
    LowerCellsLeftOut { n: usize },
    /// Nodes come zone by zone.
    NodesByZone,
    /// Cells come type by type.
    CellsByType,
    /// A device or a pipe has no place for a file beside it.
    BesideLeftOut,
    /// Nodes or elements are counted from 1.
    CountedFromOne { what: &'static str },
}

impl Display for Written {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::CoordinatesIn64 { format: "UGRID" } => {
                f.write_str("coordinates are written in 64 bits; ugrid-b4 has 32")
            }
            Self::CoordinatesIn64 { format } => {
                write!(f, "{format} holds coordinates in f64 only")
            }
            Self::CoordinatesRounded => f.write_str("coordinates are rounded to 32 bits"),
            Self::HeightLeftOut { z } => {
                write!(f, "SU2 holds no z of a plane mesh; left out: z = {z}")
            }
            Self::LowerCellsLeftOut { n } => {
                write!(f, "{n} cells of lower dimension are left out")
            }
            Self::NodesByZone => f.write_str("nodes are written zone by zone, in another order"),
            Self::CellsByType => f.write_str(
                "cells are in the order of their types: as they were, they would be too many sections",
            ),
            Self::BesideLeftOut => f.write_str(
                "names and conditions of tags are not written: they are in a file beside the mesh, for which \
                 a device or a pipe has no place",
            ),
            Self::CountedFromOne { what } => write!(
                f,
                "{what} are counted from 1: data of MSH refer to numbers up to {}, and theirs are higher",
                i32::MAX
            ),
        }
    }
}
