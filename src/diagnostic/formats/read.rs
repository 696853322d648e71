//! Notes of readers: what a mesh does not hold of a file, or holds in another way.

use super::{LISTED, more, quoted};
use crate::diagnostic::notes::notes;
use crate::error::counted;

notes! {
/// An array of a file that is left out or changed.
#[allow(missing_docs)] // the names of the fields say it
ArrayRead {
    /// It has more tuples than the mesh has nodes or cells.
    TooLong { what: &'static str, name: String } => (
        "the {what} array \"{name}\" is left out: it has more tuples than there are {what}s"
    )
    /// Its type or number of components differs between pieces.
    NotAlike { what: &'static str, name: String } => (
        "the {what} array \"{name}\" is left out: the pieces do not all have it alike"
    )
    /// It does not have one tuple for each node or cell.
    Misfit { what: &'static str, name: String, n_tuples: usize, n_components: usize, n_items: usize } => (
        "the {what} array \"{name}\" is left out: it has {n_tuples} tuples of {n_components} components for {n_items} \
         {what}s"
    )
    /// Several arrays have its name; it got another.
    Renamed { what: &'static str, name: String, here: String } => (
        "several {what} arrays are called \"{name}\"; one of them is \"{here}\" here"
    )
    /// Several arrays have the name of an array of a CGNS solution; it got another.
    OfSolutionRenamed { solution: String, name: String, here: String } => (
        "several arrays are called \"{name}\"; that of \"{solution}\" is \"{here}\" here"
    )
    /// Its values differ between pieces.
    OfFirstPiece { name: String } => (
        "the field array \"{name}\" is that of the first piece; others differ"
    )
    /// Its elements are not known.
    WithoutElements { name: String, error: String } => (
        "data \"{name}\" of elements are not kept: {error}"
    )
    /// Its sections differ in their number of components.
    ComponentsDiffer { name: String, what: &'static str } => (
        "data \"{name}\" of {what} have different numbers of components and are not kept"
    )
    /// It has values for nodes or elements that do not exist.
    ValuesElsewhere { name: String, what: &'static str, n: usize } => (
        "\"{name}\" has {} for {what} that are not in the mesh", counted(*n, "value")
    )
    /// It lacks values.
    ValuesMissing { name: String, what: &'static str, n: usize, of: usize } => (
        "\"{name}\" has no value at {n} of {of} {what}, where it is NaN"
    )
}
}

