//! Packets: up to sixteen rays that start close together and go about the same way, walked together.
//!
//! **Descent.** The rays are bounded by one *fat ray* (see `fat`): its node test has the children in
//! lanes, like that of one ray, and costs little more; the stack and the order are the single ray's
//! (see `walk`). A child that any of the rays would visit is visited.
//!
//! **Blocks.** Lanes are first the rays, against the box of the block: those that may meet it. Then
//! lanes are the cells, against the fat ray: those that any ray may cross. If they are few, each cell
//! is shown to all rays at once, lanes being the rays; else each ray is shown all cells at once, as
//! alone. The formulas of the leaf are the same either way (see `walk::gaps`).
//!
//! **One answer.** A ray gets the root of the first cell that has one, in the order of lanes, which
//! is the order along every ray. Cells that the ray alone would not have been shown have no root for
//! it (the proof of the cull in `leaf`), and cells that it would have been shown are shown. So the
//! crossing has the bits of the ray alone.
//!
//! **When it pays.** Rays of one pixel. Rays that fan out (shadows of an area light, bounces) make
//! the fat ray too fat: trace them alone.

mod block;
mod fat;

use crate::map::{HeightMap, Pyramid};
use crate::probe::Probe;
use crate::simd::Lanes;

use super::batch::{BATCH, Batch, BatchHits};
use super::leaf::Crossings;
use super::walk::{Stack, child};
use block::PacketBlocks;
use fat::FatRay;

/// Rays of a batch that run in the same mirrored directions. Lanes without such a ray repeat the first
/// one that is.
pub(crate) struct Packet<'a> {
    batch: &'a Batch<'a>,
    /// The first ray that is live.
    first: usize,
    /// Lanes that hold a ray of the packet.
    pub live: u16,
    /// Added to forward cells of the first ray's frame to give those of each ray's own; whole numbers.
    shift: [[f32; BATCH]; 2],
}

impl<'a> Packet<'a> {
    /// The rays that go with the first one that is worth walking. `walk` gets the others, before their
    /// lanes are lost.
    #[inline(always)]
    pub fn of(batch: &'a mut Batch<'_>, walk: impl FnOnce(&Batch<'_>, u16)) -> Self {
        let first = batch.worth.trailing_zeros() as usize % BATCH;
        let mut others = 0;
        for k in 0..BATCH {
            others |= u16::from(!batch.lanes.go_together(first, k)) << k;
        }
        let live = batch.worth & !others;
        if batch.worth & others != 0 {
            walk(batch, others);
        }
        batch.lanes.repeat(first, live);
        let mut shift = [[0.0; BATCH]; 2];
        for (shift, origin) in shift.iter_mut().zip(&batch.lanes.origin) {
            for k in 0..BATCH {
                shift[k] = origin[first].wrapping_sub(origin[k]) as f32;
            }
        }
        Self { batch, first, live, shift }
    }

    /// Mirrored cell of the first ray's forward cell 0: the packet counts cells from there.
    #[inline(always)]
    fn origin(&self) -> [i32; 2] {
        [self.batch.lanes.origin[0][self.first], self.batch.lanes.origin[1][self.first]]
    }

    /// What stored cells are combined with to give mirrored cells; see `TileFrame`.
    #[inline(always)]
    fn turn(&self) -> [i32; 2] {
        [self.batch.lanes.turn[0][self.first], self.batch.lanes.turn[1][self.first]]
    }

    /// Whether any ray may start below the surface.
    #[inline(always)]
    fn any_may_be_below(&self) -> bool {
        self.batch.lanes.below.iter().fold(0, |any, below| any | below) != 0
    }
}

/// The first admitted crossing of each ray, found through the pyramid.
#[inline(always)]
pub(crate) fn walk_packet<L: Lanes, P: Probe>(
    (map, pyramid): (&HeightMap, &Pyramid),
    rays: &Packet<'_>,
    (admit, hits): (Crossings, &mut BatchHits),
    probe: &mut P,
) {
    let fat = FatRay::new::<L>(rays, pyramid);
    let mut blocks = PacketBlocks::new((map, pyramid), rays, &fat, (admit, hits));
    let top = pyramid.levels() - 1;
    let mut at = rays.turn();
    let mut stack = Stack::default();
    probe.node();
    stack.push(top, fat.met::<L>(top, at));
    while let Some((level, lane)) = stack.pop() {
        at = child(at, level, lane);
        if level > 0 {
            probe.node();
            stack.push(level - 1, fat.met::<L>(level - 1, at));
        } else {
            probe.cell();
            blocks.visit::<L>(at);
            if blocks.live == 0 {
                break;
            }
        }
    }
}
