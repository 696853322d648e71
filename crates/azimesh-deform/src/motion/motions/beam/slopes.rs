//! Checks that the rotations in a table are the slopes of its displacements, as in a bent blade.

use super::SIX;
use crate::motion::table::{Naming, RotationForm, SpanHistory, Table};
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::{Note, note};

/// Slopes and rotations below this (radians, root mean square) do not determine a sign.
const LEAST: f64 = 1e-3;
/// Correlations of rotations and slopes beyond which they contradict or match each other.
const OPPOSITE: f64 = -0.5;
const ALIKE: f64 = 0.9;
/// Rotations that are larger or smaller than the slopes by this factor have another unit.
const OTHER_UNIT: f64 = 5.0;

/// A displacement, its rotation, and the rotation for a slope of one.
const PAIRS: [(usize, usize, f64); 2] = [(2, 4, -1.0), (1, 5, 1.0)];

/// Sums over all intervals between stations, with the steepest one.
#[derive(Default)]
struct Sums {
    slopes: f64,
    rotations: f64,
    products: f64,
    n: f64,
    /// Slope and rotation in radians, the stations and the row.
    steepest: (f64, f64, [f64; 2], usize),
}

/// Warns where `rot_y` is not the slope of `dz`, or `rot_z` not the slope of `dy`.
pub(super) fn check_slopes(
    span: &SpanHistory,
    table: &Table,
    (naming, form): (&Naming, RotationForm),
    body: &str,
) -> Vec<Note> {
    let found = PAIRS.iter().filter_map(|&(shift, turn, sign)| {
        let sums = sums(span, shift, turn, sign);
        let [slope, rotation] = [sums.slopes, sums.rotations].map(|sum| (sum / sums.n).sqrt());
        let correlation = sums.products / (sums.slopes * sums.rotations).sqrt();
        let factor = rotation / slope;
        let is_opposite = correlation < OPPOSITE;
        let is_scaled =
            correlation > ALIKE && !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&factor);
        if slope.max(rotation) < LEAST || !(is_opposite || is_scaled) {
            return None;
        }
        let (slope, rotation, [from, to], row) = sums.steepest;
        let names = [SIX[shift], SIX[turn]];
        let place = match span.history().n_rows() {
            1 => String::new(),
            _ => format!(" at {}", span.history().place_of(row)),
        };
        let seen = format!(
            "between the stations {} and {}{place} the slope of {} is {} deg, so that {} should be near {} deg; the table has {} deg",
            short(from),
            short(to),
            names[0],
            degrees(sign * slope),
            names[1],
            degrees(slope),
            degrees(rotation)
        );
        let column = naming.angle_in(table, form.columns()[turn - 3]);
        Some(if is_opposite {
            note!(
                "slope_sign",
                "body \"{body}\": {} contradicts the slope of {}: {seen}. If its sign follows another convention, write  columns = {{ {} = \"{}\" }}",
                names[1],
                names[0],
                column.0,
                column.1
            )
        } else {
            note!(
                "slope_size",
                "body \"{body}\": {} is {} times the slope of {}: {seen}. Check `units` of {} and {}",
                names[1],
                in_digits(factor, 2),
                names[0],
                column.0,
                names[0]
            )
        })
    });
    found.map(|note| note.file(table.path())).collect()
}

fn sums(span: &SpanHistory, shift: usize, turn: usize, sign: f64) -> Sums {
    let stations = span.stations();
    let mut sums = Sums::default();
    for (at, row) in span.history().rows().enumerate() {
        let values = |station: usize| &row[station * SIX.len()..][..SIX.len()];
        for i in 1..stations.len() {
            let (inner, outer) = (values(i - 1), values(i));
            let rise = outer[shift] - inner[shift];
            let slope = sign * (rise / (stations[i] - stations[i - 1])).atan();
            let rotation = 0.5 * (inner[turn] + outer[turn]);
            sums.slopes += slope * slope;
            sums.rotations += rotation * rotation;
            sums.products += slope * rotation;
            sums.n += 1.0;
            if slope.abs() > sums.steepest.0.abs() {
                sums.steepest = (slope, rotation, [stations[i - 1], stations[i]], at);
            }
        }
    }
    sums
}

fn degrees(angle: f64) -> String {
    in_digits(angle.to_degrees(), 3)
}
