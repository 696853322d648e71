//! How a run tells of its progress, how it is asked to end early, and when it must not be cut short.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, AtomicUsize, Ordering};

/// Hears of stages and of the work done in each.
///
/// ```
/// use azimesh::{Deformation, Mesh, Progress, Schedule};
/// use std::path::Path;
/// use std::sync::{Arc, Mutex};
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
///
/// # fn main() -> azimesh::Result<()> {
/// let stages = Arc::new(Stages::default());
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// let schedule = Schedule::read(Path::new("testdata/naca0012.toml"))?;
/// Deformation::builder(mesh, schedule).progress(stages.clone()).build()?;
/// assert!(!stages.0.lock().expect("no thread has panicked").is_empty());
/// # Ok(())
/// # }
/// ```
pub trait Progress: Send + Sync {
    /// A stage begins; `total` is its work where that is known.
    fn start(&self, stage: &str, total: Option<u64>);
    /// So much more is done.
    fn advance(&self, n: u64);
    /// What the stage has come to, in a few words.
    fn say(&self, text: &str);
    /// The stage is over.
    fn finish(&self);
}

/// Shows nothing.
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _: &str, _: Option<u64>) {}
    fn advance(&self, _: u64) {}
    fn say(&self, _: &str) {}
    fn finish(&self) {}
}

/// A request to stop, shared by the caller that makes it and the work that checks it.
///
/// ```
/// use azimesh::{Deformation, ErrorKind, Mesh, Schedule, Stop};
/// use std::path::Path;
/// use std::sync::Arc;
///
/// # fn main() -> azimesh::Result<()> {
/// let stop = Arc::new(Stop::default());
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// let schedule = Schedule::read(Path::new("testdata/naca0012.toml"))?;
/// let deformation = Deformation::builder(mesh, schedule).stop(stop.clone()).build()?;
/// stop.ask(2); // usually from another thread, or from the handler of the signal with this number
/// let error = deformation.points_at(&deformation.steps()[1]).err();
/// assert_eq!(error.map(|error| error.kind), Some(ErrorKind::Interrupted { signal: 2 }));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Default)]
pub struct Stop {
    /// The signal that asked; 0 while nobody has.
    signal: AtomicI32,
    /// How many pieces of work are under way that should be finished.
    held: AtomicUsize,
}

/// As long as it lives, something is being written.
#[must_use]
pub(crate) struct Held(Arc<Stop>);

impl Stop {
    /// Asks the run to end; `signal` is the number of the signal that made one ask.
    pub fn ask(&self, signal: i32) {
        self.signal.store(signal, Ordering::SeqCst);
    }

    /// The signal that asked.
    pub fn signal(&self) -> Option<i32> {
        match self.signal.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(signal),
        }
    }

    /// Whether a step or what closes a run is being written: it should be waited for.
    pub fn is_held(&self) -> bool {
        self.held.load(Ordering::SeqCst) > 0
    }

    /// Makes requests wait until it is dropped.
    pub(crate) fn hold(self: &Arc<Self>) -> Held {
        self.held.fetch_add(1, Ordering::SeqCst);
        Held(Arc::clone(self))
    }

    /// Ends a run that was asked to.
    pub(crate) fn check(&self) -> Result<()> {
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
