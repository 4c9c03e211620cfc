//! [`Pace`]: how much work is given to a device at once, by the time that the last such work took.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// How long work at once is to take: far from the seconds after which drivers reset a GPU, long enough that
/// its start does not count.
pub(super) const ALONE: Duration = Duration::from_millis(100);

/// The same where somebody waits to change the picture.
pub(super) const WATCHED: Duration = Duration::from_millis(25);

/// The first time.
const FIRST: u32 = 1 << 14;

/// Fewer are not worth the way.
const FEWEST: u32 = 1 << 10;

/// Rays of the largest dispatch: 64 a workgroup, at most 65535 workgroups.
const MOST_RAYS: u32 = 1 << 20;

/// Camera rays on their way at once, at most.
pub(crate) const MOST_SLOTS: u32 = 1 << 18;

/// How many of something at once.
pub(crate) struct Pace {
    now: AtomicU32,
    most: u32,
}

/// Those of rays in a dispatch, and of camera rays in a round of shading.
pub(crate) struct Paces {
    pub rays: Pace,
    pub slots: Pace,
}

impl Default for Paces {
    fn default() -> Self {
        let pace = |most| Pace { now: FIRST.into(), most };
        Self { rays: pace(MOST_RAYS), slots: pace(MOST_SLOTS) }
    }
}

impl Pace {
    /// How many.
    pub fn get(&self) -> u32 {
        self.now.load(Ordering::Relaxed)
    }

    /// So many took so long, and were to take `aim`: fewer the next time if that was more than twice as long, more if it
    /// was less than half and as many as were allowed.
    pub fn took(&self, count: u32, took: Duration, aim: Duration) {
        let now = self.get();
        if took > 2 * aim {
            self.now.store((count / 2).clamp(FEWEST, self.most).min(now), Ordering::Relaxed);
        } else if took < aim / 2 && count >= now {
            self.now.store(now.saturating_mul(2).min(self.most), Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_follows_the_time_that_it_takes_within_bounds() {
        let (pace, ms) = (Paces::default().slots, Duration::from_millis);
        for _ in 0..40 {
            pace.took(pace.get(), ms(1), ALONE);
        }
        assert_eq!(pace.get(), MOST_SLOTS);
        for _ in 0..40 {
            pace.took(pace.get(), ms(1000), ALONE);
        }
        assert_eq!(pace.get(), FEWEST);
        // Little work that was soon done says nothing of more.
        pace.took(FEWEST / 2, ms(1), ALONE);
        assert_eq!(pace.get(), FEWEST);
        pace.took(FEWEST, ms(70), ALONE);
        assert_eq!(pace.get(), FEWEST);
    }
}
