//! Vectors, rigid transforms, boxes and space-filling order. Knows nothing of meshes.

pub mod bounds;
pub mod closest;
pub mod curve;
pub mod oriented;
pub mod transform;
pub mod vector;

pub use bounds::Bounds;
pub use transform::Transform;
