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

use super::exterior::exterior_faces;
use super::gmsh::Index;
use super::names::text_of;
use super::tokens::{Tokens, line_of, shown};
use super::{Format, Notes};
use crate::mesh::CellKind::{self, *};
use crate::mesh::sides::side;
use crate::mesh::{CellSet, Group, Mesh, too_many};
use azimesh_core::diagnostic::formats::NotKept;
use azimesh_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::ops::Range;

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
/// Beginnings of the names of elements. The number of nodes follows; in beams, the order.
const BEAMS: &str = "B2 B3 PIPE2 PIPE3 SAX";
const LINES: &str = "T2D T3D R2D RAX DC1D AC1D RB2D RB3D";
const PLANES: &str = "CPEG CPE CPS CGAX CAX DC2D DCC2D DCAX AC2D ACAX WARP2D COH2D COHAX";
const SHELLS: &str = "M3D SFM3D R3D DS STRI S";
const SOLIDS: &str = "C3D F3D DC3D DCC3D AC3D EC3D FC3D Q3D COH3D SC";

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
    let number = |starts: &str| {
        starts.split(' ').find_map(|start| {
            let rest = name.strip_prefix(start)?;
            let n = rest.bytes().take_while(u8::is_ascii_digit).count();
            rest[..n].parse::<usize>().ok()
        })
    };
    let line = match (number(BEAMS), number(LINES)) {
        (Some(1 | 3), _) | (_, Some(2)) => Some(Line),
        (Some(2), _) | (_, Some(3)) => Some(Line3),
        _ => None,
    };
    let solid = || {
        Some(match number(SOLIDS)? {
            4 => Tetrahedron,
            5 => Pyramid,
            6 => Wedge,
            8 => Hexahedron,
            10 => Tetrahedron10,
            13 => Pyramid13,
            15 => Wedge15,
            20 => Hexahedron20,
            _ => return None,
        })
    };
    let face = |starts| {
        Some(match number(starts)? {
            3 => Triangle,
            4 => Quadrilateral,
            6 | 65 => Triangle6,
            8 => Quadrilateral8,
            9 => Quadrilateral9,
            _ => return None,
        })
    };
    let flat = line.or_else(solid).or_else(|| face(PLANES));
    let flat = flat.map(|kind| (kind, false));
    flat.or_else(|| Some((face(SHELLS)?, true))).map(Some)
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

/// A line `*NAME, PARAMETER=VALUE` and the lines that continue it.
struct Keyword<'a> {
    name: String,
    parameters: Vec<(String, &'a [u8])>,
}

impl<'a> Keyword<'a> {
    fn new(line: &Tokens<'a>, lexer: &mut Tokens<'a>) -> Self {
        let mut text = line.rest();
        let mut words: Vec<&[u8]> = text[1..].split(|byte| *byte == b',').collect();
        while text.ends_with(b",")
            && let Some(next) = lexer.peek_line()
            && !next.rest().starts_with(b"*")
        {
            lexer.line();
            text = next.rest();
            words.extend(text.split(|byte| *byte == b','));
        }
        let parameters = words[1..].iter().map(|part| {
            let mut halves = part.splitn(2, |byte| *byte == b'=');
            let name = plain(halves.next().unwrap_or_default());
            (name, unquoted(halves.next().unwrap_or_default()))
        });
        Self {
            name: plain(words[0]),
            parameters: parameters.collect(),
        }
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        let mut found = self.parameters.iter().filter(|(other, _)| other == name);
        found.next().map(|(_, value)| *value)
    }
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

/// The parts of a line between its commas.
fn words(bytes: &[u8], line: Range<usize>) -> impl Iterator<Item = Tokens<'_>> {
    let commas = memchr::memchr_iter(b',', &bytes[line.clone()]);
    let mut start = line.start;
    let ends = commas.map(move |i| line.start + i).chain([line.end]);
    ends.map(move |end| Tokens::between(bytes, std::mem::replace(&mut start, end + 1)..end))
}

fn integer(word: &mut Tokens, what: &str) -> Result<i64> {
    let number = word.integer(what)?;
    word.end(what)?;
    Ok(number)
}

/// Numbers from the first to the last with a step.
#[derive(Clone, Copy)]
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
        _ => set.push(Stretch {
            first: number,
            last: number,
            step: 1,
        }),
    }
}

