//! What each method pays: the steps of a ray, pixel by pixel, as heat pictures and in numbers.

use super::Studio;
use super::paper::render;
use super::program::Threads;
use super::table::Table;

const SCENE: &str = "cornell_studded_shadows";

const METHODS: &[&str] =
    &["dda", "pyramid", "distance", "distance-corrected", "distance-published", "march"];

/// Looks away from everything: no ray takes a step. Steps are told as a difference from it.
const NOTHING: &str = "\
[camera]
position   = [0, 0, 5]
look_at    = [0, 0, 10]
up         = [0, 1, 0]
fov        = 20.0
resolution = [16, 16]

[materials.any]
diffuse = [0, 0, 0]
emitted = [1, 1, 1]

[[shapes]]
type = \"quad\"
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
material = \"any\"
";

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let resolution = if studio.quick { "32x32" } else { "192x192" };
    let flags = ["--integrator", "aov", "--pixel-centers", "--aov", "Steps"];
    let flags = [&flags[..], &["--resolution", resolution]].concat();
    let (scene, zero) = (studio.scratch("nothing.toml"), studio.scratch("nothing.exr"));
    std::fs::write(&scene, NOTHING).map_err(|e| format!("{}: {e}", scene.display()))?;
    let mut words = vec!["render".into(), scene, "-o".into(), zero.clone()];
    words.extend(flags.iter().map(Into::into));
    studio.program.call(Threads::All, &words)?;
    let mut table = Table::new(&["method", "steps, mean", "steps, most"]);
    for &method in METHODS {
        let flags = [&flags[..], &["--method", method]].concat();
        render(studio, (SCENE, &studio.picture(&format!("steps-{method}.png"))), &flags)?;
        let counted = studio.scratch("steps.exr");
        render(studio, (SCENE, &counted), &flags)?;
        let words = ["diff".into(), counted, zero.clone(), "--layer".into(), "Steps".into()];
        let found = studio.program.call(Threads::All, &words)?;
        let (mean, most) = (found.number("mean")?, found.number("max")?);
        table.row(vec![format!("`{method}`"), format!("{mean:.1}"), format!("{most:.0}")]);
    }
    studio.write("docs/paper.md", "steps", &table.markdown())
}
