//! [`Renderer`]: what renders a pass: the CPU's threads, or a GPU that keeps what it was given.
//!
//! A GPU holds the surfaces of each side from one picture to the next. Another camera brings nothing over;
//! another depth, zero or tile of the same maps brings numbers ([`Brought::Numbers`]); a stroke of the brush the samples of its
//! rectangles, above which pyramids are made anew there; another material or light the words that differ. Maps are the same if they are the same in memory: the
//! renderer shares them with the scenes, but while they are painted, when it knows them by their names
//! ([`Renderer::let_go`], [`Renderer::take_back`]).
//!
//! To open a GPU and to compile its shaders takes from a part of a second to many: it is done in a thread of its own, and
//! the CPU renders meanwhile.
//!
//! A GPU that is lost or has no memory left is not asked again until another backend is chosen; a scene that it cannot
//! trace is the CPU's until it is loaded anew.

mod held;
mod light;
mod resident;

use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

use rilievo_gpu::{Backend, Gpu, GpuError, GpuKernels, GpuWorld};
use rilievo_render::{Film, RenderError, RenderOptions, Scene};

use crate::passes::Pass;
use crate::studio::{Edit, Studio};
use light::{Lit, Shaded, Shaders};
use resident::Resident;

pub use resident::Brought;

/// What the CPU is called.
const CPU: &str = "cpu";

/// Told, from another thread, that a GPU may be ready for what it was not before.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// What renders.
pub struct Renderer {
    threads: usize,
    /// None waits for the GPU.
    wake: Option<Wake>,
    backend: Backend,
    device: Device,
    /// What the device has compiled.
    kernels: Vec<GpuKernels>,
    shaders: Shaders,
    /// Where the last picture of each side was shaded.
    shaded: [Shaded; 2],
    sides: [OnDevice; 2],
    /// Why the CPU renders what a GPU was to, since it was last asked.
    why: Option<Why>,
    /// What was told last: of a scene that is loaded again and again it is told once.
    told: Option<Why>,
}

/// Why the CPU renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Why {
    /// What went wrong, in words.
    pub text: String,
    /// Whether one would want to know: not where `auto` finds no GPU.
    pub loud: bool,
}

enum Device {
    /// Not asked for yet.
    Unasked,
    /// On its way.
    Awaited(Receiver<Result<Option<Gpu>, GpuError>>),
    /// There is none, or it went away.
    Gone,
    Open(Arc<Gpu>),
}

/// A side of the picture on a GPU.
#[derive(Default)]
enum OnDevice {
    /// Nothing of it.
    #[default]
    Nothing,
    /// The GPU cannot trace it.
    Refused,
    /// The surfaces of the scene, or of one before it.
    Surfaces(Box<Resident>),
}

impl Renderer {
    /// With so many threads of the CPU; 0 takes one per processor. With `wake` the CPU renders until a GPU is ready; without
    /// it a GPU is waited for.
    pub fn new(threads: usize, wake: Option<Wake>) -> Self {
        Self {
            threads,
            shaders: Shaders::new(wake.clone()),
            shaded: Default::default(),
            wake,
            backend: Backend::Cpu,
            device: Device::Unasked,
            kernels: Vec::new(),
            sides: Default::default(),
            why: None,
            told: None,
        }
    }

    /// Takes another backend from now on.
    pub fn choose(&mut self, backend: Backend) {
        if self.backend != backend {
            self.backend = backend;
            (self.why, self.told) = (None, None);
            self.drop_device(Device::Unasked);
        }
    }

    /// What renders a side: the name of a GPU, or "cpu".
    pub fn name(&self, side: usize) -> &str {
        match (&self.device, &self.sides[side]) {
            (Device::Open(gpu), OnDevice::Surfaces(resident)) if resident.is_ready() => gpu.name(),
            _ => CPU,
        }
    }

    /// The same in words, with what shades the side.
    pub fn renders(&self, side: usize) -> String {
        let name = self.name(side);
        match self.shaded[side] {
            _ if name == CPU => CPU.to_owned(),
            Shaded::Nowhere => name.to_owned(),
            Shaded::OnGpu => format!("{name}, traced and shaded there"),
            Shaded::Meanwhile => format!("{name}, shaded by the CPU while shaders are compiled"),
            Shaded::OnCpu(why) => format!("{name}, shaded by the CPU: {why}"),
        }
    }