/// Indices of the members of a set that exist; `numbers` has the number of each index.
fn members(set: &[Stretch], index: &Index, numbers: &[i64]) -> Vec<u32> {
    let mut found = Vec::new();
    for set in set.iter().filter(|set| set.first <= set.last) {
        let range = set.first..=set.last;
        if set.last.abs_diff(set.first) / set.step as u64 <= numbers.len() as u64 {
            let of_range = range.step_by(set.step as usize);
            found.extend(of_range.filter_map(|number| index.get(number)));
            continue;
        }
        let is_in = |number: i64| {
            range.contains(&number) && number.abs_diff(set.first).is_multiple_of(set.step as u64)
        };
        let all = (0u32..).zip(numbers);
        found.extend(all.filter(|(_, number)| is_in(**number)).map(|(i, _)| i));
    }
    found
}

/// Sets or surfaces: name and members of each, in the order of the file.
struct Sets<T> {
    all: Vec<(String, Vec<T>)>,
    /// Places by name in capitals, of a part and of the assembly.
    places: BTreeMap<(bool, String), usize>,
}

impl<T> Default for Sets<T> {
    fn default() -> Self {
        Self {
            all: Vec::new(),
            places: BTreeMap::new(),
        }
    }
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

/// The elements of a line `*ELEMENT`.
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
struct Facet {
    at: usize,
    elements: Vec<Stretch>,
    label: String,
}

/// The meaning of lines of data, with the place of a set.
#[derive(Default, Clone, Copy)]
enum Block {
    #[default]
    Passed,
    Nodes(Option<usize>),
    Elements(Option<usize>),
    Set {
        is_of_nodes: bool,
        set: usize,
        generates: bool,
    },
    Surface(usize),
    Instance {
        is_first: bool,
    },
}

#[derive(Default)]
struct Reader {
    points: Vec<[f64; 3]>,
    node_numbers: Vec<i64>,
    /// Offsets of the lines of the nodes.
    node_lines: Vec<usize>,
    blocks: Vec<Elements>,
    element_numbers: Vec<i64>,
    /// Offsets of the last lines of the elements.
    element_lines: Vec<usize>,
    node_sets: Sets<Stretch>,
    element_sets: Sets<Stretch>,
    surfaces: Sets<Facet>,
    block: Block,
    /// Numbers of an element that the next line continues.
    element: Vec<i64>,
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
        loop {
            let at = lexer.position();
            let Some(line) = lexer.line() else { break };
            let text = line.rest();
            if text.starts_with(b"**") {
                continue;
            }
            if text.starts_with(b"*") {
                self.check_element(&line)?;
                let keyword = Keyword::new(&line, &mut lexer);
                self.block = self.begin(&keyword, &line, at, notes)?;
            } else {
                self.take(bytes, at..lexer.position())?;
            }
        }
        let end = Tokens::between(bytes, bytes.len()..bytes.len());
        self.check_element(&end)?;
        if self.points.is_empty() {
            return Err(end.error("the file has no nodes (*NODE)"));
        }
        self.mesh(bytes, notes)
    }

    /// Refuses an element that ends before all its nodes.
    fn check_element(&self, line: &Tokens) -> Result<()> {
        let Some((number, nodes)) = self.element.split_first() else {
            return Ok(());
        };
        let n = nodes.len();
        Err(line.error(format!("element {number} ends after {n} of its nodes")))
    }

