//! Scenes of the gallery, drawn with all rays traced on a GPU, beside the pictures of the CPU. Without an adapter nothing
//! is drawn, and stderr says so.

use std::io::Write;
use std::path::Path;

use rilievo::surface::World;
use rilievo_gpu::{Gpu, GpuWorld};
use rilievo_io::Limits;
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_render::{
    Aov, Film, Integrator, RenderOptions, RenderSettings, RenderStats, Scene, Tracer, render,
};

fn gpu() -> Option<Gpu> {
    Gpu::open()
        .map_err(|error| writeln!(std::io::stderr(), "SKIPPED, nothing was drawn: {error}"))
        .ok()
}

/// A scene of the gallery, small.
fn scene(name: &str, settings: impl FnOnce(RenderSettings) -> RenderSettings) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let file = SceneFile::read(&path.join(name).join("scene.toml"), &Limits::default()).unwrap();
    let scene = file.load(&LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene;
    let camera = scene.camera().with_resolution([24, 24]).unwrap();
    let settings = settings(*scene.settings());
    scene.with_camera(camera).with_settings(settings).unwrap()
}

fn drawn(scene: &Scene, tracer: Option<&dyn Tracer>) -> (Film, RenderStats) {
    let options = RenderOptions { tracer, aovs: &[Aov::P, Aov::Ns], ..RenderOptions::default() };
    render(scene, &options).unwrap()
}

/// Pixels whose colours are not the same within 1e-3 of the picture's mean.
fn other_pixels(one: &Film, other: &Film) -> usize {
    let values = || one.radiance().iter().flatten();
    let mean = values().sum::<f32>() / values().count() as f32;
    assert!(mean > 0.0 && mean.is_finite(), "{mean}");
    let differ =
        |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3 * mean);
    one.radiance().iter().zip(other.radiance()).filter(differ).count()
}

/// Rays that a rounding sends another way change a sample here and there, not the picture.
#[test]
fn pictures_of_the_gallery_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for (name, integrator, samples) in [
        ("cornell_reflect", Integrator::Distributed, 4),
        ("facade", Integrator::Distributed, 2),
        ("cornell_reflect", Integrator::Path, 4),
        ("relief", Integrator::Path, 4),
    ] {
        let scene = scene(name, |settings| RenderSettings {
            integrator,
            samples,
            shadow_samples: settings.shadow_samples.min(4),
            ..settings
        });
        let on_gpu = GpuWorld::new(&gpu, scene.world()).unwrap();
        let (one, stats) = drawn(&scene, None);
        let (many, on_device) = drawn(&scene, Some(&on_gpu));
        let other = other_pixels(&one, &many);
        let _ = writeln!(std::io::stderr(), "{name}, {integrator}: {other} of 576 pixels differ");
        assert!(other * 100 <= 576, "{name}, {integrator}: {other} pixels differ");
        assert_eq!(stats.rays.camera, on_device.rays.camera);
        let [a, b] = [stats, on_device].map(|stats| stats.rays.total() as f64);
        assert!(
            a > 576.0 * f64::from(samples) && (a / b - 1.0).abs() < 1e-3,
            "{name}: {a} and {b} rays"
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let Some(gpu) = gpu() else { return };
    for integrator in [Integrator::Distributed, Integrator::Path] {
        let settings = |settings| RenderSettings { integrator, samples: 2, ..settings };
        let scene = scene("cornell_reflect", settings);
        let run = |threads, world: &World| {
            let on_gpu = GpuWorld::new(&gpu, world).unwrap();
            let options =
                RenderOptions { tracer: Some(&on_gpu), threads, ..RenderOptions::default() };
            let film = render(&scene, &options).unwrap().0;
            film.radiance().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert!(run(1, scene.world()) == run(3, scene.world()), "{integrator}");
    }
}
