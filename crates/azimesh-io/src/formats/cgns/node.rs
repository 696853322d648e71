//! Nodes of a CGNS file: a name, a label, data, children, whatever file format they are stored in.

use super::super::hdf5::{File, MissingFiles};
use super::super::names::decoded;
use super::super::{Notes, Source};
use super::stored::{Data, Stored};
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

/// A node; its children are read on first use.
pub(super) struct Node {
    stored: Stored,
    name: String,
    label: String,
    path: String,
    children: OnceCell<Vec<Node>>,
    latin1: Latin1,
}

/// Texts of a file that were read as Latin-1, known to all of its nodes.
type Latin1 = Rc<RefCell<Vec<String>>>;

impl Node {
    /// The node above all bases, and the files that links lead to in vain.
    pub fn root(source: &Source) -> Result<(Self, MissingFiles)> {
        let (stored, missing) = Stored::root(source)?;
        let root = Self {
            stored,
            name: String::new(),
            label: String::new(),
            path: String::new(),
            children: OnceCell::new(),
            latin1: Latin1::default(),
        };
        Ok((root, missing))
    }

    fn below(&self, stored: Stored) -> Result<Self> {
        let name = self.decoded(stored.name());
        let path = format!("{}/{name}", self.path);
        let stored = stored.target(&path)?;
        Ok(Self {
            label: stored.label(&path)?,
            stored,
            name,
            path,
            children: OnceCell::new(),
            latin1: self.latin1.clone(),
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
        let children = self.stored.children();
        let children = children.map_err(|e| e.dataset(&self.path))?.into_iter();
        let children: Result<Vec<Node>> = children.map(|child| self.below(child)).collect();
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

    /// The data as it is stored.
    pub fn data(&self) -> Result<Data> {
        self.data_or_none()?
            .ok_or_else(|| self.refuse("it has no data"))
    }

    fn data_or_none(&self) -> Result<Option<Data>> {
        let data = self.stored.data();
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

    /// Tells of the texts of the file that were read as Latin-1.
    pub fn note_latin1(&self, notes: &mut Notes) {
        let texts = self.latin1.borrow();
        texts.iter().for_each(|text| notes.latin1(text));
    }

    fn bytes(&self) -> Result<Vec<u8>> {
        match self.values()? {
            Values::I8(bytes) => Ok(bytes.into_iter().map(|byte| byte as u8).collect()),
            Values::U8(bytes) => Ok(bytes),
            Values::Text(lines) => Ok(lines.concat().into_bytes()),
            _ => Err(self.refuse("its data must be text")),
        }
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

/// Whether an HDF5 file holds what every CGNS file does.
pub(super) fn has_bases(source: &Source) -> bool {
    let names = File::open(source).and_then(|file| file.root()?.names());
    names.is_ok_and(|(groups, _)| groups.iter().any(|name| name == "CGNSLibraryVersion"))
}

/// Text up to the first zero, without spaces at its end.
pub(super) fn trimmed(bytes: &[u8]) -> String {
    decoded(to_zero(bytes)).trim_end().to_owned()
}

/// Bytes up to the first zero.
fn to_zero(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|&byte| byte == 0);
    &bytes[..end.unwrap_or(bytes.len())]
}
