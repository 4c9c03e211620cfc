//! [`Record`]: what is done of a case, on disk.

use std::collections::hash_map::DefaultHasher;
use std::fs::{self, File, OpenOptions};
use std::hash::{Hash, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;

use super::say;
use super::tally::Tally;

/// Rays between two lines of a record.
const PART: u64 = 50_000;

/// Parts between two lines of progress.
const PARTS: u64 = 10;

/// What is done of a case: one line a part, below the name of the program that did it.
pub struct Record {
    pub name: String,
    /// Of all parts.
    pub sum: Tally,
    path: PathBuf,
    /// Numbers of rays begun with.
    done: u64,
    wanted: u64,
}

impl Record {
    /// What this program has recorded of a case; it is to be brought to `wanted` rays.
    pub fn open(name: &str, wanted: u64) -> io::Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/conformance");
        fs::create_dir_all(&folder)?;
        let path = folder.join(name.replace(' ', "-")).with_extension("tsv");
        let mut record =
            Self { name: name.to_owned(), sum: Tally::default(), path, done: 0, wanted };
        let program = program()?;
        let text = fs::read_to_string(&record.path).unwrap_or_default();
        let mut lines = text.lines();
        if lines.next() == Some(program.as_str()) {
            // A line cut short by a crash, and what follows it, is done again.
            for (begun, tally) in lines.map_while(Tally::read) {
                record.sum += tally;
                record.done = begun + PART;
            }
        } else if wanted > 0 {
            fs::write(&record.path, format!("{program}\n"))?;
        }
        Ok(record)
    }

    /// Whether rays are missing.
    pub fn is_wanting(&self) -> bool {
        self.done < self.wanted
    }

    /// Judges all rays that are missing, by number; what is found fault with is described in a file beside the record.
    pub fn judge(&mut self, ray: impl Fn(u64) -> (Tally, Option<String>) + Sync) -> io::Result<()> {
        let mut lines = OpenOptions::new().append(true).open(&self.path)?;
        while self.is_wanting() {
            let begin = Instant::now();
            let found: Vec<_> = (self.done..self.done + PART).into_par_iter().map(&ray).collect();
            let mut part = Tally::default();
            for (number, (tally, fault)) in (self.done..).zip(found) {
                part += tally;
                if let Some(fault) = fault {
                    let path = self.path.with_extension("faults");
                    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
                    writeln!(file, "ray {number}: {fault}")?;
                }
            }
            part.seconds = begin.elapsed().as_secs_f64();
            writeln!(lines, "{}", part.line(self.done))?;
            self.sum += part;
            self.done += PART;
            if (self.done / PART).is_multiple_of(PARTS) {
                say(&format!("{}, {} of {}: {}", self.name, self.done, self.wanted, self.sum));
            }
        }
        Ok(())
    }
}

/// Tells builds of this program apart.
fn program() -> io::Result<String> {
    let mut hasher = DefaultHasher::new();
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut File::open(std::env::current_exe()?)?, &mut bytes)?;
    bytes.hash(&mut hasher);
    Ok(format!("program {:016x}", hasher.finish()))
}
