//! `rilievo view`: starts the program `rilievo-viewer`, which has a window.
//!
//! It is a program of its own, so that this one needs no window system to be built or run.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Args;

use crate::outcome::Failure;

const PROGRAM: &str = "rilievo-viewer";

/// All of it is for that program.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// What rilievo-viewer takes: SCENE, MAP or FOLDER, and its flags; `rilievo view --help` lists them.
    #[arg(value_name = "ARGUMENTS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

/// Runs the viewer with the arguments it was given; its exit code, 1 if a signal ended it.
pub fn run(args: &ViewArgs) -> Result<ExitCode, Failure> {
    let program = beside().unwrap_or_else(|| PROGRAM.into());
    let status = Command::new(&program).args(&args.arguments).status().map_err(|e| {
        Failure::Refused(format!(
            "{}: {e}\n`rilievo view` needs the program {PROGRAM} beside rilievo or on the search path; \
             it is built by `cargo build --release -p {PROGRAM}`",
            program.display()
        ))
    })?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(1)))
}

/// The viewer in the folder of this program.
fn beside() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let path = std::env::current_exe().ok()?.with_file_name(name);
    path.is_file().then_some(path)
}
