//! What `--backend` means.

use std::cell::OnceCell;

use rilievo::map::{DistanceKind, DistanceMap, DistanceMapError, DistanceOptions, HeightMap};
use rilievo_gpu::{Backend, Gpu, GpuError, GpuScene, GpuTracer};
use rilievo_render::{Scene, Tracer};

use crate::args::RenderArgs;
use crate::outcome::Failure;

/// What traces rays when the CPU does.
const CPU: &str = "cpu";

/// The GPU that a render asks for, opened when there is something for it to do.
pub struct Device {
    backend: Backend,
    opened: OnceCell<Result<Option<Gpu>, GpuError>>,
}

impl Device {
    pub fn new(backend: Backend) -> Self {
        Self { backend, opened: OnceCell::new() }
    }

    fn open(&self) -> Result<Option<&Gpu>, GpuError> {
        let opened = self.opened.get_or_init(|| self.backend.open());
        opened.as_ref().map(Option::as_ref).map_err(GpuError::clone)
    }

    /// A distance map, built by the GPU if there is one; the CPU builds the same.
    ///
    /// # Errors
    /// As [`DistanceMap::from_height`].
    pub fn distance_map(
        &self,
        heights: &HeightMap,
        kind: DistanceKind,
        options: &DistanceOptions,
    ) -> Result<DistanceMap, DistanceMapError> {
        // What is wrong with a GPU is told when it is to trace.
        match self.open() {
            Ok(Some(gpu)) => gpu.distance_map(heights, kind, options).ok(),
            Ok(None) | Err(_) => None,
        }
        .map_or_else(|| DistanceMap::from_height(heights, kind, options), Ok)
    }
}

/// Does some work with what traces rays in place of the CPU's threads, if anything does; and says what does:
/// "cpu", or the name of a GPU.
///
/// With `auto` the CPU takes over where and when the GPU cannot go on, and a note says why.
///
/// # Errors
/// [`Failure::Refused`] where `gpu` is asked for and cannot be had; what the work returns.
pub fn with_tracer<T>(
    args: &RenderArgs,
    device: &Device,
    scene: &Scene,
    work: impl FnOnce(Option<&dyn Tracer>) -> Result<T, Failure>,
) -> Result<(T, String), Failure> {
    let backend = args.backend;
    let note = |error: &GpuError| args.talk.line(format_args!("note: {error}; the CPU takes over"));
    let opened = match backend {
        Backend::Cpu => Ok(None),
        Backend::Gpu | Backend::Auto => rilievo_gpu::check(scene).and_then(|()| device.open()),
    };
    let gpu = backend.or_cpu(opened, note).map_err(Failure::refused)?.flatten();
    let Some(gpu) = gpu else { return Ok((work(None)?, CPU.to_owned())) };
    let on_gpu = GpuScene::new(gpu, scene);
    let Some(on_gpu) = backend.or_cpu(on_gpu, note).map_err(Failure::refused)? else {
        return Ok((work(None)?, CPU.to_owned()));
    };
    let name = gpu.name();
    match on_gpu.why_not() {
        None => args.talk.line(format_args!("{name} traces and shades")),
        Some(why) => args.talk.line(format_args!(
            "{name} traces, the CPU shades in waves: {why} is not shaded on a GPU"
        )),
    }
    let tracer = GpuTracer::of_scene(on_gpu, backend == Backend::Auto, note);
    let done = work(Some(&tracer))?;
    Ok((done, gpu.name().to_owned()))
}
