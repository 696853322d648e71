//! Work beside the interpreter: on a thread of its own, without the GIL, so that signals and other threads of Python
//! get their turn.

use crate::arguments;
use crate::arrays::vectors;
use crate::error::raised;
use azimesh::{Error, Result, Stop};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long a signal waits at most.
const PAUSE: Duration = Duration::from_millis(50);

/// Number of SIGINT.
const INTERRUPT: i32 = 2;

/// Asks a thing beside the interpreter.
pub fn ask<A: Send + Sync + 'static, T: Send + 'static>(
    py: Python<'_>,
    asked: &Arc<A>,
    question: impl FnOnce(&A) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    let asked = Arc::clone(asked);
    done(py, None, move || question(&asked))
}

/// Asks a thing beside the interpreter for the vectors (m, 3) that belong to given ones (n, 3), called `what` in errors.
pub fn mapped<'py, A: Send + Sync + 'static>(
    py: Python<'py>,
    asked: &Arc<A>,
    given: &Bound<'py, PyAny>,
    what: &str,
    map: impl FnOnce(&A, &[[f64; 3]]) -> Result<Vec<[f64; 3]>> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    let given = arguments::vectors(given, what)?;
    vectors(py, ask(py, asked, move |asked| map(asked, &given))?)
}

/// The end of work by a signal.
pub struct Ending<'a> {
    /// Requests the end.
    pub stop: &'a Stop,
    /// Receives what the handler of the signal raised.
    pub report: &'a dyn Fn(PyErr),
    /// Waits for the work to end, as it may write files; until a second signal.
    pub wait: bool,
}

/// Does `work` without the GIL. A signal whose handler raises (Ctrl-C) ends it as `ending` has it. Without one the work
/// continues, and its result is dropped.
///
/// # Errors
/// That of the work; what a signal's handler raised.
pub fn done<T: Send + 'static>(
    py: Python<'_>,
    ending: Option<Ending<'_>>,
    work: impl FnOnce() -> Result<T> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    let receiver = Mutex::new(receiver);
    let thread = std::thread::Builder::new().name("azimesh".to_owned());
    let thread = thread.spawn(move || {
        // Nobody listens any more where the caller was interrupted.
        let _ = sender.send(work());
    });
    let thread = thread.map_err(|error| raised(py, &Error::system(error.to_string())))?;
    let mut interrupted: Option<PyErr> = None;
    loop {
        let received = py.detach(|| {
            let receiver = receiver.lock().unwrap_or_else(PoisonError::into_inner);
            receiver.recv_timeout(PAUSE)
        });
        match received {
            Ok(result) => {
                py.check_signals()?;
                return match interrupted {
                    Some(error) => Err(error),
                    None => result.map_err(|error| raised(py, &error)),
                };
            }
            Err(RecvTimeoutError::Timeout) => {
                let Err(error) = py.check_signals() else {
                    continue;
                };
                let Some(ending) = ending.as_ref().filter(|_| interrupted.is_none()) else {
                    return Err(error);
                };
                ending.stop.ask(INTERRUPT);
                (ending.report)(error.clone_ref(py));
                if !ending.wait {
                    return Err(error);
                }
                interrupted = Some(error);
            }
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => resume_unwind(panic),
                Ok(()) => {
                    return Err(PyKeyboardInterrupt::new_err(
                        "the work ended without a result",
                    ));
                }
            },
        }
    }
}
