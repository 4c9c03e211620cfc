//! [`Backend`]: what renders, as one asks for it; [`GpuTracer`]: a GPU, and the CPU for when it gives up.

use std::sync::atomic::{AtomicBool, Ordering};

use rilievo::Ray;
use rilievo_render::{CameraRay, Scene, Seen, ShadowRay, Traced, Tracer};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::shading::{GpuLight, GpuScene, WAVE};
use crate::world::{GpuSurfaces, GpuWorld};

/// Whether a GPU traces a scene as far as its settings go: levels of detail are the CPU's.
///
/// # Errors
/// [`GpuError::Unsupported`].
pub fn check(scene: &Scene) -> Result<(), GpuError> {
    if scene.settings().lod > 0.0 {
        let what = "a scene with level of detail (lod above 0)".to_owned();
        return Err(GpuError::Unsupported { what });
    }
    Ok(())
}

/// What renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The CPU.
    Cpu,
    /// A GPU, a program in its place too; what it cannot do is an error.
    Gpu,
    /// A GPU that is one; the CPU where there is none, and where and when it cannot go on.
    Auto,
}

/// A name that is no backend's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown backend {0:?}, expected cpu, gpu or auto")]
pub struct UnknownBackend(String);

impl Backend {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cpu, Self::Gpu, Self::Auto];

    /// Its name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
            Self::Auto => "auto",
        }
    }

    /// Opens the GPU that is asked for; none for [`Backend::Cpu`].
    ///
    /// # Errors
    /// As [`Gpu::open`]; [`GpuError::OnlySoftware`] where [`Backend::Auto`] finds a program in a GPU's place,
    /// which would be slower than the CPU itself.
    pub fn open(self) -> Result<Option<Gpu>, GpuError> {
        if self == Self::Cpu {
            return Ok(None);
        }
        let gpu = Gpu::open()?;
        if self == Self::Auto && gpu.is_software() {
            return Err(GpuError::OnlySoftware { adapter: gpu.name().to_owned() });
        }
        Ok(Some(gpu))
    }

    /// What was made on a GPU; none where it could not be and the CPU may take over, and `note` is told why.
    ///
    /// # Errors
    /// That of `made`, unless this is [`Backend::Auto`].
    pub fn or_cpu<T>(
        self,
        made: Result<T, GpuError>,
        note: impl FnOnce(&GpuError),
    ) -> Result<Option<T>, GpuError> {
        match made {
            Ok(made) => Ok(Some(made)),
            Err(error) if self == Self::Auto => {
                note(&error);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

impl std::str::FromStr for Backend {
    type Err = UnknownBackend;

    fn from_str(name: &str) -> Result<Self, UnknownBackend> {
        let found = Self::ALL.into_iter().find(|backend| backend.name() == name);
        found.ok_or_else(|| UnknownBackend(name.to_owned()))
    }
}

/// A GPU, and the CPU for when it gives up.
pub struct GpuTracer<'a, N> {
    held: Held<'a>,
    deputy: Deputy<N>,
}

/// What is on the GPU.
enum Held<'a> {
    World(Box<GpuWorld<'a>>),
    Scene(Box<GpuScene<'a>>),
}

impl<'a> Held<'a> {
    fn world(&self) -> &GpuWorld<'a> {
        match self {
            Self::World(world) => world,
            Self::Scene(scene) => scene.world(),
        }
    }
}

impl<'a, N: Fn(&GpuError)> GpuTracer<'a, N> {
    /// Traces on the GPU until it fails; `note` is told of the error. If the CPU may take over, all answers are its from
    /// then on; otherwise there are none.
    pub fn new(world: GpuWorld<'a>, cpu_may_take_over: bool, note: N) -> Self {
        Self::of(Held::World(Box::new(world)), cpu_may_take_over, note)
    }

    /// The same with the integrators on the GPU too, where they can be.
    pub fn of_scene(scene: GpuScene<'a>, cpu_may_take_over: bool, note: N) -> Self {
        Self::of(Held::Scene(Box::new(scene)), cpu_may_take_over, note)
    }

    fn of(held: Held<'a>, allowed: bool, note: N) -> Self {
        Self { held, deputy: Deputy { allowed, note, acts: false.into() } }
    }

    /// The surfaces on the GPU, and what the integrators have there, if they run there.
    pub fn into_parts(self) -> (GpuSurfaces, Option<GpuLight>) {
        match self.held {
            Held::World(world) => (world.into_surfaces(), None),
            Held::Scene(scene) => scene.into_parts(),
        }
    }

    /// The surfaces on the GPU.
    pub fn into_world(self) -> GpuWorld<'a> {
        match self.held {
            Held::World(world) => *world,
            Held::Scene(scene) => scene.into_world(),
        }
    }
}

impl<N: Fn(&GpuError) + Sync> Tracer for GpuTracer<'_, N> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        let cpu = || Tracer::closest(self.held.world().world(), rays);
        self.deputy.either(|| self.held.world().closest(rays), cpu)
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        let cpu = || Tracer::occluded(self.held.world().world(), rays);
        self.deputy.either(|| self.held.world().occluded(rays), cpu)
    }

    fn seen(&self, rays: &[CameraRay], samples: u64) -> Result<Option<Seen>, String> {
        match &self.held {
            Held::World(_) => Ok(None),
            // Without the GPU waves go on, traced by the CPU.
            Held::Scene(scene) => self.deputy.either(|| scene.seen(rays, samples), || Ok(None)),
        }
    }

    fn at_once(&self) -> Option<usize> {
        match &self.held {
            Held::World(world) => world.is_watched().then_some(WAVE),
            Held::Scene(scene) => Tracer::at_once(scene.as_ref()),
        }
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn lost() -> Result<&'static str, GpuError> {
        Err(GpuError::Lost { adapter: "it".to_owned(), reason: "unplugged".to_owned() })
    }

    #[test]
    fn names_are_read_back() {
        for backend in Backend::ALL {
            assert_eq!(backend.name().parse(), Ok(backend));
        }
        assert!("tpu".parse::<Backend>().unwrap_err().to_string().contains("auto"));
    }

    #[test]
    fn only_auto_lets_the_cpu_take_over_and_says_why() {
        let notes = Cell::new(0);
        let note = |_: &GpuError| notes.set(notes.get() + 1);
        assert_eq!(Backend::Auto.or_cpu(lost(), note), Ok(None));
        assert_eq!(notes.get(), 1);
        assert_eq!(Backend::Gpu.or_cpu(lost(), note), lost().map(Some));
        assert_eq!(Backend::Auto.or_cpu(Ok(3), note), Ok(Some(3)));
        assert_eq!(notes.get(), 1);
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
