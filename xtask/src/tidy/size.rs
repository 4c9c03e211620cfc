//! Rule: Rust files are short, and no committed file is large.
//!
//! A reader holds about 200 lines in mind; 400 is questioned, 800 refused. Files above 4 MiB make
//! every clone pay for them for ever.

use super::Finding;
use super::tree::Tree;

const QUESTIONED_LINES: usize = 400;
const MOST_LINES: usize = 800;
const MOST_BYTES: u64 = 4 << 20;

pub fn check(tree: &Tree) -> Vec<Finding> {
    let lines = tree.texts("rs").filter_map(|(path, text)| {
        let lines = text.lines().count();
        if lines > MOST_LINES {
            let message = format!("{lines} lines; at most {MOST_LINES} are allowed");
            Some(Finding::error(path, None, message))
        } else if lines > QUESTIONED_LINES {
            let message = format!("{lines} lines; above {QUESTIONED_LINES}, is it one thing?");
            Some(Finding::warning(path, None, message))
        } else {
            None
        }
    });
    let bytes = tree.files().iter().filter(|file| file.bytes > MOST_BYTES);
    let bytes = bytes.map(|file| {
        let message = format!("{} bytes; at most {MOST_BYTES} are allowed", file.bytes);
        Finding::error(&file.path, None, message)
    });
    lines.chain(bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Level;
    use super::*;

    #[test]
    fn lines_are_questioned_then_refused() {
        let text = |lines| "\n".repeat(lines);
        let (fine, long, too_long) = (text(400), text(401), text(801));
        let tree = Tree::of(&[("a.rs", &fine), ("b.rs", &long), ("c.rs", &too_long)]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| (f.path, f.level)).collect();
        assert_eq!(found, [("b.rs".to_owned(), Level::Warning), ("c.rs".to_owned(), Level::Error)]);
    }

    #[test]
    fn large_files_are_refused() {
        let (most, more) = ("x".repeat(4 << 20), "x".repeat((4 << 20) + 1));
        let tree = Tree::of(&[("a.exr", &most), ("b.exr", &more)]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| f.path).collect();
        assert_eq!(found, ["b.exr"]);
    }
}
