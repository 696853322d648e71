//! The nodes of a CGNS file to be: names, labels, data. Turned into groups and datasets of HDF5 as
//! the CGNS library lays them out.

use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Id, Links, Payload, Rows, StepFile, Stored, Tree};
use azimesh_core::error::Result;
use std::collections::BTreeMap;

/// The dataset of a node.
const DATA: &str = " data";

/// Nodes in the order in which they are added; children after parents.
#[derive(Default)]
pub(super) struct Draft<'a> {
    nodes: Vec<Node<'a>>,
}

/// Position of a node in a [`Draft`].
pub(super) type NodeIndex = usize;

struct Node<'a> {
    parent: Option<NodeIndex>,
    name: String,
    label: &'static str,
    data: Option<(DataType, Vec<u64>, Values<'a>)>,
}

/// Type of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DataType {
    /// Characters.
    C1,
    /// Integers of 4 bytes.
    I4,
    /// Integers of 8 bytes.
    I8,
    /// Floating-point numbers of 4 bytes.
    R4,
    /// Floating-point numbers of 8 bytes.
    R8,
}

enum Values<'a> {
    New(Data<'a>),
    Stored(Stored),
    Rows(&'a Rows),
}

impl DataType {
    fn name(self) -> &'static str {
        match self {
            DataType::C1 => "C1",
            DataType::I4 => "I4",
            DataType::I8 => "I8",
            DataType::R4 => "R4",
            DataType::R8 => "R8",
        }
    }

    fn element(self) -> Element {
        match self {
            DataType::C1 => Element::I8,
            DataType::I4 => Element::I32,
            DataType::I8 => Element::I64,
            DataType::R4 => Element::F32,
            DataType::R8 => Element::F64,
        }
    }

    /// Integers as values of this type, which is I4 or I8 and holds them.
    pub fn data_of(self, numbers: &[i64]) -> Data<'static> {
        Data::integers(numbers, self == DataType::I8)
    }
}

