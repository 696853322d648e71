//! The nodes of a CGNS file to be, as groups and datasets of HDF5 in the layout of the CGNS library.

use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Id, Links, Payload, Rows, Tree};

/// The dataset of a node.
const DATA: &str = " data";

/// Nodes of a file, or of a part of a growing file.
pub(super) struct Draft<'a> {
    pub tree: Tree<'a>,
}

/// Name and label of a node.
pub(super) type Name<'n> = (&'n str, &'static str);

/// The smallest of both types of integers that holds a number.
pub(super) fn integers_for(largest: usize) -> Element {
    match i32::try_from(largest) {
        Ok(_) => Element::Int32,
        Err(_) => Element::Int64,
    }
}

impl<'a> Draft<'a> {
    /// No node: what is added to the root is to be put below a node of a growing file.
    pub fn part() -> Self {
        Self { tree: Tree::new() }
    }

    /// The root of a file.
    pub fn root() -> Self {
        let mut draft = Self::part();
        let root = ["HDF5 MotherNode", "Root Node of HDF5 File", "MT"];
        draft.describe(Tree::ROOT, root);
        draft
    }

    /// The root of a file, with the texts by which the CGNS library knows its files.
    pub fn marked_root() -> Self {
        let mut draft = Self::root();
        let order = if cfg!(target_endian = "big") {
            "IEEE_BIG_32\0"
        } else {
            "IEEE_LITTLE_32\0"
        };
        let version = format!("{:\0<33}", "HDF5 Version 1.8.0");
        for (name, text) in [(" format", order), (" hdf5version", &version)] {
            let (shape, data) = ([text.len() as u64], Data::owned(text.as_bytes()));
            let tree = &mut draft.tree;
            tree.dataset(Tree::ROOT, name, Element::Int8, &shape, data);
        }
        draft
    }

    fn describe(&mut self, id: Id, texts: [&str; 3]) {
        for ((name, text), bytes) in ["name", "label", "type"].iter().zip(texts).zip([33, 33, 3]) {
            self.tree.text_field(id, name, text, (bytes, true));
        }
    }

    fn add(&mut self, parent: Id, (name, label): Name, element: Option<Element>) -> Id {
        let id = self.tree.group(parent, name);
        let kind = match element {
            None => "MT",
            Some(Element::Int8) => "C1",
            Some(Element::Int32) => "I4",
            Some(Element::Int64) => "I8",
            Some(Element::Float32) => "R4",
            Some(_) => "R8",
        };
        self.describe(id, [name, label, kind]);
        self.tree.number_attribute(id, "flags", &[1_i32], false);
        id
    }

    /// Adds a node without data.
    pub fn group(&mut self, parent: Id, name: Name) -> Id {
        self.add(parent, name, None)
    }

    /// Adds a node whose data, of this type, and children are in a growing file.
    pub fn stored(&mut self, parent: Id, name: Name, element: Element, links: &'a Links) -> Id {
        let id = self.add(parent, name, Some(element));
        self.tree.links(id, links);
        id
    }

    /// Adds a node that holds text.
    pub fn text(&mut self, parent: Id, name: Name, text: &str) -> Id {
        let data = Data::owned(text.as_bytes());
        self.data(parent, name, (Element::Int8, &[text.len() as u64]), data)
    }

    /// Adds a node that holds a few integers.
    pub fn integers(
        &mut self,
        parent: Id,
        name: Name,
        (element, sizes): (Element, &[u64]),
        numbers: &[i64],
    ) -> Id {
        let data = Data::integers(numbers, element == Element::Int64);
        self.data(parent, name, (element, sizes), data)
    }

    /// Adds a node that holds these values. The first index of `sizes` runs fastest.
    pub fn data(
        &mut self,
        parent: Id,
        name: Name,
        (element, sizes): (Element, &[u64]),
        values: impl Into<Payload<'a>>,
    ) -> Id {
        let id = self.add(parent, name, Some(element));
        let shape: Vec<u64> = sizes.iter().rev().copied().collect();
        self.tree.dataset(id, DATA, element, &shape, values);
        id
    }

    /// Adds a node with one row of data for each step: numbers, or names.
    pub fn rows(&mut self, parent: Id, name: &str, element: Element, rows: &'a Rows) {
        let id = self.add(parent, (name, "DataArray_t"), Some(element));
        self.tree.rows(id, DATA, rows);
    }
}
