//! Interpolation between rows, in azimuth and along the span.

use super::*;

const KNOTS: [f64; 7] = [0.0, 7.0, 30.0, 31.5, 80.0, 200.0, 250.0];
const VALUES: [[f64; 2]; 7] = [
    [-0.802, -1.324],
    [-0.248, 0.42],
    [1.136, 0.11],
    [-0.553, -0.785],
    [0.749, 1.635],
    [0.273, -1.233],
    [-0.958, 1.6],
];

/// Builds the first `n` rows over azimuth or time; `stretch` scales the spacing of the knots. `closed` adds
/// the first row at 360.
fn history(n: usize, stretch: f64, key: Key, closed: bool, cubic: bool) -> History {
    let mut knots: Vec<f64> = KNOTS[..n].iter().map(|knot| knot * stretch).collect();
    let mut values = VALUES[..n].as_flattened().to_vec();
    if closed {
        knots.push(360.0);
        values.extend(VALUES[0]);
    }
    let interpolation = if cubic {
        Interpolation::Cubic
    } else {
        Interpolation::Linear
    };
    History::new(Path::new("beam.csv"), key, knots, values, interpolation)
}

/// Lines of a place, two values and two rates there.
fn assert_samples(history: &History, samples: &str) {
    for line in samples.lines() {
        let numbers = line
            .split_whitespace()
            .map(|x| x.parse().expect("a number"));
        let numbers: Vec<f64> = numbers.collect();
        assert_near(&history.at(numbers[0]).expect("inside"), &numbers[1..3]);
        let rates = history.rates_at(numbers[0]).expect("inside");
        assert_near(&rates, &numbers[3..]);
    }
}

// The numbers are from scipy.interpolate.CubicSpline, SciPy 1.17.1.

#[test]
fn a_spline_over_time_is_that_of_scipy_with_ends_not_a_knot() {
    assert_samples(
        &history(7, 1.0, Key::Time, false, true),
        "0.0 -0.802 -1.324 -0.25290565864246095 0.20185019889580788\n\
         3.3 -1.0554561912565956 -0.5634888222472781 0.08184723421749177 0.2534354887461105\n\
         30.0 1.136 0.11 -1.0599283531082817 -0.5715541379670119\n\
         30.7 0.3616202873863829 -0.303364739089766 -1.1390270355188974 -0.6031462031293214\n\
         100.0 7.382534982523985 5.277300184414262 0.22141547980962306 0.1071249081079264\n\
         199.9 0.28780818480390735 -1.2261439110399834 -0.1482202317451855 -0.06872619481197084\n\
         250.0 -0.9580000000000002 1.6 0.1526189813675913 0.22394928953879628",
    );
    let short = [
        (
            2,
            "1.0 -0.7228571428571429 -1.074857142857143 0.07914285714285715 0.24914285714285714\n\
         6.0 -0.3271428571428571 0.17085714285714282 0.07914285714285715 0.24914285714285714",
        ),
        (
            3,
            "1.0 -0.7190633540372671 -1.0223329192546584 0.08230434782608703 0.2929130434782608\n\
         6.0 -0.32334906832298127 0.22338136645962703 0.07598136645962729 0.20537267080745347",
        ),
        (
            4,
            "1.0 -0.9830073435585416 -1.1054638836072732 -0.12854745989493105 0.22650382482875817\n\
         6.0 -0.5417854734440362 0.15458332699539426 0.2671132209405501 0.26557095533865727",
        ),
    ];
    for (n, samples) in short {
        assert_samples(&history(n, 1.0, Key::Time, false, true), samples);
    }
}

