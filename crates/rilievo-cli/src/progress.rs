//! [`Progress`]: how far work is, on standard error: a bar on a terminal, lines elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::report::{duration, say};

/// Time between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// How far a piece of work is; shown until dropped.
pub struct Progress(Shown);

enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines(Mutex<Lines>),
}

struct Lines {
    what: String,
    start: Instant,
    last: Instant,
}

impl Progress {
    /// Work that counts up to `total`.
    pub fn counted(quiet: bool, what: &str, total: u64) -> Self {
        Self::new(quiet, what, || {
            let bar = ProgressBar::new(total);
            if let Ok(style) =
                ProgressStyle::with_template("{msg} {wide_bar} {percent}% {eta} left")
            {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        })
    }

    /// Work of unknown length. Without a terminal its begin is said at once.
    pub fn uncounted(quiet: bool, what: &str) -> Self {
        let progress = Self::new(quiet, what, || {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{msg} {spinner} {elapsed}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        if let Shown::Lines(_) = progress.0 {
            say(format_args!("{what}"));
        }
        progress
    }

    fn new(quiet: bool, what: &str, bar: impl FnOnce() -> ProgressBar) -> Self {
        if quiet {
            return Self(Shown::Nothing);
        }
        let what = what.to_owned();
        if std::io::stderr().is_terminal() {
            let bar = bar();
            bar.set_message(what);
            return Self(Shown::Bar(bar));
        }
        let now = Instant::now();
        Self(Shown::Lines(Mutex::new(Lines { what, start: now, last: now })))
    }

    /// `done` of `total` is done. May be called from any thread, in any order.
    pub fn update(&self, done: u64, total: u64) {
        match &self.0 {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.update(|state| state.set_pos(state.pos().max(done))),
            Shown::Lines(lines) => {
                // Whoever finds the lock taken has nothing newer to say.
                if let Ok(mut lines) = lines.try_lock() {
                    lines.update(done, total);
                }
            }
        }
    }
}

impl Drop for Progress {
    /// The work is over; a bar is taken away.
    fn drop(&mut self) {
        if let Shown::Bar(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

impl Lines {
    fn update(&mut self, done: u64, total: u64) {
        if self.last.elapsed() < LINE_EVERY || done == 0 || done >= total {
            return;
        }
        self.last = Instant::now();
        let share = done as f64 / total as f64;
        let left = self.start.elapsed().as_secs_f64() * (1.0 - share) / share;
        say(format_args!("{}: {:.0} %, {} left", self.what, 100.0 * share, duration(left)));
    }
}
