//! The result of a run in sentences: motion, accuracy, quality of the cells.

use super::folder::Sequence;
use azimesh_core::error::counted;
use azimesh_core::numbers::{in_digits, short};

/// Motions that have a sentence.
const MOTIONS: usize = 4;

/// The sentences, most important first.
pub fn sentences(sequence: &Sequence) -> Vec<String> {
    if sequence.table.len() == 0 {
        return Vec::new();
    }
    let mut sentences = vec![steps(sequence)];
    sentences.extend(bodies(sequence));
    sentences.extend(accuracy(sequence));
    sentences.extend(quality(sequence));
    sentences.extend(folded(sequence));
    sentences
}

fn steps(sequence: &Sequence) -> String {
    let table = &sequence.table;
    let span = |column: &str, unit: &str| {
        let values: Vec<f64> = table.numbers(column).into_iter().flatten().collect();
        let (first, last) = (values.first()?, values.last()?);
        (first != last).then(|| format!("{} to {}{unit}", short(*first), short(*last)))
    };
    let azimuth = span("azimuth_deg", "°").map(|span| format!("azimuth {span}"));
    let time = span("time_s", " s").map(|span| format!("time {span}"));
    let spans: Vec<String> = azimuth.into_iter().chain(time).collect();
    let n = counted(table.len(), "step");
    let parts: Vec<String> = std::iter::once(n).chain(spans).collect();
    format!("{}.", parts.join(", "))
}

/// A sentence for each motion; bodies that move alike share one.
fn bodies(sequence: &Sequence) -> Vec<String> {
    let mut motions: Vec<(String, Vec<&str>)> = Vec::new();
    for body in sequence.bodies() {
        let Some(words) = motion(sequence, &body.name) else {
            continue;
        };
        match motions.iter_mut().find(|(other, _)| *other == words) {
            Some((_, names)) => names.push(&body.name),
            None => motions.push((words, vec![&body.name])),
        }
    }
    let shown = motions.iter().take(MOTIONS);
    let mut sentences: Vec<String> = shown
        .map(|(words, names)| format!("{}: {words}.", names.join(", ")))
        .collect();
    if motions.len() > MOTIONS {
        sentences.push(format!("Further motions: {}.", motions.len() - MOTIONS));
    }
    sentences
}

fn motion(sequence: &Sequence, body: &str) -> Option<String> {
    let range = |key: &str| sequence.table.range(&format!("{body}/{key}"));
    let mut words = Vec::new();
    if let Some([_, most]) = range("max_displacement") {
        words.push(format!(
            "moved by up to {} {}",
            figures(most),
            sequence.length_unit()
        ));
    }
    for (name, key) in [
        ("pitch", "pitch_deg"),
        ("flap", "flap_deg"),
        ("lag", "lag_deg"),
        ("angle", "angle_deg"),
    ] {
        if let Some([least, most]) = range(key) {
            words.push(format!("{name} {}° to {}°", rounded(least), rounded(most)));
        }
    }
    (!words.is_empty()).then(|| words.join(", "))
}

fn accuracy(sequence: &Sequence) -> Option<String> {
    let unit = sequence.length_unit();
    let [_, error] = sequence.table.range("max_surface_error")?;
    let mut words = match error {
        0.0 => "Surfaces are exactly where the motion puts them".to_owned(),
        _ => format!(
            "Surfaces are within {} {unit} of where the motion puts them",
            figures(error)
        ),
    };
    let mut before = Vec::new();
    if let Some([_, error]) = sequence.table.range("selection_error") {
        before.push(format!("{} before the correction", figures(error)));
    }
    if let Some(tolerance) = sequence.record.options.tolerance {
        before.push(format!("tolerance {}", figures(tolerance)));
    }
    if !before.is_empty() {
        words += &format!(" ({})", before.join(", "));
    }
    if let Some([_, n]) = sequence.table.range("base_points") {
        words += &format!("; {} base points", short(n));
    }
    Some(words + ".")
}

fn quality(sequence: &Sequence) -> Option<String> {
    let row = sequence.table.worst()?;
    let [least, _] = sequence.table.range("min_scaled_jacobian")?;
    let step = sequence.table.step(row);
    let mut words = format!(
        "The smallest scaled Jacobian is {}, at step {step}",
        figures(least)
    );
    if let Some([ratio, _]) = sequence.table.range("min_first_cell_ratio") {
        words += &format!(
            "; first cells keep at least {} of their height",
            figures(ratio)
        );
    }
    Some(words + ".")
}

fn folded(sequence: &Sequence) -> Option<String> {
    let [_, most] = sequence.table.range("inverted")?;
    let steps_with = |column: &str| {
        let values = sequence.table.numbers(column);
        values.into_iter().flatten().filter(|n| *n > 0.0).count()
    };
    let repaired = match steps_with("repaired") {
        0 => String::new(),
        n => format!(" Cells were repaired at {}.", counted(n, "step")),
    };
    Some(match steps_with("inverted") {
        0 => format!("No cell is inverted at any step.{repaired}"),
        n => format!(
            "Cells are inverted at {}: {} at most.{repaired}",
            counted(n, "step"),
            short(most)
        ),
    })
}

/// Three figures, which are enough in a sentence.
fn figures(value: f64) -> String {
    in_digits(value, 3)
}

/// An angle as people say it.
fn rounded(angle_deg: f64) -> String {
    short((angle_deg * 100.0).round() / 100.0 + 0.0)
}
