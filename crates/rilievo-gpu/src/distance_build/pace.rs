//! [`Pace`]: how much a dispatch is to do, by the time that others took.

use std::time::{Duration, Instant};

use crate::device::Gpu;
use crate::error::GpuError;

/// A dispatch is to take about this long: far from the seconds after which drivers reset a GPU.
const DISPATCH: Duration = Duration::from_millis(100);

/// How much a dispatch is to do.
pub(super) struct Pace {
    next: u32,
    last: u32,
    most: u32,
}

impl Pace {
    /// Begins with so much, and never does more than `most`.
    pub fn new(first: u32, most: u32) -> Self {
        Self { next: first.min(most), last: 0, most }
    }

    /// How much of what is left the next dispatch does.
    pub fn next(&mut self, left: u32) -> u32 {
        self.last = self.next.min(left);
        self.last
    }

    /// Submits a dispatch and waits for it.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn run(&mut self, gpu: &Gpu, commands: wgpu::CommandEncoder) -> Result<(), GpuError> {
        let begin = Instant::now();
        gpu.queue.submit([commands.finish()]);
        gpu.wait()?;
        self.took(begin.elapsed());
        Ok(())
    }

    fn took(&mut self, time: Duration) {
        if time > 2 * DISPATCH {
            self.next = (self.last / 2).max(1);
        } else if time < DISPATCH / 2 {
            self.next = self.next.max(self.last.saturating_mul(2)).min(self.most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dispatches_follow_the_time_that_others_took() {
        let mut pace = Pace::new(8, 100);
        let mut sizes = Vec::new();
        for (left, time) in
            [(1000, 10), (900, 10), (800, 60), (700, 10), (3, 1), (90, 900), (70, 1)]
        {
            sizes.push(pace.next(left));
            pace.took(Duration::from_millis(time));
        }
        assert_eq!(sizes, [8, 16, 32, 32, 3, 64, 32]);
        let mut slow = Pace::new(1, 10);
        slow.next(5);
        slow.took(Duration::from_secs(1));
        assert_eq!(slow.next(5), 1);
    }
}
