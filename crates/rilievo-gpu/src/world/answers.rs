//! Rays asked and answered: hits are completed on the CPU, in `f64`.

use rayon::prelude::*;
use rilievo::surface::Surface;
use rilievo::{Hit, Ray};
use rilievo_render::{ShadowRay, Traced, Tracer};

use super::GpuWorld;
use super::tracing::{Answer, BATCH};
use crate::error::GpuError;
use crate::records::{self, HIT_WORDS, HitRecord};

impl GpuWorld<'_> {
    /// The nearest hit of every ray within `0 <= t <= ray.t_max`, in order. `ray.from`, if any, names a
    /// surface of this world.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            let write = |words: &mut _, ray: &_| records::write_ray(words, ray, self.anchor);
            let words = self.trace(rays, write, Answer::Nearest)?;
            let hits = words.par_chunks_exact(HIT_WORDS).map(HitRecord);
            let answer = |(ray, record)| self.answer(ray, &record);
            found.par_extend(rays.par_iter().zip(hits).map(answer));
        }
        Ok(found)
    }

    /// Whether each ray meets anything within `0 <= t <= ray.t_max`, in order. `ray.from` and the surface that does not
    /// count, if any, name surfaces of this world.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            let write = |words: &mut _, ray: &_| records::write_shadow_ray(words, ray, self.anchor);
            let words = self.trace(rays, write, Answer::Whether)?;
            found.extend(words.into_iter().map(|met| met != 0));
        }
        Ok(found)
    }

    /// Works a hit out in `f64`; where the CPU cannot find the surface that the GPU names, at a border that is a
    /// rounding away, its own answer counts.
    fn answer(&self, ray: &Ray, record: &HitRecord<'_>) -> Traced {
        let hit = record.surface().and_then(|index| {
            let surface = self.world.surfaces().get(index as usize)?;
            let from = ray.from.filter(|from| from.surface == index);
            match completed(surface, &Ray { from, ..*ray }, record.t(ray), record) {
                Some(hit) => Some(Hit { surface: index, time: ray.time, ..hit }),
                None => self.world.closest(ray, &mut ()),
            }
        });
        Traced { hit, work: u64::from(record.steps()) }
    }
}

/// For the integrators of `rilievo-render`, which shade what is traced here.
impl Tracer for GpuWorld<'_> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        GpuWorld::closest(self, rays).map_err(|error| error.to_string())
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        GpuWorld::occluded(self, rays).map_err(|error| error.to_string())
    }
}

/// The hit on the surface that a record names.
fn completed(surface: &Surface, ray: &Ray, t: f64, record: &HitRecord<'_>) -> Option<Hit> {
    match surface {
        Surface::Quad(quad) => quad.closest(ray),
        Surface::Sphere(sphere) => sphere.closest(ray),
        Surface::Mesh(mesh) => mesh.hit_on(record.triangle(), ray),
        Surface::Face(face) => Some(record.on_face(face, ray, t)),
        Surface::Instance(instance) => {
            let hit = completed(instance.prototype(), &instance.local_ray(ray), t, record)?;
            Some(instance.world_hit(hit))
        }
        Surface::ReliefSphere(sphere) => Some(record.on_relief_sphere(sphere, ray, t)),
        Surface::ReliefMesh(mesh) => Some(record.on_relief_mesh(mesh, ray, t)),
        Surface::Moving(moving) => {
            let hit = completed(moving.prototype(), &moving.local_ray(ray), t, record)?;
            Some(moving.world_hit(hit, ray.time))
        }
    }
}
