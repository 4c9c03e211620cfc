//! What a command says: lines for people on standard error, JSON lines on standard output.

use std::io::{self, Write};

use serde::Serialize;

/// A line on standard error; if that is closed there is nobody to tell.
pub fn say(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// A line on standard output.
///
/// # Errors
/// When standard output cannot be written.
pub fn print(line: &str) -> Result<(), String> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(|e| format!("stdout: {e}"))
}

/// One JSON object as a line on standard output.
///
/// # Errors
/// As `print`.
pub fn object(object: &impl Serialize) -> Result<(), String> {
    print(&serde_json::to_string(object).map_err(|e| e.to_string())?)
}
