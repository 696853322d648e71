//! Tags that contradict the schedule: fixed ones that move with a body, and moving ones that the mesh does not follow.

use azimesh_core::error::counted;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, scale, sub};
use azimesh_core::numbers::{in_digits, with_verb};
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use azimesh_deform::motion::{BodyMap, Role};
use azimesh_io::mesh::{Group, Numbering};
use std::collections::BTreeMap;

/// Displacements and distances from a plane below this part of the extent of the mesh are round-off.
const ROUND_OFF: f64 = 1e-9;

/// The nodes of a fixed tag that a body moves.
#[derive(Default)]
struct Moved {
    nodes: Vec<u32>,
    n_faces: usize,
    n_shared: usize,
    distance: f64,
    step: usize,
    /// The distance of a node from the plane of the tag.
    out: f64,
}

/// Returns a warning for each fixed tag and body that moves nodes of it.
pub(super) fn fixed_that_move(plan: &Plan) -> Vec<Note> {
    let roles = plan.motion.surface.tags.iter().map(|tag| tag.role);
    let tags: Vec<(&Group, Option<Role>)> = plan.boundary.boundary_tags().zip(roles).collect();
    let (nodes, bodies) = moving_nodes(plan);
    let numbering = Numbering::new(&nodes);
    let body_of = |node: u32| Some(bodies[numbering.place(node)?]);
    let fixed = tags.iter().filter(|(_, role)| *role == Some(Role::Fixed));
    let moving = tags.iter().filter_map(|(tag, role)| match role {
        Some(Role::Moving(body)) => Some(tag.cells.iter().map(|cell| (cell, *body))),
        _ => None,
    });
    let mut moving: Vec<(usize, u16)> = moving.flatten().collect();
    moving.sort_unstable();
    let least = ROUND_OFF * plan.boundary.extent.diagonal();
    let mut notes = Vec::new();
    for (tag, _) in fixed {
        let (all_nodes, mut found) = moved_nodes(plan, tag, &body_of, &moving);
        measure(plan, tag, least, &mut found);
        let found = found
            .into_iter()
            .filter(|(_, moved)| moved.distance > least);
        notes.extend(found.map(|(body, moved)| {
            let body = &plan.motion.bodies[usize::from(body)].name;
            fixed_moves(tag, body, &moved, all_nodes, moved.out <= least)
        }));
    }
    notes
}

/// Returns a note on a fixed tag with nodes that move with a body.
fn fixed_moves(tag: &Group, body: &str, moved: &Moved, all_nodes: usize, may_slide: bool) -> Note {
    let (n_nodes, n_faces, all_faces) = (moved.nodes.len(), moved.n_faces, tag.cells.len());
    let faces = match (n_faces, moved.n_shared) {
        (0, _) => String::new(),
        (n, 0) => format!("; {} move as a whole", of(n, all_faces, "face")),
        (n, shared) => format!(
            "; {} move as a whole, and {} on tags of the body too",
            of(n, all_faces, "face"),
            with_verb(shared, "face", "is")
        ),
    };
    let remedy = if 2 * n_faces > all_faces {
        "; most of this tag is not fixed: give it to the body, or take its faces out of the tags of the body"
    } else if may_slide {
        "; they stay in the plane of that tag, which could be in `slide`"
    } else {
        ""
    };
    let note = note!(
        "fixed_moves",
        "{} of tag \"{}\", which is fixed, {} with body \"{body}\", by up to {} (step {}), since they are on its tags \
         too{faces}{remedy}",
        of(n_nodes, all_nodes, "node"),
        tag.name,
        if n_nodes == 1 { "moves" } else { "move" },
        in_digits(moved.distance, 3),
        moved.step
    );
    note.with("nodes", n_nodes)
        .with("faces", n_faces)
        .with("shared", moved.n_shared)
}

/// Formats `3 of the 40 nodes`.
fn of(some: usize, all: usize, what: &str) -> String {
    format!("{some} of the {}", counted(all, what))
}

/// Returns the moving nodes, ascending, each with its body.
fn moving_nodes(plan: &Plan) -> (Vec<u32>, Vec<u16>) {
    let surface = &plan.motion.surface.nodes;
    let nodes = surface.nodes.iter().zip(&surface.roles);
    let body = |(&node, role): (&u32, &Role)| match role {
        Role::Moving(body) => Some((node, *body)),
        Role::Fixed | Role::Sliding => None,
    };
    nodes.filter_map(body).unzip()
}

