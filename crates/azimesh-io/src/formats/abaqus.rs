//! Abaqus and CalculiX input (.inp): nodes, elements, sets and surfaces of one part. Read only.
//!
//! Element sets and surfaces of faces are groups. A file without boundary tags has its node sets as tags: the outer
//! faces whose corners are all in the set. Materials, steps and loads are not kept.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! let mesh = Mesh::read("testdata/box_by_gmsh.inp")?;
//! let tags: Vec<_> = mesh.tags().map(|tag| tag.name.as_str()).collect();
//! assert!(tags.contains(&"wall"));
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert!(zones.contains(&"solid"));
//! # Ok(())
//! # }
//! ```

use super::gmsh::Index;
use super::names::text_of;
use super::tokens::{Tokens, line_of, shown};
use super::{Format, Notes};
use crate::mesh::CellKind::{self, *};
use crate::mesh::sides::side;
use crate::mesh::{Group, Mesh, exterior_faces, too_many};
use azimesh_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Abaqus input (.inp).
pub static ABAQUS: Format = Format {
    name: "abaqus",
    title: "Abaqus input (.inp)",
    extensions: &["inp"],
    detect: |source| recognizes(source.bytes()),
    read: |source, _, notes| Reader::default().read(source.bytes(), notes),
    ..Format::NEW
};

/// Keywords that make or move nodes and elements, or read them from another file.
const REFUSED: &str = "NGEN NFILL NCOPY NMAP ELGEN ELCOPY INCLUDE SYSTEM";
/// Keywords without content that a mesh lacks.
const STRUCTURE: &str = "HEADING PREPRINT ENDPART";
/// Elements without a shape.
const SHAPELESS: &str = "MASS ROTARYI SPRING DASHPOT CONN DCOUP GAP HEATCAP";
/// Families of elements: beginnings of the names, and their dimension. The number of nodes follows; in beams (0), the
/// order.
const FAMILIES: [(&str, u8); 5] = [
    ("B2 B3 PIPE2 PIPE3 SAX", 0),
    ("T2D T3D R2D RAX DC1D AC1D RB2D RB3D", 1),
    ("C3D F3D DC3D DCC3D AC3D EC3D FC3D Q3D COH3D SC", 3),
    (
        "CPEG CPE CPS CGAX CAX DC2D DCC2D DCAX AC2D ACAX WARP2D COH2D COHAX",
        2,
    ),
    (SHELLS, 2),
];
const SHELLS: &str = "M3D SFM3D R3D DS STRI S";

/// Checks that the first line is a keyword, and that there are nodes, elements or parts.
fn recognizes(bytes: &[u8]) -> bool {
    let mut lexer = Tokens::new(bytes);
    let mut lines = std::iter::from_fn(|| lexer.line());
    let first = lines.find(|line| !line.rest().starts_with(b"**"));
    let word = first.as_ref().map_or(&b""[..], Tokens::rest);
    // LS-DYNA's files begin with *KEYWORD.
    word.starts_with(b"*")
        && word.get(1).is_some_and(u8::is_ascii_alphabetic)
        && !word.starts_with(b"*KEYWORD")
        && memchr::memchr_iter(b'*', bytes).any(|at| {
            let word = bytes[at + 1..].iter().take(4);
            let word: Vec<u8> = word.map(u8::to_ascii_lowercase).collect();
            matches!(&word[..], b"node" | b"elem" | b"part" | b"incl")
        })
}

/// The kind of the elements of a type, and whether they are shells; `None` for those without a shape.
fn kind_of(name: &str) -> Option<Option<(CellKind, bool)>> {
    // D: network elements of CalculiX.
    if name == "D" || SHAPELESS.split(' ').any(|start| name.starts_with(start)) {
        return Some(None);
    }
    FAMILIES.iter().find_map(|(starts, dimension)| {
        let number = starts.split(' ').find_map(|start| {
            let rest = name.strip_prefix(start)?;
            let n = rest.bytes().take_while(u8::is_ascii_digit).count();
            rest[..n].parse().ok()
        });
        let kind = match (dimension, number?) {
            (0, 1 | 3) | (1, 2) => Line,
            (0, 2) | (1, 3) => Line3,
            (2, 3) => Triangle,
            (2, 4) => Quadrilateral,
            (2, 6 | 65) => Triangle6,
            (2, 8) => Quadrilateral8,
            (2, 9) => Quadrilateral9,
            (3, 4) => Tetrahedron,
            (3, 5) => Pyramid,
            (3, 6) => Wedge,
            (3, 8) => Hexahedron,
            (3, 10) => Tetrahedron10,
            (3, 13) => Pyramid13,
            (3, 15) => Wedge15,
            (3, 20) => Hexahedron20,
            _ => return None,
        };
        Some(Some((kind, *starts == SHELLS)))
    })
}

