//! The program's allocator: the system's, with huge pages for large arrays. It counts memory, and ends the program with a
//! message if none is available. Where `--max-memory` does not allow a large array, the array is stored in a file
//! ([`super::spill`]).
//!
//! A mesh is a few arrays of hundreds of megabytes. With pages of 4 kB the system takes as long to provide them as the
//! program to fill them; with pages of 2 MB it does not.

use super::{limit, spill};
use std::alloc::{GlobalAlloc, Layout, System};

/// Least size of arrays for which huge pages are worthwhile.
const LARGE: usize = 8 << 20;

/// Least size of arrays that are returned to the system as soon as they are freed.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const RETURNED: i32 = 8 << 20;

/// Smaller arrays are returned to the system once this many free bytes are at the end of the heap. By default the
/// allocator returns them from 128 kB, so code that allocates a megabyte for each part of a file makes the system clear it
/// every time.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEPT: i32 = 16 << 20;

/// Prepares the program: reserves memory for its end, and stops the system's allocator from keeping large freed
/// arrays. By default it learns from the first of them to keep all up to 32 MB.
pub fn prepare() {
    spill::is_asked();
    #[cfg(unix)]
    reserve::set_aside();
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: settings; a value that is refused changes nothing.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, RETURNED);
        libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
        if are_addresses_few() {
            libc::mallopt(libc::M_ARENA_MAX, 1);
        }
    };
}

/// Checks if `ulimit -v` leaves less than the 64 MB of addresses that the system's allocator reserves for each thread.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn are_addresses_few() -> bool {
    // SAFETY: the call only fills in the limit.
    is_below(8 << 30, |limit| unsafe {
        libc::getrlimit(libc::RLIMIT_AS, limit)
    })
}

/// Checks if `ulimit -s` gives the first thread a stack of fewer bytes.
#[cfg(unix)]
pub fn is_stack_below(bytes: u32) -> bool {
    // SAFETY: as above.
    is_below(bytes.into(), |limit| unsafe {
        libc::getrlimit(libc::RLIMIT_STACK, limit)
    })
}

#[cfg(not(unix))]
pub fn is_stack_below(_: u32) -> bool {
    false
}

#[cfg(unix)]
fn is_below(least: libc::rlim_t, ask: impl FnOnce(*mut libc::rlimit) -> libc::c_int) -> bool {
    let mut limit = libc::rlimit {
        rlim_cur: libc::RLIM_INFINITY,
        rlim_max: libc::RLIM_INFINITY,
    };
    ask(&raw mut limit) == 0 && limit.rlim_cur < least
}

/// The system's allocator with huge pages for large arrays, where the system has them.
pub struct HugePages;

// SAFETY: every call is passed to the system's allocator unchanged, except for arrays in mapped files, which are whole
// pages of zeros; the advice changes no content.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let array = spill::array(layout.size(), layout.align());
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        let take = || unsafe { System.alloc(layout) };
        array.unwrap_or_else(|| had(0, layout.size(), take))
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let array = spill::array(layout.size(), layout.align());
        // SAFETY: as above.
        let take = || unsafe { System.alloc_zeroed(layout) };
        array.unwrap_or_else(|| had(0, layout.size(), take))
    }

    unsafe fn realloc(&self, array: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let before = layout.size();
        match spill::size_of_file(array, before) {
            // It is in its file.
            Some(room) if spill::is_for(size) && size <= room => return array,
            None if size <= before || !spill::is_wanted(size, size - before) => {
                // SAFETY: as above.
                return had(before, size, || unsafe {
                    System.realloc(array, layout, size)
                });
            }
            _ => {}
        }
        // SAFETY: both arrays have that many bytes, and the old one is freed as it was allocated.
        unsafe {
            let moved = self.alloc(Layout::from_size_align_unchecked(size, layout.align()));
            moved.copy_from_nonoverlapping(array, size.min(before));
            self.dealloc(array, layout);
            moved
        }
    }

    unsafe fn dealloc(&self, array: *mut u8, layout: Layout) {
        if spill::give_back(array, layout.size()) {
            return;
        }
        limit::count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.dealloc(array, layout) }
    }
}

/// Counts an array and allocates it. A small one that the system refuses is taken from the reserve, since its caller
/// may be in the middle of an operation that must be completed.
fn had(before: usize, size: usize, get: impl Fn() -> *mut u8) -> *mut u8 {
    limit::count(before, size);
    let mut array = get();
    #[cfg(unix)]
    if array.is_null() {
        reserve::give_back();
        if size < reserve::SMALL {
            array = get();
        }
    }
    if array.is_null() {
        limit::end_without(size);
    }
    advised(array, size)
}

/// Requests huge pages for a large array, which has its own mapping, or small pages if little of it will be used. The
/// advice covers all its pages: advice for a part would split the mapping, the system cannot move a split mapping, and every
/// growth of the array would be a copy.
fn advised(array: *mut u8, size: usize) -> *mut u8 {
    #[cfg(target_os = "linux")]
    if size >= LARGE {
        let advice = if azimesh_core::sparse::is_asked() {
            libc::MADV_NOHUGEPAGE
        } else {
            libc::MADV_HUGEPAGE
        };
        const PAGE: usize = 4096;
        let before = array.addr() % PAGE;
        let whole = (before + size).next_multiple_of(PAGE);
        // SAFETY: the pages hold the allocation; advice changes no content, and if it is refused, nothing.
        unsafe { libc::madvise(array.wrapping_sub(before).cast(), whole, advice) };
    }
    array
}

/// Addresses that the program reserves for its end.
#[cfg(unix)]
mod reserve {
    use crate::alloc::limit;
    use std::ptr;
    use std::sync::atomic::{AtomicPtr, Ordering};

    /// Requests below this may be met from the reserve.
    pub const SMALL: usize = 64 << 10;
    /// The reserve: no page of it is ever used, but it counts for `ulimit -v`.
    const SIZE: usize = 4 << 20;
    /// Part of the stack of the thread that runs the program, touched from the start: if it could not grow later, the system
    /// would end the program without a message.
    const STACK: usize = 512 << 10;

    static RESERVE: AtomicPtr<u8> = AtomicPtr::new(ptr::null_mut());

    /// Allocates the reserve and the stack. If even these are not available, the program ends here.
    pub fn set_aside() {
        let (size, flags) = (SIZE + STACK, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: a new mapping that nothing reads or writes.
        let found = unsafe { libc::mmap(ptr::null_mut(), size, libc::PROT_NONE, flags, -1, 0) };
        if found == libc::MAP_FAILED {
            limit::end_without(size);
        }
        // SAFETY: its end is returned, to the stack.
        unsafe { libc::munmap(found.cast::<u8>().add(SIZE).cast(), STACK) };
        RESERVE.store(found.cast(), Ordering::SeqCst);
        let mut stack = [0_u8; STACK - (16 << 10)];
        std::hint::black_box(&mut stack);
    }

    /// Returns the reserve to the system.
    pub fn give_back() {
        let reserve = RESERVE.swap(ptr::null_mut(), Ordering::SeqCst);
        if !reserve.is_null() {
            // SAFETY: the mapping is whole, and nothing else uses it.
            unsafe { libc::munmap(reserve.cast(), SIZE) };
        }
    }
}
