//! Rule: no module is named for holding whatever fits nowhere else.

use super::Finding;
use super::tree::Tree;

const FORBIDDEN: &[&str] =
    &["common", "helper", "helpers", "misc", "shared", "stuff", "util", "utils"];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, _) in tree.texts("rs") {
        let stem = path.strip_suffix(".rs").unwrap_or(path);
        if let Some(name) = stem.split('/').find(|part| FORBIDDEN.contains(part)) {
            let message = format!("module name \"{name}\" says nothing; name what it holds");
            findings.push(Finding::error(path, None, message));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_folders_are_judged_by_their_whole_name() {
        let tree = Tree::of(&[
            ("src/utils.rs", ""),
            ("tests/common/mod.rs", ""),
            ("src/utilisation.rs", ""),
            ("docs/misc.md", ""),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| f.path).collect();
        assert_eq!(found, ["src/utils.rs", "tests/common/mod.rs"]);
    }
}
