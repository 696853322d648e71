//! `$Comments` within another section of a text, which Gmsh itself does not take.

use crate::formats::Notes;
use azimesh_core::diagnostic::formats::Read;

const BEGIN: &[u8] = b"\n$Comments";
const END: &[u8] = b"\n$EndComments";

/// The text with blanks in place of comments within sections, with the same lines; `None` where there are none, and
/// for binary files.
pub(super) fn without(bytes: &[u8], notes: &mut Notes) -> Option<Vec<u8>> {
    let mut plain: Option<Vec<u8>> = None;
    let mut from = 0;
    while let Some(at) = memchr::memmem::find(&bytes[from..], BEGIN).map(|at| from + at) {
        let end = memchr::memmem::find(&bytes[at..], END).map(|n| at + n + END.len())?;
        if let Some(section) = section_at(&bytes[..at]) {
            let text = plain.get_or_insert_with(|| bytes.to_vec());
            let own = text[at..end].iter_mut();
            own.filter(|byte| !matches!(byte, b'\n' | b'\r'))
                .for_each(|byte| *byte = b' ');
            notes.push(Read::CommentsWithin { section });
        }
        from = end;
    }
    plain
}

/// The section that is open at the end of a text.
fn section_at(before: &[u8]) -> Option<String> {
    let mut lines = memchr::memrchr_iter(b'$', before);
    let at = lines.find(|at| *at == 0 || before[at - 1] == b'\n')?;
    let name = before[at + 1..].split(u8::is_ascii_whitespace).next()?;
    let is_name = !name.is_empty() && name.iter().all(u8::is_ascii_alphanumeric);
    let is_text = !before[at..].contains(&0);
    let is_open = is_name && is_text && !name.starts_with(b"End");
    is_open.then(|| String::from_utf8_lossy(name).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn comments_within_a_section_are_passed_over_and_told() {
        let plain = std::fs::read_to_string("testdata/mixed_cells_v22.msh").expect("it is there");
        let comment = "$Comments\nby hand, 1 2 3\n$EndComments\n";
        let at = plain.find("$Nodes").expect("nodes");
        let at = at + plain[at..].find("\n2 ").expect("a second node") + 1;
        let odd = format!("{}{comment}{}", &plain[..at], &plain[at..]);
        let mut notes = Notes::default();
        let blank = without(odd.as_bytes(), &mut notes).expect("it has a comment within");
        assert_eq!(blank.len(), odd.len());
        let section = "Nodes".to_owned();
        assert!(notes.iter().any(|note| {
            *note
                == Read::CommentsWithin {
                    section: section.clone(),
                }
                .into()
        }));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("odd.msh");
        std::fs::write(&path, odd).expect("it can be written");
        let wanted = Mesh::read("testdata/mixed_cells_v22.msh").expect("it is a mesh");
        assert_eq!(Mesh::read(&path).expect("it is a mesh"), wanted);
        let between = plain.replacen("$Nodes", &format!("{comment}$Nodes"), 1);
        assert_eq!(without(between.as_bytes(), &mut Notes::default()), None);
    }
}
