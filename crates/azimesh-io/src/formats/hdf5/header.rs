//! The metadata of a file as bytes: superblock, object headers, heap of strings.
//!
//! Format: HDF5 File Format Specification version 3.0; superblock version 2, object headers
//! version 2, layout messages version 3 (contiguous) and 4 (chunked). Read by
//! libhdf5 from 1.8, files with chunks from 1.10.

use super::index;
use super::messages::{Links, Messages, with_checksum};
use super::tree::{Attribute, Id, NOWHERE, Node, Storage};
use crate::formats::vtk::number::Element;
use azimesh_core::error::{Error, Result};

/// Bytes of the superblock.
pub(super) const SUPERBLOCK: usize = 48;
/// The superblock of a file of `end` bytes whose root group has its header at `root`.
pub(super) fn superblock(root: u64, end: u64) -> Vec<u8> {
    let mut block = b"\x89HDF\r\n\x1a\n".to_vec();
    block.extend([2, 8, 8, 0]);
    for address in [0, NOWHERE, end, root] {
        block.extend(address.to_le_bytes());
    }
    with_checksum(block)
}

/// The object header of a group or a dataset. `addresses` has the header of every node.
pub(super) fn object(node: &Node, place: &Storage, addresses: &[u64]) -> Result<Vec<u8>> {
    let mut messages = Messages::default();
    let n_before = node.links.map_or(0, Links::len);
    match &node.dataset {
        Some(dataset) => {
            messages.push(1, 0, &dataspace(Some(&dataset.shape)))?;
            messages.push(3, 1, &datatype(dataset.element))?;
            messages.push(5, 1, &[3, 0x0a])?;
            let element = size(dataset.element);
            let layout = layout(place, &dataset.shape, element, dataset.n_bytes());
            messages.push(8, 0, &layout)?;
        }
        None => {
            let mut info = vec![0, 3];
            info.extend(((n_before + node.children.len()) as u64).to_le_bytes());
            for _ in 0..3 {
                info.extend(NOWHERE.to_le_bytes());
            }
            messages.push(2, 0, &info)?;
            messages.push(10, 1, &[0, 0])?;
        }
    }
    if let Some(links) = node.links {
        links.add_to(&mut messages)?;
    }
    for (order, (name, Id(child))) in (n_before..).zip(&node.children) {
        messages.push_link(order, name, addresses[*child])?;
    }
    for attribute in &node.attributes {
        let message = attribute_message(attribute);
        let pushed = messages.push(12, 0, &message);
        pushed.map_err(|error| error.dataset(&attribute.name))?;
    }
    let mut header = b"OHDR\x02\x02".to_vec();
    let size = u32::try_from(messages.0.len());
    let size = size.map_err(|_| Error::input("a group has more than 4 GB of names"))?;
    header.extend(size.to_le_bytes());
    header.extend(messages.0);
    Ok(with_checksum(header))
}

fn dataspace(shape: Option<&[u64]>) -> Vec<u8> {
    let Some(shape) = shape else {
        return vec![2, 0, 0, 0];
    };
    let mut message = vec![2, shape.len() as u8, 0, 1];
    message.extend(shape.iter().flat_map(|n| n.to_le_bytes()));
    message
}

fn layout(place: &Storage, shape: &[u64], element: u64, n_bytes: u64) -> Vec<u8> {
    match *place {
        Storage::Contiguous(address) => {
            let mut message = vec![3, 1];
            message.extend(address.to_le_bytes());
            message.extend(n_bytes.to_le_bytes());
            message
        }
        Storage::Chunked { rows, index } => {
            let others = shape.iter().copied().skip(1);
            let sizes = || std::iter::once(rows).chain(others.clone()).chain([element]);
            // libhdf5 refuses more bytes for each than the largest needs.
            let largest = sizes().max().unwrap_or(1).max(1);
            let width = (u64::BITS - largest.leading_zeros()).div_ceil(8) as usize;
            let mut message = vec![4, 2, 0, shape.len() as u8 + 1, width as u8];
            for n in sizes() {
                message.extend(&n.to_le_bytes()[..width]);
            }
            message.extend(index::layout_of(index));
            message
        }
    }
}

