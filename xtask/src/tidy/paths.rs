//! Rule: no committed text names a place on somebody's machine.

use super::Finding;
use super::tree::{File, Tree};

/// Written in two parts each, or this file would break its own rule.
const ROOTS: &[[&str; 2]] = &[
    ["/ho", "me/"],
    ["/ro", "ot/"],
    ["/Us", "ers/"],
    ["/wo", "rk/"],
    ["/tm", "p/"],
    ["/mn", "t/"],
    ["C:\\", "Users"],
];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let roots: Vec<String> = ROOTS.iter().map(|parts| parts.concat()).collect();
    let mut findings = Vec::new();
    for file in tree.files().iter().filter(|file| !is_foreign(file)) {
        for (index, line) in file.text.iter().flat_map(|text| text.lines()).enumerate() {
            if let Some(root) = roots.iter().find(|root| begins_path(line, root)) {
                let message = format!("names a place on one machine ({root}...)");
                findings.push(Finding::error(&file.path, Some(index + 1), message));
            }
        }
    }
    findings
}

/// Licences and maps are other people's text and stay as they were.
fn is_foreign(file: &File) -> bool {
    ["LICENSE", "COPYING"].iter().any(|name| file.name().starts_with(name))
        || super::origins::is_data(file)
}

/// Whether a path in `line` begins with `root`; `https://example.org/home/` does not.
fn begins_path(line: &str, root: &str) -> bool {
    line.match_indices(root).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || "._-~/}".contains(c))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_a_machine_are_found_and_addresses_are_not() {
        let root = ROOTS[0].concat();
        let bad = format!("see {root}someone/map.png\n\"{root}x\"");
        let good = format!("https://example.org{root}x and a{root}b");
        let tree = Tree::of(&[
            ("a.md", &bad),
            ("b.md", &good),
            ("maps/LICENSE", &bad),
            ("maps/c.obj", &bad),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| (f.path, f.line)).collect();
        assert_eq!(found, [("a.md".to_owned(), Some(1)), ("a.md".to_owned(), Some(2))]);
    }
}
