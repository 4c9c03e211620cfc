//! `cargo xtask`: development commands.
//!
//! * `cargo xtask ci` runs everything that gates a change, in the order in which it fails fastest.
//! * `cargo xtask conformance` judges displaced spheres and meshes, optimised, for as many rays as one likes.
//! * `cargo xtask reference` writes the tables of keys in docs/SCENE.md from those of the parser.
//! * `cargo xtask figures` draws the pictures and measures the tables of `docs`.
//! * `cargo xtask tidy` checks the house rules that neither rustc nor clippy knows.
//!
//! Exit codes: 0 all is well, 1 something failed, 2 the command line is wrong.

#![forbid(unsafe_code)]

mod ci;
mod figures;
mod reference;
mod tidy;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask <ci | tidy | reference | conformance [WORD...] | figures [--quick] [PART...]>";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root =
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the repository");
    let passed = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["ci"] => ci::run(root),
        ["tidy"] => tidy::run(root),
        ["reference"] => reference::run(root),
        ["conformance", ref words @ ..] => ci::conformance(root, words),
        ["figures", ref words @ ..] => match figures::run(root, words) {
            Ok(passed) => passed,
            Err(why) => {
                say(&format!("{why}\n{USAGE}"));
                return ExitCode::from(2);
            }
        },
        _ => {
            say(USAGE);
            return ExitCode::from(2);
        }
    };
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Writes one line to stderr; a closed stderr is no reason to fail.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
