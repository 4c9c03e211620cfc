//! A GPU that goes away in the middle of a picture. Without an adapter nothing is tried, and stderr says so.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use rilievo::Ray;
use rilievo_gpu::{Gpu, GpuError, GpuWorld};
use rilievo_io::Limits;
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_render::{
    Film, RenderOptions, RenderSettings, Scene, ShadowRay, Traced, Tracer, render,
};

fn gpu() -> Option<Gpu> {
    Gpu::open()
        .map_err(|error| writeln!(std::io::stderr(), "SKIPPED, no GPU was lost: {error}"))
        .ok()
}

fn scene() -> Scene {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell_reflect/scene.toml");
    let file = SceneFile::read(&path, &Limits::default()).unwrap();
    let scene = file.load(&LoadOptions::default()).unwrap().scene;
    let camera = scene.camera().with_resolution([16, 16]).unwrap();
    let settings = RenderSettings { samples: 2, ..*scene.settings() };
    scene.with_camera(camera).with_settings(settings).unwrap()
}

/// Destroys the device before it is asked for the third time: camera rays and their shadows are traced by then.
struct Losing<'a> {
    world: GpuWorld<'a>,
    gpu: &'a Gpu,
    asked: AtomicU32,
}

impl Losing<'_> {
    fn world(&self) -> &GpuWorld<'_> {
        if self.asked.fetch_add(1, Ordering::Relaxed) == 2 {
            self.gpu.device().destroy();
        }
        &self.world
    }
}

impl Tracer for Losing<'_> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        Tracer::closest(self.world(), rays)
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        Tracer::occluded(self.world(), rays)
    }
}

fn drawn(scene: &Scene, tracer: Option<&dyn Tracer>) -> Result<Film, String> {
    let options = RenderOptions { tracer, ..RenderOptions::default() };
    render(scene, &options).map(|drawn| drawn.0).map_err(|error| error.to_string())
}

#[test]
fn a_gpu_that_is_lost_ends_a_picture_with_advice() {
    let Some(gpu) = gpu() else { return };
    let scene = scene();
    let world = GpuWorld::new(&gpu, scene.world()).unwrap();
    let losing = Losing { world, gpu: &gpu, asked: 0.into() };
    let error = drawn(&scene, Some(&losing)).expect_err("a lost device");
    assert_eq!(losing.asked.into_inner(), 3);
    assert!(error.contains("was lost") && error.contains("use the CPU"), "{error}");
    // What comes after says the same.
    let again = GpuWorld::new(&gpu, scene.world()).err().expect("a lost device");
    assert!(matches!(again, GpuError::Lost { .. }), "{again}");
}
