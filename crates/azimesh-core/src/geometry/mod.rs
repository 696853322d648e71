//! Vectors, rigid transforms, rotation vectors, boxes and space-filling order. Knows nothing of meshes.

pub mod bounds;
pub mod closest;
pub mod crossing;
pub mod curve;
mod facet;
pub mod moving;
pub mod oriented;
pub mod rotation;
pub mod transform;
pub mod vector;

pub use bounds::Bounds;
pub use moving::Moving;
pub use rotation::Twist;
pub use transform::Transform;
