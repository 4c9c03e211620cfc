//! What was typed.

use std::path::PathBuf;

use clap::Parser;
use rilievo::relief::Method;

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

Exit code: 0 the window was closed, 1 bad input or no window, 2 usage.";

fn method(name: &str) -> Result<Method, String> {
    name.parse().map_err(|e: rilievo::relief::UnknownMethod| e.to_string())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let found = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    found
        .filter(|size| size.iter().all(|n| (320..=16_384).contains(n)))
        .ok_or_else(|| "two numbers from 320 to 16384, as 1280x800".to_owned())
}
