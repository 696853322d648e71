//! Arrays of the steps of a sequence: a node for each step whose arrays are other than those of the
//! step before, and the list that says which node each step has.

use super::LONGEST;
use super::arrays::{Array, add_full_name};
use super::draft::Draft;
use crate::formats::hdf5::{Element, Links, Rows, StepFile, Stored};
use azimesh_core::error::{Error, Result};

/// The entry of a list for a step without such a node.
const NONE: &str = "Null";

/// An array in the file.
#[derive(Clone, PartialEq)]
struct Written {
    name: String,
    full_name: Option<String>,
    element: Element,
    sizes: Vec<u64>,
    hash: blake3::Hash,
    stored: Stored,
}

/// Nodes with arrays, of which a step has a new one unless its arrays are those of the step before.
pub(super) struct Series {
    name: &'static str,
    label: &'static str,
    /// Where the values are, of solutions.
    location: Option<&'static str>,
    /// Name and arrays of the newest.
    newest: Option<(String, Vec<Written>)>,
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

    fn newest(&self) -> &[Written] {
        self.newest.as_ref().map_or(&[], |(_, arrays)| arrays)
    }

    /// Refuses other arrays than the first step has.
    pub fn check_names(&self, step: usize, arrays: &[Array]) -> Result<()> {
        let before: Vec<&str> = self.newest().iter().map(|array| &*array.name).collect();
        let now: Vec<&str> = arrays.iter().map(|array| &*array.name).collect();
        if step == 0 || before == now {
            return Ok(());
        }
        Err(Error::input(format!(
            "step {step} has the arrays {}, the first step {}; all steps in one CGNS file must have the same arrays",
            now.join(", "),
            before.join(", ")
        )))
    }

    /// Takes over the arrays of a step; those that are as in the step before are not written again.
    pub fn append(
        &mut self,
        step: usize,
        arrays: Vec<Array>,
        file: &mut StepFile,
        links: &mut Links,
    ) -> Result<()> {
        let store = |array| stored(array, self.newest(), file);
        let arrays: Vec<Written> = arrays.into_iter().map(store).collect::<Result<_>>()?;
        if self.newest() != arrays {
            let mut name = NONE.to_owned();
            if !arrays.is_empty() {
                name = step_name(self.name, step);
                self.draft(&name, &arrays).store(file, None, None, links)?;
            }
            self.newest = Some((name, arrays));
        }
        let name = self.newest.as_ref().map_or(NONE, |(name, _)| name);
        self.pointers.push(&padded(name));
        Ok(())
    }

    fn draft(&self, name: &str, arrays: &[Written]) -> Draft<'static> {
        let mut draft = Draft::default();
        let node = draft.group(None, (name, self.label));
        if let Some(location) = self.location {
            draft.text(node, ("GridLocation", "GridLocation_t"), location);
        }
        for array in arrays {
            let name = (array.name.as_str(), "DataArray_t");
            let array_node = draft.data(node, name, (array.element, &array.sizes), array.stored);
            add_full_name(&mut draft, array_node, array.full_name.as_deref());
        }
        draft
    }
}

/// Writes the array, or refers to the array of the previous step if the values are the same.
fn stored(array: Array, before: &[Written], file: &mut StepFile) -> Result<Written> {
    let hash = array.data.hash()?;
    let is_same = |other: &&Written| {
        let kind = (other.element, &other.sizes);
        other.name == array.name && kind == (array.element, &array.sizes) && other.hash == hash
    };
    let stored = match before.iter().find(is_same) {
        Some(other) => other.stored,
        None => file.store(&array.data)?,
    };
    Ok(Written {
        name: array.name,
        full_name: array.full_name,
        element: array.element,
        sizes: array.sizes,
        hash,
        stored,
    })
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
