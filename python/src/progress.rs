//! The progress of work, told to a function of Python.

use azimesh::{Progress, Stop};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often the function is called within a stage, at most.
const PAUSE: Duration = Duration::from_millis(50);

/// Calls `function(stage, done, total)`; what it raises ends the work.
pub struct Told {
    function: Py<PyAny>,
    stop: Arc<Stop>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    stage: String,
    n_done: u64,
    total: Option<u64>,
    told: Option<Instant>,
    raised: Option<PyErr>,
}

impl Told {
    pub fn new(function: Py<PyAny>, stop: Arc<Stop>) -> Self {
        Self {
            function,
            stop,
            state: Mutex::default(),
        }
    }

    /// What the function raised, once.
    pub fn take_raised(&self) -> Option<PyErr> {
        self.state().raised.take()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells it now, or where the last time was long enough ago.
    fn tell(&self, now: bool) {
        let (stage, n_done, total) = {
            let mut state = self.state();
            let is_due = state.told.is_none_or(|told| told.elapsed() > PAUSE);
            if state.raised.is_some() || self.stop.signal().is_some() || !(now || is_due) {
                return;
            }
            state.told = Some(Instant::now());
            (state.stage.clone(), state.n_done, state.total)
        };
        // Without an interpreter, at its end, there is nobody to tell.
        let called = Python::try_attach(|py| self.function.call1(py, (stage, n_done, total)));
        if let Some(Err(error)) = called {
            self.state().raised = Some(error);
            self.stop.ask(2);
        }
    }
}

impl Progress for Told {
    fn start(&self, stage: &str, total: Option<u64>) {
        {
            let mut state = self.state();
            (state.stage, state.n_done, state.total) = (stage.to_owned(), 0, total);
        }
        self.tell(true);
    }

    fn advance(&self, n: u64) {
        self.state().n_done += n;
        self.tell(false);
    }

    fn say(&self, _: &str) {}

    fn finish(&self) {
        self.tell(true);
    }
}
