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
use crate::ray::Ray;
use crate::relief::{Crossing, ReliefFace};

use super::Surface;
use super::meeting::Meeting;
use super::world::{departure, seen_by};

/// Most surfaces of a world that goes without its tree.
const FEW: usize = 4;

/// Rays that a packet takes at once.
const PACKET: usize = 16;

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

    /// [`super::World::closest_packet`].
    pub(super) fn closest_packet<P: Probe>(
        &self,
        surfaces: &[Surface],
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        probe: &mut P,
    ) {
        let Some(face) = self.face(surfaces) else { return };
        for (rays, hits) in rays.chunks(PACKET).zip(hits.chunks_mut(PACKET)) {
            let mut crossings = [None; PACKET];
            let crossings = &mut crossings[..rays.len()];
            if rays.iter().all(|ray| ray.from.is_none()) {
                face.first_crossings(rays, crossings, probe);
            } else {
                for (ray, crossing) in rays.iter().zip(crossings.iter_mut()) {
                    *crossing = face.first_crossing(seen_by(self.index, ray, &mut None), probe);
                }
            }
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
        let mut others = self.beside.iter().filter(|(index, _)| exempt != Some(*index)).peekable();
        if others.peek().is_some() {
            let slab = SlabRay::new(ray);
            for &(index, ref bounds) in others {
                if slab.entry(bounds, ray.t_max).is_none() {
                    continue;
                }
                let left: Option<Departure<'_>> = departure(surfaces, ray);
                let mut room = None;
                let part = seen_by(index, ray, &mut room);
                if surfaces[index as usize].occludes_after(part, left.as_ref(), probe) {
                    return true;
                }
            }
        }
        exempt != Some(self.index)
            && self
                .face(surfaces)
                .is_some_and(|face| face.occludes(seen_by(self.index, ray, &mut None), probe))
    }
}
