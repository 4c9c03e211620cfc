//! [`Watch`]: processor time and wall time.
//!
//! Rates are taken from processor time: on a machine that others use too the wall clock counts the
//! neighbours' work.

use std::time::Instant;

use rustix::time::{ClockId, Timespec, clock_gettime};
use serde::Serialize;

/// What a watch shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Took {
    /// Processor seconds of all threads of this process.
    pub cpu: f64,
    /// Seconds of the clock on the wall.
    pub wall: f64,
}

/// Runs from its start.
pub struct Watch {
    wall: Instant,
    cpu: f64,
}

impl Watch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: seconds(clock_gettime(ClockId::ProcessCPUTime)) }
    }

    /// Time since the start.
    pub fn took(&self) -> Took {
        let cpu = seconds(clock_gettime(ClockId::ProcessCPUTime)) - self.cpu;
        Took { cpu, wall: self.wall.elapsed().as_secs_f64() }
    }
}

/// Runs `work`; its result and the processor seconds of this thread that it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = seconds(clock_gettime(ClockId::ThreadCPUTime));
    let result = std::hint::black_box(work());
    (result, seconds(clock_gettime(ClockId::ThreadCPUTime)) - begin)
}

fn seconds(time: Timespec) -> f64 {
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_processor_time_and_sleep_does_not() {
        let watch = Watch::start();
        let (spun, cpu) = timed(|| {
            let begin = Instant::now();
            let mut x = 1u64;
            while begin.elapsed().as_millis() < 5 {
                x = std::hint::black_box(x.wrapping_mul(3));
            }
            x
        });
        assert_ne!(spun, 0);
        assert!(cpu > 0.0 && watch.took().wall >= 0.005 && watch.took().cpu >= cpu);
        let ((), asleep) = timed(|| std::thread::sleep(std::time::Duration::from_millis(20)));
        assert!(asleep < 0.02);
    }
}
