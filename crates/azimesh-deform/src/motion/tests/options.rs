//! Keys of boundaries, interpolation and selection: their meaning and their error messages.

use super::parse;
use super::refusals::told;
use crate::motion::options::Refresh;
use crate::motion::{
    Interpolate, Others, Polynomial, Schedule, SelectionCriterion, SelectionMethod,
};
use azimesh_core::error::Position;

fn with(head: &str, lines: &str) -> Schedule {
    let body = "[[body]]\nname = \"a\"\ntags = [\"a\"]\ncyclic = {}";
    parse(&format!("{head}\nazimuth.values = [0]\n{body}\n{lines}")).expect("a good schedule")
}

#[test]
fn twist_has_a_radius_of_its_own_and_steps_are_cut() {
    let rbf = with(
        "",
        "[rbf]\npolynomial = \"linear\"\nrotation_radius = 0.25\ninterpolate = \"twist\"\nsubsteps = 1000",
    )
    .rbf;
    assert_eq!(rbf.polynomial, Polynomial::Linear);
    assert_eq!(rbf.interpolate, Interpolate::Twist);
    assert_eq!((rbf.rotation_radius, rbf.substeps), (Some(0.25), 1000));
    let rbf = with("", "").rbf;
    assert_eq!(rbf.polynomial, Polynomial::None);
    assert_eq!(rbf.interpolate, Interpolate::Displacement);
    assert_eq!((rbf.rotation_radius, rbf.substeps), (None, 1));
}

#[test]
fn every_selection_of_the_paper_has_its_keys() {
    let constant = with(
        "",
        "[selection]\nconstant = [0, 0.0, -1]\nmethod = \"constant\"\ncriterion = \"mean\"",
    )
    .selection;
    assert_eq!(constant.method, SelectionMethod::Constant);
    assert_eq!(constant.criterion, SelectionCriterion::Mean);
    assert_eq!(constant.constant, Some([0.0, 0.0, -1.0]));
    let real = with("", "[selection]\nmethod = \"real\"").selection;
    assert_eq!(
        (real.method, real.refresh, real.constant),
        (SelectionMethod::Real, None, None)
    );
    assert_eq!(real.criterion, SelectionCriterion::Max);
}

#[test]
fn a_refresh_is_an_angle_in_the_unit_of_the_schedule() {
    let selection = "[selection]\nmethod = \"real\"\nrefresh = 30.0";
    let degrees = Refresh {
        azimuth: 30f64.to_radians(),
        azimuth_deg: 30.0,
    };
    assert_eq!(with("", selection).selection.refresh, Some(degrees));
    let radians = Refresh {
        azimuth: 30.0,
        azimuth_deg: 30f64.to_degrees(),
    };
    let found = with("angle_unit = \"rad\"", selection).selection.refresh;
    assert_eq!(found, Some(radians));
}

#[test]
fn boundaries_slide_and_are_periodic() {
    let boundaries = with(
        "",
        "[boundaries]\nslide = [\"sym*\"]\nothers = \"slide\"\nperiodic = [\n{ pair = [\"a\", \"b_*\"] },\n{ pair = [\"c\", \"d\"] } ]",
    )
    .boundaries;
    assert_eq!(boundaries.slide[0].text, "sym*");
    assert_eq!(boundaries.others, Some(Others::Slide));
    let pairs: Vec<_> = boundaries
        .periodic
        .iter()
        .map(|pair| {
            (
                pair.a.text.as_str(),
                pair.b.text.as_str(),
                pair.place.clone(),
            )
        })
        .collect();
    let line = |line| Some(Position::Line(line));
    assert_eq!(pairs, [("a", "b_*", line(11)), ("c", "d", line(12))]);
}

