//! `cargo xtask figures [--quick] [PART...]`: every picture and measured table under `docs`.
//!
//! Everything but the part `gpu` is asked of the released program, as a user would ask it; nothing here links the
//! libraries. Pictures go to `docs/figures`. Tables go between the marks
//! `<!-- figures:NAME -->` and `<!-- /figures:NAME -->` of pages that are otherwise written by hand.
//! What is needed on the way lies in `target/figures`.
//!
//! `--quick` draws everything small, leaves it all in `target/figures` and prints the tables: it
//! shows that the machinery works and changes nothing under `docs`.
//!
//! Times are processor times, all threads together: a clock on the wall says little on a machine
//! that others use too.

mod distance_times;
mod gallery;
mod gpu;
mod heights;
mod large_map;
mod page;
mod paper;
mod program;
mod steps;
mod table;

use std::path::{Path, PathBuf};

use crate::say;
use program::Program;

/// What a part needs to draw and write.
struct Studio<'a> {
    root: &'a Path,
    program: Program,
    quick: bool,
}

/// A group of figures and the tables that belong to it.
struct Part {
    name: &'static str,
    draw: fn(&Studio<'_>) -> Result<(), String>,
}

const PARTS: &[Part] = &[
    Part { name: "paper", draw: paper::draw },
    Part { name: "steps", draw: steps::draw },
    Part { name: "gallery", draw: gallery::draw },
    Part { name: "distance-times", draw: distance_times::draw },
    Part { name: "large-map", draw: large_map::draw },
    Part { name: "gpu", draw: gpu::draw },
];

/// Draws the parts named in `words`, or all; says whether all went well.
///
/// # Errors
/// A word that is neither `--quick` nor a part.
pub fn run(root: &Path, words: &[&str]) -> Result<bool, String> {
    let (flags, names): (Vec<&str>, Vec<&str>) =
        words.iter().copied().partition(|w| w.starts_with('-'));
    if let Some(flag) = flags.iter().find(|&&flag| flag != "--quick") {
        return Err(format!("unknown flag {flag}"));
    }
    if let Some(name) = names.iter().find(|&name| PARTS.iter().all(|part| part.name != *name)) {
        let known: Vec<_> = PARTS.iter().map(|part| part.name).collect();
        return Err(format!("unknown part {name}; there are {}", known.join(", ")));
    }
    let chosen = PARTS.iter().filter(|part| names.is_empty() || names.contains(&part.name));
    let drawn = Program::build(root).and_then(|program| {
        let studio = Studio { root, program, quick: !flags.is_empty() };
        studio.prepare()?;
        chosen.into_iter().try_for_each(|part| (part.draw)(&studio))
    });
    if let Err(why) = &drawn {
        say(&format!("figures: {why}"));
    }
    Ok(drawn.is_ok())
}

impl Studio<'_> {
    /// Makes the folders and draws nothing yet.
    fn prepare(&self) -> Result<(), String> {
        for folder in [self.scratch(""), self.picture("")] {
            let told = |e| format!("{}: {e}", folder.display());
            std::fs::create_dir_all(&folder).map_err(told)?;
        }
        Ok(())
    }

    /// A file that nobody keeps.
    fn scratch(&self, name: &str) -> PathBuf {
        self.root.join("target/figures").join(name)
    }

    /// A picture of the documentation.
    fn picture(&self, name: &str) -> PathBuf {
        if self.quick { self.scratch(name) } else { self.root.join("docs/figures").join(name) }
    }

    fn scene(&self, name: &str) -> PathBuf {
        self.root.join("scenes").join(name).join("scene.toml")
    }

    /// Puts `body` between the marks `name` of the page `page`, under the date of today.
    fn write(&self, page: &str, name: &str, body: &str) -> Result<(), String> {
        say(&format!("{name}:\n{body}"));
        if self.quick {
            return Ok(());
        }
        let path = self.root.join(page);
        let told = |e: &dyn std::fmt::Display| format!("{page}: {e}");
        let text = std::fs::read_to_string(&path).map_err(|e| told(&e))?;
        let body = format!("Measured {}.\n\n{body}", page::today());
        let text = page::replace(&text, name, &body).map_err(|e| told(&e))?;
        std::fs::write(&path, text).map_err(|e| told(&e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_words_are_refused_before_anything_is_built() {
        let nowhere = Path::new("no-such-folder");
        assert!(run(nowhere, &["--fast"]).is_err_and(|why| why.contains("--fast")));
        assert!(
            run(nowhere, &["--quick", "papers"]).is_err_and(|why| why.contains("paper, steps"))
        );
    }
}
