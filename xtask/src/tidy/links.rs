//! Rule: what Markdown points at exists.
//!
//! Judged are relative links, with their `#heading`, and paths in `code` that begin with a folder
//! of the repository's root. Addresses with a scheme are not followed.

use super::Finding;
use super::tree::{Tree, folder_of};

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts("md") {
        for (index, line) in outside_fences(text) {
            let (prose, codes) = part_code(line);
            for target in targets(&prose) {
                if let Some(message) = judge_link(tree, path, target) {
                    findings.push(Finding::error(path, Some(index + 1), message));
                }
            }
            // The log speaks of what was, origins of other repositories.
            let elsewhere = path == "CHANGELOG.md" || path.ends_with("ORIGIN.md");
            let paths = codes.iter().filter(|_| !elsewhere);
            for code in paths.filter(|code| names_missing_path(tree, code)) {
                let message = format!("`{code}` does not exist");
                findings.push(Finding::error(path, Some(index + 1), message));
            }
        }
    }
    findings
}

/// Lines with their index, without fenced code blocks.
fn outside_fences(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        if fence {
            fenced = !fenced;
        }
        !fence && !fenced
    })
}

/// The line without its `code`, and the code.
fn part_code(line: &str) -> (String, Vec<&str>) {
    let parts: Vec<&str> = line.split('`').collect();
    let prose: Vec<&str> = parts.iter().copied().step_by(2).collect();
    let codes = parts.iter().copied().skip(1).step_by(2).collect();
    (prose.join("``"), codes)
}

/// Targets of `[text](target)` and `[text](target "title")`.
fn targets(prose: &str) -> impl Iterator<Item = &str> {
    prose.match_indices("](").filter_map(|(at, open)| {
        let (inside, _) = prose[at + open.len()..].split_once(')')?;
        inside.split_whitespace().next()
    })
}

fn judge_link(tree: &Tree, from: &str, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, heading) = match target.split_once('#') {
        Some((file, heading)) => (file, Some(heading)),
        None => (target, None),
    };
    let file = if file.is_empty() {
        from.to_owned()
    } else {
        match resolve(folder_of(from), file) {
            Some(file) => file,
            None => return Some(format!("link {target} leaves the repository")),
        }
    };
    if !tree.holds(&file) {
        return Some(format!("link {target} points at nothing"));
    }
    let text = tree.text(&file)?;
    let heading = heading?;
    let exists = outside_fences(text)
        .filter(|(_, line)| line.starts_with('#'))
        .any(|(_, line)| slug(line) == heading);
    (!exists).then(|| format!("link {target} names no heading of {file}"))
}

/// `relative`, seen from `folder`, as a path from the root.
fn resolve(folder: &str, relative: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in relative.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// A heading as its anchor: small letters, digits and hyphens.
fn slug(heading: &str) -> String {
    let heading = heading.trim_start_matches('#').trim().to_lowercase();
    heading
        .chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        })
        .collect()
}

/// Whether `code` is a path from the root, plainly written, that is not there.
fn names_missing_path(tree: &Tree, code: &str) -> bool {
    let Some((first, _)) = code.split_once('/') else {
        return false;
    };
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let in_root = tree
        .files()
        .iter()
        .any(|file| file.path.split_once('/').is_some_and(|(root, _)| root == first));
    in_root && code.chars().all(plain) && !tree.holds(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let tree = Tree::of(&[
            ("docs/A.md", text),
            ("docs/B.md", "# One, two\n```\n# Not a heading\n```\n"),
            ("README.md", ""),
            ("crates/a/src/lib.rs", ""),
            ("docs/maps/ORIGIN.md", "From `crates/elsewhere`."),
        ]);
        check(&tree).into_iter().map(|f| f.message).collect()
    }

    #[test]
    fn good_links_pass() {
        let text = "[a](B.md) [b](../README.md \"title\") [c](https://x.org/y) ![d](../crates/a)\n\
                    # Here\n[e](#here) [f](B.md#one-two)\n`[g](nowhere)`\n```\n[h](nowhere)\n```\n";
        assert_eq!(found(text), [""; 0]);
    }

    #[test]
    fn bad_links_are_found() {
        for (text, part) in [
            ("[a](C.md)", "points at nothing"),
            ("[a](../../x.md)", "leaves the repository"),
            ("[a](#there)", "names no heading"),
            ("[a](B.md#not-a-heading)", "names no heading"),
        ] {
            let found = found(text);
            assert!(found.len() == 1 && found[0].contains(part), "{text}: {found:?}");
        }
    }

    #[test]
    fn paths_in_code_exist_or_are_patterns() {
        let fine = "`crates/a/src/lib.rs` `crates/a/` `crates/*/src` `out/x.png` `a/b`";
        assert_eq!(found(fine), [""; 0]);
        assert_eq!(found("`crates/b`"), ["`crates/b` does not exist"]);
    }
}
