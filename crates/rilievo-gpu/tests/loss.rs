//! A GPU that goes away, or has no memory left, in the middle of a picture. Without an adapter nothing is tried, and stderr
//! says so.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use rilievo::Ray;
use rilievo_gpu::{Gpu, GpuError, GpuTracer, GpuWorld, wgpu};
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

/// Ruins the device before it is asked for the third time: camera rays and their shadows are traced by then.
struct Losing<'a, N> {
    tracer: GpuTracer<'a, N>,
    gpu: &'a Gpu,
    ruin: fn(&Gpu),
    asked: AtomicU32,
}

fn destroy(gpu: &Gpu) {
    gpu.device().destroy();
}

/// Asks for more buffers than there is memory, and gives them back.
fn exhaust(gpu: &Gpu) {
    let device = gpu.device();
    let size = device.limits().max_buffer_size.min(1 << 31);
    let usage = wgpu::BufferUsages::STORAGE;
    let asked = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    let held: Vec<_> =
        (0..1 + (ADDRESSES << 10) / size).map(|_| device.create_buffer(&asked)).collect();
    drop(held);
}

/// KiB of addresses of a process that has little memory.
const ADDRESSES: u64 = 24 << 20;

/// Set in such a process.
const LITTLE_MEMORY: &str = "RILIEVO_LITTLE_MEMORY";

impl<'a, N: Fn(&GpuError) + Sync> Losing<'a, N> {
    fn new(
        (gpu, ruin): (&'a Gpu, fn(&Gpu)),
        scene: &'a Scene,
        cpu_may_take_over: bool,
        note: N,
    ) -> Self {
        let world = GpuWorld::new(gpu, scene.world()).unwrap();
        let tracer = GpuTracer::new(world, cpu_may_take_over, note);
        Self { tracer, gpu, ruin, asked: 0.into() }
    }

    fn count(&self) {
        if self.asked.fetch_add(1, Ordering::Relaxed) == 2 {
            (self.ruin)(self.gpu);
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
    let losing = Losing::new((&gpu, destroy), &scene, false, |_: &GpuError| {});
    let error = drawn(&scene, Some(&losing)).expect_err("a lost device");
    assert!(error.contains("was lost") && error.contains("use the CPU"), "{error}");
    // What comes after says the same.
    assert!(GpuWorld::new(&gpu, scene.world()).is_err_and(|e| e.to_string().contains("was lost")));
}

#[test]
fn the_cpu_goes_on_with_the_picture_of_a_gpu_that_is_lost() {
    let Some(gpu) = gpu() else { return };
    the_cpu_goes_on((&gpu, destroy), |error| matches!(error, GpuError::Lost { .. }));
}

/// A software adapter takes memory from its process, which a shell can keep short.
#[test]
fn a_gpu_without_memory_is_an_error_with_advice_and_the_cpu_goes_on() {
    let Some(gpu) = gpu() else { return };
    if std::env::var_os(LITTLE_MEMORY).is_none() {
        let own = std::env::current_exe().unwrap();
        let short = format!("ulimit -v {ADDRESSES} && exec \"$0\" \"$@\"");
        let name = "a_gpu_without_memory_is_an_error_with_advice_and_the_cpu_goes_on";
        let mut command = Command::new("sh");
        command.args(["-c", &short]).arg(own).args(["--exact", name]).env(LITTLE_MEMORY, "1");
        match command.output() {
            Ok(output) if gpu.is_software() => {
                let told = String::from_utf8_lossy(&output.stdout);
                assert!(output.status.success() && told.contains("1 passed"), "{told}");
            }
            _ => {
                let _ = writeln!(std::io::stderr(), "SKIPPED, no memory can be kept from the GPU");
            }
        }
        return;
    }
    the_cpu_goes_on((&gpu, exhaust), |error| matches!(error, GpuError::OutOfMemory { .. }));
    let error = GpuWorld::new(&gpu, scene().world()).err().expect("no memory").to_string();
    assert!(error.contains("out of memory") && error.contains("use the CPU"), "{error}");
}

fn the_cpu_goes_on((gpu, ruin): (&Gpu, fn(&Gpu)), expected: fn(&GpuError) -> bool) {
    let scene = scene();
    let notes = AtomicU32::new(0);
    let note = |error: &GpuError| {
        assert!(expected(error), "{error}");
        notes.fetch_add(1, Ordering::Relaxed);
    };
    let losing = Losing::new((gpu, ruin), &scene, true, note);
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
