//! Rule: crates depend on each other downwards only, and all take the workspace's lints.
//!
//! ```text
//! rilievo  <-  rilievo-render  <-  rilievo-io, rilievo-gpu  <-  rilievo-cli, rilievo-viewer
//! ```

use super::Finding;
use super::tree::Tree;

/// A package of ours and the packages of ours that it may name.
const GRAPH: &[(&str, &[&str])] = &[
    ("rilievo", &[]),
    ("rilievo-render", &["rilievo"]),
    ("rilievo-io", &["rilievo", "rilievo-render"]),
    // Its tests trace the scenes of the conformance suite and draw those of the gallery.
    ("rilievo-gpu", &["rilievo", "rilievo-render", "rilievo-io", "rilievo-tests"]),
    ("rilievo-cli", &["rilievo", "rilievo-render", "rilievo-io", "rilievo-gpu"]),
    ("rilievo-viewer", &["rilievo", "rilievo-render", "rilievo-io", "rilievo-gpu"]),
    ("rilievo-tests", &["rilievo", "rilievo-render", "rilievo-io", "rilievo-cli"]),
    ("rilievo-bench", &["rilievo", "rilievo-io", "rilievo-gpu"]),
    ("rilievo-fuzz", &["rilievo", "rilievo-render", "rilievo-io", "rilievo-tests"]),
    ("xtask", &[]),
];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts("toml") {
        if path == "Cargo.toml" || !path.ends_with("/Cargo.toml") {
            continue;
        }
        let manifest = Manifest::new(text);
        let Some((_, allowed)) = GRAPH.iter().find(|(name, _)| *name == manifest.name) else {
            let message = format!("package \"{}\" has no place in the crate graph", manifest.name);
            findings.push(Finding::error(path, None, message));
            continue;
        };
        for (line, dependency) in &manifest.dependencies {
            let ours = GRAPH.iter().any(|(name, _)| name == dependency);
            if ours && !allowed.contains(&dependency.as_str()) {
                let message = format!("{} may not depend on {dependency}", manifest.name);
                findings.push(Finding::error(path, Some(*line), message));
            }
        }
        if !manifest.takes_workspace_lints && manifest.name != "rilievo-fuzz" {
            let message = "lacks [lints] workspace = true";
            findings.push(Finding::error(path, None, message));
        }
    }
    findings
}

/// The few facts of a Cargo.toml that the rule needs.
struct Manifest {
    name: String,
    /// Line and package name; dependencies of every kind.
    dependencies: Vec<(usize, String)>,
    takes_workspace_lints: bool,
}

impl Manifest {
    /// Reads the tables line by line, as Cargo.toml files are written: one key a line.
    fn new(text: &str) -> Self {
        let mut manifest =
            Self { name: String::new(), dependencies: Vec::new(), takes_workspace_lints: false };
        let mut table = String::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if let Some(header) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                table = header.to_owned();
                // [dependencies.name]
                if let Some((kind, name)) = table.rsplit_once('.')
                    && is_dependencies(kind)
                {
                    manifest.dependencies.push((index + 1, name.to_owned()));
                }
                continue;
            }
            let Some((key, value)) = line.split_once('=') else {
                continue;
            };
            let (key, value) = (key.trim(), value.trim());
            let first = key.split('.').next().unwrap_or(key).trim_matches('"');
            if table == "package" && key == "name" {
                manifest.name = value.trim_matches('"').to_owned();
            } else if is_dependencies(&table) {
                manifest.dependencies.push((index + 1, first.to_owned()));
            } else if table == "lints" && key == "workspace" && value == "true" {
                manifest.takes_workspace_lints = true;
            }
        }
        manifest
    }
}

/// `dependencies`, `dev-dependencies`, `build-dependencies`, for any target.
fn is_dependencies(table: &str) -> bool {
    let last = table.rsplit('.').next().unwrap_or(table);
    matches!(last, "dependencies" | "dev-dependencies" | "build-dependencies")
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINTS: &str = "\n[lints]\nworkspace = true\n";

    fn found(path: &str, text: &str) -> Vec<String> {
        let tree = Tree::of(&[(path, text)]);
        check(&tree).into_iter().map(|f| f.message).collect()
    }

    #[test]
    fn downward_edges_pass() {
        let text = "[package]\nname = \"rilievo-io\"\n[dependencies]\nrilievo.workspace = true\n\
                    glam = \"1\"\n[dev-dependencies]\nrilievo-render = { path = \"x\" }\n"
            .to_owned()
            + LINTS;
        assert_eq!(found("crates/rilievo-io/Cargo.toml", &text), [""; 0]);
    }

    #[test]
    fn upward_edges_of_every_spelling_are_found() {
        for dependency in [
            "[dependencies]\nrilievo-io.workspace = true",
            "[dev-dependencies]\nrilievo-io = { path = \"../rilievo-io\" }",
            "[target.'cfg(unix)'.dependencies]\nrilievo-io = \"1\"",
            "[dependencies.rilievo-io]\npath = \"../rilievo-io\"",
        ] {
            let text = format!("[package]\nname = \"rilievo\"\n{dependency}\n{LINTS}");
            assert_eq!(
                found("crates/rilievo/Cargo.toml", &text),
                ["rilievo may not depend on rilievo-io"],
                "{dependency}"
            );
        }
    }

    #[test]
    fn strangers_and_missing_lints_are_found() {
        let stranger = "[package]\nname = \"rilievo-extra\"\n";
        assert_eq!(
            found("crates/extra/Cargo.toml", stranger),
            ["package \"rilievo-extra\" has no place in the crate graph"]
        );
        let lax = "[package]\nname = \"xtask\"\n";
        assert_eq!(found("xtask/Cargo.toml", lax), ["lacks [lints] workspace = true"]);
    }
}
