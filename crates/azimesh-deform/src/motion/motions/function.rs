//! Displacements of nodes by a function of the caller.

use super::sets::NodeSets;
use super::{BodyMotion, OnMesh, ResolvedMotion};
use crate::motion::steps::Step;
use crate::motion::table::Key;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::fmt;
use std::sync::Arc;

/// A function that writes the displacements of all nodes of a body, for a step and the nodes' positions in the reference mesh.
pub(in crate::motion) type NodeFunction = dyn Fn(&Step, &[Vector], &mut [Vector]) + Send + Sync;

/// A function that displaces the nodes of a body. It is called once for each step, when the schedule is
/// resolved on a mesh.
#[derive(Clone)]
pub(in crate::motion) struct Displacements {
    pub function: Arc<NodeFunction>,
    /// Name given by the caller. A run may be resumed if the name is the same.
    pub name: Option<String>,
}

impl fmt::Debug for Displacements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Displacements").field(&self.name).finish()
    }
}

impl BodyMotion for Displacements {
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let nodes = on.nodes();
        let displaced = |step: &Step| {
            let mut set = vec![[0.0; 3]; nodes.places.len()];
            (self.function)(step, &nodes.places, &mut set);
            let wrong = |d: &Vector| {
                if d.iter().all(|x| x.is_finite()) {
                    on.in_plane() && d[2] != 0.0
                } else {
                    true
                }
            };
            match set.iter().position(wrong) {
                None => Ok(set),
                Some(at) => Err(refused(on, step, nodes.nodes[at], set[at])),
            }
        };
        let sets: Result<Vec<Vec<Vector>>> = on.clock.steps.iter().map(displaced).collect();
        let places = (0..on.clock.steps.len()).map(|step| step as f64);
        let places = (Key::Step, places.collect());
        let sets = NodeSets::at_places(places, sets?, Vec::new(), Vec::new(), on);
        Ok(Arc::new(sets))
    }
}

fn refused(on: &OnMesh<'_>, step: &Step, node: u32, displacement: Vector) -> Error {
    let body = &on.body.name;
    let right = if displacement.iter().all(|x| x.is_finite()) {
        "along z must be 0 in a 2D mesh"
    } else {
        "must be finite numbers"
    };
    let message = format!(
        "body \"{body}\": the displacement of node {node} at {step} is {displacement:?}; displacements {right}"
    );
    on.error("displacements", message)
}
