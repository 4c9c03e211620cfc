//! The program `rilievo-viewer`: a window on a scene.
//!
//! The scene is read while the window is made; what is wrong with it is told in the terminal, and no window
//! is shown.

#![forbid(unsafe_code)]

mod args;
mod journal;
mod window;

use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;

use args::Arguments;

fn main() -> ExitCode {
    let started = Instant::now();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(e) => {
            // Help goes to standard output, errors to standard error; closed ones are no news.
            let _ = e.print();
            return ExitCode::from(e.exit_code() as u8);
        }
    };
    match window::run(arguments, started) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            let _ = writeln!(std::io::stderr(), "error: {why}");
            ExitCode::FAILURE
        }
    }
}
