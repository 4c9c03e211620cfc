//! [`Tracer`]: what traces rays in place of threads of the CPU: a GPU, for instance.
//!
//! It is asked for many rays at once: first for the camera rays of many tiles, then, for as long as there are any,
//! for all shadow rays and all reflected rays of one bounce after the other. Where they go is up to the
//! integrators, whose code is the same for both ways of tracing; so two pictures differ only where hits do.
//!
//! A tracer may also say what camera rays see ([`Tracer::seen`]): then the integrators are its own, from the words
//! of [`crate::device`].

use rayon::prelude::*;
use rilievo::surface::World;
use rilievo::{Counters, Hit, Ray};

use crate::colour::Rgb;
use crate::integrator::RayCounts;
use crate::sampler::PathSampler;

/// Rays that are asked for at a time, unless a tile has more.
pub(crate) const RAYS: usize = 1 << 18;

/// Traces many rays at a time. Asked by one thread at a time.
pub trait Tracer: Sync {
    /// The nearest hits, one answer a ray, in order.
    ///
    /// # Errors
    /// Why there are none.
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String>;

    /// Whether anything is met, one answer a ray, in order.
    ///
    /// # Errors
    /// Why there are none.
    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String>;

    /// Radiance against camera rays of a scene whose pixels take `samples` in all, if the integrators run where the rays
    /// are traced; nothing, by default, where they are left to the CPU, in waves.
    ///
    /// # Errors
    /// Why there is none.
    fn seen(&self, _rays: &[CameraRay], _samples: u64) -> Result<Option<Seen>, String> {
        Ok(None)
    }

    /// Camera rays to be asked for at a time, if fewer than many: between two looks at whether to stop.
    fn at_once(&self) -> Option<usize> {
        None
    }
}

/// A camera ray that is traced elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray.
    pub ray: Ray,
    /// Column and row of its pixel.
    pub pixel: [u32; 2],
    /// Absolute index of its sample.
    pub index: u64,
    /// The numbers that are left for its path, if there are paths.
    pub numbers: Option<PathSampler>,
}

/// What camera rays see.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Radiance against each, in their order.
    pub radiance: Vec<Rgb>,
    /// Traced after the camera rays.
    pub rays: RayCounts,
}

/// The answer to one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traced {
    /// The nearest hit.
    pub hit: Option<Hit>,
    /// Nodes and blocks of cells looked at.
    pub work: u64,
}

/// A ray of which is asked only whether it meets anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowRay {
    /// The ray.
    pub ray: Ray,
    /// A surface that does not count: the light at the ray's end, which it is known to meet only there.
    pub exempt: Option<u32>,
}

impl ShadowRay {
    /// Whether it meets anything of a world.
    #[inline]
    pub fn is_occluded(&self, world: &World) -> bool {
        match self.exempt {
            Some(surface) => world.occluded_before(&self.ray, surface, &mut ()),
            None => world.occluded(&self.ray, &mut ()),
        }
    }
}

/// All threads of the CPU at once.
impl Tracer for World {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        let trace = |ray| {
            let mut counters = Counters::default();
            let hit = World::closest(self, ray, &mut counters);
            Traced { hit, work: counters.total() }
        };
        Ok(rays.par_iter().map(trace).collect())
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        Ok(rays.par_iter().map(|shadow| shadow.is_occluded(self)).collect())
    }
}