/// Index in [`CellKind::faces`] of the face S1, S2 and so on.
fn face_of(kind: CellKind, number: usize) -> Option<usize> {
    let order = match kind.linear() {
        Tetrahedron => [3, 0, 1, 2, 4, 5],
        Hexahedron => [4, 5, 2, 1, 3, 0],
        _ => [0, 1, 2, 3, 4, 5],
    };
    order.get(number.checked_sub(1)?).copied()
}

/// A line `*NAME, PARAMETER=VALUE` and the lines that continue it: those with a parameter. CalculiX has no such lines,
/// and reads data after a comma at the end.
struct Keyword<'a> {
    line: Tokens<'a>,
    name: String,
    parameters: Vec<(String, &'a [u8])>,
}

impl<'a> Keyword<'a> {
    /// The next keyword of a file.
    fn next(lexer: &mut Tokens<'a>) -> Option<Self> {
        let is_keyword = |line: &Tokens| {
            let text = line.rest();
            text.starts_with(b"*") && !text.starts_with(b"**")
        };
        let line = std::iter::from_fn(|| lexer.line()).find(is_keyword)?;
        let (bytes, start) = (lexer.bytes(), line.position());
        while bytes[start..lexer.position()]
            .trim_ascii_end()
            .ends_with(b",")
            && let Some(next) = lexer.peek_line()
            && !next.rest().starts_with(b"*")
            && (next.rest().contains(&b'=') || plain(next.rest()).starts_with("GENERATE"))
        {
            lexer.line();
        }
        let mut parts = words(&Tokens::between(bytes, start..lexer.position()));
        let name = plain(&parts.next()?.rest()[1..]);
        let parameters = parts.map(|part| {
            let mut halves = part.rest().splitn(2, |byte| *byte == b'=');
            let name = plain(halves.next().unwrap_or_default());
            (name, unquoted(halves.next().unwrap_or_default()))
        });
        let parameters = parameters.collect();
        Some(Self {
            line,
            name,
            parameters,
        })
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        let mut found = self.parameters.iter().filter(|(other, _)| other == name);
        found.next().map(|(_, value)| *value)
    }
}

/// The next line of data before the next keyword.
fn data<'a>(lexer: &mut Tokens<'a>) -> Option<Tokens<'a>> {
    while let Some(line) = lexer.peek_line() {
        if line.rest().starts_with(b"*") && !line.rest().starts_with(b"**") {
            return None;
        }
        lexer.line();
        if !line.rest().starts_with(b"*") {
            return Some(line);
        }
    }
    None
}

/// The parts of lines between their commas.
fn words<'a>(lines: &Tokens<'a>) -> impl Iterator<Item = Tokens<'a>> + use<'a> {
    let (bytes, first) = (lines.bytes(), lines.position());
    let commas = memchr::memchr_iter(b',', lines.left()).chain([lines.left().len()]);
    let mut start = first;
    commas.map(move |at| {
        let end = first + at;
        Tokens::between(bytes, std::mem::replace(&mut start, end + 1)..end)
    })
}

/// A word in capitals, without blanks.
fn plain(word: &[u8]) -> String {
    let word = String::from_utf8_lossy(word).to_uppercase();
    word.replace(char::is_whitespace, "")
}

fn unquoted(word: &[u8]) -> &[u8] {
    let word = word.trim_ascii();
    let inside = word.strip_prefix(b"\"");
    let inside = inside.and_then(|word| word.strip_suffix(b"\""));
    inside.unwrap_or(word)
}

fn integer(word: &mut Tokens, what: &str) -> Result<i64> {
    let number = word.integer(what)?;
    word.end(what)?;
    Ok(number)
}

/// Numbers from the first to the last with a step.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Stretch {
    first: i64,
    last: i64,
    step: i64,
}

/// Adds a number to a set; numbers that count up are one stretch.
fn push(set: &mut Vec<Stretch>, number: i64) {
    match set.last_mut() {
        Some(last) if last.step == 1 && last.last.checked_add(1) == Some(number) => {
            last.last = number;
        }
        _ => {
            let (first, last, step) = (number, number, 1);
            set.push(Stretch { first, last, step });
        }
    }
}

