//! The command `conformance`: displaced spheres and meshes against brute force and judge, for as many rays as one
//! likes. `cargo xtask conformance` runs it; CONTRIBUTING.md says how.
//!
//! Each case is gone through in parts; what is done stands in `target/conformance`, so a run that is stopped goes
//! on where it was. Another build of the program begins anew.

#![forbid(unsafe_code)]

mod arguments;
mod inside;
mod mesh;
mod record;
mod sphere;
mod tally;

use std::io::Write;
use std::process::ExitCode;

use arguments::Arguments;
use record::Record;

/// Brings a record to the rays it is to have.
type Run = dyn Fn(&mut Record) -> std::io::Result<()> + Sync;

/// A case, and how its rays are judged.
struct Job {
    name: String,
    run: Box<Run>,
}

const USAGE: &str =
    "usage: cargo xtask conformance [--rays N] [--case TEXT]... [--threads N] [--list] [--table]";

fn main() -> ExitCode {
    let arguments = match Arguments::parse(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(why) => {
            say(&format!("{why}\n{USAGE}"));
            return ExitCode::from(2);
        }
    };
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Goes through the cases that are asked for; says whether none has a fault.
fn run(arguments: &Arguments) -> std::io::Result<bool> {
    let jobs: Vec<Job> = [inside::jobs(), sphere::jobs(), mesh::jobs()]
        .into_iter()
        .flatten()
        .filter(|job| arguments.asks_for(&job.name))
        .collect();
    if jobs.is_empty() {
        say("no such case; --list names all");
        return Ok(false);
    }
    if arguments.list {
        for job in &jobs {
            tell(&job.name);
        }
        return Ok(true);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build();
    let pool = pool.map_err(std::io::Error::other)?;
    let mut records = Vec::new();
    for job in &jobs {
        let rays = if arguments.table { 0 } else { arguments.rays };
        let mut record = Record::open(&job.name, rays)?;
        if record.is_wanting() {
            pool.install(|| (job.run)(&mut record))?;
            say(&format!("{}: {}", job.name, record.sum));
        }
        records.push(record);
    }
    tell(tally::HEAD);
    for record in &records {
        tell(&record.sum.row(&record.name));
    }
    Ok(records.iter().all(|record| record.sum.faults() == 0))
}

/// Writes one line to stdout; a closed stdout is no reason to fail.
fn tell(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Writes one line to stderr.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
