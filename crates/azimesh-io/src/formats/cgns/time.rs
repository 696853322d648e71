//! The steps of a sequence: their times, and which node of a zone belongs to which of them.

use super::node::Node;
use super::{FIELD_ARRAYS, FIELD_POINTERS};
use crate::formats::ReadOptions;
use azimesh_core::error::Result;

/// The step that is read.
pub(super) struct Step {
    /// Number of the step; `None` where the file holds one state only.
    index: Option<usize>,
    /// Number of steps.
    n: usize,
}

/// Tests if a pointer means this solution; IOSS leaves out the location at the start of the name.
fn points_at(pointer: &str, solution: &str) -> bool {
    let short = |place: &str| solution.strip_prefix(place) == Some(pointer);
    !pointer.is_empty() && (pointer == solution || short("Vertex") || short("Cell"))
}

impl Step {
    /// The step that the options ask for, or the last.
    pub fn choose(root: &Node, options: &ReadOptions) -> Result<Self> {
        let n = times(root)?.len();
        let index = options.step_of(n)?;
        Ok(Self { index, n })
    }

    /// The node of a zone that a list of pointers names for this step.
    pub fn pointer(&self, zone: &Node, list: &str) -> Result<Option<String>> {
        let data = zone.labelled("ZoneIterativeData_t")?.next();
        let Some(pointers) = data.map(|data| data.child(list)).transpose()?.flatten() else {
            return Ok(None);
        };
        self.name_in(pointers)
    }

    /// Name of the node of a base that has the arrays of the mesh as a whole at this step.
    pub fn field_arrays(&self, base: &Node) -> Result<Option<String>> {
        let data = base.labelled("BaseIterativeData_t")?.next();
        let list = data.map(|data| data.child(FIELD_POINTERS)).transpose()?;
        match list.flatten() {
            Some(pointers) => self.name_in(pointers),
            None => Ok(Some(FIELD_ARRAYS.to_owned())),
        }
    }

    /// The name that a list has for this step.
    fn name_in(&self, pointers: &Node) -> Result<Option<String>> {
        let names = pointers.names()?;
        let name = self.index.and_then(|step| names.get(step));
        Ok(name
            .filter(|name| !name.is_empty() && *name != "Null")
            .cloned())
    }

    /// The solutions of a zone, all of one label, without those that belong to other steps only.
    pub fn solutions<'a>(&self, zone: &Node, all: Vec<&'a Node>) -> Result<Vec<&'a Node>> {
        let mut lists = Vec::new();
        for data in zone.labelled("ZoneIterativeData_t")? {
            for list in data.labelled("DataArray_t")? {
                if list.name().starts_with("FlowSolution") && list.name().ends_with("Pointers") {
                    lists.push(list.names()?);
                }
            }
        }
        if lists.is_empty() {
            return self.solutions_in_order(all);
        }
        let is_of_step = |solution: &&Node| {
            let of = |name: &String| points_at(name, solution.name());
            let now = |list: &Vec<String>| self.index.and_then(|i| list.get(i)).is_some_and(of);
            lists.iter().any(now) || !lists.iter().flatten().any(of)
        };
        Ok(all.into_iter().filter(is_of_step).collect())
    }

    /// Of as many solutions at one location as there are steps, each belongs to one.
    fn solutions_in_order<'a>(&self, all: Vec<&'a Node>) -> Result<Vec<&'a Node>> {
        let locations = all.iter().map(|node| node.child_text("GridLocation"));
        let locations: Vec<_> = locations.collect::<Result<_>>()?;
        let mut kept = Vec::new();
        for (i, solution) in all.iter().enumerate() {
            let alike = |range: std::ops::Range<usize>| {
                range.filter(|&k| locations[k] == locations[i]).count()
            };
            let is_of_step = self.index == Some(alike(0..i));
            let one_each = self.n > 1 && alike(0..all.len()) == self.n;
            if is_of_step || !one_each {
                kept.push(*solution);
            }
        }
        Ok(kept)
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
