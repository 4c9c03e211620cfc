//! The scenes on real maps: pictures, samples and memory.

use super::Studio;
use super::paper::render;
use super::program::Threads;
use super::table::{Table, mebibytes, seconds};

/// The picture at the head of the README; drawn with more samples than the scene asks for.
const MAIN: &str = "relief";

/// A scene, its map below `scenes/maps`, and the size of its picture.
const SCENES: &[(&str, &str, &str)] = &[
    (MAIN, "roofing-tiles/RoofingTiles009_1K_Displacement.png", "640x400"),
    ("moss", "moss/Moss001_1K_Displacement.png", "384x384"),
    ("facade", "facade/Facade001_1K_Displacement.png", "384x384"),
    ("jacksboro", "jacksboro/jacksboro_metres_u16.png", "384x384"),
    ("canyon", "canyon/Canyon-Height.jpg", "384x384"),
    ("moon", "moon/WAC_GLD100_E000N1800_004P.png", "384x384"),
    ("earth", "earth/etopo20_metres_f32.exr", "384x384"),
    ("tiled_sphere", "roofing-tiles/RoofingTiles009_1K_Displacement.png", "384x384"),
    ("spot", "bark/Bark014_1K_Displacement.jpg", "384x384"),
];

/// Scenes of no map file, and the size of their pictures.
const OTHERS: &[(&str, &str)] =
    &[("rolling", "576x360"), ("field", "576x360"), ("materials", "640x360")];

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let mut gallery = Table::new(&[
        "scene",
        "samples",
        "height map",
        "bounds",
        "maps and images in all",
        "predicted",
        "peak",
        "render, CPU s",
    ]);
    let mut readme =
        Table::new(&["scene", "samples", "height map", "bounds", "peak of the render"]);
    for &(scene, map, resolution) in SCENES {
        let out = studio.picture(&format!("{scene}.png"));
        let resolution = if studio.quick { "64x64" } else { resolution };
        let samples: &[&str] = if scene == MAIN { &["--samples", "64"] } else { &[] };
        let flags = [&["--resolution", resolution], samples].concat();
        let drawn = render(studio, (scene, &out), &flags)?;
        let map = studio.root.join("scenes/maps").join(map);
        let info = studio.program.call(Threads::All, &["info".into(), map])?;
        let samples = format!("{} x {}", info.number("width")?, info.number("height")?);
        let of = |bytes: f64| mebibytes(bytes);
        let heights = of(info.number("map_bytes")?);
        let bounds = of(drawn.number("bounds_bytes")?);
        let peak = of(drawn.number("peak_rss_bytes")?);
        readme.row(vec![
            scene.into(),
            samples.clone(),
            heights.clone(),
            bounds.clone(),
            peak.clone(),
        ]);
        gallery.row(vec![
            scene.into(),
            samples,
            heights,
            bounds,
            of(drawn.number("map_bytes")?),
            of(drawn.number("predicted_bytes")?),
            peak,
            seconds(drawn.number("render_cpu_seconds")?),
        ]);
    }
    for &(scene, resolution) in OTHERS {
        let resolution = if studio.quick { "64x64" } else { resolution };
        let out = studio.picture(&format!("{scene}.png"));
        render(studio, (scene, &out), &["--resolution", resolution])?;
    }
    let resolution = if studio.quick { "64x64" } else { "640x320" };
    for (out, flags) in [("sea", None), ("sea-lod", Some("--lod"))] {
        let out = studio.picture(&format!("{out}.png"));
        let flags: Vec<&str> = ["--resolution", resolution].into_iter().chain(flags).collect();
        render(studio, ("sea", &out), &flags)?;
    }
    studio.write("docs/gallery.md", "memory", &gallery.markdown())?;
    studio.write("README.md", "memory", &readme.markdown())
}