#[test]
fn a_spline_over_a_revolution_is_the_periodic_one_of_scipy() {
    assert_samples(
        &history(7, 1.0, Key::AzimuthDeg, true, true),
        "0.0 -0.802 -1.324 0.0010876529133002884 0.22560174128570404\n\
         3.3 -0.7408505339521468 -0.5340785931528389 0.05323516598867527 0.2507567727576007\n\
         30.0 1.136 0.11 -1.0561142388242437 -0.5712946563063152\n\
         300.0 -0.7839271959476446 -2.349994060839274 0.00019290605424807702 -0.10626533349222886\n\
         359.99 -0.8020108710765693 -1.3262555280390913 0.0010865624528546142 0.2255038688984088",
    );
    assert_samples(
        &history(2, 8.0, Key::AzimuthDeg, true, true),
        "1.0 -0.7938330466232546 -1.2982903128356609 0.008262255806928036 0.026009700590762623\n\
         100.0 -0.06366674910961614 1.0002837356549268 0.0007227814602295203 0.002275326474079938\n\
         300.0 -0.9810168678274644 -1.8875476850019783 -0.0013325212702809675 -0.004194796201028875",
    );
    assert_samples(
        &history(3, 8.0, Key::AzimuthDeg, true, true),
        "1.0 -0.8026509485898048 -1.3040497570149885 -0.00037462136893023055 0.020368493400348825\n\
         100.0 0.4609078999068743 1.3429115421741917 0.01563487783382607 0.01201521550735393\n\
         300.0 -0.015025482611745578 -1.2566069598763865 -0.020726834763294066 -0.016862261362596696",
    );
}

#[test]
fn a_spline_of_a_harmonic_has_its_value_and_rate_anywhere() {
    let knots: Vec<f64> = (0..72).map(|i| 5.0 * f64::from(i)).collect();
    let values = knots.iter().map(|psi| psi.to_radians().sin()).collect();
    let path = Path::new("q.csv");
    let history = History::new(path, Key::AzimuthDeg, knots, values, Interpolation::Cubic);
    assert_eq!(history.period(), Some(360.0));
    for at in [-357.7, 0.1, 359.0, 1000.3] {
        let exact = f64::to_radians(at).sin();
        let slope = f64::to_radians(at).cos().to_radians();
        assert!((history.at(at).expect("all round")[0] - exact).abs() < 1e-6);
        assert!((history.rates_at(at).expect("all round")[0] - slope).abs() < 1e-6);
    }
}

#[test]
fn rows_are_met_exactly_and_lines_lie_between_them() {
    for cubic in [false, true] {
        let history = history(7, 1.0, Key::AzimuthDeg, true, cubic);
        for (knot, values) in KNOTS.iter().zip(&VALUES) {
            for turn in [-720.0, 0.0, 360.0] {
                let found = history.at(knot + turn).expect("all round");
                assert_eq!(found, values);
            }
        }
    }
    let history = history(7, 1.0, Key::AzimuthDeg, true, false);
    let wrap = (0.25 * -0.802 + 0.75 * -0.958, (-0.802 + 0.958) / 110.0);
    assert_near(&history.at(277.5).expect("all round")[..1], &[wrap.0]);
    assert_near(&history.rates_at(277.5).expect("all round")[..1], &[wrap.1]);
}

fn azimuths(knots: &[f64], last: f64) -> History {
    let mut values: Vec<f64> = knots.iter().map(|knot| knot.to_radians().cos()).collect();
    *values.last_mut().expect("some") = last;
    let path = Path::new("q.csv");
    let knots = knots.to_vec();
    History::new(path, Key::AzimuthDeg, knots, values, Interpolation::Linear)
}

