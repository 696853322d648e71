//! Positions of nodes that belong together.

use super::NodePair;
use super::partners::{Partners, in_chunks};

/// Paired nodes whose distance exceeds the tolerance.
#[derive(Debug, Default)]
pub struct Moved {
    /// Their number.
    pub n: usize,
    /// The first.
    pub first: Option<NodePair>,
    /// The pair with the largest distance, moved or not; the first of equals.
    pub furthest: Option<NodePair>,
}

/// Looks at every node of `a` that has a partner in `b`.
pub fn compare(a: &[[f64; 3]], b: &[[f64; 3]], partners: &Partners, allowed: f64) -> Moved {
    let look = |range: std::ops::Range<usize>| {
        let mut found = Moved::default();
        let mut furthest = f64::NEG_INFINITY;
        for node in range {
            let Some(partner) = partners.of(node) else {
                continue;
            };
            let distance = distance(a[node], b[partner]);
            if distance <= allowed && distance <= furthest {
                continue;
            }
            let pair = NodePair {
                node,
                partner,
                a: a[node],
                b: b[partner],
                distance,
            };
            if distance > furthest {
                furthest = distance;
                found.furthest = Some(pair);
            }
            if distance > allowed {
                found.n += 1;
                found.first.get_or_insert(pair);
            }
        }
        found
    };
    in_chunks(a.len(), &look, Moved::joined)
}

impl Moved {
    fn joined(self, later: Self) -> Self {
        let furthest = match (self.furthest, later.furthest) {
            (Some(x), Some(y)) if y.distance > x.distance => Some(y),
            (x, y) => x.or(y),
        };
        Self {
            n: self.n + later.n,
            first: self.first.or(later.first),
            furthest,
        }
    }
}

/// Distance of two points; not zero where they differ, however little.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let apart = [0, 1, 2].map(|i| (a[i] - b[i]).abs());
    let squared: f64 = apart.iter().map(|x| x * x).sum();
    match squared {
        // Squares underflow for tiny numbers and overflow for huge ones.
        x if x < f64::MIN_POSITIVE || x == f64::INFINITY => apart.into_iter().fold(0.0, f64::max),
        x => x.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_parts_the_furthest_pair_counts_and_of_equal_ones_the_first() {
        let furthest = |distances: [f64; 2]| {
            let [a, b] = [0, 1].map(|node| {
                let pair = NodePair {
                    node,
                    partner: node,
                    a: [0.0; 3],
                    b: [distances[node], 0.0, 0.0],
                    distance: distances[node],
                };
                Moved {
                    n: 1,
                    first: Some(pair),
                    furthest: Some(pair),
                }
            });
            let joined = a.joined(b);
            assert_eq!((joined.n, joined.first.map(|pair| pair.node)), (2, Some(0)));
            joined.furthest.map(|pair| pair.node)
        };
        assert_eq!(furthest([1.0, 2.0]), Some(1));
        assert_eq!(furthest([2.0, 1.0]), Some(0));
        assert_eq!(furthest([1.0, 1.0]), Some(0));
    }
}
