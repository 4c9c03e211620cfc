//! Counts of rays and of what was said of them.

use std::fmt;
use std::ops::AddAssign;

/// The head of a table of [`Tally::row`]s.
pub const HEAD: &str = "| case | rays | hits | other bits | judged | wrong | excused | escaped | lines | not by turns | s |\n\
                        |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|";

/// Counts of rays and of what was said of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Rays traced by all methods, spawned ones included.
    pub rays: u64,
    pub hits: u64,
    /// Answers of a method that are not those of brute force, bit for bit.
    pub bits: u64,
    /// Rays that the oracle was asked about.
    pub judged: u64,
    /// Answers that are not the oracle's for any ray a nudge away.
    pub wrong: u64,
    /// Those that are.
    pub excused: u64,
    /// Rays from inside that met nothing.
    pub escaped: u64,
    /// Rays followed to the end of their lines.
    pub lines: u64,
    /// Lines that do not go in and out by turns.
    pub odd: u64,
    pub seconds: f64,
}

impl Tally {
    /// What should not be.
    pub fn faults(&self) -> u64 {
        self.bits + self.wrong + self.escaped
    }

    fn counts(&self) -> [u64; 9] {
        let Self { rays, hits, bits, judged, wrong, excused, escaped, lines, odd, .. } = *self;
        [rays, hits, bits, judged, wrong, excused, escaped, lines, odd]
    }

    /// A row of a Markdown table.
    pub fn row(&self, name: &str) -> String {
        let counts: Vec<String> = self.counts().iter().map(u64::to_string).collect();
        format!("| {name} | {} | {:.0} |", counts.join(" | "), self.seconds)
    }

    /// A line of a record.
    pub fn line(&self, begun: u64) -> String {
        let counts: Vec<String> = self.counts().iter().map(u64::to_string).collect();
        format!("{begun}\t{}\t{:.3}", counts.join("\t"), self.seconds)
    }

    /// What [`Tally::line`] wrote.
    pub fn read(line: &str) -> Option<(u64, Self)> {
        let words: Vec<&str> = line.split('\t').collect();
        let [begun, counts @ .., seconds] = words.as_slice() else { return None };
        let numbers: Option<Vec<u64>> = counts.iter().map(|word| word.parse().ok()).collect();
        let [rays, hits, bits, judged, wrong, excused, escaped, lines, odd] = numbers?[..] else {
            return None;
        };
        let seconds = seconds.parse().ok()?;
        let tally = Self { rays, hits, bits, judged, wrong, excused, escaped, lines, odd, seconds };
        Some((begun.parse().ok()?, tally))
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.bits += other.bits;
        self.judged += other.judged;
        self.wrong += other.wrong;
        self.excused += other.excused;
        self.escaped += other.escaped;
        self.lines += other.lines;
        self.odd += other.odd;
        self.seconds += other.seconds;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rays, hits, bits, wrong, excused, escaped, odd, seconds, .. } = self;
        write!(
            f,
            "{rays} rays, {hits} hits, {bits} other bits, {wrong} wrong, {excused} excused, "
        )?;
        write!(f, "{escaped} escaped, {odd} lines not by turns, {seconds:.0} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_as_they_were_written() {
        let tally = Tally { rays: 5, hits: 4, excused: 1, seconds: 0.25, ..Tally::default() };
        assert_eq!(Tally::read(&tally.line(7)), Some((7, tally)));
        assert_eq!(Tally::read("7\t1\t2"), None);
    }
}
