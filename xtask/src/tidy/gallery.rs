//! Rule: every folder of the gallery holds a scene and says what must be seen in it.

use std::collections::BTreeSet;

use super::Finding;
use super::tree::Tree;

/// Maps that several scenes use.
const MAPS: &str = "maps";

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for folder in folders(tree) {
        for name in ["scene.toml", "README.md"] {
            let path = format!("scenes/{folder}/{name}");
            if tree.text(&path).is_none_or(str::is_empty) {
                findings.push(Finding::error(&path, None, "missing from the gallery"));
            }
        }
    }
    findings
}

fn folders(tree: &Tree) -> BTreeSet<&str> {
    let inside = tree.files().iter().filter_map(|file| file.path.strip_prefix("scenes/"));
    let folders = inside.filter_map(|path| path.split_once('/').map(|(folder, _)| folder));
    folders.filter(|folder| *folder != MAPS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_without_its_description_is_found() {
        let tree = Tree::of(&[
            ("scenes/a/scene.toml", "x"),
            ("scenes/a/README.md", "x"),
            ("scenes/b/scene.toml", "x"),
            ("scenes/b/README.md", ""),
            ("scenes/c/README.md", "x"),
            ("scenes/maps/d/ORIGIN.md", "x"),
            ("scenes/README.md", "x"),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| f.path).collect();
        assert_eq!(found, ["scenes/b/README.md", "scenes/c/scene.toml"]);
    }
}
