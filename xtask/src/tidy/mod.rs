//! `cargo xtask tidy`: the house rules that neither rustc nor clippy knows.
//!
//! A rule is a function from the [`Tree`] to its [`Finding`]s. Rules read committed text only, so
//! each is tested on a small tree in memory. An error fails the run, a warning is printed.

mod calls;
mod citations;
mod gallery;
mod heads;
mod links;
mod manifests;
mod names;
mod origins;
mod paths;
mod size;
mod source;
mod todos;
mod tree;

use std::fmt;
use std::path::Path;

use crate::say;
use tree::Tree;

/// Whether a finding fails the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    /// Worth a question.
    Warning,
    /// Breaks a rule.
    Error,
}

/// What a rule has to say about one place.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Finding {
    level: Level,
    path: String,
    /// Counted from 1; `None` speaks of the whole file.
    line: Option<usize>,
    message: String,
}

impl Finding {
    fn error(path: &str, line: Option<usize>, message: impl Into<String>) -> Self {
        Self { level: Level::Error, path: path.to_owned(), line, message: message.into() }
    }

    fn warning(path: &str, line: Option<usize>, message: impl Into<String>) -> Self {
        Self { level: Level::Warning, ..Self::error(path, line, message) }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = match self.level {
            Level::Warning => "warning",
            Level::Error => "error",
        };
        match self.line {
            Some(line) => write!(f, "{level}: {}:{line}: {}", self.path, self.message),
            None => write!(f, "{level}: {}: {}", self.path, self.message),
        }
    }
}

/// Every rule, in the order in which it reports.
const RULES: &[fn(&Tree) -> Vec<Finding>] = &[
    size::check,
    names::check,
    heads::check,
    manifests::check,
    calls::check,
    todos::check,
    citations::check,
    links::check,
    paths::check,
    origins::check,
    gallery::check,
];

/// Checks the repository at `root`, prints what it finds, and says whether no rule is broken.
pub fn run(root: &Path) -> bool {
    let tree = match Tree::read(root) {
        Ok(tree) => tree,
        Err(error) => {
            say(&format!("tidy: cannot list the repository: {error}"));
            return false;
        }
    };
    let findings = check(&tree);
    for finding in &findings {
        say(&finding.to_string());
    }
    let errors = count(&findings, Level::Error);
    let warnings = count(&findings, Level::Warning);
    say(&format!("tidy: {} files, {errors} errors, {warnings} warnings", tree.files().len()));
    errors == 0
}

fn check(tree: &Tree) -> Vec<Finding> {
    RULES.iter().flat_map(|rule| rule(tree)).collect()
}

fn count(findings: &[Finding], level: Level) -> usize {
    findings.iter().filter(|f| f.level == level).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_names_level_path_line_and_message() {
        let finding = Finding::error("a/b.rs", Some(3), "is wrong");
        assert_eq!(finding.to_string(), "error: a/b.rs:3: is wrong");
        let finding = Finding::warning("a/b.rs", None, "is long");
        assert_eq!(finding.to_string(), "warning: a/b.rs: is long");
    }

    #[test]
    fn every_rule_is_asked() {
        let tree = Tree::of(&[(
            "crates/rilievo/src/utils.rs",
            "fn f() { std::fs::read(\"x\"); } // TODO mend",
        )]);
        let messages: Vec<String> = check(&tree).iter().map(Finding::to_string).collect();
        for part in ["module name", "module doc", "reads files", "issue number"] {
            assert!(messages.iter().any(|m| m.contains(part)), "{part}: {messages:?}");
        }
    }
}
