//! An open file: its header, its tags and pointers, and which part of it belongs to which node.

use super::super::Source;
use azimesh_core::error::{Error, Result};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Bytes of a block, the unit of pointers.
const BLOCK: u64 = 4096;
/// Bytes of a pointer.
pub const POINTER: usize = 12;
/// Bytes of a tag.
pub const TAG: u64 = 4;
/// Bytes of the header.
const HEADER: usize = 186;

/// An open file.
pub struct File {
    pub source: Source,
    head: Head,
    /// The owner of the node or data at a byte: a node, and a number in it.
    owners: RefCell<BTreeMap<u64, (u64, u64)>>,
}

/// The content of the header.
struct Head {
    /// True if pointers and dimensions are numbers instead of text.
    is_binary: bool,
    is_big_endian: bool,
    /// Bytes of a long integer.
    long: usize,
    has_old_links: bool,
    root: u64,
    /// The last byte that is in use.
    end: Option<u64>,
}

impl File {
    /// Reads the header.
    pub fn open(source: &Source) -> Result<Self> {
        let mut file = Self {
            source: source.clone(),
            head: Head {
                is_binary: false,
                is_big_endian: false,
                long: 8,
                has_old_links: false,
                root: 0,
                end: None,
            },
            owners: RefCell::default(),
        };
        let read = file.read_header();
        read.map_err(|error| error.file(source.path()))?;
        file.claim(file.head.root, (u64::MAX, 0))?;
        Ok(file)
    }

    fn read_header(&mut self) -> Result<()> {
        let source = self.source.clone();
        let header: &[u8; HEADER] = source.bytes().first_chunk().ok_or_else(|| {
            let n = source.bytes().len();
            Error::input(format!(
                "the file ends after {n} bytes; the header of an ADF file has {HEADER}"
            ))
            .byte(n as u64)
        })?;
        for (at, tag) in [32, 64, 96, 102, 130, 182].into_iter().zip(0..) {
            self.check_tag(at, format!("AdF{tag}").as_bytes(), "the header")?;
        }
        self.head.is_binary = match header[25] {
            b'A' => false,
            b'B' => true,
            _ => return Err(other_version(header)),
        };
        let minor = number(&header[26..28]).filter(|_| header[28] != b'>');
        let minor = minor.ok_or_else(|| other_version(header))?;
        self.head.has_old_links = header[25] == b'A' && minor < 2;
        self.head.is_big_endian = match header[100] {
            b'B' => true,
            b'L' => false,
            b'C' => {
                return Err(Error::input(
                    "this ADF file has numbers of Cray machines, which are not read; convert it with \
                     adf2hdf, a tool of CGNS",
                )
                .byte(100));
            }
            other => {
                return Err(Error::input(format!(
                    "the numbers of this ADF file are of the format \"{}\"; B and L are read, IEEE numbers in big and in \
                     little endian",
                    other.escape_ascii()
                ))
                .byte(100));
            }
        };
        self.head.long = long_integers(header)?;
        self.head.end = self.pointer(&header[146..158], 146).ok();
        self.head.root = self.pointer(&header[134..146], 134)?;
        Ok(())
    }

    /// The byte of the root.
    pub fn root(&self) -> u64 {
        self.head.root
    }

    /// Tests if numbers have the other byte order than on this machine.
    pub fn swaps(&self) -> bool {
        self.head.is_big_endian != cfg!(target_endian = "big")
    }

    /// Bytes of a long integer.
    pub fn long(&self) -> usize {
        self.head.long
    }

    /// Tests if a blank separates file and path of a link, as before version A02.
    pub fn has_old_links(&self) -> bool {
        self.head.has_old_links
    }

    /// Adds the name of the file to an error.
    pub fn refuse(&self, message: impl Into<String>, at: u64) -> Error {
        Error::input(message).byte(at).file(self.source.path())
    }

    /// Some bytes of the file, `what` for messages.
    pub fn part(&self, at: u64, n: usize, what: &str) -> Result<&[u8]> {
        let bytes = self.source.bytes();
        let start = usize::try_from(at).ok();
        let range = start.and_then(|start| Some(start..start.checked_add(n)?));
        let part = range.and_then(|range| bytes.get(range));
        part.ok_or_else(|| {
            let length = bytes.len();
            let wanted = self.head.end.map(|end| end.saturating_add(1));
            let wanted = wanted.filter(|wanted| *wanted > length as u64);
            let said = wanted.map_or(String::new(), |n| {
                format!(" of the {n} that its header states")
            });
            self.refuse(
                format!("{what} would be here, but the file has {length} bytes{said}"),
                at,
            )
        })
    }

