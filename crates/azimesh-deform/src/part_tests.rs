//! Zones that move rigidly, each with its own body, next to zones at rest, that turn or that deform.

use super::{Plan, StepEvaluator, choose};
use crate::motion::Schedule;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::progress::Silent;
use azimesh_core::ranks::{Ranks, on_threads};
use azimesh_io::mesh::{CellKind, Group, Mesh};
use std::path::Path;
use std::sync::Arc;

/// Six cubes in a row along x: `rest`, `a`, `rest`, `b`, `rest`, `outer`, with the tag `far` at the first end and `wall` below `a`.
fn row() -> Mesh {
    let mut mesh = Mesh::default();
    for x in 0..7 {
        for [y, z] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            mesh.points.push([f64::from(x), y, z]);
        }
    }
    for first in 0..6 {
        let nodes: Vec<u32> = (4 * first..4 * first + 8).collect();
        mesh.cells.push(CellKind::Hexahedron, &nodes);
    }
    for face in [[0, 1, 2, 3], [4, 5, 9, 8]] {
        mesh.cells.push(CellKind::Quadrilateral, &face);
    }
    let mut group = |dimension: u8, name: &str, cells: &[usize]| {
        mesh.groups.push(Group {
            dimension,
            name: name.into(),
            number: None,
            condition: None,
            cells: cells.iter().copied().collect(),
        });
    };
    group(3, "rest", &[0, 2, 4]);
    group(3, "a", &[1]);
    group(3, "b", &[3]);
    group(3, "outer", &[5]);
    group(2, "far", &[6]);
    group(2, "wall", &[7]);
    mesh
}

/// The mesh of a plan, and its points and velocities at every step.
struct Moved {
    plan: Arc<Plan>,
    mesh: Arc<Mesh>,
    steps: Vec<(Vec<Vector>, Option<Vec<Vector>>)>,
}

fn moved(text: &str) -> Result<Moved> {
    moved_on(text, &Ranks::alone())
}

/// The same on one of several ranks.
fn moved_on(text: &str, ranks: &Ranks) -> Result<Moved> {
    let schedule = Schedule::parse(text, Path::new("s.toml"))?;
    let mesh = match ranks.n() {
        1 => row(),
        _ => Mesh::shared_of(ranks.is_first().then_some(&row()), ranks),
    };
    let (plan, part) = Plan::new(mesh, schedule)?;
    let (plan, part) = (Arc::new(plan), Arc::new(part));
    let all = 0..plan.motion.steps.len();
    let selections = choose(&plan, &all, ranks, &Silent)?;
    let interval = StepEvaluator::new(&plan, &part, selections, &all, &Silent)?;
    let mut steps = Vec::new();
    for step in &plan.motion.steps {
        let mut points = part.mesh.points.clone();
        interval.points_at(step, &mut points)?;
        let velocities = interval.velocities_at(step, &points);
        steps.push((points, velocities));
    }
    let mesh = Arc::clone(&part.mesh);
    Ok(Moved { plan, mesh, steps })
}

/// The nodes of a cell are at their images by `place`.
fn check(moved: &Moved, step: usize, cell: usize, place: impl Fn(Vector) -> Vector) {
    for &node in moved.mesh.cells.get(cell).nodes {
        let (found, right) = (
            moved.steps[step].0[node as usize],
            place(moved.mesh.points[node as usize]),
        );
        assert!(
            distance(found, right) < 1e-12,
            "cell {cell}: {found:?} {right:?}"
        );
    }
}

/// `x` turned about an axis along z through `(ax, ay)`.
fn about_z([x, y, z]: Vector, [ax, ay]: [f64; 2], angle: f64) -> Vector {
    let (sin, cos) = angle.to_radians().sin_cos();
    let (x, y) = (x - ax, y - ay);
    [ax + cos * x - sin * y, ay + sin * x + cos * y, z]
}

const TWO: &str = "time = { values = [0, 1, 2] }\noutput.velocity = true\n\
    [[body]]\nname = \"a\"\nzones = [\"a\"]\n\
    rigid = { ramp = true, rotate = { axis = [0, 0, 1], origin = [1.5, 0.5, 0], angle = 60 } }\n\
    [[body]]\nname = \"b\"\nzones = [\"b\"]\n\
    rigid = { ramp = true, rotate = { axis = [1, 0, 0], origin = [0, 0.5, 0.5], angle = -40 } }\n";

