//! The motion of each body in words: its angles and translations at the extreme steps, and the positions of its points.

use super::motion::points_of;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, sub};
use azimesh_core::numbers::{in_digits, point, short};
use azimesh_core::parallel;
use azimesh_deform::Plan;
use azimesh_deform::motion::{RigidAt, Rotation, Step};

/// Angles (radians) and lengths (parts of the largest) below this count as zero.
const NOTHING: f64 = 1e-12;
/// Axes whose directions differ by less (radians) are one.
const ONE_AXIS: f64 = 1e-9;

/// Returns sentences for each body.
pub fn motion_in_words(plan: &Plan) -> Vec<Vec<String>> {
    (0..plan.motion.bodies.len())
        .map(|body| of_body(plan, body))
        .collect()
}

fn of_body(plan: &Plan, body: usize) -> Vec<String> {
    let mut told = cyclic(plan, body);
    let steps = &plan.motion.steps;
    let at = parallel::map(steps.len(), &|step| {
        plan.motion.rigid_parts(body, &steps[step])
    });
    for i in 0..at[0].rotations.len() {
        told.extend(rotation(plan, body, &at, i));
    }
    for axis in 0..3 {
        told.extend(translation(steps, &at, axis));
    }
    told
}

/// Returns the first steps of the smallest and the largest of some values, one per step; `None` if all are zero.
fn extremes(values: impl Iterator<Item = f64>) -> Option<[(usize, f64); 2]> {
    let mut values = values.enumerate();
    let first = values.next()?;
    let ends = values.fold([first; 2], |[low, high], next| {
        [
            if next.1 < low.1 { next } else { low },
            if next.1 > high.1 { next } else { high },
        ]
    });
    ends.iter().any(|end| end.1.abs() > NOTHING).then_some(ends)
}

/// Formats "from a at one step to b at another".
fn range(
    steps: &[Step],
    ends @ [low, high]: [(usize, f64); 2],
    word: impl Fn(f64) -> String,
) -> String {
    if ends[0].1 == ends[1].1 {
        return format!("{} at every step", word(low.1));
    }
    format!(
        "from {} at {} to {} at {}",
        word(low.1),
        place(&steps[low.0]),
        word(high.1),
        place(&steps[high.0])
    )
}

/// Formats a step with its azimuth and its time.
fn place(step: &Step) -> String {
    match (step.azimuth_deg(), step.time_s()) {
        (Some(_), Some(time)) => format!("{step} and {} s", short(time)),
        _ => step.to_string(),
    }
}

fn degrees(angle: f64) -> String {
    format!("{} deg", in_digits(angle.to_degrees(), 4))
}

/// Describes pitch, flap and lag by their effect on the blade.
fn cyclic(plan: &Plan, body: usize) -> Vec<String> {
    let (motion, signs) = (&plan.motion, &plan.motion.axes(body).signs);
    let names = [
        (
            "pitch",
            signs.azimuth * signs.pitch,
            ["nose up", "nose down"],
        ),
        ("flap", signs.flap, ["tip up", "tip down"]),
        (
            "lag",
            signs.azimuth * signs.lag,
            ["tip forward", "tip back"],
        ),
    ];
    let all: Vec<_> = motion
        .steps
        .iter()
        .map(|step| motion.cyclic_angles(body, step))
        .collect();
    let told = names
        .iter()
        .enumerate()
        .filter_map(|(i, (name, sign, [plus, minus]))| {
            let angles: Option<Vec<f64>> = all.iter().map(|angles| Some((*angles)?[i])).collect();
            let ends = extremes(angles?.into_iter())?;
            let word = |angle: f64| match sign * angle {
                turn if turn.abs() <= NOTHING => degrees(0.0),
                turn if turn > 0.0 => format!("{} ({plus})", degrees(angle)),
                _ => format!("{} ({minus})", degrees(angle)),
            };
            Some(format!("{name} {}", range(&motion.steps, ends, word)))
        });
    told.collect()
}

