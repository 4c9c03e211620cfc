//! [`Resident`]: the surfaces of a scene on a GPU, kept from one picture to the next.

use std::ops::Range;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use glam::DVec3;
use rilievo::Ray;
use rilievo::surface::World;
use rilievo_gpu::{Gpu, GpuError, GpuKernels, GpuSurfaces, GpuWorld, MapEdit};
use rilievo_render::Scene;

use super::Wake;
use super::held::{HeldMap, maps_of};
use super::light::Lit;
use crate::studio::{Edit, Studio};

/// What a picture had to bring to the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Brought {
    /// Nothing: the surfaces were there.
    Nothing,
    /// Surfaces and trees, and of maps what was painted: so many rectangles.
    Numbers(usize),
    /// Maps too.
    Maps,
}

/// The surfaces of a scene, or of one before it.
pub(super) struct Resident {
    surfaces: Surfaces,
    lit: Lit,
    /// The maps, in the order of the surfaces, each once.
    maps: Vec<HeldMap>,
    /// What was painted since on maps, by their places among those.
    edits: Vec<(usize, [Range<u32>; 2])>,
    /// Whether the scene was loaded anew since.
    stale: bool,
}

/// What lies on a GPU, and whether its shaders are compiled.
enum Surfaces {
    /// Not seen by a shader yet.
    New(GpuSurfaces),
    /// Lent to the thread that compiles.
    Lent(Receiver<Result<GpuSurfaces, GpuError>>),
    Ready(GpuSurfaces),
}

