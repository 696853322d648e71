//! Files as the library of CGNS writes them, for tests: in every version, byte order and width, with data in pieces.

use crate::mesh::reverse_each;
use crate::mesh::{Values, arrays::with_numbers};

/// Version, byte order and size of a file.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// The start of the file from the letter of its version on.
    pub version: &'static str,
    /// Letters of the byte order and of the width.
    pub machine: [u8; 2],
    /// Bytes of a piece of data; 0 for one piece.
    pub piece: usize,
}

/// Little endian and 64 bits, data in one piece.
pub const PLAIN: Layout = Layout {
    version: "A02011>",
    machine: *b"LB",
    piece: 0,
};

/// Every version, byte order and width.
pub fn layouts() -> impl Iterator<Item = Layout> {
    let machines = [*b"LB", *b"LL", *b"BB", *b"BL"];
    let versions = ["A01010>", "A02011>", "B02012>"];
    versions.into_iter().flat_map(move |version| {
        machines
            .into_iter()
            .zip([0, 1, 7, 64])
            .map(move |(machine, piece)| Layout {
                version,
                machine,
                piece,
            })
    })
}

/// A node to be written.
#[derive(Debug, Clone, Default)]
pub struct Draft {
    pub name: String,
    pub label: String,
    /// Its type, dimensions with the first index running fastest, and values.
    pub data: Option<(&'static str, Vec<u64>, Values)>,
    pub children: Vec<Draft>,
}

impl Draft {
    /// A node without data.
    pub fn new(name: &str, label: &str, children: Vec<Draft>) -> Self {
        Self {
            name: name.to_owned(),
            label: label.to_owned(),
            data: None,
            children,
        }
    }

    /// A node with data of one index.
    pub fn data(name: &str, label: &str, kind: &'static str, values: Values) -> Self {
        let n = with_numbers!(&values, v => v.len(), _text => 0);
        Self {
            data: Some((kind, vec![n as u64], values)),
            ..Self::new(name, label, Vec::new())
        }
    }

    /// A node with text.
    pub fn text(name: &str, label: &str, text: &str) -> Self {
        Self::data(name, label, "C1", Values::U8(text.into()))
    }

