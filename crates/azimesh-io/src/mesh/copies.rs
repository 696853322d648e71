//! Completes a mesh: a half by its mirror image, a sector by copies around an axis.

use super::join::{JoinCounts, RELATIVE_DISTANCE};
use super::transform::Turned;
use super::{Faces, Group, Mesh, too_many};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::Transform;
use azimesh_core::numbers::{point, short, with_verb};
use std::collections::BTreeSet;

/// Largest distance of nodes of a symmetry tag from its plane, relative to the extent of the tag.
const NEAR_PLANE: f64 = 1e-2;

/// More copies are tried with two first.
const MANY_COPIES: usize = 8;

/// A plane normal to an axis of coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Number of the axis, 0 to 2.
    pub axis: usize,
    /// Position on the axis.
    pub at: f64,
}

impl Plane {
    /// Returns the reflection across the plane.
    fn mirror(&self) -> Transform {
        let mut mirror = Transform::IDENTITY;
        mirror.rotation[self.axis][self.axis] = -1.0;
        mirror.translation[self.axis] = 2.0 * self.at;
        mirror
    }

    fn name(&self) -> String {
        format!("{} = {}", ["x", "y", "z"][self.axis], short(self.at))
    }
}

impl Mesh {
    /// Returns the default joining distance.
    pub fn join_distance(&self) -> f64 {
        RELATIVE_DISTANCE * Bounds::around(&self.points).diagonal()
    }

    /// Adds the mirror image of the mesh. Nodes at most `distance` from the plane are put on it and shared by both halves; boundary faces
    /// between the halves are removed with their tags. A suffix gives the boundary tags of the image their own names.
    ///
    /// # Errors
    /// If the mesh is on both sides of the plane or does not touch it, a symmetry tag has nodes off the plane, or a cell would become flat.
    pub fn mirror(
        &mut self,
        plane: Plane,
        suffix: Option<&str>,
        distance: f64,
    ) -> Result<(JoinCounts, Turned)> {
        let off = |point: &[f64; 3]| point[plane.axis] - plane.at;
        self.check_half(plane, distance)?;
        let used = self.nodes_of_cells();
        let is_on: Vec<bool> = (self.points.iter().zip(&used))
            .map(|(point, used)| *used && off(point).abs() <= distance)
            .collect();
        self.check_symmetry_tags(plane, &is_on)?;
        for (point, _) in self.points.iter_mut().zip(&is_on).filter(|(_, on)| **on) {
            point[plane.axis] = plane.at;
        }
        let mut image = self.clone();
        image.cells = self.cells.mirrored()?;
        let turned = image.transform(&plane.mirror());
        for (point, _) in image.points.iter_mut().zip(&is_on).filter(|(_, on)| **on) {
            point[plane.axis] = plane.at;
        }
        if let Some(suffix) = suffix {
            let dimension = self.dimension();
            image.rename_groups(|group| match group.dimension < dimension {
                true => format!("{}{suffix}", group.name),
                false => group.name.clone(),
            });
        }
        let n = self.points.len() as u32;
        let own: BTreeSet<String> = self.groups.iter().map(|tag| tag.name.clone()).collect();
        self.append(&image)?;
        drop(image);
        let between = Faces::of(self).between();
        let twins = (0..n).map(|node| if is_on[node as usize] { node } else { n + node });
        let first: Vec<u32> = (0..n).chain(twins).collect();
        let mut counts = self.unite(&first, &between);
        if let Some(suffix) = suffix {
            let is_image = |name: &str| {
                name.strip_suffix(suffix)
                    .is_some_and(|name| own.contains(name))
            };
            counts.tags.retain(|(name, _, _)| !is_image(name));
        }
        Ok((counts, turned))
    }

