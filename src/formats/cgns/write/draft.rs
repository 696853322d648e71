//! The nodes of a CGNS file to be: names, labels, data. Turned into groups and datasets of HDF5 as
//! the CGNS library lays them out.

use crate::error::Result;
use crate::formats::hdf5::{Data, Element, Growing, Id, Sink, Stored, Tree};

/// Nodes in the order in which they are added; children after parents.
#[derive(Default)]
pub(super) struct Draft<'a> {
    nodes: Vec<Node<'a>>,
    /// Place of the first: how many nodes of another draft come before.
    first: Place,
}

/// Position of a node in a [`Draft`].
pub(super) type Place = usize;

struct Node<'a> {
    parent: Option<Place>,
    name: String,
    label: &'static str,
    data: Option<(Kind, Vec<u64>, Payload<'a>)>,
}

/// Type of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
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

/// Makes bytes as they are written.
pub(super) type Make<'a> = Box<dyn Fn(Sink) -> Result<()> + Send + Sync + 'a>;

enum Payload<'a> {
    Bytes(Vec<u8>),
    Stream(Make<'a>),
    Stored(Stored),
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::C1 => "C1",
            Kind::I4 => "I4",
            Kind::I8 => "I8",
            Kind::R4 => "R4",
            Kind::R8 => "R8",
        }
    }

    fn element(self) -> Element {
        match self {
            Kind::C1 => Element::I8,
            Kind::I4 => Element::I32,
            Kind::I8 => Element::I64,
            Kind::R4 => Element::F32,
            Kind::R8 => Element::F64,
        }
    }

    /// Integers as bytes of this type, which is I4 or I8 and holds them.
    pub fn bytes_of(self, numbers: &[i64]) -> Vec<u8> {
        match self {
            Kind::I8 => bytemuck::cast_slice(numbers).to_vec(),
            _ => {
                let narrow: Vec<i32> = numbers.iter().map(|&n| n as i32).collect();
                bytemuck::cast_slice(&narrow).to_vec()
            }
        }
    }
}

impl<'a> Draft<'a> {
    /// A draft whose nodes follow those of another, and may be children of them.
    pub fn after(other: &Draft) -> Self {
        Self {
            nodes: Vec::new(),
            first: other.first + other.nodes.len(),
        }
    }

