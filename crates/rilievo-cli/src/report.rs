//! What a command says: a report for people on standard error, one JSON object on standard output.

use std::io::{ErrorKind, Write};

use serde::Serialize;

use crate::args::Talk;
use crate::outcome::Failure;

impl Talk {
    /// A line for people.
    pub fn line(self, line: std::fmt::Arguments<'_>) {
        if !self.quiet {
            say(line);
        }
    }

    /// The object for programs, if it was asked for.
    ///
    /// # Errors
    /// [`Failure::Output`]; a reader that has gone away is no error.
    pub fn object(self, object: &impl Serialize) -> Result<(), Failure> {
        if !self.json {
            return Ok(());
        }
        let text = serde_json::to_string(object).map_err(|e| Failure::Output(e.into()))?;
        let mut out = std::io::stdout().lock();
        match writeln!(out, "{text}").and_then(|()| out.flush()) {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::Output(e)),
            _ => Ok(()),
        }
    }
}

/// A line on standard error; if that is closed there is nobody to tell.
pub fn say(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Bytes with a binary unit: `1.5 MiB`.
pub fn bytes(count: u64) -> String {
    let units = ["KiB", "MiB", "GiB", "TiB"];
    let Some(unit) = (1..=4).rev().find(|&power| count >> (10 * power) > 0) else {
        return format!("{count} B");
    };
    let value = count as f64 / 1024f64.powi(unit);
    format!("{value:.1} {}", units[unit as usize - 1])
}

/// What level of detail holds, as a part of a list; nothing if there is none.
pub fn levels(count: u64) -> String {
    if count == 0 { String::new() } else { format!("levels of detail {}, ", bytes(count)) }
}

/// A span of time: `12 ms`, `3.4 s`, `5 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 60.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min {:.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

/// A number with about six digits: `0.381966`, `1.2e-9`.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { format!("{x:.6}") } else { format!("{x:.3e}") }
}

/// A count with a decimal unit: `12.3 million`.
pub fn count(n: u64) -> String {
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => format!("{:.1} thousand", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} million", n as f64 / 1e6),
        _ => format!("{:.1} billion", n as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_units() {
        for (n, want) in [(0, "0 B"), (1023, "1023 B"), (1536, "1.5 KiB"), (7 << 30, "7.0 GiB")] {
            assert_eq!(bytes(n), want);
        }
        let spans =
            [(0.0123, "12 ms"), (3.44, "3.4 s"), (320.5, "5 min 20 s"), (7500.0, "2 h 5 min")];
        for (s, want) in spans {
            assert_eq!(duration(s), want);
        }
        for (x, want) in [(0.0, "0.000000"), (-1.5, "-1.500000"), (1.234e-9, "1.234e-9")] {
            assert_eq!(number(x), want);
        }
        for (n, want) in [(12, "12"), (12_345, "12.3 thousand"), (2_500_000_000, "2.5 billion")] {
            assert_eq!(count(n), want);
        }
    }
}