/// Describes the angle about an axis, and the extreme positions of the point of the body that is farthest from the axis.
fn rotation(plan: &Plan, body: usize, at: &[RigidAt], i: usize) -> Option<String> {
    let turns: Vec<&Rotation> = at.iter().map(|at| &at.rotations[i]).collect();
    let largest = |most: usize, step: usize| match turns[step].angle.abs() > turns[most].angle.abs()
    {
        true => step,
        false => most,
    };
    let most = (0..turns.len()).fold(0, largest);
    let Rotation {
        axis,
        origin,
        angle,
        ..
    } = *turns[most];
    let is_about =
        |turn: &&Rotation| turn.angle.abs() <= NOTHING || norm(cross(turn.axis, axis)) <= ONE_AXIS;
    if !turns.iter().all(is_about) {
        return Some(format!(
            "turns through {} about changing axes, farthest by {} about {} at {}",
            point(&origin),
            degrees(angle),
            point(&axis),
            place(&plan.motion.steps[most])
        ));
    }
    let ends = extremes(
        turns
            .iter()
            .map(|turn| turn.angle * dot(turn.axis, axis).signum()),
    )?;
    let range = range(&plan.motion.steps, ends, degrees);
    let sentence = format!(
        "turns about {} through {}: {range}",
        point(&axis),
        point(&origin)
    );
    let arm = |x: &Vector| norm(cross(axis, sub(*x, origin)));
    let points = points_of(plan, body).into_iter();
    let own = points.map(|at| plan.surface.points[at]);
    let of_zones = plan.rigid_points.iter().filter(|(of, _)| *of == body);
    let points = own.chain(of_zones.map(|(_, x)| *x));
    let farthest = points.reduce(|most, x| if arm(&x) > arm(&most) { x } else { most });
    let Some(x) = farthest.filter(|x| arm(x) > 0.0) else {
        return Some(sentence);
    };
    let moved = |end: (usize, f64)| {
        let by = sub(at[end.0].rotations[i].map().apply(x), x);
        format!(
            "by {} towards {} at {}",
            short(norm(by)),
            direction(by),
            degrees(end.1)
        )
    };
    let mut moves: Vec<String> = ends
        .into_iter()
        .filter(|end| end.1.abs() > NOTHING)
        .map(moved)
        .collect();
    moves.dedup();
    Some(format!(
        "{sentence}; this moves the point at {} {}",
        point(&x),
        moves.join(", ")
    ))
}

/// Returns the axis that is nearest to a vector, with its sign.
fn direction(by: Vector) -> String {
    let axis = (0..3).fold(0, |most, i| {
        if by[i].abs() > by[most].abs() {
            i
        } else {
            most
        }
    });
    let sign = if by[axis] < 0.0 { '-' } else { '+' };
    format!("{sign}{}", ["x", "y", "z"][axis])
}

fn translation(steps: &[Step], at: &[RigidAt], axis: usize) -> Option<String> {
    let ends = extremes(at.iter().map(|at| at.translation[axis]))?;
    let name = ["x", "y", "z"][axis];
    Some(format!("moves along {name}: {}", range(steps, ends, short)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::plan;

    fn told(steps: &str, motion: &str) -> Vec<String> {
        let schedule = format!(
            "{steps}\nboundaries.others = \"fixed\"\nbody = [ {{ name = \"it\", tags = [\"airfoil\"], {motion} }} ]\n"
        );
        motion_in_words(&plan("testdata/naca0012.vtu", &schedule)).remove(0)
    }

    #[test]
    fn a_hinge_is_told_with_its_extreme_angles_and_where_they_take_the_far_end() {
        let motion = "rigid.rotate = { axis = [0, 0, 1], angle = 2, harmonics = [ { sin = 10 } ] }";
        assert_eq!(
            told("time = { stop = 1, step = 0.25, frequency = 1 }", motion),
            [
                "turns about (0, 0, 1) through (0, 0, 0): from -8 deg at step 3 (azimuth 270 degrees) and 0.75 s to 12 deg at step 1 (azimuth 90 degrees) and 0.25 s; this moves the point at (0.75, 0, 0) by 0.104635 towards -y at -8 deg, by 0.156793 towards +y at 12 deg"
            ]
        );
        assert_eq!(
            told("steps = 2", "rigid.translate = [0, -0.1, 0]"),
            ["moves along y: -0.1 at every step"]
        );
    }

    #[test]
    fn a_rotation_vector_is_told_as_the_angle_about_its_axis() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("m.csv");
        std::fs::write(&file, "time_s,rot_z_deg\n0,5\n1,-10\n2,2\n").expect("it can be written");
        let of = |form: &str| {
            let motion = format!("table = {{ file = {file:?}, rotation = \"{form}\" }}");
            told("time = { stop = 2, step = 1 }", &motion)
        };
        let expected = of("euler_zyx")[0].clone();
        assert!(
            expected.contains("from -10 deg at step 1 (1 s) to 5 deg at step 0"),
            "{expected}"
        );
        let found = of("vector").remove(0);
        let from_5 = "turns about (0, 0, -1) through (0, 0, 0): from -5 deg at step 0 (0 s) to 10 deg at step 1 (1 s); this moves the point at (0.75, 0, 0) by";
        assert!(found.starts_with(from_5), "{found}");
    }

    #[test]
    fn pitch_is_nose_up_or_down_by_the_signs_of_the_rotor() {
        let pitch = "cyclic.pitch = [ { sin = 5 } ]";
        assert_eq!(
            told("azimuth = { stop = 270, step = 90 }\nrotor.rpm = 60", pitch),
            [
                "pitch from -5 deg (nose down) at step 3 (azimuth 270 degrees) and 0.75 s to 5 deg (nose up) at step 1 (azimuth 90 degrees) and 0.25 s"
            ]
        );
        let turned = told(
            "azimuth = { stop = 270, step = 90 }\nrotor.pitch_sign = -1",
            pitch,
        );
        assert!(
            turned[0].starts_with("pitch from -5 deg (nose up) at step 3"),
            "{turned:?}"
        );
    }
}