    /// A link.
    pub fn link(name: &str, to: &str) -> Self {
        Self::data(name, "", "LK", Values::U8(to.into()))
    }
}

/// The bytes of a file with these nodes below its root.
pub fn file(layout: Layout, children: Vec<Draft>) -> Vec<u8> {
    let mut out = Writer {
        layout,
        bytes: vec![0; 266],
    };
    let root = Draft::new("ADF MotherNode", "Root Node of ADF File", children);
    let root = out.node(&root);
    let end = out.bytes.len() as u64 - 1;
    let long = if layout.machine[1] == b'B' {
        "08"
    } else {
        "04"
    };
    let sizes = format!("01020{}{long}0408080808080808", 4);
    let date = format!("{:28}", "Thu Jan  1 00:00:00 1998");
    let head = [
        format!(
            "ADF Database Version {}AdF0{date}AdF1{date}AdF2",
            layout.version
        )
        .as_bytes(),
        &layout.machine,
        format!("AdF3{sizes}AdF4").as_bytes(),
        &out.pointer(root),
        &out.pointer(end),
        &out.pointer(186),
        &out.pointer(4096),
        b"AdF5fCbt",
    ]
    .concat();
    out.bytes[..4].copy_from_slice(b"\xc0\xa8\xa3\xa9");
    out.bytes[4..4 + head.len()].copy_from_slice(&head);
    out.bytes[262..266].copy_from_slice(b"Fcte");
    out.bytes
}

/// Offset of the header of a node.
pub fn place(bytes: &[u8], name: &str) -> usize {
    let start = format!("NoDe{name:32}");
    memchr::memmem::find(bytes, start.as_bytes()).expect("the node is there")
}

/// Bytes with other ones at a place.
pub fn patched(bytes: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

struct Writer {
    layout: Layout,
    bytes: Vec<u8>,
}

impl Writer {
    fn is_binary(&self) -> bool {
        self.layout.version.starts_with('B')
    }

    fn ordered(&self, mut bytes: Vec<u8>, size: usize) -> Vec<u8> {
        if self.layout.machine[0] == b'B' {
            reverse_each(&mut bytes, size);
        }
        bytes
    }

    fn pointer(&self, at: u64) -> Vec<u8> {
        let (block, offset) = (at / 4096, at % 4096);
        if self.is_binary() {
            [
                self.ordered(block.to_le_bytes().to_vec(), 8),
                self.ordered((offset as u32).to_le_bytes().to_vec(), 4),
            ]
            .concat()
        } else {
            format!("{block:08X}{offset:04X}").into_bytes()
        }
    }

    fn dimension(&self, n: u64) -> Vec<u8> {
        if self.is_binary() {
            self.ordered(n.to_le_bytes().to_vec(), 8)
        } else {
            format!("{n:08X}").into_bytes()
        }
    }

    /// Writes a node with all that is below it, and gives its place.
    fn node(&mut self, node: &Draft) -> u64 {
        let at = self.bytes.len();
        self.bytes.resize(at + 246, b' ');
        let children: Vec<_> = node.children.iter().map(|child| self.node(child)).collect();
        let nowhere = self.pointer(4096);
        let table = match &node.children[..] {
            [] => nowhere.clone(),
            all => {
                let entries = all.iter().zip(&children);
                let entries = entries.map(|(child, at)| {
                    [format!("{:32}", child.name).into_bytes(), self.pointer(*at)].concat()
                });
                // The library allocates more.
                let room = vec![b' '; 44 * (8 - all.len() % 8)];
                let content = entries.chain([room]).collect::<Vec<_>>().concat();
                let table = self.enclosed([b"SNTb", b"snTE"], &content);
                self.pointer(table.0)
            }
        };
        let (kind, dimensions, values) = match &node.data {
            Some((kind, dimensions, values)) => (*kind, &dimensions[..], Some(values)),
            None => ("MT", &[][..], None),
        };
        let (n_chunks, chunks) = match values {
            Some(values) => self.data(kind, values),
            None => (0, nowhere),
        };
        let sizes = dimensions.iter().chain([&0; 12]).take(12);
        let sizes: Vec<_> = sizes.map(|n| self.dimension(*n)).collect();
        let n = children.len();
        let header = [
            format!(
                "NoDe{:32}{:32}{n:08X}{:08X}",
                node.name,
                node.label,
                n.next_multiple_of(8)
            )
            .as_bytes(),
            &table,
            format!("{kind:32}{:02X}", dimensions.len()).as_bytes(),
            &sizes.concat(),
            format!("{n_chunks:04X}").as_bytes(),
            &chunks,
            b"TaiL",
        ]
        .concat();
        assert_eq!(header.len(), 246);
        self.bytes[at..at + 246].copy_from_slice(&header);
        at as u64
    }

    /// Writes data; gives the number of its pieces, and the pointer to them.
    fn data(&mut self, kind: &str, values: &Values) -> (usize, Vec<u8>) {
        let bytes = with_numbers!(values, v => bytemuck::cast_slice::<_, u8>(v).to_vec(), _text => panic!("numbers"));
        let n = with_numbers!(values, v => v.len(), _text => 0);
        let mut size = bytes.len() / n.max(1);
        let mut bytes = bytes;
        if kind.ends_with('8') && !kind.starts_with('R') && self.layout.machine[1] == b'L' {
            bytes = bytes
                .chunks(8)
                .flat_map(|long| &long[..4])
                .copied()
                .collect();
            size = 4;
        }
        let bytes = self.ordered(bytes, size);
        let piece = match self.layout.piece {
            0 => bytes.len().max(1),
            n => n,
        };
        let pieces: Vec<(u64, u64)> = bytes
            .chunks(piece)
            .map(|piece| {
                // What was freed between them.
                self.bytes.extend(b"zzz");
                self.enclosed([b"DaTa", b"dEnD"], piece)
            })
            .collect();
        match pieces[..] {
            [] => (0, self.pointer(4096)),
            [(at, _)] => (1, self.pointer(at)),
            _ => {
                let entries = pieces
                    .iter()
                    .map(|(at, end)| [self.pointer(*at), self.pointer(*end)].concat());
                let entries = entries.collect::<Vec<_>>().concat();
                let table = self.enclosed([b"DCtb", b"dcTE"], &entries);
                (pieces.len(), self.pointer(table.0))
            }
        }
    }

    /// Writes content between tags, and gives the places of both.
    fn enclosed(&mut self, [first, last]: [&[u8; 4]; 2], content: &[u8]) -> (u64, u64) {
        let at = self.bytes.len() as u64;
        let end = at + 16 + content.len() as u64;
        let pointer = self.pointer(end);
        for part in [&first[..], &pointer, content, last] {
            self.bytes.extend(part);
        }
        (at, end)
    }
}
