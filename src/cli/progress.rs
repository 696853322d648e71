//! Progress bars, on a terminal only.

use super::Context;
use crate::sequence::{Progress, Silent};
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;
use std::time::Duration;

/// A bar for the stage that is running.
#[derive(Default)]
pub struct Bars(Mutex<Option<ProgressBar>>);

impl Context {
    /// Bars on a terminal, nothing when quiet; elsewhere nothing is drawn.
    pub fn progress(&self) -> Box<dyn Progress> {
        match self.common.quiet {
            true => Box::new(Silent),
            false => Box::new(Bars::default()),
        }
    }
}

impl Bars {
    fn with(&self, act: impl FnOnce(&ProgressBar)) {
        let guard = self
            .0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(bar) = guard.as_ref() {
            act(bar);
        }
    }
}

impl Progress for Bars {
    fn start(&self, stage: &str, total: Option<u64>) {
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
        bar.enable_steady_tick(Duration::from_millis(200));
        *self
            .0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner) = Some(bar);
    }

    fn advance(&self, n: u64) {
        self.with(|bar| bar.inc(n));
    }

    fn say(&self, text: &str) {
        self.with(|bar| bar.set_message(text.to_owned()));
    }

    fn finish(&self) {
        self.with(ProgressBar::finish_and_clear);
    }
}
