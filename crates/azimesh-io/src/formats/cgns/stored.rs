//! A node as its file stores it: a group of HDF5, or a node of ADF. Links, also into other files, are followed here.

use super::super::hdf5::{self, Group, MissingFiles};
use super::super::names::decoded;
use super::super::{Source, adf};
use super::node::trimmed;
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Most links that lead from one to the next.
const MOST_LINKS: usize = 16;

/// A node; clones are the same node.
pub(super) enum Stored {
    Hdf5(Group),
    Adf(adf::Node),
}

impl Stored {
    /// The node above all others, and the files that links lead to in vain without an error.
    pub fn root(source: &Source) -> Result<(Self, MissingFiles)> {
        if adf::is_adf(source.bytes()) {
            let root = adf::Node::root(source)?;
            return Ok((Self::Adf(root), MissingFiles::default()));
        }
        if !hdf5::is_hdf5(source.bytes()) {
            return Err(Error::input(format!(
                "CGNS files are HDF5 or ADF files, and this is neither: it begins with {}; HDF5 begins with \"{}\", ADF with \
                 four bytes of any kind and \"{}\"",
                hdf5::first_bytes(source.bytes()),
                hdf5::SIGNATURE.escape_ascii(),
                adf::NAME.escape_ascii()
            ))
            .byte(0));
        }
        let file = hdf5::File::open(source)?;
        Ok((Self::Hdf5(file.root()?), file.missing_files()))
    }

    /// The name, in any encoding.
    pub fn name(&self) -> &[u8] {
        match self {
            Self::Hdf5(group) => group.name().as_bytes(),
            Self::Adf(node) => node.name(),
        }
    }

    /// The label; `path` is for messages.
    pub fn label(&self, path: &str) -> Result<String> {
        match self {
            Self::Hdf5(group) => Ok(text_of(group, "label", path)?.unwrap_or_default()),
            Self::Adf(node) => Ok(decoded(node.label()).into_owned()),
        }
    }

    /// The children, in the order of creation where the file has that, else by name.
    pub fn children(&self) -> Result<Vec<Self>> {
        match self {
            Self::Hdf5(group) => {
                let groups = group.groups()?.into_iter();
                let nodes = groups.filter(|group| !group.name().starts_with(' '));
                Ok(nodes.map(Self::Hdf5).collect())
            }
            Self::Adf(node) => Ok(node.children()?.into_iter().map(Self::Adf).collect()),
        }
    }

    /// The data; `None` where there is none.
    pub fn data(&self) -> Result<Option<Data>> {
        match self {
            Self::Hdf5(group) => Ok(group
                .dataset(" data")?
                .map(|data| Data::Hdf5(Box::new(data)))),
            Self::Adf(node) => Ok(node.data()?.map(Data::Adf)),
        }
    }

    /// The node that this one stands for where it is a link, else itself.
    pub fn target(self, path: &str) -> Result<Self> {
        match self {
            Self::Hdf5(group) => linked_group(group, path).map(Self::Hdf5),
            Self::Adf(node) => {
                let target = node.target().map_err(|error| error.dataset(path));
                target.map(Self::Adf)
            }
        }
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
    /// How many values there are along each index, the last index running fastest.
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
fn linked_group(group: Group, path: &str) -> Result<Group> {
    let mut target = group;
    let mut links = 0;
    while text_of(&target, "type", path)?.as_deref() == Some("LK") {
        links += 1;
        let next = match links {
            0..=MOST_LINKS => target.group(" link"),
            _ => return Err(Error::input("its links form a loop").dataset(path)),
        };
        target = match next {
            Ok(Some(next)) => next,
            Ok(None) => return Err(broken_link(&target, path)),
            Err(error) => return Err(refused_link(&target, path, &error)),
        };
    }
    Ok(target)
}

fn text_of(group: &Group, attribute: &str, path: &str) -> Result<Option<String>> {
    let text = group.text(attribute).map_err(|e| e.dataset(path))?;
    Ok(text.map(|text| trimmed(text.as_bytes())))
}

fn broken_link(group: &Group, path: &str) -> Error {
    let message = match target_of(group) {
        (to, Some(file)) => format!(
            "this links to \"{to}\" in the file \"{file}\"; that file is not in the folder of this one, or has no such node"
        ),
        (to, None) => format!("this links to \"{to}\", which is not in the file"),
    };
    Error::input(message).dataset(path)
}

/// A link that could not be followed, for a reason that the library gives.
fn refused_link(group: &Group, path: &str, why: &Error) -> Error {
    let message = match target_of(group) {
        (to, Some(file)) => format!(
            "this links to \"{to}\" in the file \"{file}\", and the link could not be followed: {}",
            why.message
        ),
        (to, None) => format!(
            "this links to \"{to}\", and the link could not be followed: {}",
            why.message
        ),
    };
    Error::input(message).dataset(path)
}

/// Where a link leads: a path and, unless it is in the same file, a file.
fn target_of(group: &Group) -> (String, Option<String>) {
    let word = |name: &str| {
        let dataset = group.dataset(name).ok()??;
        match dataset.values().ok()? {
            Values::I8(bytes) => Some(bytes.into_iter().map(|b| b as u8).collect::<Vec<u8>>()),
            Values::U8(bytes) => Some(bytes),
            Values::Text(lines) => Some(lines.concat().into_bytes()),
            _ => None,
        }
        .map(|bytes| trimmed(&bytes))
    };
    let file = word(" file").filter(|file| !file.is_empty());
    (word(" path").unwrap_or_default(), file)
}
