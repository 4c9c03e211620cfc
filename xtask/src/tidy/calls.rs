//! Rule: who may read files, keep a clock, print or exit, and what nobody may write.
//!
//! Looks at code only, never at comments or strings. Unit tests are free of the bans on calls, not
//! of the bans on attributes. Examples may print.

use super::Finding;
use super::source::Source;
use super::tree::Tree;

/// Words of code that files under some folders may not hold.
struct Ban {
    words: &'static [&'static str],
    folders: &'static [&'static str],
    /// Whether `#[cfg(test)]` modules are judged too.
    tests_too: bool,
    message: &'static str,
}

const CORE: &str = "crates/rilievo/src/";
const RENDER: &str = "crates/rilievo-render/src/";
const IO: &str = "crates/rilievo-io/src/";
const GPU: &str = "crates/rilievo-gpu/src/";

const BANS: &[Ban] = &[
    Ban {
        words: &["std::fs", "fs::", "File::", "OpenOptions", "std::net"],
        folders: &[CORE, RENDER, GPU],
        tests_too: false,
        message: "reads files; only rilievo-io may",
    },
    Ban {
        words: &["Instant", "SystemTime"],
        folders: &[CORE, RENDER],
        tests_too: false,
        message: "keeps a clock; only programs may",
    },
    Ban {
        words: &["print!", "println!", "eprint!", "eprintln!", "dbg!", "stdout()", "stderr()"],
        folders: &[CORE, RENDER, IO, GPU],
        tests_too: false,
        message: "prints; only programs may",
    },
    Ban {
        words: &["process::exit", "process::abort"],
        folders: &[CORE, RENDER, IO, GPU],
        tests_too: false,
        message: "ends the process; only programs may",
    },
    Ban {
        words: &["#[allow(", "#![allow(", "#[expect(", "#![expect("],
        folders: &[""],
        tests_too: true,
        message: "silences a lint; mend the cause",
    },
    Ban {
        words: &["#[ignore]", "#[ignore ="],
        folders: &[""],
        tests_too: true,
        message: "switches a test off; a test runs or is deleted",
    },
    Ban {
        words: &["unsafe {", "unsafe fn", "unsafe impl", "unsafe extern", "unsafe trait"],
        folders: &[""],
        tests_too: true,
        message: "is unsafe; only the kernel's SIMD levels and the bench's peer bindings may be",
    },
];

/// Where unsafe code may stand: modules that hold little else.
const UNSAFE_HOMES: &[&str] = &["crates/rilievo/src/simd", "bench/src/embree"];

pub fn check(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (path, text) in tree.texts("rs") {
        let source = Source::new(text);
        let shipped = source.shipped_code();
        for ban in BANS {
            if !ban.folders.iter().any(|folder| path.starts_with(folder)) {
                continue;
            }
            let code = if ban.tests_too { &source.code } else { &shipped };
            for (index, line) in code.lines().enumerate() {
                let found = ban.words.iter().find(|word| holds_word(line, word));
                if let Some(word) = found.filter(|word| {
                    !is_printing_example(path, line) && !is_unsafe_at_home(path, line, word)
                }) {
                    let message = format!("`{word}` {}", ban.message);
                    findings.push(Finding::error(path, Some(index + 1), message));
                }
            }
        }
    }
    findings
}

/// Examples are programs that show how a caller writes: they print, and say that they do.
fn is_printing_example(path: &str, line: &str) -> bool {
    path.contains("/examples/") && line.starts_with("#![expect(clippy::print_stdout")
}

/// Unsafe code in a module that may hold it, and the one lint that such a module switches off.
fn is_unsafe_at_home(path: &str, line: &str, word: &str) -> bool {
    let at_home = UNSAFE_HOMES.iter().any(|home| {
        path.strip_prefix(home).is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
    });
    let line = line.trim_start();
    let attribute = line.strip_prefix("#![").or_else(|| line.strip_prefix("#["));
    let switch = attribute.is_some_and(|rest| {
        ["expect(unsafe_code", "allow(unsafe_code"].iter().any(|lint| rest.starts_with(lint))
    });
    at_home && (word.starts_with("unsafe ") || switch)
}

