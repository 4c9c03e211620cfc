//! What `--backend` means.

use std::sync::atomic::{AtomicBool, Ordering};

use rilievo::Ray;
use rilievo_gpu::{Gpu, GpuError, GpuWorld};
use rilievo_render::{Scene, ShadowRay, Traced, Tracer};

use crate::args::{Backend, RenderArgs};
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
    let note = |error: &GpuError| note(args, error);
    let deputy = Deputy { allowed: args.backend == Backend::Auto, note, acts: false.into() };
    let tracer = OnGpu { scene, world, deputy };
    let done = work(Some(&tracer))?;
    Ok((done, gpu.name().to_owned()))
}

/// A GPU, and the CPU for when it gives up.
struct OnGpu<'a, N> {
    scene: &'a Scene,
    world: GpuWorld<'a>,
    deputy: Deputy<N>,
}

impl<N: Fn(&GpuError) + Sync> Tracer for OnGpu<'_, N> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        let cpu = || Tracer::closest(self.scene.world(), rays);
        self.deputy.either(|| self.world.closest(rays), cpu)
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        let cpu = || Tracer::occluded(self.scene.world(), rays);
        self.deputy.either(|| self.world.occluded(rays), cpu)
    }
}

/// The CPU in the GPU's place.
struct Deputy<N> {
    /// Whether it may take over.
    allowed: bool,
    /// Told of the error after which it does.
    note: N,
    /// Whether it has taken over.
    acts: AtomicBool,
}

impl<N: Fn(&GpuError)> Deputy<N> {
    /// What the GPU says; from its first error on what the CPU says, if it may take over.
    fn either<T>(
        &self,
        gpu: impl FnOnce() -> Result<T, GpuError>,
        cpu: impl FnOnce() -> Result<T, String>,
    ) -> Result<T, String> {
        if self.acts.load(Ordering::Relaxed) {
            return cpu();
        }
        match gpu() {
            Ok(found) => Ok(found),
            Err(error) if self.allowed => {
                (self.note)(&error);
                self.acts.store(true, Ordering::Relaxed);
                cpu()
            }
            Err(error) => Err(error.to_string()),
        }
    }
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn lost() -> Result<&'static str, GpuError> {
        Err(GpuError::Lost { adapter: "it".to_owned(), reason: "unplugged".to_owned() })
    }

    #[test]
    fn the_cpu_takes_over_in_the_middle_once_and_for_all_and_says_so() {
        for error in [lost(), Err(GpuError::OutOfMemory { adapter: "it".to_owned() })] {
            let notes = Cell::new(0);
            let note = |_: &GpuError| notes.set(notes.get() + 1);
            let deputy = Deputy { allowed: true, note, acts: false.into() };
            let cpu = || Ok("cpu");
            assert_eq!(deputy.either(|| Ok("gpu"), cpu), Ok("gpu"));
            assert_eq!(deputy.either(|| error, cpu), Ok("cpu"));
            assert_eq!(deputy.either(|| Ok("gpu"), cpu), Ok("cpu"));
            assert_eq!(notes.get(), 1);
        }
    }

    #[test]
    fn a_gpu_that_is_asked_for_fails_with_advice() {
        let deputy = Deputy { allowed: false, note: |_: &GpuError| {}, acts: false.into() };
        let error = deputy.either(lost, || Ok("cpu")).unwrap_err();
        assert!(error.contains("unplugged") && error.contains("try again or use the CPU"));
    }
}