    /// Refuses a place without this tag of `what`.
    pub fn check_tag(&self, at: u64, tag: &[u8], what: &str) -> Result<()> {
        let found = self.part(at, tag.len(), what)?;
        if found == tag {
            return Ok(());
        }
        let (tag, found) = (tag.escape_ascii(), found.escape_ascii());
        Err(self.refuse(
            format!("{what} has the tag \"{tag}\" here; this file has \"{found}\""),
            at,
        ))
    }

    /// The byte that a pointer leads to, which is itself at `at`.
    pub fn pointer(&self, bytes: &[u8], at: u64) -> Result<u64> {
        let numbers = if self.head.is_binary {
            Some((self.integer(&bytes[..8]), self.integer(&bytes[8..])))
        } else {
            number(&bytes[..8]).zip(number(&bytes[8..]))
        };
        let place = numbers.and_then(|(block, offset)| {
            let start = block.checked_mul(BLOCK)?;
            start.checked_add(offset)
        });
        place.ok_or_else(|| {
            let found = bytes.escape_ascii();
            self.refuse(
                format!("\"{found}\" is no pointer to a place in the file"),
                at,
            )
        })
    }

    /// The pointer that is at a place.
    pub fn pointer_at(&self, at: u64) -> Result<u64> {
        self.pointer(self.part(at, POINTER, "a pointer")?, at)
    }

    /// A dimension of data from its eight bytes.
    pub fn dimension(&self, bytes: &[u8]) -> Option<u64> {
        if self.head.is_binary {
            Some(self.integer(bytes))
        } else {
            number(bytes)
        }
    }

    /// An integer of as many bytes.
    fn integer(&self, bytes: &[u8]) -> u64 {
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        if self.head.is_big_endian {
            bytes.iter().fold(0, add)
        } else {
            bytes.iter().rev().fold(0, add)
        }
    }

    /// Records the owner of a block, and its use. Each node has one parent and all data belong to one node. Damaged or
    /// hostile content is therefore not larger than the file and has no loops.
    pub fn claim(&self, at: u64, owner: (u64, u64)) -> Result<()> {
        let mut owners = self.owners.borrow_mut();
        let first = owners.entry(at).or_insert(owner);
        if *first == owner {
            return Ok(());
        }
        let message = match first.0 {
            u64::MAX => format!(
                "the node at byte {} has the root of the file as its child",
                owner.0
            ),
            first => format!(
                "this belongs to the node at byte {first} and to the node at byte {} again; it can have one place only",
                owner.0
            ),
        };
        Err(self.refuse(message, at))
    }
}

/// A number in hexadecimal digits.
pub fn number(digits: &[u8]) -> Option<u64> {
    digits.iter().try_fold(0_u64, |sum, digit| {
        let digit = (*digit as char).to_digit(16)?;
        Some(sum << 4 | u64::from(digit))
    })
}

/// Bytes of long integers; the others must have the sizes that they have everywhere.
fn long_integers(header: &[u8; HEADER]) -> Result<usize> {
    let names = ["char", "short", "int", "long", "float", "double"];
    let size = |i: usize| number(&header[106 + 2 * i..108 + 2 * i]);
    let sizes = std::array::from_fn::<_, 6, _>(size);
    match sizes {
        [Some(1), _, Some(4), Some(long @ (4 | 8)), Some(4), Some(8)] => Ok(long as usize),
        _ => {
            let found = names.iter().zip(sizes).map(|(name, size)| match size {
                Some(size) => format!("{name} {size}"),
                None => format!("{name} ?"),
            });
            let found = found.collect::<Vec<_>>().join(", ");
            Err(Error::input(format!(
                "the numbers of this ADF file have the sizes {found}; char 1, int 4, long 4 or 8, float 4 and double 8 are \
                 read"
            ))
            .byte(106))
        }
    }
}

fn other_version(header: &[u8; HEADER]) -> Error {
    let text = header[4..32].escape_ascii();
    Error::input(format!(
        "this is \"{text}\"; databases of version A00 and later and of version B are read"
    ))
    .byte(25)
}
