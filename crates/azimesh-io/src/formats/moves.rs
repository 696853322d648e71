//! Gives staged files and folders their names, all or none. A signal that ends the program waits until all are in place. The moves of
//! a program that is killed among them are in a list on the disk, and the next one that reads or writes there completes them.

use super::save::exists;
use super::staged::{
    Temporary, folder_of, lists_of_killed, lock, registry, remove, sync_file, sync_folder,
};
use azimesh_core::error::{Error, Result};
use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// A staged file or folder, and the name that it gets.
pub(super) struct Move {
    pub from: PathBuf,
    pub to: PathBuf,
    /// True if what has the name is replaced; otherwise that is an error.
    pub replace: bool,
    /// True if the list of the moves is synced to the disk.
    pub sync: bool,
}

/// Actions that restore the state before, in reverse order. A file that cannot be restored matters less than the error that
/// is reported.
type Undo = Vec<Box<dyn FnOnce()>>;

/// Makes all moves, in order. After an error the files that were there before have their names again.
pub(super) fn make_all(mut moves: Vec<Move>) -> Result<()> {
    drop_equal(&mut moves)?;
    // A single rename is one call: nothing can be seen between.
    let is_one = |only: &Move| !only.from.is_dir() || only.to.symlink_metadata().is_err();
    if let [only] = &moves[..]
        && is_one(only)
    {
        let _held = registry();
        return make_folders(folder_of(&only.to), &mut Undo::new())
            .and_then(|()| rename_to(&only.from, &only.to, only.replace))
            .map_err(|error| only.failed(&error));
    }
    // What is replaced, until all is done.
    let aside = moves.iter().map(|one| Temporary::name_for(&one.from));
    let aside: Vec<Temporary> = aside.collect();
    let list = MoveList::write(&moves);
    // A signal waits for this.
    let held = registry();
    let mut undo = Undo::new();
    let mut both = moves.iter().zip(&aside);
    let made = both.try_for_each(|(one, aside)| {
        let made = one.make(aside.path(), &mut undo);
        made.map_err(|error| one.failed(&error))
    });
    if made.is_err() {
        undo.into_iter().rev().for_each(|undo| undo());
    }
    drop(list);
    drop(held);
    made
}

/// Leaves one of several files with the same name and the same bytes, which outputs of several formats share.
fn drop_equal(moves: &mut Vec<Move>) -> Result<()> {
    let mut kept: Vec<Move> = Vec::with_capacity(moves.len());
    for one in moves.drain(..) {
        let Some(same) = kept.iter().find(|kept| kept.to == one.to) else {
            kept.push(one);
            continue;
        };
        let read = |path: &Path| fs::read(path).map_err(|error| Error::io(path, &error));
        if one.from.is_dir() || read(&same.from)? != read(&one.from)? {
            let message = "two outputs would be written to this file; give them names of their own";
            return Err(Error::input(message).file(&one.to));
        }
    }
    *moves = kept;
    Ok(())
}

impl Move {
    fn failed(&self, error: &io::Error) -> Error {
        match error.kind() {
            ErrorKind::AlreadyExists if !self.replace => exists(&self.to),
            _ => Error::io(&self.to, error),
        }
    }

    /// Renames, with what is replaced kept as `aside`.
    fn make(&self, aside: &Path, undo: &mut Undo) -> io::Result<()> {
        let (from, to) = (self.from.clone(), self.to.clone());
        let aside = aside.to_path_buf();
        make_folders(folder_of(&to), undo)?;
        let Some(there) = fs::symlink_metadata(&to).ok().filter(|_| self.replace) else {
            rename_to(&from, &to, false)?;
            undo.push(Box::new(move || drop(fs::rename(to, from))));
            return Ok(());
        };
        match (from.is_dir(), &there) {
            (false, there) if there.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            (true, there) if there.is_file() => return Err(ErrorKind::NotADirectory.into()),
            _ => {}
        }
        if from.is_dir() && exchange(&from, &to)? {
            // The list of moves takes what is under the staged name as new.
            fs::rename(&from, &aside)?;
            undo.push(Box::new(move || drop(exchange(&aside, &to))));
            return Ok(());
        }
        // A file keeps its name meanwhile.
        if there.is_dir() || fs::hard_link(&to, &aside).is_err() {
            fs::rename(&to, &aside)?;
        }
        let back = to.clone();
        undo.push(Box::new(move || drop(fs::rename(aside, back))));
        rename_to(&from, &to, true)
    }
}

