//! A surface continued by its periodic images: copies of facets, joined to the surface where points are images of one another.

use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::parallel;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Points this near, as a part of the extent of the surface, are one point.
const SAME: f64 = 4e-6;

/// The periodic images of a surface.
#[derive(Debug, Clone, Default)]
pub struct Images {
    /// The maps, without the identity: with a map its inverse.
    pub maps: Arc<Vec<Transform>>,
    /// For each surface point the lowest point that it is an image of; its own index if there is none. Empty without maps.
    pub leaders: Vec<u32>,
}

/// A surface followed by images of some of its facets.
#[derive(Debug, Clone)]
pub struct Continued<'a> {
    /// The points of the surface, then the points of the images.
    pub points: Cow<'a, [Vector]>,
    /// The facets of the surface, then the images.
    pub facets: Cow<'a, [[u32; 3]]>,
    /// The facet that each image is of.
    pub of_facets: Vec<u32>,
    /// The point that each added point is an image of, and its map.
    pub added: Vec<(u32, Transform)>,
    n_points: usize,
}

impl Images {
    /// Continues a surface by the images of facets that touch it.
    pub fn around<'a>(&self, points: &'a [Vector], facets: &'a [[u32; 3]]) -> Continued<'a> {
        let mut all = Joined::new(self, points, facets);
        let is_on_axis = |x: Vector| {
            let mut maps = self.maps.iter();
            maps.any(|map| distance(map.apply(x), x) <= all.tolerance)
        };
        let n_points = if self.maps.is_empty() {
            0
        } else {
            points.len()
        };
        let may_touch = parallel::collect(n_points, |at| {
            all.known.contains_key(&self.leaders[at]) || is_on_axis(points[at])
        });
        for map in self.maps.iter() {
            let near = |at: &usize| facets[*at].iter().any(|&corner| may_touch[corner as usize]);
            for at in (0..facets.len()).filter(near) {
                let mut found = facets[at].iter().map(|&corner| all.find(corner, map));
                if found.any(|at| at.is_some_and(|at| (at as usize) < n_points)) {
                    all.add(at, map);
                }
            }
        }
        all.continued
    }

    /// Continues a surface by the images of facets that reach into a box.
    pub fn within<'a>(
        &self,
        points: &'a [Vector],
        facets: &'a [[u32; 3]],
        within: &Bounds,
    ) -> Continued<'a> {
        let mut all = Joined::new(self, points, facets);
        for map in self.maps.iter() {
            let reaching = parallel::filter_map(facets.len(), |at| {
                let corners = facets[at].map(|i| map.apply(points[i as usize]));
                Bounds::around(&corners).meets(within).then_some(at)
            });
            reaching.into_iter().for_each(|at| all.add(at, map));
        }
        all.continued
    }
}

/// A surface while images are joined to it.
struct Joined<'a, 'b> {
    images: &'b Images,
    continued: Continued<'a>,
    /// The points that are images of each other, by their leader; of others their images alone.
    known: BTreeMap<u32, Vec<u32>>,
    tolerance: f64,
}

impl<'a, 'b> Joined<'a, 'b> {
    fn new(images: &'b Images, points: &'a [Vector], facets: &'a [[u32; 3]]) -> Self {
        let mut known: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (&leader, at) in images
            .leaders
            .iter()
            .zip(0..)
            .filter(|(leader, at)| *leader != at)
        {
            known.entry(leader).or_insert_with(|| vec![leader]).push(at);
        }
        Self {
            images,
            known,
            tolerance: SAME * Bounds::around(points).diagonal(),
            continued: Continued {
                points: points.into(),
                facets: facets.into(),
                of_facets: Vec::new(),
                added: Vec::new(),
                n_points: points.len(),
            },
        }
    }

