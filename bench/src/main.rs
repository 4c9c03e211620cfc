//! The command `rilievo-bench`: rilievo and its peers, measured on equal terms.
//!
//! `bench/README.md` says how to run it and what makes the comparison fair.

mod args;
mod builds;
mod clock;
mod contender;
#[cfg(feature = "embree")]
mod embree;
mod gpu;
mod kernels;
mod map;
mod measure;
mod plots;
mod random;
mod rays;
mod report;
mod runs;
mod solids;
mod tally;
mod transforms;
mod walks;

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
        Command::Kernels(args) => kernels::run(args),
        Command::Transforms(args) => transforms::run(args),
        Command::Walks(args) => walks::run(args),
        Command::Solids(args) => solids::run(args),
        Command::Refinement(args) => solids::refinement(args),
        Command::Build(args) => builds::run(args),
        Command::Gpu(args) => gpu::run(args),
        Command::Machine => runs::machine(),
        Command::Summary(args) => runs::summary(&args.run),
        Command::Plots(args) => {
            plots::plots(&args.run, args.output.as_deref().unwrap_or(&args.run))
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            report::say(format_args!("error: {failure}"));
            ExitCode::FAILURE
        }
    }
}

/// Runs `work` in a pool of one thread: what is measured there is one thread's time.
fn one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        // No thread to be had: the caller's own.
        Err(_) => work(),
    }
}
