//! What the columns of steps.csv are called on the page, and their units.

/// Column, name, unit.
const COLUMNS: [(&str, &str, &str); 30] = [
    ("step", "step", ""),
    ("azimuth_deg", "azimuth", "degrees"),
    ("time_s", "time", "s"),
    ("base_points", "base points", ""),
    ("max_displacement", "largest displacement", "mesh units"),
    (
        "selection_error",
        "error before the correction",
        "mesh units",
    ),
    ("max_surface_error", "largest surface error", "mesh units"),
    ("rms_surface_error", "RMS surface error", "mesh units"),
    ("inverted", "inverted cells", ""),
    ("inverted_reference", "inverted in the reference", ""),
    ("min_volume", "smallest volume", ""),
    ("min_scaled_jacobian", "smallest scaled Jacobian", ""),
    ("mean_scaled_jacobian", "mean scaled Jacobian", ""),
    (
        "p01_scaled_jacobian",
        "first percentile of the scaled Jacobian",
        "",
    ),
    ("max_edge_ratio", "largest edge ratio", ""),
    ("max_skew", "largest equiangle skew", ""),
    (
        "max_non_orthogonality",
        "largest non-orthogonality",
        "degrees",
    ),
    ("min_size_skew", "smallest size-skew", ""),
    ("mean_size_skew", "mean size-skew", ""),
    (
        "min_first_cell_ratio",
        "smallest first-cell height ratio",
        "",
    ),
    (
        "max_normal_change_deg",
        "largest change of wall normals",
        "degrees",
    ),
    ("seconds", "computing and writing", "s"),
    ("file", "file", ""),
    ("blake3", "BLAKE3 of the file", ""),
    ("pitch_deg", "pitch", "degrees"),
    ("flap_deg", "flap", "degrees"),
    ("lag_deg", "lag", "degrees"),
    ("tip_x", "tip displacement along x", "mesh units"),
    ("tip_y", "tip displacement along y", "mesh units"),
    ("tip_z", "tip displacement along z", "mesh units"),
];

/// Columns of text.
const TEXT: [&str; 2] = ["file", "blake3"];

/// Name and unit of a column. `body/pitch_deg` is that of a body; a column that is not known is called
/// as it is.
fn label(column: &str) -> (String, &'static str) {
    let (body, key) = match column.rsplit_once('/') {
        Some((body, key)) => (format!("{body}: "), key),
        None => (String::new(), column),
    };
    let known = COLUMNS.iter().find(|(name, _, _)| *name == key);
    let (name, unit) = known.map_or((key, ""), |(_, label, unit)| (*label, *unit));
    (format!("{body}{name}"), unit)
}

/// The same for a mesh of known dimension, which volumes have their unit from: in a plane they are areas.
pub fn label_in(dimension: Option<usize>, column: &str) -> (String, &'static str) {
    match (column, dimension) {
        ("min_volume", Some(2)) => ("smallest area".to_owned(), "mesh units²"),
        ("min_volume", Some(3)) => ("smallest volume".to_owned(), "mesh units³"),
        _ => label(column),
    }
}

/// Whether a column holds numbers, as far as is known.
pub fn is_number(column: &str) -> bool {
    COLUMNS.iter().any(|(name, _, _)| *name == column) && !is_text(column)
}

/// Whether a column holds text.
pub fn is_text(column: &str) -> bool {
    TEXT.contains(&column)
}