    /// Takes a keyword; gives the meaning of the lines after it.
    fn begin(
        &mut self,
        keyword: &Keyword,
        line: &Tokens,
        at: usize,
        notes: &mut Notes,
    ) -> Result<Block> {
        let name = keyword.name.as_str();
        let is_elsewhere = matches!(name, "NODE" | "ELEMENT") && keyword.get("INPUT").is_some();
        if is_elsewhere || REFUSED.split(' ').any(|refused| refused == name) {
            return Err(line.error(format!(
                "*{name} makes nodes or elements, or reads another file, which is not supported; write a file with all \
                 of them"
            )));
        }
        let of_assembly = self.in_assembly;
        match name {
            "NODE" if of_assembly => {
                self.left.insert("*NODE of the assembly".into());
            }
            "NODE" => {
                let system = keyword.get("SYSTEM").unwrap_or(b"R");
                if !system.eq_ignore_ascii_case(b"R") {
                    let found = shown(system);
                    return Err(line.error(format!(
                        "nodes in the coordinate system {found} are not read; write Cartesian ones"
                    )));
                }
                let set = keyword.get("NSET");
                let set = set.map(|set| self.node_sets.place(of_assembly, set, notes));
                return Ok(Block::Nodes(set));
            }
            "ELEMENT" => {
                let of = plain(keyword.get("TYPE").unwrap_or_default());
                let Some(kind) = kind_of(&of) else {
                    return Err(line.error(format!(
                        "element type \"{of}\" is not read; solids of 4 to 20 nodes (C3D4, C3D20R), faces of 3 to 9 \
                         (S4, CPS6) and lines (B31, T3D2) are"
                    )));
                };
                let Some((kind, is_shell)) = kind else {
                    self.left.insert(format!("*ELEMENT, TYPE={of}"));
                    return Ok(Block::Passed);
                };
                self.blocks.push(Elements {
                    kind,
                    is_shell,
                    at,
                    first: self.element_numbers.len(),
                    nodes: Vec::new(),
                });
                let set = keyword.get("ELSET");
                let set = set.map(|set| self.element_sets.place(of_assembly, set, notes));
                return Ok(Block::Elements(set));
            }
            "NSET" if keyword.get("ELSET").is_some() => {
                self.left.insert("*NSET, ELSET=".into());
            }
            "NSET" if of_assembly && keyword.get("INSTANCE").is_none() => {
                self.left.insert("*NSET without INSTANCE".into());
            }
            "NSET" | "ELSET" => {
                let Some(set) = keyword.get(name) else {
                    let message = format!("*{name} has no name of the set ({name}=)");
                    return Err(line.error(message));
                };
                let is_of_nodes = name == "NSET";
                let sets = if is_of_nodes {
                    &mut self.node_sets
                } else {
                    &mut self.element_sets
                };
                return Ok(Block::Set {
                    is_of_nodes,
                    set: sets.place(of_assembly, set, notes),
                    generates: keyword.get("GENERATE").is_some(),
                });
            }
            "SURFACE" => {
                let of = keyword.get("TYPE").unwrap_or(b"ELEMENT");
                if let Some(name) = keyword.get("NAME")
                    && of.eq_ignore_ascii_case(b"ELEMENT")
                {
                    let surface = self.surfaces.place(of_assembly, name, notes);
                    return Ok(Block::Surface(surface));
                }
                self.left.insert("*SURFACE without faces".into());
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
                return Ok(Block::Instance { is_first: true });
            }
            "ASSEMBLY" | "ENDINSTANCE" => self.in_assembly = true,
            "ENDASSEMBLY" => self.in_assembly = false,
            _ if STRUCTURE.split(' ').any(|known| known == name) => {}
            _ => {
                self.left.insert(format!("*{name}"));
            }
        }
        Ok(Block::Passed)
    }

    /// Takes a line of data.
    fn take(&mut self, bytes: &[u8], line: Range<usize>) -> Result<()> {
        let mut words = words(bytes, line.clone());
        match self.block {
            Block::Passed => {}
            Block::Nodes(set) => {
                let mut first = words.next();
                let number = first.as_mut().map(|word| integer(word, "a node number"));
                let Some(number) = number.transpose()? else {
                    return Ok(());
                };
                let mut point = [0.0; 3];
                for (x, mut word) in point.iter_mut().zip(words) {
                    if !word.rest().is_empty() {
                        *x = word.real("a coordinate")?;
                        word.end("a coordinate")?;
                    }
                }
                self.points.push(point);
                self.node_numbers.push(number);
                self.node_lines.push(line.start);
                if let Some(set) = set {
                    push(&mut self.node_sets.all[set].1, number);
                }
            }
            Block::Elements(set) => {
                for mut word in words.filter(|word| !word.rest().is_empty()) {
                    self.element
                        .push(integer(&mut word, "a number of an element")?);
                }
                self.end_element(set, &Tokens::between(bytes, line))?;
            }
            Block::Set {
                is_of_nodes,
                set,
                generates,
            } => {
                let sets = if is_of_nodes {
                    &mut self.node_sets
                } else {
                    &mut self.element_sets
                };
                let line = Tokens::between(bytes, line);
                let words = words.filter(|word| !word.rest().is_empty());
                if generates {
                    sets.all[set].1.push(generated(words, &line)?);
                } else {
                    sets.extend(set, words, self.in_assembly)?;
                }
            }
            Block::Surface(surface) => {
                let Some(mut of) = words.next() else {
                    return Ok(());
                };
                let elements = match self
                    .element_sets
                    .find(self.in_assembly, unquoted(of.rest()))
                {
                    Some(set) => self.element_sets.all[set].1.clone(),
                    None => {
                        let mut elements = Vec::new();
                        let number = integer(&mut of, "an element or the name of an element set")?;
                        push(&mut elements, number);
                        elements
                    }
                };
                self.surfaces.all[surface].1.push(Facet {
                    at: line.start,
                    elements,
                    label: words
                        .next()
                        .map_or(String::new(), |word| plain(word.rest())),
                });
            }
            Block::Instance { is_first: true } => {
                for (x, mut word) in self.offset.iter_mut().zip(words) {
                    *x = word.real("a coordinate")?;
                }
                self.block = Block::Instance { is_first: false };
            }
            Block::Instance { is_first: false } => {
                let message = "the instance is rotated, which is not read; write the mesh in place";
                return Err(Tokens::between(bytes, line).error(message));
            }
        }
        Ok(())
    }

