//! Nodes of a CGNS file: a name, a label, data, children. Stored as groups of HDF5 or as nodes of ADF; links, also into
//! other files, are followed here.

use super::super::hdf5::{self, Group, MissingFiles};
use super::super::names::decoded;
use super::super::{Notes, Source, adf};
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::ops::Range;
use std::rc::Rc;

/// Most links that lead from one to the next.
const MOST_LINKS: usize = 16;

/// A node; its children are read on first use.
pub(super) struct Node {
    stored: Stored,
    name: String,
    label: String,
    path: String,
    children: OnceCell<Vec<Node>>,
    /// Texts of the file that were read as Latin-1, known to all of its nodes.
    latin1: Rc<RefCell<Vec<String>>>,
}

enum Stored {
    Hdf5(Group),
    Adf(adf::Node),
}

impl Node {
    /// The node above all bases, and the files that links lead to in vain.
    pub fn root(source: &Source) -> Result<(Self, MissingFiles)> {
        let bytes = source.bytes();
        let (stored, missing) = if adf::is_adf(bytes) {
            (
                Stored::Adf(adf::Node::root(source)?),
                MissingFiles::default(),
            )
        } else if hdf5::is_hdf5(bytes) {
            let file = hdf5::File::open(source)?;
            (Stored::Hdf5(file.root()?), file.missing_files())
        } else {
            return Err(Error::input(format!(
                "CGNS files are HDF5 or ADF files, and this is neither: it begins with {}; HDF5 begins with \"{}\", ADF with \
                 four bytes of any kind and \"{}\"",
                hdf5::first_bytes(bytes),
                hdf5::SIGNATURE.escape_ascii(),
                adf::NAME.escape_ascii()
            ))
            .byte(0));
        };
        let root = Self::new(stored, String::new(), String::new(), String::new());
        Ok((root, missing))
    }

    fn new(stored: Stored, name: String, label: String, path: String) -> Self {
        Self {
            stored,
            name,
            label,
            path,
            children: OnceCell::new(),
            latin1: Rc::default(),
        }
    }

