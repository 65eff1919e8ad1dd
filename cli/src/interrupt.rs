//! Ctrl-C: what was half done is removed, and the command ends at once; or, where it can, it keeps what
//! it has, and a second Ctrl-C ends it at once. One that comes with the first is none: a terminal and `timeout`
//! may both send theirs.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

/// How long after the first a signal is still the same wish.
const ONE_WISH: Duration = Duration::from_millis(200);

/// The work at hand can end early, and keep what it has.
static GENTLE: AtomicBool = AtomicBool::new(false);
/// It was asked to.
static CANCEL: AtomicBool = AtomicBool::new(false);

/// Files that are not complete yet, and directories that were made for them.
static PARTIAL: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file to remove on an interrupt, as long as this lives; or a directory, if nothing is in it.
#[derive(Debug)]
pub(crate) struct Partial(PathBuf);

impl Partial {
    /// Enters a file or a directory, by a path from the root.
    pub(crate) fn new(path: &Path) -> Self {
        if let Ok(mut all) = PARTIAL.lock() {
            all.insert(path.to_owned());
        }
        Self(path.to_owned())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if let Ok(mut all) = PARTIAL.lock() {
            all.remove(&self.0);
        }
    }
}

/// From now on the first Ctrl-C sets this, and the command ends in its own way.
pub(crate) fn gentle() -> &'static AtomicBool {
    GENTLE.store(true, Ordering::Relaxed);
    &CANCEL
}

/// Whether the work was asked to end early.
pub(crate) fn is_asked() -> bool {
    CANCEL.load(Ordering::Relaxed)
}

/// Whether a signal is the first one, or comes with it.
fn is_one_wish(first: &mut Option<Instant>, now: Instant) -> bool {
    now.duration_since(*first.get_or_insert(now)) < ONE_WISH
}

/// From now on Ctrl-C (and a request to terminate) ends the command with exit code 1.
pub(crate) fn install() {
    // Where no handler can be set the system's default ends the command as well.
    let mut asked = None;
    let _ = ctrlc::set_handler(move || {
        if GENTLE.load(Ordering::Relaxed) && is_one_wish(&mut asked, Instant::now()) {
            CANCEL.store(true, Ordering::Relaxed);
            return;
        }
        // The lock is kept: no file can be completed or begun from here on.
        let all = PARTIAL.lock();
        if let Ok(all) = &all {
            // What lies in a directory comes before it.
            for path in all.iter().rev() {
                let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
            }
        }
        crate::progress::clear();
        crate::failure::print("interrupted; what was half done is removed");
        std::process::exit(1);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_signal_counts_when_it_is_another_wish() {
        let (begin, mut first) = (Instant::now(), None);
        let mut at = |ms| is_one_wish(&mut first, begin + Duration::from_millis(ms));
        assert_eq!([5, 6, 204, 205, 9000].map(&mut at), [true, true, true, false, false]);
    }
}
