//! [`Interrupt`]: Ctrl-C, SIGTERM and time limits ask for a stop; a second signal kills.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The signals that are caught.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGINT: Ctrl-C.
    Interrupt,
    /// SIGTERM.
    Terminate,
}

impl Signal {
    const ALL: [Self; 2] = [Self::Interrupt, Self::Terminate];

    fn number(self) -> i32 {
        match self {
            Self::Interrupt => SIGINT,
            Self::Terminate => SIGTERM,
        }
    }

    /// 128 plus the number of the signal, as shells count.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Interrupt => 130,
            Self::Terminate => 143,
        }
    }
}

/// A request to stop, from outside or from a time limit.
pub struct Interrupt {
    /// Set by the first signal and by the end of a time limit.
    stop: Arc<AtomicBool>,
    /// Set by the first signal: the next one has its default effect.
    armed: Arc<AtomicBool>,
    /// Number of the signal that came, or 0.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Catches the signals from here on.
    ///
    /// # Errors
    /// If the system refuses the handlers.
    pub fn install() -> io::Result<Self> {
        let interrupt =
            Self { stop: Arc::default(), armed: Arc::default(), signal: Arc::default() };
        for signal in Signal::ALL {
            let number = signal.number();
            // Handlers run in this order, so that the first signal does not arm itself.
            flag::register_conditional_default(number, Arc::clone(&interrupt.armed))?;
            flag::register(number, Arc::clone(&interrupt.armed))?;
            flag::register_usize(number, Arc::clone(&interrupt.signal), number as usize)?;
            flag::register(number, Arc::clone(&interrupt.stop))?;
        }
        Ok(interrupt)
    }

    /// Set once a stop is asked for.
    pub fn flag(&self) -> &AtomicBool {
        &self.stop
    }

    /// The signal that came, if any.
    pub fn signal(&self) -> Option<Signal> {
        let number = self.signal.load(Ordering::SeqCst);
        Signal::ALL.into_iter().find(|signal| signal.number() as usize == number)
    }

    /// Does `work` and asks for a stop once `limit` has passed. Says whether it has.
    pub fn limited<T>(&self, limit: Option<Duration>, work: impl FnOnce() -> T) -> (T, bool) {
        let Some(limit) = limit else {
            return (work(), false);
        };
        let (finished, wait) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            let watch = scope.spawn(move || {
                let late = wait.recv_timeout(limit) == Err(mpsc::RecvTimeoutError::Timeout);
                if late {
                    self.stop.store(true, Ordering::SeqCst);
                }
                late
            });
            let result = work();
            drop(finished);
            (result, watch.join().unwrap_or(false))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_limit_asks_for_a_stop_and_quick_work_does_not_wait_for_it() {
        let interrupt = Interrupt::install().unwrap();
        let hour = Some(Duration::from_secs(3600));
        assert_eq!(interrupt.limited(hour, || 7), (7, false));
        assert!(!interrupt.flag().load(Ordering::SeqCst));
        let wait = || {
            while !interrupt.flag().load(Ordering::SeqCst) {
                std::thread::yield_now();
            }
        };
        assert_eq!(interrupt.limited(Some(Duration::from_millis(5)), wait), ((), true));
        assert_eq!(interrupt.signal(), None);
    }
}