#[test]
fn a_table_repeats_itself_where_it_goes_round() {
    let by = |step: f64, n: u32| -> Vec<f64> { (0..n).map(|i| f64::from(i) * step).collect() };
    for (knots, period) in [
        (by(10.0, 36), Some(360.0)),
        (by(10.0, 37), Some(360.0)),
        (by(10.0, 108), Some(1080.0)),
        (by(10.0, 73), Some(720.0)),
        (by(120.0, 3), Some(360.0)),
        (vec![0.0, 100.0, 170.0, 265.0], Some(360.0)),
        (vec![0.0, 360.0], Some(360.0)),
        // Two rows have one interval; uneven rows have none that leads back to the first.
        (vec![-90.0, 90.0], None),
        (vec![0.0, 170.0, 190.0], None),
        (vec![0.0, 170.0, 340.0], None),
        (vec![0.0, 50.0, 300.0], None),
        (by(10.0, 35), None),
        (by(90.0, 3), None),
        (vec![0.0, 90.0], None),
    ] {
        let last = knots.last().expect("some").to_radians().cos();
        assert_eq!(azimuths(&knots, last).period(), period, "{knots:?}");
    }
    assert_eq!(azimuths(&by(10.0, 37), 1.1).period(), None);
}

#[test]
fn a_place_outside_of_a_table_is_refused_with_its_range() {
    let quarter = azimuths(&[0.0, 45.0, 90.0], 0.0);
    assert_eq!(
        refusal(quarter.at(120.0)),
        "q.csv: the motion needs azimuth 120 deg, but the table goes from azimuth 0 deg to azimuth 90 deg; its last row is neither at azimuth 360 deg nor one step before it: add the missing rows"
    );
    let changed = azimuths(&[0.0, 90.0, 180.0, 270.0, 360.0], 1.5);
    assert_eq!(
        refusal(changed.at(-1.0)),
        "q.csv: the motion needs azimuth -1 deg, but the table goes from azimuth 0 deg to azimuth 360 deg; its values at azimuth 360 deg differ from those at azimuth 0 deg, so it is not periodic; add the missing rows"
    );
    let time = history(7, 0.001, Key::Time, false, true);
    assert_eq!(
        refusal(time.at(0.3)),
        "beam.csv: the motion needs time 0.3 s, but the table goes from time 0 s to time 0.25 s; add the missing rows"
    );
    assert!(time.at(0.25 * (1.0 + 1e-12)).is_ok(), "round-off is none");
    let one = History::new(
        Path::new("q.csv"),
        Key::Time,
        vec![1.0],
        vec![2.0],
        Interpolation::Cubic,
    );
    assert_eq!(one.at(7.0).expect("one row holds everywhere"), [2.0]);
    assert_eq!(one.rates_at(7.0).expect("everywhere"), [0.0]);
}

#[test]
fn rows_of_a_history_must_go_on() {
    let read = |text: &str| {
        let table = table(text);
        let mut columns = table.columns();
        let key = columns.require_key()?;
        let dx = columns.require("dx")?;
        History::from_table(&table, key, &[dx], Interpolation::Linear)
    };
    assert!(read("time_s,dx\n0,1\n1,2\n").is_ok());
    assert_eq!(
        refusal(read("time_s,dx\n0,1\n\n2,2\n1,2\n")),
        "beam.csv:5: time 1 s comes after time 2 s of line 4; `time_s` must increase from row to row"
    );
    assert_eq!(
        refusal(read("dx,azimuth_deg\n0,1\n2,1\n")),
        "beam.csv:3: azimuth 1 deg repeats azimuth 1 deg of line 2; `azimuth_deg` must increase from row to row"
    );
}

fn span(text: &str, cubic: bool) -> Result<SpanHistory> {
    let table = table(text);
    let mut columns = table.columns();
    let key = columns.optional_key()?;
    let station = columns.require("station")?;
    let dz = columns.require("dz")?;
    columns.done()?;
    let interpolation = if cubic {
        Interpolation::Cubic
    } else {
        Interpolation::Linear
    };
    SpanHistory::from_table(&table, key, station, &[Some(dz)], interpolation)
}

const GRID: &str = "azimuth_deg,station,dz\n180,2,8\n0,1,1\n360,2,2\n0,2,2\n180,1,5\n360,1,1\n";

