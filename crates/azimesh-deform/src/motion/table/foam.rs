//! The table of OpenFOAM's `tabulated6DoFMotion`: a list of `(time ((x y z) (rotations in degrees)))`.

use super::{RotationForm, Table};
use azimesh_core::error::{Error, Result, counted};
use std::path::Path;

const NAMES: [&str; 7] = [
    "time_s",
    "dx",
    "dy",
    "dz",
    "rot_x_deg",
    "rot_y_deg",
    "rot_z_deg",
];
/// A row; `#` stands for a number.
const ROW: &[u8] = b"(#((###)(###)))";

/// Returns whether a text is a list.
pub(super) fn is_list(bytes: &[u8]) -> bool {
    let mut tokens = Tokens { bytes, line: 1 };
    let first = tokens.next();
    let is_count = first.is_some_and(|(_, word)| word.iter().all(u8::is_ascii_digit));
    let first = if is_count { tokens.next() } else { first };
    first.is_some_and(|(_, word)| word == b"(")
}

/// Reads the list; errors have lines and no file.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Table> {
    let mut tokens = Tokens { bytes, line: 1 };
    let mut table = Table {
        path: path.to_path_buf(),
        names: NAMES.map(str::to_owned).to_vec(),
        header: 1,
        rotation: Some(RotationForm::EulerXyz),
        ..Table::default()
    };
    let count = tokens.next().filter(|(_, word)| *word != b"(");
    if count.is_some() {
        tokens.next();
    }
    loop {
        match tokens.next() {
            Some((_, b")")) => break,
            first => read_row(first, &mut tokens, &mut table)?,
        }
    }
    let n = table.lines.len();
    if let Some((line, word)) = count
        && super::text::number(word) != Some(n as f64)
    {
        let message = format!(
            "the list has {}, and its count is {}",
            counted(n, "row"),
            word.escape_ascii()
        );
        return Err(Error::input(message).line(line));
    }
    match tokens.next() {
        Some((line, _)) => Err(Error::input("text follows the end of the list").line(line)),
        None if n == 0 => Err(Error::input("the list has no rows").line(1)),
        None => Ok(table),
    }
}

fn read_row<'a>(
    first: Option<(u64, &'a [u8])>,
    tokens: &mut Tokens<'a>,
    table: &mut Table,
) -> Result<()> {
    let mut token = first;
    for (at, expected) in ROW.iter().enumerate() {
        if at > 0 {
            token = tokens.next();
        }
        let number = token.and_then(|(_, word)| super::text::number(word));
        match (token, expected, number) {
            (Some((line, _)), b'#', Some(number)) => {
                if at == 1 {
                    table.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
                }
                table.values.push(number);
            }
            (Some((_, word)), paren, _) if word == [*paren] => {}
            _ => {
                let (line, found) = token
                    .map_or((tokens.line, "the end".into()), |(line, word)| {
                        (line, format!("`{}`", word.escape_ascii()))
                    });
                let message = format!(
                    "a row of OpenFOAM's table is (time ((x y z) (rot_x rot_y rot_z))) with angles in degrees; found {found}"
                );
                return Err(Error::input(message).line(line));
            }
        }
    }
    Ok(())
}

/// Words and parentheses with their lines; comments are skipped.
struct Tokens<'a> {
    bytes: &'a [u8],
    line: u64,
}

impl<'a> Tokens<'a> {
    fn skip(&mut self, n: usize) -> &'a [u8] {
        let (passed, rest) = self.bytes.split_at(n);
        self.line += memchr::memchr_iter(b'\n', passed).count() as u64;
        self.bytes = rest;
        passed
    }

    fn skip_comments(&mut self) {
        loop {
            let text = self.bytes;
            let blanks = text.len() - text.trim_ascii_start().len();
            self.skip(blanks);
            let rest = self.bytes;
            let length = if rest.starts_with(b"//") {
                memchr::memchr(b'\n', rest).unwrap_or(rest.len())
            } else if rest.starts_with(b"/*") {
                memchr::memmem::find(rest, b"*/").map_or(rest.len(), |at| at + 2)
            } else {
                return;
            };
            self.skip(length);
        }
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        self.skip_comments();
        let line = self.line;
        let ends = |b: &u8| b.is_ascii_whitespace() || b"()".contains(b);
        let length = match self.bytes.first()? {
            b'(' | b')' => 1,
            _ => self.bytes.iter().position(ends).unwrap_or(self.bytes.len()),
        };
        Some((line, self.skip(length)))
    }
}
