//! The text of a table: lines, fields, numbers.

use super::Table;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel;
use std::borrow::Cow;
use std::path::Path;

/// Bytes of rows that one task parses at a time.
const CHUNK: usize = 1 << 18;

/// An error and the line, counted from 0 in its piece of text.
type Located<T> = std::result::Result<T, (u64, String)>;

/// Reads a table; errors have lines and no file.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Table> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let message = "the table is UTF-16 text; save it as UTF-8 or plain ASCII";
        return Err(Error::input(message).line(1));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut header = Header::find(bytes).map_err(at_line(1))?;
    let units = header.take_units(bytes);
    header.check_first_row(bytes).map_err(at_line(1))?;
    let rest = &bytes[header.end..];
    let parts = parallel::map_items(chunks(rest), &|_, chunk| Rows::parse(chunk, &header));
    let mut table = Table {
        path: path.to_path_buf(),
        names: header.names,
        header: header.line + 1,
        units,
        ..Table::default()
    };
    let mut first = header.rows_line + 1;
    for part in parts {
        let part = part.map_err(at_line(first))?;
        table.values.extend(part.values);
        // A file of more lines than this is an error at the last line with a number.
        let line = |line: u32| u32::try_from(first + u64::from(line)).unwrap_or(u32::MAX);
        table.lines.extend(part.lines.into_iter().map(line));
        first += part.n_lines;
    }
    if table.lines.is_empty() {
        Err(table.header_error("the table has no rows after the names of its columns"))
    } else {
        Ok(table)
    }
}

fn at_line(first: u64) -> impl Fn((u64, String)) -> Error {
    move |(line, message)| Error::input(message).line(first + line)
}

/// The names of the columns, and where the rows start.
struct Header {
    names: Vec<String>,
    delimiter: u8,
    /// Lines of the names and of the first row, from 0.
    line: u64,
    rows_line: u64,
    /// Number of bytes before the first row.
    end: usize,
}

impl Header {
    /// Finds the line above a line of units, otherwise the first line that is neither blank nor a comment. If that is a row of
    /// numbers, the comment before it is used if it has a name for each.
    fn find(bytes: &[u8]) -> Located<Self> {
        let mut comment: Option<(u64, &[u8])> = None;
        let (first, mut start) = above_units(bytes).unwrap_or((0, 0));
        for (line, text) in (first..).zip(Lines(&bytes[start..])) {
            let end = (start + text.len() + 1).min(bytes.len());
            let content = without_comment(text).trim_ascii();
            if let Some(names) = text.trim_ascii().strip_prefix(b"#") {
                comment = Some((line, names));
            } else if !content.is_empty() {
                let here = Self::of_line(content, line, end);
                let are_numbers = numbers_of(content);
                let Some(n) = are_numbers else { return here };
                if let Some((above, names)) = comment
                    && let Ok(header) = Self::of_line(names, above, start)
                    && header.names.len() == n
                {
                    return Ok(Self {
                        rows_line: line,
                        ..header
                    });
                }
                let message =
                    "the first line has numbers; it must name the columns, as in azimuth_deg,dx,dy";
                return Err((line, message.into()));
            }
            start = end;
        }
        Err((
            0,
            "the table is empty; it must name its columns in its first line".into(),
        ))
    }

    /// Takes a line of units in brackets from below the names, with its number counted from 1.
    fn take_units(&mut self, bytes: &[u8]) -> Option<(u64, Vec<String>)> {
        let mut end = self.end;
        for (n, text) in (1..).zip(Lines(&bytes[self.end..])) {
            end = (end + text.len() + 1).min(bytes.len());
            let content = without_comment(text).trim_ascii();
            if content.is_empty() {
                continue;
            }
            let units = units_of(content, self.delimiter);
            let units = units.filter(|units| units.len() == self.names.len())?;
            self.end = end;
            self.rows_line += n;
            return Some((self.rows_line, units));
        }
        None
    }

    /// Refuses text in place of the first row: the names are then not where they seem to be, or not between what they seem to be.
    fn check_first_row(&self, bytes: &[u8]) -> Located<()> {
        let mut lines = (self.rows_line..).zip(Lines(&bytes[self.end..]));
        let Some((line, text)) =
            lines.find(|(_, text)| !without_comment(text).trim_ascii().is_empty())
        else {
            return Ok(());
        };
        let text = without_comment(text).trim_ascii();
        let mut fields = Fields::of(text, self.delimiter);
        let number = |field: Cow<'_, [u8]>| number_between(&field, self.delimiter).is_some();
        // The error of a wrong quote names its column.
        if fields.any(|field| field.map_or(true, number)) {
            return Ok(());
        }
        let between = match self.delimiter {
            b',' => "commas",
            b';' => "semicolons",
            b'\t' => "tabs",
            _ => "blanks",
        };
        let message = format!(
            "found \"{}\" below the names of the columns; a row is a number for each column between {between}. Text above the names \
             needs a line of units in brackets below them",
            shown(text)
        );
        Err((line, message))
    }