impl<'a> Draft<'a> {
    fn add(
        &mut self,
        parent: Option<NodeIndex>,
        name: &str,
        label: &'static str,
        data: Option<(DataType, Vec<u64>, Values<'a>)>,
    ) -> NodeIndex {
        self.nodes.push(Node {
            parent,
            name: name.to_owned(),
            label,
            data,
        });
        self.nodes.len() - 1
    }

    /// Adds a node without data.
    pub fn group(
        &mut self,
        parent: impl Into<Option<NodeIndex>>,
        name: &str,
        label: &'static str,
    ) -> NodeIndex {
        self.add(parent.into(), name, label, None)
    }

    /// Adds a node that holds text.
    pub fn text(
        &mut self,
        parent: NodeIndex,
        name: &str,
        label: &'static str,
        text: &str,
    ) -> NodeIndex {
        let sizes = [text.len() as u64];
        self.data(
            parent,
            (name, label),
            DataType::C1,
            &sizes,
            Data::owned(text.as_bytes()),
        )
    }

    /// Adds a node with one row of data for each step: numbers, or names.
    pub fn rows(
        &mut self,
        parent: NodeIndex,
        name: &str,
        kind: DataType,
        rows: &'a Rows,
    ) -> NodeIndex {
        let data = (kind, Vec::new(), Values::Rows(rows));
        self.add(Some(parent), name, "DataArray_t", Some(data))
    }

    /// Adds a node that holds a few integers. The first index of `sizes` runs fastest.
    pub fn integers(
        &mut self,
        parent: impl Into<Option<NodeIndex>>,
        (name, label): (&str, &'static str),
        kind: DataType,
        sizes: &[u64],
        numbers: &[i64],
    ) -> NodeIndex {
        self.data(parent, (name, label), kind, sizes, kind.data_of(numbers))
    }

    /// Adds a node that holds a few floating-point numbers.
    pub fn reals(
        &mut self,
        parent: NodeIndex,
        (name, label): (&str, &'static str),
        numbers: &[f64],
    ) -> NodeIndex {
        let sizes = [numbers.len() as u64];
        self.data(
            parent,
            (name, label),
            DataType::R8,
            &sizes,
            Data::owned(numbers),
        )
    }

    /// Adds a node that holds these values.
    pub fn data(
        &mut self,
        parent: impl Into<Option<NodeIndex>>,
        (name, label): (&str, &'static str),
        kind: DataType,
        sizes: &[u64],
        data: Data<'a>,
    ) -> NodeIndex {
        let data = (kind, sizes.to_vec(), Values::New(data));
        self.add(parent.into(), name, label, Some(data))
    }

    /// Adds the version of CGNS that the file follows.
    pub fn version(&mut self, version: f32) {
        let name = ("CGNSLibraryVersion", "CGNSLibraryVersion_t");
        self.data(None, name, DataType::R4, &[1], Data::owned(&[version]));
    }

    /// Adds a node whose values are in the file already.
    pub fn stored(
        &mut self,
        parent: NodeIndex,
        name: &str,
        (kind, sizes): (DataType, &[u64]),
        stored: Stored,
    ) -> NodeIndex {
        let data = (kind, sizes.to_vec(), Values::Stored(stored));
        self.add(Some(parent), name, "DataArray_t", Some(data))
    }

    /// Puts the children of a node, or the nodes that are children of none, into a growing file, and
    /// adds them to `links`; all but the one at `open`.
    pub fn store(
        &self,
        file: &mut StepFile,
        of: Option<NodeIndex>,
        open: Option<NodeIndex>,
        links: &mut Links,
    ) -> Result<()> {
        let mut trees: BTreeMap<NodeIndex, Tree> = BTreeMap::new();
        // The tree of each node that is in one, and what it is there.
        let mut ids: Vec<Option<(NodeIndex, Id)>> = Vec::with_capacity(self.nodes.len());
        for (place, node) in self.nodes.iter().enumerate() {
            let above = node.parent.and_then(|parent| ids[parent]);
            ids.push(match above {
                _ if open == Some(place) => None,
                _ if node.parent == of => {
                    let tree = trees.entry(place).or_insert_with(Tree::new);
                    node.describe(tree, Tree::ROOT);
                    Some((place, Tree::ROOT))
                }
                Some((top, parent)) => {
                    let tree = trees.get_mut(&top).expect("it has its parent");
                    let id = tree.group(parent, &node.name);
                    node.describe(tree, id);
                    Some((top, id))
                }
                None => None,
            });
        }
        for (place, tree) in &trees {
            links.add(&self.nodes[*place].name, file.store_object(tree)?)?;
        }
        Ok(())
    }

    /// A node whose children are put into a growing file, and which gets more of them with each step.
    pub fn open(
        &self,
        file: &mut StepFile,
        place: NodeIndex,
        child: Option<NodeIndex>,
    ) -> Result<Open> {
        let node = &self.nodes[place];
        let mut links = Links::default();
        if let Some((kind, sizes, values)) = &node.data {
            let tree = Tree::of_dataset(kind.element(), &shape(sizes), values.payload());
            links.add(DATA, file.store_object(&tree)?)?;
        }
        self.store(file, Some(place), child, &mut links)?;
        Ok(Open {
            name: node.name.clone(),
            label: node.label,
            kind: node.kind(),
            links,
        })
    }

    /// The root of the file to be, with what is not a child of `open` in the file already.
    pub fn open_root(&self, file: &mut StepFile, open: NodeIndex) -> Result<Links> {
        let mut links = Links::default();
        for (name, text) in marks() {
            let data = Data::slice(&text);
            let tree = Tree::of_dataset(Element::I8, &[text.len() as u64], data);
            links.add(name, file.store_object(&tree)?)?;
        }
        self.store(file, None, Some(open), &mut links)?;
        Ok(links)
    }

    /// The whole file as groups and datasets of HDF5.
    pub fn tree(&self) -> Tree<'_> {
        let mut tree = Tree::new();
        describe_root(&mut tree);
        for (name, text) in marks() {
            let shape = [text.len() as u64];
            let data = Data::owned(&text);
            tree.dataset(Tree::ROOT, name, Element::I8, &shape, data);
        }
        self.add_to(&mut tree, Tree::ROOT);
        tree
    }

    /// Adds all nodes to a group.
    pub fn add_to<'t>(&'t self, tree: &mut Tree<'t>, group: Id) {
        let mut ids: Vec<Id> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.map_or(group, |parent| ids[parent]);
            let id = tree.group(parent, &node.name);
            node.describe(tree, id);
            ids.push(id);
        }
    }
}

/// A node that gets more children with each step.
pub(super) struct Open {
    name: String,
    label: &'static str,
    kind: &'static str,
    /// The children that are in the file already.
    pub links: Links,
}

impl Open {
    /// Adds the node to a group.
    pub fn add_to<'t>(&'t self, tree: &mut Tree<'t>, parent: Id) -> Id {
        let id = tree.group(parent, &self.name);
        describe(tree, id, (&self.name, self.label, self.kind));
        flags(tree, id);
        tree.links(id, &self.links);
        id
    }
}