/// Sets or surfaces: name and members of each, in the order of the file.
#[derive(Default)]
struct Sets<T> {
    all: Vec<(String, Vec<T>)>,
    /// Places by name in capitals, of a part and of the assembly.
    places: BTreeMap<(bool, String), usize>,
}

impl<T> Sets<T> {
    fn place(&mut self, is_assembly: bool, name: &[u8], notes: &mut Notes) -> usize {
        let place = self.places.entry((is_assembly, plain(name)));
        *place.or_insert_with(|| {
            self.all.push((text_of(name, notes), Vec::new()));
            self.all.len() - 1
        })
    }

    /// The place of a set that exists; an instance may come before its name.
    fn find(&self, is_assembly: bool, name: &[u8]) -> Option<usize> {
        let name = plain(name);
        let short = name.rsplit('.').next().unwrap_or_default().to_owned();
        let keys = [(is_assembly, name), (false, short)];
        keys.iter().find_map(|key| self.places.get(key).copied())
    }
}

/// Numbers of nodes or of elements in the order of the file, and sets of them.
#[derive(Default)]
struct Items {
    numbers: Vec<i64>,
    /// Offsets of their lines; of an element the last one.
    lines: Vec<usize>,
    sets: Sets<Stretch>,
}

impl Items {
    fn push(&mut self, number: i64, line: &Tokens, set: Option<usize>) {
        self.numbers.push(number);
        self.lines.push(line.position());
        if let Some(set) = set {
            push(&mut self.sets.all[set].1, number);
        }
    }

    /// Adds the members in a line to a set: numbers and other sets, or the stretch of a line with GENERATE.
    fn extend(&mut self, set: usize, line: &Tokens, generates: bool, at: bool) -> Result<()> {
        let mut words = words(line).filter(|word| !word.rest().is_empty());
        if generates {
            let numbers = words.map(|mut word| integer(&mut word, "a number of GENERATE"));
            let (first, last, step) = match numbers.collect::<Result<Vec<i64>>>()?[..] {
                [first, last] => (first, last, 1),
                [first, last, step] if step > 0 => (first, last, step),
                _ => {
                    let message =
                        "GENERATE needs a first and a last number, and a step of at least 1";
                    return Err(line.error(message));
                }
            };
            self.sets.all[set].1.push(Stretch { first, last, step });
            return Ok(());
        }
        words.try_for_each(|mut word| {
            let name = unquoted(word.rest());
            if name.iter().all(u8::is_ascii_digit) {
                let number = integer(&mut word, "a member of a set")?;
                push(&mut self.sets.all[set].1, number);
                return Ok(());
            }
            let missing = || format!("there is no set {} before this line", shown(name));
            let other = self.sets.find(at, name);
            let other = other.ok_or_else(|| word.error(missing()))?;
            let more = self.sets.all[other].1.clone();
            let all = &mut self.sets.all[set].1;
            all.extend(more);
            // A union: sets of sets that are named twice do not double.
            all.sort_unstable();
            all.dedup();
            Ok(())
        })
    }

    fn index(&self, what: &str, bytes: &[u8]) -> Result<Index> {
        Index::new(&self.numbers, what).map_err(|error| {
            let mut seen = HashSet::new();
            let repeated = self.numbers.iter().position(|number| !seen.insert(number));
            let at = repeated.map_or(bytes.len(), |i| self.lines[i]);
            error.line(line_of(bytes, at))
        })
    }

    /// Indices of the members of a set that exist.
    fn members(&self, set: &[Stretch], index: &Index) -> Vec<u32> {
        let mut found = Vec::new();
        for set in set.iter().filter(|set| set.first <= set.last) {
            let (range, step) = (set.first..=set.last, set.step as u64);
            if set.last.abs_diff(set.first) / step <= self.numbers.len() as u64 {
                let of_range = range.step_by(set.step as usize);
                found.extend(of_range.filter_map(|number| index.get(number)));
                continue;
            }
            let is_in = |number: &i64| {
                range.contains(number) && number.abs_diff(set.first).is_multiple_of(step)
            };
            let all = (0u32..).zip(&self.numbers);
            found.extend(all.filter(|(_, number)| is_in(number)).map(|(i, _)| i));
        }
        found
    }
}

struct Elements {
    kind: CellKind,
    is_shell: bool,
    /// Place of the line.
    at: usize,
    /// Index of the first element.
    first: usize,
    nodes: Vec<i64>,
}

