//! One zone: its kind, its sizes, its nodes.

use super::super::number::Chunk;
use super::node::Node;
use super::time::Step;
use crate::mesh::{Values, too_many};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// A zone of the file and what is read of it first.
pub(super) struct Zone<'a> {
    pub node: &'a Node,
    /// Name of its base.
    pub base: &'a str,
    /// Index among all zones.
    pub number: usize,
    /// Dimension of its cells.
    pub cell_dimension: u8,
    /// Nodes along each index; one entry for an unstructured zone.
    pub n_nodes: Vec<usize>,
    /// Cells along each index.
    pub n_cells: Vec<usize>,
    pub is_structured: bool,
    /// Its kind in the file and its actual kind, where these differ.
    pub odd_kind: Option<(String, &'static str)>,
    /// Index in the mesh of its first node.
    pub first_node: usize,
    /// CGNS version of the file.
    pub version: f64,
}

const STRUCTURED: &str = "Structured";

/// The kind that a text means: some programs abbreviate it, or write it in other letters.
fn kind_of(said: &str) -> Option<&'static str> {
    let begins = |kind: &&str| {
        let start = kind.get(..said.len());
        !said.is_empty() && start.is_some_and(|start| start.eq_ignore_ascii_case(said))
    };
    [STRUCTURED, "Unstructured"].into_iter().find(begins)
}

impl<'a> Zone<'a> {
    /// Reads the kind and the sizes.
    pub fn open(
        node: &'a Node,
        base: &'a str,
        number: usize,
        (cell_dimension, version): (u8, f64),
    ) -> Result<Self> {
        let said = node.child_text("ZoneType")?.unwrap_or_default();
        let kind = kind_of(&said).ok_or_else(|| {
            node.refuse(format!(
                "ZoneType is \"{said}\"; it must be Structured or Unstructured"
            ))
        })?;
        let is_structured = kind == STRUCTURED;
        let n_indices = if is_structured { cell_dimension } else { 1 }.into();
        let count = |n: i64| {
            let count = usize::try_from(n).ok().filter(|n| *n < u32::MAX as usize);
            count.ok_or_else(|| node.refuse(format!("its size {n} is out of range")))
        };
        let sizes = node.integers()?.into_iter().map(count);
        let sizes: Vec<usize> = sizes.collect::<Result<_>>()?;
        if sizes.len() < 2 * n_indices {
            return Err(node.refuse(format!(
                "it has {} sizes; a zone with {n_indices} indices must have {}",
                sizes.len(),
                3 * n_indices
            )));
        }
        Ok(Self {
            node,
            base,
            number,
            cell_dimension,
            n_nodes: sizes[..n_indices].to_vec(),
            n_cells: sizes[n_indices..2 * n_indices].to_vec(),
            is_structured,
            odd_kind: (said != kind).then_some((said, kind)),
            first_node: 0,
            version,
        })
    }

    /// Number of its nodes.
    pub fn total_nodes(&self) -> Result<usize> {
        let n = product(&self.n_nodes).filter(|n| *n < u32::MAX as usize);
        n.ok_or_else(|| self.node.refuse(too_many("nodes")))
    }

    /// Appends its nodes at this step to `points`.
    pub fn read_points(&mut self, step: &Step, points: &mut Vec<[f64; 3]>) -> Result<()> {
        let (axes, rind) = self.axes(step)?;
        let n = self.total_nodes()?;
        self.first_node = points.len();
        for (axis, node) in axes.iter().enumerate() {
            let Some(node) = node else { continue };
            let values = self.core(node, &self.n_nodes, &rind)?;
            if values.len() != n {
                return Err(node.refuse(format!(
                    "it has {} values; the zone has {n} nodes",
                    values.len()
                )));
            }
            if points.len() == self.first_node {
                points.resize(self.first_node + n, [0.0; 3]);
            }
            let points = &mut points[self.first_node..];
            let numbers = Chunk::of(&values);
            let numbers = numbers.ok_or_else(|| node.refuse("coordinates must be numbers"))?;
            let is_odd = |point: &[f64; 3]| !point[axis].is_finite();
            if !numbers.axis(axis, points)
                && let Some(at) = points.iter().position(is_odd)
            {
                return Err(node.refuse(format!(
                    "node {} has the coordinate {}; coordinates must be finite",
                    at + 1,
                    points[at][axis]
                )));
            }
        }
        if points.len() + 1 >= u32::MAX as usize {
            return Err(Error::input(too_many("nodes")));
        }
        Ok(())
    }

