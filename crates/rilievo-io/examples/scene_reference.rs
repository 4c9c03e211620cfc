//! Prints docs/SCENE.md, read from standard input, with the tables of keys as the parser has them:
//! what `cargo xtask reference` runs.

use std::io::{Read, Write};
use std::process::ExitCode;

fn main() -> std::io::Result<ExitCode> {
    let mut page = String::new();
    std::io::stdin().read_to_string(&mut page)?;
    match rilievo_io::scene::reference(&page) {
        Some(page) => {
            std::io::stdout().write_all(page.as_bytes())?;
            Ok(ExitCode::SUCCESS)
        }
        None => {
            writeln!(std::io::stderr(), "the page does not have each section of keys once")?;
            Ok(ExitCode::FAILURE)
        }
    }
}
