//! [`Tree`]: the files that belong to the repository.

use std::io;
use std::path::Path;
use std::process::Command;

/// One file of the repository.
pub struct File {
    /// Path from the repository root, with `/` between its parts.
    pub path: String,
    /// Size in bytes.
    pub bytes: u64,
    /// Contents, if they are UTF-8.
    pub text: Option<String>,
}

impl File {
    /// The part of the path after the last `/`.
    pub fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or(&self.path)
    }

    /// The part of the name after the last dot, or nothing.
    pub fn extension(&self) -> &str {
        self.name().rsplit_once('.').map_or("", |(_, end)| end)
    }

    /// The part of the path before the last `/`; empty for a file of the root.
    pub fn folder(&self) -> &str {
        folder_of(&self.path)
    }
}

/// The part of `path` before its last `/`, or nothing.
pub fn folder_of(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// All files that git tracks, or would track: ignored files are no part of it.
pub struct Tree {
    files: Vec<File>,
}

impl Tree {
    /// Reads the repository at `root`.
    ///
    /// # Errors
    /// When git cannot be asked, or a file cannot be read.
    pub fn read(root: &Path) -> io::Result<Self> {
        let output = Command::new("git")
            .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
            .current_dir(root)
            .output()?;
        if !output.status.success() {
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(io::Error::other(message));
        }
        let listed = String::from_utf8_lossy(&output.stdout).into_owned();
        let mut files = Vec::new();
        for path in listed.split('\0').filter(|path| !path.is_empty()) {
            // A file that is tracked but deleted in the working tree is gone for us too.
            let contents = match std::fs::read(root.join(path)) {
                Ok(contents) => contents,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(error),
            };
            files.push(File {
                path: path.to_owned(),
                bytes: contents.len() as u64,
                text: String::from_utf8(contents).ok(),
            });
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        files.dedup_by(|a, b| a.path == b.path);
        Ok(Self { files })
    }

    /// A tree of text files held in memory.
    #[cfg(test)]
    pub fn of(files: &[(&str, &str)]) -> Self {
        let files = files
            .iter()
            .map(|(path, text)| File {
                path: (*path).to_owned(),
                bytes: text.len() as u64,
                text: Some((*text).to_owned()),
            })
            .collect();
        Self { files }
    }

    /// All files, by path.
    pub fn files(&self) -> &[File] {
        &self.files
    }

    /// Path and text of every text file whose name ends in `.extension`.
    pub fn texts(&self, extension: &str) -> impl Iterator<Item = (&str, &str)> {
        self.files
            .iter()
            .filter(move |file| file.extension() == extension)
            .filter_map(|file| Some((file.path.as_str(), file.text.as_deref()?)))
    }

    /// The text of one file.
    pub fn text(&self, path: &str) -> Option<&str> {
        self.files.iter().find(|file| file.path == path).and_then(|file| file.text.as_deref())
    }

    /// Whether `path` is a file or a folder of the tree.
    pub fn holds(&self, path: &str) -> bool {
        let path = path.trim_end_matches('/');
        path.is_empty()
            || self.files.iter().any(|file| {
                file.path
                    .strip_prefix(path)
                    .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_path() {
        let tree = Tree::of(&[("a/b.c/d.rs", ""), ("Makefile", "")]);
        let [deep, root] = tree.files() else { panic!() };
        assert_eq!((deep.name(), deep.extension(), deep.folder()), ("d.rs", "rs", "a/b.c"));
        assert_eq!((root.name(), root.extension(), root.folder()), ("Makefile", "", ""));
    }

    #[test]
    fn holds_files_and_folders_but_no_prefixes_of_names() {
        let tree = Tree::of(&[("a/b/c.rs", "")]);
        for path in ["a", "a/", "a/b", "a/b/c.rs", ""] {
            assert!(tree.holds(path), "{path}");
        }
        for path in ["b", "a/b/c", "a/b/c.rs.bak"] {
            assert!(!tree.holds(path), "{path}");
        }
    }

    #[test]
    fn reads_this_repository() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let tree = Tree::read(root).unwrap();
        assert!(tree.text("xtask/src/tidy/tree.rs").is_some());
        assert!(!tree.holds("target"));
    }
}
