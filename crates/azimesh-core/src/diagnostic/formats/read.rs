//! Notes of readers: what a mesh does not hold of a file, or holds in another way.

use super::{LISTED, more, quoted};
use crate::diagnostic::notes::notes;
use crate::diagnostic::short;
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
        "the {what} array \"{name}\" is left out: its type or number of components differs between pieces"
    )
    /// It does not have one tuple for each node or cell.
    Misfit { what: &'static str, name: String, n_tuples: usize, n_components: usize, n_items: usize } => (
        "the {what} array \"{name}\" is left out: it has {} of {} for {}",
        counted(*n_tuples, "tuple"), counted(*n_components, "component"), counted(*n_items, what)
    )
    /// Several arrays have its name; it got another.
    Renamed { what: &'static str, name: String, here: String } => (
        "several {what} arrays are called \"{name}\"; one of them is read as \"{here}\""
    )
    /// Several arrays have the name of an array of a CGNS solution; it got another.
    OfSolutionRenamed { solution: String, name: String, here: String } => (
        "several arrays are called \"{name}\"; that of \"{solution}\" is read as \"{here}\""
    )
    /// Its values differ between pieces.
    OfFirstPiece { name: String } => (
        "the field array \"{name}\" differs between pieces; that of the first is kept"
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
    Keywords { n: usize } => ("{} not kept", are(*n, "more keyword"))
    /// Further data (`what`) of `n` items.
    Of { what: &'static str, n: usize, item: &'static str } => (
        "{what} of {} are not kept", counted(*n, item)
    )
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
        "{what} after the last cell ({n}), such as volume numbers, are not kept"
    )
    /// Blanking of nodes.
    Blanking => ("blanking is not kept: cells at blanked nodes are read like others")
}
}

