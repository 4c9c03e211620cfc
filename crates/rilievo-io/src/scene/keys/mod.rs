//! Every key of a scene file, told once: the tables of docs/SCENE.md.
//!
//! docs/SCENE.md holds the tables after lines `<!-- keys: SECTION -->`; `cargo xtask reference` writes
//! them there. Tests hold that the page is what is said here, and that what is said here is what the
//! parser asks for: no key more, none less.

mod tables;

use std::fmt::Write;

pub use tables::SECTIONS;

/// A key of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What kind of value it takes.
    pub kind: &'static str,
    /// Unit, or what is meant.
    pub unit: &'static str,
    /// What holds without it.
    pub default: &'static str,
    /// Values allowed.
    pub allowed: &'static str,
}

/// Keys that are told together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name in docs/SCENE.md.
    pub name: &'static str,
    /// The table of a scene file that they stand in: `NAME` for a name of the author's, `[]` for a
    /// place in an array.
    pub table: &'static str,
    /// The keys.
    pub keys: &'static [Key],
}

const fn key(
    name: &'static str,
    kind: &'static str,
    unit: &'static str,
    default: &'static str,
    allowed: &'static str,
) -> Key {
    Key { name, kind, unit, default, allowed }
}

impl Section {
    /// The section as a table of Markdown.
    fn markdown(&self) -> String {
        let mut text =
            "| key | type | unit | default | allowed |\n|---|---|---|---|---|\n".to_owned();
        for Key { name, kind, unit, default, allowed } in self.keys {
            // Writing to a string does not fail.
            let _ = write!(text, "| `{name}` |");
            for cell in [kind, unit, default, allowed] {
                let _ = write!(text, "{}{cell} |", if cell.is_empty() { "" } else { " " });
            }
            text.push('\n');
        }
        text
    }
}

/// A page of Markdown with the table after each line `<!-- keys: SECTION -->` made anew. `None` if
/// the page names a section that is not there, or not each section once.
pub fn reference(page: &str) -> Option<String> {
    let (mut text, mut told) = (String::new(), 0);
    let mut lines = page.lines().peekable();
    while let Some(line) = lines.next() {
        text.push_str(line);
        text.push('\n');
        let marker = line.strip_prefix("<!-- keys: ").and_then(|rest| rest.strip_suffix(" -->"));
        if let Some(name) = marker {
            let section = SECTIONS.iter().find(|section| section.name == name)?;
            while lines.next_if(|line| line.starts_with('|')).is_some() {}
            text.push_str(&section.markdown());
            told += 1;
        }
    }
    let once =
        SECTIONS.iter().all(|s| text.matches(&format!("<!-- keys: {} -->", s.name)).count() == 1);
    (once && told == SECTIONS.len()).then_some(text)
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::path::Path;

    use super::super::{SceneFile, asked};
    use super::*;

    /// A shape and a metal that the valid scenes of the tests lack.
    const REST: &str = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n\
        [[shapes]]\ntype = \"terrain\"\nmap = \"ground\"\n\
        [materials.metal]\nmodel = \"conductor\"\neta = [1, 1, 1]\nk = [3, 3, 3]\n";

    const PAGE: &str = include_str!("../../../../../docs/SCENE.md");

    #[test]
    fn the_page_is_what_is_said_here() {
        let page = reference(PAGE).expect("docs/SCENE.md has each section once");
        assert!(page == PAGE, "docs/SCENE.md is not current: cargo xtask reference");
    }

    #[test]
    fn what_is_said_here_is_what_the_parser_asks_for() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/valid");
        asked::start();
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                let text = std::fs::read_to_string(&path).unwrap();
                SceneFile::parse(&text, &path).unwrap();
            }
        }
        SceneFile::parse(REST, Path::new("rest.toml")).unwrap();
        let mut told: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
        for section in SECTIONS {
            let keys = section.keys.iter().map(|key| key.name);
            told.entry(section.table.to_owned()).or_default().extend(keys);
        }
        let asked = asked::finish();
        for (table, keys) in &asked {
            let empty = BTreeSet::new();
            let told = told.get(table).unwrap_or(&empty);
            let missing: Vec<_> = keys.difference(told).collect();
            assert!(missing.is_empty(), "{table:?}: {missing:?} are read, but not in scene/keys");
            let idle: Vec<_> = told.difference(keys).collect();
            assert!(
                idle.is_empty(),
                "{table:?}: {idle:?} are in scene/keys, but no valid test scene has them read"
            );
        }
        let tables: Vec<_> = told.keys().filter(|table| !asked.contains_key(*table)).collect();
        assert!(tables.is_empty(), "{tables:?} are in scene/keys, but in no valid test scene");
    }

    #[test]
    fn a_page_without_a_section_or_with_another_is_refused() {
        assert_eq!(reference("nothing"), None);
        assert_eq!(reference(&format!("{PAGE}\n<!-- keys: camera -->\n")), None);
        assert_eq!(reference(&PAGE.replace("keys: camera", "keys: cameras")), None);
    }
}
