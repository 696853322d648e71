//! Keys of boundaries, interpolation and selection: their meaning.

use super::parse;
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