/// Makes a folder and those above it.
fn make_folders(folder: &Path, undo: &mut Undo) -> io::Result<()> {
    let missing = folder.ancestors().take_while(|path| !path.exists());
    let missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
    fs::create_dir_all(folder)?;
    for folder in missing.into_iter().rev() {
        undo.push(Box::new(move || drop(fs::remove_dir(folder))));
    }
    Ok(())
}

/// Renames a file or folder; a file that is replaced gives it its permissions.
pub(super) fn rename_to(from: &Path, to: &Path, replace: bool) -> io::Result<()> {
    if !replace && !from.is_dir() && !from.is_symlink() {
        let named = TempPath::try_from_path(from)?.persist_noclobber(to);
        return named.map_err(|failed| failed.error);
    }
    if !replace && to.symlink_metadata().is_ok() {
        return Err(ErrorKind::AlreadyExists.into());
    }
    if let Ok(replaced) = fs::metadata(to)
        && !from.is_symlink()
    {
        // File systems without permissions refuse this, and nothing is lost.
        let _ = fs::set_permissions(from, replaced.permissions());
    }
    fs::rename(from, to)
}

/// Exchanges two names in one call; `false` where the system or the file system cannot.
#[cfg(target_os = "linux")]
fn exchange(a: &Path, b: &Path) -> io::Result<bool> {
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt;
    let [a, b] = [a, b].map(|path| CString::new(path.as_os_str().as_bytes()));
    let (a, b, here) = (a?, b?, libc::AT_FDCWD);
    // SAFETY: both are paths that end in zero. glibc before 2.28 has no function for this call.
    let done = unsafe {
        libc::syscall(
            libc::SYS_renameat2,
            here,
            a.as_ptr(),
            here,
            b.as_ptr(),
            libc::RENAME_EXCHANGE,
        )
    };
    match io::Error::last_os_error() {
        _ if done == 0 => Ok(true),
        error
            if [libc::EINVAL, libc::ENOSYS, libc::EOPNOTSUPP, libc::EPERM]
                .contains(&error.raw_os_error().unwrap_or(0)) =>
        {
            Ok(false)
        }
        error => Err(error),
    }
}

#[cfg(not(target_os = "linux"))]
fn exchange(_: &Path, _: &Path) -> io::Result<bool> {
    Ok(false)
}

/// The number of a file on its disk; 0 where the system has none.
#[cfg(unix)]
fn number_of(found: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(found)
}
#[cfg(not(unix))]
fn number_of(_: &Metadata) -> u64 {
    0
}

fn number_at(path: &Path) -> Option<u64> {
    fs::symlink_metadata(path)
        .ok()
        .map(|found| number_of(&found))
}

/// The ending of a list of moves.
pub(super) const LIST: &str = "moves";

/// The list of moves that are being made, in the folder that all of them are in; locked while its program lives, and removed
/// when dropped.
struct MoveList(#[expect(dead_code)] File, PathBuf);

/// The number of the file on its disk, and both names as seen from the folder of the list.
type Line = (u64, PathBuf, PathBuf);

/// A path whose folders are no links; the last name may be one.
fn real(path: &Path) -> Option<PathBuf> {
    let full = std::path::absolute(path).ok()?;
    let above = full.ancestors().skip(1);
    let mut there = above.filter_map(|above| Some((above, fs::canonicalize(above).ok()?)));
    let (above, found) = there.next()?;
    Some(found.join(full.strip_prefix(above).ok()?))
}

impl MoveList {
    /// Writes the list, where one folder holds all moves and can be written to.
    fn write(moves: &[Move]) -> Option<Self> {
        let line = |one: &Move| Some((number_at(&one.from)?, real(&one.from)?, real(&one.to)?));
        let mut lines: Vec<Line> = moves.iter().map(line).collect::<Option<_>>()?;
        let first = lines.first()?.2.clone();
        let root = first.ancestors().skip(1).find(|root| {
            let mut all = lines.iter().flat_map(|(_, from, to)| [from, to]);
            root.is_dir() && all.all(|path| path.starts_with(root))
        })?;
        for (_, from, to) in &mut lines {
            for path in [from, to] {
                *path = path.strip_prefix(root).ok()?.to_path_buf();
            }
        }
        let text = serde_json::to_vec(&lines).ok()?;
        let path = Temporary::name_for(&root.join("list"))
            .path()
            .with_extension(LIST);
        let mut file = File::options()
            .write(true)
            .create_new(true)
            .open(&path)
            .ok()?;
        let is_locked = lock(&file) != Some(false);
        let list = Self(file.try_clone().ok()?, path);
        let written = file.write_all(&text).and_then(|()| {
            if moves.iter().any(|one| one.sync) {
                sync_file(&list.1)?;
                sync_folder(root)?;
            }
            Ok(())
        });
        (is_locked && written.is_ok()).then_some(list)
    }
}

impl Drop for MoveList {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.1);
    }
}

