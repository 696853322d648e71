//! The memory of the program: its amount and limit, arrays in files, and its allocator.

pub mod global;
pub mod limit;
#[cfg(target_os = "linux")]
pub mod spill;

/// Other systems have no files without a name: every array stays in memory.
#[cfg(not(target_os = "linux"))]
#[allow(missing_docs)]
pub mod spill {
    pub fn is_asked() {}

    pub fn is_for(_: usize) -> bool {
        false
    }

    pub fn is_wanted(_: usize, _: usize) -> bool {
        false
    }

    pub fn begin(_: &std::path::Path, _: u64, _: u64) -> bool {
        false
    }

    pub fn array(_: usize, _: usize) -> Option<*mut u8> {
        None
    }

    pub fn most_in_files() -> u64 {
        0
    }

    pub fn size_of_file(_: *const u8, _: usize) -> Option<usize> {
        None
    }

    pub fn give_back(_: *mut u8, _: usize) -> bool {
        false
    }
}