#[test]
fn mistakes_in_these_keys_are_told_what_would_be_right() {
    for (section, line, wrong, expected) in [
        (
            "boundaries",
            11,
            "slide = []",
            "`slide` is empty; name the tags, or leave the key out",
        ),
        (
            "boundaries",
            11,
            "slide = \"sym\"",
            "`slide` is the string \"sym\"; it must be an array of strings",
        ),
        (
            "boundaries",
            11,
            "others = \"slid\"",
            "unknown others \"slid\"; did you mean `slide`? known: fixed, free, slide",
        ),
        (
            "boundaries",
            11,
            "periodic = []",
            "`periodic` is empty; name the pairs, or leave the key out",
        ),
        (
            "boundaries",
            11,
            "periodic = [\"a\", \"b\"]",
            "`periodic` is the string \"a\"; it must be a table, { pair = [\"side_a\", \"side_b\"] }",
        ),
        (
            "boundaries",
            11,
            "periodic = { pair = [\"a\", \"b\"] }",
            "`periodic` is a table; it must be an array of pairs such as { pair = [\"side_a\", \"side_b\"] }",
        ),
        (
            "boundaries",
            12,
            "periodic = [\n{} ]",
            "{ pair = [\"side_a\", \"side_b\"] } has no `pair`; add for example  pair = [\"side_a\", \"side_b\"]",
        ),
        (
            "boundaries",
            11,
            "periodic = [ { pair = [\"a\"] } ]",
            "`pair` has 1 names; it must have 2, one for each side",
        ),
        (
            "boundaries",
            11,
            "periodic = [ { pair = [\"a\", \"b\", \"c\"] } ]",
            "`pair` has 3 names; it must have 2, one for each side",
        ),
        (
            "boundaries",
            12,
            "periodic = [ { pair = [\"a\",\n3] } ]",
            "`pair` is the integer 3; it must be a string that is not empty",
        ),
        (
            "boundaries",
            11,
            "periodic = [ { pairs = [] } ]",
            "unknown key `pairs` in { pair = [\"side_a\", \"side_b\"] }; did you mean `pair`? known: pair",
        ),
        (
            "rbf",
            13,
            "polynomial = \"cubic\"",
            "unknown polynomial \"cubic\"; known: none, linear",
        ),
        (
            "rbf",
            13,
            "interpolate = \"twst\"",
            "unknown interpolate \"twst\"; did you mean `twist`? known: displacement, twist",
        ),
        (
            "rbf",
            13,
            "rotation_radius = 1.0",
            "`rotation_radius` needs interpolate = \"twist\"; set that, or leave the key out",
        ),
        (
            "rbf",
            14,
            "interpolate = \"twist\"\nrotation_radius = 0",
            "`rotation_radius` is the integer 0; it must be a number greater than 0",
        ),
        (
            "rbf",
            13,
            "substeps = 0",
            "`substeps` is the integer 0; it must be a whole number greater than 0",
        ),
        (
            "rbf",
            13,
            "substeps = 1001",
            "`substeps` is 1001; at most 1000 are possible",
        ),
        (
            "selection",
            15,
            "method = \"rael\"",
            "unknown method \"rael\"; did you mean `real`? known: sequence, constant, real, all",
        ),
        (
            "selection",
            15,
            "criterion = \"rms\"",
            "unknown criterion \"rms\"; known: max, mean",
        ),
        (
            "selection",
            15,
            "constant = [0, 0, 1]",
            "`constant` needs method = \"constant\"; set that, or leave the key out",
        ),
        (
            "selection",
            16,
            "method = \"constant\"\nconstant = [0, 0, 0.0]",
            "`constant` is zero, so no base points would be chosen; give a displacement such as [0.0, 0.0, 1.0], or leave the key out to use the displacement of the motion",
        ),
        (
            "selection",
            16,
            "method = \"constant\"\nconstant = [0, 0, inf]",
            "`constant` is the number inf; it must be a finite number",
        ),
        (
            "selection",
            16,
            "method = \"constant\"\nrefresh = 30",
            "`refresh` needs method = \"real\"; set that, or leave the key out",
        ),
        (
            "selection",
            16,
            "method = \"real\"\nrefresh = 0.0",
            "`refresh` is the number 0.0; it must be a number greater than 0",
        ),
    ] {
        assert_eq!(
            told(section, wrong),
            format!("hover.toml:{line}: {expected}")
        );
    }
}
