//! [`PacketBlocks`]: the rays of a packet against the cells of a block.

use crate::map::{HeightMap, Pyramid};
use crate::simd::{Lanes, WIDTH};

use super::super::leaf::{self, Crossings, LeafHit};
use super::super::walk::{Blocks, LaneRay, block_corners};
use super::PACKET;
use super::fat::FatRay;
use super::rays::{PacketRays, pair};

/// Cells a ray that are worth showing to all rays at once; measured flat between 8 and 12 of 16.
const FEW_CELLS: u32 = 12;

/// A packet on its way through blocks.
pub(super) struct PacketBlocks<'a> {
    map: &'a HeightMap,
    pyramid: &'a Pyramid,
    rays: &'a PacketRays,
    fat: &'a FatRay<'a>,
    admit: Crossings,
    /// Rays without a crossing yet.
    pub live: u16,
    pub found: [Option<LeafHit>; PACKET],
}

impl<'a> PacketBlocks<'a> {
    #[inline(always)]
    pub fn new(
        (map, pyramid): (&'a HeightMap, &'a Pyramid),
        rays: &'a PacketRays,
        fat: &'a FatRay<'a>,
        admit: Crossings,
    ) -> Self {
        Self { map, pyramid, rays, fat, admit, live: rays.live(), found: [None; PACKET] }
    }

    /// Shows the block with its corner at a mirrored cell to the live rays.
    #[inline(always)]
    pub fn visit<L: Lanes>(&mut self, corner: [i32; 2]) {
        let rays = self.live & self.rays_in::<L>(corner);
        if rays == 0 {
            return;
        }
        let cells = self.fat.cells::<L>(corner);
        if cells.count_ones() * WIDTH as u32 <= FEW_CELLS * rays.count_ones() {
            self.show_cells::<L>(corner, cells, rays);
        } else {
            self.show_rays::<L>(corner, rays);
        }
    }

    /// The rays that may meet the box of a block.
    #[inline(always)]
    fn rays_in<L: Lanes>(&self, corner: [i32; 2]) -> u16 {
        let lanes = &self.rays.lanes;
        let ray: LaneRay<L> = lanes.load();
        let [x, y] = self.forward(corner);
        let side = L::splat(4.0);
        let t = |axis: usize, line: L| line.minus(ray.o[axis]).times(ray.inv[axis]);
        let [enter, leave] = pair::<L>(&lanes.part);
        let near = t(0, x).larger(enter).larger(t(1, y));
        let far = t(0, x.plus(side)).smaller(leave).smaller(t(1, y.plus(side)));
        let frame = self.rays.frame();
        // Any cell of the block names it.
        let block =
            [(corner[0] ^ frame.turn[0]) as u32 / 4, (corner[1] ^ frame.turn[1]) as u32 / 4];
        let (_, max) = self.pyramid.bounds(0, block[0], block[1]);
        let slack = 2.0 * leaf::slack(self.rays.ray(0).0.size);
        let (za, zb) = (near.times(ray.dz).plus(ray.oz), far.times(ray.dz).plus(ray.oz));
        let lowest = za.smaller(zb).minus(L::splat(slack));
        L::bits(L::and(near.below(far), lowest.at_most(L::splat(max))))
    }

    /// A mirrored cell as each ray counts it forward.
    #[inline(always)]
    fn forward<L: Lanes>(&self, cell: [i32; 2]) -> [L; 2] {
        let frame = self.rays.frame();
        let shift = pair::<L>(&self.rays.lanes.shift);
        [
            L::splat((cell[0] - frame.origin[0]) as f32).plus(shift[0]),
            L::splat((cell[1] - frame.origin[1]) as f32).plus(shift[1]),
        ]
    }

    /// Cell after cell, all rays at once.
    #[inline(always)]
    fn show_cells<L: Lanes>(&mut self, corner: [i32; 2], mut cells: u16, mut rays: u16) {
        let corners: [L; 4] = block_corners(self.map, self.rays.frame(), corner);
        let [h00, h10, h01, h11] = corners;
        let (h00, h10, h01, h11) = (h00.store(), h10.store(), h01.store(), h11.store());
        let lanes: LaneRay<L> = self.rays.lanes.load();
        while cells != 0 && rays != 0 {
            let lane = cells.trailing_zeros() as usize % WIDTH;
            cells &= cells - 1;
            let cell = [corner[0] + (lane as i32 & 3), corner[1] + (lane as i32 >> 2)];
            let heights = [h00[lane], h10[lane], h01[lane], h11[lane]];
            let heights = [
                L::splat(heights[0]),
                L::splat(heights[1]),
                L::splat(heights[2]),
                L::splat(heights[3]),
            ];
            let gaps = lanes.gaps(self.forward(cell), heights);
            let mut candidates = gaps.candidates & rays;
            if candidates == 0 {
                continue;
            }
            let stored = gaps.store();
            while candidates != 0 {
                let lane = candidates.trailing_zeros() as usize % WIDTH;
                candidates &= candidates - 1;
                let (ray, frame) = self.rays.ray(lane);
                let forward = [cell[0] - frame.origin[0], cell[1] - frame.origin[1]];
                let hit = stored.hit(lane, (self.map, ray), forward, self.admit);
                if hit.is_some() {
                    self.found[lane] = hit;
                    rays &= !(1 << lane);
                    self.live &= !(1 << lane);
                }
            }
        }
    }

    /// Ray after ray, all cells at once.
    #[inline(always)]
    fn show_rays<L: Lanes>(&mut self, corner: [i32; 2], mut rays: u16) {
        while rays != 0 {
            let lane = rays.trailing_zeros() as usize % WIDTH;
            rays &= rays - 1;
            let (ray, frame) = self.rays.ray(lane);
            let hit = Blocks::new(self.map, ray, frame).first_hit::<L>(corner, self.admit);
            if hit.is_some() {
                self.found[lane] = hit;
                self.live &= !(1 << lane);
            }
        }
    }
}
