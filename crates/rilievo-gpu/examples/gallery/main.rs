//! Scenes of the gallery on a GPU, beside the CPU and beside the judge of the tests, as tables in Markdown.
//!
//! `gallery PIXELS SCENE-FOLDER...` traces one ray through the centre of each of PIXELS x PIXELS pixels (`hits`), and draws the
//! scene by its own integrator (`pictures`). Stdout: the adapter's name, a table of the hits, one of the pictures, with an empty
//! line between. Exit code 1: there is no adapter, a scene does not load, or an answer is wrong.

#![forbid(unsafe_code)]

mod hits;
mod pictures;

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use rilievo_gpu::{Gpu, GpuScene};
use rilievo_io::Limits;
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_render::{RenderSettings, Scene};

/// Camera rays a pixel of the pictures.
const MOST_SAMPLES: u32 = 4;

fn main() -> ExitCode {
    let mut words = std::env::args_os().skip(1);
    let pixels = words.next().and_then(|word| word.to_str()?.parse().ok());
    let folders: Vec<PathBuf> = words.map(PathBuf::from).collect();
    let (Some(pixels), false) = (pixels, folders.is_empty()) else {
        let _ = writeln!(std::io::stderr(), "usage: gallery PIXELS SCENE-FOLDER...");
        return ExitCode::from(2);
    };
    match compared(&folders, pixels) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            let _ = writeln!(std::io::stderr(), "gallery: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Writes both tables; says whether every answer is right.
fn compared(folders: &[PathBuf], pixels: u32) -> Result<bool, String> {
    let gpu = Gpu::open().map_err(|error| error.to_string())?;
    let (mut hits, mut pictures) = (vec![hits::HEAD.to_owned()], vec![pictures::HEAD.to_owned()]);
    let mut right = true;
    for folder in folders {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let _ = writeln!(std::io::stderr(), "{name}");
        let scene = scene(folder, pixels)?;
        let on_gpu = match GpuScene::new(&gpu, &scene) {
            Ok(on_gpu) => on_gpu,
            Err(error) => {
                hits.push(format!("| {name} | refused: {error} |"));
                continue;
            }
        };
        let found = hits::Comparison::new(&scene, on_gpu.world())
            .map_err(|why| format!("{name}: {why}"))?;
        right &= found.is_right();
        hits.push(format!("| {name} | {found} |"));
        let drawn = pictures::Comparison::new(&scene, &on_gpu)?;
        pictures.push(format!("| {name} | {drawn} |"));
    }
    let text = format!("{}\n\n{}\n\n{}\n", gpu.name(), hits.join("\n"), pictures.join("\n"));
    std::io::stdout().write_all(text.as_bytes()).map_err(|error| error.to_string())?;
    Ok(right)
}

/// A scene at a size, with few samples.
fn scene(folder: &Path, pixels: u32) -> Result<Scene, String> {
    let told = |error: &dyn fmt::Display| format!("{}: {error}", folder.display());
    let file = SceneFile::read(&folder.join("scene.toml"), &Limits::default());
    let loaded = file.and_then(|file| file.load(&LoadOptions::default()));
    let scene = loaded.map_err(|error| told(&error))?.scene;
    let camera = scene.camera().with_resolution([pixels; 2]).map_err(|error| told(&error))?;
    let settings = *scene.settings();
    let settings = RenderSettings { samples: settings.samples.min(MOST_SAMPLES), ..settings };
    scene.with_camera(camera).with_settings(settings).map_err(|error| told(&error))
}