    /// Why the CPU renders, if that has changed since this was last asked.
    pub fn take_why(&mut self) -> Option<Why> {
        self.why.take()
    }

    /// The scene of a side was loaded anew.
    pub fn loaded(&mut self, side: usize) {
        match &mut self.sides[side] {
            OnDevice::Surfaces(resident) => resident.set_stale(),
            other => *other = OnDevice::Nothing,
        }
    }

    /// Nothing is shown on a side any more.
    pub fn forget(&mut self, side: usize) {
        self.sides[side] = OnDevice::Nothing;
    }

    /// Shares no map with `studio` any more, so that heights are painted in place.
    pub fn let_go(&mut self, studio: &Studio) {
        self.residents().for_each(|resident| resident.let_go(studio));
    }

    /// Shares maps with `studio` again after these edits.
    pub fn take_back(&mut self, studio: &Studio, edits: &[Edit]) {
        self.residents().for_each(|resident| resident.take_back(studio, edits));
    }

    fn residents(&mut self) -> impl Iterator<Item = &mut Resident> {
        self.sides.iter_mut().filter_map(|side| match side {
            OnDevice::Surfaces(resident) => Some(&mut **resident),
            OnDevice::Nothing | OnDevice::Refused => None,
        })
    }

    fn drop_device(&mut self, next: Device) {
        self.sides = Default::default();
        self.shaded = Default::default();
        self.kernels.clear();
        self.shaders.forget();
        self.device = next;
    }