    /// Takes the element if all its nodes are known.
    fn end_element(&mut self, set: Option<usize>, line: &Tokens) -> Result<()> {
        let (Some(block), Some((&number, nodes))) =
            (self.blocks.last_mut(), self.element.split_first())
        else {
            return Ok(());
        };
        let n_nodes = block.kind.n_nodes().unwrap_or(0);
        if nodes.len() > n_nodes {
            let (name, n) = (block.kind.name(), nodes.len());
            return Err(line.error(format!("a {name} needs {n_nodes} nodes, found {n}")));
        }
        if nodes.len() == n_nodes {
            if block.kind == Line3 {
                // The middle comes second.
                block.nodes.extend([nodes[0], nodes[2], nodes[1]]);
            } else {
                block.nodes.extend(nodes);
            }
            self.element_numbers.push(number);
            self.element_lines.push(line.position());
            self.element.clear();
            if let Some(set) = set {
                push(&mut self.element_sets.all[set].1, number);
            }
        }
        Ok(())
    }

    fn mesh(mut self, bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
        let wrong = |at: usize, message: String| {
            let start = bytes[at..].iter().take_while(|b| b.is_ascii_whitespace());
            Error::input(message).line(line_of(bytes, at + start.count()))
        };
        let index = |numbers: &[i64], lines: &[usize], what: &str| {
            Index::new(numbers, what).map_err(|error| {
                let mut seen = HashSet::new();
                let repeated = numbers.iter().position(|number| !seen.insert(number));
                let at = repeated.map_or(bytes.len(), |i| lines[i]);
                error.line(line_of(bytes, at))
            })
        };
        let nodes = index(&self.node_numbers, &self.node_lines, "node")?;
        let elements = index(&self.element_numbers, &self.element_lines, "element")?;
        let mut mesh = Mesh::default();
        let moved = |point: [f64; 3]| std::array::from_fn(|i| point[i] + self.offset[i]);
        mesh.points = self.points.into_iter().map(moved).collect();
        for block in &self.blocks {
            let n_nodes = block.kind.n_nodes().unwrap_or(1);
            let found = block.nodes.iter().enumerate().map(|(i, number)| {
                nodes.get(*number).ok_or_else(|| {
                    let element = self.element_numbers[block.first + i / n_nodes];
                    let message =
                        format!("element {element} has node {number}, which is not there");
                    wrong(block.at, message)
                })
            });
            let found = found.collect::<Result<Vec<u32>>>()?;
            mesh.cells.push_run(block.kind, n_nodes, &found);
        }
        let n_elements = mesh.cells.len();
        let mut empty = Vec::new();
        for (name, set) in self.element_sets.all {
            let cells = members(&set, &elements, &self.element_numbers);
            if !add_group(&mut mesh, &name, cells) {
                empty.push(name);
            }
        }
        for (name, facets) in self.surfaces.all {
            let mut cells = Vec::new();
            for facet in facets {
                for cell in members(&facet.elements, &elements, &self.element_numbers) {
                    let after = self
                        .blocks
                        .partition_point(|block| block.first <= cell as usize);
                    let is_shell = self.blocks[after - 1].is_shell;
                    let of = mesh.cells.get(cell as usize);
                    let number = match (facet.label.as_str(), is_shell) {
                        ("SPOS" | "SNEG", _) | ("S1" | "S2", true) => {
                            cells.push(cell);
                            continue;
                        }
                        (label, false) => label.strip_prefix('S').and_then(|n| n.parse().ok()),
                        // CalculiX counts the sides of a shell as faces.
                        (label, true) => label
                            .strip_prefix('E')
                            .and_then(|n| n.parse().ok())
                            .or_else(|| {
                                label
                                    .strip_prefix('S')?
                                    .parse::<usize>()
                                    .ok()?
                                    .checked_sub(2)
                            }),
                    };
                    let face = number.and_then(|number| face_of(of.kind, number));
                    let Some((kind, nodes)) = face.and_then(|face| side(&mesh.cells, &of, face))
                    else {
                        let (name, label) = (of.kind.name(), &facet.label);
                        return Err(wrong(facet.at, format!("a {name} has no face \"{label}\"")));
                    };
                    if mesh.cells.len() + 1 >= u32::MAX as usize {
                        return Err(wrong(facet.at, too_many("cells")));
                    }
                    cells.push(mesh.cells.len() as u32);
                    mesh.cells.push(kind, &nodes);
                }
            }
            if !add_group(&mut mesh, &name, cells) {
                empty.push(name);
            }
        }
        let sets = self.node_sets.all.into_iter();
        let sets = sets.map(|(name, set)| (name, members(&set, &nodes, &self.node_numbers)));
        let left = add_node_sets(&mut mesh, sets.collect(), n_elements);
        for (what, names) in [
            ("sets without elements", empty),
            ("node sets", left),
            (
                "keywords",
                std::mem::take(&mut self.left).into_iter().collect(),
            ),
        ] {
            let what = what.to_owned();
            notes.list(names, |names| NotKept::NamedNodes { what, names });
        }
        Ok(mesh)
    }
}

