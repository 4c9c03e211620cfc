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

mod answer;
mod block;
mod fat;
mod lanes;
mod rays;

use crate::map::{HeightMap, Pyramid};
use crate::probe::Probe;
use crate::simd::{Lanes, WIDTH};

use super::leaf::{Crossings, LeafHit};
use super::walk::{Stack, child};
use block::PacketBlocks;
use fat::FatRay;

pub(crate) use rays::PacketRays;

/// Most rays of a packet.
pub(crate) const PACKET: usize = WIDTH;

/// What the rays of a packet met: one element a ray.
#[derive(Default)]
pub(crate) struct PacketHits {
    s: [f32; PACKET],
    /// Forward cells, each in its own ray's frame.
    cell: [[i32; 2]; PACKET],
    /// Rays that met the surface, and those of them that came from above.
    any: u16,
    from_above: u16,
}

impl PacketHits {
    #[inline(always)]
    fn put(&mut self, lane: usize, hit: &LeafHit) {
        self.s[lane] = hit.s;
        self.cell[lane] = hit.cell;
        self.any |= 1 << lane;
        self.from_above |= u16::from(hit.from_above) << lane;
    }
}

/// The first admitted crossing of each ray, found through the pyramid.
#[inline(always)]
pub(crate) fn walk_packet<L: Lanes, P: Probe>(
    (map, pyramid): (&HeightMap, &Pyramid),
    rays: &PacketRays<'_>,
    admit: Crossings,
    probe: &mut P,
) -> PacketHits {
    let fat = FatRay::new::<L>(rays, pyramid);
    let mut blocks = PacketBlocks::new((map, pyramid), rays, &fat, admit);
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
    blocks.hits
}

/// The lanes whose bits are set, in order.
#[inline(always)]
fn lanes_of(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            lane % PACKET
        })
    })
}
