//! The nodes of a CGNS file to be, as groups and datasets of HDF5 in the layout of the CGNS library.

use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Id, Links, Payload, Rows, StepFile, Tree};
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

/// Name and label of a node.
pub(super) type Name<'n> = (&'n str, &'static str);

struct Node<'a> {
    parent: Option<NodeIndex>,
    name: String,
    label: &'static str,
    data: Option<Dataset<'a>>,
}

struct Dataset<'a> {
    element: Element,
    /// Sizes, the first index running fastest.
    sizes: Vec<u64>,
    values: Payload<'a>,
}

/// The smallest of both types of integers that holds a number.
pub(super) fn integers_for(largest: usize) -> Element {
    match i32::try_from(largest) {
        Ok(_) => Element::I32,
        Err(_) => Element::I64,
    }
}

impl<'a> Draft<'a> {
    fn add(
        &mut self,
        parent: Option<NodeIndex>,
        (name, label): Name,
        data: Option<Dataset<'a>>,
    ) -> NodeIndex {
        let name = name.to_owned();
        self.nodes.push(Node {
            parent,
            name,
            label,
            data,
        });
        self.nodes.len() - 1
    }

    /// Adds a node without data.
    pub fn group(&mut self, parent: impl Into<Option<NodeIndex>>, name: Name) -> NodeIndex {
        self.add(parent.into(), name, None)
    }

    /// Adds a node that holds text.
    pub fn text(&mut self, parent: NodeIndex, name: Name, text: &str) -> NodeIndex {
        let data = Data::owned(text.as_bytes());
        self.data(parent, name, (Element::I8, &[text.len() as u64]), data)
    }

    /// Adds a node that holds a few integers.
    pub fn integers(
        &mut self,
        parent: impl Into<Option<NodeIndex>>,
        name: Name,
        (element, sizes): (Element, &[u64]),
        numbers: &[i64],
    ) -> NodeIndex {
        let data = Data::integers(numbers, element == Element::I64);
        self.data(parent, name, (element, sizes), data)
    }

    /// Adds a node that holds these values. The first index of `sizes` runs fastest.
    pub fn data(
        &mut self,
        parent: impl Into<Option<NodeIndex>>,
        name: Name,
        (element, sizes): (Element, &[u64]),
        values: impl Into<Payload<'a>>,
    ) -> NodeIndex {
        let (sizes, values) = (sizes.to_vec(), values.into());
        let data = Dataset {
            element,
            sizes,
            values,
        };
        self.add(parent.into(), name, Some(data))
    }

    /// Adds a node with one row of data for each step: numbers, or names.
    pub fn rows(&mut self, parent: NodeIndex, name: &str, element: Element, rows: &'a Rows) {
        let rows = Payload::Rows(rows);
        self.data(parent, (name, "DataArray_t"), (element, &[]), rows);
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
        // The tree of each node that is in one, and its place there.
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
                    Some((top, node.add_to(tree, parent)))
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
        if let Some(data) = &node.data {
            let tree = Tree::of_dataset(data.element, &data.shape(), data.payload());
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

    /// The root of a growing file, which has all but the children of `open` already.
    pub fn open_root(&self, file: &mut StepFile, open: NodeIndex) -> Result<Links> {
        let mut links = Links::default();
        for (name, text) in marks() {
            let shape = [text.len() as u64];
            let tree = Tree::of_dataset(Element::I8, &shape, Data::owned(&text));
            links.add(name, file.store_object(&tree)?)?;
        }
        self.store(file, None, Some(open), &mut links)?;
        Ok(links)
    }

    /// The whole file as groups and datasets of HDF5.
    pub fn tree(&self) -> Tree<'_> {
        let mut tree = new_tree();
        for (name, text) in marks() {
            let shape = [text.len() as u64];
            tree.dataset(Tree::ROOT, name, Element::I8, &shape, Data::owned(&text));
        }
        self.add_to(&mut tree, Tree::ROOT);
        tree
    }

    /// Adds all nodes to a group.
    pub fn add_to<'t>(&'t self, tree: &mut Tree<'t>, group: Id) {
        let mut ids: Vec<Id> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.map_or(group, |parent| ids[parent]);
            ids.push(node.add_to(tree, parent));
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
        describe(tree, id, [&self.name, self.label, self.kind]);
        tree.number_attribute(id, "flags", &[1_i32], false);
        tree.links(id, &self.links);
        id
    }
}

/// The file as it is at a step: `links` are in it already.
pub(super) fn root_of(links: &Links) -> Tree<'_> {
    let mut tree = new_tree();
    tree.links(Tree::ROOT, links);
    tree
}

impl<'a> Node<'a> {
    fn kind(&self) -> &'static str {
        match self.data.as_ref().map(|data| data.element) {
            None => "MT",
            Some(Element::I8) => "C1",
            Some(Element::I32) => "I4",
            Some(Element::I64) => "I8",
            Some(Element::F32) => "R4",
            Some(_) => "R8",
        }
    }

    fn add_to<'t>(&'t self, tree: &mut Tree<'t>, parent: Id) -> Id {
        let id = tree.group(parent, &self.name);
        self.describe(tree, id);
        id
    }

    /// Makes a group this node.
    fn describe<'t>(&'t self, tree: &mut Tree<'t>, id: Id) {
        describe(tree, id, [&self.name, self.label, self.kind()]);
        tree.number_attribute(id, "flags", &[1_i32], false);
        if let Some(data) = &self.data {
            match data.values {
                Payload::Rows(rows) => tree.rows(id, DATA, rows),
                _ => tree.dataset(id, DATA, data.element, &data.shape(), data.payload()),
            };
        }
    }
}

impl Dataset<'_> {
    /// Sizes in the order of HDF5, the last index running fastest.
    fn shape(&self) -> Vec<u64> {
        self.sizes.iter().rev().copied().collect()
    }

    fn payload(&self) -> Payload<'_> {
        match &self.values {
            Payload::New(data) => data.borrowed().into(),
            Payload::Stored(stored) => (*stored).into(),
            Payload::Rows(rows) => Payload::Rows(rows),
            Payload::Chunks { rows, chunks } => Payload::Chunks {
                rows: *rows,
                chunks,
            },
        }
    }
}

fn new_tree<'t>() -> Tree<'t> {
    let mut tree = Tree::new();
    let root = ["HDF5 MotherNode", "Root Node of HDF5 File", "MT"];
    describe(&mut tree, Tree::ROOT, root);
    tree
}

/// Text by which the CGNS library knows its files.
fn marks() -> [(&'static str, Vec<u8>); 2] {
    let order = if cfg!(target_endian = "big") {
        "IEEE_BIG_32\0"
    } else {
        "IEEE_LITTLE_32\0"
    };
    let mut version = b"HDF5 Version 1.8.0".to_vec();
    version.resize(33, 0);
    [(" format", order.into()), (" hdf5version", version)]
}

fn describe(tree: &mut Tree, id: Id, texts: [&str; 3]) {
    for ((name, text), bytes) in ["name", "label", "type"].iter().zip(texts).zip([33, 33, 3]) {
        let terminated = true;
        tree.padded_attribute(id, name, text, Element::Text { bytes, terminated });
    }
}
