//! What some programs write into text formats that others do not: exponents of Fortran, comments.

use super::lexer::line_of;

/// Characters that begin a comment, besides `%` of SU2.
pub const COMMENTS: &[u8] = b"%#!";

/// A number whose exponent is Fortran's, as in `1.0D-3`, at the start of a word; with its length.
pub fn fortran_real(text: &[u8]) -> Option<(f64, usize)> {
    let n = text.iter().take_while(|b| !b.is_ascii_whitespace()).count();
    let at = text[..n].iter().position(|b| b"dD".contains(b))?;
    let mut word = text[..n].to_vec();
    word[at] = b'e';
    let value = fast_float2::parse::<f64, _>(&word).ok()?;
    value.is_finite().then_some((value, n))
}

/// The line of the first word that is a number with Fortran's exponent; `None` without one.
pub fn first_fortran_real(bytes: &[u8]) -> Option<u64> {
    let found = memchr::memchr2_iter(b'd', b'D', bytes).find(|&at| {
        let begins = |b: &u8| b.is_ascii_whitespace();
        let start = bytes[..at].iter().rposition(begins).map_or(0, |at| at + 1);
        at > start && fortran_real(&bytes[start..]).is_some()
    });
    found.map(|at| line_of(bytes, at))
}

/// Number of lines that begin with `#` or `!`, and of those that end with a comment behind a blank. A line that begins
/// with `%` is a comment of SU2 and counts nowhere.
pub fn n_comments(bytes: &[u8]) -> (usize, usize) {
    let (mut n_lines, mut n_trailing, mut next) = (0, 0, 0);
    for at in memchr::memchr2_iter(b'#', b'!', bytes) {
        if at < next {
            continue;
        }
        let start = memchr::memrchr(b'\n', &bytes[..at]).map_or(0, |end| end + 1);
        let before = &bytes[start..at];
        match before.trim_ascii() {
            [] => n_lines += 1,
            [b'%', ..] => {}
            _ if before.ends_with(b" ") || before.ends_with(b"\t") => n_trailing += 1,
            _ => continue,
        }
        next = memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |n| at + n);
    }
    (n_lines, n_trailing)
}

