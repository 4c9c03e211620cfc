//! `cargo xtask ci`: the run that gates every change.
//!
//! Steps stand in the order of their cost, and the first failure ends the run. Every cargo call
//! takes `--locked`: what was tested is what the lock file says.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::{say, tidy};

/// One cargo command of the run.
struct Step {
    name: &'static str,
    arguments: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

const FORMAT: &[Step] = &[
    Step { name: "format", arguments: &["fmt", "--all", "--check"], environment: &[] },
    Step {
        name: "format of the fuzz targets",
        arguments: &["fmt", "--manifest-path", "fuzz/Cargo.toml", "--check"],
        environment: &[],
    },
];

const COMPILED: &[Step] = &[
    Step {
        name: "clippy",
        arguments: &["clippy", "--locked", "--workspace", "--all-targets", "--", "-D", "warnings"],
        environment: &[],
    },
    Step {
        name: "documentation",
        arguments: &["doc", "--locked", "--workspace", "--no-deps", "--document-private-items"],
        environment: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step {
        name: "fuzz targets compile",
        arguments: &["check", "--locked", "--manifest-path", "fuzz/Cargo.toml"],
        environment: &[],
    },
    Step { name: "tests", arguments: &["test", "--locked", "--workspace"], environment: &[] },
];

/// Runs all steps from the repository root; says whether all passed.
pub fn run(root: &Path) -> bool {
    let begin = Instant::now();
    let passed = FORMAT.iter().all(|step| cargo(root, step))
        && tidy::run(root)
        && COMPILED.iter().all(|step| cargo(root, step));
    let verdict = if passed { "passed" } else { "FAILED" };
    say(&format!("ci {verdict} after {:.0} s", begin.elapsed().as_secs_f64()));
    passed
}

/// Builds the program `conformance` of rilievo-tests and runs it with some words; says whether it found no fault.
pub fn conformance(root: &Path, words: &[&str]) -> bool {
    let build = ["run", "--locked", "--quiet", "--release", "--package", "rilievo-tests"];
    let arguments = [&build[..], &["--bin", "conformance", "--"], words].concat();
    start(root, &arguments, &[])
}

/// Runs one step; says whether it passed. Cargo's own output goes where ours goes.
fn cargo(root: &Path, step: &Step) -> bool {
    say(&format!("== {}: cargo {}", step.name, step.arguments.join(" ")));
    let begin = Instant::now();
    let passed = start(root, step.arguments, step.environment);
    let verdict = if passed { "passed" } else { "FAILED" };
    say(&format!("== {}: {verdict} in {:.0} s", step.name, begin.elapsed().as_secs_f64()));
    passed
}

/// Runs cargo; says whether it succeeded.
fn start(root: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> bool {
    // Cargo names itself to the programs it runs; outside of it, take the one on the path.
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(program)
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(root)
        .status();
    match status {
        Ok(status) => status.success(),
        Err(error) => {
            say(&format!("cannot run cargo: {error}"));
            false
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps() -> impl Iterator<Item = &'static Step> {
        FORMAT.iter().chain(COMPILED)
    }

    #[test]
    fn every_step_that_resolves_packages_is_locked() {
        for step in steps().filter(|step| step.arguments[0] != "fmt") {
            assert!(step.arguments.contains(&"--locked"), "{}", step.name);
        }
    }

    #[test]
    fn warnings_fail_clippy_and_documentation() {
        let clippy = steps().find(|step| step.name == "clippy").unwrap();
        assert!(clippy.arguments.ends_with(&["-D", "warnings"]));
        let documentation = steps().find(|step| step.name == "documentation").unwrap();
        assert_eq!(documentation.environment, [("RUSTDOCFLAGS", "-D warnings")]);
    }

    #[test]
    fn a_failing_command_fails_its_step() {
        let step =
            Step { name: "no such command", arguments: &["no-such-command"], environment: &[] };
        assert!(!cargo(Path::new(env!("CARGO_MANIFEST_DIR")), &step));
    }
}
