//! The memory that the program holds, its limit, and the end of the program when there is no more. Its allocator counts
//! here and ends here; nothing in this file allocates once the end has begun.

use super::spill;
use azimesh_io::formats::end_staged_soon;
use std::fmt;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Exit code for a failure of the system.
pub const SYSTEM_FAILED: u8 = 3;

/// Arrays of fewer bytes are not counted: together they are small, and counting takes time.
const COUNTED: usize = 64 << 10;

/// Bytes in counted arrays.
static HELD: AtomicUsize = AtomicUsize::new(0);
/// Largest allowed value, by `--max-memory`.
static ALLOWED: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Bytes in memory from which a large array is stored in a file instead.
static IN_MEMORY: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Stage of the work, for the final message.
static STAGE: Mutex<String> = Mutex::new(String::new());
/// Prefix of the name of a finished stage.
const AFTER: &str = "after ";
/// The thread that ends the program; 0 while there is none.
static ENDING: AtomicUsize = AtomicUsize::new(0);

/// Sets the limit: an array with which the program would hold more than `limit` bytes ends it.
pub fn allow(limit: u64) {
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    ALLOWED.store(limit, Ordering::Relaxed);
}

/// Sets the number of bytes that `has_room` allows in memory.
pub fn keep_in_memory(bytes: u64) {
    let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
    IN_MEMORY.store(bytes, Ordering::Relaxed);
}

/// Checks if this many more bytes fit in memory, when the alternative is a file.
pub(super) fn has_room(more: usize) -> bool {
    let held = HELD.load(Ordering::Relaxed);
    held.saturating_add(more) <= IN_MEMORY.load(Ordering::Relaxed)
}

/// Returns small free arrays to the system, which the system's allocator keeps between those in use: the peak of a step
/// of 8 million nodes falls from 1.38 to 1.29 GB. Takes a few milliseconds.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: no memory in use is touched.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Sets the stage of the work, and the file in use.
pub fn set_stage(stage: &str, path: Option<&Path>) {
    let text = match path {
        Some(path) => format!("{stage} {}", path.display()),
        None => stage.to_owned(),
    };
    *STAGE.lock().unwrap_or_else(PoisonError::into_inner) = text;
}

/// Ends the stage; until the next one begins, the program is after it.
pub fn end_stage() {
    let mut text = STAGE.lock().unwrap_or_else(PoisonError::into_inner);
    if !text.is_empty() && !text.starts_with(AFTER) {
        text.insert_str(0, AFTER);
    }
}

/// Counts an array that grows or shrinks from `before` to `after` bytes, 0 if it does not exist. Ends the program if it
/// exceeds `--max-memory`.
#[inline]
pub fn count(before: usize, after: usize) {
    if before >= COUNTED || after >= COUNTED {
        count_large(before, after);
    }
}

fn count_large(before: usize, after: usize) {
    let counted = |size: usize| if size < COUNTED { 0 } else { size };
    let (before, after) = (counted(before), counted(after));
    let Some(more) = after.checked_sub(before).filter(|more| *more > 0) else {
        HELD.fetch_sub(before - after, Ordering::Relaxed);
        return;
    };
    let held = HELD.fetch_add(more, Ordering::Relaxed);
    let allowed = ALLOWED.load(Ordering::Relaxed);
    if held.saturating_add(more) > allowed {
        let disk = ", for which the disk of the output has no room";
        let disk = if spill::is_for(more) { disk } else { "" };
        end_out_of_memory(format_args!(
            "--max-memory allows {allowed} bytes; {held} are in use, and {more} more are needed{disk}"
        ));
    }
}

/// Ends the program after the system has refused `size` bytes.
pub fn end_without(size: usize) -> ! {
    end_out_of_memory(format_args!("the system did not give {size} bytes"))
}

/// Ends the program from here on if a thread cannot be started for lack of memory. The standard library panics if it
/// has no memory for the signal stack of a thread, and some callers of `spawn` ignore its error. A panic has this cause if
/// no other thread can be started either.
pub fn end_where_threads_fail() {
    const PROBE: &str = "probe";
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let probe = || thread::Builder::new().name(PROBE.to_owned()).spawn(|| ());
        if thread::current().name() == Some(PROBE) || probe().is_err() {
            end_out_of_memory(format_args!("a thread could not be started"));
        }
        usual(panic);
    }));
}

/// Ends the program for lack of memory, with the current stage.
fn end_out_of_memory(reason: fmt::Arguments<'_>) -> ! {
    let stage = STAGE.try_lock();
    match stage.as_ref().map_or("", |stage| stage.as_str()) {
        "" => end(format_args!("out of memory: {reason}")),
        // The buffer is long enough: a character has at most four bytes.
        stage => end(format_args!("out of memory: {reason} ({stage:.800})")),
    }
}

/// Ends the program with this one-line message and the exit code of a system failure, and removes hidden files. No
/// destructor runs and no other thread is awaited: they may need memory too.
pub fn end(message: fmt::Arguments<'_>) -> ! {
    thread_local!(static MARK: u8 = const { 0 });
    let me = MARK.with(|mark| std::ptr::from_ref(mark).addr());
    match ENDING.compare_exchange(0, me, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => {
            let mut line = Cursor::new([0_u8; 4096]);
            let _ = writeln!(line, "error: {message}");
            to_stderr(&line.get_ref()[..line.position() as usize]);
            end_staged_soon();
        }
        // Ending the program needs memory itself.
        Err(ending) if ending == me => {}
        Err(_) => thread::sleep(Duration::from_secs(60)),
    }
    #[cfg(unix)]
    // SAFETY: ends the process immediately.
    unsafe {
        libc::_exit(SYSTEM_FAILED.into())
    }
    #[cfg(not(unix))]
    std::process::exit(SYSTEM_FAILED.into())
}

/// Writes without the lock of `std::io::stderr`, which a thread that waits for memory may hold.
fn to_stderr(line: &[u8]) {
    #[cfg(unix)]
    // SAFETY: the bytes are valid; a failed write cannot be reported.
    unsafe {
        libc::write(libc::STDERR_FILENO, line.as_ptr().cast(), line.len())
    };
    #[cfg(not(unix))]
    let _ = std::io::stderr().write_all(line);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_counted_as_they_grow_and_shrink() {
        count(0, COUNTED - 1);
        assert_eq!(HELD.load(Ordering::Relaxed), 0);
        count(COUNTED - 1, 2 * COUNTED);
        count(2 * COUNTED, 3 * COUNTED);
        assert_eq!(HELD.load(Ordering::Relaxed), 3 * COUNTED);
        count(3 * COUNTED, COUNTED);
        count(COUNTED, 0);
        assert_eq!(HELD.load(Ordering::Relaxed), 0);
    }
}
