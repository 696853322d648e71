//! Which steps are looked at closely.

use super::table::Table;

/// Steps spread over the sequence that are drawn, the last one among them.
const SPREAD: usize = 4;

/// The row with the worst cell: the smallest scaled Jacobian, or without quality the largest
/// displacement. Of several the first.
pub fn worst(table: &Table) -> Option<usize> {
    let jacobian = table.numbers("min_scaled_jacobian");
    let values = match table.has("min_scaled_jacobian") {
        true => jacobian,
        false => {
            let displacement = table.numbers("max_displacement").into_iter();
            displacement
                .map(|value| value.map(|value| -value))
                .collect()
        }
    };
    let known = values
        .iter()
        .enumerate()
        .filter_map(|(row, value)| Some((row, (*value)?)));
    let (row, _) = known.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(row)
}

/// The row whose surface has moved least, which stands in for a reference mesh that is gone.
pub fn calmest(table: &Table) -> Option<usize> {
    let moved = table.numbers("max_displacement").into_iter().enumerate();
    let known = moved.map(|(row, value)| (row, value.unwrap_or(f64::INFINITY)));
    let (row, _) = known.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(row)
}

/// The rows that are drawn, ascending: some evenly over the sequence, and the worst.
pub fn drawn(table: &Table) -> Vec<usize> {
    let Some(last) = table.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut rows: Vec<usize> = (1..=SPREAD)
        .map(|i| (last * i + SPREAD / 2) / SPREAD)
        .collect();
    rows.extend(worst(table));
    rows.sort_unstable();
    rows.dedup();
    rows
}