impl Resident {
    /// Brings a scene over.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<(Self, Brought), GpuError> {
        let maps = maps_of(scene.world().surfaces());
        let surfaces = Surfaces::New(GpuWorld::new(gpu, scene.world())?.into_surfaces());
        let new = Self { surfaces, lit: Lit::Unknown, maps, edits: Vec::new(), stale: false };
        Ok((new, Brought::Maps))
    }

    /// Brings over what parts a scene from the one that is there. While a thread compiles, that has to wait; what it has
    /// compiled is added to `known`.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn follow(
        self,
        gpu: &Gpu,
        scene: &Scene,
        known: &mut Vec<GpuKernels>,
    ) -> Result<(Self, Brought), GpuError> {
        let Self { surfaces, lit, maps, edits, stale } = self;
        let surfaces = match surfaces {
            Surfaces::New(surfaces) | Surfaces::Ready(surfaces) => surfaces,
            Surfaces::Lent(receiver) => match receiver.try_recv() {
                Ok(surfaces) => {
                    let surfaces = surfaces?;
                    known.push(surfaces.kernels());
                    surfaces
                }
                Err(TryRecvError::Empty) => {
                    let surfaces = Surfaces::Lent(receiver);
                    return Ok((Self { surfaces, lit, maps, edits, stale }, Brought::Nothing));
                }
                Err(TryRecvError::Disconnected) => {
                    let reason = "its shaders could not be compiled".to_owned();
                    return Err(GpuError::Lost { adapter: gpu.name().to_owned(), reason });
                }
            },
        };
        if !stale && edits.is_empty() {
            let surfaces = Surfaces::New(surfaces);
            return Ok((Self { surfaces, lit, maps, edits, stale }, Brought::Nothing));
        }
        let world = scene.world();
        let now = maps_of(world.surfaces());
        if now.len() != maps.len() || !now.iter().zip(&maps).all(|(a, b)| a.is(b)) {
            // What lies there makes room first.
            drop(surfaces);
            let (new, brought) = Self::new(gpu, scene)?;
            return Ok((Self { lit: lit.older(), ..new }, brought));
        }
        let edit = |(place, samples): &(usize, [Range<u32>; 2])| match &now[*place] {
            HeldMap::Map(relief) => Some(MapEdit { relief, samples: samples.clone() }),
            HeldMap::Named(_) | HeldMap::Cube(_) => None,
        };
        let edits: Vec<_> = edits.iter().filter_map(edit).collect();
        let brought = Brought::Numbers(edits.len());
        let surfaces = GpuWorld::edited(gpu, world, surfaces.into_maps(), &edits)?.into_surfaces();
        let surfaces = Surfaces::New(surfaces);
        let lit = lit.older();
        Ok((Self { surfaces, lit, maps: now, edits: Vec::new(), stale: false }, brought))
    }

    /// Makes it ready to be traced: at once with shaders among `known`, and without `wake`, after they were compiled;
    /// otherwise a thread compiles them and calls `wake` when they are.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn compile(
        self,
        gpu: &Arc<Gpu>,
        wake: Option<&Wake>,
        known: &mut Vec<GpuKernels>,
    ) -> Result<Self, GpuError> {
        let surfaces = match (self.surfaces, wake) {
            (Surfaces::New(surfaces), _) if known.contains(&surfaces.kernels()) => {
                Surfaces::Ready(surfaces)
            }
            (Surfaces::New(surfaces), None) => {
                known.push(surfaces.kernels());
                Surfaces::Ready(seen(gpu, surfaces)?)
            }
            (Surfaces::New(surfaces), Some(wake)) => {
                let (gpu, wake) = (Arc::clone(gpu), Arc::clone(wake));
                let (sender, receiver) = channel();
                std::thread::spawn(move || {
                    // Nobody waits any more if the device was given up.
                    let _ = sender.send(seen(&gpu, surfaces));
                    wake();
                });
                Surfaces::Lent(receiver)
            }
            (other, _) => other,
        };
        Ok(Self { surfaces, ..self })
    }

    /// Whether it can be traced now.
    pub fn is_ready(&self) -> bool {
        matches!(self.surfaces, Surfaces::Ready(_))
    }

    /// The surfaces that can be traced now, what lights them, and their maps; none if it is not ready.
    pub fn into_ready(self) -> Option<(GpuSurfaces, Lit, Vec<HeldMap>)> {
        match self.surfaces {
            Surfaces::Ready(surfaces) => Some((surfaces, self.lit, self.maps)),
            Surfaces::New(_) | Surfaces::Lent(_) => None,
        }
    }

    /// What was traced, as it was.
    pub fn traced(surfaces: GpuSurfaces, lit: Lit, maps: Vec<HeldMap>) -> Self {
        Self { surfaces: Surfaces::Ready(surfaces), lit, maps, edits: Vec::new(), stale: false }
    }

    /// The scene was loaded anew.
    pub fn set_stale(&mut self) {
        self.stale = true;
    }

    /// Shares no map with `studio` any more.
    pub fn let_go(&mut self, studio: &Studio) {
        for map in &mut self.maps {
            if let HeldMap::Map(relief) = map
                && let Some(name) = studio.name_of(relief)
            {
                *map = HeldMap::Named(name);
            }
        }
    }

    /// Shares maps with `studio` again, after these edits.
    pub fn take_back(&mut self, studio: &Studio, edits: &[Edit]) {
        for (place, map) in self.maps.iter_mut().enumerate() {
            let HeldMap::Named(name) = map else { continue };
            let own = edits.iter().filter(|edit| edit.map == *name);
            self.edits.extend(own.map(|edit| (place, edit.samples.clone())));
            if let Some(relief) = studio.map_named(name) {
                *map = HeldMap::Map(relief);
            }
        }
    }
}

/// Has a shader look at surfaces once: only then do some drivers compile it.
fn seen(gpu: &Gpu, surfaces: GpuSurfaces) -> Result<GpuSurfaces, GpuError> {
    let nothing = World::new(Vec::new());
    let world = GpuWorld::again(gpu, &nothing, surfaces);
    world.closest(&[Ray::new(DVec3::ZERO, DVec3::Z)])?;
    Ok(world.into_surfaces())
}