/// Elements with one of their faces, edges or sides of a shell.
#[derive(Default)]
struct Facet {
    at: usize,
    elements: Vec<Stretch>,
    label: String,
}

impl Facet {
    /// The index of the face of an element; `None` for the shell itself.
    fn face(&self, kind: CellKind, is_shell: bool) -> Option<Option<usize>> {
        let number = |start| self.label.strip_prefix(start)?.parse::<usize>().ok();
        let number = match (self.label.as_str(), is_shell) {
            ("SPOS" | "SNEG", _) | ("S1" | "S2", true) => return Some(None),
            (_, false) => number('S'),
            // CalculiX counts the sides of a shell as faces.
            (_, true) => number('E').or_else(|| number('S')?.checked_sub(2)),
        };
        face_of(kind, number?).map(Some)
    }
}

#[derive(Default)]
struct Reader {
    points: Vec<[f64; 3]>,
    nodes: Items,
    elements: Items,
    blocks: Vec<Elements>,
    surfaces: Sets<Facet>,
    part: Option<String>,
    has_instance: bool,
    /// True in an assembly, but not in an instance.
    in_assembly: bool,
    offset: [f64; 3],
    left: BTreeSet<String>,
}

impl Reader {
    fn read(mut self, bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
        let mut lexer = Tokens::new(bytes);
        while let Some(keyword) = Keyword::next(&mut lexer) {
            let left = self.take(&keyword, &mut lexer, notes)?;
            self.left.extend(left);
        }
        if self.points.is_empty() {
            return Err(lexer.error("the file has no nodes (*NODE)"));
        }
        self.mesh(bytes, notes)
    }

