//! The grid that covers a closed tube: nodes and quadrilaterals by their place, without positions.
//!
//! ```text
//!            row n_span + band                 tip patch, side x band cells:
//!          ┌──────────────────┐  tip ring          side
//! row      ├──────────────────┤               ┌─────────────┐
//!          │  loop x n_span   │  wrap         │             │ band
//!          ├──────────────────┤               └─────────────┘
//!          └──────────────────┘  root ring
//!            row 0
//! ```
//!
//! A loop runs round the tube: half the leading band, the upper side, the trailing band, the lower
//! side, half the leading band. At either end, `band / 2` rows more (a ring) lead to a patch whose
//! rim is the last row. Only the patches' corners have three cells instead of four.

/// Cell counts of the grid on a tube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tube {
    /// Cells along the upper and along the lower side.
    pub side: usize,
    /// Cells round the leading and round the trailing band; even.
    pub band: usize,
    /// Cells along the span, without rings.
    pub span: usize,
}

/// Root or tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The inner end.
    Root,
    /// The outer end.
    Tip,
}

impl End {
    /// Part of the way from root to tip.
    pub fn part(self) -> f64 {
        match self {
            Self::Root => 0.0,
            Self::Tip => 1.0,
        }
    }
}

/// The place of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// On the wrap: loop index and span index.
    Wrap(usize, usize),
    /// On the ring of an end: loop index and the part of the way to the patch, above 0 to 1.
    Ring(End, usize, f64),
    /// Inside the patch of an end: index along the side from the leading band, index through the
    /// band from the upper side.
    Patch(End, usize, usize),
}

impl Tube {
    /// The tube with about `n_nodes` nodes, and with `aspect` times as many cells along the span
    /// as from leading to trailing edge.
    pub fn with_nodes(n_nodes: usize, aspect: f64) -> Self {
        // Nodes are about 2 aspect (half loop)^2, and a band about a sixth of the half loop.
        let usual = (n_nodes as f64 / (2.0 * aspect + 0.6)).sqrt();
        let from = (0.8 * usual) as usize;
        let to = (1.2 * usual) as usize + 1;
        (from.max(6)..=to.max(7))
            .map(|half_loop| Self::with_half_loop(half_loop, n_nodes))
            .min_by(|a, b| {
                let cost = |tube: &Self| tube.misfit(n_nodes, aspect);
                cost(a).total_cmp(&cost(b))
            })
            .expect("the range holds at least one")
    }

    fn with_half_loop(half_loop: usize, n_nodes: usize) -> Self {
        let band = (2 * ((half_loop as f64 / 12.0).round() as usize)).clamp(2, 48);
        let side = half_loop - band;
        let tube = Self {
            side,
            band,
            span: 0,
        };
        let span = n_nodes.saturating_sub(tube.n_nodes()) as f64 / tube.n_loop() as f64;
        Self {
            span: (span.round() as usize).max(4),
            ..tube
        }
    }

    fn misfit(&self, n_nodes: usize, aspect: f64) -> f64 {
        let off = (self.n_nodes() as f64 / n_nodes as f64).ln().abs();
        let half_loop = (self.n_loop() / 2) as f64;
        let shape = (self.span as f64 / half_loop / aspect).ln().abs();
        off + 0.02 * shape
    }

    /// Nodes of a loop.
    pub fn n_loop(&self) -> usize {
        2 * (self.side + self.band)
    }

    /// Nodes in all.
    pub fn n_nodes(&self) -> usize {
        self.n_loop() * self.n_rows() + 2 * self.n_inside()
    }

    /// Quadrilaterals in all.
    pub fn n_quads(&self) -> usize {
        self.n_loop() * (self.n_rows() - 1) + 2 * self.side * self.band
    }

    /// Rows of loops of the wrap and of both rings.
    pub fn n_rows(&self) -> usize {
        self.span + self.band + 1
    }

    /// Nodes inside a patch.
    fn n_inside(&self) -> usize {
        (self.side - 1) * (self.band - 1)
    }

    /// Loop index in half a loop, and +1 on the upper, -1 on the lower half.
    pub fn folded(&self, around: usize) -> (usize, f64) {
        let half_loop = self.side + self.band;
        if around <= half_loop {
            (around, 1.0)
        } else {
            (2 * half_loop - around, -1.0)
        }
    }

    /// The end that a quadrilateral is on, rings included; `None` on the wrap.
    pub fn end_of(&self, quad: usize) -> Option<End> {
        let (n, ring) = (self.n_loop(), self.band / 2);
        let of_rows = n * (self.n_rows() - 1);
        if quad < n * ring || (of_rows..of_rows + self.side * self.band).contains(&quad) {
            Some(End::Root)
        } else if quad < n * (ring + self.span) {
            None
        } else {
            Some(End::Tip)
        }
    }

    /// Checks if a cell of a loop, from this loop index to the next, is in the leading or the trailing
    /// band.
    pub fn is_in_band(&self, around: usize) -> bool {
        let (half, ring) = (self.n_loop() / 2, self.band / 2);
        around % half < ring || around % half >= half - ring
    }

    /// Checks if a node is on the wrap's trailing band or its edges.
    pub fn is_trailing(&self, node: usize) -> bool {
        let (n, ring) = (self.n_loop(), self.band / 2);
        let on_wrap = (n * ring..n * (ring + self.span + 1)).contains(&node);
        on_wrap && (node % n).abs_diff(n / 2) <= ring
    }

