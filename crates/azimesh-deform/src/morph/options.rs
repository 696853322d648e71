//! Options of a morph: which nodes move, stay, slide or are paired, and the selection of base points.

use crate::motion::KernelName;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::Mesh;

/// Nodes of a mesh, by their boundary tags or by their numbers.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::Nodes;
///
/// let by_tag = Nodes::from("wing");
/// let by_tags = Nodes::from(["wing", "flap"]);
/// let by_number = Nodes::from(vec![4, 7, 9]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Nodes {
    /// All nodes of the faces of these tags.
    Tags(Vec<String>),
    /// These nodes, from 0.
    Numbers(Vec<u32>),
}

impl Default for Nodes {
    /// No nodes.
    fn default() -> Self {
        Self::Numbers(Vec::new())
    }
}

impl From<&str> for Nodes {
    fn from(tag: &str) -> Self {
        Self::Tags(vec![tag.to_owned()])
    }
}

impl<const N: usize> From<[&str; N]> for Nodes {
    fn from(tags: [&str; N]) -> Self {
        Self::Tags(tags.map(str::to_owned).into())
    }
}

impl From<Vec<String>> for Nodes {
    fn from(tags: Vec<String>) -> Self {
        Self::Tags(tags)
    }
}

impl From<Vec<u32>> for Nodes {
    fn from(numbers: Vec<u32>) -> Self {
        Self::Numbers(numbers)
    }
}

impl Nodes {
    /// Returns the node numbers: ascending for tags, else in the given order. `option` is its name in messages.
    ///
    /// # Errors
    /// A tag or a number that is not in the mesh, and a number that is given twice.
    pub(super) fn find(&self, option: &str, mesh: &Mesh) -> Result<Vec<u32>> {
        match self {
            Self::Tags(tags) => {
                let of_tags = tags.iter().map(|tag| mesh.tag_nodes(tag));
                let mut nodes = of_tags.collect::<Result<Vec<_>>>()?.concat();
                nodes.sort_unstable();
                nodes.dedup();
                Ok(nodes)
            }
            Self::Numbers(numbers) => {
                check_numbers(numbers, option, mesh.points.len())?;
                Ok(numbers.clone())
            }
        }
    }

    /// Returns a description for messages.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Tags(tags) => tags.join(", "),
            Self::Numbers(numbers) => format!("{} nodes", numbers.len()),
        }
    }
}

fn check_numbers(numbers: &[u32], option: &str, n_nodes: usize) -> Result<()> {
    let mut seen = vec![false; n_nodes];
    for &node in numbers {
        let Some(seen) = seen.get_mut(node as usize) else {
            return Err(Error::input(format!(
                "`{option}` has node {node}, but the mesh has {n_nodes} nodes (0 to {})",
                n_nodes.saturating_sub(1)
            )));
        };
        if std::mem::replace(seen, true) {
            return Err(Error::input(format!("`{option}` has node {node} twice")));
        }
    }
    Ok(())
}

/// Options of a [`Morph`](super::Morph): which nodes move, stay and slide, and the selection of base points.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Kernel, MorphOptions};
///
/// let options = MorphOptions {
///     moving: ["wing", "flap"].into(),
///     fixed: "farfield".into(),
///     slide: "symmetry".into(),
///     kernel: Kernel::WendlandC4,
///     support_radius: Some(4.0),
///     ..Default::default()
/// };
/// assert_eq!(options.max_points, 1000);
/// ```
#[derive(Debug, Clone)]
pub struct MorphOptions {
    /// Nodes with given displacements, at least one. A node of both a moving tag and a fixed or sliding tag moves.
    pub moving: Nodes,
    /// Nodes that stay where they are.
    pub fixed: Nodes,
    /// Nodes that slide on the planes and straight edges of their boundary faces. A node that is also fixed or moving does
    /// not slide.
    pub slide: Nodes,
    /// Pairs of sides that a translation or a rotation makes equal.
    pub periodic: Vec<[Nodes; 2]>,
    /// Displacement fields (n_moving, 3) by which base points are selected, such as mode shapes; their size does not
    /// matter. Without samples, the power function is used.
    pub samples: Vec<Vec<Vector>>,
    /// Largest number of base points.
    pub max_points: usize,
    /// With samples, the error allowed at any surface node, relative to the largest displacement of the sample. Without,
    /// the bound of the weighted power function: the error over the norm of the displacements in the kernel's space.
    pub tolerance: f64,
    /// The kernel of the interpolation.
    pub kernel: KernelName,
    /// Support radius: distance beyond which the kernel is zero, in mesh units. Default: the smaller of the diagonal of
    /// the mesh and ten diagonals of the moving surface.
    pub support_radius: Option<f64>,
}

impl Default for MorphOptions {
    /// Creates options without moving nodes: up to 1000 base points, a tolerance of 1e-4, Wendland's C2 function.
    fn default() -> Self {
        Self {
            moving: Nodes::default(),
            fixed: Nodes::default(),
            slide: Nodes::default(),
            periodic: Vec::new(),
            samples: Vec::new(),
            max_points: 1000,
            tolerance: 1e-4,
            kernel: KernelName::default(),
            support_radius: None,
        }
    }
}

impl MorphOptions {
    /// # Errors
    /// Numbers that are out of range.
    pub(super) fn check(&self) -> Result<()> {
        let size = |name: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::input(format!(
                    "`{name}` is {value}; it must be a positive number"
                )))
            }
        };
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(Error::input(format!(
                "`tolerance` is {}; it must be between 0 and 1",
                self.tolerance
            )));
        }
        size("support_radius", self.support_radius.unwrap_or(1.0))?;
        match self.max_points {
            0 => Err(Error::input("`max_points` is 0; it must be at least 1")),
            _ => Ok(()),
        }
    }
}
