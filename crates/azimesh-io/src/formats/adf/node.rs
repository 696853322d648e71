//! A node of a file: its name, its children, and the places of its data.

use super::data::{Data, Pieces};
use super::file::{File, POINTER, TAG, number};
use super::links::{self, Files, Link};
use azimesh_core::error::Result;
use std::ops::Range;
use std::rc::Rc;

/// Bytes of the header of a node.
const HEADER: usize = 246;
/// Bytes of a name, and of a label.
const NAME: usize = 32;
/// Bytes of a child in the table of children.
const CHILD: usize = NAME + POINTER;
/// Bytes of a piece in the table of pieces.
const PIECE: usize = 2 * POINTER;
/// Bytes before the content of a table or of data: a tag, and a pointer to the tag at its end.
const OPENING: u64 = TAG + POINTER as u64;

/// A node.
#[derive(Clone)]
pub struct Node {
    pub(super) file: Rc<File>,
    pub(super) files: Rc<Files>,
    /// Its first byte.
    at: u64,
}

/// Children of a node, or pieces of its data: how many, and where their table is.
struct Table {
    n: u64,
    at: u64,
}

impl Node {
    /// The node above all others.
    pub fn root(source: &super::super::Source) -> Result<Self> {
        let file = Rc::new(File::open(source)?);
        Self::root_of(file, Rc::default())
    }

    pub(super) fn root_of(file: Rc<File>, files: Rc<Files>) -> Result<Self> {
        let at = file.root();
        Self { file, files, at }.checked()
    }

    /// Refuses what is no node.
    fn checked(self) -> Result<Self> {
        self.file.check_tag(self.at, b"NoDe", "a node")?;
        let end = self.at.saturating_add(HEADER as u64 - TAG);
        self.file.check_tag(end, b"TaiL", "the end of a node")?;
        Ok(self)
    }

    fn header(&self) -> &[u8] {
        let header = self.file.part(self.at, HEADER, "a node");
        header.expect("it was there when the node was opened")
    }

    /// Bytes of the header, and where they are.
    fn field(&self, bytes: Range<usize>) -> (&[u8], u64) {
        (&self.header()[bytes.clone()], self.at + bytes.start as u64)
    }

    fn count(&self, bytes: Range<usize>, what: &str) -> Result<u64> {
        let (digits, at) = self.field(bytes);
        number(digits).ok_or_else(|| {
            let digits = digits.escape_ascii();
            let message = format!("the number of {what} must be hexadecimal; this is \"{digits}\"");
            self.file.refuse(message, at)
        })
    }

    fn table(&self, count: Range<usize>, pointer: Range<usize>, what: &str) -> Result<Table> {
        let n = self.count(count, what)?;
        let at = match n {
            0 => 0,
            _ => {
                let (pointer, at) = self.field(pointer);
                self.file.pointer(pointer, at)?
            }
        };
        Ok(Table { n, at })
    }

    /// The name, without the blanks behind it.
    pub fn name(&self) -> &[u8] {
        trimmed(self.field(4..36).0)
    }

    /// The label, which says what it is.
    pub fn label(&self) -> &[u8] {
        trimmed(self.field(36..68).0)
    }

    /// The type of its data, in capital letters.
    fn data_type(&self) -> Vec<u8> {
        trimmed(self.field(96..128).0).to_ascii_uppercase()
    }

    /// The children, in the order of their table.
    pub fn children(&self) -> Result<Vec<Node>> {
        let table = self.table(68..76, 84..96, "children")?;
        let content = self.opened(&table, [b"SNTb", b"snTE"], CHILD, "a table of children")?;
        (0..table.n)
            .map(|i| self.child_at(content.start + i * CHILD as u64, i))
            .collect()
    }

    /// The child of this name.
    pub fn child(&self, name: &[u8]) -> Result<Option<Node>> {
        let table = self.table(68..76, 84..96, "children")?;
        let content = self.opened(&table, [b"SNTb", b"snTE"], CHILD, "a table of children")?;
        let name = &name[..name.len().min(NAME)];
        for i in 0..table.n {
            let at = content.start + i * CHILD as u64;
            if trimmed(self.file.part(at, NAME, "a child")?) == name {
                return self.child_at(at, i).map(Some);
            }
        }
        Ok(None)
    }

    fn child_at(&self, entry: u64, i: u64) -> Result<Node> {
        let at = self.file.pointer_at(entry + NAME as u64)?;
        let child = Self { at, ..self.clone() }.checked()?;
        self.file.claim(at, (self.at, i))?;
        Ok(child)
    }

    /// The bytes between the tags of a table or of data.
    fn content(&self, at: u64, [first, last]: [&[u8; 4]; 2], what: &str) -> Result<Range<u64>> {
        let file = &self.file;
        file.check_tag(at, first, what)?;
        let end = file.pointer_at(at + TAG)?;
        file.check_tag(end, last, &format!("the end of {what}"))?;
        let start = at + OPENING;
        if start <= end {
            Ok(start..end)
        } else {
            Err(file.refuse(format!("{what} ends at byte {end}, before it starts"), at))
        }
    }

