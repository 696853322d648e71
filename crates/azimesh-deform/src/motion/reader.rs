//! Reads values from a parsed TOML document and keeps their line numbers.
//!
//! Owns the kinds of values and the errors of keys and values; knows nothing of what the keys mean.

use super::names::{Pattern, list};
use super::places::{MOST_TURNED, Places, is_angle};
use azimesh_core::error::{Error, Position, Result, nearest_name};
use std::cell::Cell;
use toml::de::{DeTable, DeValue};

/// A table whose keys have been checked.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    lines: &'a Lines,
    title: &'static str,
    table: &'a DeTable<'a>,
    /// Line where the table starts.
    pub line: u64,
}

/// A key and its value.
#[derive(Clone, Copy)]
pub(super) struct Entry<'a> {
    lines: &'a Lines,
    key: &'a str,
    value: &'a DeValue<'a>,
    /// Byte offset of the key, or of the element in an array.
    offset: usize,
}

/// Unit of the angles in the schedule.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum AngleUnit {
    #[default]
    Degrees,
    Radians,
}

impl AngleUnit {
    pub(super) fn to_radians(self, angle: f64) -> f64 {
        match self {
            Self::Degrees => angle.to_radians(),
            Self::Radians => angle,
        }
    }

    pub(super) fn to_degrees(self, angle: f64) -> f64 {
        match self {
            Self::Degrees => angle,
            Self::Radians => angle.to_degrees(),
        }
    }
}

/// The ends of the lines of a schedule, and the unit of its angles.
pub(super) struct Lines {
    ends: Vec<usize>,
    pub unit: Cell<AngleUnit>,
}

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        Self {
            ends: text.match_indices('\n').map(|(at, _)| at).collect(),
            unit: Cell::default(),
        }
    }

    /// One-based line of a byte offset.
    pub(super) fn at(&self, offset: usize) -> u64 {
        1 + self.ends.partition_point(|end| *end < offset) as u64
    }
}

impl<'a> Section<'a> {
    /// The whole document.
    pub(super) fn root(lines: &'a Lines, table: &'a DeTable<'a>, title: &'static str) -> Self {
        Self {
            lines,
            title,
            table,
            line: 1,
        }
    }

    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<Entry<'a>> {
        let (name, value) = self.table.get_key_value(key)?;
        Some(Entry {
            lines: self.lines,
            key: name.get_ref(),
            value: value.get_ref(),
            offset: name.span().start,
        })
    }

    /// The value of a required key; `example` is a valid line.
    pub(super) fn require(&self, key: &str, example: &str) -> Result<Entry<'a>> {
        self.get(key).ok_or_else(|| {
            self.error(format!(
                "{} has no `{key}`; add for example  {example}",
                self.title
            ))
        })
    }

    /// Reads an optional key with `read`; `None` where it is left out.
    pub(super) fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Entry<'a>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(|entry| read(&entry)).transpose()
    }

    /// Refuses a key if another key, to which it belongs, is missing.
    pub(super) fn only_with(&self, key: &str, other: &str) -> Result<()> {
        match (self.get(key), self.get(other)) {
            (Some(entry), None) => {
                Err(entry.error(&format!("belongs to `{other}`, which is not given")))
            }
            _ => Ok(()),
        }
    }

    /// Returns the lines of the keys of this table and of its subtables, by names such as `rbf.kernel`.
    pub(super) fn places(&self) -> Places {
        let mut places = Places::default();
        self.add_places("", self.table, &mut places);
        places
    }

    fn add_places(&self, before: &str, table: &DeTable<'_>, places: &mut Places) {
        for (key, value) in table {
            let name = format!("{before}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(inner) => self.add_places(&format!("{name}."), inner, places),
                DeValue::Array(array) => {
                    for (at, element) in array.iter().enumerate() {
                        if let DeValue::Table(inner) = element.get_ref() {
                            self.add_places(&format!("{name}.{at}."), inner, places);
                            let line = self.lines.at(element.span().start);
                            places.add(format!("{name}.{at}"), line);
                        }
                    }
                }
                _ => {}
            }
            places.add(name, self.lines.at(key.span().start));
        }
    }

    /// An error at the table's first line.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        Error::input(message).line(self.line)
    }

    /// Refuses the first unknown key.
    pub(super) fn check_keys(&self, known: &[&str]) -> Result<()> {
        let wrong = |name: &str| !known.contains(&name);
        let first = self
            .table
            .keys()
            .filter(|key| wrong(key.get_ref()))
            .min_by_key(|key| key.span().start);
        let Some(key) = first else {
            return Ok(());
        };
        let name: &str = key.get_ref();
        let message = unknown(&format!("key `{name}` in {}", self.title), name, known);
        Err(Error::input(message).line(self.lines.at(key.span().start)))
    }
}

/// Formats "unknown ...; did you mean ...?", then all known names.
fn unknown(what: &str, found: &str, known: &[&str]) -> String {
    let all = list(known.iter().copied());
    match nearest_name(found, known.iter().copied()) {
        Some(name) => format!("unknown {what}; did you mean `{name}`? known: {all}"),
        None => format!("unknown {what}; known: {all}"),
    }
}

impl<'a> Entry<'a> {
    /// Line of the key, or of the element in an array.
    pub(super) fn line(&self) -> u64 {
        self.lines.at(self.offset)
    }

    /// The unit of angles.
    pub(super) fn unit(&self) -> AngleUnit {
        self.lines.unit.get()
    }

    /// A name or a glob.
    pub(super) fn pattern(&self) -> Result<Pattern> {
        Ok(Pattern {
            text: self.string()?.to_owned(),
            place: Some(Position::Line(self.line())),
        })
    }

