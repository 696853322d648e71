//! Effects of the motion on the mesh before interpolation: surfaces that intersect, bodies of several blades, and a support
//! radius within which the motion cannot fade out.

use super::displacements::LargestDisplacements;
use super::motion::{places_at, points_of};
use azimesh_core::error::counted;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::crossing::{segments_cross, triangles_cross};
use azimesh_core::geometry::vector::{Vector, dot, sub};
use azimesh_core::numbers::{in_digits, point, short};
use azimesh_core::{Note, note};
use azimesh_deform::Plan;
use azimesh_deform::motion::{Interpolate, Role, Step};
use std::collections::{BTreeMap, BTreeSet};

/// Regions that one blade does not reach, as parts of its largest distance from the hub: behind the hub, and away from the span.
const BEHIND: f64 = 0.4;
const BESIDE: f64 = 0.7;
/// Safety factor of the advised support radius.
const SAFE: f64 = 1.1;

/// Returns a warning for each body whose nodes are all around the hub, but whose motion is about the axes of one blade.
pub(super) fn of_several_blades(plan: &Plan) -> Vec<Note> {
    let motion = &plan.motion;
    let first = motion.steps.first().filter(|_| !motion.in_plane());
    let bodies = motion.bodies.iter().enumerate();
    let about_a_span = bodies
        .filter(|(at, _)| first.is_some_and(|step| motion.cyclic_angles(*at, step).is_some()));
    let notes = about_a_span.filter_map(|(at, body)| {
        let rotor = motion.axes(at);
        let turned = rotor.turn(body.azimuth_offset);
        let [span, beside] = [rotor.e_x, rotor.e_y].map(|axis| turned.turn(axis));
        let from_hub = points_of(plan, at).into_iter();
        let from_hub = from_hub.map(|point| sub(plan.surface.points[point], rotor.hub));
        let [mut low, mut high, mut side] = [0.0_f64; 3];
        for x in from_hub {
            low = low.min(dot(x, span));
            high = high.max(dot(x, span));
            side = side.max(dot(x, beside).abs());
        }
        let reach = high.max(-low);
        let is_round = -low > BEHIND * reach && side > BESIDE * reach;
        is_round.then(|| {
            note!(
                "several_blades",
                "body \"{}\" pitches and flaps about the span of one blade, but lies all round the hub (stations {} to {}, up to {} beside \
                 the span); several blades are several bodies, each with its azimuth_offset",
                body.name,
                short(low),
                short(high),
                short(side)
            )
        })
    });
    notes.collect()
}

/// Returns a warning if cells fold in any mesh. With a displacement `d` that is zero at the distance `R`, the slope of the
/// field reaches `s d / R`, with `s` the steepest slope of the kernel; cells fold if that exceeds one. Rotations that are
/// interpolated as such are exempt.
pub(super) fn small_radius(plan: &Plan, extremes: &LargestDisplacements) -> Option<Note> {
    let (surface, rbf) = (&plan.surface, &plan.schedule.rbf);
    let turns = rbf.interpolate == Interpolate::Twist;
    let mut layers = plan.layers.iter();
    let rings = layers.any(|layer| layer.rings().next().is_some());
    let mut tags = plan.motion.surface.tags.iter();
    let has_still = surface.body.contains(&None) || tags.any(|tag| tag.role.is_none());
    if turns || rings || !has_still {
        return None;
    }
    let bodies = extremes.farthest.iter().enumerate();
    let farther = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
    let (body, &(step, whole)) = bodies.rev().max_by(|a, b| farther(a.1, b.1))?;
    let (radius, slope) = (plan.basis.radius, plan.basis.kernel.steepest());
    let by = whole / rbf.substeps as f64;
    if slope * by <= radius {
        return None;
    }
    let needed_radius = SAFE * slope * by;
    let needed_substeps = (SAFE * slope * whole / radius).ceil() as usize;
    let note = note!(
        "small_radius",
        "body \"{}\" moves by up to {}{} (step {step}), which has to fade out within the support radius {}: with {} \
         that has to be about {} times the distance, or cells fold; set rbf.support_radius = {} or more, where the mesh has that room, or \
         rbf.substeps = {needed_substeps}",
        plan.motion.bodies[body].name,
        in_digits(by, 3),
        if rbf.substeps > 1 {
            " in one substep"
        } else {
            ""
        },
        short(radius),
        plan.basis.kernel.name(),
        in_digits(needed_radius / by, 2),
        in_digits(needed_radius, 3)
    );
    let note = note.with("needed_radius", needed_radius);
    Some(note.with("needed_substeps", needed_substeps))
}

