//! [`World`]: surfaces under one tree.

use crate::accel::{Aabb, Bvh};
use crate::hit::Hit;
use crate::mesh::departure::Departure;
use crate::probe::Probe;
use crate::ray::{Coherence, Ray};

use super::Surface;
use super::lone::Lone;
use super::meeting::Meeting;
use super::search::WideWorld;

/// Surfaces by index, ready to trace.
#[derive(Clone, Debug)]
pub struct World {
    surfaces: Vec<Surface>,
    tree: Bvh,
    /// For rays that nobody counts.
    pub(super) wide: Option<WideWorld>,
    /// Where one relief stands among few: traced without the tree.
    lone: Option<Lone>,
    moves: bool,
}

impl World {
    /// Builds the tree over `surfaces`; hits name them by their place in the list.
    pub fn new(surfaces: Vec<Surface>) -> Self {
        let boxes: Vec<Aabb> = surfaces.iter().map(Surface::bounds).collect();
        let moves = surfaces.iter().any(|surface| matches!(surface, Surface::Moving(_)));
        let lone = Lone::of(&surfaces);
        let wide = if lone.is_some() { None } else { WideWorld::of(&surfaces, &boxes) };
        Self { tree: Bvh::build(&boxes, 1), wide, lone, moves, surfaces }
    }

    /// The surfaces, in order.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Whether anything moves: else the time of rays means nothing.
    pub fn moves(&self) -> bool {
        self.moves
    }

    /// A box around everything, at all times.
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// The nearest hit within `0 <= t <= t_max`; of several at the same `t`, that of the surface
    /// with the smallest index. `ray.from`, if any, names a surface of this world.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        if let Some(lone) = &self.lone {
            return lone.closest(&self.surfaces, ray, probe);
        }
        if let (Some(wide), None) = (&self.wide, probe.counters())
            && let Some(found) = wide.closest(&self.surfaces, ray)
        {
            let ((index, meeting), mut hit) = (found?, None);
            hit.insert(meeting.complete(ray)).surface = index;
            return hit;
        }
        let left = departure(&self.surfaces, ray);
        let mut best: Option<(u32, Meeting<'_>)> = None;
        self.tree.closest(ray, probe, |index, ray, probe| {
            let surface = &self.surfaces[index as usize];
            let found = surface.meet(seen_by(index, ray, &mut None), left.as_ref(), probe);
            let Some(found) = found else { return };
            let t = found.t();
            if best.as_ref().is_none_or(|(i, b)| t < b.t() || (t == b.t() && index < *i)) {
                ray.t_max = t;
                best = Some((index, found));
            }
        });
        let (index, meeting) = best?;
        Some(Hit { surface: index, ..meeting.complete(ray) })
    }

    /// [`World::closest`] of many rays; `hits` takes one answer a ray, the same as for the ray alone.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_each<P: Probe>(
        &self,
        (rays, coherence): (&[Ray], Coherence),
        hits: &mut [Option<Hit>],
        probe: &mut P,
    ) {
        assert_eq!(rays.len(), hits.len(), "one answer a ray");
        if let Some(lone) = &self.lone {
            return lone.closest_each(&self.surfaces, (rays, coherence), hits, probe);
        }
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.closest(ray, probe);
        }
    }

    /// Whether anything is met within `0 <= t <= t_max`; rays as for [`World::closest`].
    pub fn occluded<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.occluded_by_all_but(ray, None, probe)
    }

    /// [`World::occluded`] by any surface but `exempt`: the light at the ray's end, which it is known
    /// to meet only there.
    pub fn occluded_before<P: Probe>(&self, ray: &Ray, exempt: u32, probe: &mut P) -> bool {
        self.occluded_by_all_but(ray, Some(exempt), probe)
    }

    /// [`World::occluded`] of many rays, each by any surface but the one that stands in `exempt` for it;
    /// `occluded` takes one answer a ray, the same as for the ray alone.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_each<P: Probe>(
        &self,
        rays: &[Ray],
        exempt: &[Option<u32>],
        (occluded, probe): (&mut [bool], &mut P),
    ) {
        assert!(rays.len() == exempt.len() && rays.len() == occluded.len(), "one answer a ray");
        if let Some(lone) = &self.lone {
            return lone.occluded_each(&self.surfaces, rays, exempt, (occluded, probe));
        }
        for ((ray, exempt), occluded) in rays.iter().zip(exempt).zip(occluded) {
            *occluded = self.occluded_by_all_but(ray, *exempt, probe);
        }
    }

    #[inline]
    fn occluded_by_all_but<P: Probe>(&self, ray: &Ray, exempt: Option<u32>, probe: &mut P) -> bool {
        if let Some(lone) = &self.lone {
            return lone.occluded(&self.surfaces, ray, exempt, probe);
        }
        if let (Some(wide), None) = (&self.wide, probe.counters())
            && let Some(found) = wide.occluded(&self.surfaces, ray, exempt)
        {
            return found;
        }
        let left = departure(&self.surfaces, ray);
        self.tree.any(ray, probe, |index, ray, probe| {
            let surface = &self.surfaces[index as usize];
            let mut room = None;
            let ray = seen_by(index, ray, &mut room);
            exempt != Some(index) && surface.occludes_after(ray, left.as_ref(), probe)
        })
    }
}

/// What a ray leaves, as the others should know.
pub(super) fn departure<'a>(surfaces: &'a [Surface], ray: &Ray) -> Option<Departure<'a>> {
    let from = ray.from?;
    surfaces.get(from.surface as usize)?.departure(from, ray.time)
}

/// The ray as surface `index` sees it: with its origin only if that is on this surface. `room` is for
/// a copy where one is needed.
#[inline]
pub(super) fn seen_by<'a>(index: u32, ray: &'a Ray, room: &'a mut Option<Ray>) -> &'a Ray {
    match ray.from {
        Some(from) if from.surface != index => room.insert(Ray { from: None, ..*ray }),
        _ => ray,
    }
}

#[cfg(test)]
mod tests;
