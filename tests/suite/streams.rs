//! Standard input and output, compressed files, and pipes whose reader leaves.

use crate::support::{Args, azimesh, short, succeed};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

const PLANE: &str = "NDIME= 2\nNELEM= 2\n5 0 1 2 0\n5 1 3 2 1\nNPOIN= 4\n0.0 0.0 0\n1.0 0.0 1\n\
                     0.0 1.0 2\n1.0 1.0 3\nNMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\n";

/// A tetrahedron whose faces are in tag 1.
const SOLID: &str = "4 4 0 1 0 0 0\n0.0 0.0 0.0\n1.0 0.0 0.0\n0.0 1.0 0.0\n0.0 0.0 1.0\n1 3 2\n\
                     1 2 4\n2 3 4\n3 1 4\n1\n1\n1\n1\n1 2 3 4\n";

fn program(folder: &Path, args: impl Args) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_azimesh"));
    command.current_dir(folder).args(args.words());
    command
}

/// Runs the program with `input` in a pipe.
fn piped(args: impl Args, input: &[u8]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let mut child = program(folder.path(), args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    let feeder = std::thread::spawn(move || {
        let _ = stdin.write_all(&input); // the program may refuse before it has read all
    });
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    output
}

#[test]
fn a_mesh_goes_through_a_pipe_from_one_format_into_another() {
    let vtu = piped("convert - - --format vtu", PLANE.as_bytes());
    assert!(vtu.status.success(), "{vtu:?}");
    assert!(vtu.stdout.starts_with(b"<?xml"));
    let su2 = piped("convert - - --format su2", &vtu.stdout);
    assert_eq!(String::from_utf8(su2.stdout).unwrap(), PLANE);
    let info = piped("info - --json", &vtu.stdout);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!(info["nodes"], 4);
}

#[test]
fn binary_ugrid_in_a_pipe_is_known_by_its_counts() {
    for flavour in ["ugrid-b8", "ugrid-lb4", "ugrid-lr8", "ugrid-b8l"] {
        let binary = piped(format!("convert - - --format {flavour}"), SOLID.as_bytes());
        assert!(binary.status.success(), "{binary:?}");
        let text = piped("convert - - --format ugrid", &binary.stdout);
        assert_eq!(String::from_utf8(text.stdout).unwrap(), SOLID, "{flavour}");
    }
}

#[test]
fn what_needs_a_file_beside_it_is_refused_on_standard_output() {
    let args = "convert - - --format ugrid --rename-tag 1=wing";
    let run = piped(args, SOLID.as_bytes());
    assert_eq!(run.status.code(), Some(2));
    assert!(run.stdout.is_empty());
    let message = String::from_utf8(run.stderr).unwrap();
    assert!(
        message.contains("standard output can hold only one"),
        "{message}"
    );
    let run = piped("convert - -", PLANE.as_bytes());
    assert_eq!(run.status.code(), Some(2));
    let message = String::from_utf8(run.stderr).unwrap();
    assert!(message.contains("give --format"), "{message}");
    let run = piped("info -", b"nothing of a mesh");
    assert_eq!(run.status.code(), Some(2));
}

#[test]
fn a_file_on_standard_input_is_read_from_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.su2");
    fs::write(&path, format!("a line of somebody else\n{PLANE}")).unwrap();
    let mut file = File::open(&path).unwrap();
    file.read_exact(&mut [0; 24]).unwrap();
    let output = program(folder.path(), "convert - - --format su2")
        .stdin(file)
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), PLANE);
    let empty = File::open("/dev/null").unwrap();
    let output = program(folder.path(), "info -").stdin(empty).output();
    assert_eq!(output.unwrap().status.code(), Some(2));
}

#[test]
fn a_reader_that_leaves_ends_the_program_quietly() {
    let folder = tempfile::tempdir().unwrap();
    let sample = "sample naca0012 --nodes 20000 -o n.vtu";
    succeed(folder.path(), sample);
    let mut child = program(folder.path(), "convert n.vtu - --format su2")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut start = [0; 9];
    child.stdout.take().unwrap().read_exact(&mut start).unwrap(); // and the pipe is closed
    let output = child.wait_with_output().unwrap();
    assert_eq!(&start, b"NDIME= 2\n");
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
}

#[test]
fn a_compressed_file_is_read_whatever_it_is_called() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let gzip = |text: &str| {
        let mut file = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        file.write_all(text.as_bytes()).unwrap();
        file.finish().unwrap()
    };
    fs::write(folder.join("plane.su2.gz"), gzip(PLANE)).unwrap();
    fs::write(folder.join("plane"), gzip(PLANE)).unwrap();
    succeed(folder, "diff plane.su2.gz plane");
    // Numbers behind the last cell: only the name tells what this is.
    fs::write(folder.join("solid.ugrid.gz"), gzip(SOLID)).unwrap();
    fs::write(folder.join("solid.mapbc"), "1\n1 4000 wing\n").unwrap();
    let info = succeed(folder, "info solid.ugrid.gz");
    assert!(info.out.contains("wing"), "{info:?}");
    let run = azimesh(folder, "convert plane out.su2.gz");
    assert_eq!(run.code, 2);
    assert!(run.err.contains("write out.su2 and compress it"), "{run:?}");
}

#[test]
fn names_beside_a_mesh_are_replaced_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("in.ugrid"), SOLID).unwrap();
    fs::write(folder.join("in.mapbc"), "1\n1 4000 wing\n").unwrap();
    fs::write(folder.join("out.mapbc"), "mine").unwrap();
    let run = azimesh(folder, "convert in.ugrid out.b8.ugrid");
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.err.contains("out.mapbc: exists already"), "{run:?}");
    assert!(!folder.join("out.b8.ugrid").exists());
    succeed(folder, "convert --force in.ugrid out.b8.ugrid");
    let text = fs::read_to_string(folder.join("out.mapbc")).unwrap();
    assert_eq!(text, "1\n1 4000 wing\n");
}

#[cfg(unix)]
#[test]
fn a_run_takes_its_inputs_from_pipes_and_is_not_resumed_without_their_hashes() {
    let folder = short();
    let bash = |line: &str| {
        let path = Path::new(env!("CARGO_BIN_EXE_azimesh")).parent().unwrap();
        let line = format!("PATH={}:$PATH; timeout 120 {line}", path.display());
        let output = Command::new("bash")
            .args(["-c", &line])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        (output.status.code().unwrap(), err)
    };
    for (out, inputs) in [
        ("a", "n.vtu <(cat few.toml)"),
        ("b", "<(cat n.vtu) few.toml"),
    ] {
        let (code, err) = bash(&format!("azimesh -q deform {inputs} -o {out}"));
        assert_eq!((code, err.as_str()), (0, ""), "{inputs}");
        let (code, err) = bash(&format!("azimesh -q deform {inputs} -o {out} --resume"));
        assert_eq!(code, 2, "{inputs}: {err}");
        assert!(err.contains("pipe"), "{inputs}: {err}");
    }
}
