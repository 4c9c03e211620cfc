//! What `--backend` means.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use rilievo::{Counters, Ray};
use rilievo_gpu::{Gpu, GpuError, GpuWorld};
use rilievo_render::{FirstHits, Scene, Traced};

use crate::args::{Backend, RenderArgs};
use crate::outcome::Failure;

/// What traces camera rays when the CPU does.
const CPU: &str = "cpu";

/// Does some work with what finds first hits in place of the scene's world, if anything does; and says what
/// traces camera rays: "cpu", or the name of a GPU.
///
/// With `auto` the CPU takes over where and when the GPU cannot go on, and a note says why.
///
/// # Errors
/// [`Failure::Refused`] where `gpu` is asked for and cannot be had; what the work returns.
pub fn with_first_hits<T>(
    args: &RenderArgs,
    scene: &Scene,
    work: impl FnOnce(Option<&FirstHits<'_>>) -> Result<T, Failure>,
) -> Result<(T, String), Failure> {
    let gpu = match args.backend {
        Backend::Cpu => None,
        Backend::Gpu | Backend::Auto => {
            let levels = scene.settings().lod > 0.0;
            let opened = if levels { Err(no_levels()) } else { Gpu::open() };
            unless_auto(args, opened)?
        }
    };
    let Some(gpu) = gpu else { return Ok((work(None)?, CPU.to_owned())) };
    let Some(world) = unless_auto(args, GpuWorld::new(&gpu, scene.world()))? else {
        return Ok((work(None)?, CPU.to_owned()));
    };
    let given_up = AtomicBool::new(false);
    let first_hits = |rays: &[Ray]| {
        if given_up.load(Ordering::Relaxed) {
            return Ok(trace_on_cpu(scene, rays));
        }
        match world.closest(rays) {
            Ok(found) => Ok(found),
            Err(error) if args.backend == Backend::Auto => {
                note(args, &error);
                given_up.store(true, Ordering::Relaxed);
                Ok(trace_on_cpu(scene, rays))
            }
            Err(error) => Err(error.to_string()),
        }
    };
    let done = work(Some(&first_hits))?;
    Ok((done, gpu.name().to_owned()))
}

/// Levels of detail are the CPU's.
fn no_levels() -> GpuError {
    GpuError::Unsupported { what: "a scene with level of detail (lod above 0)".to_owned() }
}

/// What was made, or none and a note if it could not be and the CPU may take over.
fn unless_auto<T>(args: &RenderArgs, made: Result<T, GpuError>) -> Result<Option<T>, Failure> {
    match made {
        Ok(made) => Ok(Some(made)),
        Err(error) if args.backend == Backend::Auto => {
            note(args, &error);
            Ok(None)
        }
        Err(error) => Err(Failure::refused(error)),
    }
}

fn note(args: &RenderArgs, error: &GpuError) {
    args.talk.line(format_args!("note: {error}; the CPU takes over"));
}

fn trace_on_cpu(scene: &Scene, rays: &[Ray]) -> Vec<Traced> {
    let trace = |ray: &Ray| {
        let mut counters = Counters::default();
        let hit = scene.world().closest(ray, &mut counters);
        Traced { hit, work: counters.total() }
    };
    rays.par_iter().map(trace).collect()
}
