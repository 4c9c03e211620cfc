//! [`Stopwatch`]: how long something took, and how much of a processor.

use std::time::Instant;

/// Ticks of `/proc/self/stat` in a second; Linux promises programs this unit on every machine.
const TICKS: f64 = 100.0;

/// Runs from its start.
pub struct Stopwatch {
    wall: Instant,
    cpu: Option<f64>,
}

/// What a stopwatch shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Elapsed {
    /// Time of the clock on the wall.
    pub seconds: f64,
    /// Processor time of all threads of this process, in steps of 10 ms. None where the system does
    /// not tell. On a machine that others use too it says more than the clock.
    pub cpu_seconds: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: process_cpu_seconds() }
    }

    pub fn elapsed(&self) -> Elapsed {
        let cpu_seconds = self.cpu.zip(process_cpu_seconds()).map(|(from, to)| to - from);
        Elapsed { seconds: self.wall.elapsed().as_secs_f64(), cpu_seconds }
    }
}

/// Processor time of this process so far, threads that have ended included.
fn process_cpu_seconds() -> Option<f64> {
    parse(&std::fs::read_to_string("/proc/self/stat").ok()?)
}

/// User and system time from the text of `/proc/self/stat`, its fields 14 and 15. The name of the
/// program, field 2, stands in brackets and may hold anything.
fn parse(stat: &str) -> Option<f64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut ticks = after_name.split_ascii_whitespace().skip(11).map(str::parse::<u64>);
    let (user, system) = (ticks.next()?.ok()?, ticks.next()?.ok()?);
    Some((user + system) as f64 / TICKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_counted_after_the_name() {
        let stat = "7 (a) b (c) R 1 2 3 4 5 6 7 8 9 10 250 75 0 0";
        assert_eq!(parse(stat), Some(3.25));
        assert_eq!(parse("7 (a) R 1 2"), None);
        assert_eq!(parse(""), None);
    }

    #[test]
    fn work_takes_time() {
        let watch = Stopwatch::start();
        let begin = Instant::now();
        let mut x = 1u64;
        while begin.elapsed().as_millis() < 20 {
            x = std::hint::black_box(x.wrapping_mul(3));
        }
        let elapsed = watch.elapsed();
        assert!(elapsed.seconds >= 0.02);
        assert!(elapsed.cpu_seconds.is_none_or(|s| (0.0..3600.0).contains(&s)));
    }
}
