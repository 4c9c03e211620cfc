//! `plots`: SVG pictures of a recorded run.
//!
//! | file | shows |
//! |---|---|
//! | `kernels-<row>.svg` | Mrays/s by map size, a panel a map |
//! | `ratios-<size>.svg` | rilievo / best Embree, a bar a row; losses in their own colour |
//! | `memory.svg` | bytes a texel beyond the heights, by map size |
//! | `build.svg` | processor time of the build, ns a texel, by map size |
//! | `transforms.svg` | distance maps and distance transforms, ns a voxel |

mod bars;
mod curves;
mod panel;
mod svg;

use std::fs;
use std::path::Path;

use crate::report::say;
use crate::runs::Run;

/// Draws the plots of the run in `folder` into `output`.
///
/// # Errors
/// A run that cannot be read or holds nothing to draw, or a plot that cannot be written.
pub fn plots(folder: &Path, output: &Path) -> Result<(), String> {
    let run = Run::read(folder)?;
    let mut plots = curves::rates(&run.kernels);
    plots.extend(bars::ratios(&run));
    plots.extend(curves::costs(&run.kernels));
    plots.extend(bars::transforms(&run.transforms));
    if plots.is_empty() {
        return Err(format!("{}: no lines to draw", folder.display()));
    }
    for Plot { name, text } in plots {
        let path = output.join(name);
        fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        say(format_args!("{}", path.display()));
    }
    Ok(())
}

/// A picture and the name of its file.
struct Plot {
    name: String,
    text: String,
}

/// The colour of a contender, readable on light and dark ground.
fn colour(contender: &str) -> &'static str {
    match contender {
        "rilievo-default" => "#d9480f",
        "rilievo-tiny" => "#f59f00",
        "embree-grid" => "#1c7ed6",
        "embree-quad" => "#0ca678",
        "embree-tri" => "#9c6ade",
        _ => "#868e96",
    }
}

/// Contenders in the order of a legend: ours first.
const ORDER: [&str; 5] =
    ["rilievo-default", "rilievo-tiny", "embree-grid", "embree-quad", "embree-tri"];