    /// Refuses a mesh on both sides of a plane or away from it, and cells in the plane.
    fn check_half(&self, plane: Plane, distance: f64) -> Result<()> {
        let used = self.nodes_of_cells();
        let nodes = (0..self.points.len()).filter(|node| used[*node]);
        let off = |node: usize| self.points[node][plane.axis] - plane.at;
        let (mut below, mut above, mut nearest) = ((0, 0.0f64), (0, 0.0f64), None);
        for node in nodes {
            let off = off(node);
            if off < -distance {
                below = (below.0 + 1, below.1.max(-off));
            } else if off > distance {
                above = (above.0 + 1, above.1.max(off));
            }
            if nearest.is_none_or(|(_, least): (usize, f64)| off.abs() < least) {
                nearest = Some((node, off.abs()));
            }
        }
        let [name, join] = [plane.name(), option("join")];
        if below.0 > 0 && above.0 > 0 {
            return Err(Error::input(format!(
                "{}: the mesh is on both sides of {name}: {} below it, up to {} away, {} above it, up to {} away; \
                 {join} D sets how far nodes may be off the plane, now {}",
                option("mirror"),
                with_verb(below.0, "node", "is"),
                short(below.1),
                with_verb(above.0, "node", "is"),
                short(above.1),
                short(distance)
            )));
        }
        if let Some((node, off)) = nearest.filter(|(_, off)| *off > distance) {
            return Err(Error::input(format!(
                "{}: no node is on {name}; the nearest is node {node} at {}, {} away; {join} D sets how far nodes may be off the plane, \
                 now {}",
                option("mirror"),
                point(&self.points[node]),
                short(off),
                short(distance)
            )));
        }
        for run in self.volume_runs() {
            let is_flat = |nodes: &[u32]| {
                nodes
                    .iter()
                    .all(|node| off(*node as usize).abs() <= distance)
            };
            if let Some(cell) = run.cells().position(is_flat) {
                return Err(Error::input(format!(
                    "{}: all nodes of cell {} are on {name}, at most {} off it; mirror across another plane, or set a smaller distance \
                     with {join}",
                    option("mirror"),
                    run.first_cell + cell,
                    short(distance)
                )));
            }
        }
        Ok(())
    }

    /// Refuses symmetry tags with nodes off the plane.
    fn check_symmetry_tags(&self, plane: Plane, is_on: &[bool]) -> Result<()> {
        for tag in self.boundary_tags() {
            let runs = || {
                tag.cells
                    .ranges()
                    .flat_map(|range| self.cells.runs_in(range))
            };
            let is_face_on = |nodes: &&[u32]| nodes.iter().all(|node| is_on[*node as usize]);
            let n_on: usize = runs()
                .map(|run| run.cells().filter(is_face_on).count())
                .sum();
            let mut nodes: Vec<u32> = runs().flat_map(|run| run.connectivity).copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            let touches = nodes.iter().any(|node| is_on[*node as usize]);
            let places = nodes.iter().map(|node| &self.points[*node as usize]);
            let extent = Bounds::around(places).diagonal();
            let off: Vec<u32> = nodes
                .into_iter()
                .filter(|node| !is_on[*node as usize])
                .collect();
            let farthest = off
                .iter()
                .map(|node| (self.points[*node as usize][plane.axis] - plane.at).abs())
                .fold(0.0, f64::max);
            let is_plane = 2 * n_on >= tag.cells.len() || touches && is_symmetry(tag);
            if is_plane && !off.is_empty() && farthest < NEAR_PLANE * extent {
                return Err(Error::input(format!(
                    "{}: {} of tag \"{}\" off {}, up to {} away; {} D sets how far nodes may be off the plane",
                    option("mirror"),
                    with_verb(off.len(), "node", "is"),
                    tag.name,
                    plane.name(),
                    short(farthest),
                    option("join")
                )));
            }
        }
        Ok(())
    }

