//! Large arrays that do not fit into memory: each is stored in a mapped file without a name, on the disk of the output.
//! The system moves its pages between memory and disk; results do not depend on where arrays are. The program's allocator
//! calls this module; nothing in this file allocates when called.
//!
//! A file disappears with its array, and with the program however that ends. Its blocks are allocated when it is created,
//! so a full disk is found then.

use super::limit;
use azimesh_io::formats::release_mapped;
use std::fs::File;
use std::os::fd::IntoRawFd;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Smaller arrays stay in memory: for a mesh they take about two bytes per cell.
pub const LEAST: usize = 1 << 16;
/// Bytes of the smallest page.
const PAGE: usize = 4096;
/// Largest number of arrays in files; the next ones stay in memory.
const MOST: usize = 1 << 14;
/// The interval at which the resident memory is checked.
const TICK: Duration = Duration::from_millis(2);

/// True if the program's allocator calls this module. Other programs, such as Python, have their own allocator.
static IS_ASKED: AtomicBool = AtomicBool::new(false);
static IS_ON: AtomicBool = AtomicBool::new(false);
/// Descriptor of the folder.
static FOLDER: AtomicI32 = AtomicI32::new(-1);
static ARRAYS: Mutex<Arrays> = Mutex::new(Arrays {
    n: 0,
    all: [(0, 0); MOST],
    bytes: 0,
    most: 0,
});

/// Address and size of each array, by address, in a list of fixed length: the allocator itself needs it.
struct Arrays {
    n: usize,
    all: [(usize, usize); MOST],
    /// Bytes of all of them, and their largest value.
    bytes: u64,
    most: u64,
}

impl Arrays {
    /// Finds the index of the array at an address, or the index to insert it.
    fn find(&self, at: usize) -> Result<usize, usize> {
        self.all[..self.n].binary_search_by_key(&at, |array| array.0)
    }

    fn add(&mut self, at: usize, size: usize) {
        let (Ok(place) | Err(place)) = self.find(at);
        self.all.copy_within(place..self.n, place + 1);
        self.all[place] = (at, size);
        self.n += 1;
        self.bytes += size as u64;
        self.most = self.most.max(self.bytes);
    }

    /// Removes an array from the list and returns its size.
    fn remove(&mut self, at: usize) -> Option<usize> {
        let place = self.find(at).ok()?;
        let size = self.all[place].1;
        self.all.copy_within(place + 1..self.n, place);
        self.n -= 1;
        self.bytes -= size as u64;
        Some(size)
    }
}

fn arrays() -> MutexGuard<'static, Arrays> {
    ARRAYS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records that the program's allocator calls this module.
pub fn is_asked() {
    IS_ASKED.store(true, Ordering::Relaxed);
}

/// Checks if an array of this many bytes may be in a file.
pub fn is_for(size: usize) -> bool {
    size >= LEAST && IS_ON.load(Ordering::Acquire)
}

/// Checks if an array of `size` bytes, `more` than before, is to be stored in a file.
pub fn is_wanted(size: usize, more: usize) -> bool {
    is_for(size) && !limit::has_room(more)
}

/// Stores large arrays beyond `in_memory` bytes in files in `folder` from here on, and keeps about `limit` bytes resident
/// at most. Returns whether the system reports the resident memory.
pub fn begin(folder: &Path, in_memory: u64, limit: u64) -> bool {
    let is_on = IS_ASKED.load(Ordering::Relaxed) && set_up(folder, limit);
    if is_on {
        limit::keep_in_memory(in_memory);
    }
    is_on
}

fn set_up(folder: &Path, limit: u64) -> bool {
    let mut options = File::options();
    options.read(true).custom_flags(libc::O_DIRECTORY);
    let Ok(folder) = options.open(folder) else {
        return false;
    };
    let before = FOLDER.swap(folder.into_raw_fd(), Ordering::SeqCst);
    if before >= 0 {
        // SAFETY: the descriptor was stored open, and nothing else uses it.
        unsafe { libc::close(before) };
    }
    // Detects a file system without nameless files, or one that cannot allocate blocks.
    let Some(tried) = map(LEAST) else {
        return false;
    };
    unmap(tried);
    arrays().most = 0;
    if !IS_ON.swap(true, Ordering::AcqRel) {
        let keeper = std::thread::Builder::new().name("resident".to_owned());
        let kept = keeper.spawn(move || keep(limit));
        if kept.is_err() {
            IS_ON.store(false, Ordering::Release);
        }
    }
    IS_ON.load(Ordering::Acquire)
}