    /// A child, or the node that it links to.
    fn below(&self, stored: Stored) -> Result<Self> {
        let name = match &stored {
            Stored::Hdf5(group) => self.decoded(group.name().as_bytes()),
            Stored::Adf(node) => self.decoded(node.name()),
        };
        let path = format!("{}/{name}", self.path);
        let linked = match stored {
            Stored::Hdf5(group) => linked_group(group).and_then(|group| {
                let label = text_of(&group, "label")?.unwrap_or_default();
                Ok((Stored::Hdf5(group), label))
            }),
            Stored::Adf(node) => node.target().map(|node| {
                let label = decoded(node.label()).into_owned();
                (Stored::Adf(node), label)
            }),
        };
        let (stored, label) = linked.map_err(|error| error.dataset(&path))?;
        Ok(Self {
            latin1: self.latin1.clone(),
            ..Self::new(stored, name, label, path)
        })
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The label, which says what it is: `Zone_t`.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The path from the root.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Adds its place to an error.
    pub fn refuse(&self, message: impl Into<String>) -> Error {
        Error::input(message).dataset(&self.path)
    }

    /// The children, in the order of creation where the file has that, else by name.
    pub fn children(&self) -> Result<&[Node]> {
        if let Some(children) = self.children.get() {
            return Ok(children);
        }
        let stored: Result<Vec<Stored>> = match &self.stored {
            Stored::Hdf5(group) => group.groups().map(|groups| {
                let groups = groups.into_iter();
                let nodes = groups.filter(|group| !group.name().starts_with(' '));
                nodes.map(Stored::Hdf5).collect()
            }),
            Stored::Adf(node) => {
                let children = node.children();
                children.map(|nodes| nodes.into_iter().map(Stored::Adf).collect())
            }
        };
        let stored = stored
            .map_err(|error| error.dataset(&self.path))?
            .into_iter();
        let children: Result<Vec<Node>> = stored.map(|stored| self.below(stored)).collect();
        let children = children?;
        Ok(self.children.get_or_init(|| children))
    }

    /// The children with this label.
    pub fn labelled<'a>(&'a self, label: &'a str) -> Result<impl Iterator<Item = &'a Node>> {
        let children = self.children()?.iter();
        Ok(children.filter(move |child| child.label == label))
    }

    /// The child of this name.
    pub fn child(&self, name: &str) -> Result<Option<&Node>> {
        Ok(self.children()?.iter().find(|child| child.name == name))
    }

    /// The child of this name, which must be there.
    pub fn need(&self, name: &str) -> Result<&Node> {
        self.child(name)?
            .ok_or_else(|| self.refuse(format!("it has no \"{name}\"")))
    }

    /// The data as stored.
    pub fn data(&self) -> Result<Data> {
        self.data_or_none()?
            .ok_or_else(|| self.refuse("it has no data"))
    }

    fn data_or_none(&self) -> Result<Option<Data>> {
        let data = match &self.stored {
            Stored::Hdf5(group) => {
                let data = group.dataset(" data");
                data.map(|data| data.map(|data| Data::Hdf5(Box::new(data))))
            }
            Stored::Adf(node) => node.data().map(|data| data.map(Data::Adf)),
        };
        data.map_err(|error| error.dataset(&self.path))
    }

    /// All of its data.
    pub fn values(&self) -> Result<Values> {
        let values = self.data()?.values();
        values.map_err(|error| self.refuse(error.message))
    }

    /// The data, which must be integers.
    pub fn integers(&self) -> Result<Vec<i64>> {
        let values = self.values()?;
        values
            .to_integers()
            .ok_or_else(|| self.refuse("its data must be integers"))
    }

    /// The data, which must be numbers.
    pub fn numbers(&self) -> Result<Vec<f64>> {
        self.values()?
            .to_f64()
            .ok_or_else(|| self.refuse("its data must be numbers"))
    }

    /// The data as text, without what fills it up.
    pub fn text(&self) -> Result<String> {
        let bytes = self.bytes()?;
        Ok(self.decoded(to_zero(&bytes)).trim_end().to_owned())
    }

    /// The data as text; empty where there is none.
    pub fn text_or_none(&self) -> Result<String> {
        match self.data_or_none()? {
            Some(_) => self.text(),
            None => Ok(String::new()),
        }
    }

    /// Text that azimesh has put there, with every space that it has.
    pub fn own_text(&self) -> Result<String> {
        Ok(self.decoded(&self.bytes()?))
    }

    /// The data as names of 32 characters each.
    pub fn names(&self) -> Result<Vec<String>> {
        let bytes = self.bytes()?;
        let names = bytes.chunks(32).map(|name| self.decoded(to_zero(name)));
        Ok(names.map(|name| name.trim_end().to_owned()).collect())
    }

    /// The data as strings, each with a zero after it.
    pub fn strings(&self) -> Result<Vec<String>> {
        let bytes = self.bytes()?;
        let ended = bytes.strip_suffix(b"\0").unwrap_or(&bytes);
        let strings = ended.split(|&byte| byte == 0);
        Ok(strings.map(|text| self.decoded(text)).collect())
    }

    fn decoded(&self, bytes: &[u8]) -> String {
        let text = decoded(bytes);
        if let Cow::Owned(text) = &text {
            self.latin1.borrow_mut().push(text.clone());
        }
        text.into_owned()
    }

    /// Reports the texts of the file that were read as Latin-1.
    pub fn note_latin1(&self, notes: &mut Notes) {
        let texts = self.latin1.borrow();
        texts.iter().for_each(|text| notes.latin1(text));
    }

    fn bytes(&self) -> Result<Vec<u8>> {
        text_bytes(self.values()?).ok_or_else(|| self.refuse("its data must be text"))
    }

    /// Its name in full where the one that CGNS takes is another: azimesh has put it there.
    pub fn full_name(&self) -> Result<Option<String>> {
        self.child(super::FULL_NAME)?
            .map(Node::own_text)
            .transpose()
    }

    /// Text of a child of this name; `None` without it.
    pub fn child_text(&self, name: &str) -> Result<Option<String>> {
        self.child(name)?.map(Node::text).transpose()
    }

    /// Sizes of its data as CGNS counts them, the first index running fastest.
    pub fn sizes(&self) -> Result<Vec<u64>> {
        let data = self.data()?;
        Ok(data.shape().iter().rev().copied().collect())
    }
}

/// The data of a node.
pub(super) enum Data {
    Hdf5(Box<hdf5::Dataset>),
    Adf(adf::Data),
}

/// `$body` with `$data` standing for the data of either kind.
macro_rules! either {
    ($self:expr, $data:ident => $body:expr) => {
        match $self {
            Data::Hdf5($data) => $body,
            Data::Adf($data) => $body,
        }
    };
}

impl Data {
    /// Number of values along each index; the last index varies fastest.
    pub fn shape(&self) -> &[u64] {
        either!(self, data => data.shape())
    }