    /// The content of a table, which must have space for all of its entries of `size` bytes.
    fn opened(
        &self,
        table: &Table,
        tags: [&[u8; 4]; 2],
        size: usize,
        what: &str,
    ) -> Result<Range<u64>> {
        if table.n == 0 {
            return Ok(0..0);
        }
        let content = self.content(table.at, tags, what)?;
        let most = (content.end - content.start) / size as u64;
        if table.n > most {
            let n = table.n;
            let message = format!("{what} has room for {most}; its node says that there are {n}");
            return Err(self.file.refuse(message, table.at));
        }
        Ok(content)
    }

    /// The data; `None` where there is none.
    pub fn data(&self) -> Result<Option<Data>> {
        let data_type = self.data_type();
        if data_type.is_empty() || data_type == b"MT" {
            return Ok(None);
        }
        let shape = self.shape()?;
        let chunks = self.table(226..230, 230..242, "pieces of data")?;
        if shape.is_empty() || (chunks.n == 0 && !shape.contains(&0)) {
            return Ok(None);
        }
        let (_, at) = self.field(96..128);
        Data::new(&self.file, &data_type, shape, at, |n_bytes| {
            self.pieces(&chunks, n_bytes)
        })
        .map(Some)
    }

    /// Number of values along each index, the last index running fastest.
    fn shape(&self) -> Result<Vec<u64>> {
        let n = self.count(128..130, "dimensions")?;
        let (dimensions, at) = self.field(130..226);
        if n > 12 {
            let message = format!("data has {n} dimensions; there can be 12");
            return Err(self.file.refuse(message, at - 2));
        }
        let dimension = |(i, bytes): (usize, &[u8])| {
            self.file.dimension(bytes).ok_or_else(|| {
                let bytes = bytes.escape_ascii();
                let message = format!("a dimension must be hexadecimal; this is \"{bytes}\"");
                self.file.refuse(message, at + 8 * i as u64)
            })
        };
        let dimensions = dimensions.chunks(8).enumerate().take(n as usize);
        let mut shape: Vec<u64> = dimensions.map(dimension).collect::<Result<_>>()?;
        shape.reverse();
        Ok(shape)
    }

    /// Finds the first `n_bytes` of the data.
    fn pieces(&self, chunks: &Table, n_bytes: u64) -> Result<Pieces> {
        let mut pieces = Pieces::default();
        let tags = [b"DaTa", b"dEnD"];
        if chunks.n == 1 {
            self.file.claim(chunks.at, (self.at, 0))?;
            pieces.add(self.content(chunks.at, tags, "data")?, n_bytes);
        }
        if chunks.n > 1 {
            let what = "a table of pieces of data";
            let table = self.opened(chunks, [b"DCtb", b"dcTE"], PIECE, what)?;
            for i in 0..chunks.n {
                // What was longer before it was written anew has pieces that are no more in use.
                if pieces.n_bytes() == n_bytes {
                    break;
                }
                let entry = table.start + i * PIECE as u64;
                let [first, last] = [0, POINTER as u64].map(|at| self.file.pointer_at(entry + at));
                let (first, last) = (first?, last?);
                self.file.claim(first, (self.at, i))?;
                let content = self.content(first, tags, "a piece of data")?;
                // What is left of data that was longer may end before its table says, if no more is needed.
                let last = last.min(content.start + (n_bytes - pieces.n_bytes()));
                if !(content.start..=content.end).contains(&last) {
                    let message = format!(
                        "a piece of data ends at byte {last} by its table and at byte {} by itself",
                        content.end
                    );
                    return Err(self.file.refuse(message, first));
                }
                pieces.add(content.start..last, n_bytes);
            }
        }
        if pieces.n_bytes() == n_bytes {
            Ok(pieces)
        } else {
            let message = format!(
                "the dimensions of data need {n_bytes} bytes; there are {}",
                pieces.n_bytes()
            );
            Err(self.file.refuse(message, self.at + 130))
        }
    }

    /// The target, where it is a link.
    pub(super) fn link(&self) -> Result<Option<Link>> {
        if self.data_type() != b"LK" {
            return Ok(None);
        }
        let data = self.data()?.ok_or_else(|| {
            let message = "a link must say where it leads";
            self.file.refuse(message, self.at)
        })?;
        Ok(Some(Link::parse(&data.bytes(), self.file.has_old_links())))
    }

    /// The node that it stands for where it is a link, else itself.
    pub fn target(&self) -> Result<Node> {
        let mut left = links::MOST;
        links::target(self.clone(), &mut left)
    }
}

/// Text up to the first zero, without blanks at its end.
pub fn trimmed(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|byte| *byte == 0);
    bytes[..end.unwrap_or(bytes.len())].trim_ascii_end()
}
