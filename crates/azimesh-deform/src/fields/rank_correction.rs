//! The correction of fields and positions, shared by ranks: every rank corrects the same number of nodes near the
//! surface, which may belong to other ranks.
//!
//! ```text
//! every rank   finds its nodes near the surface; the lists of all ranks, in rank order, are cut into equal pieces
//! every rank   sends the positions of its nodes to the ranks of their pieces, and receives the corrections
//! ```

use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_core::ranks::Ranks;
use azimesh_rbf::correct::{Added, Correction};
use azimesh_rbf::field::Field;
use std::ops::Range;

/// Number of nodes that one task checks.
const BLOCK: usize = 1 << 14;
/// Number of nodes checked together: first many, then few.
const MANY: usize = 64;
const FEW: usize = 8;

/// Adds a correction to a field at the nodes of this rank, whose positions are in `points`. Nodes near the surface
/// are spread evenly over the ranks.
pub(crate) fn add_correction(
    correction: &Correction<'_>,
    field: &mut Field,
    points: &[Vector],
    ranks: &Ranks,
) {
    let Field { nodes, values, .. } = field;
    let nodes = nodes.as_deref();
    Rows { points, nodes }.add(correction, values, |row| row, ranks);
}

/// Adds a correction of three modes to the positions `out` of the nodes of this rank, or of some ascending `nodes`.
/// Distances to the surface are measured from the positions `before` of all nodes.
pub(crate) fn add_faded(
    correction: &Correction<'_>,
    before: &[Vector],
    nodes: Option<&[u32]>,
    out: &mut [Vector],
    ranks: &Ranks,
) {
    // Like a sum with a field that is zero out of reach, this removes negative zeros.
    let add_zero = |x: &mut Vector| *x = x.map(|x| x + 0.0);
    match nodes {
        None => parallel::update(out, |_, x| add_zero(x)),
        Some(nodes) => (nodes.iter()).for_each(|&node| add_zero(&mut out[node as usize])),
    }
    let points = before;
    let target = |row: u32| nodes.map_or(row, |nodes| nodes[row as usize]);
    Rows { points, nodes }.add(correction, out.as_flattened_mut(), target, ranks);
}

/// The corrected nodes of this rank, one per row.
struct Rows<'a> {
    /// The positions of all nodes.
    points: &'a [Vector],
    /// The nodes of the rows; `None` for all.
    nodes: Option<&'a [u32]>,
}

impl Rows<'_> {
    fn n(&self) -> usize {
        self.nodes.map_or(self.points.len(), <[u32]>::len)
    }

    fn place(&self, row: usize) -> Vector {
        self.points[self.nodes.map_or(row, |nodes| nodes[row] as usize)]
    }

    /// Adds the correction of each row to the row `target(row)` of `values`.
    fn add(
        &self,
        correction: &Correction<'_>,
        values: &mut [f64],
        target: impl Fn(u32) -> u32,
        ranks: &Ranks,
    ) {
        let place = |row: usize| self.place(row);
        if ranks.n() == 1 {
            return correction.add_at(self.n(), place, values, target);
        }
        let near = self.near(correction);
        let pieces = pieces(&ranks.allgather(near.len()), ranks.rank());
        if pieces.is_empty() {
            return;
        }
        let places = |piece: &Range<usize>| {
            let near = &near[piece.clone()];
            parallel::collect(near.len(), |i| place(near[i] as usize))
        };
        let asked = ranks.alltoallv(pieces.iter().map(places).collect());
        let added: Vec<Added> = asked.iter().map(|points| correction.at(points)).collect();
        drop(asked);
        for (piece, added) in pieces.into_iter().zip(ranks.alltoall_values(added)) {
            let near = &near[piece];
            added.add_to(values, correction.n_modes(), |at| target(near[at as usize]));
        }
    }

    /// Returns the rows that may be within the fade radius, ascending; some are outside. Consecutive nodes of a mesh are
    /// near each other, so many are checked together, then few.
    fn near(&self, correction: &Correction<'_>) -> Vec<u32> {
        let may_reach = |rows: &Range<usize>| {
            let mut bounds = Bounds::EMPTY;
            for row in rows.clone() {
                bounds.include(&self.place(row));
            }
            correction.may_reach(&bounds)
        };
        let parts = |rows: Range<usize>, n: usize| {
            let starts = rows.clone().step_by(n);
            starts.map(move |start| start..rows.end.min(start + n))
        };
        parallel::concat_blocks(self.n(), BLOCK, &|rows| {
            let many = parts(rows, MANY).filter(may_reach);
            let few = many.flat_map(|many| parts(many, FEW)).filter(may_reach);
            few.flat_map(|few| few.start as u32..few.end as u32)
                .collect()
        })
    }
}