#[test]
fn two_zones_turn_in_opposite_directions_in_a_mesh_at_rest() {
    let moved = moved(TWO).expect("it moves");
    assert_eq!(moved.mesh.points.len(), 28 + 16, "each zone has two sides");
    for (step, part) in [(0, 0.0), (1, 0.5), (2, 1.0)] {
        check(&moved, step, 1, |x| about_z(x, [1.5, 0.5], 60.0 * part));
        check(&moved, step, 3, |[x, y, z]| {
            let [y, z, _] = about_z([y, z, 0.0], [0.5, 0.5], -40.0 * part);
            [x, y, z]
        });
        for cell in [0, 2, 4, 5] {
            check(&moved, step, cell, |x| x);
        }
    }
    let (points, velocities) = &moved.steps[1];
    let velocities = velocities.as_ref().expect("they are asked for");
    let rate = 30_f64.to_radians();
    for &node in moved.mesh.cells.get(1).nodes {
        let [x, y, _] = points[node as usize];
        let right = [-rate * (y - 0.5), rate * (x - 1.5), 0.0];
        assert!(distance(velocities[node as usize], right) < 1e-12);
    }
    assert_eq!(moved.plan.n_modes(), 0, "nothing deforms");
    let names: Vec<&str> = moved
        .mesh
        .groups
        .iter()
        .map(|group| group.name.as_str())
        .collect();
    let sides = [
        "inner_interface",
        "outer_interface",
        "inner_interface_2",
        "outer_interface_2",
    ];
    assert_eq!(names[6..], sides);
}

/// Two rotors that turn touching zones in opposite directions, the second half as fast again, inside a mesh at rest.
const ROTORS: &str = "time.values = [0, 0.25]\noutput.velocity = true\n\
    [[rotor]]\nname = \"front\"\nrpm = 60\nframe = \"inertial\"\nzones = [\"rest\"]\nhub = [0, 0.5, 0.5]\nshaft_axis = [1, 0, 0]\n\
    span_axis = [0, 1, 0]\n\
    [[rotor]]\nname = \"rear\"\nrpm = 90\nframe = \"inertial\"\nzones = [\"a\", \"b\"]\nazimuth_sign = -1\nhub = [1.5, 0.5, 0]\n\
    [boundaries]\nothers = \"fixed\"\n";

#[test]
fn touching_zones_turn_with_their_own_rotors() {
    let moved = moved(ROTORS).expect("it moves");
    // Between outer and rest 4 nodes are doubled, between rest, a and b 16.
    assert_eq!(moved.mesh.points.len(), 28 + 20);
    let tags = moved.mesh.groups[6..].iter();
    let tags: Vec<_> = tags
        .map(|tag| (tag.name.as_str(), tag.cells.len()))
        .collect();
    // The sides of the mesh between two interfaces have no boundary faces that tell them apart.
    let sides = [
        ("inner_interface", 1 + 8),
        ("outer_interface", 1 + 8),
        ("inner_interface_2", 4),
        ("outer_interface_2", 4),
    ];
    assert_eq!(tags, sides, "one pair for each neighbour");
    for (step, [front, rear]) in [(0, [0.0; 2]), (1, [90.0, -135.0])] {
        for cell in [0, 2, 4] {
            check(&moved, step, cell, |[x, y, z]| {
                let [y, z, _] = about_z([y, z, 0.0], [0.5, 0.5], front);
                [x, y, z]
            });
        }
        for cell in [1, 3] {
            check(&moved, step, cell, |x| about_z(x, [1.5, 0.5], rear));
        }
        check(&moved, step, 5, |x| x);
    }
    let (points, velocities) = &moved.steps[1];
    let velocities = velocities.as_ref().expect("they are asked for");
    let [front, rear] = [360_f64, -540.0].map(f64::to_radians);
    for (cell, velocity) in [
        (
            0,
            &(|[_, y, z]: Vector| [0.0, -front * (z - 0.5), front * (y - 0.5)])
                as &dyn Fn(Vector) -> Vector,
        ),
        (3, &|[x, y, _]: Vector| {
            [-rear * (y - 0.5), rear * (x - 1.5), 0.0]
        }),
        (5, &|_: Vector| [0.0; 3]),
    ] {
        for &node in moved.mesh.cells.get(cell).nodes {
            let node = node as usize;
            assert!(distance(velocities[node], velocity(points[node])) < 1e-12);
        }
    }
}

#[test]
fn a_rigid_zone_moves_in_a_turning_zone_inside_a_fixed_one() {
    let text = "azimuth.values = [0, 30]\nrotor.frame = \"inertial\"\nboundaries.zones = [\"rest\", \"b\"]\n\
        [[body]]\nname = \"a\"\nzones = [\"a\"]\n\
        rigid.rotate = { axis = [0, 0, 1], origin = [1.5, 0.5, 0], angle = 10 }\n\
        [[body]]\nname = \"again\"\nzones = [\"outer\"]\nparent = \"a\"\n";
    let moved = moved(text).expect("it moves");
    let own = |x| about_z(x, [1.5, 0.5], 10.0);
    for (step, azimuth) in [(0, 0.0), (1, 30.0)] {
        let turn = |x| about_z(x, [0.0; 2], azimuth);
        check(&moved, step, 1, |x| turn(own(x)));
        check(&moved, step, 5, |x| turn(own(x)));
        for cell in [0, 2, 3, 4] {
            check(&moved, step, cell, turn);
        }
    }
}