    fn of_line(text: &[u8], line: u64, end: usize) -> Located<Self> {
        let wrong = |message: String| (line, message);
        let delimiter = delimiter_of(text);
        let mut names: Vec<String> = Vec::new();
        for field in Fields::of(text, delimiter) {
            let field = field.map_err(wrong)?;
            let name = String::from_utf8_lossy(&field).into_owned();
            if name.is_empty() {
                let place = names.len() + 1;
                return Err(wrong(format!(
                    "column {place} has no name; give it one, or remove the column"
                )));
            }
            if names.contains(&name) {
                return Err(wrong(format!(
                    "two columns have the name `{name}`; keep one of them"
                )));
            }
            names.push(name);
        }
        Ok(Self {
            names,
            delimiter,
            line,
            rows_line: line + 1,
            end,
        })
    }
}

/// Any blanks between the fields of a line.
const BLANKS: u8 = b' ';

/// Returns the separator of the fields of a line: its first comma, semicolon or tab, else blanks.
fn delimiter_of(line: &[u8]) -> u8 {
    let found = line.iter().copied().find(|b| b",;\t".contains(b));
    found.unwrap_or(BLANKS)
}

/// The line above the first one of as many units in brackets, and where it begins: what comes before it in a file of OpenFAST is
/// no table.
fn above_units(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut start = 0;
    let mut above: Option<(u64, usize, &[u8])> = None;
    for (line, text) in (0..).zip(Lines(bytes)) {
        let content = without_comment(text).trim_ascii();
        if let Some((at, from, names)) = above
            && let Some(units) = units_of(content, delimiter_of(names))
            && units.len() == Fields::of(names, delimiter_of(names)).count()
        {
            return Some((at, from));
        }
        if numbers_of(content).is_some_and(|n| n > 0) {
            return None;
        }
        if !content.is_empty() {
            above = Some((line, start, content));
        }
        start += text.len() + 1;
    }
    None
}

/// The units of a line that has nothing else.
fn units_of(line: &[u8], delimiter: u8) -> Option<Vec<String>> {
    let units = Fields::of(line, delimiter).map(|unit| in_brackets(&unit.ok()?));
    units
        .collect::<Option<Vec<String>>>()
        .filter(|units| !units.is_empty())
}

/// Returns the text in the brackets of a unit.
fn in_brackets(unit: &[u8]) -> Option<String> {
    let inside = match unit {
        [b'(', inside @ .., b')'] | [b'[', inside @ .., b']'] => inside.trim_ascii(),
        _ => return None,
    };
    Some(String::from_utf8_lossy(inside).into_owned())
}

/// Returns how many numbers a line has, if it has nothing else.
fn numbers_of(line: &[u8]) -> Option<usize> {
    let mut n = 0;
    let delimiter = delimiter_of(line);
    for field in Fields::of(line, delimiter) {
        number_between(&field.ok()?, delimiter)?;
        n += 1;
    }
    Some(n)
}

/// Splits text into pieces of about `CHUNK` bytes that end with a line.
fn chunks(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut chunks = Vec::new();
    while !bytes.is_empty() {
        let least = CHUNK.min(bytes.len());
        let more = memchr::memchr(b'\n', &bytes[least - 1..]);
        let end = more.map_or(bytes.len(), |at| least + at);
        let (chunk, rest) = bytes.split_at(end);
        chunks.push(chunk);
        bytes = rest;
    }
    chunks
}

/// The rows of one piece of text.
#[derive(Default)]
struct Rows {
    values: Vec<f64>,
    /// Line of each, from 0.
    lines: Vec<u32>,
    n_lines: u64,
}

impl Rows {
    fn parse(text: &[u8], header: &Header) -> Located<Self> {
        let mut rows = Self::default();
        for line in Lines(text) {
            let number = rows.n_lines;
            rows.n_lines += 1;
            let is_row = rows.add(line, header);
            if is_row.map_err(|message| (number, message))? {
                rows.lines.push(number as u32);
            }
        }
        Ok(rows)
    }

    /// Adds the numbers of a line; returns whether there are any.
    fn add(&mut self, line: &[u8], header: &Header) -> std::result::Result<bool, String> {
        let line = without_comment(line);
        if line.iter().all(u8::is_ascii_whitespace) {
            return Ok(false);
        }
        let names = &header.names;
        let mut n = 0;
        for field in Fields::of(line, header.delimiter) {
            let field = field?;
            if let Some(name) = names.get(n) {
                let value = number_between(&field, header.delimiter);
                let value = value.ok_or_else(|| not_a_number(name, &field))?;
                self.values.push(value);
            }
            n += 1;
        }
        if n != names.len() {
            let fields = if n == 1 { "field" } else { "fields" };
            let remedy = match header.delimiter {
                b',' if n > names.len() => {
                    "; if commas are decimal, put semicolons between the columns"
                }
                _ => "",
            };
            return Err(format!(
                "the row has {n} {fields}; it must have {}, one for each column{remedy}",
                names.len()
            ));
        }
        Ok(true)
    }
}

