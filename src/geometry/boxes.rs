//! Boxes in an order in which neighbours are near each other, and which of them are around a point or meet a box.

use super::bounds::Bounds;
use super::vector::Vector;

/// Boxes that one box of the level above holds.
const FAN: usize = 8;

/// Boxes, with boxes around `FAN` of them each, around as many of those, and so on.
pub struct Boxes {
    /// The boxes first, the largest last.
    levels: Vec<Vec<Bounds>>,
}

impl Boxes {
    /// With the boxes around them.
    pub fn new(boxes: Vec<Bounds>) -> Self {
        let mut levels = vec![boxes];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let around = |some: &[Bounds]| some.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
            let next = last.chunks(FAN).map(around).collect();
            levels.push(next);
        }
        Self { levels }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.levels[0].len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.levels[0].is_empty()
    }

    /// One that holds a point: the one that held another where that `was`, which is found at once.
    pub fn one_around(&self, point: &Vector, was: Option<usize>) -> Option<usize> {
        let point = Bounds {
            low: *point,
            high: *point,
        };
        let again = was.filter(|&at| self.levels[0][at].meets(&point));
        again.or_else(|| {
            let mut first = None;
            self.each_below(self.levels.len() - 1, 0, &point, &mut |at| {
                first = Some(at);
                false
            });
            first
        })
    }

    /// Whether one meets a box: that which met another, where it `was` one, is looked at first.
    pub fn any_meets(&self, bounds: &Bounds, was: Option<usize>) -> bool {
        was.is_some_and(|at| self.levels[0][at].meets(bounds))
            || !self.each_below(self.levels.len() - 1, 0, bounds, &mut |_| false)
    }

    /// Calls `found` with each that meets a box, in their order.
    pub fn each_meeting(&self, bounds: &Bounds, mut found: impl FnMut(usize)) {
        self.each_below(self.levels.len() - 1, 0, bounds, &mut |at| {
            found(at);
            true
        });
    }

    /// Looks at the boxes of a level from `start` on that lie in one box, until `found` wants no more; tells whether it did.
    fn each_below(
        &self,
        level: usize,
        start: usize,
        bounds: &Bounds,
        found: &mut impl FnMut(usize) -> bool,
    ) -> bool {
        let boxes = &self.levels[level];
        let some = start..boxes.len().min(start + FAN);
        some.into_iter().all(|at| {
            !boxes[at].meets(bounds)
                || match level {
                    0 => found(at),
                    _ => self.each_below(level - 1, at * FAN, bounds, found),
                }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_what_looking_at_all_boxes_finds() {
        let boxes: Vec<Bounds> = (0..777)
            .map(|i| {
                let at = f64::from(i) * 0.1;
                let middle = [at.sin() * 3.0, at.cos() * 3.0, at];
                Bounds::around(&[middle]).grown(0.3 + f64::from(i % 7) * 0.1)
            })
            .collect();
        for n in [0, 1, 8, 9, 777] {
            let some = &boxes[..n];
            let tree = Boxes::new(some.to_vec());
            assert_eq!((tree.len(), tree.is_empty()), (n, n == 0));
            for i in 0..500 {
                let t = f64::from(i) * 0.17;
                let point = [(t * 1.3).sin() * 3.0, t.cos() * 3.0, t];
                let around = |bounds: &Bounds| bounds.distance_squared(&point) == 0.0;
                assert_eq!(tree.one_around(&point, None), some.iter().position(around));
                let last = some.iter().rposition(around);
                assert_eq!(tree.one_around(&point, last), last);
                let wide = Bounds::around(&[point]).grown(1.0);
                let meeting: Vec<usize> = (0..n).filter(|&at| some[at].meets(&wide)).collect();
                let mut found = Vec::new();
                tree.each_meeting(&wide, |at| found.push(at));
                assert_eq!(found, meeting);
                for was in [None, last, n.checked_sub(1)] {
                    assert_eq!(tree.any_meets(&wide, was), !meeting.is_empty());
                }
            }
        }
    }
}
