//! Progress: bars on a terminal, occasional lines for long stages elsewhere, and the stage named in errors of memory.

use super::Context;
use crate::alloc::limit;
use azimesh_core::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two lines for long stages, without a terminal.
const SILENT: Duration = Duration::from_secs(10);

/// A bar for the running stage, unless output is off.
pub struct Bars {
    bar: Mutex<Option<ProgressBar>>,
    is_quiet: bool,
    /// Time of the last line.
    told: Mutex<Instant>,
}

impl Context {
    /// Creates bars on a terminal, nothing if quiet, and lines for long stages elsewhere.
    pub fn progress(&self) -> Box<dyn Progress> {
        Box::new(Bars {
            bar: Mutex::default(),
            is_quiet: self.common.quiet || !self.ranks.is_first(),
            told: Mutex::new(Instant::now()),
        })
    }
}

impl Bars {
    fn with(&self, act: impl FnOnce(&ProgressBar)) {
        let bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = bar.as_ref() {
            act(bar);
        }
    }
}

impl Progress for Bars {
    fn start(&self, stage: &str, total: Option<u64>) {
        limit::give_back();
        limit::set_stage(stage, None);
        if self.is_quiet {
            return;
        }
        let bar = match total {
            Some(total) => ProgressBar::new(total),
            None => ProgressBar::new_spinner(),
        };
        let template = match total {
            Some(_) => "{prefix:>10} {wide_bar} {human_pos}/{human_len} {eta} {msg}",
            None => "{prefix:>10} {spinner} {msg} {elapsed}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(stage.to_owned());
        // Its thread is for a terminal only: if it cannot be started, the bar panics.
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar);
    }

    fn advance(&self, n: u64) {
        self.with(|bar| bar.inc(n));
    }

    fn say(&self, text: &str) {
        self.with(|bar| {
            bar.set_message(text.to_owned());
            let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
            if bar.is_hidden() && !text.is_empty() && told.elapsed() >= SILENT {
                *told = Instant::now();
                // A closed stderr is ignored.
                let _ = writeln!(std::io::stderr(), "{}: {text}", bar.prefix());
            }
        });
    }

    fn finish(&self) {
        limit::end_stage();
        self.with(ProgressBar::finish_and_clear);
    }
}