/// The file as it is at a step: `links` are in it already.
pub(super) fn root_of(links: &Links) -> Tree<'_> {
    let mut tree = Tree::new();
    describe_root(&mut tree);
    tree.links(Tree::ROOT, links);
    tree
}

impl Node<'_> {
    fn kind(&self) -> &'static str {
        self.data.as_ref().map_or("MT", |(kind, ..)| kind.name())
    }

    /// Makes a group this node.
    fn describe<'t>(&'t self, tree: &mut Tree<'t>, id: Id) {
        describe(tree, id, (&self.name, self.label, self.kind()));
        flags(tree, id);
        match &self.data {
            Some((_, _, Values::Rows(rows))) => {
                tree.rows(id, DATA, rows);
            }
            Some((kind, sizes, values)) => {
                tree.dataset(id, DATA, kind.element(), &shape(sizes), values.payload());
            }
            None => {}
        }
    }
}

impl Values<'_> {
    fn payload(&self) -> Payload<'_> {
        match self {
            Values::New(data) => data.borrowed().into(),
            Values::Stored(stored) => (*stored).into(),
            Values::Rows(rows) => Payload::Rows(rows),
        }
    }
}

/// Sizes in the order of HDF5, the last index running fastest.
fn shape(sizes: &[u64]) -> Vec<u64> {
    sizes.iter().rev().copied().collect()
}

fn describe_root(tree: &mut Tree) {
    let root = ("HDF5 MotherNode", "Root Node of HDF5 File", "MT");
    describe(tree, Tree::ROOT, root);
}

/// Text by which the CGNS library knows its files.
fn marks() -> [(&'static str, Vec<u8>); 2] {
    let order = if cfg!(target_endian = "big") {
        "IEEE_BIG_32"
    } else {
        "IEEE_LITTLE_32"
    };
    let padded = |text: &str, n: usize| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(n, 0);
        bytes
    };
    [
        (" format", padded(order, order.len() + 1)),
        (" hdf5version", padded("HDF5 Version 1.8.0", 33)),
    ]
}

fn describe(tree: &mut Tree, id: Id, (name, label, kind): (&str, &str, &str)) {
    let field = |bytes| Element::Text {
        bytes,
        terminated: true,
    };
    tree.padded_attribute(id, "name", name, field(33));
    tree.padded_attribute(id, "label", label, field(33));
    tree.padded_attribute(id, "type", kind, field(3));
}

fn flags(tree: &mut Tree, id: Id) {
    tree.number_attribute(id, "flags", &[1_i32], false);
}
