//! Axis-aligned boxes.

use super::vector::Vector;
use serde::{Deserialize, Serialize};

/// An axis-aligned box; empty when `low` is above `high`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest coordinates.
    pub low: Vector,
    /// Largest coordinates.
    pub high: Vector,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    /// The box around these points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector>) -> Self {
        let mut bounds = Self::EMPTY;
        for point in points {
            bounds.include(point);
        }
        bounds
    }

    /// Grows to hold a point.
    #[inline]
    pub fn include(&mut self, point: &Vector) {
        for i in 0..3 {
            self.low[i] = self.low[i].min(point[i]);
            self.high[i] = self.high[i].max(point[i]);
        }
    }

    /// The box around both.
    #[must_use]
    pub fn union(mut self, other: &Self) -> Self {
        for i in 0..3 {
            self.low[i] = self.low[i].min(other.low[i]);
            self.high[i] = self.high[i].max(other.high[i]);
        }
        self
    }

    /// Checks if both boxes share a point.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// The box with `margin` more on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self {
            low: self.low.map(|x| x - margin),
            high: self.high.map(|x| x + margin),
        }
    }

    /// Length of the diagonal; zero when empty.
    pub fn diagonal(&self) -> f64 {
        let squares = (0..3).map(|i| (self.high[i] - self.low[i]).max(0.0).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The point of the box nearest to a point; the point itself when the box is empty.
    pub fn nearest(&self, point: &Vector) -> Vector {
        std::array::from_fn(|i| {
            if self.low[i] <= self.high[i] {
                point[i].clamp(self.low[i], self.high[i])
            } else {
                point[i]
            }
        })
    }

    /// The middle of the box.
    pub fn centre(&self) -> Vector {
        std::array::from_fn(|i| 0.5 * self.low[i] + 0.5 * self.high[i])
    }

    /// Square of the distance from a point to the box; zero inside.
    #[inline]
    pub fn distance_squared(&self, point: &Vector) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            let outside = (self.low[i] - point[i])
                .max(point[i] - self.high[i])
                .max(0.0);
            sum += outside * outside;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_its_faces_and_distances_are_measured_from_them() {
        let one = Bounds::around(&[[0.0; 3], [1.0, 2.0, 3.0]]);
        let touching = Bounds::around(&[[1.0, 2.0, 3.0], [4.0; 3]]);
        assert!(one.meets(&touching) && touching.meets(&one));
        let behind = Bounds::around(&[[1.0 + 1e-15, 2.0, 3.0], [4.0; 3]]);
        assert!(!one.meets(&behind) && !behind.meets(&one));
        // Inside in x, below in y, above in z.
        let point = [0.25, -3.0, 7.0];
        assert_eq!(one.nearest(&point), [0.25, 0.0, 3.0]);
        assert_eq!(one.distance_squared(&point), 9.0 + 16.0);
        assert_eq!(one.distance_squared(&[0.5, 1.0, 3.0]), 0.0);
    }

    #[test]
    fn a_flat_box_is_not_empty() {
        let flat = Bounds::around(&[[0.0, 0.0, 5.0], [1.0, 1.0, 5.0]]);
        assert_eq!(flat.nearest(&[2.0, 0.5, 0.0]), [1.0, 0.5, 5.0]);
        assert_eq!(flat.distance_squared(&[0.5, 0.5, 3.0]), 4.0);
    }
}
