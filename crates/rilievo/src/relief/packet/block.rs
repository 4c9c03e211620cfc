//! [`PacketBlocks`]: the rays of a packet against the cells of a block.

use crate::map::{HeightMap, Pyramid};
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::batch::{BatchHits, lanes_of, pair};
use super::super::leaf::{self, Crossings, LeafHit};
use super::super::tile;
use super::super::walk::{Gaps, LaneRay, PLACES, StoredGaps, block_corners, cell_at, first_lane};
use super::Packet;
use super::fat::FatRay;

/// Cells a ray that are worth showing to all rays at once; measured flat between 8 and 12 of 16.
const FEW_CELLS: u32 = 12;

/// A packet on its way through blocks.
pub(super) struct PacketBlocks<'a> {
    map: &'a HeightMap,
    pyramid: &'a Pyramid,
    rays: &'a Packet<'a>,
    fat: &'a FatRay<'a>,
    admit: Crossings,
    /// Rays without a crossing yet.
    pub live: u16,
    hits: &'a mut BatchHits,
}

impl<'a> PacketBlocks<'a> {
    #[inline(always)]
    pub fn new(
        (map, pyramid): (&'a HeightMap, &'a Pyramid),
        rays: &'a Packet<'a>,
        fat: &'a FatRay<'a>,
        (admit, hits): (Crossings, &'a mut BatchHits),
    ) -> Self {
        Self { map, pyramid, rays, fat, admit, live: rays.live, hits }
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
        let lanes = &self.rays.batch.lanes;
        let ray: LaneRay<L> = lanes.load();
        let [x, y] = self.forward(corner);
        let side = L::splat(4.0);
        let t = |axis: usize, line: L| line.minus(ray.o[axis]).times(ray.inv[axis]);
        let [enter, leave] = pair::<L>(&lanes.part);
        let near = t(0, x).larger(enter).larger(t(1, y));
        let far = t(0, x.plus(side)).smaller(leave).smaller(t(1, y.plus(side)));
        let turn = self.rays.turn();
        // Any cell of the block names it.
        let block = [(corner[0] ^ turn[0]) as u32 / 4, (corner[1] ^ turn[1]) as u32 / 4];
        let (_, max) = self.pyramid.bounds(0, block[0], block[1]);
        let slack = 2.0 * leaf::slack(self.rays.batch.size());
        let (za, zb) = (near.times(ray.dz).plus(ray.oz), far.times(ray.dz).plus(ray.oz));
        let lowest = za.smaller(zb).minus(L::splat(slack));
        L::bits(L::and(near.below(far), lowest.at_most(L::splat(max))))
    }

    /// A mirrored cell as each ray counts it forward.
    #[inline(always)]
    fn forward<L: Lanes>(&self, cell: [i32; 2]) -> [L; 2] {
        let origin = self.rays.origin();
        let shift = pair::<L>(&self.rays.shift);
        [
            L::splat((cell[0] - origin[0]) as f32).plus(shift[0]),
            L::splat((cell[1] - origin[1]) as f32).plus(shift[1]),
        ]
    }

    /// Cell after cell, all rays at once.
    #[inline(always)]
    fn show_cells<L: Lanes>(&mut self, corner: [i32; 2], mut cells: u16, mut rays: u16) {
        let corners: [L; 4] = block_corners(self.map, Mirror::of(self.rays.turn()), corner);
        let [h00, h10, h01, h11] = corners;
        let (h00, h10, h01, h11) = (h00.store(), h10.store(), h01.store(), h11.store());
        let lanes: LaneRay<L> = self.rays.batch.lanes.load();
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
            let candidates = gaps.candidates & rays;
            if candidates != 0 {
                rays &= !self.take(&gaps, candidates, cell);
            }
        }
    }

    /// Rays, of those that are candidates, that cross a mirrored cell.
    #[inline(always)]
    fn take<L: Lanes>(&mut self, gaps: &Gaps<L>, candidates: u16, cell: [i32; 2]) -> u16 {
        let before = self.live;
        let origin = &self.rays.batch.lanes.origin;
        let forward = |ray: usize| [cell[0] - origin[0][ray], cell[1] - origin[1][ray]];
        let mut sure = 0;
        if self.admit == Crossings::Both {
            let roots = gaps.roots();
            let s = roots.s.store();
            sure = candidates & roots.sure;
            self.hits.from_above |= roots.from_above & sure;
            self.hits.any |= sure;
            self.live &= !sure;
            for ray in lanes_of(sure) {
                self.hits.s[ray] = s[ray];
                self.hits.cell[ray] = forward(ray);
            }
        }
        let doubtful = candidates & !sure;
        if doubtful != 0 {
            let stored = gaps.store();
            for ray in lanes_of(doubtful) {
                self.put_confirmed(&stored, ray, (ray, forward(ray)));
            }
        }
        before & !self.live
    }

    /// Whether a ray crosses a forward cell, whose gap stands in a lane, as the unrounded ray
    /// confirms; the hit is kept.
    #[inline(never)]
    fn put_confirmed(
        &mut self,
        gaps: &StoredGaps,
        lane: usize,
        (ray, cell): (usize, [i32; 2]),
    ) -> bool {
        let Some((t0, hit)) = gaps.hit(lane, cell, self.admit) else { return false };
        let confirmed =
            tile::confirms(self.map, &self.rays.batch.ray(ray).0, (t0, &hit), self.admit);
        if confirmed {
            self.hits.put(ray, &hit);
            self.live &= !(1 << ray);
        }
        confirmed
    }

    /// Ray after ray, all cells at once.
    #[inline(always)]
    fn show_rays<L: Lanes>(&mut self, corner: [i32; 2], rays: u16) {
        let corners: [L; 4] = block_corners(self.map, Mirror::of(self.rays.turn()), corner);
        let places = [L::load(&PLACES[0]), L::load(&PLACES[1])];
        for ray in lanes_of(rays) {
            let lanes = &self.rays.batch.lanes;
            let first = [corner[0] - lanes.origin[0][ray], corner[1] - lanes.origin[1][ray]];
            let cells = [
                L::splat(first[0] as f32).plus(places[0]),
                L::splat(first[1] as f32).plus(places[1]),
            ];
            let gaps = lanes.alone::<L>(ray).gaps(cells, corners);
            if gaps.candidates != 0 {
                self.take_first(&gaps, ray, first);
            }
        }
    }

    /// The first crossing of a ray among the candidates of a block at a forward cell.
    #[inline(always)]
    fn take_first<L: Lanes>(&mut self, gaps: &Gaps<L>, ray: usize, first: [i32; 2]) {
        if self.admit == Crossings::Both {
            let (roots, lane) = (gaps.roots(), first_lane(gaps.candidates));
            if roots.sure >> lane & 1 == 1 {
                let from_above = roots.from_above >> lane & 1 == 1;
                let (s, cell) = (roots.s.store()[lane], cell_at(first, lane));
                self.hits.put(ray, &LeafHit { s, cell, from_above });
                self.live &= !(1 << ray);
                return;
            }
        }
        let stored = gaps.store();
        for lane in lanes_of(gaps.candidates) {
            if self.put_confirmed(&stored, lane, (ray, cell_at(first, lane))) {
                return;
            }
        }
    }
}
