//! Nodes of the same or of another file that a node stands for.

use super::super::Source;
use super::super::names::decoded;
use super::super::source::check_file;
use super::file::File;
use super::is_adf;
use super::node::{Node, trimmed};
use azimesh_core::error::{Error, Result};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;

/// Most links that are followed to find one node.
pub const MOST: usize = 100;

/// Other files that links have led to.
pub type Files = RefCell<BTreeMap<PathBuf, Rc<File>>>;

/// The target of a link.
pub struct Link {
    /// Name of the file; empty where it is the same.
    file: Vec<u8>,
    /// Names of nodes from the root on, with slashes between them.
    path: Vec<u8>,
}

impl Link {
    /// Splits its text: `file>path`. Before version A02 a blank stood for the `>`; later libraries add links in
    /// the new way to such files.
    pub fn parse(text: &[u8], is_old: bool) -> Self {
        let text = trimmed(text);
        let at = |byte: u8| text.iter().position(|found| *found == byte);
        let separator = at(b'>').or_else(|| at(b' ').filter(|_| is_old));
        let (file, path) = match separator {
            Some(at) => (&text[..at], &text[at + 1..]),
            None => (&b""[..], text),
        };
        Self {
            file: file.to_vec(),
            path: path.to_vec(),
        }
    }

    fn refuse(&self, why: &str) -> Error {
        let (file, path) = (decoded(&self.file), decoded(&self.path));
        let of_file = if file.is_empty() {
            String::new()
        } else {
            format!(" in the file \"{file}\"")
        };
        Error::input(format!("this links to \"{path}\"{of_file}{why}"))
    }
}

/// The node that this one stands for, however many links are on the way; `left` can be followed.
pub fn target(node: Node, left: &mut usize) -> Result<Node> {
    let mut node = node;
    while let Some(link) = node.link()? {
        *left = left
            .checked_sub(1)
            .ok_or_else(|| Error::input("its links form a loop"))?;
        node = find(&node, &link, left)?;
    }
    Ok(node)
}

fn find(from: &Node, link: &Link, left: &mut usize) -> Result<Node> {
    let file = if link.file.is_empty() {
        from.file.clone()
    } else {
        other_file(from, link)?
    };
    let mut node = Node::root_of(file, from.files.clone())?;
    let names = link.path.split(|byte| *byte == b'/');
    for name in names.filter(|name| !name.is_empty()) {
        let child = target(node, left)?.child(name)?;
        let missing = if link.file.is_empty() {
            ", which is not in the file"
        } else {
            "; that file has no such node"
        };
        node = child.ok_or_else(|| link.refuse(missing))?;
    }
    Ok(node)
}

/// Opens the file that a link names, in the folder of the file that has the link.
fn other_file(from: &Node, link: &Link) -> Result<Rc<File>> {
    let folder = from.file.source.path().parent();
    let path = folder.map(PathBuf::from).unwrap_or_default();
    let path = path.join(&*decoded(&link.file));
    if let Some(file) = from.files.borrow().get(&path) {
        return Ok(file.clone());
    }
    if check_file(&path).is_err() {
        return Err(link.refuse("; that file is not in the folder of this one"));
    }
    let source = Source::stored(&path)?;
    if !is_adf(source.bytes()) {
        return Err(link.refuse(
            "; that is no ADF file. Files that are linked must all be of one kind: adf2hdf and hdf2adf, tools of CGNS, convert them",
        ));
    }
    let file = Rc::new(File::open(&source)?);
    from.files.borrow_mut().insert(path, file.clone());
    Ok(file)
}