fn not_a_number(name: &str, field: &[u8]) -> String {
    if field.is_empty() {
        return format!("column `{name}` is empty; it must be a finite number");
    }
    let shown = shown(field);
    let remedy = match with_point(field) {
        Some(_) => "; write decimals with a point, or put semicolons between the columns",
        None => "",
    };
    format!("column `{name}` has \"{shown}\"; it must be a finite number{remedy}")
}

/// The start of a text, for a message.
fn shown(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    text.chars().take(40).flat_map(char::escape_debug).collect()
}

/// Reads a number; between semicolons it may have a decimal comma.
fn number_between(field: &[u8], delimiter: u8) -> Option<f64> {
    number(field).or_else(|| with_point(field).filter(|_| delimiter == b';'))
}

/// The number that a field with a decimal comma is.
fn with_point(field: &[u8]) -> Option<f64> {
    let at = memchr::memchr(b',', field).filter(|_| !field.contains(&b'.'))?;
    let mut field = field.to_vec();
    field[at] = b'.';
    number(&field)
}

/// Parses a finite number; exponents may be Fortran's, as in `1.0D-3`.
pub(super) fn number(field: &[u8]) -> Option<f64> {
    let value = fast_float2::parse::<f64, _>(field).ok().or_else(|| {
        let at = field.iter().position(|b| b"dD".contains(b))?;
        let mut field = field.to_vec();
        field[at] = b'e';
        fast_float2::parse::<f64, _>(&field).ok()
    });
    // Adding 0 turns -0 into 0.
    value
        .filter(|value| value.is_finite())
        .map(|value| value + 0.0)
}

/// Returns the line before a `#` that is not in quotes.
fn without_comment(line: &[u8]) -> &[u8] {
    let mut quoted = false;
    for at in memchr::memchr2_iter(b'#', b'"', line) {
        match line[at] {
            b'"' => quoted = !quoted,
            _ if !quoted => return &line[..at],
            _ => {}
        }
    }
    line
}

/// Lines without their ends.
struct Lines<'a>(&'a [u8]);

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.0.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', self.0);
        let line = &self.0[..end.unwrap_or(self.0.len())];
        self.0 = end.map_or(&[], |end| &self.0[end + 1..]);
        Some(line)
    }
}

/// Fields of a line, without quotes and white space around them.
struct Fields<'a> {
    rest: Option<&'a [u8]>,
    delimiter: u8,
}

impl<'a> Fields<'a> {
    fn of(line: &'a [u8], delimiter: u8) -> Self {
        Self {
            rest: Some(line),
            delimiter,
        }
    }

    /// Returns the end of the field at the beginning of a text.
    fn end(&self, text: &[u8]) -> Option<usize> {
        match self.delimiter {
            BLANKS => text.iter().position(u8::is_ascii_whitespace),
            delimiter => memchr::memchr(delimiter, text),
        }
    }

    /// Parses a field in quotes: returns its end, and the text with `""` as one quote.
    fn quoted(&mut self, text: &'a [u8]) -> std::result::Result<Cow<'a, [u8]>, String> {
        let mut content = Vec::new();
        let mut at = 1;
        loop {
            let Some(length) = memchr::memchr(b'"', &text[at..]) else {
                return Err("a quote is not closed on its line".into());
            };
            content.extend_from_slice(&text[at..at + length]);
            at += length + 1;
            if text.get(at) != Some(&b'"') {
                break;
            }
            content.push(b'"');
            at += 1;
        }
        let after = self.end(&text[at..]);
        let end = after.map_or(text.len(), |length| at + length);
        if !text[at..end].iter().all(u8::is_ascii_whitespace) {
            return Err("text follows a quote that closes; put the whole field in quotes".into());
        }
        self.rest = after.map(|_| &text[end + 1..]);
        Ok(Cow::Owned(content.trim_ascii().to_vec()))
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = std::result::Result<Cow<'a, [u8]>, String>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut text = self.rest.take()?;
        if self.delimiter == BLANKS {
            text = text.trim_ascii();
            if text.is_empty() {
                return None;
            }
        }
        let blanks = text.iter().take_while(|b| **b == b' ').count();
        if text.get(blanks) == Some(&b'"') {
            return Some(self.quoted(&text[blanks..]));
        }
        let end = self.end(text);
        self.rest = end.map(|end| &text[end + 1..]);
        Some(Ok(Cow::Borrowed(
            text[..end.unwrap_or(text.len())].trim_ascii(),
        )))
    }
}