fn attribute_message(attribute: &Attribute) -> Vec<u8> {
    let space = dataspace(attribute.shape.as_deref());
    let mut message = vec![3, 0];
    for size in [
        attribute.name.len() + 1,
        attribute.datatype.len(),
        space.len(),
    ] {
        message.extend((size as u16).to_le_bytes());
    }
    message.push(1);
    message.extend(attribute.name.as_bytes());
    message.push(0);
    message.extend(&attribute.datatype);
    message.extend(space);
    message.extend(&attribute.bytes);
    message
}

/// Strings as a heap that will be at `at`, and the references to them.
pub(super) fn heap(at: u64, strings: &[String]) -> (Vec<u8>, Vec<u8>) {
    const MOST_OBJECTS: usize = 60_000;
    const SMALLEST: usize = 4096;
    let mut heap: Vec<u8> = Vec::new();
    let mut references = Vec::with_capacity(strings.len() * 16);
    for some in strings.chunks(MOST_OBJECTS) {
        let start = heap.len();
        heap.extend(b"GCOL\x01\0\0\0\0\0\0\0\0\0\0\0");
        for (index, string) in (1u16..).zip(some) {
            references.extend((string.len() as u32).to_le_bytes());
            references.extend((at + start as u64).to_le_bytes());
            references.extend(u32::from(index).to_le_bytes());
            heap.extend(index.to_le_bytes());
            heap.extend([1, 0, 0, 0, 0, 0]);
            heap.extend((string.len() as u64).to_le_bytes());
            heap.extend(string.as_bytes());
            heap.resize(heap.len().next_multiple_of(8), 0);
        }
        let free = (start + SMALLEST).saturating_sub(heap.len()).max(16);
        let free_at = heap.len();
        heap.resize(free_at + free, 0);
        heap[free_at + 8..free_at + 16].copy_from_slice(&(free as u64).to_le_bytes());
        let size = (heap.len() - start) as u64;
        heap[start + 8..start + 16].copy_from_slice(&size.to_le_bytes());
    }
    (heap, references)
}

/// Bytes of one value in a dataset; for a string, of its reference into a heap.
pub(in crate::formats) fn size(element: Element) -> u64 {
    match element {
        Element::String => 16,
        number => number.size() as u64,
    }
}

/// The datatype message of numbers in the byte order of this machine, or of strings.
pub(super) fn datatype(element: Element) -> Vec<u8> {
    use Element::{Float32, Float64, Int8, Int16, Int32, Int64};
    let order = u8::from(cfg!(target_endian = "big"));
    let size = size(element) as u32;
    let mut message = Vec::with_capacity(20);
    match element {
        // Called ASCII, as VTK wants it, whatever the bytes.
        Element::String => {
            message.extend([0x19, 1, 0, 0]);
            message.extend(size.to_le_bytes());
            message.extend(datatype(Element::UInt8));
        }
        Float32 | Float64 => {
            let (sign, exponent_at, exponent, bias) = match element {
                Float32 => (31, 23, 8, 127_u32),
                _ => (63, 52, 11, 1023),
            };
            message.extend([0x11, 0x20 | order, sign, 0]);
            message.extend(size.to_le_bytes());
            let bits = sign + 1;
            message.extend([0, 0, bits, 0, exponent_at, exponent, 0, exponent_at]);
            message.extend(bias.to_le_bytes());
        }
        _ => {
            let is_signed = matches!(element, Int8 | Int16 | Int32 | Int64);
            message.extend([0x10, order | u8::from(is_signed) << 3, 0, 0]);
            message.extend(size.to_le_bytes());
            message.extend([0, 0]);
            message.extend((size as u16 * 8).to_le_bytes());
        }
    }
    message
}

/// The datatype message of ASCII text of so many bytes, ended by a zero (C's strings) or filled up with zeros.
pub(super) fn text_type(bytes: u32, is_terminated: bool) -> Vec<u8> {
    let mut message = vec![0x13, u8::from(!is_terminated), 0, 0];
    message.extend(bytes.to_le_bytes());
    message
}