    /// The node opposite to one of the wrap: on the leading half for one on the trailing half.
    pub fn mirrored(&self, node: usize) -> usize {
        let n = self.n_loop();
        node - node % n + (n / 2 + n - node % n) % n
    }

    /// The place of a node: rows from root to tip, then the root's patch, then the tip's.
    pub fn place(&self, node: usize) -> Place {
        let n_wrap = self.n_loop() * self.n_rows();
        if node < n_wrap {
            return self.place_in_row(node % self.n_loop(), node / self.n_loop());
        }
        let inside = node - n_wrap;
        let is_root = inside < self.n_inside();
        let end = if is_root { End::Root } else { End::Tip };
        let (inside, n) = (inside % self.n_inside(), self.side - 1);
        Place::Patch(end, inside % n + 1, inside / n + 1)
    }

    fn place_in_row(&self, around: usize, row: usize) -> Place {
        let ring = self.band / 2;
        let part = |rows: usize| rows as f64 / ring as f64;
        if row < ring {
            Place::Ring(End::Root, around, part(ring - row))
        } else if row <= ring + self.span {
            Place::Wrap(around, row - ring)
        } else {
            Place::Ring(End::Tip, around, part(row - ring - self.span))
        }
    }

    /// Loop index of a node on a patch's rim or `None` inside: `i` along the side, `j` through the
    /// band.
    fn rim(&self, i: usize, j: usize) -> Option<usize> {
        let (n, ring) = (self.n_loop(), self.band / 2);
        if j == 0 {
            Some(ring + i)
        } else if j == self.band {
            Some(n - ring - i)
        } else if i == 0 {
            Some((n + ring - j) % n)
        } else if i == self.side {
            Some(n / 2 - ring + j)
        } else {
            None
        }
    }

    fn patch_node(&self, end: End, i: usize, j: usize) -> u32 {
        let (row, before) = match end {
            End::Root => (0, 0),
            End::Tip => (self.n_rows() - 1, self.n_inside()),
        };
        let node = match self.rim(i, j) {
            Some(around) => row * self.n_loop() + around,
            None => self.n_loop() * self.n_rows() + before + (j - 1) * (self.side - 1) + i - 1,
        };
        node as u32
    }

    /// The quadrilaterals, seen counter-clockwise from outside the tube when its loop runs from
    /// +y over +z to -y and its rows along +x.
    pub fn quads(&self) -> Vec<[u32; 4]> {
        let n = self.n_loop();
        let mut quads = Vec::with_capacity(self.n_quads());
        for row in 0..self.n_rows() - 1 {
            for around in 0..n {
                let (a, b) = (row * n + around, row * n + (around + 1) % n);
                quads.push([a, b, b + n, a + n].map(|node| node as u32));
            }
        }
        for end in [End::Root, End::Tip] {
            for j in 0..self.band {
                for i in 0..self.side {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    let mut quad = corners.map(|(i, j)| self.patch_node(end, i, j));
                    if end == End::Root {
                        quad.reverse();
                    }
                    quads.push(quad);
                }
            }
        }
        quads
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn the_grid_is_closed_and_turns_one_way() {
        let tube = Tube {
            side: 5,
            band: 4,
            span: 6,
        };
        let quads = tube.quads();
        assert_eq!(quads.len(), tube.n_quads());
        let mut edges = BTreeMap::new();
        for quad in &quads {
            for i in 0..4 {
                *edges.entry((quad[i], quad[(i + 1) % 4])).or_insert(0) += 1;
            }
        }
        assert!(
            edges
                .iter()
                .all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a)))
        );
        // A sphere: nodes - edges + faces = 2.
        assert_eq!(tube.n_nodes() + quads.len(), edges.len() / 2 + 2);
    }

    #[test]
    fn nodes_and_their_mirror_images_are_on_opposite_bands() {
        let tube = Tube {
            side: 5,
            band: 4,
            span: 6,
        };
        let n = tube.n_loop();
        let trailing: Vec<usize> = (0..tube.n_nodes())
            .filter(|&i| tube.is_trailing(i))
            .collect();
        assert_eq!(trailing.len(), 5 * 7);
        for node in trailing {
            let leading = tube.mirrored(node);
            assert_eq!((leading / n, tube.mirrored(leading)), (node / n, node));
            assert!([0, 1, 2, n - 1, n - 2].contains(&(leading % n)));
        }
        let on = |end| {
            (0..tube.n_quads())
                .filter(|&quad| tube.end_of(quad) == end)
                .count()
        };
        assert_eq!(on(Some(End::Root)), 2 * n + 5 * 4);
        assert_eq!(on(Some(End::Tip)), on(Some(End::Root)));
        assert_eq!((0..n).filter(|&around| tube.is_in_band(around)).count(), 8);
    }

    #[test]
    fn the_node_count_is_met() {
        for wanted in [400, 1_500, 12_560, 334_351] {
            let tube = Tube::with_nodes(wanted, 1.4);
            let off = tube.n_nodes() as f64 / wanted as f64 - 1.0;
            assert!(
                off.abs() < 0.03,
                "{wanted}: {tube:?} has {}",
                tube.n_nodes()
            );
        }
    }
}
