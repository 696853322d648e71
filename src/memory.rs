//! The program's allocator: the system's, with huge pages asked for behind large arrays.
//!
//! A mesh is a few arrays of hundreds of megabytes. In pages of 4 kB the system spends as long on
//! handing them out as the program on filling them; in pages of 2 MB it does not.

use std::alloc::{GlobalAlloc, Layout, System};

/// Arrays from this size on are worth huge pages.
const LARGE: usize = 8 << 20;

/// Arrays from this size on go back to the system as soon as they are freed.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const RETURNED: i32 = 8 << 20;

/// Has the system's allocator keep no large array that is freed for later: left to itself it learns
/// from the first of them to keep all up to 32 MB.
pub fn return_large_arrays() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: a setting; a value that is refused changes nothing.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, RETURNED)
    };
}

/// The system's allocator with huge pages for large arrays, where the system has them to give.
pub struct HugePages;

// SAFETY: every call goes to the system's allocator as it came; the advice changes no content.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        advised(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, array: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.realloc(array, layout, size) }, size)
    }

    unsafe fn dealloc(&self, array: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(array, layout) }
    }
}

/// Asks for huge pages behind a large array, which has a mapping of its own. All its pages are named:
/// a part would split the mapping, and the system cannot move one that is split, so that every
/// growth of the array would be a copy.
fn advised(array: *mut u8, size: usize) -> *mut u8 {
    #[cfg(target_os = "linux")]
    if size >= LARGE && !array.is_null() {
        const PAGE: usize = 4096;
        let before = array.addr() % PAGE;
        let whole = (before + size).next_multiple_of(PAGE);
        // SAFETY: the pages hold the allocation; advice changes no content, and if it is refused, nothing.
        unsafe {
            libc::madvise(
                array.wrapping_sub(before).cast(),
                whole,
                libc::MADV_HUGEPAGE,
            )
        };
    }
    array
}
