//! Notes of writers: what a file does not hold of a mesh, or holds in another way.

use super::quoted;
use crate::diagnostic::notes::notes;
use crate::error::{counted, option};

notes! {
/// An array that a file does not hold, or holds in another way.
#[allow(missing_docs)] // the names of the fields say it
ArrayWritten {
    /// The format has no such arrays.
    LeftOut { format: &'static str, what: &'static str, names: Vec<String> } => (
        "{format} holds no {what} arrays; left out: {}", quoted(names)
    )
    /// The format has no text there.
    TextLeftOut { format: &'static str, name: String } => ("{}", text_left_out(format, name))
    /// Its name stands for tags, or no text is wanted.
    NotWritten { name: String } => ("the array \"{name}\" is not written")
    /// It has no values.
    WithoutValues { name: String } => ("field array \"{name}\" is not written: it has no values")
    /// It has more components than the format allows.
    TooManyComponents { name: String, n: usize, most: usize } => (
        "array \"{name}\" is left out: it has {n} components; MSH holds at most {most}"
    )
    /// Each component becomes an array.
    ComponentsApart { name: String, n: usize } => (
        "array \"{name}\" of {n} components is written as {n} arrays"
    )
    /// Its components lose their names.
    ComponentNames { name: String } => ("names of the components of \"{name}\" are not written")
    /// It has integers above the largest of the format.
    IntegersTooLarge { name: String } => (
        "array \"{name}\" is not written: it has integers above {}, the largest of CGNS", i64::MAX
    )
    /// It has integers that reals cannot represent.
    IntegersRounded { name: String } => (
        "array \"{name}\" has integers above 2^53, which MSH holds as the nearest 64-bit real"
    )
    /// Its text has zero bytes.
    ZerosInText { name: String } => ("zero bytes in the text of \"{name}\" are written as \"_\"")
    /// Its values on faces are left out.
    FaceValues { name: String } => (
        "values of the array \"{name}\" on boundary faces are not written: CGNS holds values of cells"
    )
    /// Its name is that of global numbers.
    ReplacedByNumbers { name: String } => (
        "the array \"{name}\" is replaced by consecutive numbers"
    )
}
}

fn text_left_out(format: &str, name: &str) -> String {
    match format {
        "CGNS" => format!("array \"{name}\" of text is not written"),
        "VTKHDF" => {
            format!("the array \"{name}\" is left out: VTK reads no text at nodes or cells")
        }
        format => format!("{format} holds no text; array \"{name}\" is left out"),
    }
}

notes! {
/// What a file holds and programs that read it do not take; `--portable` writes what they take.
#[allow(missing_docs)] // the names of the fields say it
NotTaken {
    /// Markers of SU2 inside the volume.
    InnerMarkers { n: usize, first: u32 } => (
        "tagged faces between two cells ({n}, the first is cell {first}) become markers, and SU2 takes markers on the \
         boundary only; {} leaves them out", option("portable")
    )
    /// Lagrange pyramids in files of VTK.
    LagrangePyramids { n: usize } => (
        "VTK has no Lagrange pyramids and leaves them out when it reads the file ({n}); {} keeps their corner nodes only",
        option("portable")
    )
    /// Edges or points of a solid mesh with cell arrays in CGNS.
    LowerCells { n: usize } => (
        "with cells of lower dimension than boundary faces ({n}) ParaView shows no cell array of a CGNS file; {} leaves these \
         cells out", option("portable")
    )
}
}

notes! {
/// A group that a file does not hold, or holds in another way, and names that are written as others.
#[allow(missing_docs)] // the names of the fields say it
GroupWritten {
    /// A name, of an array too, is written as another: the format does not allow it, or (`is_taken`) what it would
    /// become is taken.
    Renamed { what: &'static str, name: String, written: String, why: &'static str, is_taken: bool } => (
        "{what} {name:?} is written as \"{written}\": {why}{}",
        if *is_taken { ", and that name is taken" } else { "" }
    )
    /// It is written with another number.
    Renumbered { name: String, number: i32, own: i32 } => (
        "group \"{name}\" gets number {number}: its own, {own}, is taken or not allowed in MSH"
    )
    /// Tags of one name become one.
    Joined { name: String, n: usize } => ("{n} tags are called \"{name}\" and become one")
    /// It has no cells.
    Empty { name: String } => ("group \"{name}\" has no cells; only its family is written to CGNS")
    /// Zones, in a format that has none or only some.
    ZonesLeftOut { format: &'static str, names: Vec<String> } => (
        "{format} holds {}; left out: {}", zones_held(format), quoted(names)
    )
    /// Zones are numbered.
    ZoneNames { n: usize, names: Vec<String> } => (
        "zones are written as IZONE= 1 to {n}; names left out: {}", quoted(names)
    )
    /// Groups of lower dimension than boundary tags.
    LowerLeftOut { format: &'static str, names: Vec<String> } => (
        "{format} holds boundary tags only; groups left out: {}", quoted(names)
    )
    /// Further tags of faces that are in several.
    FaceTagsLeftOut { n: usize } => (
        "UGRID holds one tag for each face; further tags of faces that have several are left out ({n})"
    )
    /// Cells in several groups, of which an array holds the first.
    OfSeveral { n: usize, array: &'static str, cell: usize } => (
        "cells are in more than one group ({n}, the first is cell {cell}); the array {array} holds the first group of each"
    )
    /// Boundary faces in no tag are left out.
    UntaggedLeftOut { n: usize } => ("boundary elements without a tag are left out ({n})")
    /// Boundary faces in no tag get a number.
    UntaggedNumbered { n: usize, number: i32, name: String } => (
        "boundary faces without a tag ({n}) get number {number}, \"{name}\""
    )
    /// Faces that are in several tags are in the patch of the first.
    OnePatch { n: usize } => (
        "a face is in one patch of OpenFOAM; further tags of faces that have several are left out ({n})"
    )
    /// Faces that are in several tags are in the solid of the first.
    OneSolid { n: usize } => (
        "a face is in one solid of STL; further tags of faces that have several are left out ({n})"
    )
    /// Binary files of triangles have no names.
    NamesInText { names: Vec<String> } => (
        "binary STL has no tags; left out: {} ({} ascii writes a solid for each)", quoted(names), option("encoding")
    )
    /// Boundary faces inside the mesh, or on no cell.
    NotOutside { name: String, n: usize } => (
        "faces of the tag \"{name}\" that are not on the outside of the mesh are left out ({n}); a patch of OpenFOAM has \
         outer faces only"
    )
    /// Outer faces in no tag get a patch.
    UntaggedPatch { n: usize, name: String } => ("outer faces without a tag ({n}) are in the patch {name}")
    /// Names of tags were not wanted.
    NamesNotWritten => ("names of tags are not written, as requested")
}
}

fn zones_held(format: &str) -> &'static str {
    match format {
        "SU2" => "zones only where two or more make up the mesh and share no nodes",
        _ => "no zones",
    }
}

