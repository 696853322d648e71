//! Arrays that are mostly never written, so that the system provides memory for little of them.

use std::cell::Cell;

thread_local! {
    static IS_ASKED: Cell<bool> = const { Cell::new(false) };
}

/// Makes an array of zeros; few of them will change.
pub fn zeros<T: Clone>(n: usize, zero: T) -> Vec<T> {
    IS_ASKED.set(true);
    let zeros = vec![zero; n];
    IS_ASKED.set(false);
    zeros
}

/// Checks if this thread is allocating such an array: an allocator gives it small pages.
pub fn is_asked() -> bool {
    IS_ASKED.get()
}
