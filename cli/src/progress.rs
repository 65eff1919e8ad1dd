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
        set_style(&bar, total > 0);
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

    /// One step more.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }

    /// A word on it.
    pub(crate) fn message(&self, message: String) {
        self.0.set_message(message);
    }
}

/// One line, however narrow the terminal is: the message is cut, which stands last.
fn set_style(bar: &ProgressBar, has_length: bool) {
    let template = if has_length {
        "{prefix:>10} [{bar:16}] {percent:>3} %{left}  {wide_msg}"
    } else {
        "{prefix:>10} {spinner} {elapsed}  {wide_msg}"
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.with_key("left", left).progress_chars("=> "));
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use indicatif::TermLike;

    use super::*;

    /// A terminal that keeps what it shows.
    #[derive(Debug, Clone, Default)]
    struct Terminal(Arc<Mutex<String>>);

    impl Terminal {
        fn add(&self, text: &str) -> io::Result<()> {
            self.0.lock().unwrap().push_str(text);
            Ok(())
        }
    }

    impl TermLike for Terminal {
        fn width(&self) -> u16 {
            80
        }
        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn write_line(&self, text: &str) -> io::Result<()> {
            self.add(&format!("{text}\n"))
        }
        fn write_str(&self, text: &str) -> io::Result<()> {
            self.add(text)
        }
        fn clear_line(&self) -> io::Result<()> {
            self.add("\n")
        }
        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_bar_takes_one_line_of_a_terminal() {
        let message = "12.3 k of 65.5 k pixels, 1.23 M rays, 124 ms of virtual time".repeat(2);
        for has_length in [true, false] {
            let terminal = Terminal::default();
            let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
            let bar = ProgressBar::with_draw_target(has_length.then_some(100), target);
            set_style(&bar, has_length);
            bar.set_prefix("simulating");
            bar.set_position(50);
            bar.set_message(message.clone());
            bar.tick();
            let shown = terminal.0.lock().unwrap().clone();
            let widest = shown.lines().map(|line| line.chars().count()).max();
            assert!((70..=80).contains(&widest.unwrap_or(0)), "{shown}");
            assert!(shown.contains("simulating") && shown.contains("12.3 k of 65.5 k"), "{shown}");
        }
    }
}
