//! A tree written front to back: superblock, headers, then the values of every dataset.

use super::header::{self, SUPERBLOCK};
use super::tree::{Dataset, NOWHERE, Payload, Storage, Tree};
use crate::formats::Out;
use crate::formats::column::{Data, Sink};
use azimesh_core::error::{Error, Result};

/// Values start at multiples of this.
pub(super) const ALIGNMENT: u64 = 64;

impl Tree<'_> {
    /// Writes the whole file. Values in memory are not copied.
    ///
    /// # Panics
    /// When a dataset is one that only a growing file can hold.
    pub fn write(&self, out: &mut dyn Out) -> Result<()> {
        let start = SUPERBLOCK as u64;
        let somewhere = vec![Storage::Contiguous(0); self.nodes.len()];
        let (headers, _) = headers_from(start, self, &somewhere)?;
        let (places, end) = self.places(start + headers.len() as u64)?;
        let (headers, root) = headers_from(start, self, &places)?;
        let mut out = Counted { out, at: 0 };
        out.write(&header::superblock(root, end))?;
        out.write(&headers)?;
        for (node, place) in self.nodes.iter().zip(&places) {
            if let (Some(dataset), &Storage::Contiguous(address)) = (&node.dataset, place)
                && address != NOWHERE
            {
                out.pad_to(address)?;
                out.write_values(dataset)?;
            }
        }
        out.pad_to(end)
    }

    /// The positions of the values of each node if the first may start at `at`, and the end of the file.
    fn places(&self, mut at: u64) -> Result<(Vec<Storage>, u64)> {
        let too_large = || Error::input("the file would have more than 2^63 bytes");
        let mut places = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let n_bytes = node.dataset.as_ref().map_or(0, stored_bytes);
            let mut address = NOWHERE;
            if n_bytes > 0 {
                address = at.next_multiple_of(ALIGNMENT);
                at = address.checked_add(n_bytes).ok_or_else(too_large)?;
            }
            places.push(Storage::Contiguous(address));
        }
        Ok((places, at))
    }
}

/// Headers one after another from address `start` on, and the address of the root group's.
fn headers_from(start: u64, tree: &Tree, places: &[Storage]) -> Result<(Vec<u8>, u64)> {
    let mut bytes = Vec::new();
    let mut addresses = vec![NOWHERE; tree.nodes.len()];
    let nodes = places.iter().cloned().enumerate();
    let root = headers(tree, nodes, &mut addresses, |header| {
        let address = start + bytes.len() as u64;
        bytes.extend(header);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        Ok(address)
    })?;
    Ok((bytes, root))
}

/// Makes the headers of a node and of all nodes below it, the last one first; `put` gives each its address. Gives the
/// address of the first.
pub(super) fn headers(
    tree: &Tree,
    nodes: impl DoubleEndedIterator<Item = (usize, Storage)>,
    addresses: &mut [u64],
    mut put: impl FnMut(Vec<u8>) -> Result<u64>,
) -> Result<u64> {
    let mut last = NOWHERE;
    for (id, place) in nodes.rev() {
        let node = &tree.nodes[id];
        last = match node.object {
            Some(object) => object.address,
            None => put(header::object(node, &place, addresses)?)?,
        };
        addresses[id] = last;
    }
    Ok(last)
}

/// Bytes that the values take in the file, with the heap of strings.
pub(super) fn stored_bytes(dataset: &Dataset) -> u64 {
    match &dataset.data {
        Payload::New(Data::Text(strings)) => {
            let (heap, references) = header::heap(0, strings);
            (heap.len() + references.len()) as u64
        }
        _ => dataset.n_bytes(),
    }
}

/// Hands values that will be at `at` to `sink`: numbers, or references to strings and their heap.
pub(super) fn write_data(data: &Data, at: u64, sink: Sink) -> Result<()> {
    let Data::Text(strings) = data else {
        return data.for_each(sink);
    };
    let (heap, references) = header::heap(at + strings.len() as u64 * 16, strings);
    sink(&references)?;
    sink(&heap)
}

/// Counts the bytes that go by.
struct Counted<'a> {
    out: &'a mut dyn Out,
    at: u64,
}

impl Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.out.write_all(bytes).map_err(failed)?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn write_values(&mut self, dataset: &Dataset) -> Result<()> {
        let start = self.at;
        match &dataset.data {
            Payload::New(Data::Remote(numbers)) => {
                self.out.apart(numbers, 0)?;
                self.at += numbers.n_bytes;
            }
            Payload::New(data) => write_data(data, start, &mut |bytes| self.write(bytes))?,
            _ => panic!("what is stored is not written again"),
        }
        let expected = stored_bytes(dataset);
        assert_eq!(
            self.at - start,
            expected,
            "values must fit element and shape"
        );
        Ok(())
    }

    fn pad_to(&mut self, address: u64) -> Result<()> {
        let zeros = [0; ALIGNMENT as usize];
        self.write(&zeros[..(address - self.at) as usize])
    }
}

pub(super) fn failed(error: std::io::Error) -> Error {
    Error::system(error.to_string())
}
