//! Rule: beside every picture, map and mesh stands where it comes from and on what terms.
//!
//! The statement is `ORIGIN.md` or a licence file, in the folder of the data or in one above it,
//! but not as high as the folders of the root. Pictures under `docs/` are our own renderings.

use super::Finding;
use super::tree::{File, Tree, folder_of};

const DATA: &[&str] = &[
    "asc", "bin", "exr", "glb", "gltf", "hdr", "jpeg", "jpg", "npz", "obj", "pfm", "pgm", "ply",
    "png", "ppm", "rmap", "tif", "tiff",
];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for file in tree.files() {
        if !is_data(file) || file.path.starts_with("docs/") || is_explained(tree, file.folder()) {
            continue;
        }
        // One report a folder.
        if findings.last().is_none_or(|last| folder_of(&last.path) != file.folder()) {
            let message = "data without ORIGIN.md or a licence file beside it";
            findings.push(Finding::error(&file.path, None, message));
        }
    }
    findings
}

/// Whether the file is a picture, a map, a mesh or other data, by its ending.
pub fn is_data(file: &File) -> bool {
    DATA.contains(&file.extension().to_ascii_lowercase().as_str())
}

fn is_explained(tree: &Tree, folder: &str) -> bool {
    let mut folder = folder;
    while folder.contains('/') {
        let explains = |file: &File| file.folder() == folder && is_statement(file.name());
        if tree.files().iter().any(explains) {
            return true;
        }
        folder = folder_of(folder);
    }
    false
}

fn is_statement(name: &str) -> bool {
    name == "ORIGIN.md" || name.contains("LICENSE") || name.starts_with("COPYING")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_needs_a_statement_beside_or_above_it() {
        let tree = Tree::of(&[
            ("LICENSE-MIT", ""),
            ("scenes/LICENSE", ""),
            ("scenes/a/map.png", ""),
            ("scenes/a/map2.PNG", ""),
            ("scenes/b/ORIGIN.md", ""),
            ("scenes/b/deep/map.exr", ""),
            ("docs/pictures/relief.png", ""),
            ("scenes/c/scene.toml", ""),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| f.path).collect();
        assert_eq!(found, ["scenes/a/map.png"]);
    }
}