    /// The arrays of its coordinates at this step, for x, y and z, and their rind planes.
    pub fn axes(&self, step: &Step) -> Result<(Axes<'a>, Vec<usize>)> {
        let coordinates = self.coordinates(step)?;
        let rind = rind(coordinates)?;
        Ok((axes_of(coordinates, self.cell_dimension)?, rind))
    }

    /// Its nodes in the mesh.
    pub fn nodes(&self) -> Range<usize> {
        let n = self.n_nodes.iter().product::<usize>();
        self.first_node..self.first_node + n
    }

    /// The coordinates of a step.
    pub fn coordinates(&self, step: &Step) -> Result<&'a Node> {
        if let Some(name) = step.pointer(self.node, "GridCoordinatesPointers")? {
            return self.node.need(&name);
        }
        if let Some(original) = self.node.child("GridCoordinates")? {
            return Ok(original);
        }
        let any = self.node.labelled("GridCoordinates_t")?.next();
        any.ok_or_else(|| {
            self.node
                .refuse("it has no coordinates (GridCoordinates_t)")
        })
    }

    /// The values of an array without rind planes, that is without ghost nodes or cells.
    pub fn core(&self, node: &Node, sizes: &[usize], rind: &[usize]) -> Result<Values> {
        let values = node.values()?;
        if rind.iter().all(|&n| n == 0) {
            return Ok(values);
        }
        let planes = |i: usize| rind.get(i).copied().unwrap_or(0);
        let full = |i: usize| {
            let both = planes(2 * i).checked_add(planes(2 * i + 1))?;
            both.checked_add(sizes[i])
        };
        let whole: Option<Vec<usize>> = (0..sizes.len()).map(full).collect();
        let fits = |whole: &Vec<usize>| product(whole) == Some(values.len());
        let Some(whole) = whole.filter(fits) else {
            return Err(node.refuse(format!(
                "it has {} values, which do not fit the zone with its rind planes {rind:?}",
                values.len()
            )));
        };
        let mut keep = Vec::new();
        let get = |list: &[usize], i: usize, or: usize| list.get(i).copied().unwrap_or(or);
        for k in 0..get(sizes, 2, 1) {
            for j in 0..get(sizes, 1, 1) {
                let row = (k + planes(4)) * get(&whole, 1, 1) + j + planes(2);
                let start = row * whole[0] + planes(0);
                keep.extend(start..start + sizes[0]);
            }
        }
        Ok(values.select(1, &keep))
    }
}

/// The rind of coordinates or of a solution: ghost planes at both ends of each index.
pub(super) fn rind(node: &Node) -> Result<Vec<usize>> {
    let Some(rind) = node.labelled("Rind_t")?.next() else {
        return Ok(Vec::new());
    };
    let planes = rind.integers()?;
    let count = |&n: &i64| {
        usize::try_from(n).map_err(|_| rind.refuse("a number of rind planes is negative"))
    };
    planes.iter().map(count).collect()
}

fn product(sizes: &[usize]) -> Option<usize> {
    sizes.iter().try_fold(1, |p: usize, n| p.checked_mul(*n))
}

/// The arrays for x, y and z.
type Axes<'a> = [Option<&'a Node>; 3];

fn axes_of(coordinates: &Node, cell_dimension: u8) -> Result<Axes<'_>> {
    let names = ["CoordinateX", "CoordinateY", "CoordinateZ"];
    let mut axes = [None; 3];
    for (axis, name) in axes.iter_mut().zip(names) {
        *axis = coordinates.child(name)?;
    }
    let n_axes = axes.iter().flatten().count();
    let lacks = names.iter().zip(&axes).find(|(_, axis)| axis.is_none());
    if let Some((name, _)) = lacks
        && axes[0].is_some()
        && n_axes < usize::from(cell_dimension)
    {
        return Err(coordinates.refuse(format!(
            "it has no {name}; cells of dimension {cell_dimension} need {cell_dimension} coordinates"
        )));
    }
    if axes[0].is_none() || (axes[1].is_none() && axes[2].is_some()) {
        let found: Vec<&str> = coordinates
            .labelled("DataArray_t")?
            .map(Node::name)
            .collect();
        return Err(coordinates.refuse(format!(
            "it has the coordinates {}; only CoordinateX, CoordinateY and CoordinateZ are read",
            found.join(", ")
        )));
    }
    Ok(axes)
}
