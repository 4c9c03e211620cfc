//! The tables of docs/SCENE.md.

use super::{SECTIONS, Section};

impl Section {
    /// The section as a table of Markdown.
    fn markdown(&self) -> String {
        let table = match self.table {
            "" => String::new(),
            table => format!(" of `{table}`"),
        };
        let mut text = format!(
            "| key{table} | type | unit | default | allowed | meaning |\n\
             |---|---|---|---|---|---|\n"
        );
        for key in self.keys {
            text += &format!("| `{}` |", key.name());
            for cell in key.cells() {
                text += &format!("{}{cell} |", if cell.is_empty() { "" } else { " " });
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
    use super::*;

    const PAGE: &str = include_str!("../../../../../docs/SCENE.md");

    #[test]
    fn the_page_is_what_is_said_here() {
        let page = reference(PAGE).expect("docs/SCENE.md has each section once");
        assert!(page == PAGE, "docs/SCENE.md is not current: cargo xtask reference");
    }

    #[test]
    fn a_page_without_a_section_or_with_another_is_refused() {
        assert_eq!(reference("nothing"), None);
        assert_eq!(reference(&format!("{PAGE}\n<!-- keys: camera -->\n")), None);
        assert_eq!(reference(&PAGE.replace("keys: camera", "keys: cameras")), None);
    }
}