/// Returns the number of nodes of a tag, and the nodes of it that move with each body; `moving` has the cells of tags that
/// move with a body, ascending.
fn moved_nodes(
    plan: &Plan,
    tag: &Group,
    body_of: &impl Fn(u32) -> Option<u16>,
    moving: &[(usize, u16)],
) -> (usize, BTreeMap<u16, Moved>) {
    let mut found: BTreeMap<u16, Moved> = BTreeMap::new();
    let mut nodes = Vec::new();
    for cell in tag.cells.iter() {
        let face = plan.boundary.face(cell).nodes;
        nodes.extend_from_slice(face);
        let body = body_of(face[0]);
        if let Some(body) = body.filter(|_| face.iter().all(|&node| body_of(node) == body)) {
            let moved = found.entry(body).or_default();
            moved.n_faces += 1;
            moved.n_shared += usize::from(moving.binary_search(&(cell, body)).is_ok());
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    for &node in &nodes {
        if let Some(body) = body_of(node) {
            found.entry(body).or_default().nodes.push(node);
        }
    }
    (nodes.len(), found)
}

/// Measures the largest displacement of the nodes, and the largest out of the plane of their tag.
fn measure(plan: &Plan, tag: &Group, least: f64, found: &mut BTreeMap<u16, Moved>) {
    if found.is_empty() {
        return;
    }
    let normal = plane_of(plan, tag, least);
    let steps = &plan.motion.steps;
    for step in steps {
        let poses: Vec<BodyMap<'_>> = plan.motion.poses(step, 1.0);
        for (body, moved) in &mut *found {
            for &node in &moved.nodes {
                let x = plan.boundary.position(node);
                let by = sub(poses[usize::from(*body)].place(node, x), x);
                if norm(by) > moved.distance {
                    (moved.distance, moved.step) = (norm(by), step.index());
                }
                let out = normal.map_or(f64::INFINITY, |normal| dot(by, normal).abs());
                moved.out = moved.out.max(out);
            }
        }
    }
}

/// Returns the normal of the plane of the faces of a tag, within `least`, in space; `None` if they are not in one plane.
fn plane_of(plan: &Plan, tag: &Group, least: f64) -> Option<Vector> {
    let nodes = || plan.boundary.nodes_of(tag);
    let origin = plan.boundary.position(nodes().next()?);
    let along = |node: u32| sub(plan.boundary.position(node), origin);
    let far = nodes()
        .map(along)
        .reduce(|a, b| if norm(b) > norm(a) { b } else { a })?;
    let areas = nodes().map(|node| cross(far, along(node)));
    let normal = if plan.boundary.dimension() == 3 {
        areas.reduce(|a, b| if norm(b) > norm(a) { b } else { a })?
    } else {
        [-far[1], far[0], 0.0]
    };
    let normal = scale(normal, 1.0 / norm(normal));
    // Not finite if the tag has no area.
    let is_flat = nodes().all(|node| dot(along(node), normal).abs() <= least);
    is_flat.then_some(normal)
}

/// Returns a warning for each moving tag with faces on no cell, if the mesh has cells.
pub(super) fn on_no_cell(plan: &Plan) -> Vec<Note> {
    if plan.boundary.n_volume_cells() == 0 {
        return Vec::new();
    }
    let loose = &plan.loose_faces;
    let roles = plan.motion.surface.tags.iter().map(|tag| tag.role);
    let moving = plan.boundary.boundary_tags().zip(roles);
    let moving = moving.filter(|(_, role)| matches!(role, Some(Role::Moving(_))));
    let notes = moving.filter_map(|(tag, _)| {
        let own = loose
            .iter()
            .copied()
            .filter(|&face| tag.cells.contains(face as usize));
        let own: Vec<u32> = own.collect();
        let first = *own.first()?;
        Some(note!(
            "faces_on_no_cell",
            "{} of tag \"{}\", which moves, {} on no cell, the first is cell {first}: they move, and no cell of the mesh \
             follows them",
            of(own.len(), tag.cells.len(), "face"),
            tag.name,
            if own.len() == 1 { "is" } else { "are" }
        ))
    });
    notes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::plan_of;
    use azimesh_io::mesh::{CellKind, CellSet, Mesh};

    fn plan(mesh: Mesh, boundaries: &str, tags: &str) -> Plan {
        let text = format!(
            "azimuth.values = [0, 90]\nboundaries = {{ {boundaries} }}\nrbf.support_radius = 10.0\nselection.tolerance = 1e-2\n\
             body = [ {{ name = \"it\", tags = [{tags}], rigid.translate = [0.1, 0, 0] }} ]\n"
        );
        plan_of(mesh, &text)
    }

    /// Returns the airfoil; its faces behind x = 0.45 are also in the tag "flap", or only there.
    fn with_flap(overlaps: bool) -> Mesh {
        let mut mesh = Mesh::read("testdata/naca0012.vtu").expect("it is good");
        let at = mesh.groups.iter().position(|group| group.name == "airfoil");
        let wing = &mesh.groups[at.expect("it has the tag")];
        let behind = |cell: &usize| {
            let nodes = mesh.cells.get(*cell).nodes;
            nodes
                .iter()
                .all(|&node| mesh.points[node as usize][0] > 0.45)
        };
        let mut flap = wing.clone();
        flap.name = "flap".into();
        flap.number = None;
        flap.cells = wing.cells.iter().filter(behind).collect::<CellSet>();
        let rest: CellSet = wing.cells.iter().filter(|cell| !behind(cell)).collect();
        if !overlaps {
            mesh.groups[at.expect("it has the tag")].cells = rest;
        }
        mesh.groups.push(flap);
        mesh
    }

    /// Returns nodes, faces and shared faces of the only note, and its text.
    fn told(notes: &[Note]) -> ([u64; 3], &str) {
        assert_eq!(
            (notes.len(), &*notes[0].code),
            (1, "fixed_moves"),
            "{notes:?}"
        );
        let number = |key| notes[0].get(key).as_u64().expect("a number");
        (["nodes", "faces", "shared"].map(number), &notes[0].text)
    }

    #[test]
    fn nodes_of_a_fixed_wall_that_move_with_a_body_are_told_of() {
        let walls = "fixed = [\"farfield\", \"airfoil\"]";
        let beside = plan(with_flap(false), walls, "\"flap\"");
        let notes = fixed_that_move(&beside);
        let (counts, text) = told(&notes);
        assert!(counts == [2, 0, 0] && !text.contains("slide"), "{text}");
        let over = plan(with_flap(true), walls, "\"flap\"");
        let notes = fixed_that_move(&over);
        let ([nodes, faces, shared], text) = told(&notes);
        assert!(nodes > 2 && faces > 1 && shared == faces, "{text}");
        let others = plan(with_flap(true), "others = \"fixed\"", "\"airfoil\"");
        let notes = fixed_that_move(&others);
        let ([nodes, faces, _], text) = told(&notes);
        assert!(text.starts_with(&format!("{nodes} of the {nodes} nodes ")));
        assert!(text.contains(&format!("{faces} of the {faces} faces ")));
        assert!(
            text.contains(
                "tag \"flap\", which is fixed, move with body \"it\", by up to 0.1 (step 0)"
            ),
            "{text}"
        );
        assert!(
            text.ends_with("give it to the body, or take its faces out of the tags of the body"),
            "{text}"
        );
    }

    #[test]
    fn fixed_walls_that_stay_are_not_told_of() {
        let both = plan(
            with_flap(true),
            "others = \"fixed\"",
            "\"airfoil\", \"flap\"",
        );
        assert_eq!(fixed_that_move(&both), []);
        let alone = Mesh::read("testdata/naca0012.vtu").expect("it is good");
        assert_eq!(
            fixed_that_move(&plan(alone, "others = \"fixed\"", "\"airfoil\"")),
            []
        );
    }

    #[test]
    fn a_wall_in_a_plane_that_its_moving_nodes_do_not_leave_may_slide() {
        let mesh = Mesh::read("testdata/wing_on_plane.vtu").expect("it is good");
        let notes = fixed_that_move(&plan(mesh.clone(), "others = \"fixed\"", "\"wing\""));
        let ([nodes, faces, _], text) = told(&notes);
        assert!(nodes > 2 && faces == 0, "{text}");
        assert!(text.ends_with("could be in `slide`"), "{text}");
        let slides = plan(
            mesh,
            "fixed = [\"farfield\"], slide = [\"symmetry\"]",
            "\"wing\"",
        );
        assert_eq!(fixed_that_move(&slides), []);
    }

    #[test]
    fn moving_faces_on_no_cell_are_told_of() {
        let mut mesh = Mesh::read("testdata/naca0012.vtu").expect("it is good");
        let good = plan(mesh.clone(), "others = \"fixed\"", "\"airfoil\"");
        assert_eq!(on_no_cell(&good), []);
        let face = mesh.cells.len();
        mesh.cells
            .push(CellKind::Line, &[0, mesh.points.len() as u32 - 1]);
        mesh.cell_arrays.clear();
        let at = mesh.groups.iter().position(|group| group.name == "airfoil");
        mesh.groups[at.expect("it has the tag")].cells.push(face);
        let n = mesh.groups[at.expect("it has the tag")].cells.len();
        let notes = on_no_cell(&plan(mesh, "others = \"fixed\"", "\"airfoil\""));
        assert_eq!((notes.len(), &*notes[0].code), (1, "faces_on_no_cell"));
        let start = format!(
            "1 of the {n} faces of tag \"airfoil\", which moves, is on no cell, the first is cell {face}:"
        );
        assert!(notes[0].text.starts_with(&start), "{notes:?}");
    }
}