    /// Takes a keyword and its lines of data; gives the name of content that a mesh lacks.
    fn take<'a>(
        &mut self,
        keyword: &Keyword<'a>,
        lexer: &mut Tokens<'a>,
        notes: &mut Notes,
    ) -> Result<Option<String>> {
        let (name, line) = (keyword.name.as_str(), &keyword.line);
        let is_elsewhere = matches!(name, "NODE" | "ELEMENT" | "NSET" | "ELSET" | "SURFACE")
            && keyword.get("INPUT").is_some();
        if is_elsewhere || REFUSED.split(' ').any(|refused| refused == name) {
            return Err(line.error(format!(
                "*{name} makes nodes, elements or sets, or reads another file, which is not supported; write a file with all \
                 of them"
            )));
        }
        let of_assembly = self.in_assembly;
        match name {
            "NODE" if of_assembly => return Ok(Some("*NODE of the assembly".into())),
            "NODE" => {
                let system = keyword.get("SYSTEM").unwrap_or(b"R");
                if !system.eq_ignore_ascii_case(b"R") {
                    let found = shown(system);
                    return Err(line.error(format!(
                        "nodes in the coordinate system {found} are not read; write Cartesian ones"
                    )));
                }
                let set = keyword.get("NSET");
                let set = set.map(|set| self.nodes.sets.place(of_assembly, set, notes));
                while let Some(line) = data(lexer) {
                    let mut words = words(&line);
                    let Some(mut number) = words.next() else {
                        continue;
                    };
                    let number = integer(&mut number, "a node number")?;
                    self.points.push(coordinates(words)?);
                    self.nodes.push(number, &line, set);
                }
            }
            "ELEMENT" => {
                let of = plain(keyword.get("TYPE").unwrap_or_default());
                let kind = kind_of(&of).ok_or_else(|| {
                    line.error(format!(
                        "element type \"{of}\" is not read; solids of 4 to 20 nodes (C3D4, C3D20R), faces of 3 to 9 \
                         (S4, CPS6) and lines (B31, T3D2) are"
                    ))
                })?;
                let Some((kind, is_shell)) = kind else {
                    return Ok(Some(format!("*ELEMENT, TYPE={of}")));
                };
                let set = keyword.get("ELSET");
                let set = set.map(|set| self.elements.sets.place(of_assembly, set, notes));
                let mut block = Elements {
                    kind,
                    is_shell,
                    at: line.position(),
                    first: self.elements.numbers.len(),
                    nodes: Vec::new(),
                };
                self.elements(&mut block, set, lexer)?;
                self.blocks.push(block);
            }
            "NSET" if keyword.get("ELSET").is_some() => return Ok(Some("*NSET, ELSET=".into())),
            "NSET" if of_assembly && keyword.get("INSTANCE").is_none() => {
                return Ok(Some("*NSET without INSTANCE".into()));
            }
            "NSET" | "ELSET" => {
                let missing = || line.error(format!("*{name} has no name of the set ({name}=)"));
                let set = keyword.get(name).ok_or_else(missing)?;
                let are_nodes = name == "NSET";
                let items = if are_nodes {
                    &mut self.nodes
                } else {
                    &mut self.elements
                };
                let set = items.sets.place(of_assembly, set, notes);
                let generates = keyword.get("GENERATE").is_some();
                while let Some(line) = data(lexer) {
                    items.extend(set, &line, generates, of_assembly)?;
                }
            }
            "SURFACE" => {
                let of = keyword.get("TYPE").unwrap_or(b"ELEMENT");
                let name = keyword.get("NAME");
                let Some(name) = name.filter(|_| of.eq_ignore_ascii_case(b"ELEMENT")) else {
                    return Ok(Some("*SURFACE without faces".into()));
                };
                let surface = self.surfaces.place(of_assembly, name, notes);
                while let Some(line) = data(lexer) {
                    let facet = self.facet(&line)?;
                    self.surfaces.all[surface].1.push(facet);
                }
            }
            "PART" => {
                let part = text_of(keyword.get("NAME").unwrap_or_default(), notes);
                if let Some(other) = self.part.replace(part.clone()) {
                    return Err(line.error(format!(
                        "the file has the parts \"{other}\" and \"{part}\"; one is read: merge them, or write a file \
                         for each"
                    )));
                }
            }
            "INSTANCE" => {
                if std::mem::replace(&mut self.has_instance, true) {
                    let message = "the file has several instances; one is read: merge them";
                    return Err(line.error(message));
                }
                self.in_assembly = false;
                if let Some(line) = data(lexer) {
                    for (x, mut word) in self.offset.iter_mut().zip(words(&line)) {
                        *x = word.real("a coordinate")?;
                    }
                }
                if let Some(line) = data(lexer) {
                    let message =
                        "the instance is rotated, which is not read; write the mesh in place";
                    return Err(line.error(message));
                }
            }
            "ASSEMBLY" | "ENDINSTANCE" => self.in_assembly = true,
            "ENDASSEMBLY" => self.in_assembly = false,
            _ if STRUCTURE.split(' ').any(|known| known == name) => {}
            _ => return Ok(Some(format!("*{name}"))),
        }
        Ok(None)
    }

    /// Takes the elements of a line `*ELEMENT`; the numbers of one may be on several lines.
    fn elements(
        &mut self,
        block: &mut Elements,
        set: Option<usize>,
        lexer: &mut Tokens,
    ) -> Result<()> {
        let n_nodes = block.kind.n_nodes().unwrap_or(0);
        let mut element = Vec::new();
        while let Some(line) = data(lexer) {
            for mut word in words(&line).filter(|word| !word.rest().is_empty()) {
                element.push(integer(&mut word, "a number of an element")?);
            }
            let Some((&number, nodes)) = element.split_first() else {
                continue;
            };
            if nodes.len() > n_nodes {
                let (name, n) = (block.kind.name(), nodes.len());
                return Err(line.error(format!("a {name} needs {n_nodes} nodes, found {n}")));
            }
            if nodes.len() == n_nodes {
                match *nodes {
                    // The middle comes second.
                    [a, b, c] if block.kind == Line3 => block.nodes.extend([a, c, b]),
                    _ => block.nodes.extend(nodes),
                }
                self.elements.push(number, &line, set);
                element.clear();
            }
        }
        let Some((number, nodes)) = element.split_first() else {
            return Ok(());
        };
        let message = format!("element {number} ends after {} of its nodes", nodes.len());
        let next = lexer.peek_line();
        Err(next.map_or_else(|| lexer.error_at_end(&message), |line| line.error(&message)))
    }

    /// Reads a line of a surface: an element or a set of them, and the face.
    fn facet(&self, line: &Tokens) -> Result<Facet> {
        let mut words = words(line);
        let mut elements = Vec::new();
        if let Some(mut of) = words.next() {
            let sets = &self.elements.sets;
            match sets.find(self.in_assembly, unquoted(of.rest())) {
                Some(set) => elements.clone_from(&sets.all[set].1),
                None => {
                    let what = "an element or the name of an element set";
                    push(&mut elements, integer(&mut of, what)?);
                }
            }
        }
        Ok(Facet {
            at: line.position(),
            elements,
            label: words
                .next()
                .map_or(String::new(), |word| plain(word.rest())),
        })
    }

    fn mesh(self, bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
        let wrong = |at: usize, message: String| Error::input(message).line(line_of(bytes, at));
        let nodes = self.nodes.index("node", bytes)?;
        let elements = self.elements.index("element", bytes)?;
        let mut mesh = Mesh::default();
        let moved = |point: [f64; 3]| std::array::from_fn(|i| point[i] + self.offset[i]);
        mesh.points = self.points.into_iter().map(moved).collect();
        for block in &self.blocks {
            let n_nodes = block.kind.n_nodes().unwrap_or(1);
            let found = block.nodes.iter().enumerate().map(|(i, number)| {
                nodes.get(*number).ok_or_else(|| {
                    let element = self.elements.numbers[block.first + i / n_nodes];
                    let what = format!("node {number}, which is not there");
                    wrong(block.at, format!("element {element} has {what}"))
                })
            });
            let found = found.collect::<Result<Vec<u32>>>()?;
            mesh.cells.push_run(block.kind, n_nodes, &found);
        }
        let n_elements = mesh.cells.len();
        let mut empty = Vec::new();
        for (name, set) in &self.elements.sets.all {
            let cells = self.elements.members(set, &elements);
            empty.extend(add_group(&mut mesh, name, cells));
        }
        for (name, facets) in &self.surfaces.all {
            let mut cells = Vec::new();
            for facet in facets {
                for cell in self.elements.members(&facet.elements, &elements) {
                    let is_before = |block: &Elements| block.first <= cell as usize;
                    let block = &self.blocks[self.blocks.partition_point(is_before) - 1];
                    let of = mesh.cells.get(cell as usize);
                    let face = facet.face(of.kind, block.is_shell);
                    if face == Some(None) {
                        cells.push(cell);
                        continue;
                    }
                    let found = face.flatten();
                    let found = found.and_then(|face| side(&mesh.cells, &of, face));
                    let (kind, nodes) = found.ok_or_else(|| {
                        let (name, label) = (of.kind.name(), &facet.label);
                        wrong(facet.at, format!("a {name} has no face \"{label}\""))
                    })?;
                    if mesh.cells.len() + 1 >= u32::MAX as usize {
                        return Err(wrong(facet.at, too_many("cells")));
                    }
                    cells.push(mesh.cells.len() as u32);
                    mesh.cells.push(kind, &nodes);
                }
            }
            empty.extend(add_group(&mut mesh, name, cells));
        }
        let sets = self.nodes.sets.all.iter();
        let sets = sets.map(|(name, set)| (name, self.nodes.members(set, &nodes)));
        let left = add_node_sets(&mut mesh, sets.collect(), n_elements);
        for (what, names) in [
            ("sets without elements", empty),
            ("node sets", left),
            ("keywords", self.left.into_iter().collect()),
        ] {
            notes.names_not_kept(what, names);
        }
        Ok(mesh)
    }
}

