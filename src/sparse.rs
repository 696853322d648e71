//! Arrays of which little is ever written, so that the system gives memory for little of them.

use std::cell::Cell;

thread_local! {
    static IS_ASKED: Cell<bool> = const { Cell::new(false) };
}

/// An array of zeros, of which few will be anything else.
pub fn zeros<T: Clone>(n: usize, zero: T) -> Vec<T> {
    IS_ASKED.set(true);
    let zeros = vec![zero; n];
    IS_ASKED.set(false);
    zeros
}

/// Whether the memory that this thread asks for is that of such an array: an allocator gives it small pages.
pub fn is_asked() -> bool {
    IS_ASKED.get()
}