notes! {
/// A part of a file that a mesh does not hold.
#[allow(missing_docs)] // the names of the fields say it
NotKept {
    /// A part with a name: a group, a lookup table.
    Named { what: &'static str, name: String } => ("the {what} \"{name}\" is not kept")
    /// An entry of metadata, as it is shown.
    Information { shown: String } => ("the information {shown} is not kept")
    /// A keyword of SU2 and its lines.
    Keyword { name: String, n_lines: usize } => ("{name}= is not kept ({})", counted(*n_lines, "line"))
    /// Keywords beyond those that are named.
    Keywords { n: usize } => ("{n} more keywords are not kept")
    /// Further data (`what`) of `n` items.
    Of { what: &'static str, n: usize, item: &'static str } => (
        "{what} of {} are not kept", counted(*n, item)
    )
    /// Values at other times.
    Times { n: usize } => ("values of {} of the data are not kept", counted(*n, "other time"))
    /// Nodes of a CGNS file, by their label or in words.
    Nodes { what: String, n: usize } => ("{}", nodes_not_kept(what, *n))
    /// Nodes of a CGNS file, by their names.
    NamedNodes { what: String, names: Vec<String> } => (
        "{what} are not kept: {}{}", names[..names.len().min(LISTED)].join(", "), more(names.len(), LISTED)
    )
    /// A section of a Gmsh file.
    Section { name: String } => ("{} not kept", section(name))
    /// Data after the last cell of a UGRID file: bytes or numbers.
    Rest { n: usize, what: &'static str } => (
        "{n} {what} behind the last cell, such as volume numbers, are not kept"
    )
    /// Blanking of nodes.
    Blanking => ("blanking is not kept: cells at blanked nodes are like others")
}
}

fn nodes_not_kept(what: &str, n: usize) -> String {
    match (what.contains(' '), n) {
        (true, _) => format!("{n} {what} are not kept"),
        (false, 1) => format!("a node of type {what} is not kept"),
        (false, _) => format!("{n} nodes of type {what} are not kept"),
    }
}

/// What a section of a Gmsh file holds, with the verb.
fn section(name: &str) -> String {
    match name {
        "Periodic" => "periodic links between entities ($Periodic) are".into(),
        "GhostElements" => "ghost elements of partitions ($GhostElements) are".into(),
        "ElementNodeData" => "values at each element's own nodes ($ElementNodeData) are".into(),
        name => format!("section ${name} is"),
    }
}

notes! {
/// Something else that a user should know of a file that was read.
#[allow(missing_docs)] // the names of the fields say it
Read {
    /// Texts that are not UTF-8 were read as Latin-1.
    Latin1 { texts: Vec<String> } => (
        "not UTF-8; read as Latin-1: {}{}", quoted(&texts[..texts.len().min(LISTED)]), more(texts.len(), LISTED)
    )
    /// An XML file that is not UTF-8 was read as Latin-1.
    XmlLatin1 => ("the XML is not UTF-8; read as Latin-1")
    /// Groups share names: each with the number of groups.
    SharedNames { what: &'static str, names: Vec<(String, usize)> } => (
        "of the {what}, {}; by its name all of them are meant", shared(names)
    )
    /// `NMARK=` is not the number of markers.
    MarkerCount { said: usize, found: usize } => (
        "NMARK= {said}, but there are {found} markers; all are read"
    )
    /// Markers of one name become one tag.
    MarkersJoined { name: String, n: usize } => (
        "{n} markers are called \"{name}\"; they become one tag"
    )
    /// The companion file of a UGRID file cannot be used.
    ConditionsUnused { error: String } => ("names and conditions of tags are not used: {error}")
    /// The companion file of a UGRID file has a wrong number of patches.
    PatchCount { said: usize, found: usize } => (
        "the .mapbc promises {said} patches and has {found}; all are read"
    )
    /// Marks of Fortran's records are wrong.
    WrongRecordMarks => ("the marks of Fortran's records are wrong; the length fits")
    /// Elements of several partitions.
    SeveralPartitions { n: usize } => (
        "{n} elements are in several partitions; the first of them is kept"
    )
    /// Physical groups are named, but there is no `$Entities` with their content.
    GroupsWithoutEntities { n: usize } => (
        "{} without elements: there is no $Entities, which says what is in them", counted(*n, "physical group")
    )
    /// A physical group has two names.
    SecondName { number: i32, dimension: u8, used: String, other: String } => (
        "physical group {number} of dimension {dimension} has two names; \"{used}\" is used, not \"{other}\""
    )
    /// Hexahedra of high order whose degrees are not known.
    OldOrder { n: usize } => (
        "{n} hexahedra of high order are left in the order of nodes before VTK 9: their degrees are not given"
    )
    /// Cells were split into simpler ones.
    Split { from: &'static str, n: u64, into: &'static str, n_into: u64 } => (
        "{} split into {n_into} {}s", split_cells(from, *n), plural_stem(into)
    )
    /// Cells without a shape.
    EmptyCells { n: u64, with_nodes: bool } => (
        "{} left out{}",
        if *n == 1 { "1 empty cell is".into() } else { format!("{n} empty cells are") },
        if *with_nodes { ", with the nodes they list" } else { "" }
    )
    /// Elements with nodes between the corners that no cell has.
    OnlyCorners { element: &'static str, n: usize } => (
        "of {n} elements of type {element} only the corner nodes are kept: no cell has their others"
    )
    /// The number of cells in a zone of a CGNS file is wrong.
    CellCount { zone: String, said: usize, dimension: u8, found: usize } => (
        "{zone}: it should have {said} cells of dimension {dimension}; its sections have {found}"
    )
}
}

fn shared(names: &[(String, usize)]) -> String {
    let listed = names.iter().take(LISTED);
    let mut each: Vec<String> = listed
        .map(|(name, n)| format!("{n} are called \"{name}\""))
        .collect();
    match names.len().saturating_sub(LISTED) {
        0 => {}
        n => each.push(format!("and {} more are shared", counted(n, "name"))),
    }
    each.join(", ")
}

fn split_cells(from: &str, n: u64) -> String {
    match n {
        1 => format!("1 {from} is"),
        n => format!("{n} {}s are", plural_stem(from)),
    }
}

/// What an "s" makes the plural of a kind of cell.
fn plural_stem(kind: &str) -> String {
    kind.replace("vertex", "vertice")
}

notes! {
/// How the pieces of a mesh were joined.
Pieces {
    /// Nodes of one global number lie apart.
    NumbersUnused => ("global numbers of nodes are not used: they join nodes at different places")
    /// Cells share no nodes within a piece.
    NotJoined => ("the pieces are not joined: their cells have nodes of their own")
    /// A piece has several nodes at one place.
    KeptApart {
        /// Number of such places.
        n: usize,
    } => ("nodes at {n} places are kept apart: a piece has several of them there")
    /// Pieces are joined at nodes of one number or one place.
    Joined {
        /// Number of pieces.
        n: usize,
        /// Number of nodes at which they are joined.
        n_nodes: usize,
        /// What these nodes have in common.
        by: &'static str,
    } => ("{n} pieces are joined at {n_nodes} nodes that have the same {by}")
    /// Copies of a neighbour's cells are left out.
    GhostsLeftOut => ("ghost cells of the pieces are left out")
    /// Cells are marked as hidden.
    Hidden => ("cells marked as hidden are like others")
}
}
