//! `cargo xtask reference`: the tables of keys in docs/SCENE.md, from those of the parser.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::say;

const PAGE: &str = "docs/SCENE.md";

/// Writes the page anew; says whether it could.
pub fn run(root: &Path) -> bool {
    let page = root.join(PAGE);
    let input = match File::open(&page) {
        Ok(file) => file,
        Err(error) => {
            say(&format!("{PAGE}: {error}"));
            return false;
        }
    };
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(program)
        .args(["run", "--locked", "--quiet", "-p", "rilievo-io", "--example", "scene_reference"])
        .current_dir(root)
        .stdin(input)
        .stderr(Stdio::inherit())
        .output();
    match output {
        Ok(output) if output.status.success() => match fs::write(&page, output.stdout) {
            Ok(()) => true,
            Err(error) => {
                say(&format!("{PAGE}: {error}"));
                false
            }
        },
        Ok(_) => false,
        Err(error) => {
            say(&format!("cannot run cargo: {error}"));
            false
        }
    }
}