/// The text with spaces in place of comments, from `#` or `!` to the end of the line, for formats of numbers alone;
/// `None` where there is none.
pub fn without_comments(bytes: &[u8]) -> Option<Vec<u8>> {
    let first = memchr::memchr2(b'#', b'!', bytes)?;
    let mut text = bytes.to_vec();
    let mut at = first;
    loop {
        let rest = &mut text[at..];
        let n = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        rest[..n].fill(b' ');
        match memchr::memchr2(b'#', b'!', &text[at + n..]) {
            Some(next) => at += n + next,
            None => return Some(text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{ReadOptions, Source, read};
    use crate::mesh::Mesh;
    use azimesh_core::diagnostic::Diagnostic;
    use azimesh_core::diagnostic::formats::Read;
    use std::path::Path;

    fn load(name: &str, text: String) -> (Mesh, Vec<Diagnostic>) {
        let source = Source::from_bytes(Path::new(name), text.into_bytes());
        let loaded = read(&source.into(), &ReadOptions::default());
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        (loaded.mesh, loaded.notes.iter().cloned().collect())
    }

    fn testdata(name: &str) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("testdata")
            .join(name);
        std::fs::read_to_string(path).expect("the file is there")
    }

    #[test]
    fn su2_files_with_comments_exponents_and_spellings_of_others_are_read_and_told() {
        let plain = "NDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\nNMARK= 1\nMARKER_TAG= wall#1\n\
                     MARKER_ELEMS= 1\n3 0 1\n";
        let odd = "# made by a tool, with a=b\n  ! twice\nNDIME= 2 ! plane\nNELEM= 1\n9 0 1 2 3 # one\nNPOIN= 4\n0.0D0 0\n\
                   1.0d+0 0.0 ! node\n1 1\n0 10.0D-1\nNMARK= 1\nMARKERTAG= wall#1 # wall\nMARKER_ELEMS= 1\n3 0 1\n";
        let (wanted, notes) = load("m.su2", plain.to_owned());
        assert_eq!(notes, []);
        let (mesh, notes) = load("m.su2", odd.to_owned());
        assert_eq!(mesh, wanted);
        assert_eq!(mesh.groups[0].name, "wall#1");
        let spelled = Read::Spelled {
            found: "MARKERTAG",
            meant: "MARKER_TAG",
        };
        for note in [
            spelled,
            Read::FortranExponents { line: 7 },
            Read::CommentLines { n: 2 },
            Read::TrailingComments { n: 4 },
        ] {
            assert!(notes.contains(&note.clone().into()), "{note:?}: {notes:?}");
        }
        let trailing = plain.replacen("1 0\n", "1 0 ! node\n", 1);
        let (mesh, notes) = load("m.su2", trailing);
        assert_eq!(mesh, wanted);
        assert_eq!(notes, [Read::TrailingComments { n: 1 }.into()]);
    }

    #[test]
    fn ugrid_text_with_comments_and_exponents_of_fortran_is_read_and_told() {
        let plain = testdata("mixed_cells.ugrid");
        let (counts, rest) = plain.split_once('\n').expect("counts come first");
        let lines = rest.lines().map(|line| match line.contains('.') {
            true => {
                line.split(' ')
                    .map(|x| format!("{x}D0 "))
                    .collect::<String>()
                    + "! a node\n"
            }
            false => format!("{line}\n"),
        });
        let odd = format!("# a mesh\n{counts} ! counts\n{}", lines.collect::<String>());
        let (wanted, _) = load("m.ugrid", plain.clone());
        let (mesh, notes) = load("m.ugrid", odd);
        assert_eq!(mesh, wanted);
        for note in [
            Read::FortranExponents { line: 3 },
            Read::CommentLines { n: 1 },
        ] {
            assert!(notes.contains(&note.clone().into()), "{note:?}: {notes:?}");
        }
    }

    #[test]
    fn msh_files_without_the_ends_of_sections_are_read_and_told() {
        let plain = testdata("mixed_cells_v22.msh");
        let is_end = |line: &&str| line.starts_with("$End") && *line != "$EndMeshFormat";
        let lines = plain.lines().filter(|line| !is_end(line));
        let odd: String = lines.map(|line| format!("{line}\n")).collect();
        let (wanted, _) = load("m.msh", plain.clone());
        let (mesh, notes) = load("m.msh", odd);
        assert_eq!(mesh, wanted);
        let told = notes
            .iter()
            .map(ToString::to_string)
            .find(|note| note.contains("$Elements"));
        assert!(
            told.is_some_and(|note| note.contains("$Nodes")),
            "{notes:?}"
        );
    }

    #[test]
    fn exponents_of_fortran_are_numbers_and_names_with_a_d_are_not() {
        assert_eq!(fortran_real(b"1.5D-3 7"), Some((1.5e-3, 6)));
        assert_eq!(fortran_real(b"-2d+00"), Some((-2.0, 6)));
        assert_eq!(fortran_real(b"1.0D"), None);
        assert_eq!(fortran_real(b"NDIME="), None);
        assert_eq!(
            first_fortran_real(b"NDIME= 2\nside3d 3D\n1 2.0D0\n"),
            Some(3)
        );
        assert_eq!(first_fortran_real(b"NDIME= 2\n3 4d\n"), None);
    }

    #[test]
    fn comments_are_counted_and_blanked_without_moving_what_is_behind() {
        let text = b"# a\n1 2 ! counts\n \t!b\n3#\n";
        assert_eq!(n_comments(text), (2, 1));
        assert_eq!(n_comments(b"% a # b\nname#1\n1 % of # 2 ! 3\n"), (0, 1));
        let blanked = without_comments(text).expect("there are comments");
        assert_eq!(blanked, b"   \n1 2         \n \t  \n3 \n");
        assert!(without_comments(b"1 2\n").is_none());
    }
}
