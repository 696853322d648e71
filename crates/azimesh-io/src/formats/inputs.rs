//! Input files by their identity on the disk: device and inode, so that links count. An output must not take the place of one.

use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The inputs that no output may replace, once [`guard_inputs`] has been called.
static GUARDED: Mutex<Option<Inputs>> = Mutex::new(None);

/// Files and folders that are read.
#[derive(Debug, Clone, Default)]
pub struct Inputs(BTreeMap<Identity, PathBuf>);

/// Device and inode; the path without links where the system has no such numbers.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

/// The identity of a file or folder; `None` of a device or a pipe, and of what is not there.
fn identity(path: &Path) -> Option<Identity> {
    let found = fs::metadata(path).ok()?;
    let is_stored = found.is_file() || found.is_dir();
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        is_stored.then(|| (found.dev(), found.ino()))
    }
    #[cfg(not(unix))]
    {
        fs::canonicalize(path).ok().filter(|_| is_stored)
    }
}

impl Inputs {
    /// The inputs at these paths.
    pub fn of<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Self {
        let mut inputs = Self::default();
        paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
        inputs
    }

    fn add(&mut self, path: &Path) {
        if let Some(identity) = identity(path) {
            self.0.entry(identity).or_insert_with(|| path.to_path_buf());
        }
    }

    /// The input that a path leads to.
    pub fn find(&self, path: &Path) -> Option<&Path> {
        self.0.get(&identity(path)?).map(PathBuf::as_path)
    }

    /// Refuses an output at a path that leads to an input.
    pub fn refuse(&self, output: &Path) -> Result<()> {
        match self.find(output) {
            None => Ok(()),
            Some(input) => Err(replaced(output, input)),
        }
    }
}

/// The refusal of an output that would replace an input.
pub fn replaced(output: &Path, input: &Path) -> Error {
    let which = match output == input {
        true => "this is an input".to_owned(),
        false => format!("this is the input {}", input.display()),
    };
    Error::input(format!(
        "{which}, which the output would replace; give the output another name or folder"
    ))
    .file(output)
}

/// From now on no file that this process writes may replace one of these inputs, or a file that it reads as one.
pub fn guard_inputs<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) {
    let mut guarded = guarded();
    let inputs = guarded.get_or_insert_default();
    paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
}

/// Adds inputs that are about to be read, where inputs are guarded.
pub fn note_inputs<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) {
    if let Some(inputs) = guarded().as_mut() {
        paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
    }
}

/// Refuses an output that would replace a guarded input.
pub(super) fn refuse_guarded(output: &Path) -> Result<()> {
    match guarded().as_ref() {
        Some(inputs) => inputs.refuse(output),
        None => Ok(()),
    }
}

fn guarded() -> MutexGuard<'static, Option<Inputs>> {
    GUARDED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_by_every_name_that_it_has() {
        let folder = tempfile::tempdir().expect("a folder");
        let [mesh, other, link, second] = ["mesh.vtu", "other.vtu", "link.vtu", "second.vtu"]
            .map(|name| folder.path().join(name));
        fs::write(&mesh, "x").expect("it can be written");
        fs::write(&other, "x").expect("it can be written");
        std::os::unix::fs::symlink(&mesh, &link).expect("links are known");
        fs::hard_link(&mesh, &second).expect("links are known");
        let inputs = Inputs::of([&mesh, Path::new("/dev/null"), &folder.path().join("none")]);
        for path in [&mesh, &link, &second] {
            assert_eq!(inputs.find(path), Some(&*mesh));
            inputs.refuse(path).expect_err("it is the input");
        }
        for path in [&*other, Path::new("/dev/null"), &folder.path().join("none")] {
            inputs.refuse(path).expect("it is no input");
        }
    }
}
