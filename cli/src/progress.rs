//! Progress bars on a terminal; silence in a pipe.

use std::{
    fmt,
    io::{self, IsTerminal},
    sync::Mutex,
    time::Duration,
};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

static CURRENT: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// The bar of one stage of the work. Any thread may advance it.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Begins a stage of `total` steps; one of unknown length has 0.
    pub(crate) fn new(stage: &'static str, total: u64, quiet: bool) -> Self {
        if quiet || !io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::with_draw_target(
            (total > 0).then_some(total),
            ProgressDrawTarget::stderr_with_hz(10),
        );
        let template = if total > 0 {
            "{prefix:>10} [{bar:32}] {percent:>3} %  {msg}{left}"
        } else {
            "{prefix:>10} {spinner} {msg}  {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("left", left).progress_chars("=> "));
        }
        bar.set_prefix(stage);
        bar.enable_steady_tick(Duration::from_millis(200));
        if let Ok(mut current) = CURRENT.lock() {
            *current = Some(bar.clone());
        }
        Self(bar)
    }

    /// So far.
    pub(crate) fn set(&self, done: u64) {
        self.0.set_position(done);
    }

    /// A word on it.
    pub(crate) fn message(&self, message: String) {
        self.0.set_message(message);
    }
}

/// The time left, as soon as anything is done to tell it by.
fn left(state: &ProgressState, out: &mut dyn fmt::Write) {
    if state.pos() > 0 {
        // A terminal that cannot be written to shows nothing.
        let _ = write!(out, "  {:#} left", HumanDuration(state.eta()));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Takes the bar off the terminal.
pub(crate) fn clear() {
    if let Ok(mut current) = CURRENT.lock()
        && let Some(bar) = current.take()
    {
        bar.finish_and_clear();
    }
}