/// Whether `word` stands in `line` and is not the tail of a longer identifier.
fn holds_word(line: &str, word: &str) -> bool {
    line.match_indices(word).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let after = line[at + word.len()..].chars().next();
        let begins_inside = before.is_some_and(is_identifier);
        let ends_inside = word.ends_with(is_identifier) && after.is_some_and(is_identifier);
        !begins_inside && !ends_inside
    })
}

fn is_identifier(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, text: &str) -> Vec<(Option<usize>, String)> {
        let tree = Tree::of(&[(path, text)]);
        let findings = check(&tree).into_iter();
        findings.map(|f| (f.line, f.message)).collect()
    }

    #[test]
    fn only_io_reads_files() {
        let text = "\nuse std::fs::File;\nfn f() { File::open(p); }";
        let core = found("crates/rilievo/src/a.rs", text);
        assert_eq!(core.len(), 2, "{core:?}");
        assert_eq!(core[0].0, Some(2));
        assert_eq!(found("crates/rilievo-render/src/a.rs", text).len(), 2);
        assert_eq!(found("crates/rilievo-io/src/a.rs", text), []);
    }

    #[test]
    fn only_programs_print_and_exit() {
        let text = "fn f() { println!(); std::process::exit(1) }";
        for library in ["rilievo", "rilievo-render", "rilievo-io"] {
            let path = format!("crates/{library}/src/a.rs");
            assert_eq!(found(&path, text).len(), 2, "{library}");
        }
        assert_eq!(found("crates/rilievo-cli/src/a.rs", text), []);
    }

    #[test]
    fn words_in_comments_strings_tests_and_longer_names_pass() {
        let text = "// println!\nfn f() -> &'static str { \"std::fs\" }\nstruct MapFile;\n\
                    impl MapFile { fn g() { MapFile::g() } }\nstruct Instantaneous;\n\
                    #[cfg(test)]\nmod tests { fn t() { eprintln!(); } }";
        assert_eq!(found("crates/rilievo/src/a.rs", text), []);
    }

    #[test]
    fn neither_core_nor_renderer_keeps_a_clock() {
        let text = "use std::time::Instant;";
        assert_eq!(found("crates/rilievo/src/a.rs", text).len(), 1);
        assert_eq!(found("crates/rilievo-render/src/a.rs", text).len(), 1);
        assert_eq!(found("crates/rilievo-cli/src/a.rs", text), []);
    }

    #[test]
    fn examples_may_print() {
        let text = "#![expect(clippy::print_stdout, reason = \"an example\")]";
        assert_eq!(found("crates/rilievo/examples/a.rs", text), []);
        assert_eq!(found("crates/rilievo/src/a.rs", text).len(), 1);
        let text = "#![expect(dead_code)]";
        assert_eq!(found("crates/rilievo/examples/a.rs", text).len(), 1);
    }

    #[test]
    fn unsafe_code_has_two_homes() {
        let text = "#![expect(unsafe_code, reason = \"x\")]\nfn f() { unsafe { g() } }";
        for path in ["crates/rilievo/src/simd.rs", "crates/rilievo/src/simd/a.rs"] {
            assert_eq!(found(path, text), [], "{path}");
        }
        assert_eq!(found("bench/src/embree/scene.rs", text), []);
        for path in ["crates/rilievo/src/a.rs", "crates/rilievo/src/simdy.rs", "bench/src/a.rs"] {
            assert_eq!(found(path, text).len(), 2, "{path}");
        }
        assert_eq!(found("bench/src/embree/scene.rs", "#![expect(dead_code)]").len(), 1);
    }

    #[test]
    fn nobody_silences_lints_or_tests() {
        let text =
            "#[allow(dead_code)]\nfn f() {}\n#[cfg(test)]\nmod tests {\n#[ignore]\nfn t() {}\n}";
        let found = found("xtask/src/a.rs", text);
        assert_eq!(found.iter().map(|f| f.0).collect::<Vec<_>>(), [Some(1), Some(5)]);
    }
}
