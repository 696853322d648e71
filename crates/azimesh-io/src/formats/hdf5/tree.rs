//! The content of a file: groups, datasets and attributes, before they have addresses.

use super::header::{datatype, size, text_type};
use super::index::Chunks;
use super::messages::Links;
use super::rows::Rows;
use crate::formats::column::Data;
use crate::formats::vtk::number::{Element, Number};

/// The undefined address.
pub(super) const NOWHERE: u64 = u64::MAX;

/// Values or an object in a growing file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) struct Stored {
    pub(super) address: u64,
}

impl Stored {
    /// The values after so many bytes.
    pub fn past(self, n_bytes: u64) -> Self {
        Self {
            address: self.address + n_bytes,
        }
    }
}

/// Position of the values of a dataset.
#[derive(Debug, Clone)]
pub(super) enum Storage {
    /// In one piece.
    Contiguous(u64),
    /// In chunks of so many rows, by way of the index at this address.
    Chunked { rows: u64, index: Stored },
}

/// The content of a file. Children come back in the order in which they were added.
pub(in crate::formats) struct Tree<'a> {
    pub(super) nodes: Vec<Node<'a>>,
}

/// A group or dataset of a [`Tree`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) struct Id(pub(super) usize);

/// Values of a dataset, the last index running fastest.
pub(in crate::formats) enum Payload<'a> {
    /// Values that are written now.
    New(Data<'a>),
    /// Values in a growing file.
    Stored(Stored),
    /// Pieces of a dataset in a growing file, each of `rows` of the first index, with their index.
    Chunks {
        /// Rows of each piece.
        rows: u64,
        /// The index.
        chunks: &'a Chunks,
    },
    /// A dataset in a growing file, of one row per step.
    Rows(&'a Rows),
}

impl<'a> From<Data<'a>> for Payload<'a> {
    fn from(data: Data<'a>) -> Self {
        Payload::New(data)
    }
}

impl From<Stored> for Payload<'_> {
    fn from(stored: Stored) -> Self {
        Payload::Stored(stored)
    }
}

#[derive(Default)]
pub(super) struct Node<'a> {
    pub attributes: Vec<Attribute>,
    pub children: Vec<(String, Id)>,
    pub dataset: Option<Dataset<'a>>,
    /// Children before those.
    pub links: Option<&'a Links>,
    /// The object of the node, where that is in the file already.
    pub object: Option<Stored>,
}

impl<'a> Node<'a> {
    fn dataset(element: Element, shape: &[u64], data: impl Into<Payload<'a>>) -> Self {
        let (shape, data) = (shape.to_vec(), data.into());
        Self {
            dataset: Some(Dataset {
                element,
                shape,
                data,
            }),
            ..Self::default()
        }
    }
}

pub(super) struct Attribute {
    pub name: String,
    pub datatype: Vec<u8>,
    pub shape: Option<Vec<u64>>,
    pub bytes: Vec<u8>,
}

pub(super) struct Dataset<'a> {
    pub element: Element,
    pub shape: Vec<u64>,
    pub data: Payload<'a>,
}

impl Dataset<'_> {
    pub fn n_bytes(&self) -> u64 {
        self.shape.iter().product::<u64>() * size(self.element)
    }
}

impl<'a> Tree<'a> {
    /// The group that holds everything.
    pub const ROOT: Id = Id(0);

    /// A file with nothing in it.
    pub fn new() -> Self {
        Self {
            nodes: vec![Node::default()],
        }
    }

    /// Adds a group to a group.
    pub fn group(&mut self, parent: Id, name: &str) -> Id {
        self.add(parent, name, Node::default())
    }

    /// Adds a dataset to a group. `data` must have as many bytes as `element` and `shape` say.
    pub fn dataset(
        &mut self,
        parent: Id,
        name: &str,
        element: Element,
        shape: &[u64],
        data: impl Into<Payload<'a>>,
    ) -> Id {
        self.add(parent, name, Node::dataset(element, shape, data))
    }

    /// A tree that is one dataset, to be an object of a growing file.
    pub fn of_dataset(element: Element, shape: &[u64], data: impl Into<Payload<'a>>) -> Self {
        let nodes = vec![Node::dataset(element, shape, data)];
        Self { nodes }
    }

    /// Adds an object of a growing file to a group.
    pub fn object(&mut self, parent: Id, name: &str, object: Stored) -> Id {
        let node = Node {
            object: Some(object),
            ..Node::default()
        };
        self.add(parent, name, node)
    }

    /// Gives a group of a growing file children that come before all others.
    pub fn links(&mut self, of: Id, links: &'a Links) {
        self.nodes[of.0].links = Some(links);
    }

    /// Adds a dataset that has one more row with each step.
    pub fn rows(&mut self, parent: Id, name: &str, rows: &'a Rows) -> Id {
        let shape = rows.shape();
        self.dataset(parent, name, rows.element, &shape, Payload::Rows(rows))
    }

    /// Adds a dataset of numbers with one index.
    pub fn numbers<T: Number>(&mut self, parent: Id, name: &str, values: &[T]) -> Id {
        let shape = [values.len() as u64];
        self.dataset(parent, name, T::ELEMENT, &shape, Data::owned(values))
    }

    /// Adds an attribute of text that takes as many bytes as it has, at least one, without a zero
    /// at the end.
    pub fn text_attribute(&mut self, of: Id, name: &str, text: &str) {
        let size = text.len().max(1);
        self.text_field(of, name, text, (size, false));
    }

    /// Adds an attribute of text in a field of so many bytes, zeros after it, at least one if it is terminated; text that
    /// is too long is cut.
    pub fn text_field(
        &mut self,
        of: Id,
        name: &str,
        text: &str,
        (size, is_terminated): (usize, bool),
    ) {
        let mut bytes = text.as_bytes().to_vec();
        bytes.truncate(size - usize::from(is_terminated));
        bytes.resize(size, 0);
        let datatype = text_type(size as u32, is_terminated);
        self.attribute(of, name, datatype, None, bytes);
    }

    /// Adds an attribute of numbers: a scalar where `is_scalar`, else with one index.
    pub fn number_attribute<T: Number>(
        &mut self,
        of: Id,
        name: &str,
        values: &[T],
        is_scalar: bool,
    ) {
        let shape = (!is_scalar).then(|| vec![values.len() as u64]);
        let bytes = bytemuck::cast_slice(values).to_vec();
        self.attribute(of, name, datatype(T::ELEMENT), shape, bytes);
    }

    fn attribute(
        &mut self,
        of: Id,
        name: &str,
        datatype: Vec<u8>,
        shape: Option<Vec<u64>>,
        bytes: Vec<u8>,
    ) {
        self.nodes[of.0].attributes.push(Attribute {
            name: name.to_owned(),
            datatype,
            shape,
            bytes,
        });
    }

    /// A node and all nodes below it, in the order in which they were added.
    pub(super) fn below(&self, Id(top): Id) -> Vec<usize> {
        let mut nodes = vec![top];
        let mut next = 0;
        while let Some(&node) = nodes.get(next) {
            nodes.extend(
                self.nodes[node]
                    .children
                    .iter()
                    .map(|(_, Id(child))| *child),
            );
            next += 1;
        }
        nodes.sort_unstable();
        nodes
    }

    fn add(&mut self, parent: Id, name: &str, node: Node<'a>) -> Id {
        let id = Id(self.nodes.len());
        self.nodes.push(node);
        self.nodes[parent.0].children.push((name.to_owned(), id));
        id
    }
}
