//! The scenes on real maps: pictures, samples and memory.

use super::Studio;
use super::paper::render;
use super::program::{Report, Threads};
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
    ("rolling", "roofing-tiles/RoofingTiles009_1K_Displacement.png", "576x360"),
];

/// Scenes of no map file, and the size of their pictures.
const OTHERS: &[(&str, &str)] =
    &[("field", "576x360"), ("materials", "640x360"), ("sea", "640x320")];

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
        let row = [scene.to_owned(), samples, mebibytes(info.number("map_bytes")?)];
        write_rows((&mut gallery, &mut readme), row, &drawn)?;
    }
    for &(scene, resolution) in OTHERS {
        let resolution = if studio.quick { "64x64" } else { resolution };
        let out = studio.picture(&format!("{scene}.png"));
        let drawn = render(studio, (scene, &out), &["--resolution", resolution])?;
        let info = studio.program.call(Threads::All, &["info".into(), studio.scene(scene)])?;
        let row = [scene.to_owned(), info.map_sizes()?, "procedural".to_owned()];
        write_rows((&mut gallery, &mut readme), row, &drawn)?;
    }
    let resolution = if studio.quick { "64x64" } else { "640x320" };
    let out = studio.picture("sea-lod.png");
    render(studio, ("sea", &out), &["--resolution", resolution, "--lod"])?;
    studio.write("docs/gallery.md", "memory", &gallery.markdown())?;
    studio.write("README.md", "memory", &readme.markdown())
}

/// Writes a scene, the samples of its maps and the size of its map file, and what a render measured.
fn write_rows(
    (gallery, readme): (&mut Table, &mut Table),
    [scene, samples, heights]: [String; 3],
    drawn: &Report,
) -> Result<(), String> {
    let bytes = |key: &str| drawn.number(key).map(mebibytes);
    let (bounds, peak) = (bytes("bounds_bytes")?, bytes("peak_rss_bytes")?);
    let first = [scene, samples, heights, bounds];
    readme.row(first.iter().chain([&peak]).cloned().collect());
    let rest = [bytes("map_bytes")?, bytes("predicted_bytes")?, peak];
    let took = seconds(drawn.number("render_cpu_seconds")?);
    gallery.row(first.into_iter().chain(rest).chain([took]).collect());
    Ok(())
}
