//! Tables as users write them, wrong ones, and interpolation compared with SciPy's.

mod interpolation;
mod text;

use super::*;

fn parse(text: &str) -> Result<Table> {
    Table::parse(text.as_bytes(), Path::new("beam.csv"))
}

fn table(text: &str) -> Table {
    parse(text).expect("the table is right")
}

/// The sentence with which a table is refused.
fn refusal<T>(result: Result<T>) -> String {
    match result {
        Ok(_) => panic!("it must be refused"),
        Err(error) => error.to_string(),
    }
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let allowed = 1e-14 * expected.abs().max(1.0);
        assert!((found - expected).abs() <= allowed, "{found} {expected}");
    }
}