    /// Number of rows: values of the first index.
    pub fn n_rows(&self) -> u64 {
        either!(self, data => data.n_rows())
    }

    /// Values in one row.
    pub fn row(&self) -> Result<usize> {
        either!(self, data => data.row())
    }

    /// At least `n` rows, so many that they are read without waste.
    pub fn whole_chunks(&self, n: u64) -> u64 {
        either!(self, data => data.whole_chunks(n))
    }

    /// Refuses rows that are not there, and more than the file can hold.
    pub fn check_rows(&self, rows: &Range<u64>) -> Result<()> {
        either!(self, data => data.check_rows(rows))
    }

    /// The values of some rows.
    pub fn rows(&self, rows: Range<u64>) -> Result<Values> {
        either!(self, data => data.rows(rows))
    }

    /// All values.
    pub fn values(&self) -> Result<Values> {
        either!(self, data => data.values())
    }
}

/// The group that a chain of links ends at.
fn linked_group(mut group: Group) -> Result<Group> {
    let mut links = 0;
    while text_of(&group, "type")?.as_deref() == Some("LK") {
        links += 1;
        if links > MOST_LINKS {
            return Err(Error::input("its links form a loop"));
        }
        group = match group.group(" link") {
            Ok(Some(next)) => next,
            Ok(None) => return Err(broken_link(&group, None)),
            Err(error) => return Err(broken_link(&group, Some(error))),
        };
    }
    Ok(group)
}

fn text_of(group: &Group, attribute: &str) -> Result<Option<String>> {
    let text = group.text(attribute)?;
    Ok(text.map(|text| trimmed(text.as_bytes())))
}

/// A link that leads nowhere or, for a reason that the library gives, could not be followed.
fn broken_link(group: &Group, why: Option<Error>) -> Error {
    let word = |name: &str| {
        let bytes = text_bytes(group.dataset(name).ok()??.values().ok()?)?;
        Some(trimmed(&bytes)).filter(|word| !word.is_empty())
    };
    let mut to = format!("this links to \"{}\"", word(" path").unwrap_or_default());
    let file = word(" file");
    if let Some(file) = &file {
        to += &format!(" in the file \"{file}\"");
    }
    Error::input(match (why, file) {
        (Some(why), _) => format!("{to}, and the link could not be followed: {}", why.message),
        (_, Some(_)) => {
            format!("{to}; that file is not in the folder of this one, or has no such node")
        }
        _ => format!("{to}, which is not in the file"),
    })
}

/// The bytes of text; `None` for numbers.
fn text_bytes(values: Values) -> Option<Vec<u8>> {
    match values {
        Values::I8(bytes) => Some(bytes.into_iter().map(|byte| byte as u8).collect()),
        Values::U8(bytes) => Some(bytes),
        Values::Text(lines) => Some(lines.concat().into_bytes()),
        _ => None,
    }
}

/// Tests if an HDF5 file holds what every CGNS file does.
pub(super) fn has_bases(source: &Source) -> bool {
    let names = hdf5::File::open(source).and_then(|file| file.root()?.names());
    names.is_ok_and(|(groups, _)| groups.iter().any(|name| name == "CGNSLibraryVersion"))
}

/// Text up to the first zero, without spaces at its end.
fn trimmed(bytes: &[u8]) -> String {
    decoded(to_zero(bytes)).trim_end().to_owned()
}

/// Bytes up to the first zero.
fn to_zero(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|&byte| byte == 0);
    &bytes[..end.unwrap_or(bytes.len())]
}