/// Completes the moves of killed programs in a folder.
///
/// # Errors
/// If a file cannot be moved: old and new files of an output are mixed there.
pub(super) fn complete_left(folder: &Path) -> Result<()> {
    for (path, mut list) in lists_of_killed(folder) {
        let mut text = Vec::new();
        let read = list.read_to_end(&mut text).and_then(|_| list.metadata());
        let listed = read.map_err(|error| Error::io(&path, &error))?;
        // A list that is not complete has moved nothing.
        let lines: Vec<Line> = serde_json::from_slice(&text).unwrap_or_default();
        for line in lines {
            complete(folder, &line, &listed).map_err(|error| {
                Error::system(format!(
                    "a program that was killed has left files of it under their old names, and they cannot be renamed now: \
                     {error}; give permission to write to this folder, or write the mesh again"
                ))
                .file(&folder.join(&line.2))
            })?;
        }
        let _ = fs::remove_file(&path);
    }
    Ok(())
}

fn complete(folder: &Path, (number, from, to): &Line, listed: &Metadata) -> io::Result<()> {
    let is_inside = |path: &Path| {
        let mut parts = path.components();
        parts.all(|part| matches!(part, std::path::Component::Normal(_)))
    };
    if !is_inside(from) || !is_inside(to) {
        return Ok(());
    }
    let (from, to) = (folder.join(from), folder.join(to));
    let Some(staged) = number_at(&from).filter(|_| number_at(&to) != Some(*number)) else {
        return Ok(());
    };
    // A file that was written after the program was killed stays. In a copy of the folder all times are new.
    let is_newer =
        |there: Metadata| matches!((there.modified(), listed.modified()), (Ok(a), Ok(b)) if a > b);
    if staged == *number && fs::metadata(&to).is_ok_and(is_newer) {
        return Ok(());
    }
    fs::create_dir_all(folder_of(&to))?;
    if from.is_dir() && to.symlink_metadata().is_ok() {
        if exchange(&from, &to)? {
            remove(&from);
            return Ok(());
        }
        remove(&to);
    }
    rename_to(&from, &to, true)
}

#[cfg(test)]
mod tests {
    use super::super::staged::{clear_left, complete_above};
    use super::*;

