//! The gallery on this system's GPU, beside the CPU and beside the judge of the tests.
//!
//! The one part that is not asked of the program: the judge is no part of that. The example `gallery` of `rilievo-gpu`
//! measures, and says of which adapter.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::Studio;

/// Maps, in a folder beside the scenes.
const MAPS: &str = "maps";

const PAGE: &str = "docs/METHODS.md";

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let pixels = if studio.quick { "8" } else { "48" };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let example = ["run", "--release", "--locked", "--quiet", "-p", "rilievo-gpu"];
    let output = Command::new(cargo)
        .args(example)
        .args(["--example", "gallery", "--", pixels])
        .args(scenes(&studio.root.join("scenes"))?)
        .current_dir(studio.root)
        .stderr(std::process::Stdio::inherit())
        .output()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let [adapter, hits, pictures] = parts(&text)?;
    let told = |table: &str| format!("Adapter: {adapter}; {pixels} x {pixels} pixels.\n\n{table}");
    studio.write(PAGE, "gpu-hits", &told(hits))?;
    studio.write(PAGE, "gpu-pictures", &told(pictures))?;
    match output.status.success() {
        true => Ok(()),
        false => Err("the GPU gives wrong answers, see above".to_owned()),
    }
}

/// The folders of all scenes, by name.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let told = |e| format!("{}: {e}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(told)?.flatten().map(|entry| entry.path());
    let mut scenes: Vec<_> =
        entries.filter(|path| path.is_dir() && !path.ends_with(MAPS)).collect();
    scenes.sort();
    Ok(scenes)
}

/// What the example wrote: the adapter's name and two tables.
fn parts(text: &str) -> Result<[&str; 3], String> {
    let parts: Vec<&str> = text.trim_end().split("\n\n").collect();
    parts.try_into().map_err(|_| "the example gallery measured nothing".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_stand_between_empty_lines() {
        let told = parts("llvmpipe (Vulkan)\n\n| a |\n| --- |\n\n| b |\n| --- |\n");
        assert_eq!(told, Ok(["llvmpipe (Vulkan)", "| a |\n| --- |", "| b |\n| --- |"]));
        assert!(parts("").is_err());
    }

    #[test]
    fn every_folder_but_that_of_the_maps_is_a_scene() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
        let scenes = scenes(&folder).unwrap();
        assert!(scenes.len() >= 22 && scenes.iter().all(|path| path.join("scene.toml").exists()));
    }
}