/// Coordinates, which are 0 where they are left out.
fn coordinates<'a>(words: impl Iterator<Item = Tokens<'a>>) -> Result<[f64; 3]> {
    let mut point = [0.0; 3];
    for (x, mut word) in point.iter_mut().zip(words) {
        if !word.rest().is_empty() {
            *x = word.real("a coordinate")?;
            word.end("a coordinate")?;
        }
    }
    Ok(point)
}

/// Adds a group for each dimension of the cells; gives the name where there are none.
fn add_group(mesh: &mut Mesh, name: &str, cells: Vec<u32>) -> Option<String> {
    let mut parts: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
    for cell in cells {
        let dimension = mesh.cells.get(cell as usize).kind.dimension();
        parts.entry(dimension).or_default().push(cell as usize);
    }
    let is_empty = parts.is_empty();
    let groups = parts.into_iter();
    let groups = groups.map(|(d, cells)| Group::new(d, name, None, cells.into_iter().collect()));
    mesh.groups.extend(groups);
    is_empty.then(|| name.to_owned())
}

/// Adds the outer faces whose corners are all in a set of nodes as a tag, in a mesh without tags. Gives the names of
/// the other sets, and of sets of all nodes.
fn add_node_sets(
    mesh: &mut Mesh,
    sets: Vec<(&String, Vec<u32>)>,
    n_elements: usize,
) -> Vec<String> {
    let mut left = Vec::new();
    let mut outer = Vec::new();
    if !sets.is_empty() && mesh.boundary_tags().next().is_none() {
        let dimension = mesh.cells.dimension();
        outer = exterior_faces(&mesh.cells, 0..n_elements, dimension, |_| true);
    }
    for (name, nodes) in sets {
        let mut is_in = vec![false; mesh.points.len()];
        nodes.iter().for_each(|node| is_in[*node as usize] = true);
        let is_all = !is_in.contains(&false);
        let first = mesh.cells.len();
        for (kind, nodes) in outer.iter().filter(|_| !is_all) {
            let corners = &nodes[..kind.n_corners(nodes.len())];
            let is_inside = corners.iter().all(|corner| is_in[*corner as usize]);
            if is_inside && mesh.cells.len() + 1 < u32::MAX as usize {
                mesh.cells.push(*kind, nodes);
            }
        }
        let cells = first as u32..mesh.cells.len() as u32;
        left.extend(add_group(mesh, name, cells.collect()));
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    fn mesh_of(text: &str) -> (Result<Mesh>, Notes) {
        let mut notes = Notes::default();
        (Reader::default().read(text.as_bytes(), &mut notes), notes)
    }

    const BOX: &str = "** by hand\n*Heading\nbox\n*Part, name=P\n*Node, nset=all\n1, 0, 0, 0\n2, 1,,\n3, 1, 1, 0\n4, 0, 1, 0\n\
        15, 0, 0, 1\n16, 1., 0, 1.D0\n17, 1, 1, 1\n18, 0, 1, 1\n*ELEMENT, type=C3D8R,\n elset=\"the box\"\n7, 1, 2, 3, 4, 15,\n16, 17, 18\n\
        *Elset, elset=copy, generate\n7, 9000000000000, 1\n*Nset, nset=low, generate\n1, 4, 1\n\
        *Surface, type=ELEMENT, name=top\nthe box, S2\n7, S4\n*End Part\n*Material, name=m\n1., 2.\n";

    #[test]
    fn sets_and_surfaces_are_groups() {
        let (mesh, notes) = mesh_of(BOX);
        let mesh = mesh.expect("a mesh");
        assert!(recognizes(BOX.as_bytes()));
        assert_eq!(mesh.points[1], [1.0, 0.0, 0.0]);
        assert_eq!(mesh.points[5], [1.0, 0.0, 1.0]);
        let groups: Vec<_> = mesh
            .groups
            .iter()
            .map(|g| (g.dimension, &*g.name, g.cells.len()))
            .collect();
        assert_eq!(groups, [(3, "the box", 1), (3, "copy", 1), (2, "top", 2)]);
        let mut face = mesh.cells.get(1).nodes.to_vec();
        face.sort_unstable();
        assert_eq!(face, [4, 5, 6, 7]);
        let mut face = mesh.cells.get(2).nodes.to_vec();
        face.sort_unstable();
        assert_eq!(face, [1, 2, 5, 6]);
        let said: Vec<String> = notes.iter().map(ToString::to_string).collect();
        assert!(
            said.iter().any(|note| note.contains("*MATERIAL")),
            "{said:?}"
        );
        assert!(said.iter().any(|note| note.contains("low")), "{said:?}");
    }

    #[test]
    fn a_set_that_is_named_twice_counts_once() {
        for (name, first) in [("Elset", 7), ("Nset", 1)] {
            let mut text = format!("{BOX}*{name}, {name}=s0\n{first}\n");
            for i in 1..60 {
                let before = i - 1;
                text += &format!("*{name}, {name}=s{i}\ns{before}, s{before}\n");
            }
            let mesh = mesh_of(&text).0.expect("a mesh");
            let last = mesh.groups.iter().find(|group| group.name == "s59");
            let n = last.map(|group| group.cells.len());
            assert_eq!(n, (name == "Elset").then_some(1), "{name}");
        }
    }

    #[test]
    fn data_follow_a_keyword_that_ends_with_a_comma() {
        let groups = |text: &str| {
            let groups = mesh_of(text).0.expect("a mesh").groups;
            let groups = groups.into_iter();
            groups
                .map(|group| (group.name, group.cells.iter().collect::<Vec<_>>()))
                .collect::<Vec<_>>()
        };
        for line in ["name=top\n", "nset=all\n", "generate\n7"] {
            let with_comma = line.replacen('\n', ",\n", 1);
            let text = BOX.replacen(line, &with_comma, 1);
            assert_ne!(text, BOX);
            assert_eq!(groups(&text), groups(BOX), "{line}");
        }
    }

    #[test]
    fn node_sets_are_tags_where_there_are_no_others() {
        let start = BOX.find("*Surface").expect("a surface");
        let mesh = mesh_of(&BOX[..start]).0.expect("a mesh");
        let tags: Vec<_> = mesh
            .boundary_tags()
            .map(|tag| (&*tag.name, tag.cells.len()))
            .collect();
        assert_eq!(tags, [("low", 1)]);
    }

    #[test]
    fn faces_are_those_of_the_manual() {
        for (kind, faces) in [
            (
                Tetrahedron,
                &[&[0, 1, 2][..], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]][..],
            ),
            (
                Wedge,
                &[
                    &[0, 1, 2],
                    &[3, 5, 4],
                    &[0, 3, 4, 1],
                    &[1, 4, 5, 2],
                    &[2, 5, 3, 0],
                ],
            ),
            (
                Hexahedron,
                &[
                    &[0, 1, 2, 3],
                    &[4, 7, 6, 5],
                    &[0, 4, 5, 1],
                    &[1, 5, 6, 2],
                    &[2, 6, 7, 3],
                    &[3, 7, 4, 0],
                ],
            ),
            (
                Pyramid,
                &[
                    &[0, 1, 2, 3],
                    &[0, 4, 1],
                    &[1, 4, 2],
                    &[2, 4, 3],
                    &[3, 4, 0],
                ],
            ),
        ] {
            for (i, nodes) in faces.iter().enumerate() {
                let face = kind.faces()[face_of(kind, i + 1).expect("a face")];
                let sorted = |nodes: &[u8]| nodes.iter().copied().collect::<BTreeSet<u8>>();
                assert_eq!(sorted(face), sorted(nodes), "{kind:?} S{}", i + 1);
            }
        }
    }

    #[test]
    fn types_have_their_kinds() {
        for (name, kind) in [
            ("C3D10M", Tetrahedron10),
            ("C3D20RH", Hexahedron20),
            ("S4R", Quadrilateral),
            ("STRI65", Triangle6),
            ("S8R5", Quadrilateral8),
            ("CPS4I", Quadrilateral),
            ("CAX8R", Quadrilateral8),
            ("B31OS", Line),
            ("T3D3", Line3),
            ("R3D4", Quadrilateral),
            ("SC8R", Hexahedron),
            ("SC6R", Wedge),
            ("DC3D4", Tetrahedron),
            ("M3D9", Quadrilateral9),
            ("B32", Line3),
            ("CPEG3", Triangle),
            ("DC2D8", Quadrilateral8),
            ("STRI3", Triangle),
            ("SFM3D4R", Quadrilateral),
        ] {
            let found = kind_of(name).flatten();
            assert_eq!(found.map(|(kind, _)| kind), Some(kind), "{name}");
        }
        assert_eq!(kind_of("SPRINGA"), Some(None));
        assert_eq!(kind_of("C3D27"), None);
    }

    #[test]
    fn damage_is_refused_with_its_line() {
        for (before, after, line, word) in [
            ("16, 17, 18", "16, 17", 18, "ends after 7"),
            ("16, 17, 18", "16, 17, 18, 1", 17, "needs 8 nodes"),
            ("7, 1, 2", "7, 99, 2", 14, "node 99"),
            ("S4", "S7", 24, "no face"),
            ("1, 1, 0", "1, x, 0", 8, "a coordinate"),
            ("C3D8R", "C3D27", 14, "is not read"),
            ("3, 1, 1, 0", "2, 1, 1, 0", 8, "node 2 is given twice"),
            ("*Elset", "*Part, name=Q\n*Elset", 18, "\"P\" and \"Q\""),
            ("*Elset", "*Include, input=a.inp\n*Elset", 18, "*INCLUDE"),
            ("elset=copy", "elset=copy, input=a", 18, "*ELSET"),
            ("nset=low", "nset=low, input=a", 20, "*NSET"),
            ("name=top", "name=top, input=a", 22, "*SURFACE"),
        ] {
            let error = mesh_of(&BOX.replacen(before, after, 1)).0;
            let error = error.expect_err(after).to_string();
            assert_says(&error, word);
            assert!(
                error.starts_with(&format!("line {line}:")),
                "{after}: {error}"
            );
        }
        for end in 0..BOX.len() {
            let _ = mesh_of(&BOX[..end]);
        }
    }
}