    /// A folder with old and new files of an output: of `mesh` and `names`, and in the folder `case`.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path();
        for name in ["case", ".azimesh_1-0.part", ".azimesh_1-1.part"] {
            fs::create_dir(path.join(name)).expect("it is made");
        }
        for (name, content) in [
            ("mesh", "old"),
            ("names", "old"),
            ("case/points", "old"),
            (".azimesh_1-0.part/points", "new"),
            (".azimesh_1-1.part/mesh", "new"),
            (".azimesh_1-1.part/names", "new"),
        ] {
            fs::write(path.join(name), content).expect("it is written");
        }
        folder
    }

    fn moves(folder: &Path) -> Vec<Move> {
        let named = [
            (".azimesh_1-0.part", "case"),
            (".azimesh_1-1.part/names", "names"),
            (".azimesh_1-1.part/mesh", "mesh"),
        ];
        let one = |(from, to)| Move {
            from: folder.join(from),
            to: folder.join(to),
            replace: true,
            sync: true,
        };
        named.map(one).into()
    }

    fn contents(folder: &Path) -> [String; 3] {
        ["case/points", "names", "mesh"]
            .map(|name| fs::read_to_string(folder.join(name)).expect("it is there"))
    }

    #[test]
    fn all_files_and_folders_are_replaced() {
        let folder = folder();
        make_all(moves(folder.path())).expect("they can be moved");
        assert_eq!(contents(folder.path()), ["new"; 3]);
    }

    #[test]
    fn after_an_error_the_old_files_have_their_names() {
        let folder = folder();
        let moves = moves(folder.path());
        fs::remove_file(&moves[2].from).expect("it is there");
        make_all(moves).expect_err("a file is missing");
        assert_eq!(contents(folder.path()), ["old"; 3]);
        let new = |name: &str| !name.starts_with(".azimesh") && name != "case";
        let entries = fs::read_dir(folder.path()).expect("a folder").flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        assert_eq!(names.filter(|name| new(name)).count(), 2);
    }

    #[test]
    fn a_new_name_that_is_taken_undoes_the_moves_before() {
        let folder = folder();
        let mut moves = moves(folder.path());
        moves[2].replace = false;
        let refused = make_all(moves).expect_err("it is taken");
        assert_eq!(refused.kind, azimesh_core::error::ErrorKind::Input);
        assert_eq!(contents(folder.path()), ["old"; 3]);
    }

    #[test]
    fn outputs_share_a_file_of_the_same_bytes_only() {
        let folder = folder();
        let path = folder.path();
        let with_copy = |content: &str| {
            let copy = path.join(".azimesh_1-1.part/copy");
            fs::write(&copy, content).expect("it is written");
            let mut moves = moves(path);
            let (to, replace, sync) = (path.join("names"), true, true);
            moves.push(Move {
                from: copy,
                to,
                replace,
                sync,
            });
            moves
        };
        make_all(with_copy("other")).expect_err("two contents for one name");
        assert_eq!(contents(path), ["old"; 3]);
        make_all(with_copy("new")).expect("the bytes are equal");
        assert_eq!(contents(path), ["new"; 3]);
    }

    /// Makes the first `n` moves and leaves the list, as a program that is killed then.
    fn killed_after(n: usize, folder: &Path) {
        let moves = moves(folder);
        let list = MoveList::write(&moves).expect("the folder can be written to");
        let left = folder.join(".azimesh_1-9.moves");
        fs::rename(&list.1, &left).expect("it is there");
        drop(list);
        for one in &moves[..n] {
            let aside = folder.join(".azimesh_1-8.part");
            one.make(&aside, &mut Undo::new()).expect("it can be moved");
            remove(&aside);
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_next_reader_or_writer_completes_the_moves_of_a_killed_program() {
        for n in 0..=3 {
            for is_reader in [true, false] {
                let folder = folder();
                killed_after(n, folder.path());
                if is_reader {
                    let mesh = folder.path().join(["mesh", "case"][n % 2]);
                    complete_above(&mesh).expect("they can be moved");
                } else {
                    clear_left(folder.path());
                }
                assert_eq!(contents(folder.path()), ["new"; 3], "{n}");
                clear_left(folder.path());
                assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 3);
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn files_written_after_the_program_was_killed_are_kept() {
        let folder = folder();
        killed_after(1, folder.path());
        let listed = fs::metadata(folder.path().join(".azimesh_1-9.moves")).expect("it is there");
        let later = listed.modified().expect("it is known") + std::time::Duration::from_secs(1);
        let mesh = File::options().write(true).open(folder.path().join("mesh"));
        mesh.and_then(|file| file.set_modified(later))
            .expect("it is ours");
        clear_left(folder.path());
        assert_eq!(contents(folder.path()), ["new", "new", "old"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_list_moves_nothing_outside_its_folder() {
        let folder = folder();
        let inner = folder.path().join("case");
        let lines: [Line; 1] = [(0, "points".into(), "../mesh".into())];
        let text = serde_json::to_vec(&lines).expect("it is text");
        fs::write(inner.join(".azimesh_1-9.moves"), text).expect("it is written");
        clear_left(&inner);
        assert_eq!(contents(folder.path()), ["old"; 3]);
    }
}
