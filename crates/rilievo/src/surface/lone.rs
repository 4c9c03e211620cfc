//! [`Lone`]: the only relief of a small world, and what stands beside it.
//!
//! One relief under a few lamps or between a few walls is what most scenes are. There a tree does
//! not pay: the relief clips rays to a closer box of its own, and each of its neighbours has one box.
//! So the relief goes first, and a neighbour is asked only by rays that enter its box before they
//! meet the relief.

use crate::accel::{Aabb, GROWTH, SlabRay};
use crate::hit::Hit;
use crate::mesh::departure::Departure;
use crate::probe::Probe;
use crate::ray::{Coherence, Ray};
use crate::relief::{BATCH, BatchOf, Crossing, ReliefFace};

use super::Surface;
use super::meeting::Meeting;
use super::world::{departure, seen_by};

/// Most surfaces of a world that goes without its tree.
const FEW: usize = 4;

/// What is known of such a world beside its surfaces.
#[derive(Clone, Debug)]
pub(super) struct Lone {
    /// Index of the relief.
    index: u32,
    /// Index and box of each other surface, in order.
    beside: Vec<(u32, Aabb)>,
}

impl Lone {
    /// Nothing if the surfaces are too many or hold no relief or several.
    pub(super) fn of(surfaces: &[Surface]) -> Option<Self> {
        let reliefs = (0u32..).zip(surfaces).filter(|(_, s)| matches!(s, Surface::Face(_)));
        let mut reliefs = reliefs.map(|(index, _)| index);
        let (index, second) = (reliefs.next()?, reliefs.next());
        if second.is_some() || surfaces.len() > FEW {
            return None;
        }
        let grown = |bounds: Aabb| bounds.grown(GROWTH * bounds.largest_coordinate());
        let beside = (0u32..).zip(surfaces).filter(|&(other, _)| other != index);
        let beside = beside.map(|(other, surface)| (other, grown(surface.bounds()))).collect();
        Some(Self { index, beside })
    }