/// Returns sentences on bodies that leave the region, and on bodies that intersect other surfaces at some of the steps
/// or at their farthest positions.
pub(super) fn conflicts(
    plan: &Plan,
    steps: &[&Step],
    extremes: &LargestDisplacements,
) -> Vec<Note> {
    let facets = Facets::new(plan);
    let mut meeting: BTreeMap<(Owner, Owner), Vec<(usize, Vector)>> = BTreeMap::new();
    let steps: BTreeSet<usize> = (steps.iter().map(|step| step.index()))
        .chain(extremes.farthest.iter().map(|(step, _)| *step))
        .collect();
    for &step in &steps {
        let step = &plan.motion.steps[step];
        let places = places_at(plan, step);
        for (pair, place) in facets.meeting(&places) {
            meeting.entry(pair).or_default().push((step.index(), place));
        }
    }
    let name = |owner: Owner| match owner {
        Some(body) => format!("body \"{}\"", plan.motion.bodies[usize::from(body)].name),
        None => "a fixed boundary".to_owned(),
    };
    let leaving = extremes.leaving.iter();
    let leaving = leaving.map(|(&body, at)| extremes.leaves_box(plan, body, at));
    let meeting = meeting.into_iter().map(|((one, other), found)| {
        note!(
            "surfaces_meet",
            "the surfaces of {} and {} intersect at {} of the {} checked, first at step {}, near {}",
            name(other),
            name(one),
            found.len(),
            counted(steps.len(), "step"),
            found[0].0,
            point(&found[0].1)
        )
    });
    leaving.chain(meeting).collect()
}

/// The body that a facet moves with; `None` is fixed.
type Owner = Option<u16>;

/// Groups facets by their owner. Facets between two owners and sliding ones are left out.
struct Facets {
    by_owner: BTreeMap<Owner, Vec<[u32; 3]>>,
}

/// A facet at a step with its box.
struct Placed {
    facet: [u32; 3],
    bounds: Bounds,
}

impl Facets {
    fn new(plan: &Plan) -> Self {
        let surface = &plan.surface;
        let mut slides = vec![false; surface.points.len()];
        let roles = plan.motion.surface.nodes.roles.iter();
        for (role, &point) in roles.zip(&surface.point_of) {
            slides[point as usize] |= *role == Role::Sliding;
        }
        let mut by_owner: BTreeMap<Owner, Vec<[u32; 3]>> = BTreeMap::new();
        for facet in &surface.facets {
            let owner = surface.body[facet[0] as usize];
            let alike =
                |&point: &u32| surface.body[point as usize] == owner && !slides[point as usize];
            if facet.iter().all(alike) {
                by_owner.entry(owner).or_default().push(*facet);
            }
        }
        Self { by_owner }
    }

    /// Returns pairs of owners whose facets intersect, each with a position.
    fn meeting(&self, places: &[Vector]) -> Vec<((Owner, Owner), Vector)> {
        let boxes: BTreeMap<Owner, Bounds> = self
            .by_owner
            .iter()
            .map(|(owner, facets)| {
                let points = facets.iter().flatten();
                let bounds = Bounds::around(points.map(|&point| &places[point as usize]));
                (*owner, bounds)
            })
            .collect();
        let owners: Vec<Owner> = self.by_owner.keys().copied().collect();
        let mut found = Vec::new();
        for (i, one) in owners.iter().enumerate() {
            for other in &owners[i + 1..] {
                let a = placed(&self.by_owner[one], places, &boxes[other]);
                if a.is_empty() {
                    continue;
                }
                let b = placed(&self.by_owner[other], places, &boxes[one]);
                if let Some(place) = crossing(&a, &b, places) {
                    found.push(((*one, *other), place));
                }
            }
        }
        found
    }
}

/// Returns the facets that reach into a box, by their lowest x.
fn placed(facets: &[[u32; 3]], places: &[Vector], inside: &Bounds) -> Vec<Placed> {
    let facets = facets.iter().map(|facet| Placed {
        facet: *facet,
        bounds: Bounds::around(facet.iter().map(|&point| &places[point as usize])),
    });
    let mut found: Vec<Placed> = facets
        .filter(|facet| overlap(&facet.bounds, inside))
        .collect();
    found.sort_by(|a, b| a.bounds.low[0].total_cmp(&b.bounds.low[0]));
    found
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    (0..3).all(|i| a.low[i] <= b.high[i] && b.low[i] <= a.high[i])
}

