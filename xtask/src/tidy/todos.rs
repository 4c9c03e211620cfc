//! Rule: a note about work to do names its issue, or it is lost.

use super::Finding;
use super::source::Source;
use super::tree::Tree;

const MARKS: &[&str] = &["TODO", "FIXME", "XXX", "HACK"];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts("rs") {
        for (index, line) in Source::new(text).comments.lines().enumerate() {
            findings.extend(judge(path, index, line));
        }
    }
    for (path, text) in tree.texts("toml") {
        for (index, line) in text.lines().enumerate() {
            if let Some((_, comment)) = line.split_once('#') {
                findings.extend(judge(path, index, comment));
            }
        }
    }
    findings
}

fn judge(path: &str, index: usize, comment: &str) -> Option<Finding> {
    let words = |c: char| !c.is_alphanumeric() && c != '#';
    let mark = comment.split(words).find(|word| MARKS.contains(word))?;
    let names_issue = comment.split(words).any(|word| {
        word.strip_prefix('#')
            .is_some_and(|n| !n.is_empty() && n.chars().all(|c| c.is_ascii_digit()))
    });
    let message = format!("{mark} without an issue number (#12)");
    (!names_issue).then(|| Finding::error(path, Some(index + 1), message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_need_an_issue() {
        let tree = Tree::of(&[
            ("a.rs", "// TODO: mend\n// TODO(#12): mend\n/* FIXME */ let s = \"TODO\";"),
            ("b.toml", "key = 1 # XXX why\n# HACK #3"),
            ("c.rs", "// todos.rs and TODOS are other words"),
        ]);
        let found: Vec<_> = check(&tree).into_iter().map(|f| (f.path, f.line.unwrap())).collect();
        let expected = [("a.rs", 1), ("a.rs", 3), ("b.toml", 1)];
        assert_eq!(found, expected.map(|(path, line)| (path.to_owned(), line)));
    }
}
