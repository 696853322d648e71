//! The program's allocator: the system's, with huge pages asked for behind large arrays. What it takes is
//! counted, and memory that is not available ends the program with a message. Where `--max-memory` leaves no room for a
//! large array, it is in a file ([`super::spill`]).
//!
//! A mesh is a few arrays of hundreds of megabytes. In pages of 4 kB the system spends as long on
//! handing them out as the program on filling them; in pages of 2 MB it does not.

use super::{limit, spill};
use std::alloc::{GlobalAlloc, Layout, System};

/// Arrays from this size on are worth huge pages.
const LARGE: usize = 8 << 20;

/// Arrays from this size on go back to the system as soon as they are freed.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const RETURNED: i32 = 8 << 20;

/// Smaller arrays go back to the system once so many bytes of them are free at the end of the heap. Left to itself the allocator
/// returns 128 kB, and who makes an array of a megabyte for each part of a file has the system clear it anew each time.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEPT: i32 = 16 << 20;

/// Makes the program ready: memory for its end is set aside, and the system's allocator keeps no large array
/// that is freed for later. Left to itself it learns from the first of them to keep all up to 32 MB.
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

/// Checks if `ulimit -v` leaves less than the 64 MB of addresses that the system's allocator would set aside
/// for each thread.
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

/// The system's allocator with huge pages for large arrays, where the system has them to give.
pub struct HugePages;

// SAFETY: every call goes to the system's allocator as it came, but for arrays that are mapped files, which are
// whole pages of zeros of their own; the advice changes no content.
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
        // SAFETY: both arrays have that many bytes, and the old one is given back as it was taken.
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

/// Counts an array and gets it. A small one that the system refuses is taken from the reserve: whoever asks for it
/// may be in the middle of something that should be whole.
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

/// Asks for huge pages behind a large array, which has a mapping of its own, but for small ones where little of it will be used. All its pages are named:
/// a part would split the mapping, and the system cannot move one that is split, so that every
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

/// Addresses that the program keeps for its end.
#[cfg(unix)]
mod reserve {
    use crate::alloc::limit;
    use std::ptr;
    use std::sync::atomic::{AtomicPtr, Ordering};

    /// Requests below this may be met from the reserve.
    pub const SMALL: usize = 64 << 10;
    /// Its size: no page of it is ever used, but it counts for `ulimit -v`.
    const SIZE: usize = 4 << 20;
    /// Part of the stack of the thread that runs the program, which it has from the start: where it cannot grow later, the system ends
    /// the program without a word.
    const STACK: usize = 512 << 10;

    static RESERVE: AtomicPtr<u8> = AtomicPtr::new(ptr::null_mut());

    /// Sets it aside, and the stack. Where even that cannot be had, the program ends here.
    pub fn set_aside() {
        let (size, flags) = (SIZE + STACK, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: a mapping of its own, which nothing reads or writes.
        let found = unsafe { libc::mmap(ptr::null_mut(), size, libc::PROT_NONE, flags, -1, 0) };
        if found == libc::MAP_FAILED {
            limit::end_without(size);
        }
        // SAFETY: its end is given back, to the stack.
        unsafe { libc::munmap(found.cast::<u8>().add(SIZE).cast(), STACK) };
        RESERVE.store(found.cast(), Ordering::SeqCst);
        let mut stack = [0_u8; STACK - (16 << 10)];
        std::hint::black_box(&mut stack);
    }

    /// Gives it back to the system.
    pub fn give_back() {
        let reserve = RESERVE.swap(ptr::null_mut(), Ordering::SeqCst);
        if !reserve.is_null() {
            // SAFETY: the mapping is whole, and nobody else has it.
            unsafe { libc::munmap(reserve.cast(), SIZE) };
        }
    }
}