    /// Finds the point at the image of a point of the surface.
    fn find(&self, point: u32, map: &Transform) -> Option<u32> {
        let points = &self.continued.points;
        let x = map.apply(points[point as usize]);
        let away = |&at: &u32| distance(points[at as usize], x);
        let known = self.known.get(&self.images.leaders[point as usize]);
        let all = known.into_iter().flatten().copied().chain([point]);
        all.min_by(|a, b| away(a).total_cmp(&away(b)))
            .filter(|at| away(at) <= self.tolerance)
    }

    /// Adds the image of a facet.
    fn add(&mut self, facet: usize, map: &Transform) {
        let corners = self.continued.facets[facet].map(|corner| {
            self.find(corner, map).unwrap_or_else(|| {
                let all = &mut self.continued;
                let new = all.points.len() as u32;
                let x = map.apply(all.points[corner as usize]);
                all.points.to_mut().push(x);
                all.added.push((corner, *map));
                let leader = self.images.leaders[corner as usize];
                self.known.entry(leader).or_default().push(new);
                new
            })
        });
        self.continued.facets.to_mut().push(corners);
        self.continued.of_facets.push(facet as u32);
    }
}

impl<'a> Continued<'a> {
    /// Returns a point of the surface: this one, or the one that it is an image of.
    pub fn source(&self, point: usize) -> usize {
        point
            .checked_sub(self.n_points)
            .map_or(point, |added| self.added[added].0 as usize)
    }

    /// Returns values (N, r) at the points of the surface, followed by the values at the images. With images they are
    /// vectors: column `3 m + a` is component `a` of vector `m`.
    pub fn values(&self, values: &'a [f64], n_columns: usize) -> Cow<'a, [f64]> {
        if self.added.is_empty() {
            return values.into();
        }
        let mut all = values.to_vec();
        for (point, map) in &self.added {
            let row = &values[*point as usize * n_columns..][..n_columns];
            let vectors = row.as_chunks::<3>().0.iter();
            all.extend(vectors.flat_map(|vector| map.turn(*vector)));
        }
        all.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of triangles over a quarter of a ring, whose ends are paired.
    fn quarter() -> (Vec<Vector>, Vec<[u32; 3]>, Images) {
        let at = |i: usize, r: f64| {
            let (sin, cos) = (i as f64 * std::f64::consts::FRAC_PI_6).sin_cos();
            [r * cos, r * sin, 0.0]
        };
        let points: Vec<Vector> = (0..4).flat_map(|i| [at(i, 1.0), at(i, 2.0)]).collect();
        let facets = (0..3).flat_map(|i| {
            let a = 2 * i;
            [[a, a + 1, a + 3], [a, a + 3, a + 2]]
        });
        let turn = |n: f64| {
            Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], n * std::f64::consts::FRAC_PI_2)
        };
        let images = Images {
            maps: Arc::new([1.0, 2.0, 3.0].map(turn).to_vec()),
            leaders: vec![0, 1, 2, 3, 4, 5, 0, 1],
        };
        (points, facets.collect(), images)
    }

    #[test]
    fn images_are_joined_to_the_surface_and_to_each_other() {
        let (points, facets, images) = quarter();
        let all = images.within(&points, &facets, &Bounds::around(&points).grown(9.0));
        // The whole ring: 12 sections of two points, two facets each.
        assert_eq!(all.points.len(), 24);
        assert_eq!(all.facets.len(), 24);
        let touching = images.around(&points, &facets);
        assert_eq!(touching.of_facets, [0, 1, 4, 5]);
        assert_eq!(touching.points.len(), 8 + 4);
        assert_eq!(touching.facets[6..8], [[6, 7, 8], [6, 8, 9]]);
    }

    #[test]
    fn values_at_images_are_turned() {
        let (points, facets, images) = quarter();
        let all = images.around(&points, &facets);
        let values: Vec<f64> = points.iter().flatten().copied().collect();
        let all_values = all.values(&values, 3);
        for (value, x) in all_values.as_chunks::<3>().0.iter().zip(all.points.iter()) {
            assert!(distance(*value, *x) < 1e-15);
        }
        assert_eq!(all.source(3), 3);
        assert_eq!(all.source(8), 3);
    }
}