#[test]
fn a_zone_is_rigid_next_to_one_that_deforms() {
    let text = "azimuth.values = [0]\nboundaries = { zones = [\"rest\"], others = \"free\" }\nselection.tolerance = 1e-3\n\
        [[body]]\nname = \"a\"\nzones = [\"a\"]\nrigid.translate = [0, 0.25, 0]\n\
        [[body]]\nname = \"far\"\ntags = [\"far\"]\nrigid.translate = [-0.1, 0, 0]\n";
    let moved = moved(text).expect("it moves");
    check(&moved, 0, 1, |[x, y, z]| [x, y + 0.25, z]);
    check(&moved, 0, 0, |[x, y, z]| {
        [if x == 0.0 { -0.1 } else { x }, y, z]
    });
    check(&moved, 0, 3, |x| x);
}

#[test]
fn ranks_move_rigid_zones_as_one_process_does() {
    ranks_move_alike(TWO);
}

#[test]
fn ranks_turn_the_zones_of_rotors_as_one_process_does() {
    ranks_move_alike(ROTORS);
}

fn ranks_move_alike(text: &str) {
    let alone = moved(text).expect("it moves").steps;
    for n in [2, 3] {
        let found = on_threads(n, |ranks| {
            let moved = moved_on(text, &ranks).expect("it moves");
            let own = moved.mesh.own_nodes();
            let gather = |values: &[Vector]| moved.mesh.gather_nodes(&values[own.clone()]);
            let steps = moved.steps.iter().map(|(points, velocities)| {
                let velocities = velocities.as_ref().expect("they are asked for");
                (gather(points), gather(velocities))
            });
            steps.collect::<Vec<_>>()
        });
        for (found, (points, velocities)) in found[0].iter().zip(&alone) {
            assert!(
                found.0.as_ref() == Some(points) && found.1 == *velocities,
                "{n} ranks"
            );
        }
    }
}

#[test]
fn all_zones_may_be_rigid() {
    let text = "azimuth.values = [0]\n\
        [[body]]\nname = \"all\"\nzones = [\"*\"]\nrigid.translate = [0, 0.25, 0]\n";
    let moved = moved(text).expect("it moves");
    for cell in 0..6 {
        check(&moved, 0, cell, |[x, y, z]| [x, y + 0.25, z]);
    }
}

#[test]
fn zones_that_cannot_move_rigidly_are_refused() {
    let rigid = "rigid.translate = [0, 0.25, 0]";
    let body = |name: &str, rest: &str| format!("[[body]]\nname = \"{name}\"\n{rest}\n");
    let cases = [
        (
            body("a", &format!("zones = [\"a\"]\ntags = [\"wall\"]\n{rigid}")),
            "s.toml:4: body \"a\" has `tags` and `zones`; leave `tags` out, tags in its zones move with them, or make two bodies",
        ),
        (
            body("a", "zones = [\"a\"]\nbeam = { table = \"b.csv\" }"),
            "s.toml:4: body \"a\" moves its zones rigidly, which a beam, `modes`, `surface` or displacements do not; use [body.rigid], \
             [body.table] or [body.cyclic], or name its `tags` instead",
        ),
        (
            body("a", &format!("zones = [\"a\"]\n{rigid}"))
                + &body("b", &format!("zones = [\"a\", \"b\"]\n{rigid}")),
            "s.toml:8: the zones of body \"b\" have cells that move with body \"a\" already; a cell moves with one body",
        ),
        (
            body("a", &format!("zones = [\"c\"]\n{rigid}")),
            "s.toml:4: zone \"c\" is not in the mesh; it has: rest, a, b, outer",
        ),
    ];
    for (bodies, message) in cases {
        let error = moved(&format!("azimuth.values = [0]\n{bodies}")).err();
        assert_eq!(error.expect("it is refused").to_string(), message);
    }
    let both = body("a", &format!("zones = [\"a\"]\n{rigid}")) + "[boundaries]\nzones = [\"a\"]\n";
    let error = moved(&format!("azimuth.values = [0]\n{both}")).err();
    assert_eq!(
        error.expect("it is refused").to_string(),
        "s.toml:7: `zones` has cells that move rigidly with body \"a\"; leave its zones out, a cell cannot deform as well"
    );
}