#[test]
fn a_grid_in_any_order_is_bilinear_and_held_past_its_ends() {
    let span = span(GRID, false).expect("it is complete");
    assert_eq!(span.stations(), [1.0, 2.0]);
    for (azimuth, station, value, rate) in [
        (0.0, 1.0, 1.0, 4.0 / 180.0),
        (90.0, 1.5, 4.0, 5.0 / 180.0),
        (45.0, 0.2, 2.0, 4.0 / 180.0),
        (45.0, 9.0, 3.5, 6.0 / 180.0),
        (270.0, 1.5, 4.0, -5.0 / 180.0),
        (-90.0, 1.5, 4.0, -5.0 / 180.0),
        (360.0, 2.0, 2.0, 6.0 / 180.0),
    ] {
        let row = span.at(azimuth).expect("all round");
        assert_near(&row.values::<1>(station), &[value]);
        assert_near(&row.rates::<1>(station), &[rate]);
    }
}

#[test]
fn azimuths_with_stations_of_their_own_are_interpolated_along_the_span_first() {
    let text = "azimuth_deg,station,dz\n0,0,0\n0,1,1\n180,0.1,1\n180,0.6,0\n180,1.2,6\n";
    let span = span(text, false).expect("each has its own");
    assert_eq!(span.stations(), [0.0, 0.1, 0.6, 1.0, 1.2]);
    for (station, there, back) in [
        (0.0, 0.0, 1.0),
        (0.35, 0.35, 0.5),
        (0.9, 0.9, 3.0),
        (2.0, 1.0, 6.0),
    ] {
        let row = span.at(45.0).expect("all round");
        assert_near(&row.values::<1>(station), &[0.75 * there + 0.25 * back]);
    }
}

#[test]
fn cubic_in_azimuth_is_the_spline_of_every_station() {
    let mut text = String::from("azimuth_deg,station,dz\n");
    for (knot, values) in KNOTS.iter().zip(&VALUES) {
        text += &format!("{knot},3,{}\n{knot},4,{}\n", values[0], values[1]);
    }
    text += &format!("360,3,{}\n360,4,{}\n", VALUES[0][0], VALUES[0][1]);
    let span = span(&text, true).expect("it is complete");
    let row = span.at(3.3 - 360.0).expect("all round");
    let ends = [-0.7408505339521468, -0.5340785931528389];
    let rates = [0.05323516598867527, 0.2507567727576007];
    let mean = |pair: [f64; 2]| 0.5 * (pair[0] + pair[1]);
    // 3.3 - 360 + 360 is 3.3 to 1e-14 only.
    assert!((row.values::<1>(3.5)[0] - mean(ends)).abs() < 1e-13);
    assert!((row.rates::<1>(3.5)[0] - mean(rates)).abs() < 1e-13);
}

#[test]
fn missing_and_repeated_rows_are_told() {
    assert_eq!(
        refusal(span(
            "azimuth_deg,station,dz\n0,1,0\n0,2,0\n10,1,0\n0,3,0\n10,3,0\n",
            false
        )),
        "beam.csv:6: azimuth 10 deg has no row for station 2, which azimuth 0 deg has in line 3; add it"
    );
    assert_eq!(
        refusal(span(
            "azimuth_deg,station,dz\n0,1,0\n0,2,0\n0,1,0.5\n",
            false
        )),
        "beam.csv:4: azimuth 0 deg, station 1 is given twice, first in line 2; keep one of the rows"
    );
    assert_eq!(
        refusal(span("station,dz\n1,0\n2,0\n1,0.5\n", false)),
        "beam.csv:4: station 1 is given twice, first in line 2; keep one of the rows"
    );
}

#[test]
fn stations_without_azimuths_hold_everywhere() {
    let line = span("station,dz\n2,1\n0,0\n", true).expect("a line");
    assert_near(&line.at(1e6).expect("everywhere").values::<1>(0.5), &[0.25]);
}