/// Returns a corner of the first facet of `a` that intersects a facet of `b`.
fn crossing(a: &[Placed], b: &[Placed], places: &[Vector]) -> Option<Vector> {
    let longest = b.iter().map(|b| b.bounds.high[0] - b.bounds.low[0]);
    let longest = longest.fold(0.0, f64::max);
    for one in a {
        let from = b.partition_point(|b| b.bounds.low[0] < one.bounds.low[0] - longest);
        let near = b[from..]
            .iter()
            .take_while(|b| b.bounds.low[0] <= one.bounds.high[0]);
        for other in near.filter(|b| overlap(&b.bounds, &one.bounds)) {
            let shared = one.facet.iter().any(|point| other.facet.contains(point));
            let at = |facet: &[u32; 3]| facet.map(|point| places[point as usize]);
            let (p, q) = (at(&one.facet), at(&other.facet));
            // An edge repeats its second corner.
            let cut = if one.facet[1] == one.facet[2] {
                segments_cross(&[p[0], p[1]], &[q[0], q[1]])
            } else {
                triangles_cross(&p, &q)
            };
            if cut && !shared {
                return Some(p[0]);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preflight::tests::plan;

    fn told(mesh: &str, tag: &str, by: &str) -> Vec<Note> {
        let plan = plan(
            mesh,
            &format!(
                "time = {{ stop = 1, step = 0.5 }}\nboundaries.others = \"fixed\"\nrbf.support_radius = 3.0\nselection.tolerance = 1e-2\nbody = [ {{ name = \"it\", tags = [\"{tag}\"], rigid = {{ translate = {by}, ramp = true }} }} ]\n"
            ),
        );
        let steps: Vec<&Step> = plan.motion.steps.iter().collect();
        conflicts(&plan, &steps, &LargestDisplacements::new(&plan))
    }

    /// Returns the text of a note after "the surfaces of the body and a fixed boundary intersect".
    fn meeting(told: &[Note]) -> Option<&str> {
        let start = "the surfaces of body \"it\" and a fixed boundary intersect";
        let mut told = told.iter().filter(|note| note.code == "surfaces_meet");
        told.find_map(|note| note.text.strip_prefix(start))
    }

    #[test]
    fn a_body_that_stays_clear_is_not_warned_of() {
        for (mesh, tag) in [
            ("testdata/body_in_duct.vtu", "body"),
            ("testdata/naca0012.vtu", "airfoil"),
        ] {
            assert_eq!(told(mesh, tag, "[0.05, 0.05, 0]"), []);
        }
    }

    #[test]
    fn a_single_step_far_out_is_found_among_many() {
        let folder = tempfile::tempdir().expect("a folder");
        let rows =
            (0..=360).map(|step| format!("{step},{}\n", if step == 100 { 5.0 } else { 0.01 }));
        let table = format!("step,dx\n{}", rows.collect::<String>());
        let path = folder.path().join("t.csv");
        std::fs::write(&path, table).expect("it can be written");
        let text = format!(
            "azimuth = {{ stop = 360, step = 1 }}\nboundaries.others = \"fixed\"\nrbf.support_radius = 3.0\nselection.tolerance = 1e-2\nbody = [ {{ name = \"it\", tags = [\"airfoil\"], table = {{ file = {path:?} }} }} ]\n"
        );
        let plan = plan("testdata/naca0012.vtu", &text);
        let extremes = LargestDisplacements::new(&plan);
        assert_eq!((extremes.n_steps, extremes.farthest[0]), (361, (100, 5.0)));
        let steps: Vec<&Step> = plan.motion.steps.iter().step_by(6).collect();
        let told = conflicts(&plan, &steps, &extremes);
        assert_eq!(
            told[0].text,
            "body \"it\" leaves the bounding box of the mesh at 1 of the 361 steps checked, first at step 100"
        );
    }

    #[test]
    fn a_body_that_runs_into_a_wall_or_out_of_the_mesh_is_warned_of() {
        let duct = told("testdata/body_in_duct.vtu", "body", "[0, 1.2, 0]");
        assert!(meeting(&duct).is_some(), "{duct:?}");
        let airfoil = told("testdata/naca0012.vtu", "airfoil", "[2.0, 0, 0]");
        assert_eq!(airfoil[0].code, "leaves_box");
        let met = meeting(&airfoil).expect("it meets a wall");
        let wanted = " at 1 of the 3 steps checked, first at step 2, near (";
        assert!(met.starts_with(wanted), "{met}");
    }

    #[test]
    fn the_angles_and_the_tip_of_a_blade_are_those_of_its_motion() {
        let plan = plan(
            "testdata/wing_on_plane.vtu",
            "azimuth.values = [90]\nboundaries.others = \"fixed\"\nrbf.support_radius = 3.0\nselection.tolerance = 1e-2\nrotor = { span_axis = [0, 0, 1], shaft_axis = [0, 1, 0] }\nbody = [ { name = \"wing\", tags = [\"wing\"], cyclic = { collective = 2, flap = [ { sin = 5 } ] } } ]\n",
        );
        let found = &crate::preflight::bodies_at(&plan, &[&plan.motion.steps[0]])[0];
        let angles = found.angles.map(|angle| angle.map_or(0.0, f64::to_degrees));
        assert!((angles[0] - 2.0).abs() < 1e-12 && (angles[1] - 5.0).abs() < 1e-12);
        let tip = found.tip.expect("it is in space");
        let root = Bounds::around(&plan.surface.points_of(0));
        let length = root.high[2];
        let (sin, cos) = 5f64.to_radians().sin_cos();
        assert!((tip[1] - length * sin).abs() < 0.02 * length, "{tip:?}");
        assert!(
            (tip[2] - length * (cos - 1.0)).abs() < 0.02 * length,
            "{tip:?}"
        );
        assert!(found.largest >= azimesh_core::geometry::vector::norm(tip) * 0.999);
    }

    #[test]
    fn a_body_has_a_tip_only_where_something_says_what_its_span_is() {
        let tip = |rotor: &str, motion: &str| {
            let schedule = format!(
                "azimuth.values = [90]\nboundaries.others = \"fixed\"\nrbf.support_radius = 3.0\nselection.tolerance = 1e-2\n{rotor}\nbody = [ {{ name = \"wing\", tags = [\"wing\"], {motion} }} ]\n"
            );
            let plan = plan("testdata/wing_on_plane.vtu", &schedule);
            crate::preflight::bodies_at(&plan, &[&plan.motion.steps[0]])[0].tip
        };
        // The wing is along z, and the default span along x.
        let swing = "rigid = { rotate = { axis = [1, 0, 0], angle = 2.0 } }";
        assert_eq!(tip("", swing), None);
        let span = "rotor = { span_axis = [0, 0, 1], shaft_axis = [0, 1, 0] }";
        let along_z = tip(span, swing).expect("the span is given");
        assert!(along_z[1].abs() > 0.01, "{along_z:?}");
        assert!(tip("", "cyclic = { collective = 2 }").is_some());
    }

    /// Returns the advised radius and number of substeps for an airfoil that moves by 0.35.
    fn advised(rbf: &str) -> Option<(f64, usize)> {
        let text = format!(
            "azimuth.values = [0]\nboundaries.others = \"fixed\"\nrbf = {{ {rbf} }}\nselection.tolerance = 1e-2\n\
             body = [ {{ name = \"a\", tags = [\"airfoil\"], rigid.translate = [0, 0.35, 0] }} ]\n"
        );
        let plan = plan("testdata/naca0012.vtu", &text);
        small_radius(&plan, &LargestDisplacements::new(&plan)).map(|note| {
            let radius = note.get("needed_radius").as_f64().expect("a number");
            let substeps = note.get("needed_substeps").as_u64().expect("a number");
            (radius, substeps as usize)
        })
    }

    #[test]
    fn a_radius_within_which_the_motion_cannot_fade_out_is_told_with_one_that_is_enough() {
        assert_eq!(advised("support_radius = 2.0"), None);
        for kernel in ["c0", "c2", "c4", "c6"] {
            let rbf = |radius: f64, substeps: usize| {
                format!(
                    "kernel = \"wendland-{kernel}\", support_radius = {radius:?}, substeps = {substeps}"
                )
            };
            let (radius, substeps) = advised(&rbf(0.5, 1)).expect("it is too small");
            assert_eq!(advised(&rbf(radius, 1)), None, "{kernel}");
            assert_eq!(advised(&rbf(0.5, substeps)), None, "{kernel}");
        }
    }
}