/// Returns an array of zeros in a file, if files are in use and it does not fit into memory.
pub fn array(size: usize, align: usize) -> Option<*mut u8> {
    (is_wanted(size, size) && align <= PAGE)
        .then(|| map(size))
        .flatten()
}

fn map(size: usize) -> Option<*mut u8> {
    let mut arrays = arrays();
    if arrays.n == MOST {
        return None;
    }
    let length = libc::off_t::try_from(size).ok()?;
    // SAFETY: a new file, mapped whole; the mapping keeps it when it is closed.
    let at = unsafe {
        let flags = libc::O_TMPFILE | libc::O_RDWR | libc::O_CLOEXEC;
        let folder = FOLDER.load(Ordering::SeqCst);
        let file = libc::openat(folder, c".".as_ptr(), flags, 0o600);
        if file < 0 {
            return None;
        }
        let at = match libc::fallocate(file, 0, 0, length) {
            0 => {
                let access = libc::PROT_READ | libc::PROT_WRITE;
                libc::mmap(ptr::null_mut(), size, access, libc::MAP_SHARED, file, 0)
            }
            _ => libc::MAP_FAILED,
        };
        libc::close(file);
        at
    };
    if at == libc::MAP_FAILED {
        return None;
    }
    arrays.add(at.expose_provenance(), size);
    Some(at.cast())
}

/// Returns the largest number of bytes that were in files at a time.
pub fn most_in_files() -> u64 {
    arrays().most
}

/// Returns the size of the file of an array of `size` bytes; `None` if it is in memory.
pub fn size_of_file(at: *const u8, size: usize) -> Option<usize> {
    if !is_for(size) {
        return None;
    }
    let arrays = arrays();
    let place = arrays.find(at.addr()).ok()?;
    Some(arrays.all[place].1)
}

/// Frees an array of `size` bytes in a file; returns whether it was in one.
pub fn give_back(at: *mut u8, size: usize) -> bool {
    is_for(size) && unmap(at)
}

fn unmap(at: *mut u8) -> bool {
    let mut arrays = arrays();
    let Some(size) = arrays.remove(at.addr()) else {
        return false;
    };
    // SAFETY: the array is this mapping, and its owner frees it.
    unsafe { libc::munmap(at.cast(), size) };
    true
}

/// Releases the pages of all files whenever the program has three quarters of `limit` bytes in memory, so before it
/// reaches the limit. The pages stay with the system, which writes them to the disk and reclaims them as needed.
fn keep(limit: u64) {
    let Ok(statm) = File::open("/proc/self/statm") else {
        return;
    };
    let most = limit / 4 * 3;
    loop {
        std::thread::sleep(TICK);
        if arrays().n > 0 && resident(&statm).is_some_and(|bytes| bytes > most) {
            let_go();
            release_mapped();
        }
    }
}

/// Returns the resident bytes of the program: the second number of `statm`, in pages.
fn resident(statm: &File) -> Option<u64> {
    let mut text = [0; 128];
    let n = statm.read_at(&mut text, 0).ok()?;
    let text = std::str::from_utf8(&text[..n]).ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    // SAFETY: a query of the system.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    Some(pages * u64::try_from(page).ok()?)
}

fn let_go() {
    let arrays = arrays();
    for (at, size) in &arrays.all[..arrays.n] {
        let at = ptr::with_exposed_provenance_mut(*at);
        // SAFETY: a mapping of a file that is shared with it: what was written stays in the file.
        unsafe { libc::madvise(at, *size, libc::MADV_DONTNEED) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_there_after_its_pages_were_let_go() {
        let folder = tempfile::tempdir().expect("a folder");
        if !set_up(folder.path(), 1 << 40) {
            // The temporary folder is on a file system that has no nameless files.
            return;
        }
        let size = 3 * LEAST + 17;
        let [one, two] = [size, LEAST].map(|size| map(size).expect("there is room"));
        // SAFETY: the arrays are that long.
        let bytes = unsafe { std::slice::from_raw_parts_mut(one, size) };
        assert!(bytes.iter().all(|byte| *byte == 0));
        for (i, byte) in bytes.iter_mut().enumerate() {
            *byte = (i * 37 % 251) as u8;
        }
        let_go();
        assert!(
            bytes
                .iter()
                .enumerate()
                .all(|(i, byte)| *byte == (i * 37 % 251) as u8)
        );
        assert_eq!(size_of_file(one, size), Some(size));
        assert_eq!(size_of_file(one.wrapping_add(1), size), None);
        assert!(give_back(one, size) && give_back(two, LEAST));
        assert!(!give_back(one, size));
        let left = std::fs::read_dir(folder.path())
            .expect("it is there")
            .count();
        assert_eq!(left, 0);
    }
}
