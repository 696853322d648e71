//! Signals that ask a program to end, and the signal for a file that grows too large. In a sequence the first signal takes
//! effect between two steps, and the second ends the program at once; every other command ends with the first. None leaves a
//! hidden file behind. The end of a terminal (SIGHUP) is one of them, unless it was ignored from the start, as under `nohup`.

use crate::alloc::limit;
use azimesh_core::error::{Error, Result};
use azimesh_core::progress::Stop;
use azimesh_io::formats::{SHORTER, end_staged, with_mapped_at};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use std::io::Write;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Time for a run that writes nothing to end by itself.
const GRACE: Duration = Duration::from_millis(700);
/// Interval between checks of the run.
const PAUSE: Duration = Duration::from_millis(10);

/// Makes writing a file beyond the limit of `ulimit -f` an ordinary error from here on, instead of ending the program.
pub(super) fn outlive_file_limits() {
    // If the signal cannot be caught it still ends the program.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Makes the program end with a message from here on if another program has truncated a mapped file: the system raises
/// SIGBUS in the thread that reads beyond the end of the file.
pub(super) fn end_where_inputs_shrink() {
    // SAFETY: all zeros are a valid action, and the handler has the signature that the flag requires. It runs on the stack of
    // the thread, which has enough space during a read of a mapped file.
    unsafe {
        let (mut own, mut before): (libc::sigaction, libc::sigaction) = std::mem::zeroed();
        own.sa_sigaction = on_fault as *const () as usize;
        own.sa_flags = libc::SA_SIGINFO;
        if libc::sigaction(libc::SIGBUS, &raw const own, &raw mut before) == 0 {
            let _ = BEFORE.set(before);
        }
    }
}

/// The previous action for SIGBUS, replaced by [`end_where_inputs_shrink`].
static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

/// Ends the program at a fault in a mapped file. Any other fault is repeated with the previous action.
extern "C" fn on_fault(signal: i32, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
    // SAFETY: the system gives a valid `info`.
    let address = unsafe { (*info).si_addr() }.addr();
    // The thread was reading a mapped file, so that it holds no lock of the allocator or of staged files.
    let is_mapped = with_mapped_at(address, |path| {
        limit::end(format_args!("{}: {SHORTER}", path.display()));
    });
    if let Some(before) = BEFORE.get().filter(|_| !is_mapped) {
        // SAFETY: the action came from the system.
        unsafe { libc::sigaction(signal, before, std::ptr::null_mut()) };
    }
}

/// Makes SIGINT, SIGTERM and SIGHUP request a stop through `stop` from here on.
///
/// A step that is being written is always completed. Before the steps (reading, base points, modes) there is no work to
/// lose, and the program ends.
pub(super) fn listen(stop: &Arc<Stop>) -> Result<()> {
    let stop = Arc::clone(stop);
    after_first(move |signal, signals| {
        stop.ask(signal);
        let mut idle = Instant::now();
        while idle.elapsed() < GRACE {
            std::thread::sleep(PAUSE);
            if let Some(again) = signals.pending().next() {
                end_staged();
                std::process::exit(128 + again);
            }
            if stop.is_held() {
                idle = Instant::now();
            }
        }
        end_with(
            signal,
            "interrupted; if a step was finished, it is kept, and --resume continues from there",
        );
    })
}

/// Makes SIGINT, SIGTERM and SIGHUP end the program with this message from here on, and remove hidden files.
pub(super) fn end(message: &'static str) -> Result<()> {
    after_first(move |signal, _| end_with(signal, message))
}

/// Ignores SIGINT, SIGTERM and SIGHUP from here on: another rank receives them, and ends this one.
pub(super) fn ignore() -> Result<()> {
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        let ignored = signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)));
        ignored.map_err(cannot_listen)?;
    }
    Ok(())
}

fn cannot_listen(error: std::io::Error) -> Error {
    Error::system(format!("cannot listen to signals: {error}"))
}

fn end_with(signal: i32, message: &str) {
    end_staged();
    // A closed stderr is ignored.
    let _ = writeln!(std::io::stderr(), "error: {message}");
    std::process::exit(128 + signal);
}

/// Calls `then` on a separate thread at the first signal.
fn after_first(then: impl FnOnce(i32, &mut Signals) + Send + 'static) -> Result<()> {
    let heard = [SIGINT, SIGTERM].into_iter();
    let heard = heard.chain((!is_ignored(SIGHUP)).then_some(SIGHUP));
    let mut signals = Signals::new(heard).map_err(cannot_listen)?;
    let wait = move || {
        let first = signals.forever().next();
        if let Some(signal) = first {
            then(signal, &mut signals);
        }
    };
    let thread = std::thread::Builder::new().name("signals".to_owned());
    thread.spawn(wait).map(|_| ()).map_err(cannot_listen)
}

/// Checks if the parent process has set a signal to be ignored.
fn is_ignored(signal: i32) -> bool {
    // SAFETY: all zeros are a valid action, and the call only fills it in.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        let asked = libc::sigaction(signal, std::ptr::null(), &mut action);
        asked == 0 && action.sa_sigaction == libc::SIG_IGN
    }
}
