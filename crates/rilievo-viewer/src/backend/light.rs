//! [`Lit`]: what lights surfaces that lie on a GPU; [`Shaders`]: which shaders work that out there.
//!
//! Materials and lights stay on the device as surfaces do. Another camera and other settings bring a few words, another
//! material the words that differ. Until its shaders are compiled, and where they do not know all of a scene, rays are traced there
//! and shaded by the CPU.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use rilievo_gpu::{Gpu, GpuError, GpuLight, GpuScene, GpuShaders, GpuTracer, GpuWorld};
use rilievo_render::device::Uncovered;
use rilievo_render::{Integrator, Scene};

use super::Wake;

/// What lights surfaces on a GPU.
#[derive(Default)]
pub(super) enum Lit {
    #[default]
    Unknown,
    /// What the shaders of an integrator do not know.
    Uncovered(Uncovered, Integrator),
    /// The materials and lights of the scene.
    Now(GpuLight),
    /// Those of one before it.
    Before(GpuLight),
}

/// Where a picture is shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Shaded {
    /// It is not: layers are first hits.
    #[default]
    Nowhere,
    OnGpu,
    /// By the CPU, until shaders are compiled.
    Meanwhile,
    /// By the CPU, because of this.
    OnCpu(Uncovered),
}

impl Lit {
    /// After the scene was loaded anew.
    pub fn older(self) -> Self {
        match self {
            Self::Now(light) | Self::Before(light) => Self::Before(light),
            Self::Unknown | Self::Uncovered(..) => Self::Unknown,
        }
    }

    /// What renders a scene on a GPU, and what of this it does not hold itself; `layers` if nothing is shaded.
    ///
    /// # Errors
    /// As [`GpuScene::new`].
    pub fn tracer<'a, N: Fn(&GpuError)>(
        self,
        (gpu, shaders): (&'a Arc<Gpu>, &mut Shaders),
        (world, scene): (GpuWorld<'a>, &'a Scene),
        (layers, note): (bool, N),
    ) -> Result<(GpuTracer<'a, N>, Self, Shaded), GpuError> {
        let integrator = scene.settings().integrator;
        let on_gpu = match self {
            lit if layers => return Ok((GpuTracer::new(world, true, note), lit, Shaded::Nowhere)),
            Self::Uncovered(why, of) if of == integrator => {
                return Ok((GpuTracer::new(world, true, note), self, Shaded::OnCpu(why)));
            }
            Self::Unknown | Self::Uncovered(..) => GpuScene::with_world(world, scene),
            Self::Now(light) => GpuScene::again(world, scene, light),
            Self::Before(light) => GpuScene::following(world, scene, light),
        }?;
        if let Some(why) = on_gpu.why_not() {
            let lit = Self::Uncovered(why, integrator);
            let tracer = GpuTracer::new(on_gpu.into_world(), true, note);
            return Ok((tracer, lit, Shaded::OnCpu(why)));
        }
        if shaders.ready(gpu, on_gpu.shaders().as_ref())? {
            return Ok((GpuTracer::of_scene(on_gpu, true, note), Self::Unknown, Shaded::OnGpu));
        }
        let (world, light) = on_gpu.apart();
        let lit = light.map_or(Self::Unknown, Self::Now);
        Ok((GpuTracer::new(world, true, note), lit, Shaded::Meanwhile))
    }
}

/// The shaders of light that a GPU has compiled, or is about to have.
pub(super) struct Shaders {
    /// None has them compiled at once.
    wake: Option<Wake>,
    known: Vec<GpuShaders>,
    awaited: Vec<(GpuShaders, Receiver<Result<(), GpuError>>)>,
}

impl Shaders {
    pub fn new(wake: Option<Wake>) -> Self {
        Self { wake, known: Vec::new(), awaited: Vec::new() }
    }

    /// Knows none any more.
    pub fn forget(&mut self) {
        self.known.clear();
        self.awaited.clear();
    }

    /// Whether shaders are compiled; if not, they are now being.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    fn ready(&mut self, gpu: &Arc<Gpu>, shaders: Option<&GpuShaders>) -> Result<bool, GpuError> {
        let Some(shaders) = shaders else { return Ok(false) };
        for (which, receiver) in std::mem::take(&mut self.awaited) {
            match receiver.try_recv() {
                Ok(compiled) => {
                    compiled?;
                    self.known.push(which);
                }
                Err(TryRecvError::Empty) => self.awaited.push((which, receiver)),
                Err(TryRecvError::Disconnected) => {
                    let reason = "its shaders could not be compiled".to_owned();
                    return Err(GpuError::Lost { adapter: gpu.name().to_owned(), reason });
                }
            }
        }
        if self.known.contains(shaders) {
            return Ok(true);
        }
        if self.awaited.iter().any(|(which, _)| which == shaders) {
            return Ok(false);
        }
        let Some(wake) = self.wake.clone() else {
            gpu.compile(shaders)?;
            self.known.push(shaders.clone());
            return Ok(true);
        };
        let (sender, receiver) = channel();
        let (gpu, theirs) = (Arc::clone(gpu), shaders.clone());
        std::thread::spawn(move || {
            // Nobody waits any more if the device was given up.
            let _ = sender.send(gpu.compile(&theirs));
            wake();
        });
        self.awaited.push((shaders.clone(), receiver));
        Ok(false)
    }
}