/// The stretch of a line of a set with GENERATE.
fn generated<'a>(words: impl Iterator<Item = Tokens<'a>>, line: &Tokens) -> Result<Stretch> {
    let numbers = words.map(|mut word| integer(&mut word, "a number of GENERATE"));
    match numbers.collect::<Result<Vec<i64>>>()?[..] {
        [first, last] => Ok(Stretch {
            first,
            last,
            step: 1,
        }),
        [first, last, step] if step > 0 => Ok(Stretch { first, last, step }),
        _ => Err(line.error("GENERATE needs a first and a last number, and a step of at least 1")),
    }
}

impl Sets<Stretch> {
    /// Adds the members in a line, numbers or other sets, to a set.
    fn extend<'a>(
        &mut self,
        set: usize,
        words: impl Iterator<Item = Tokens<'a>>,
        is_assembly: bool,
    ) -> Result<()> {
        for mut word in words {
            let name = unquoted(word.rest());
            let is_number = |name: &[u8]| name.iter().all(u8::is_ascii_digit);
            if is_number(name) {
                let number = integer(&mut word, "a member of a set")?;
                push(&mut self.all[set].1, number);
                continue;
            }
            let Some(other) = self.find(is_assembly, name) else {
                let name = shown(name);
                return Err(word.error(format!("there is no set {name} before this line")));
            };
            let more = self.all[other].1.clone();
            self.all[set].1.extend(more);
        }
        Ok(())
    }
}

/// Adds a group for each dimension of the cells; `false` where there are none.
fn add_group(mesh: &mut Mesh, name: &str, cells: Vec<u32>) -> bool {
    let mut parts: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
    for cell in cells {
        let dimension = mesh.cells.get(cell as usize).kind.dimension();
        parts.entry(dimension).or_default().push(cell as usize);
    }
    let is_added = !parts.is_empty();
    mesh.groups
        .extend(parts.into_iter().map(|(dimension, cells)| Group {
            dimension,
            name: name.to_owned(),
            number: None,
            condition: None,
            cells: cells.into_iter().collect::<CellSet>(),
        }));
    is_added
}

/// Adds the outer faces whose corners are all in a set of nodes as a tag, in a mesh without tags. Gives the names of
/// the other sets, and of sets of all nodes.
fn add_node_sets(mesh: &mut Mesh, sets: Vec<(String, Vec<u32>)>, n_elements: usize) -> Vec<String> {
    let mut left = Vec::new();
    let has_tags = sets.is_empty() || mesh.boundary_tags().next().is_some();
    let outer = if has_tags {
        Vec::new()
    } else {
        let dimension = mesh.cells.dimension();
        exterior_faces(&mesh.cells, 0..n_elements, dimension, |_| true)
    };
    for (name, nodes) in sets {
        let mut is_in = vec![false; mesh.points.len()];
        nodes.iter().for_each(|node| is_in[*node as usize] = true);
        let is_all = !is_in.contains(&false);
        let first = mesh.cells.len();
        for (kind, nodes) in outer.iter().filter(|_| !is_all) {
            let corners = &nodes[..kind.n_corners(nodes.len())];
            if corners.iter().all(|corner| is_in[*corner as usize])
                && mesh.cells.len() + 1 < u32::MAX as usize
            {
                mesh.cells.push(*kind, nodes);
            }
        }
        let cells = first as u32..mesh.cells.len() as u32;
        if !add_group(mesh, &name, cells.collect()) {
            left.push(name);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

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
        ] {
            let error = mesh_of(&BOX.replacen(before, after, 1)).0;
            let error = error.expect_err(after).to_string();
            assert!(error.contains(word), "{error}");
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
