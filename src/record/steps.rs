//! The rows of steps.csv, written and read back by one list of their columns.

use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::shortest;
use std::collections::BTreeMap;

/// Rows by their step.
pub type Rows = BTreeMap<usize, Row>;

/// A column of steps.csv.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Its name in the file.
    pub name: &'static str,
    /// Its name on the page of a run.
    pub label: &'static str,
    /// Its unit; empty where it has none, or one that depends on the mesh.
    pub unit: &'static str,
    /// True if it holds numbers.
    pub is_number: bool,
}

/// Defines [`Row`] and [`COLUMNS`]: for each column its type, its label and its unit. A number is formatted by [`shortest`],
/// or by the function after `as`.
macro_rules! columns {
    ($($(#[$doc:meta])* $column:ident: $kind:ty $(as $format:ident)? => $label:literal, $unit:literal,)*) => {
        /// Columns of steps.csv, in order.
        pub const COLUMNS: [Column; [$(stringify!($column)),*].len()] = [$(Column {
            name: stringify!($column),
            label: $label,
            unit: $unit,
            is_number: <$kind as Value>::IS_NUMBER,
        }),*];

        /// The values of a step. Unknown values are `None`, and empty in the file.
        #[derive(Debug, Clone, Default, PartialEq)]
        pub struct Row {
            $($(#[$doc])* pub $column: $kind,)*
        }

        impl Row {
            /// Returns the values as text.
            fn texts(&self) -> [String; COLUMNS.len()] {
                [$(self.$column.text(columns!(@format $($format)?))),*]
            }

            /// Parses a row from these values; `None` if one does not fit its column.
            fn of_texts(texts: &[String]) -> Option<Self> {
                let [$($column),*] = texts else { return None };
                Some(Self { $($column: Value::read($column)?),* })
            }

            /// Returns every column with its value if that is a number.
            pub fn numbers(&self) -> [(&'static str, Option<f64>); COLUMNS.len()] {
                [$((stringify!($column), self.$column.number())),*]
            }
        }
    };
    (@format) => { shortest };
    (@format $format:ident) => { $format };
}

columns! {
    /// Number of the step, from 0.
    step: usize => "step", "",
    /// Azimuth in degrees, where the schedule has one.
    azimuth_deg: Option<f64> as decimal => "azimuth", "degrees",
    /// Time in s.
    time_s: Option<f64> as decimal => "time", "s",
    /// Name of the mesh's file.
    file: String => "file", "",
    /// Number of base points.
    base_points: usize => "base points", "",
    /// Largest prescribed displacement of a surface node, in mesh units.
    max_displacement: f64 => "largest displacement", "mesh units",
    /// Largest displacement error before the correction, in mesh units.
    selection_error: f64 => "error before the correction", "mesh units",
    /// Largest distance of a written surface node from its prescribed position, in mesh units.
    max_surface_error: f64 => "largest surface error", "mesh units",
    /// Root mean square of the distances of written surface nodes from their prescribed positions, in mesh units.
    rms_surface_error: f64 => "RMS surface error", "mesh units",
    /// Cells that are valid in the reference mesh and inverted now.
    inverted: Option<usize> => "inverted cells", "",
    /// Cells that are inverted in the reference mesh.
    inverted_reference: Option<usize> => "inverted in the reference", "",
    /// Smallest volume (area in 2D).
    min_volume: Option<f64> => "smallest volume", "",
    /// Smallest scaled Jacobian.
    min_scaled_jacobian: Option<f64> => "smallest scaled Jacobian", "",
    /// Mean scaled Jacobian.
    mean_scaled_jacobian: Option<f64> => "mean scaled Jacobian", "",
    /// First percentile of the scaled Jacobian.
    p01_scaled_jacobian: Option<f64> => "first percentile of the scaled Jacobian", "",
    /// Largest ratio of longest to shortest edge of a cell.
    max_edge_ratio: Option<f64> => "largest edge ratio", "",
    /// Largest equiangle skew.
    max_skew: Option<f64> => "largest equiangle skew", "",
    /// Largest non-orthogonality of a face, in degrees.
    max_non_orthogonality: Option<f64> => "largest non-orthogonality", "degrees",
    /// Smallest size-skew against the reference mesh.
    min_size_skew: Option<f64> => "smallest size-skew", "",
    /// Mean size-skew.
    mean_size_skew: Option<f64> => "mean size-skew", "",
    /// Smallest ratio of a first-cell height to its height in the reference mesh.
    min_first_cell_ratio: Option<f64> => "smallest first-cell height ratio", "",
    /// Largest change of the angle between a wall's normal and the line to its first cell, in degrees.
    max_normal_change_deg: Option<f64> => "largest change of wall normals", "degrees",
    /// Hash of what was written.
    blake3: String => "BLAKE3 of the file", "",
    /// Seconds of computing and writing, in thousandths.
    seconds: f64 as thousandths => "computing and writing", "s",
    /// Cells neither proven to be valid between their corners nor refuted.
    unproven: Option<usize> => "unproven cells", "",
    /// Cells that were untangled.
    repaired: Option<usize> => "repaired cells", "",
    /// The angle whose cosine is the mean of the cosines at inner faces, in degrees.
    mean_non_orthogonality: Option<f64> => "mean non-orthogonality", "degrees",
    /// Largest skewness of a face.
    max_face_skewness: Option<f64> => "largest face skewness", "",
    /// Smallest ratio of the volumes of two neighbours.
    min_volume_ratio: Option<f64> => "smallest volume ratio of neighbours", "",
    /// Smallest interpolation weight of a face.
    min_face_weight: Option<f64> => "smallest face weight", "",
    /// Least Jacobian of a curved cell, relative to its mean in the cell with straight edges.
    min_curved_jacobian: Option<f64> => "least Jacobian of curved cells", "",
    /// Least scaled Jacobian of a curved cell.
    min_curved_scaled_jacobian: Option<f64> => "least scaled Jacobian of curved cells", "",
}

impl Row {
    /// Returns the row as a line of the file, with its checksum and line end.
    pub fn line(&self) -> String {
        let texts = self.texts();
        let checksum = checksum(&texts);
        joined(texts.iter().chain([&checksum]).map(String::as_str))
    }
}

/// A value of a column.
trait Value: Sized {
    const IS_NUMBER: bool;
    /// Formats the value; numbers with a fraction are formatted by `format`.
    fn text(&self, format: fn(f64) -> String) -> String;
    /// Parses the value.
    fn read(text: &str) -> Option<Self>;
    /// Returns the value as a number, if it is one.
    fn number(&self) -> Option<f64>;
}

impl Value for usize {
    const IS_NUMBER: bool = true;

    fn text(&self, _: fn(f64) -> String) -> String {
        self.to_string()
    }

    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    fn number(&self) -> Option<f64> {
        Some(*self as f64)
    }
}

impl Value for f64 {
    const IS_NUMBER: bool = true;

    fn text(&self, format: fn(f64) -> String) -> String {
        format(*self)
    }

    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    fn number(&self) -> Option<f64> {
        Some(*self)
    }
}

impl Value for String {
    const IS_NUMBER: bool = false;

    fn text(&self, _: fn(f64) -> String) -> String {
        self.clone()
    }

    fn read(text: &str) -> Option<Self> {
        Some(text.to_owned())
    }

    fn number(&self) -> Option<f64> {
        None
    }
}

impl<T: Value> Value for Option<T> {
    const IS_NUMBER: bool = T::IS_NUMBER;

    fn text(&self, format: fn(f64) -> String) -> String {
        self.as_ref()
            .map_or_else(String::new, |value| value.text(format))
    }

    fn read(text: &str) -> Option<Self> {
        match text {
            "" => Some(None),
            text => T::read(text).map(Some),
        }
    }

    fn number(&self) -> Option<f64> {
        self.as_ref().and_then(T::number)
    }
}

/// Returns the shortest text that reads back as the same number, without an exponent.
fn decimal(value: f64) -> String {
    value.to_string()
}

fn thousandths(value: f64) -> String {
    format!("{value:.3}")
}

/// Returns the names of all columns, in order.
fn names() -> [&'static str; COLUMNS.len()] {
    COLUMNS.map(|column| column.name)
}

/// The last column of the file, which is not a value of a step: a checksum of the row.
pub const CHECKSUM: &str = "checksum";

/// Returns the first 16 hexadecimal digits of the BLAKE3 hash of the values of a row without its seconds, each followed by a comma.
fn checksum(texts: &[String]) -> String {
    let mut hasher = blake3::Hasher::new();
    let columns = names().into_iter().zip(texts);
    for (_, text) in columns.filter(|(name, _)| *name != "seconds") {
        hasher.update(text.as_bytes());
        hasher.update(b",");
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Returns the header of a file.
fn header() -> Vec<&'static str> {
    names().into_iter().chain([CHECKSUM]).collect()
}

/// Returns the text of a table.
pub fn text(rows: &Rows) -> String {
    rows.values()
        .fold(joined(header()), |text, row| text + &row.line())
}

/// Reads the rows in the bytes of a table. It leaves out a last row that a killed run has cut, rows damaged by a power cut,
/// and rows that differ from their checksum.
///
/// # Errors
/// If the table has other columns.
pub fn parse(bytes: &[u8]) -> Result<Rows> {
    let mut lines = lines(bytes);
    if let Some((line, Some(found))) = lines.next()
        && found != header()
    {
        return Err(Error::input(format!(
            "the columns are \"{}\"; this version has \"{}\"",
            found.join(","),
            header().join(",")
        ))
        .line(line));
    }
    let rows = lines.filter_map(|(_, values)| {
        let mut values = values?;
        let is_as_written = values.pop()? == checksum(&values);
        Row::of_texts(&values).filter(|_| is_as_written)
    });
    Ok(rows.map(|row| (row.step, row)).collect())
}

/// Returns the complete lines of a table, with their numbers from 1 and their values; `None` for a line that is not text.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, Option<Vec<String>>)> {
    let ended = bytes
        .split_inclusive(|byte| *byte == b'\n')
        .filter_map(|line| line.strip_suffix(b"\n"));
    let values = ended.map(|line| {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let text = std::str::from_utf8(line).ok();
        text.filter(|text| !text.contains('\0')).map(cut)
    });
    (1..).zip(values)
}

fn joined<'a>(values: impl IntoIterator<Item = &'a str>) -> String {
    let values: Vec<String> = values.into_iter().map(quoted).collect();
    values.join(",") + "\n"
}

fn quoted(value: &str) -> String {
    if value.contains([',', '"', '\n']) {
        format!("\"{}\"", value.replace('"', "\"\""))
    } else {
        value.to_owned()
    }
}

/// Returns the values of a line.
fn cut(line: &str) -> Vec<String> {
    let mut values = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        let value = values.last_mut().expect("there is always one");
        match character {
            '"' if is_quoted && characters.next_if_eq(&'"').is_some() => value.push('"'),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => values.push(String::new()),
            _ => value.push(character),
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_they_were() {
        for value in [0.0, 1.0, 37.0, 0.1 + 0.2, 1e-17, -2.9753038973609e-9, 1e300] {
            assert_eq!(shortest(value).parse::<f64>(), Ok(value));
        }
        assert_eq!(shortest(1e-17), "1e-17");
    }

    #[test]
    fn a_row_has_the_text_of_each_of_its_values() {
        let row = Row {
            step: 3,
            azimuth_deg: Some(1e-5),
            max_displacement: 1e-5,
            file: "a, \"b\".vtu".to_owned(),
            inverted: Some(0),
            max_edge_ratio: Some(f64::INFINITY),
            seconds: 0.25,
            ..Row::default()
        };
        let line = row.line();
        assert_eq!(
            line,
            format!(
                "3,0.00001,,\"a, \"\"b\"\".vtu\",0,1e-5,0,0,0,0,,,,,,inf,,,,,,,,0.250,,,,,,,,,{}\n",
                checksum(&row.texts())
            )
        );
        let table = text(&[(3, row.clone())].into());
        assert_eq!(parse(table.as_bytes()).expect("it is whole")[&3], row);
        let changed = text(&[(3, row.clone())].into()).replace(",0.25", ",0.75");
        assert_eq!(
            parse(changed.as_bytes()).expect("seconds may differ").len(),
            1
        );
        let changed = changed.replace("inf", "1e9");
        assert_eq!(parse(changed.as_bytes()).expect("it is a table").len(), 0);
        let of = |column: &str| {
            let numbers = row.numbers();
            let found = numbers.into_iter().find(|(name, _)| *name == column);
            found.expect("it is a column").1
        };
        assert_eq!(
            (of("inverted"), of("inverted_reference")),
            (Some(0.0), None)
        );
        assert_eq!((of("azimuth_deg"), of("file")), (Some(1e-5), None));
    }
}
