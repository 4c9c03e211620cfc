//! What `--backend` means.

use rilievo_gpu::{Backend, GpuError, GpuScene, GpuTracer};
use rilievo_render::{Scene, Tracer};

use crate::args::RenderArgs;
use crate::outcome::Failure;

/// What traces rays when the CPU does.
const CPU: &str = "cpu";

/// Does some work with what traces rays in place of the CPU's threads, if anything does; and says what does:
/// "cpu", or the name of a GPU.
///
/// With `auto` the CPU takes over where and when the GPU cannot go on, and a note says why.
///
/// # Errors
/// [`Failure::Refused`] where `gpu` is asked for and cannot be had; what the work returns.
pub fn with_tracer<T>(
    args: &RenderArgs,
    scene: &Scene,
    work: impl FnOnce(Option<&dyn Tracer>) -> Result<T, Failure>,
) -> Result<(T, String), Failure> {
    let backend = args.backend;
    let note = |error: &GpuError| args.talk.line(format_args!("note: {error}; the CPU takes over"));
    let opened = match backend {
        Backend::Cpu => Ok(None),
        Backend::Gpu | Backend::Auto => rilievo_gpu::check(scene).and_then(|()| backend.open()),
    };
    let gpu = backend.or_cpu(opened, note).map_err(Failure::refused)?.flatten();
    let Some(gpu) = gpu else { return Ok((work(None)?, CPU.to_owned())) };
    let on_gpu = GpuScene::new(&gpu, scene);
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
