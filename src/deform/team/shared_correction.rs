//! The correction of fields, shared by places: each rank corrects the nodes around some patches of the surface, as many as the
//! others do, whichever rank evaluates fields at them.
//!
//! ```text
//! every rank       the patch of each of its nodes that is near the surface: how many there are of each
//! the first        which patches each rank takes, and the surface near them
//! every rank       the places of its nodes, to the ranks that take their patches; what these add, back
//! ```

use super::near_surface::{self, WholeSurface};
use crate::geometry::Bounds;
use crate::geometry::boxes::Boxes;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::Ranks;
use crate::rbf::correct::Added;

/// Nodes that are looked at by one task.
const BLOCK: usize = 1 << 14;
/// Nodes that follow each other in the mesh are near each other: so many are looked at together first.
const FEW: usize = 32;

/// The nodes of a rank that are near the surface.
struct Near {
    /// The row of each and its patch, by ascending rows.
    rows: Vec<[u32; 2]>,
}

/// What is corrected at nodes of a rank, by rows.
pub(super) trait Corrected: Sync {
    /// How many rows there are.
    fn n_rows(&self) -> usize;
    /// Where the node of a row was before it was moved.
    fn place(&self, row: usize) -> Vector;
    /// Adds the correction of a layer; `row` gives the row of each number in it.
    fn add(&mut self, layer: usize, added: &Added, row: &dyn Fn(usize) -> u32);
}

/// Where all nodes of a rank are, which are moved.
pub(super) struct Moved<'a> {
    /// Where they were before that.
    pub before: &'a [Vector],
    /// Those that move, ascending; none for all.
    pub moved: Option<&'a [u32]>,
    pub places: &'a mut [Vector],
}

impl Moved<'_> {
    /// Adds 0.0 to the coordinates of the nodes that move.
    pub fn add_zero(&mut self) {
        let add = |x: &mut Vector| *x = x.map(|x| x + 0.0);
        match self.moved {
            None => parallel::update(self.places, |_, x| add(x)),
            Some(moved) => (moved.iter()).for_each(|&at| add(&mut self.places[at as usize])),
        }
    }

    fn node(&self, row: usize) -> usize {
        self.moved.map_or(row, |moved| moved[row] as usize)
    }
}

impl Corrected for Moved<'_> {
    fn n_rows(&self) -> usize {
        self.moved.map_or(self.places.len(), <[u32]>::len)
    }

    fn place(&self, row: usize) -> Vector {
        self.before[self.node(row)]
    }

    fn add(&mut self, _: usize, added: &Added, row: &dyn Fn(usize) -> u32) {
        let moved = self.moved;
        let node = |row: usize| moved.map_or(row as u32, |moved| moved[row]);
        let places = self.places.as_flattened_mut();
        added.add_to(places, 3, |at| node(row(at as usize) as usize));
    }
}

/// Corrects what is at nodes of each rank; the first has the whole surface. All ranks do it at once.
pub(super) fn correct(
    mut fields: impl Corrected,
    boxes: Boxes,
    whole: Option<&WholeSurface<'_>>,
    ranks: &Ranks,
) {
    let near = ranks.together(|| Near::find(&fields, &boxes));
    let starts = ranks.broadcast(
        (ranks.gather(near.counts(boxes.len()))).map(|counts| starts_of(&counts, ranks.n())),
    );
    let of_rank = near.by_rank(&starts);
    let place = |row: u32| fields.place(row as usize);
    let places = |rows: &Vec<u32>| parallel::collect(rows.len(), |i| place(rows[i]));
    let asked = ranks.exchange(of_rank.iter().map(places).collect());
    let mut facets = whole.map(|whole| whole.near_each(&boxes, &starts));
    let surface = ranks.scatter(&mut |rank| {
        let facets = std::mem::take(&mut facets.as_mut()?[rank]);
        Some(whole?.some(&facets))
    });
    let added = ranks.together(|| surface.added_at(&asked));
    drop(asked);
    let added = ranks.exchange_values(added);
    for (rows, layers) in of_rank.iter().zip(added) {
        for (layer, added) in layers.iter().enumerate() {
            fields.add(layer, added, &|at| rows[at]);
        }
    }
}

impl Near {
    fn find(fields: &impl Corrected, boxes: &Boxes) -> Self {
        let rows = parallel::concat_blocks(fields.n_rows(), BLOCK, &|rows| {
            let (mut found, mut last) = (Vec::new(), None);
            let mut places = [[0.0; 3]; FEW];
            for start in rows.clone().step_by(FEW) {
                let few = start..rows.end.min(start + FEW);
                let places = &mut places[..few.len()];
                for (row, place) in few.clone().zip(&mut *places) {
                    *place = fields.place(row);
                }
                // Most nodes are far from all patches.
                if !boxes.any_meets(&Bounds::around(&*places), last) {
                    continue;
                }
                for (row, place) in few.zip(&*places) {
                    if let Some(patch) = boxes.one_around(place, last) {
                        found.push([row as u32, patch as u32]);
                        last = Some(patch);
                    }
                }
            }
            found
        });
        Self { rows }
    }

    /// How many there are around each patch.
    fn counts(&self, n_patches: usize) -> Vec<u32> {
        let mut counts = vec![0; n_patches];
        for [_, patch] in &self.rows {
            counts[*patch as usize] += 1;
        }
        counts
    }

    /// The rows of those around the patches of each rank.
    fn by_rank(self, starts: &[u32]) -> Vec<Vec<u32>> {
        let mut each = vec![Vec::new(); starts.len() - 1];
        for [row, patch] in self.rows {
            each[near_surface::rank_of(starts, patch)].push(row);
        }
        each
    }
}

/// The first patch of each rank, and the end of those of the last, from how many nodes each rank has around each patch: as
/// many for each rank as can be.
fn starts_of(counts: &[Vec<u32>], n_ranks: usize) -> Vec<u32> {
    let n_patches = counts.first().map_or(0, Vec::len);
    let of_patch = |patch: usize| counts.iter().map(|of| u64::from(of[patch])).sum::<u64>();
    let mut before = vec![0];
    for patch in 0..n_patches {
        before.push(before[patch] + of_patch(patch));
    }
    let all = before[n_patches];
    let start = |rank: usize| {
        let share = all * rank as u64 / n_ranks as u64;
        before.partition_point(|&before| before < share) as u32
    };
    let mut starts: Vec<u32> = (0..n_ranks).map(start).collect();
    starts.push(n_patches as u32);
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_have_as_many_nodes_as_patches_allow() {
        let counts = [vec![0, 5, 5, 0, 0, 10], vec![10, 0, 0, 0, 0, 0]];
        assert_eq!(starts_of(&counts, 1), [0, 6]);
        assert_eq!(starts_of(&counts, 2), [0, 2, 6]);
        assert_eq!(starts_of(&counts, 3), [0, 1, 3, 6]);
        assert_eq!(starts_of(&[vec![], vec![]], 2), [0, 0, 0]);
    }
}
