//! [`LevelOfDetail`]: coarser maps for what is seen from afar.
//!
//! **What is traced.** A chain of worlds: in the next one each relief lies under a map of half the samples a side
//! ([`rilievo::map::MipLevel`]: box averages of the full heights), with bounds of its own. Every ray meets one of these worlds
//! alone, by the exact kernels; so no level has cracks, and nothing is traced that is not a surface.
//!
//! **Which level.** A camera ray is traced in the full world first. Its footprint there, `lod` pixels wide, over the
//! width of a cell is a power of two, the level sought; its fraction is the probability of the level above. So the
//! radiance is on average the blend of both levels' radiance, without a surface in between that would need
//! bounds of its own.
//!
//! Then the ray is traced in the world of that level. What it meets there may lie much nearer: something near, that
//! the ray passes by, has grown. So a hit counts only if its own footprint asks for this level or the one
//! below; otherwise the next finer world is asked, and in the end the hit of the full one stands. A ray that misses
//! a level asks the next finer one too: outlines are those of the full surface.
//!
//! **One level a path.** Shadow rays and all bounces of a path stay in the world of its camera ray. They leave the very
//! surface that was hit, so nothing shadows itself for being another level. A mirror shows what is behind it in
//! the level of the mirror.
//!
//! **What is lost.** A level's cell knows the variance of slopes that it averages away
//! ([`rilievo::map::LostSlopes`]). It widens the lobes of the material there: `roughness`.

mod build;
mod roughness;

use std::sync::Arc;

use rilievo::map::LostSlopes;
use rilievo::relief::Displacement;
use rilievo::surface::World;
use rilievo::{Hit, Probe, Ray};

use crate::scene::Camera;

/// Coarser worlds of one scene.
#[derive(Debug)]
pub(crate) struct LevelOfDetail {
    /// Level 1 and on.
    levels: Vec<Level>,
    /// Width of the finest map's cells, in scene units.
    cell: f64,
}

/// One world, and what its reliefs lost.
#[derive(Debug)]
pub(crate) struct Level {
    pub world: World,
    /// For each surface, if it is coarser than the full one.
    lost: Vec<Option<Lost>>,
}

/// What a relief does not show of its full map.
#[derive(Clone, Debug)]
enum Lost {
    /// A face or a mesh.
    Map(Arc<LostSlopes>, Displacement),
    /// A sphere of so many cells a face, by its radius and its displacement of height 1.
    Cube { slopes: Arc<[LostSlopes; 6]>, cells: u32, radius: f64, scale: f64 },
}

/// How wide a camera ray is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    /// Scene units at the camera.
    width: f64,
    /// Scene units more per unit of distance.
    spread: f64,
}

impl Cone {
    /// Of rays so many pixels apart.
    pub fn of(camera: &Camera, pixels: f64) -> Self {
        let [width, spread] = camera.pixel_width();
        Self { width: pixels * width, spread: pixels * spread }
    }

    fn at(&self, ray: &Ray, t: f64) -> f64 {
        self.width + self.spread * t * ray.direction.length()
    }
}

/// The world that a path sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detail<'a> {
    /// The world.
    pub world: &'a World,
    level: Option<&'a Level>,
}

impl<'a> Detail<'a> {
    /// The full world.
    pub fn full(world: &'a World) -> Self {
        Self { world, level: None }
    }

    /// Variance of slopes, along all directions together, that the surface does not show at a hit.
    pub fn lost_slopes(&self, hit: &Hit) -> f64 {
        self.level.map_or(0.0, |level| level.lost_slopes(hit))
    }
}

impl LevelOfDetail {
    /// What a camera ray that meets `full` in the full world is taken to meet, and its level, 0 for the full one.
    /// `number` in `[0, 1)` decides between two levels.
    pub fn choose(
        &self,
        ray: &Ray,
        full: Hit,
        (cone, number): (&Cone, f64),
        probe: &mut impl Probe,
    ) -> (Hit, usize) {
        let sought = |t: f64| self.level_of(cone.at(ray, t), number);
        for level in (1..=sought(full.t)).rev() {
            if let Some(hit) = self.levels[level - 1].world.closest(ray, probe)
                && sought(hit.t) + 1 >= level
            {
                return (hit, level);
            }
        }
        (full, 0)
    }

    /// The level for a footprint of so many scene units.
    fn level_of(&self, width: f64, number: f64) -> usize {
        let level = (width / self.cell).log2() + number;
        // NaN, too, asks for no level.
        if level >= 1.0 { (level as usize).min(self.levels.len()) } else { 0 }
    }

    /// What a path sees of a scene at a level.
    pub fn detail<'a>(&'a self, full: &'a World, level: usize) -> Detail<'a> {
        match level.checked_sub(1) {
            None => Detail::full(full),
            Some(index) => {
                let level = &self.levels[index];
                Detail { world: &level.world, level: Some(level) }
            }
        }
    }

    /// The levels, from the first above the full world.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

impl Level {
    /// What is kept of lost slopes, with its place in memory.
    pub fn lost_bytes(&self) -> impl Iterator<Item = (*const (), u64)> {
        self.lost.iter().flatten().map(|lost| match lost {
            Lost::Map(slopes, _) => (Arc::as_ptr(slopes).cast(), slopes.bytes()),
            Lost::Cube { slopes, .. } => {
                (Arc::as_ptr(slopes).cast(), slopes.iter().map(LostSlopes::bytes).sum())
            }
        })
    }

    /// Bytes of the list of what is lost.
    pub fn list_bytes(&self) -> u64 {
        size_of_val(self.lost.as_slice()) as u64
    }
}