    /// Renders a scene that has the camera and the settings of the pass; `watch` sees the film on its way,
    /// `cancel` stops it within a row of a tile, on a GPU with the dispatch on its way, some 25 ms of work, and where the CPU
    /// shades with a wave of 16384 camera rays. What had to be brought to a GPU for it, if one renders.
    ///
    /// # Errors
    /// As [`rilievo_render::render()`].
    pub fn render(
        &mut self,
        (side, scene): (usize, &Scene),
        pass: &Pass,
        watch: &(dyn Fn(&Film) + Sync),
        cancel: &AtomicBool,
    ) -> Result<(Film, Option<Brought>), RenderError> {
        let options = RenderOptions {
            threads: self.threads,
            pixel_centers: pass.centers,
            aovs: &pass.layers,
            watch,
            cancel,
            ..RenderOptions::default()
        };
        let on_cpu = || rilievo_render::render(scene, &options).map(|(film, _)| (film, None));
        let brought = self.prepare(side, scene);
        let (Some(brought), Device::Open(gpu)) = (brought, &self.device) else { return on_cpu() };
        let OnDevice::Surfaces(resident) = std::mem::take(&mut self.sides[side]) else {
            return on_cpu();
        };
        let Some((surfaces, lit, maps)) = resident.into_ready() else { return on_cpu() };
        let gpu = Arc::clone(gpu);
        let failed = Mutex::new(None);
        let note = |error: &GpuError| {
            *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error.clone());
        };
        let world = GpuWorld::again(&gpu, scene.world(), surfaces).stopped_by(cancel);
        let layers = !pass.layers.is_empty();
        let made = lit.tracer((&gpu, &mut self.shaders), (world, scene), (layers, note));
        let (tracer, lit, shaded) = match made {
            Ok(made) => made,
            Err(error) => {
                self.gave_up(side, &error);
                return on_cpu();
            }
        };
        self.shaded[side] = shaded;
        let traced = RenderOptions { tracer: Some(&tracer), ..options };
        let film = rilievo_render::render(scene, &traced).map(|(film, _)| film);
        let (surfaces, light) = tracer.into_parts();
        let lit = light.map_or(lit, Lit::Now);
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => self.gave_up(side, &error),
            None => {
                let resident = Resident::traced(surfaces, lit, maps);
                self.sides[side] = OnDevice::Surfaces(Box::new(resident));
            }
        }
        Ok((film?, Some(brought)))
    }

    /// Brings the scene of a side to the GPU before it is drawn again, and has shaders compiled for it.
    pub fn bring_ahead(&mut self, side: usize, scene: &Scene) {
        let brought = self.prepare(side, scene);
        let (Some(_), Device::Open(gpu)) = (brought, &self.device) else { return };
        let gpu = Arc::clone(gpu);
        let OnDevice::Surfaces(resident) = std::mem::take(&mut self.sides[side]) else { return };
        let Some((surfaces, lit, maps)) = resident.into_ready() else { return };
        let world = GpuWorld::again(&gpu, scene.world(), surfaces);
        let made =
            lit.tracer((&gpu, &mut self.shaders), (world, scene), (false, |_: &GpuError| {}));
        match made {
            Ok((tracer, lit, shaded)) => {
                self.shaded[side] = shaded;
                let (surfaces, light) = tracer.into_parts();
                let resident = Resident::traced(surfaces, light.map_or(lit, Lit::Now), maps);
                self.sides[side] = OnDevice::Surfaces(Box::new(resident));
            }
            Err(error) => self.gave_up(side, &error),
        }
    }

    /// Brings the scene of a side to the GPU, as far as it is not there; what had to be brought, if the GPU is ready to
    /// trace it then.
    pub fn prepare(&mut self, side: usize, scene: &Scene) -> Option<Brought> {
        self.open();
        let Device::Open(gpu) = &self.device else { return None };
        let gpu = Arc::clone(gpu);
        let known = &mut self.kernels;
        let there = match std::mem::take(&mut self.sides[side]) {
            OnDevice::Refused => {
                self.sides[side] = OnDevice::Refused;
                return None;
            }
            OnDevice::Nothing => {
                rilievo_gpu::check(scene).and_then(|()| Resident::new(&gpu, scene))
            }
            OnDevice::Surfaces(resident) => {
                rilievo_gpu::check(scene).and_then(|()| resident.follow(&gpu, scene, known))
            }
        };
        let ready = there.and_then(|(resident, brought)| {
            Ok((resident.compile(&gpu, self.wake.as_ref(), known)?, brought))
        });
        match ready {
            Ok((resident, brought)) => {
                let ready = resident.is_ready();
                self.sides[side] = OnDevice::Surfaces(Box::new(resident));
                ready.then_some(brought)
            }
            Err(error) => {
                self.gave_up(side, &error);
                None
            }
        }
    }

    /// Opens the GPU that is asked for, if that was not tried yet, or has it opened.
    fn open(&mut self) {
        let opened = match &self.device {
            Device::Unasked if self.backend == Backend::Cpu => return,
            Device::Unasked => match self.wake.clone() {
                None => self.backend.open(),
                Some(wake) => {
                    let backend = self.backend;
                    let (sender, receiver) = channel();
                    std::thread::spawn(move || {
                        // Nobody waits any more if another backend was chosen.
                        let _ = sender.send(backend.open());
                        wake();
                    });
                    self.device = Device::Awaited(receiver);
                    return;
                }
            },
            Device::Awaited(receiver) => match receiver.try_recv() {
                Ok(opened) => opened,
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => Ok(None),
            },
            Device::Gone | Device::Open(_) => return,
        };
        self.device = match opened {
            Ok(Some(gpu)) => Device::Open(Arc::new(gpu)),
            Ok(None) => Device::Gone,
            Err(error) => {
                let loud = self.backend == Backend::Gpu;
                self.tell(Why { text: error.to_string(), loud });
                Device::Gone
            }
        };
    }

    fn tell(&mut self, why: Why) {
        if self.told.as_ref() != Some(&why) {
            self.told = Some(why.clone());
            self.why = Some(why);
        }
    }

    /// The CPU renders a side from now on: for as long as this scene is shown, or for good.
    fn gave_up(&mut self, side: usize, error: &GpuError) {
        self.tell(Why { text: format!("{error}; the CPU takes over"), loud: true });
        match error {
            GpuError::Unsupported { .. } | GpuError::TooLarge { .. } => {
                self.sides[side] = OnDevice::Refused;
            }
            _ => self.drop_device(Device::Gone),
        }
    }
}

#[cfg(test)]
mod tests;