    fn add(
        &mut self,
        parent: Option<Place>,
        name: &str,
        label: &'static str,
        data: Option<(Kind, Vec<u64>, Payload<'a>)>,
    ) -> Place {
        self.nodes.push(Node {
            parent,
            name: name.to_owned(),
            label,
            data,
        });
        self.first + self.nodes.len() - 1
    }

    /// Adds a node without data.
    pub fn group(&mut self, parent: Place, name: &str, label: &'static str) -> Place {
        self.add(Some(parent), name, label, None)
    }

    /// Adds a node that holds text.
    pub fn text(&mut self, parent: Place, name: &str, label: &'static str, text: &str) -> Place {
        let bytes = Payload::Bytes(text.as_bytes().to_vec());
        let data = (Kind::C1, vec![text.len() as u64], bytes);
        self.add(Some(parent), name, label, Some(data))
    }

    /// Adds a node that holds names of 32 characters.
    pub fn names(&mut self, parent: Place, name: &str, names: &[String]) -> Place {
        let bytes = names.iter().flat_map(|name| {
            let mut field = name.as_bytes().to_vec();
            field.resize(super::names::LONGEST, b' ');
            field
        });
        let bytes = Payload::Bytes(bytes.collect());
        let data = (Kind::C1, vec![32, names.len() as u64], bytes);
        self.add(Some(parent), name, "DataArray_t", Some(data))
    }

    /// Adds a node that holds a few integers. The first index of `sizes` runs fastest.
    pub fn integers(
        &mut self,
        parent: impl Into<Option<Place>>,
        (name, label): (&str, &'static str),
        kind: Kind,
        sizes: &[u64],
        numbers: &[i64],
    ) -> Place {
        let data = (kind, sizes.to_vec(), Payload::Bytes(kind.bytes_of(numbers)));
        self.add(parent.into(), name, label, Some(data))
    }

    /// Adds a node that holds a few floating-point numbers.
    pub fn reals(
        &mut self,
        parent: Place,
        (name, label): (&str, &'static str),
        numbers: &[f64],
    ) -> Place {
        let bytes = Payload::Bytes(bytemuck::cast_slice(numbers).to_vec());
        let data = (Kind::R8, vec![numbers.len() as u64], bytes);
        self.add(Some(parent), name, label, Some(data))
    }

    /// Adds a node that holds these bytes.
    pub fn bytes(
        &mut self,
        parent: Place,
        (name, label): (&str, &'static str),
        kind: Kind,
        sizes: &[u64],
        bytes: Vec<u8>,
    ) -> Place {
        let data = (kind, sizes.to_vec(), Payload::Bytes(bytes));
        self.add(Some(parent), name, label, Some(data))
    }

    /// Adds the version of CGNS that the file follows.
    pub fn version(&mut self, version: f32) {
        let bytes = Payload::Bytes(version.to_ne_bytes().to_vec());
        let data = (Kind::R4, vec![1], bytes);
        let label = "CGNSLibraryVersion_t";
        self.add(None, "CGNSLibraryVersion", label, Some(data));
    }

    /// Adds a node whose `n` values are made as they are written.
    pub fn stream(
        &mut self,
        parent: Place,
        (name, label): (&str, &'static str),
        kind: Kind,
        n: usize,
        make: Make<'a>,
    ) -> Place {
        let data = (kind, vec![n as u64], Payload::Stream(make));
        self.add(Some(parent), name, label, Some(data))
    }

    /// Adds a node whose `n` values are in the file already.
    pub fn stored(
        &mut self,
        parent: Place,
        name: &str,
        kind: Kind,
        n: usize,
        stored: Stored,
    ) -> Place {
        let data = (kind, vec![n as u64], Payload::Stored(stored));
        self.add(Some(parent), name, "DataArray_t", Some(data))
    }

    /// Puts all that is streamed into a growing file: the draft no longer needs the mesh.
    pub fn store(self, file: &mut Growing) -> Result<Draft<'static>> {
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for node in self.nodes {
            let data = match node.data {
                Some((kind, sizes, payload)) => {
                    let payload = match payload {
                        Payload::Stream(make) => Payload::Stored(file.store(|sink| make(sink))?),
                        Payload::Bytes(bytes) => Payload::Stored(file.store(|sink| sink(&bytes))?),
                        Payload::Stored(stored) => Payload::Stored(stored),
                    };
                    Some((kind, sizes, payload))
                }
                None => None,
            };
            nodes.push(Node {
                parent: node.parent,
                name: node.name,
                label: node.label,
                data,
            });
        }
        Ok(Draft {
            nodes,
            first: self.first,
        })
    }

    /// The groups and datasets of HDF5, of these nodes and of those of a draft after this one.
    pub fn tree<'t>(&'t self, more: Option<&'t Draft<'a>>) -> Tree<'t> {
        let mut tree = Tree::new();
        describe(
            &mut tree,
            Tree::ROOT,
            ("HDF5 MotherNode", "Root Node of HDF5 File", "MT"),
        );
        let order = if cfg!(target_endian = "big") {
            "IEEE_BIG_32"
        } else {
            "IEEE_LITTLE_32"
        };
        characters(&mut tree, " format", order, order.len() + 1);
        characters(&mut tree, " hdf5version", "HDF5 Version 1.8.0", 33);
        let mut ids: Vec<Id> = Vec::new();
        for node in self
            .nodes
            .iter()
            .chain(more.iter().flat_map(|more| &more.nodes))
        {
            let parent = node.parent.map_or(Tree::ROOT, |parent| ids[parent]);
            let id = tree.group(parent, &node.name);
            ids.push(id);
            let kind = node.data.as_ref().map_or("MT", |(kind, ..)| kind.name());
            describe(&mut tree, id, (&node.name, node.label, kind));
            flags(&mut tree, id);
            if let Some((kind, sizes, payload)) = &node.data {
                let shape: Vec<u64> = sizes.iter().rev().copied().collect();
                let data = match payload {
                    Payload::Bytes(bytes) => Data::Bytes(bytes.into()),
                    Payload::Stream(make) => Data::Stream(Box::new(|sink| make(sink))),
                    Payload::Stored(stored) => Data::Stored(*stored),
                };
                tree.dataset(id, " data", kind.element(), &shape, data);
            }
        }
        tree
    }
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

fn characters(tree: &mut Tree, name: &str, text: &str, n: usize) {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(n, 0);
    tree.dataset(
        Tree::ROOT,
        name,
        Element::I8,
        &[n as u64],
        Data::Bytes(bytes.into()),
    );
}