    /// Completes a sector with `n` copies, the first being the sector itself; `turn` gives their positions. Coincident faces of
    /// copies, with nodes at most `distance` from each other, are joined. Boundary tags get the number of the copy; a tag with faces
    /// of one copy only keeps its name.
    ///
    /// # Errors
    /// If no faces coincide, or only some faces of a tag.
    pub fn repeat(
        &mut self,
        n: usize,
        turn: &dyn Fn(usize) -> Transform,
        distance: f64,
    ) -> Result<(JoinCounts, Turned)> {
        let (n_nodes, dimension) = (self.points.len(), self.dimension());
        if n.saturating_mul(n_nodes) > u32::MAX as usize - 1 {
            return Err(Error::input(format!(
                "{} {n}: copies of {n_nodes} nodes; {}",
                option("repeat"),
                too_many("nodes")
            )));
        }
        let sector = self.clone();
        if n > MANY_COPIES {
            // Sides that do not match are found before all copies are made.
            sector.clone().repeat(2, turn, distance)?;
        }
        let number = |name: &str, copy: usize| format!("{name}_{}", copy + 1);
        let numbered = |mesh: &mut Self, copy: usize| {
            mesh.rename_groups(|group| match group.dimension < dimension {
                true => number(&group.name, copy),
                false => group.name.clone(),
            });
        };
        numbered(self, 0);
        let mut turned = Turned::default();
        for copy in 1..n {
            let mut next = sector.clone();
            turned = next.transform(&turn(copy));
            numbered(&mut next, copy);
            self.append(&next)?;
        }
        let mut counts = self.join_parts(distance, |node| node / n_nodes as u32)?;
        if counts.n_faces == 0 {
            return Err(Error::input(format!(
                "{}: no face of a copy lies on a face of the next within {}; the angle between copies must be that between the periodic sides, \
                 whose nodes lie alike ({} D sets another distance)",
                option("repeat"),
                short(distance),
                option("join")
            )));
        }
        let is_whole = counts.tags.iter().any(|(_, _, left)| *left == 0);
        let is_partly =
            |(_, gone, left): &&(String, usize, usize)| *left > 0 && (gone >= left || !is_whole);
        if let Some((name, gone, left)) = counts.tags.iter().find(is_partly) {
            return Err(Error::input(format!(
                "{}: {gone} of {} faces of tag \"{name}\" lie on faces of another copy and the others do not, within {}; periodic sides need tags of \
                 their own, and the angle between them ({} D sets another distance)",
                option("repeat"),
                gone + left,
                short(distance),
                option("join")
            )));
        }
        let mut tags = Vec::new();
        for group in sector.boundary_tags() {
            let names: Vec<String> = (0..n).map(|copy| number(&group.name, copy)).collect();
            let lost = counts.tags.iter().filter(|(tag, _, _)| names.contains(tag));
            let n_gone: usize = lost.map(|(_, gone, _)| gone).sum();
            let is_copy =
                |own: &&mut Group| own.dimension == group.dimension && names.contains(&own.name);
            let mut left: Vec<&mut Group> = self.groups.iter_mut().filter(is_copy).collect();
            if n_gone > 0 {
                let n_left = left.iter().map(|group| group.cells.len()).sum();
                tags.push((group.name.clone(), n_gone, n_left));
            }
            if let [one] = &mut left[..] {
                one.name.clone_from(&group.name);
            }
        }
        counts.tags = tags;
        Ok((counts, turned))
    }
}

