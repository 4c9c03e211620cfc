//! A GPU that goes away in the middle of a picture. Without an adapter nothing is tried, and stderr says so.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use rilievo::Ray;
use rilievo_gpu::{Gpu, GpuError, GpuTracer, GpuWorld};
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
struct Losing<'a, N> {
    tracer: GpuTracer<'a, N>,
    gpu: &'a Gpu,
    asked: AtomicU32,
}

impl<'a, N: Fn(&GpuError) + Sync> Losing<'a, N> {
    fn new(gpu: &'a Gpu, scene: &'a Scene, cpu_may_take_over: bool, note: N) -> Self {
        let world = GpuWorld::new(gpu, scene.world()).unwrap();
        let tracer = GpuTracer::new(world, cpu_may_take_over, note);
        Self { tracer, gpu, asked: 0.into() }
    }

    fn count(&self) {
        if self.asked.fetch_add(1, Ordering::Relaxed) == 2 {
            self.gpu.device().destroy();
        }
    }
}

impl<N: Fn(&GpuError) + Sync> Tracer for Losing<'_, N> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        self.count();
        self.tracer.closest(rays)
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        self.count();
        self.tracer.occluded(rays)
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
    let losing = Losing::new(&gpu, &scene, false, |_: &GpuError| {});
    let error = drawn(&scene, Some(&losing)).expect_err("a lost device");
    assert!(error.contains("was lost") && error.contains("use the CPU"), "{error}");
    // What comes after says the same.
    assert!(GpuWorld::new(&gpu, scene.world()).is_err_and(|e| e.to_string().contains("was lost")));
}

#[test]
fn the_cpu_goes_on_with_the_picture_of_a_gpu_that_is_lost() {
    let Some(gpu) = gpu() else { return };
    let scene = scene();
    let notes = AtomicU32::new(0);
    let note = |error: &GpuError| {
        assert!(matches!(error, GpuError::Lost { .. }), "{error}");
        notes.fetch_add(1, Ordering::Relaxed);
    };
    let losing = Losing::new(&gpu, &scene, true, note);
    let (cpu, both) = (drawn(&scene, None).unwrap(), drawn(&scene, Some(&losing)).unwrap());
    assert!(notes.load(Ordering::Relaxed) == 1 && losing.asked.load(Ordering::Relaxed) > 4);
    assert!(both.is_complete());
    let mean = cpu.radiance().iter().flatten().sum::<f32>() / (3 * 256) as f32;
    let apart = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|k| (a[k] - b[k]).abs() / mean).fold(0.0, f32::max)
    };
    let other = cpu.radiance().iter().zip(both.radiance()).filter(|pair| apart(*pair) > 1e-3);
    assert!(mean > 0.0 && other.count() <= 2);
}
