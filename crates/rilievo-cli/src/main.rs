//! The command `rilievo`: parse, run, exit code.

#![forbid(unsafe_code)]

mod args;
mod backend;
mod bake;
mod check;
mod checkpoint;
mod denoise;
mod diff;
mod info;
mod interrupt;
mod job;
mod live;
mod memory;
mod merge;
mod name;
mod outcome;
mod picture;
mod progress;
mod render;
mod report;
mod stopwatch;
mod view;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(e) => {
            // Help goes to standard output, errors to standard error; closed ones are no news.
            let _ = e.print();
            return ExitCode::from(e.exit_code() as u8);
        }
    };
    let result = match &arguments.command {
        Command::View(args) => match view::run(args) {
            Ok(code) => return code,
            Err(failure) => Err(failure),
        },
        Command::Render(args) => render::run(args),
        Command::Bake(args) => bake::run(args),
        Command::Info(args) => info::run(args),
        Command::Check(args) => check::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Merge(args) => merge::run(args),
    };
    match result {
        Ok(outcome) => ExitCode::from(outcome.code()),
        Err(failure) => {
            report::say(format_args!("error: {failure}"));
            ExitCode::from(failure.code())
        }
    }
}
