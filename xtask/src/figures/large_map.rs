//! A map of 4096 x 4096 16-bit samples: how long its pyramid takes, and the memory of a render.

use std::path::PathBuf;

use super::Studio;
use super::heights::Shape;
use super::program::Threads;
use super::table::{Table, mebibytes};

const SCENE: &str = "\
[camera]
position   = [0.5, -0.6, 0.6]
look_at    = [0.5, 0.45, 0.0]
up         = [0, 0, 1]
fov        = 40.0
resolution = [512, 512]

[render]
integrator     = \"distributed\"
samples        = 4
shadow_samples = 4
max_depth      = 1

[maps.large]
file = \"large.png\"

[materials.clay]
diffuse = [0.6, 0.5, 0.4]

[materials.sun]
diffuse = [0, 0, 0]
emitted = [60, 55, 45]

[[shapes]]
type = \"quad\"
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
material = \"clay\"
displacement = { map = \"large\", scale = 0.1 }

[[shapes]]
type = \"quad\"
corners = [[-2, 0, 1.0], [-2, 1, 1.0], [-1.5, 1, 1.8], [-1.5, 0, 1.8]]
material = \"sun\"
one_sided = true
";

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let side = if studio.quick { 256 } else { 4096 };
    let (scene, map) = (studio.scratch("large.toml"), studio.scratch("large.png"));
    std::fs::write(&scene, SCENE).map_err(|e| format!("{}: {e}", scene.display()))?;
    Shape::Fbm.write(&map, side)?;
    let call = |words: Vec<PathBuf>| studio.program.call(Threads::All, &words);
    let info = call(vec!["info".into(), scene.clone()])?;
    let bounds = studio.scratch("large.rlv");
    let bounds = call(
        ["bake", "bounds"].map(Into::into).into_iter().chain([map, "-o".into(), bounds]).collect(),
    )?;
    let out = studio.scratch("large-picture.png");
    let drawn = call(vec!["render".into(), scene, "-o".into(), out])?;
    let mut table = Table::new(&["of the map or the render", "measured"]);
    let mut row = |what: &str, value: String| table.row(vec![what.into(), value]);
    row("samples", format!("{side} x {side}, 16 bit"));
    row("pyramid, clock on the wall", format!("{:.3} s", bounds.number("build_seconds")?));
    row(
        "reading and building, clock on the wall",
        format!("{:.2} s", drawn.number("build_seconds")?),
    );
    row("heights", mebibytes(drawn.number("map_bytes")?));
    row("pyramid", mebibytes(drawn.number("bounds_bytes")?));
    row("peak, as `info` predicts it", mebibytes(info.number("predicted_bytes")?));
    row("peak of the render, 512 x 512, 4 samples", mebibytes(drawn.number("peak_rss_bytes")?));
    studio.write("docs/METHODS.md", "large-map", &table.markdown())
}
