//! Progress of a run, requests to end it early, and periods in which it must not be interrupted.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, AtomicUsize, Ordering};

/// Receiver of the stages of a run and of the work done in each.
///
/// ```
/// use azimesh_core::Progress;
/// use std::sync::Mutex;
///
/// #[derive(Default)]
/// struct Stages(Mutex<Vec<String>>);
///
/// impl Progress for Stages {
///     fn start(&self, stage: &str, _total: Option<u64>) {
///         self.0.lock().expect("no thread has panicked").push(stage.to_owned());
///     }
///     fn advance(&self, _n: u64) {}
///     fn say(&self, _text: &str) {}
///     fn finish(&self) {}
/// }
/// ```
pub trait Progress: Send + Sync {
    /// A stage begins; `total` is its work where that is known.
    fn start(&self, stage: &str, total: Option<u64>);
    /// `n` more units of work are done.
    fn advance(&self, n: u64);
    /// A result of the stage, in a few words.
    fn say(&self, text: &str);
    /// The stage is over.
    fn finish(&self);
}

/// A progress that shows nothing.
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _: &str, _: Option<u64>) {}
    fn advance(&self, _: u64) {}
    fn say(&self, _: &str) {}
    fn finish(&self) {}
}

/// A request to stop, shared by the caller that makes it and the work that checks it.
#[derive(Debug, Default)]
pub struct Stop {
    /// The signal of the request; 0 while there is none.
    signal: AtomicI32,
    /// Number of pieces of work in progress that should be finished.
    held: AtomicUsize,
}

/// A guard: while it exists, something is being written.
#[must_use]
pub struct Held(Arc<Stop>);

impl Stop {
    /// Asks the run to end; `signal` is the number of the signal that caused the request.
    pub fn ask(&self, signal: i32) {
        self.signal.store(signal, Ordering::SeqCst);
    }

    /// Returns the signal of the request, if there is one.
    pub fn signal(&self) -> Option<i32> {
        match self.signal.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(signal),
        }
    }

    /// Checks if a step or the end of a run is being written: the caller should wait for it.
    pub fn is_held(&self) -> bool {
        self.held.load(Ordering::SeqCst) > 0
    }

    /// Makes requests wait until the result is dropped.
    pub fn hold(self: &Arc<Self>) -> Held {
        self.held.fetch_add(1, Ordering::SeqCst);
        Held(Arc::clone(self))
    }

    /// Returns an error if a stop was requested.
    pub fn check(&self) -> Result<()> {
        match self.signal() {
            None => Ok(()),
            Some(signal) => Err(Error::interrupted(signal, "interrupted")),
        }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.0.held.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    #[test]
    fn a_run_that_is_asked_ends_and_is_waited_for_while_it_writes() {
        let stop = Arc::new(Stop::default());
        assert!(stop.check().is_ok() && !stop.is_held());
        let held = stop.hold();
        stop.ask(15);
        assert!(stop.is_held());
        drop(held);
        assert!(!stop.is_held());
        let error = stop.check().expect_err("it was asked");
        assert_eq!(error.kind, ErrorKind::Interrupted { signal: 15 });
    }
}