    /// A list of names or globs that is not empty.
    pub(super) fn patterns(&self) -> Result<Vec<Pattern>> {
        let elements = self.elements("strings")?;
        if elements.is_empty() {
            return Err(self.error(match self.key {
                "tags" => "is empty; name the tags of the body",
                "zones" => "is empty; name the zones, or leave the key out",
                _ => "is empty; name the tags, or leave the key out",
            }));
        }
        elements.iter().map(Self::pattern).collect()
    }

    /// Returns an error at this line: the value of the key is wrong.
    pub(super) fn error(&self, message: &str) -> Error {
        Error::input(format!("`{}` {message}", self.key)).line(self.line())
    }

    fn expected(&self, expected: &str) -> Error {
        let found = match self.value {
            DeValue::String(text) => format!("the string \"{}\"", text.escape_debug()),
            DeValue::Integer(number) => format!("the integer {number}"),
            DeValue::Float(number) => format!("the number {number}"),
            DeValue::Boolean(value) => format!("{value}"),
            DeValue::Datetime(date) => format!("the date {date}"),
            DeValue::Array(array) => format!("an array of {}", array.len()),
            DeValue::Table(_) => "a table".to_owned(),
        };
        self.error(&format!("is {found}; it must be {expected}"))
    }

    /// A finite number.
    pub(super) fn number(&self) -> Result<f64> {
        self.number_or("a finite number")
    }

    fn number_or(&self, expected: &str) -> Result<f64> {
        let number = match self.value {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(int) => i64::from_str_radix(int.as_str(), int.radix())
                .ok()
                .map(|int| int as f64),
            _ => None,
        };
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.expected(expected))
    }

    /// A finite number greater than 0.
    pub(super) fn positive(&self) -> Result<f64> {
        let expected = "a number greater than 0";
        let number = self.number_or(expected)?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.expected(expected))
        }
    }

    /// An angle, in radians.
    pub(super) fn angle(&self) -> Result<f64> {
        let expected = "an angle, a finite number";
        let angle = self.unit().to_radians(self.number_or(expected)?);
        if is_angle(angle) {
            Ok(angle)
        } else {
            Err(self.error(&format!(
                "is {angle:e} radians, too many turns for an accurate position; it must be {expected} of at \
                 most {MOST_TURNED:e} radians"
            )))
        }
    }

    /// A whole number greater than 0.
    pub(super) fn count(&self) -> Result<usize> {
        let number = match self.value {
            DeValue::Integer(int) => usize::from_str_radix(int.as_str(), int.radix()).ok(),
            _ => None,
        };
        number
            .filter(|number| *number > 0)
            .ok_or_else(|| self.expected("a whole number greater than 0"))
    }

    /// 1 or -1, as a factor.
    pub(super) fn sign(&self) -> Result<f64> {
        match self.value {
            DeValue::Integer(int) if int.radix() == 10 => match int.as_str() {
                "1" | "+1" => Ok(1.0),
                "-1" => Ok(-1.0),
                _ => Err(self.expected("1 or -1")),
            },
            _ => Err(self.expected("1 or -1")),
        }
    }

    /// Returns whether it is a table, and not a single value or an array.
    pub(super) fn is_table(&self) -> bool {
        matches!(self.value, DeValue::Table(_))
    }

    /// Returns whether it is an array.
    pub(super) fn is_array(&self) -> bool {
        matches!(self.value, DeValue::Array(_))
    }

    /// `true` or `false`.
    pub(super) fn boolean(&self) -> Result<bool> {
        match self.value {
            DeValue::Boolean(value) => Ok(*value),
            _ => Err(self.expected("true or false")),
        }
    }

    /// A string that is not empty.
    pub(super) fn string(&self) -> Result<&'a str> {
        match self.value {
            DeValue::String(text) if !text.is_empty() => Ok(text),
            _ => Err(self.expected("a string that is not empty")),
        }
    }

    /// One of a few names.
    pub(super) fn choice<T: Copy>(&self, known: &[(&str, T)]) -> Result<T> {
        let names = || known.iter().map(|(name, _)| *name);
        let DeValue::String(found) = self.value else {
            return Err(self.expected(&format!("one of the strings {}", list(names()))));
        };
        let found: &str = found;
        if let Some((_, value)) = known.iter().find(|(name, _)| *name == found) {
            return Ok(*value);
        }
        let all: Vec<&str> = names().collect();
        let what = format!("{} \"{}\"", self.key, found.escape_debug());
        Err(Error::input(unknown(&what, found, &all)).line(self.line()))
    }

    /// The elements of an array, each with its own line.
    pub(super) fn elements(&self, of: &str) -> Result<Vec<Entry<'a>>> {
        let DeValue::Array(array) = self.value else {
            return Err(self.expected(&format!("an array of {of}")));
        };
        let element = |value: &'a toml::Spanned<DeValue<'a>>| Entry {
            value: value.get_ref(),
            offset: value.span().start,
            ..*self
        };
        Ok(array.iter().map(element).collect())
    }

    /// `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let expected = format!("{N} finite numbers in brackets");
        let DeValue::Array(array) = self.value else {
            return Err(self.expected(&expected));
        };
        if array.len() != N {
            return Err(self.error(&format!("has {} numbers; it must have {N}", array.len())));
        }
        let mut numbers = [0.0; N];
        for (number, element) in numbers.iter_mut().zip(self.elements("numbers")?) {
            *number = element.number()?;
        }
        Ok(numbers)
    }

    /// The table under this key.
    pub(super) fn section(&self, title: &'static str, known: &[&str]) -> Result<Section<'a>> {
        let DeValue::Table(table) = self.value else {
            return Err(self.expected(&format!("a table, {title}")));
        };
        let section = Section {
            lines: self.lines,
            title,
            table,
            line: self.line(),
        };
        section.check_keys(known)?;
        Ok(section)
    }
}
