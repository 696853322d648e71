//! Progress: bars, on a terminal only, and the stage that is named where memory runs out.

use super::{Context, heap};
use crate::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A bar for the stage that is running, unless nothing is to be shown.
#[derive(Default)]
pub struct Bars {
    bar: Mutex<Option<ProgressBar>>,
    is_quiet: bool,
}

impl Context {
    /// Bars on a terminal, nothing when quiet; elsewhere nothing is drawn.
    pub fn progress(&self) -> Box<dyn Progress> {
        Box::new(Bars {
            is_quiet: self.common.quiet || !self.ranks.is_first(),
            ..Bars::default()
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
        heap::give_back();
        heap::set_stage(stage, None);
        if self.is_quiet {
            return;
        }
        let bar = match total {
            Some(total) => ProgressBar::new(total),
            None => ProgressBar::new_spinner(),
        };
        let template = match total {
            Some(_) => "{prefix:>10} {wide_bar} {human_pos}/{human_len} {eta}",
            None => "{prefix:>10} {spinner} {msg} {elapsed}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(stage.to_owned());
        // Its thread is for a terminal only: where it cannot be started, the bar panics.
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar);
    }

    fn advance(&self, n: u64) {
        self.with(|bar| bar.inc(n));
    }

    fn say(&self, text: &str) {
        self.with(|bar| bar.set_message(text.to_owned()));
    }

    fn finish(&self) {
        heap::end_stage();
        self.with(ProgressBar::finish_and_clear);
    }
}
