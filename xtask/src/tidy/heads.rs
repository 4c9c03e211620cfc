//! Rule: every Rust file opens with a module doc that says what it is.

use super::Finding;
use super::tree::Tree;

pub fn check(tree: &Tree) -> Vec<Finding> {
    tree.texts("rs")
        .filter(|(_, text)| !opens_with_doc(text))
        .map(|(path, _)| Finding::error(path, Some(1), "no module doc (//!) at the head"))
        .collect()
}

/// Inner attributes may stand before the doc: fuzz targets begin with `#![no_main]`.
fn opens_with_doc(text: &str) -> bool {
    text.lines()
        .map(str::trim)
        .find(|line| !line.is_empty() && !line.starts_with("#!["))
        .is_some_and(|line| line.starts_with("//!") && line.len() > "//!".len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_head_is_found() {
        let tree = Tree::of(&[
            ("a.rs", "//! What it is.\n"),
            ("b.rs", "#![no_main]\n\n//! What it is.\n"),
            ("c.rs", "use std::fmt;\n//! Too late.\n"),
            ("d.rs", "//!\n"),
            ("e.rs", ""),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| f.path).collect();
        assert_eq!(found, ["c.rs", "d.rs", "e.rs"]);
    }
}