/// Returns the parts of this rank's list that go to each rank's piece, from the lengths of all lists; empty if all lists are.
fn pieces(lengths: &[usize], rank: usize) -> Vec<Range<usize>> {
    let (n, all) = (lengths.len(), lengths.iter().sum::<usize>());
    if all == 0 {
        return Vec::new();
    }
    let before = lengths[..rank].iter().sum::<usize>();
    let start = |piece: usize| (all * piece / n).saturating_sub(before).min(lengths[rank]);
    (0..n).map(|piece| start(piece)..start(piece + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::ranks::on_threads;
    use azimesh_rbf::correct::Fading;

    #[test]
    fn lists_are_cut_into_equal_pieces() {
        assert_eq!(pieces(&[5, 0], 0), [0..2, 2..5]);
        assert_eq!(pieces(&[0, 9, 0], 1), [0..3, 3..6, 6..9]);
        assert_eq!(pieces(&[0, 9, 0], 2), [0..0, 0..0, 0..0]);
        assert_eq!(pieces(&[4, 2, 1], 0), [0..2, 2..4, 4..4]);
        assert_eq!(pieces(&[4, 2, 1], 2), [0..0, 0..0, 0..1]);
        assert!(pieces(&[0, 0], 1).is_empty());
    }

    /// A wavy sheet of triangles and layers of nodes above it. The lowest two layers are close to it.
    struct Example {
        surface: Vec<Vector>,
        facets: Vec<[u32; 3]>,
        residuals: Vec<f64>,
        fade_radius: Vec<f64>,
        nodes: Vec<Vector>,
    }

    const SIDE: usize = 30;
    const LAYER: usize = 40;
    const N_LAYER: usize = LAYER * LAYER;
    const N_LAYERS: usize = 11;
    const N_MODES: usize = 3;

    impl Example {
        /// Numbers nodes from layer to layer (`upward`), or from column to column.
        fn new(upward: bool) -> Self {
            let height = |x: f64, y: f64| 0.1 * (5.0 * x).sin() * (3.0 * y).cos();
            let corner = |i: usize, j: usize| (i * SIDE + j) as u32;
            let mut facets = Vec::new();
            for (i, j) in (0..SIDE - 1).flat_map(|i| (0..SIDE - 1).map(move |j| (i, j))) {
                let (a, b) = (corner(i, j), corner(i + 1, j));
                facets.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
            let n = SIDE * SIDE;
            let surface = |at: usize| {
                let (x, y) = ((at / SIDE) as f64 / 29.0, (at % SIDE) as f64 / 29.0);
                [x, y, height(x, y)]
            };
            let node = |at: usize| {
                let (k, at) = if upward {
                    (at / N_LAYER, at % N_LAYER)
                } else {
                    (at % N_LAYERS, at / N_LAYERS)
                };
                let (x, y) = (
                    (at / LAYER) as f64 / 38.0 - 0.01,
                    (at % LAYER) as f64 / 38.0,
                );
                [
                    x,
                    y,
                    height(x, y) + if k < 2 { 0.02 } else { 0.1 } * k as f64,
                ]
            };
            Self {
                surface: (0..n).map(surface).collect(),
                facets,
                residuals: (0..N_MODES * n).map(|i| (i as f64).sin() * 1e-3).collect(),
                fade_radius: (0..n).map(|i| 0.03 + 0.02 * (i as f64).cos()).collect(),
                nodes: (0..N_LAYERS * N_LAYER).map(node).collect(),
            }
        }

        fn with_correction<T>(&self, work: impl FnOnce(&Correction<'_>) -> T) -> T {
            let fading = Fading::new(&self.surface, &self.facets, self.fade_radius.clone());
            work(&Correction::fading(fading, &self.residuals, N_MODES))
        }

        /// Returns the nodes of a rank. If they are numbered upward, the first rank has all nodes near the surface.
        fn part(&self, ranks: &Ranks) -> Range<usize> {
            let start = |rank: usize| self.nodes.len() * rank / ranks.n();
            start(ranks.rank())..start(ranks.rank() + 1)
        }
    }

    /// Some numbers, including zeros of both signs.
    fn numbers(n: usize) -> Vec<f64> {
        let number = |i: usize| match i % 5 {
            0 => 0.0,
            1 => -0.0,
            _ => (i as f64 * 0.7).sin(),
        };
        (0..n).map(number).collect()
    }

    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    /// Every third node but the first of each hundred.
    fn some(n: usize) -> Vec<u32> {
        let nodes = (0..n as u32).step_by(3);
        nodes.filter(|node| node % 100 > 0).collect()
    }

    fn field(nodes: Option<Vec<u32>>, n_nodes: usize) -> Field {
        Field {
            values: numbers(N_MODES * nodes.as_ref().map_or(n_nodes, Vec::len)),
            nodes,
            n_modes: N_MODES,
        }
    }

    #[test]
    fn ranks_add_the_correction_of_one_to_a_field() {
        for (upward, are_some) in [(true, false), (false, false), (true, true), (false, true)] {
            let example = Example::new(upward);
            for n in [1, 2, 3, 5] {
                let found = on_threads(n, |ranks| {
                    let part = &example.nodes[example.part(&ranks)];
                    let nodes = are_some.then(|| some(part.len()));
                    let mut wanted = field(nodes.clone(), part.len());
                    let mut found = wanted.clone();
                    let before = bits(&found.values);
                    example.with_correction(|correction| {
                        correction.add_to(&mut wanted, part);
                        add_correction(correction, &mut found, part, &ranks);
                    });
                    assert_eq!(bits(&found.values), bits(&wanted.values), "{n} ranks");
                    bits(&found.values) != before
                });
                let wanted: Vec<bool> = (0..n).map(|rank| !upward || rank == 0).collect();
                assert_eq!(found, wanted);
            }
        }
    }

    #[test]
    fn ranks_add_to_positions_what_one_adds_through_a_field_of_zeros() {
        for (upward, are_some) in [(true, false), (false, false), (true, true), (false, true)] {
            let example = Example::new(upward);
            for n in [1, 2, 3, 5] {
                on_threads(n, |ranks| {
                    let before = &example.nodes[example.part(&ranks)];
                    let nodes = are_some.then(|| some(before.len()));
                    let mut wanted = numbers(3 * before.len());
                    let mut found = wanted.as_chunks::<3>().0.to_vec();
                    let mut zeros = field(nodes.clone(), before.len());
                    zeros.values.fill(0.0);
                    example.with_correction(|correction| {
                        correction.add_to(&mut zeros, before);
                        add_faded(correction, before, nodes.as_deref(), &mut found, &ranks);
                    });
                    for (row, added) in zeros.values.chunks(3).enumerate() {
                        let node = nodes.as_ref().map_or(row, |nodes| nodes[row] as usize);
                        for (x, added) in wanted[3 * node..].iter_mut().zip(added) {
                            *x += added;
                        }
                    }
                    assert_eq!(bits(found.as_flattened()), bits(&wanted), "{n} ranks");
                });
            }
        }
    }

    #[test]
    fn ranks_correct_as_many_nodes_each() {
        let example = Example::new(true);
        let found = on_threads(3, |ranks| {
            let part = &example.nodes[example.part(&ranks)];
            ranks.set_label("correction");
            let mut found = field(None, part.len());
            example.with_correction(|correction| {
                add_correction(correction, &mut found, part, &ranks);
            });
            let sent = ranks.sent_by_all();
            let rows = Rows {
                points: part,
                nodes: None,
            };
            let n_near = example
                .with_correction(|correction| rows.near(correction))
                .len();
            (n_near, sent)
        });
        let near: Vec<usize> = found.iter().map(|(n, _)| *n).collect();
        assert!(near[0] > 2000 && near[1..] == [0, 0], "{near:?}");
        let sent = &found[0].1;
        let sent = (sent.iter().find(|sent| sent.what == "correction")).expect("it is counted");
        // Two of three positions are sent, and their corrections return: a row number and three values.
        let places = (near[0] - near[0] / 3) as u64 * 24;
        let least = places + places / 24 * 20;
        assert!(sent.most > places && sent.bytes < places + places / 24 * 28 + 200);
        assert!(sent.bytes > least, "{sent:?}, {places}");
    }

    #[test]
    fn nothing_is_added_where_nothing_fades() {
        let mut example = Example::new(true);
        example.fade_radius.fill(0.0);
        on_threads(2, |ranks| {
            let part = &example.nodes[example.part(&ranks)];
            let mut found = field(None, part.len());
            let before = bits(&found.values);
            example.with_correction(|correction| {
                add_correction(correction, &mut found, part, &ranks);
            });
            assert_eq!(bits(&found.values), before);
        });
    }
}
