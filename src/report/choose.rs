//! Which steps are looked at closely.

use super::table::Table;

/// Steps whose meshes are read: at most, at least, and nodes of all of them together between these bounds.
const FRAMES: usize = 120;
const FEWEST: usize = 9;
const NODES: usize = 60_000_000;

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

/// The rows whose meshes are read, ascending: all, or of a long sequence or a large mesh some evenly and the worst.
pub fn frames(table: &Table, n_nodes: usize) -> Vec<usize> {
    let Some(last) = table.len().checked_sub(1) else {
        return Vec::new();
    };
    let most = (NODES / n_nodes.max(1)).clamp(FEWEST, FRAMES);
    if table.len() <= most {
        return (0..table.len()).collect();
    }
    let gaps = most - 2;
    let mut rows: Vec<usize> = (0..=gaps).map(|i| (last * i + gaps / 2) / gaps).collect();
    rows.extend(worst(table));
    rows.sort_unstable();
    rows.dedup();
    rows
}
