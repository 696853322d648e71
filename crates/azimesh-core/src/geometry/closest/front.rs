//! Searches for neighbouring points together: they descend the tree as one block.

use super::super::bounds::Bounds;
use super::super::oriented::LANES;
use super::super::vector::{Vector, dot, sub};
use super::search::{Front, MOST_GROUPS, Stack, search};
use super::{ClosestPoint, ClosestSurface};
use multiversion::multiversion;

/// Points that are searched from one front; longer lists are cut into `PARTS`.
const TOGETHER: usize = 16;
const PARTS: usize = 4;

/// Neighbouring points that are searched together.
pub(super) struct Block<'a> {
    surface: &'a ClosestSurface<'a>,
    limit: f64,
    /// The leaf where the last foot was found: the next search starts from there.
    hint: Option<usize>,
    /// Buffers of the searches.
    waiting: Stack,
    found: &'a mut dyn FnMut(usize, &ClosestPoint),
}

impl<'a> Block<'a> {
    pub(super) fn new(
        surface: &'a ClosestSurface<'a>,
        limit: f64,
        found: &'a mut dyn FnMut(usize, &ClosestPoint),
    ) -> Self {
        Self {
            surface,
            limit,
            hint: None,
            waiting: Stack::new(),
            found,
        }
    }

    /// Narrows the front to what may be closest to one of `points`, and asks for parts of them or,
    /// in the end, for each.
    pub(super) fn visit(&mut self, points: &[Vector], first: usize, front: &Front) {
        let bounds = Bounds::around(points);
        let limit = self.limit_of(points, front);
        let front = narrowed(self.surface, front, &bounds, limit * limit);
        if front.groups.is_empty() {
            return;
        }
        if points.len() <= TOGETHER {
            for (i, point) in points.iter().enumerate() {
                let found = self.search(&front, point);
                if let Some((leaf, foot)) = found {
                    self.hint = Some(leaf);
                    (self.found)(first + i, &foot);
                }
            }
            return;
        }
        let part = points.len().div_ceil(PARTS).max(TOGETHER);
        for (i, points) in points.chunks(part).enumerate() {
            self.visit(points, first + i * part, &front);
        }
    }

    /// No point has its foot beyond this: the triangle inequality by way of one of them.
    fn limit_of(&mut self, points: &[Vector], front: &Front) -> f64 {
        let middle = &points[points.len() / 2];
        let Some((_, foot)) = self.search(front, middle) else {
            return self.limit;
        };
        let from_middle = |p: &Vector| dot(sub(*p, *middle), sub(*p, *middle));
        let spread = points.iter().map(from_middle).fold(0.0, f64::max);
        let limit = foot.distance_squared.sqrt() + spread.sqrt();
        self.limit.min(limit * (1.0 + 1e-12))
    }

    fn search(&mut self, front: &Front, point: &Vector) -> Option<(usize, ClosestPoint)> {
        let query = self.surface.query(point, None);
        search(&query, front, self.limit, self.hint, &mut self.waiting)
    }
}

/// The part of the front that may be nearer to the block than `limit`, squared, walked down while
/// it stays small.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn narrowed(surface: &ClosestSurface<'_>, front: &Front, block: &Bounds, limit: f64) -> Front {
    let mut front = front.clone();
    loop {
        let level = &surface.levels[front.level];
        let n_boxes = surface.n_boxes(front.level);
        let mut children = Vec::new();
        let mut groups = Vec::with_capacity(front.groups.len());
        for &group in &front.groups {
            let before = children.len();
            let distances = level[group as usize].distances_to(block);
            for lane in 0..LANES {
                let child = LANES * group as usize + lane;
                let is_far = distances[lane] > limit;
                if !is_far && child < n_boxes {
                    children.push(child as u32);
                }
            }
            if children.len() > before {
                groups.push(group);
            }
        }
        front.groups = groups;
        if front.level == 0 || children.is_empty() || children.len() > MOST_GROUPS {
            return front;
        }
        front = Front {
            level: front.level - 1,
            groups: children,
        };
    }
}