fn nodes_not_kept(what: &str, n: usize) -> String {
    match (what.contains(' '), n) {
        (true, _) => format!("{what} are not kept ({n})"),
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
        "texts that are not UTF-8 are read as Latin-1: {}{}", quoted(&texts[..texts.len().min(LISTED)]), more(texts.len(), LISTED)
    )
    /// An XML file that is not UTF-8 was read as Latin-1.
    XmlLatin1 => ("the XML is not UTF-8; it is read as Latin-1")
    /// Groups share names: each with the number of groups.
    SharedNames { what: &'static str, names: Vec<(String, usize)> } => (
        "of the {what}, {}; the name stands for all of them", shared(names)
    )
    /// Triangles of STL have attributes, such as colours.
    TriangleAttributes { n: usize } => ("attributes of triangles, such as colours, are not kept ({n})")
    /// Numbers have exponents as Fortran writes them.
    FortranExponents { line: u64 } => (
        "numbers with exponents of Fortran, such as that in line {line}, are read: D stands for E"
    )
    /// Lines begin with a mark of comments that the format does not have.
    CommentLines { n: usize } => (
        "{} with # or !, which the format does not know as comments, {} passed over",
        if *n == 1 { "1 line that begins".into() } else { format!("{n} lines that begin") }, if *n == 1 { "is" } else { "are" }
    )
    /// Lines end with a comment that the format does not have.
    TrailingComments { n: usize } => (
        "what follows # or !, which the format does not know as comments, is passed over in {}", counted(*n, "line")
    )
    /// Comments within a section of a Gmsh file.
    CommentsWithin { section: String } => ("$Comments within ${section} are passed over")
    /// A keyword is spelled in another way than that of the format.
    Spelled { found: &'static str, meant: &'static str } => ("{found}= is read as {meant}=")
    /// Sections of a Gmsh file have no end.
    Unended { sections: Vec<String> } => ("lines that end sections are missing, and the sections are read: {}", sections.join(", "))
    /// It holds a sequence, and no step was asked for.
    LastOfSteps { n: usize, last: f64 } => ("of {} that it holds the last is read, at {}", counted(*n, "step"), short(*last))
    /// Zeros follow compressed data.
    ZeroPadding { n: usize } => ("{} behind the compressed data are passed over", counted(*n, "zero"))
    /// `NMARK=` is not the number of markers.
    MarkerCount { said: usize, found: usize } => (
        "NMARK= {said}, but the file has {}; all are read", counted(*found, "marker")
    )
    /// Markers of one name become one tag.
    MarkersJoined { name: String, n: usize } => (
        "{n} markers are called \"{name}\"; they become one tag"
    )
    /// The companion file of a UGRID file cannot be used.
    ConditionsUnused { error: String } => ("names and conditions of tags are not used: {error}")
    /// The companion file of a UGRID file has a wrong number of patches.
    PatchCount { said: usize, found: usize } => (
        "the number of patches in the .mapbc is given as {said}, but there are {found}; all are read"
    )
    /// Marks of Fortran's records are wrong.
    WrongRecordMarks => ("the Fortran record marks are wrong; the file is read by its counts, which fit its length")
    /// Elements of several partitions.
    SeveralPartitions { n: usize } => (
        "{} in several partitions; the first of these is kept", are(*n, "element")
    )
    /// Physical groups are named, but there is no `$Entities` with their content.
    GroupsWithoutEntities { n: usize } => (
        "{} left without elements: the file has no $Entities to say which they are", are(*n, "physical group")
    )
    /// A physical group has two names.
    SecondName { number: i32, dimension: u8, used: String, other: String } => (
        "physical group {number} of dimension {dimension} has two names; \"{used}\" is used, not \"{other}\""
    )
    /// Wedges of a VTK file that are not in the order of VTK up to 9.6.
    WedgesTurned { n: usize } => (
        "{} in the node order of VTK 9.7, in which most of them have a positive volume, not in that of VTK up to 9.6",
        are(*n, "wedge")
    )
    /// Hexahedra of high order whose degrees are not known.
    OldOrder { n: usize } => (
        "hexahedra of high order ({n}) keep the node order of VTK before version 9: their degrees are not given"
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
        "only the corner nodes of {} of type {element} are kept: no kind of cell has the other nodes", counted(*n, "element")
    )
    /// Elements with more nodes than any kind of cell has.
    FewerNodes { element: String, n: usize, n_nodes: usize, n_kept: usize } => (
        "{} of type {element} {} {n_kept} of {n_nodes} nodes: no kind of cell has the others", counted(*n, "element"), if *n == 1 { "keeps" } else { "keep" }
    )
    /// Links lead to files that are not there.
    BrokenLinks { files: Vec<String> } => (
        "links lead to files that are not there, and what they stand for is left out: {}", files.join(", ")
    )
    /// The kind of a zone of a CGNS file is abbreviated.
    ZoneKind { zone: String, found: String, meant: &'static str } => ("{zone}: ZoneType \"{found}\" is read as {meant}")
    /// Polygons without a shape.
    DegeneratePolygons { zone: String, n: usize } => (
        "{zone}: {} left out, since {} fewer than 3 nodes", are(*n, "polygon"), if *n == 1 { "it has" } else { "they have" }
    )
    /// The number of cells in a zone of a CGNS file is wrong.
    CellCount { zone: String, said: usize, dimension: u8, found: usize } => (
        "{zone}: the number of cells of dimension {dimension} is given as {said}, but its sections have {found}"
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

/// "1 node is", "2 nodes are".
fn are(n: usize, noun: &str) -> String {
    format!("{} {}", counted(n, noun), if n == 1 { "is" } else { "are" })
}

/// What an "s" makes the plural of a kind of cell.
fn plural_stem(kind: &str) -> String {
    kind.replace("vertex", "vertice")
}

notes! {
/// How the pieces of a mesh were joined.
Pieces {
    /// Nodes of one global number lie apart.
    NumbersUnused => ("global node numbers are not used: nodes with the same number are at different places")
    /// Cells share no nodes within a piece.
    NotJoined => ("the pieces are not joined: their cells share no nodes even within a piece")
    /// A piece has several nodes at one place.
    KeptApart {
        /// Number of such places.
        n: usize,
    } => ("nodes at {} are not joined: a piece has several nodes there", counted(*n, "place"))
    /// Pieces are joined at nodes of one number or one place.
    Joined {
        /// Number of pieces.
        n: usize,
        /// Number of nodes at which they are joined.
        n_nodes: usize,
        /// What these nodes have in common.
        by: &'static str,
    } => ("{} joined at {} with the same {by}", are(*n, "piece"), counted(*n_nodes, "node"))
    /// Copies of a neighbour's cells are left out.
    GhostsLeftOut => ("ghost cells of the pieces are left out")
    /// Cells are marked as hidden.
    Hidden => ("cells marked as hidden are read like others")
}
}