/// Returns whether the condition or the name of a tag is a word for symmetry.
fn is_symmetry(tag: &Group) -> bool {
    let words = [Some(&tag.name), tag.condition.as_ref()];
    let mut words = words.into_iter().flatten();
    words.any(|word| word.to_lowercase().contains("symm"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::cubes::{cubes, shuffled};

    fn mesh(name: &str) -> Mesh {
        Mesh::read(format!("../../testdata/{name}")).expect("it is there")
    }

    const LOW_X: Plane = Plane { axis: 0, at: 0.0 };

    fn names(mesh: &Mesh) -> Vec<&str> {
        mesh.boundary_tags().map(|tag| &*tag.name).collect()
    }

    #[test]
    fn a_half_and_its_image_share_the_nodes_of_the_plane_and_nothing_is_left_of_its_tag() {
        for half in [cubes(4), shuffled(&cubes(4))] {
            let mut whole = half.clone();
            let (counts, _) = whole.mirror(LOW_X, Some("_2"), 1e-9).expect("it is a half");
            whole.validate().expect("it is a mesh");
            assert_eq!(
                (counts.n_nodes, &*counts.tags),
                (25, &[("left".to_owned(), 16, 0)][..])
            );
            assert_eq!(whole.n_repeated_nodes(), 0);
            let (before, after) = (Faces::of(&half), Faces::of(&whole));
            assert_eq!(after.outer.len(), 2 * before.outer.len() - 2 * 16);
            assert_eq!(after.inside.len(), 2 * before.inside.len());
            assert!(names(&whole).contains(&"right_2") && !names(&whole).contains(&"left_2"));
            // Cells of the image list the faces that they share with the half the other way round.
            let adjacency = crate::mesh::Adjacency::of(&whole);
            let first = whole.volume_runs().next().expect("it has cells").first_cell;
            let known = |cell: usize| i8::from(cell == first);
            let signs = crate::mesh::orientations(&whole, &adjacency, &known);
            let volume = whole.volume_runs().flat_map(|run| run.range());
            assert!(volume.into_iter().all(|cell| signs[cell] == 1));
        }
    }

    #[test]
    fn nodes_off_the_plane_are_refused_with_their_number_and_distance() {
        let mut half = cubes(3);
        half.points[4][0] = 2e-5;
        half.points[8][0] = 3e-5;
        let error = half
            .clone()
            .mirror(LOW_X, None, 1e-6)
            .expect_err("two are off")
            .message;
        assert!(
            error.contains("2 nodes are of tag") || error.contains("2 nodes"),
            "{error}"
        );
        assert!(
            error.contains("\"left\"") && error.contains("up to 3e-5 away"),
            "{error}"
        );
        half.mirror(LOW_X, None, 1e-4)
            .expect("they are put on the plane");
        assert!(half.points.iter().filter(|x| x[0] == 0.0).count() == 16);
        let mut thin = cubes(3);
        thin.points.iter_mut().for_each(|x| x[0] *= 1e-3);
        let high = thin.groups.iter_mut().find(|tag| tag.name == "right");
        high.expect("it is there").name = "symmetry".to_owned();
        thin.mirror(LOW_X, None, 1e-9)
            .expect("the other symmetry plane is away");
        let beside = Plane { axis: 0, at: -1.0 };
        let error = cubes(3)
            .mirror(beside, None, 1e-6)
            .expect_err("it is away")
            .message;
        assert!(
            error.contains("no node is on x = -1; the nearest is node 0"),
            "{error}"
        );
        let through = Plane { axis: 0, at: 1.0 };
        let error = cubes(3)
            .mirror(through, None, 1e-6)
            .expect_err("it cuts")
            .message;
        assert!(error.contains("both sides"), "{error}");
    }

    #[test]
    fn a_sector_and_its_copies_are_a_rotor_with_numbered_tags() {
        let sector = mesh("rotor_sector.vtu");
        let quarter = |n: usize| {
            Transform::rotation(
                [0.0, 0.0, 1.0],
                [0.0; 3],
                n as f64 * std::f64::consts::FRAC_PI_2,
            )
        };
        let mut rotor = sector.clone();
        let (counts, _) = rotor.repeat(4, &quarter, 1e-6).expect("it is a quarter");
        rotor.validate().expect("it is a mesh");
        let tags = [("side_a".to_owned(), 308, 0), ("side_b".to_owned(), 308, 0)];
        assert_eq!((counts.n_faces, &*counts.tags), (308, &tags[..]));
        assert_eq!(rotor.points.len(), 4 * sector.points.len() - counts.n_nodes);
        assert_eq!(Faces::of(&rotor).bare().count(), 0);
        assert!(names(&rotor).starts_with(&["blade_1", "hub_wall_1"]));
        // Two of four copies are open: each side is that of one copy and keeps its name.
        let mut half = sector.clone();
        half.repeat(2, &quarter, 1e-6).expect("it is a quarter");
        assert!(names(&half).contains(&"side_a") && names(&half).contains(&"side_b"));
        let wrong = |n: usize| Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], n as f64);
        let error = sector
            .clone()
            .repeat(4, &wrong, 1e-6)
            .expect_err("it is another angle")
            .message;
        assert!(error.contains("no face of a copy"), "{error}");
        let mut bent = sector.clone();
        let node = bent.tag_nodes("side_a").expect("it is there")[5] as usize;
        bent.points[node][2] += 1e-3;
        let error = bent
            .repeat(4, &quarter, 1e-6)
            .expect_err("a node is off")
            .message;
        assert!(
            error.contains("of tag \"side_a_1\"") && error.contains("not, within"),
            "{error}"
        );
    }

    #[test]
    fn curved_halves_are_joined_with_all_nodes_of_the_plane() {
        for name in [
            "curved_solids_complete_v22.msh",
            "curved_solids_serendipity_v22.msh",
        ] {
            let half = mesh(name);
            let [low, _] = half.bounds().expect("it has nodes");
            let mut whole = half.clone();
            let plane = Plane {
                axis: 0,
                at: low[0],
            };
            let (counts, _) = whole.mirror(plane, None, 1e-9).expect("it is on one side");
            whole.validate().expect("it is a mesh");
            let n_on = half.points.iter().filter(|x| x[0] == low[0]).count();
            assert_eq!(
                (counts.n_nodes, whole.n_repeated_nodes()),
                (n_on, 0),
                "{name}"
            );
        }
    }
}
