//! What the columns of steps.csv are called on the page, and their units.

use crate::record::COLUMNS;

/// Columns of the motion of a body, as the page makes them from run.json: name, label, unit.
const OF_BODY: [(&str, &str, &str); 6] = [
    ("pitch_deg", "pitch", "degrees"),
    ("flap_deg", "flap", "degrees"),
    ("lag_deg", "lag", "degrees"),
    ("tip_x", "tip displacement along x", "mesh units"),
    ("tip_y", "tip displacement along y", "mesh units"),
    ("tip_z", "tip displacement along z", "mesh units"),
];

/// Name and unit of a column. `body/pitch_deg` is that of a body; a column that is not known is called
/// as it is.
fn label(column: &str) -> (String, &'static str) {
    let (body, key) = match column.rsplit_once('/') {
        Some((body, key)) => (format!("{body}: "), key),
        None => (String::new(), column),
    };
    let of_step = COLUMNS.iter().map(|of| (of.name, of.label, of.unit));
    let mut all = of_step.chain(OF_BODY);
    let known = all.find(|(name, _, _)| *name == key);
    let (name, unit) = known.map_or((key, ""), |(_, label, unit)| (label, unit));
    (format!("{body}{name}"), unit)
}

/// Label and unit of a column of a run, whose mesh may be of known dimension: volumes have their unit from
/// that, and are areas in a plane.
pub fn label_in(dimension: Option<usize>, column: &str) -> (String, &'static str) {
    match (column, dimension) {
        ("min_volume", Some(2)) => ("smallest area".to_owned(), "mesh units²"),
        ("min_volume", Some(3)) => ("smallest volume".to_owned(), "mesh units³"),
        _ => label(column),
    }
}

/// Whether a column of steps.csv holds numbers; `None` for one that this version does not know.
pub fn holds_numbers(column: &str) -> Option<bool> {
    let known = COLUMNS.iter().find(|known| known.name == column);
    known.map(|known| known.is_number)
}