    /// The relief.
    fn face<'a>(&self, surfaces: &'a [Surface]) -> Option<&'a ReliefFace> {
        match surfaces.get(self.index as usize) {
            Some(Surface::Face(face)) => Some(face),
            _ => None,
        }
    }

    /// [`super::World::closest`].
    #[inline]
    pub(super) fn closest<P: Probe>(
        &self,
        surfaces: &[Surface],
        ray: &Ray,
        probe: &mut P,
    ) -> Option<Hit> {
        let face = self.face(surfaces)?;
        let crossing = face.first_crossing(seen_by(self.index, ray, &mut None), probe);
        let mut hit = None;
        self.answer((surfaces, face), ray, crossing.as_ref(), (&mut hit, probe));
        hit
    }

    /// [`super::World::closest_each`].
    pub(super) fn closest_each<P: Probe>(
        &self,
        surfaces: &[Surface],
        (rays, coherence): (&[Ray], Coherence),
        hits: &mut [Option<Hit>],
        probe: &mut P,
    ) {
        let Some(face) = self.face(surfaces) else { return };
        for (rays, hits) in rays.chunks(BATCH).zip(hits.chunks_mut(BATCH)) {
            let mut crossings = [None; BATCH];
            let crossings = &mut crossings[..rays.len()];
            let of = BatchOf { rays, set: u16::MAX, surface: Some(self.index) };
            face.crossings((of, coherence), crossings, probe.counters());
            for ((ray, hit), crossing) in rays.iter().zip(hits).zip(crossings.iter()) {
                self.answer((surfaces, face), ray, crossing.as_ref(), (hit, probe));
            }
        }
    }

    /// Puts the hit that comes first into its place, where the ray crosses the relief at `crossing`.
    #[inline]
    fn answer<P: Probe>(
        &self,
        (surfaces, face): (&[Surface], &ReliefFace),
        ray: &Ray,
        crossing: Option<&Crossing>,
        (hit, probe): (&mut Option<Hit>, &mut P),
    ) {
        *hit = None;
        let ahead = self.beside.iter().any(|(_, bounds)| !bounds.is_behind(ray));
        if ahead
            && let Some((index, meeting)) = self.before(surfaces, ray, crossing.map(|c| c.t), probe)
        {
            hit.insert(meeting.complete(ray)).surface = index;
        } else if let Some(crossing) = crossing {
            hit.insert(face.complete(ray, crossing)).surface = self.index;
        }
    }

    /// What stands beside the relief and is met before `crossing`, the parameter at which that is.
    #[inline(never)]
    fn before<'a, P: Probe>(
        &self,
        surfaces: &'a [Surface],
        ray: &Ray,
        crossing: Option<f64>,
        probe: &mut P,
    ) -> Option<(u32, Meeting<'a>)> {
        let slab = SlabRay::new(ray);
        let mut best: Option<(u32, Meeting<'a>)> = None;
        let mut t_max = crossing.unwrap_or(ray.t_max);
        // At the same parameter the smaller index comes first.
        let mut holder = if crossing.is_some() { self.index } else { u32::MAX };
        for &(index, ref bounds) in &self.beside {
            if slab.entry(bounds, t_max).is_none() {
                continue;
            }
            let part = Ray { t_max, ..*seen_by(index, ray, &mut None) };
            let left = departure(surfaces, ray);
            let found = surfaces[index as usize].meet(&part, left.as_ref(), probe);
            if let Some(found) = found
                && (found.t() < t_max || index < holder)
            {
                (t_max, holder) = (found.t(), index);
                best = Some((index, found));
            }
        }
        best
    }

    /// [`super::World::occluded`] by any surface but `exempt`.
    #[inline]
    pub(super) fn occluded<P: Probe>(
        &self,
        surfaces: &[Surface],
        ray: &Ray,
        exempt: Option<u32>,
        probe: &mut P,
    ) -> bool {
        self.occluded_beside(surfaces, ray, exempt, probe)
            || exempt != Some(self.index)
                && self
                    .face(surfaces)
                    .is_some_and(|face| face.occludes(seen_by(self.index, ray, &mut None), probe))
    }

    /// [`super::World::occluded_each`].
    pub(super) fn occluded_each<P: Probe>(
        &self,
        surfaces: &[Surface],
        rays: &[Ray],
        exempt: &[Option<u32>],
        (occluded, probe): (&mut [bool], &mut P),
    ) {
        let Some(face) = self.face(surfaces) else { return };
        let chunks = rays.chunks(BATCH).zip(exempt.chunks(BATCH));
        for ((rays, exempt), occluded) in chunks.zip(occluded.chunks_mut(BATCH)) {
            let mut set = 0;
            for (k, (ray, exempt)) in rays.iter().zip(exempt).enumerate() {
                occluded[k] = self.occluded_beside(surfaces, ray, *exempt, probe);
                set |= u16::from(!occluded[k] && *exempt != Some(self.index)) << k;
            }
            let stopped = face.stopped(BatchOf { rays, set, surface: Some(self.index) }, probe);
            for (k, occluded) in occluded.iter_mut().enumerate() {
                *occluded |= stopped >> k & 1 == 1;
            }
        }
    }

    /// Whether a neighbour of the relief stops a ray.
    #[inline]
    fn occluded_beside<P: Probe>(
        &self,
        surfaces: &[Surface],
        ray: &Ray,
        exempt: Option<u32>,
        probe: &mut P,
    ) -> bool {
        let mut others = self.beside.iter().filter(|(index, _)| exempt != Some(*index)).peekable();
        if others.peek().is_none() {
            return false;
        }
        let slab = SlabRay::new(ray);
        others.any(|&(index, ref bounds)| {
            if slab.entry(bounds, ray.t_max).is_none() {
                return false;
            }
            let left: Option<Departure<'_>> = departure(surfaces, ray);
            let mut room = None;
            let part = seen_by(index, ray, &mut room);
            surfaces[index as usize].occludes_after(part, left.as_ref(), probe)
        })
    }
}
