//! Arrays of the steps of a sequence: a node for each step whose arrays are other than those of the
//! step before, and the list that says which node each step has.

use super::super::super::hdf5::{Element, Links, Rows, StepFile, Stored};
use super::super::FULL_NAME;
use super::arrays::Scalar;
use super::draft::{DataType, Draft};
use super::fields::Field;
use super::names::LONGEST;
use crate::formats::column::Data;
use azimesh_core::error::{Error, Result};

/// The entry of a list for a step without such a node.
const NONE: &str = "Null";

/// An array in the file.
#[derive(Clone, PartialEq)]
struct Array {
    name: String,
    full_name: Option<String>,
    kind: DataType,
    sizes: Vec<u64>,
    stored: Stored,
    hash: blake3::Hash,
}

/// An array that may be in the file already.
pub(super) struct Given<'a> {
    name: String,
    full_name: Option<String>,
    kind: DataType,
    sizes: Vec<u64>,
    data: Data<'a>,
}

/// Nodes with arrays, of which a step has a new one unless its arrays are those of the step before.
pub(super) struct Series {
    name: &'static str,
    label: &'static str,
    /// Where the values are, of solutions.
    location: Option<&'static str>,
    /// Name and arrays of the newest.
    newest: Option<(String, Vec<Array>)>,
    /// The name of each step's node.
    pub pointers: Rows,
}

impl Series {
    pub fn new(name: &'static str, label: &'static str, location: Option<&'static str>) -> Self {
        Self {
            name,
            label,
            location,
            newest: None,
            pointers: names(),
        }
    }

    /// Whether a step had arrays.
    pub fn is_used(&self) -> bool {
        self.newest.is_some()
    }

    /// Refuses other arrays than the first step has.
    pub fn check_names(&self, step: usize, scalars: &[Scalar]) -> Result<()> {
        let newest = self.newest.iter().flat_map(|(_, arrays)| arrays);
        let before: Vec<&str> = newest.map(|array| &*array.name).collect();
        let given: Vec<&str> = scalars.iter().map(|scalar| &*scalar.name).collect();
        match step > 0 && before != given {
            true => Err(Error::input(format!(
                "step {step} has the arrays {}, the first step {}; all steps in one CGNS file must have the same arrays",
                given.join(", "),
                before.join(", ")
            ))),
            false => Ok(()),
        }
    }

    /// Takes over the arrays of a step; those that are as in the step before are not written again.
    pub fn append(
        &mut self,
        step: usize,
        given: Vec<Given>,
        file: &mut StepFile,
        links: &mut Links,
    ) -> Result<()> {
        let before = self.newest.as_ref().map_or(&[][..], |(_, arrays)| arrays);
        let arrays: Result<Vec<Array>> = given
            .into_iter()
            .map(|given| given.stored(before, file))
            .collect();
        let arrays = arrays?;
        if before != arrays {
            let name = match arrays.is_empty() {
                true => NONE.to_owned(),
                false => step_name(self.name, step),
            };
            if !arrays.is_empty() {
                self.draft(&name, &arrays).store(file, None, None, links)?;
            }
            self.newest = Some((name, arrays));
        }
        let name = self.newest.as_ref().map_or(NONE, |(name, _)| name);
        self.pointers.push(&padded(name));
        Ok(())
    }

    fn draft(&self, name: &str, arrays: &[Array]) -> Draft<'static> {
        let mut draft = Draft::default();
        let node = draft.group(None, name, self.label);
        if let Some(location) = self.location {
            draft.text(node, "GridLocation", "GridLocation_t", location);
        }
        for array in arrays {
            let data = (array.kind, &array.sizes[..]);
            let node = draft.stored(node, &array.name, data, array.stored);
            if let Some(full_name) = &array.full_name {
                draft.text(node, FULL_NAME, "Descriptor_t", full_name);
            }
        }
        draft
    }
}

impl<'a> From<&'a Field> for Given<'a> {
    fn from(field: &'a Field) -> Self {
        Self {
            name: field.name.clone(),
            full_name: field.full_name.clone(),
            kind: field.kind,
            sizes: field.sizes.clone(),
            data: field.data.borrowed(),
        }
    }
}

impl<'a> From<&Scalar<'a>> for Given<'a> {
    fn from(scalar: &Scalar<'a>) -> Self {
        Self {
            name: scalar.name.clone(),
            full_name: scalar.full_name.clone(),
            kind: scalar.kind,
            sizes: vec![scalar.n as u64],
            data: scalar.data(),
        }
    }
}

impl Given<'_> {
    /// The array in the file: that of the step before where it is the same.
    fn stored(self, before: &[Array], file: &mut StepFile) -> Result<Array> {
        let hash = self.data.hash()?;
        let is_same = |array: &&Array| {
            array.name == self.name
                && (array.kind, &array.sizes) == (self.kind, &self.sizes)
                && array.hash == hash
        };
        let stored = match before.iter().find(is_same) {
            Some(array) => array.stored,
            None => file.store(&self.data)?,
        };
        Ok(Array {
            name: self.name,
            full_name: self.full_name,
            kind: self.kind,
            sizes: self.sizes,
            stored,
            hash,
        })
    }
}

/// A list of names, one for each step.
pub(super) fn names() -> Rows {
    Rows::new(Element::I8, &[LONGEST as u64])
}

/// A name as it is in a list.
pub(super) fn padded(name: &str) -> [u8; LONGEST] {
    let mut field = [b' '; LONGEST];
    for (to, from) in field.iter_mut().zip(name.bytes()) {
        *to = from;
    }
    field
}

/// The first step has the name that programs look for which know of no steps.
pub(super) fn step_name(name: &str, step: usize) -> String {
    match step {
        0 => name.to_owned(),
        _ => format!("{name}#{step:04}"),
    }
}
