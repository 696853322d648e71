//! The steps of a sequence: their times, and which node of a zone belongs to which of them.

use super::node::Node;
use crate::error::{Error, Result};

/// The step that is read.
pub(super) struct Step {
    /// Its number; `None` where the file holds one state only.
    index: Option<usize>,
}

impl Step {
    /// The step that was asked for, or the last.
    pub fn choose(root: &Node, asked: Option<usize>) -> Result<Self> {
        let n = times(root)?.len();
        let index = match asked {
            Some(step) if step >= n.max(1) => {
                let message = match n {
                    0 | 1 => format!("there is no step {step}: the file holds one mesh"),
                    _ => format!("there is no step {step}: the file has steps 0 to {}", n - 1),
                };
                return Err(Error::input(message));
            }
            Some(step) => Some(step),
            None => n.checked_sub(1),
        };
        Ok(Self {
            index: index.filter(|_| n > 0),
        })
    }

    /// The node of a zone that a list of pointers names for this step.
    pub fn pointer(&self, zone: &Node, list: &str) -> Result<Option<String>> {
        let Some(data) = zone.labelled("ZoneIterativeData_t")?.next() else {
            return Ok(None);
        };
        let Some(pointers) = data.child(list)? else {
            return Ok(None);
        };
        let names = pointers.names()?;
        let name = self.index.and_then(|step| names.get(step));
        Ok(name
            .filter(|name| !name.is_empty() && *name != "Null")
            .cloned())
    }

    /// Whether a solution of a zone belongs to other steps only.
    pub fn is_of_other_steps(&self, zone: &Node, solution: &str) -> Result<bool> {
        let Some(data) = zone.labelled("ZoneIterativeData_t")?.next() else {
            return Ok(false);
        };
        let mut is_named = false;
        for list in data.labelled("DataArray_t")? {
            if !list.name().starts_with("FlowSolution") || !list.name().ends_with("Pointers") {
                continue;
            }
            let names = list.names()?;
            if self
                .index
                .and_then(|step| names.get(step))
                .map(String::as_str)
                == Some(solution)
            {
                return Ok(false);
            }
            is_named |= names.iter().any(|name| name == solution);
        }
        Ok(is_named)
    }

    /// Names of the zones that exist at this step; `None` where all do.
    pub fn zones(&self, base: &Node) -> Result<Option<Vec<String>>> {
        let Some(data) = base.labelled("BaseIterativeData_t")?.next() else {
            return Ok(None);
        };
        let (Some(pointers), Some(step)) = (data.child("ZonePointers")?, self.index) else {
            return Ok(None);
        };
        let n_zones = match pointers.sizes()?[..] {
            [32, n, _] => n as usize,
            _ => return Ok(None),
        };
        let names = pointers.names()?;
        let of_step = names.chunks(n_zones.max(1)).nth(step);
        Ok(of_step.map(<[String]>::to_vec))
    }
}

/// Times of the steps; empty for a file of one state.
pub(super) fn times(root: &Node) -> Result<Vec<f64>> {
    for base in root.labelled("CGNSBase_t")? {
        let Some(data) = base.labelled("BaseIterativeData_t")?.next() else {
            continue;
        };
        for name in ["TimeValues", "IterationValues"] {
            if let Some(values) = data.child(name)? {
                return values.numbers();
            }
        }
    }
    Ok(Vec::new())
}
