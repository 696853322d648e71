//! Points at which sliding planes meet other boundaries.

use super::patches::Patches;
use azimesh_core::geometry::vector::Vector;

impl Patches {
    /// Points of planar patches for which `sliding` does not hold, with the normal of each plane; each once.
    pub fn rims(&self, sliding: &[bool]) -> Vec<(u32, Vector)> {
        let mut found: Vec<(u32, u32)> = Vec::new();
        for (facet, &patch) in self.own().iter().zip(&self.patch) {
            if self.planes[patch as usize].is_some() {
                let held = facet.iter().filter(|&&point| !sliding[point as usize]);
                found.extend(held.map(|&point| (point, patch)));
            }
        }
        found.sort_unstable();
        found.dedup();
        let with_normal = |(point, patch): (u32, u32)| Some((point, self.planes[patch as usize]?));
        found.into_iter().filter_map(with_normal).collect()
    }
}
