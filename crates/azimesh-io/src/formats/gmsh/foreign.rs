//! Names the format of files that are called .msh but are not Gmsh's.

use super::super::lexer::shown;
use azimesh_core::error::Error;

/// The refusal of a file without `$MeshFormat`.
pub(super) fn refusal(bytes: &[u8]) -> Error {
    let head = bytes.trim_ascii_start();
    let head = &head[..head.len().min(4096)];
    let starts = |text: &str| {
        let start = head.get(..text.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(text.as_bytes()))
    };
    let found = if head.is_empty() {
        "it is empty".to_owned()
    } else if starts("(") {
        "it is a Fluent mesh, which is read as format fluent".to_owned()
    } else if starts("*") {
        "it is an Abaqus or CalculiX mesh (.inp), which gmsh and meshio convert".to_owned()
    } else if starts("MESH") {
        "it is a GiD mesh".to_owned()
    } else if starts("$PostFormat") {
        "it holds Gmsh views (.pos) and no mesh".to_owned()
    } else if starts("MeshVersionFormatted") {
        "it is a Medit mesh (.mesh), which gmsh and meshio convert".to_owned()
    } else if is_format_line(head) {
        "it looks like a Gmsh mesh without section names".to_owned()
    } else {
        format!("it starts with {}", shown(&head[..head.len().min(24)]))
    };
    Error::input(format!(
        "there is no $MeshFormat, so this is not a Gmsh mesh: {found}"
    ))
    .line(1)
}

/// Whether the first line is version, file type and data size, without the line before it.
fn is_format_line(head: &[u8]) -> bool {
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let words: Vec<&[u8]> = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .collect();
    matches!(
        words[..],
        [[b'1'..=b'4', b'.', ..], [b'0' | b'1'], [b'4' | b'8']]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_programs_files_are_named() {
        for (head, word) in [
            ("(0 \"GAMBIT to Fluent File\")", "Fluent"),
            ("*NODE, NSET=Nall", "CalculiX"),
            ("MESH    dimension 2 ElemType Triangle", "GiD"),
            ("\n2.2 0 8\n\n\n7443", "section names"),
            ("27\n7 17 48", "starts with"),
            ("", "empty"),
        ] {
            let sentence = refusal(head.as_bytes()).to_string();
            assert!(sentence.contains(word), "{sentence}");
        }
    }
}
