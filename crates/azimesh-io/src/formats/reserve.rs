//! Room on a disk, kept free for what is to be written when the disk is full: how a run ended.

use super::staged::Temporary;
use std::io::Write;
use std::path::Path;

/// A hidden file that takes room until this is dropped. One that a killed program has left is removed like other staged
/// files.
pub struct Reserve {
    /// Removed when it is dropped; `None` where there is no room.
    _file: Option<Temporary>,
}

impl Reserve {
    /// So many bytes in the folder of a file; none where they cannot be had.
    pub fn beside(path: &Path, n_bytes: usize) -> Self {
        let Ok((mut file, temporary)) = Temporary::file_for(path) else {
            return Self { _file: None };
        };
        let is_there = file.write_all(&vec![0; n_bytes]).is_ok();
        Self {
            _file: is_there.then_some(temporary),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn it_takes_room_until_it_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let sizes = || -> Vec<u64> {
            let entries = fs::read_dir(folder.path()).expect("a folder").flatten();
            let sizes = entries.map(|entry| entry.metadata().expect("it is there").len());
            sizes.collect()
        };
        let reserve = Reserve::beside(&folder.path().join("run.json"), 10_000);
        assert_eq!(sizes(), [10_000]);
        drop(reserve);
        assert!(sizes().is_empty());
    }
}
