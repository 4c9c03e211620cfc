//! Rule: every paper cited by key stands in `docs/REFERENCES.bib`, once.
//!
//! A key is the first author's name and the year, perhaps with a letter, in square brackets:
//! several keys may stand in one pair, parted by commas, and a place in the paper after them. In a
//! doc comment the brackets are escaped, or rustdoc takes the key for a link. Keys that nothing
//! cites are warned of.

use std::collections::{BTreeMap, BTreeSet};

use super::Finding;
use super::source::Source;
use super::tree::Tree;

const BIBLIOGRAPHY: &str = "docs/REFERENCES.bib";

/// A key where it is cited.
struct Citation {
    line: usize,
    key: String,
    escaped: bool,
}

pub fn check(tree: &Tree) -> Vec<Finding> {
    let (known, mut findings) = bibliography(tree.text(BIBLIOGRAPHY).unwrap_or(""));
    let mut cited = BTreeSet::new();
    let mut judge = |path: &str, citations: Vec<Citation>| {
        for citation in citations {
            if !known.contains_key(&citation.key) {
                let message = format!("{} is not in {BIBLIOGRAPHY}", citation.key);
                findings.push(Finding::error(path, Some(citation.line), message));
            }
            cited.insert(citation.key);
        }
    };
    let mut unescaped = Vec::new();
    for (path, text) in tree.texts("rs") {
        let comments = Source::new(text).comments;
        let citations = citations(&comments);
        for citation in citations.iter().filter(|citation| !citation.escaped) {
            let line = comments.lines().nth(citation.line - 1).unwrap_or("").trim();
            if line.starts_with("///") || line.starts_with("//!") {
                let message =
                    format!("rustdoc takes [{0}] for a link; write \\[{0}\\]", citation.key);
                unescaped.push(Finding::error(path, Some(citation.line), message));
            }
        }
        judge(path, citations);
    }
    for (path, text) in tree.texts("md") {
        judge(path, citations(text));
    }
    findings.extend(unescaped);
    for (key, line) in known.iter().filter(|(key, _)| !cited.contains(*key)) {
        let message = format!("nothing cites {key}");
        findings.push(Finding::warning(BIBLIOGRAPHY, Some(*line), message));
    }
    findings
}

/// Keys and their lines, and what is wrong with them.
fn bibliography(text: &str) -> (BTreeMap<String, usize>, Vec<Finding>) {
    let mut known = BTreeMap::new();
    let mut findings = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let Some((_, rest)) = line.strip_prefix('@').and_then(|l| l.split_once('{')) else {
            continue;
        };
        let key = rest.trim_end().trim_end_matches(',');
        if !is_key(key) {
            let message = format!("\"{key}\" is no key: name and year, as in Whitted1980");
            findings.push(Finding::error(BIBLIOGRAPHY, Some(index + 1), message));
        } else if known.insert(key.to_owned(), index + 1).is_some() {
            let message = format!("{key} stands here twice");
            findings.push(Finding::error(BIBLIOGRAPHY, Some(index + 1), message));
        }
    }
    (known, findings)
}

fn citations(text: &str) -> Vec<Citation> {
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        for (at, _) in line.match_indices('[') {
            let Some((inside, _)) = line[at + 1..].split_once(']') else {
                continue;
            };
            let inside = inside.strip_suffix('\\').unwrap_or(inside);
            let mut words = inside.split([',', ';']).map(str::trim).peekable();
            // After a first key stand more keys, or the place in the paper.
            if words.peek().is_some_and(|word| is_key(word)) {
                found.extend(words.filter(|word| is_key(word)).map(|key| Citation {
                    line: index + 1,
                    key: key.to_owned(),
                    escaped: line[..at].ends_with('\\'),
                }));
            }
        }
    }
    found
}

/// A capital, letters, four digits, perhaps one small letter.
fn is_key(word: &str) -> bool {
    let word = word.strip_suffix(|c: char| c.is_ascii_lowercase()).unwrap_or(word);
    let Some((name, year)) = word.len().checked_sub(4).and_then(|at| word.split_at_checked(at))
    else {
        return false;
    };
    name.len() > 1
        && name.starts_with(|c: char| c.is_ascii_uppercase())
        && name.chars().all(|c| c.is_ascii_alphabetic())
        && year.chars().all(|c| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BIB: &str = "@article{Whitted1980,\n}\n@book{Unused2001a,\n}\n";

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        check(&Tree::of(files)).iter().map(Finding::to_string).collect()
    }

    #[test]
    fn keys_have_a_name_and_a_year() {
        for key in ["Whitted1980", "Thonat2021b", "DupuyBenyoub2023"] {
            assert!(is_key(key), "{key}");
        }
        for word in ["whitted1980", "1980", "Whitted", "Whitted80", "R2D2", "A1980", "é1980", ""] {
            assert!(!is_key(word), "{word}");
        }
    }

    #[test]
    fn unknown_and_unused_keys_are_found() {
        let rust = "//! After \\[Whitted1980\\] and \\[Nobody1999, Whitted1980, section 2\\].";
        assert_eq!(
            found(&[("a.rs", rust), (BIBLIOGRAPHY, BIB)]),
            [
                "error: a.rs:1: Nobody1999 is not in docs/REFERENCES.bib",
                "warning: docs/REFERENCES.bib:3: nothing cites Unused2001a",
            ]
        );
    }

    #[test]
    fn doc_comments_escape_and_other_text_need_not() {
        let rust = "//! [Whitted1980]\n// [Whitted1980]\nlet s = \"[Nobody1999]\";";
        let found = found(&[
            ("a.rs", rust),
            ("b.md", "[Unused2001a] and [`Hit2000`] and [text](x)"),
            (BIBLIOGRAPHY, BIB),
        ]);
        assert_eq!(
            found,
            ["error: a.rs:1: rustdoc takes [Whitted1980] for a link; write \\[Whitted1980\\]"]
        );
    }

    #[test]
    fn the_bibliography_is_judged_too() {
        let bib = "@book{cook84,\n}\n@book{Cook1984,\n}\n@book{Cook1984,\n}\n";
        let found = found(&[("b.md", "[Cook1984]"), (BIBLIOGRAPHY, bib)]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("no key") && found[1].contains("twice"));
    }
}
