//! Damaged files of every format: always a mesh or an error with a place, never a panic, a hang or a huge allocation.
//!
//! The files are one small mesh written in every way that each format of the list has, sequences, and the small files of
//! other programs in `testdata/`. What is special to a format is in a file of its own.

mod good;
mod msh;
mod su2;
mod ugrid;
mod vtu;

use crate::support::assert_says;
use azimesh_core::error::{Error, ErrorKind, Position};
use azimesh_io::formats::{Format, ReadOptions, parse};
use good::Good;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::TestRunner;

/// Files that are damaged at random in each test: of a small mesh mostly, since those of `testdata/` are larger.
const CASES: u32 = 3000;

/// Damages files at random.
fn damage<T: std::fmt::Debug>(what: impl Strategy<Value = T>, change: impl Fn(&mut Vec<u8>, &T)) {
    let good = Good::all();
    let own = good.own.len();
    let file = prop_oneof![9 => 0..own, 1 => 0..good.files.len()];
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(CASES)
    };
    let run = TestRunner::new(config).run(&(file, what), |(file, what)| {
        let file = &good.files[file];
        let mut bytes = file.bytes.clone();
        change(&mut bytes, &what);
        file.check(&bytes, &what).map_err(TestCaseError::fail)?;
        Ok(())
    });
    run.unwrap();
}

#[test]
fn any_bytes_after_the_start_of_a_file_are_refused_with_a_place() {
    let kept = prop_oneof![1 => Just(0.0), 3 => 0.0..1.0];
    damage((kept, vec(any::<u8>(), 0..400)), |file, (kept, bytes)| {
        file.truncate((file.len() as f64 * kept) as usize);
        file.extend(bytes);
    });
}

#[test]
fn flipped_bytes_are_refused_with_a_place() {
    damage(vec((any::<Index>(), 1u8..), 1..6), |file, flips| {
        for (at, flip) in flips {
            let at = at.index(file.len());
            file[at] ^= flip;
        }
    });
}

#[test]
fn changed_digits_are_refused_with_a_place() {
    damage(vec((any::<Index>(), b'0'..=b'9'), 1..4), |file, changes| {
        let is_digit = |at: &usize| file[*at].is_ascii_digit();
        let digits: Vec<usize> = (0..file.len()).filter(is_digit).collect();
        for (at, digit) in changes.iter().filter(|_| !digits.is_empty()) {
            file[*at.get(&digits)] = *digit;
        }
    });
}

/// At most so many places of a file, evenly.
fn places(n: usize, most: usize) -> impl Iterator<Item = usize> {
    (0..n).step_by(n / most + 1)
}

#[test]
fn truncated_files_are_refused_with_a_place() {
    let good = Good::all();
    for (at, file) in good.files.iter().enumerate() {
        let most = if good.own.contains(&at) { 300 } else { 50 };
        for length in places(file.bytes.len(), most) {
            file.check(&file.bytes[..length], &length).unwrap();
        }
    }
}

/// Every number of a text, and values at every fourth byte, become such that no file can hold what they announce.
fn announce_billions() {
    let good = Good::all();
    for file in &good.files[good.own] {
        let bytes = &file.bytes;
        let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let starts = |at: &usize| is_digit(*at) && (*at == 0 || !is_digit(at - 1));
        let starts: Vec<usize> = (0..bytes.len()).filter(starts).collect();
        for start in places(starts.len(), 80).map(|at| starts[at]) {
            let end = (start..).find(|at| !is_digit(*at)).expect("the file ends");
            for number in ["4000000000", "99999999999", "18446744073709551615"] {
                let changed = [&bytes[..start], number.as_bytes(), &bytes[end..]].concat();
                file.check(&changed, &(start, number)).unwrap();
            }
        }
        let numbers = [
            &0x7fff_fff0_u32.to_le_bytes()[..],
            &0x7fff_fff0_u32.to_be_bytes(),
            &(1_u64 << 40).to_le_bytes(),
            &(1_u64 << 40).to_be_bytes(),
        ];
        for at in places(bytes.len() / 4, 80).map(|at| 4 * at) {
            for number in numbers {
                let mut changed = bytes.clone();
                let end = bytes.len().min(at + number.len());
                changed[at..end].copy_from_slice(&number[..end - at]);
                file.check(&changed, &(at, number)).unwrap();
            }
        }
    }
}

/// In a process of its own, which may take no more memory than it needs to run.
#[cfg(unix)]
#[test]
fn announced_billions_take_no_memory() {
    const LIMITED: &str = "AZIMESH_LIMITED_MEMORY";
    if std::env::var_os(LIMITED).is_some() {
        return announce_billions();
    }
    let name = "bad_input::announced_billions_take_no_memory";
    let output = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 1000000 && exec \"$0\" --exact \"$1\""])
        .arg(std::env::current_exe().unwrap())
        .arg(name)
        .env(LIMITED, "1")
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}{error}");
    assert!(said.contains("1 passed"), "{said}");
}

/// The error that a file of a format is refused with.
fn refusal(format: &Format, bytes: &[u8]) -> Error {
    let error = parse(format, bytes, &ReadOptions::default()).err();
    let error = error.unwrap_or_else(|| panic!("it is read: {}", bytes.escape_ascii()));
    assert_eq!(error.kind, ErrorKind::Input, "{error}");
    error
}

/// A text that is changed, and where and with which numbers and names the changed file is refused.
type Wrong = (
    &'static str,
    &'static str,
    Position,
    &'static [&'static str],
);

/// Each change of a good file of text is refused at its place.
fn refused(format: &Format, good: &str, wrong: &[Wrong]) {
    for (old, new, place, parts) in wrong {
        assert!(good.contains(old), "{old}");
        let error = refusal(format, good.replace(old, new).as_bytes());
        assert_eq!(error.position.as_ref(), Some(place), "{new}: {error}");
        assert_says(&error.message, parts);
    }
}

fn line(line: u64) -> Position {
    Position::Line(line)
}

fn dataset(name: &str) -> Position {
    Position::Dataset(name.to_owned())
}
