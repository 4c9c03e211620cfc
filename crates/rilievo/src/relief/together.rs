//! A batch of rays against a face: made ready together, walked as a packet or one after the other, and
//! answered together. What cannot go so goes ray by ray: other methods than the pyramid, faces with
//! walls, windows of several tiles, rays that leave a wall.

use crate::probe::Probe;
use crate::ray::Coherence;
use crate::simd::Lanes;

use super::batch::{Batch, BatchHits, BatchOf, lanes_of};
use super::kernels::{FirstCrossing, IsCrossed};
use super::method::Method;
use super::packet::{Packet, walk_packet};
use super::trace::{Crossing, Met, Trace};
use super::walk::{Unfolding, walk_pyramid};

impl Trace<'_> {
    /// How the face shows its map, if its rays can be made ready together.
    fn batched(&self) -> Option<[Unfolding; 2]> {
        let pyramid = self.options.method == Method::Pyramid;
        self.placement.unfolding.filter(|_| pyramid && !self.options.closed)
    }

    /// The first crossing of each ray of a batch within its own end; others get none.
    #[inline(always)]
    pub fn first_crossings<L: Lanes, P: Probe>(
        &self,
        (of, coherence): (BatchOf<'_>, Coherence),
        found: &mut [Option<Crossing>],
        probe: &mut P,
    ) {
        found.fill(None);
        let Some(unfolding) = self.batched() else {
            return self.first_crossings_alone::<L, P>(of, u16::MAX, found, probe);
        };
        let mut batch = Batch::new(self.placement);
        batch.fill(unfolding, &of);
        self.first_crossings_alone::<L, P>(of, batch.from_walls, found, probe);
        if batch.worth == 0 {
            return;
        }
        let maps = (self.relief.heights(), self.relief.pyramid());
        let (admit, mut hits) = (self.admitted(), BatchHits::default());
        match coherence {
            Coherence::Incoherent => {
                batch.walk_each::<L, P>(maps, u16::MAX, (admit, &mut hits), probe);
            }
            Coherence::Coherent => {
                let others = |batch: &Batch<'_>, others| {
                    batch.walk_each::<L, P>(maps, others, (admit, &mut hits), probe);
                };
                let packet = Packet::of(&mut batch, others);
                walk_packet::<L, P>(maps, &packet, (admit, &mut hits), probe);
            }
        }
        let rising = self.options.displacement.scale > 0.0;
        batch.answer(&hits, (self.relief.heights(), rising), of.rays, found);
    }

    /// The first crossing of each ray of a batch that is in a set, one by one.
    #[inline(always)]
    fn first_crossings_alone<L: Lanes, P: Probe>(
        &self,
        of: BatchOf<'_>,
        set: u16,
        found: &mut [Option<Crossing>],
        probe: &mut P,
    ) {
        for (k, ray) in of.each(set) {
            found[k] = L::call(FirstCrossing { trace: *self, ray: &ray, probe: &mut *probe });
        }
    }

    /// [`Trace::is_crossed`] of each ray of a batch: one bit a ray.
    #[inline(always)]
    pub fn are_crossed<L: Lanes, P: Probe>(&self, of: BatchOf<'_>, probe: &mut P) -> u16 {
        let Some(unfolding) = self.batched() else {
            return self.are_crossed_alone::<L, P>(of, u16::MAX, probe);
        };
        let mut batch = Batch::new(self.placement);
        batch.fill(unfolding, &of);
        let maps = (self.relief.heights(), self.relief.pyramid());
        let mut crossed = self.are_crossed_alone::<L, P>(of, batch.from_walls, probe);
        for k in lanes_of(batch.worth) {
            let (ray, frame) = batch.ray(k);
            let met = walk_pyramid::<L, P>(maps, &ray, &frame, self.admitted(), probe);
            let met =
                met.is_some_and(|hit| self.ends_after(&ray, of.rays[k].t_max, Met::Surface(hit)));
            crossed |= u16::from(met) << k;
        }
        crossed
    }

    /// [`Trace::is_crossed`] of each ray of a batch that is in a set, one by one.
    #[inline(always)]
    fn are_crossed_alone<L: Lanes, P: Probe>(
        &self,
        of: BatchOf<'_>,
        set: u16,
        probe: &mut P,
    ) -> u16 {
        let mut crossed = 0;
        for (k, ray) in of.each(set) {
            let is_crossed = L::call(IsCrossed { trace: *self, ray: &ray, probe: &mut *probe });
            crossed |= u16::from(is_crossed) << k;
        }
        crossed
    }
}