notes! {
/// The type of a boundary condition that a file does not hold, or holds in another way.
#[allow(missing_docs)] // the names of the fields say it
Condition {
    /// The format has no types of conditions: those of `n` groups are left out.
    NotWritten { format: &'static str, n: usize } => ("{}", conditions_left_out(format, *n))
    /// It has no number.
    WithoutNumber { condition: String, tag: String } => (
        "condition {condition} of tag \"{tag}\" has no number in FUN3D; 0 is written"
    )
    /// It is written as the number of another.
    WrittenAs { condition: String, tag: String, number: i32 } => (
        "condition {condition} of tag \"{tag}\" is written as FUN3D's {number}"
    )
    /// Tags have none.
    Missing { tags: Vec<String> } => (
        "tags without a boundary condition have number 0 in the .mapbc: {}", quoted(tags)
    )
    /// OpenFOAM has no type of patch for it.
    AsPatch { condition: String, tag: String } => (
        "condition {condition} of tag \"{tag}\" is written as the type patch of OpenFOAM"
    )
    /// CGNS does not know it.
    Unknown { condition: String, group: String } => (
        "the condition \"{condition}\" of \"{group}\" is not known to CGNS"
    )
}
}

fn conditions_left_out(format: &str, n: usize) -> String {
    match format {
        "SU2" => {
            "types of boundary conditions are not written: SU2 has them in its configuration".into()
        }
        "MSH" => {
            format!(
                "MSH holds no types of boundary conditions; those of {} are left out",
                counted(n, "tag")
            )
        }
        _ => "types of boundary conditions are not written".into(),
    }
}

notes! {
/// Something else that a file does not hold, or holds in another way.
#[allow(missing_docs)] // the names of the fields say it
Written {
    /// Coordinates in 32 bits were wanted, which the format does not have.
    CoordinatesIn64 { format: &'static str } => ("{}", coordinates_in_64(format))
    /// Coordinates lose digits.
    CoordinatesRounded => ("coordinates are rounded to 32 bits")
    /// Cells lose their volume with those digits.
    Flattened { n: usize, of: usize, first: usize } => (
        "cells become flat or fold in coordinates of 32 bits: {n} of {of} (the first is cell {first}); 64 bits keep them"
    )
    /// The height of a plane mesh.
    HeightLeftOut { z: f64 } => ("SU2 holds no z coordinate for a plane mesh; z = {z} is left out")
    /// Cells of lower dimension.
    LowerCellsLeftOut { n: usize } => ("cells of lower dimension are left out ({n})")
    /// Nodes are written zone by zone.
    NodesByZone => ("nodes are written zone by zone, so their order changes")
    /// A format of surfaces holds no solid cells.
    BoundaryAlone { format: &'static str, n: usize } => (
        "{format} holds surfaces: the boundary alone is written; solid cells left out, with their zones: {n}"
    )
    /// Outer faces that are no boundary cells of the mesh are written too.
    BareFaces { n: usize } => ("outer faces without a boundary element are written too, without a tag ({n})")
    /// Outer faces that are no boundary cells of the mesh are not wanted.
    BareFacesLeftOut { n: usize } => (
        "outer faces without a boundary element, such as those that {} or {} removed, are left out ({n})",
        option("keep-tag"), option("drop-tag")
    )
    /// Curved faces become flat.
    CornersAlone { n: usize } => ("curved cells are written flat, with their corners only ({n})")
    /// Faces become triangles.
    CutIntoTriangles { n: usize } => ("faces of four corners or more are cut into triangles ({n})")
    /// Cells are written type by type.
    CellsByType => (
        "cells are written in the order of their types: in their own order there would be too many sections"
    )
    /// A mesh of an ADF file, written as CGNS.
    Hdf5ForAdf => (
        "the mesh was read from a CGNS file in ADF and is written in HDF5; hdf2adf, a tool of CGNS, makes ADF of it"
    )
    /// Cells whose nodes are in reverse order.
    TurnedRound { n: usize } => (
        "cells are listed in the other orientation, with a negative volume ({n}); they are turned round, for faces of OpenFOAM \
         point out of their cells"
    )
    /// The mesh that all steps share was not as it was written, and is written again.
    MeshAgain {
        /// Its folders.
        folders: Vec<String>,
    } => (
        "{}: a file is missing or not as it was written; all files there but the points are written again",
        folders.join(", ")
    )
    /// A mesh that was joined from the pieces of a decomposed case.
    AsOne => (
        "the mesh is written as one: its cells or tags are not those of the pieces that it was read from; decomposePar cuts it again"
    )
    /// Files of an OpenFOAM mesh that say what its faces and points belong to.
    FilesLeftOut { names: Vec<String> } => (
        "left out, since faces have another order now: {}", names.join(", ")
    )
    /// A device or a pipe can have no companion file.
    CompanionLeftOut => (
        "names and conditions of tags are not written: they need a second file, which a device or a pipe cannot hold"
    )
    /// Nodes or elements are counted from 1.
    CountedFromOne { what: &'static str } => (
        "{what} are counted from 1: their own numbers are above {}, the largest that data in MSH can refer to", i32::MAX
    )
}
}

fn coordinates_in_64(format: &str) -> String {
    match format {
        "UGRID" => "coordinates are written in 64 bits; ugrid-b4 has 32".into(),
        format => format!("{format} holds coordinates in 64 bits only"),
    }
}
