//! Arrays of the steps of a sequence: a new CGNS node for each step whose arrays changed, and the list
//! of the node of each step.

use super::LONGEST;
use super::arrays::{self, Array, Kind};
use super::draft::Draft;
use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Links, Rows, StepFile, Stored, Tree};
use azimesh_core::error::{Error, Result};

/// The entry of a list for a step without such a node.
const NONE: &str = "Null";

/// An array in the file, with the hash of its values.
type Written = Array<(blake3::Hash, Stored)>;

/// Nodes with arrays. A step shares the node of the step before if its arrays are the same.
pub(super) struct Series {
    kind: Kind,
    /// Name and arrays of the newest.
    newest: Option<(String, Vec<Written>)>,
    /// The name of each step's node.
    pub pointers: Rows,
}

impl Series {
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            newest: None,
            pointers: names(),
        }
    }

    /// Tests if a step had arrays.
    pub fn is_used(&self) -> bool {
        self.newest.is_some()
    }

    fn newest(&self) -> &[Written] {
        self.newest.as_ref().map_or(&[], |(_, arrays)| arrays)
    }

    /// Refuses other arrays than the first step has.
    pub fn check_names(&self, step: usize, arrays: &[Array<Data>]) -> Result<()> {
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
        arrays: Vec<Array<Data>>,
        file: &mut StepFile,
        links: &mut Links,
    ) -> Result<()> {
        let store = |array| stored(array, self.newest(), file);
        let arrays: Vec<Written> = arrays.into_iter().map(store).collect::<Result<_>>()?;
        if self.newest() != arrays {
            let mut name = NONE.to_owned();
            if !arrays.is_empty() {
                name = step_name(self.kind.name, step);
                let mut draft = Draft::part();
                let of_step = arrays.iter().map(|array| array.clone().with(array.data.1));
                arrays::add(&mut draft, Tree::ROOT, (&name, &self.kind), of_step);
                file.store_children(&draft.tree, Tree::ROOT, None, links)?;
            }
            self.newest = Some((name, arrays));
        }
        let name = self.newest.as_ref().map_or(NONE, |(name, _)| name);
        self.pointers.push(&padded(name));
        Ok(())
    }
}

/// Writes the array, or refers to the array of the previous step if the values are the same.
fn stored(array: Array<Data>, before: &[Written], file: &mut StepFile) -> Result<Written> {
    let hash = array.data.hash()?;
    let is_same = |other: &&Written| {
        let kind = (other.element, &other.sizes);
        other.name == array.name && kind == (array.element, &array.sizes) && other.data.0 == hash
    };
    let stored = match before.iter().find(is_same) {
        Some(other) => other.data.1,
        None => file.store(&array.data)?,
    };
    Ok(array.with((hash, stored)))
}

/// A list of names, one for each step.
pub(super) fn names() -> Rows {
    Rows::new(Element::Int8, &[LONGEST as u64])
}

/// A name as written in a list.
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
