//! What was typed.

use std::path::PathBuf;

use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use rilievo::relief::Method;
use rilievo_gpu::Backend;

/// Looks at a scene, a height map or a texture set in a window, and edits its relief.
#[derive(Debug, Parser)]
#[command(name = "rilievo-viewer", version, after_help = HELP)]
pub struct Arguments {
    /// Scene file (TOML), the folder of a texture set, a model (OBJ, PLY, glTF, GLB) or a height map.
    pub scene: PathBuf,
    /// Show another scene or map beyond the wipe, seen by the same camera.
    #[arg(long, value_name = "SCENE", conflicts_with = "compare_method")]
    pub compare: Option<PathBuf>,
    /// Show the same scene walked by another method beyond the wipe.
    #[arg(long, value_name = "METHOD", value_parser = method)]
    pub compare_method: Option<Method>,
    /// The model that a bare map is shown on by the preset `mesh`; it needs texture coordinates.
    #[arg(long, value_name = "MODEL")]
    pub mesh: Option<PathBuf>,
    /// What renders: auto takes a GPU where there is one and the CPU otherwise; gpu takes a program in a GPU's place
    /// too.
    #[arg(long, value_name = "BACKEND", value_parser = backend(), default_value = "auto")]
    pub backend: Backend,
    /// Threads; 0 takes one per processor.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Size of the window, as 1280x800.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x800")]
    pub window: [u32; 2],
    /// Tell on standard output what happens and where sliders are, a JSON object a line: for scripts.
    #[arg(long)]
    pub journal: bool,
}

const HELP: &str = "\
Mouse, over the picture:
  left button         orbit around the middle; Shift: pan; with the tool Paint: paint
  middle button       pan
  right button        turn the head
  wheel               zoom
  double click        look at what is under the mouse
Keys:
  W A S D, Q E        fly ahead, left, back, right, down, up; Shift: faster
  F                   frame everything
  1 2 3               tools: Move, Pick, Paint
  Ctrl+Z, Ctrl+Y      undo, redo
  Ctrl+S              save the scene
  Ctrl+Q              close the window

Exit code: 0 the window was closed, 1 bad input or no window, 2 usage.

Examples:
  rilievo view scenes/relief/scene.toml
  rilievo view textures/rock058/ --backend gpu
  rilievo view heights.png --mesh spot.obj
  rilievo view scene.toml --compare other.toml
  rilievo view scene.toml --compare-method distance-published
  rilievo view scene.toml --threads 4 --window 1920x1080
  rilievo view scene.toml --journal > journal.jsonl";

fn method(name: &str) -> Result<Method, String> {
    name.parse().map_err(|e: rilievo::relief::UnknownMethod| e.to_string())
}

fn backend() -> impl TypedValueParser<Value = Backend> {
    PossibleValuesParser::new(Backend::ALL.map(Backend::name)).try_map(|name| name.parse())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let found = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    found
        .filter(|size| size.iter().all(|n| (320..=16_384).contains(n)))
        .ok_or_else(|| "two numbers from 320 to 16384, as 1280x800".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn every_flag_has_an_example_that_is_understood() {
        let (_, examples) = HELP.split_once("Examples:\n").unwrap();
        for argument in Arguments::command().get_arguments() {
            let Some(flag) = argument.get_long() else { continue };
            let shown = format!(" --{flag} ");
            assert!(
                examples.lines().any(|line| format!("{line} ").contains(&shown)),
                "--{flag} has no example"
            );
        }
        for line in examples.lines() {
            let words = line.trim().strip_prefix("rilievo view ").unwrap();
            let words = words.split_once(" >").map_or(words, |(words, _)| words).split(' ');
            if let Err(e) =
                Arguments::try_parse_from(std::iter::once("rilievo-viewer").chain(words))
            {
                panic!("{line}: {e}");
            }
        }
    }
}
